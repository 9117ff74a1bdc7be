// SPDX-License-Identifier: Apache-2.0
/// Numbers in messages.
#pragma once

#include <array>
#include <cstdio>
#include <string>

namespace fransac {

/// In at most six significant digits.
inline std::string number_text(double value) {
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), "%g", value);
  return text.data();
}

}  // namespace fransac
