// SPDX-License-Identifier: Apache-2.0
#include "fransac/core/printable.hpp"

#include <algorithm>
#include <cstdint>

namespace fransac {
namespace {

constexpr std::size_t kQuotedBytes = 48;  // enough to find the word again

std::uint8_t byte_at(std::string_view text, std::size_t i) { return static_cast<std::uint8_t>(text[i]); }

/// Control characters (C0, DEL, C1), line and paragraph separators, and marks that change the direction of what follows.
bool is_control(char32_t c) {
  return c < 0x20 || (c >= 0x7f && c < 0xa0) || c == 0x61c || (c >= 0x200e && c <= 0x200f) || (c >= 0x2028 && c <= 0x202e) ||
         (c >= 0x2066 && c <= 0x2069);
}

/// Bytes of the printable character that `text` starts with (Unicode 15, table 3-7); 0: none.
std::size_t character_bytes(std::string_view text) {
  const std::uint8_t first = byte_at(text, 0);
  const std::size_t size = first < 0x80 ? 1 : first < 0xc2 ? 0 : first < 0xe0 ? 2 : first < 0xf0 ? 3 : first < 0xf5 ? 4 : 0;
  if (size == 0 || size > text.size()) return 0;
  char32_t c = size == 1 ? first : first & (0x7fU >> size);
  for (std::size_t i = 1; i < size; ++i) {
    if ((byte_at(text, i) & 0xc0U) != 0x80U) return 0;
    c = (c << 6U) | (byte_at(text, i) & 0x3fU);
  }
  const bool too_long = (size == 3 && c < 0x800) || (size == 4 && c < 0x10000);
  const bool no_character = (c >= 0xd800 && c < 0xe000) || c > 0x10ffff;
  return too_long || no_character || is_control(c) ? 0 : size;
}

void append_printable(std::string& result, std::string_view text) {
  constexpr std::string_view kDigits = "0123456789abcdef";
  while (!text.empty()) {
    const std::size_t size = character_bytes(text);
    if (size > 0) {
      result += text.substr(0, size);
    } else {
      result += "\\x";
      result += kDigits[byte_at(text, 0) >> 4U];
      result += kDigits[byte_at(text, 0) & 0xfU];
    }
    text.remove_prefix(std::max<std::size_t>(size, 1));
  }
}

bool is_inside_character(std::string_view text, std::size_t at) { return (byte_at(text, at) & 0xc0U) == 0x80U; }

}  // namespace

std::string printable(std::string_view text, std::size_t max_bytes) {
  std::string result;
  if (text.size() <= max_bytes) {
    append_printable(result, text);
    return result;
  }
  std::size_t head = max_bytes - max_bytes / 4;
  std::size_t tail = text.size() - max_bytes / 4;
  for (int i = 0; i < 3 && head > 0 && is_inside_character(text, head); ++i) --head;
  for (int i = 0; i < 3 && tail < text.size() && is_inside_character(text, tail); ++i) ++tail;
  append_printable(result, text.substr(0, head));
  result += "…";
  append_printable(result, text.substr(tail));
  return result;
}

std::string quoted_text(std::string_view text) { return "'" + printable(text, kQuotedBytes) + "'"; }

}  // namespace fransac
