// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstddef>
#include <optional>
#include <span>
#include <string_view>
#include <system_error>

#include "fransac/core/result.hpp"

namespace fransac::io {

/// Bytes of a text file as characters.
inline std::string_view as_text(std::span<const std::byte> bytes) {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

/// What some editors and spreadsheets put before UTF-8 text.
inline constexpr std::string_view kByteOrderMark = "\xef\xbb\xbf";

/// Between words; the end of a line written on Windows counts as one.
inline constexpr std::string_view kBlanks = " \t\r";

/// A whole word as a number; `nan` and `inf` are numbers, and what is too large or too small for double is `nan`. Nothing when
/// the word is anything else.
inline std::optional<double> parse_real(std::string_view word) {
  if (word.starts_with('+') && !word.starts_with("+-")) word.remove_prefix(1);  // std::from_chars takes no plus sign.
  double value = 0.0;
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
  if (end != word.data() + word.size() || word.empty()) return std::nullopt;
  // Too large or too small for double: neither is a coordinate, and std::from_chars leaves `value` as it was.
  if (error != std::errc{}) return error == std::errc::result_out_of_range ? std::optional(std::nan("")) : std::nullopt;
  return value;
}

/// Calls `visit(line, number)` for the lines that hold something before a comment's '#', without the comment; `number` counts
/// from 1. Ends at the first Status that is an error and returns it.
template <class Visit>
Status for_each_line(std::string_view text, Visit&& visit) {
  if (text.starts_with(kByteOrderMark)) text.remove_prefix(kByteOrderMark.size());
  for (std::size_t number = 1; !text.empty(); ++number) {
    std::string_view line = text.substr(0, text.find('\n'));
    text.remove_prefix(std::min(line.size() + 1, text.size()));
    line = line.substr(0, line.find('#'));
    if (line.find_first_not_of(kBlanks) == std::string_view::npos) continue;
    if (Status status = visit(line, number); !status) return status;
  }
  return {};
}

}  // namespace fransac::io
