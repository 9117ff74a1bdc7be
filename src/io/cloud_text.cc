// SPDX-License-Identifier: Apache-2.0
#include "io/cloud_text.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <limits>

namespace fransac::io::cloud_formats {
namespace {

constexpr std::string_view kBlanks = " \t\r\n\v\f";

template <class Real>
void append_shortest(std::string& text, Real value) {
  if (std::isnan(value)) {
    text += "nan";
    return;
  }
  std::array<char, 32> buffer;  // The longest shortest double, -2.2250738585072014e-308, has 24 characters.
  const auto end = std::to_chars(buffer.data(), buffer.data() + buffer.size(), value).ptr;
  text.append(buffer.data(), end);
}

}  // namespace

std::optional<std::string_view> Lines::next() {
  if (position_ >= text_.size()) return std::nullopt;
  const std::size_t end = text_.find('\n', position_);
  std::string_view line = text_.substr(position_, end == std::string_view::npos ? end : end - position_);
  position_ = end == std::string_view::npos ? text_.size() : end + 1;
  ++number_;
  if (line.ends_with('\r')) line.remove_suffix(1);
  return line;
}

std::string_view take_word(std::string_view& text) {
  text.remove_prefix(std::min(text.find_first_not_of(kBlanks), text.size()));
  const std::string_view word = text.substr(0, text.find_first_of(kBlanks));
  text.remove_prefix(word.size());
  return word;
}

std::vector<std::string_view> words(std::string_view line) {
  std::vector<std::string_view> result;
  for (auto word = take_word(line); !word.empty(); word = take_word(line)) result.push_back(word);
  return result;
}

std::optional<std::uint64_t> parse_count(std::string_view word) {
  std::uint64_t value = 0;
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
  if (word.empty() || error != std::errc{} || end != word.data() + word.size()) return std::nullopt;
  if (value > static_cast<std::uint64_t>(std::numeric_limits<std::int32_t>::max())) return std::nullopt;
  return value;
}

void append_real(std::string& text, float value) { append_shortest(text, value); }
void append_real(std::string& text, double value) { append_shortest(text, value); }

Status check_points(std::uint64_t points, const ReadLimits& limits, const std::string& name) {
  if (points <= limits.max_size) return {};
  return format_error(
      name, std::to_string(points) + " points: more than the limit of " + std::to_string(limits.max_size) + " (--max-size)");
}

}  // namespace fransac::io::cloud_formats
