// SPDX-License-Identifier: Apache-2.0
/// What targets demand of the code under test.
#pragma once

#include <cstdio>
#include <string_view>

#include "fransac/core/printable.hpp"
#include "fransac/core/result.hpp"

namespace fransac::fuzz {

/// Ends the target where something does not hold, which libFuzzer takes for a finding, and says where that is.
inline void require(bool holds, const char* file = __builtin_FILE(), int line = __builtin_LINE()) {
  if (holds) return;
  std::fprintf(stderr, "%s:%d: does not hold\n", file, line);
  __builtin_trap();
}

/// A message is one line of printable text, not long, that begins with the place of the error.
inline void require_message(const Error& error, std::string_view place = {}) {
  const std::string& text = error.message;
  require(!text.empty() && text.size() < 4096 && text.starts_with(place) && printable(text, text.size()) == text);
}

}  // namespace fransac::fuzz
