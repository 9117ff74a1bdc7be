// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>

namespace fransac::kernels {

/// 0xFF in byte i where bit i is set.
inline constexpr std::array<std::uint64_t, 256> kBytesOfBits = [] {
  std::array<std::uint64_t, 256> table{};
  for (unsigned byte = 0; byte < 256; ++byte) {
    for (unsigned bit = 0; bit < 8; ++bit) {
      if ((byte >> bit & 1U) != 0) table[byte] |= std::uint64_t{0xFF} << (8 * bit);
    }
  }
  return table;
}();

}  // namespace fransac::kernels
