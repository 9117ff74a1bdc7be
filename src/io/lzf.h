// SPDX-License-Identifier: Apache-2.0
// LZF, Marc Lehmann's compression (libLZF), by its format: what PCD files of the encoding binary_compressed hold.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>

namespace fransac::io {

/// One byte stands for at most this many, in whole numbers: three bytes, a long reference, for 7 + 255 + 2.
inline constexpr std::uint64_t kLzfLargestExpansion = 264 / 3;

/// Fills `plain` with what `compressed` expands to. False where it is damaged: ends early, refers to before its beginning, or
/// expands to another size.
bool expand_lzf(std::span<const std::uint8_t> compressed, std::span<std::uint8_t> plain);

/// Compressed bytes, which may be more than the plain ones: by one for every 32 and one.
std::string compress_lzf(std::span<const std::uint8_t> plain);

}  // namespace fransac::io
