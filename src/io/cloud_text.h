// SPDX-License-Identifier: Apache-2.0
// Words and numbers of the formats' text parts.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "fransac/core/printable.hpp"
#include "fransac/core/result.hpp"
#include "fransac/io/limits.hpp"
#include "io/guard.h"
#include "io/text.h"

namespace fransac::io::cloud_formats {

/// A text line by line.
class Lines {
 public:
  explicit Lines(std::string_view text, int lines_before = 0) : text_(text), number_(lines_before) {}
  /// The next line without its end (LF or CR LF); nothing after the last.
  std::optional<std::string_view> next();
  /// Number of the last line, from 1.
  [[nodiscard]] int number() const { return number_; }
  /// What follows the last line.
  [[nodiscard]] std::string_view rest() const { return text_.substr(position_); }

 private:
  std::string_view text_;
  std::size_t position_ = 0;
  int number_ = 0;
};

/// Takes the next word, between blanks and line ends, off the front of `text`; empty when there is none.
std::string_view take_word(std::string_view& text);
std::vector<std::string_view> words(std::string_view line);

/// Decimal digits only. Nothing above 2^31 - 1, what the formats' readers hold counts in.
std::optional<std::uint64_t> parse_count(std::string_view word);

/// Appends the shortest text that reads back as the same number; "nan" for every kind of it.
void append_real(std::string& text, float value);
void append_real(std::string& text, double value);

/// A format error when a header promises more points than are read.
Status check_points(std::uint64_t points, const ReadLimits& limits, const std::string& name);

}  // namespace fransac::io::cloud_formats
