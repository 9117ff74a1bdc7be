// SPDX-License-Identifier: Apache-2.0
// Numbers on planes in a picture.
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "fransac/core/labels.hpp"
#include "fransac/io/overlay.hpp"

namespace fransac::io {
namespace {

constexpr int kGlyphWidth = 3;
constexpr int kGlyphHeight = 5;
/// Digits of 3 x 5 pixels, row by row from the top left in the highest of 15 bits.
constexpr std::array<unsigned, 10> kDigits = {
    0b111'101'101'101'111, 0b010'110'010'010'111, 0b111'001'111'100'111, 0b111'001'111'001'111, 0b101'101'111'001'001,
    0b111'100'111'001'111, 0b111'100'111'101'111, 0b111'001'001'001'001, 0b111'101'111'101'111, 0b111'101'111'001'111};

/// Where a label's pixel is farthest from pixels of others and from the border, in steps to neighbours: 0 where there is none.
struct Middle {
  int u = 0;
  int v = 0;
  int steps = 0;
};

/// By label; the distance transform of city blocks, Rosenfeld & Pfaltz, "Sequential operations in digital picture processing",
/// 1966.
std::array<Middle, 256> middles(std::span<const std::uint8_t> labels, int width) {
  const auto columns = static_cast<std::size_t>(width);
  std::vector<int> steps(labels.size());
  const auto from = [&](std::size_t i, bool inside, std::size_t neighbour) {
    return inside && labels[neighbour] == labels[i] ? steps[neighbour] : 0;
  };
  for (std::size_t i = 0; i < labels.size(); ++i) {
    steps[i] = 1 + std::min(from(i, i % columns > 0, i - 1), from(i, i >= columns, i - columns));
  }
  std::array<Middle, 256> found{};
  for (std::size_t i = labels.size(); i-- > 0;) {
    const int back = 1 + std::min(from(i, i % columns + 1 < columns, i + 1), from(i, i + columns < labels.size(), i + columns));
    steps[i] = std::min(steps[i], back);
    Middle& middle = found[labels[i]];
    if (steps[i] > middle.steps) middle = {static_cast<int>(i % columns), static_cast<int>(i / columns), steps[i]};
  }
  return found;
}

/// A grey square of `scale` pixels.
void fill(ColourImage& picture, int u, int v, int scale, std::uint8_t grey) {
  for (int y = v; y < v + scale; ++y) {
    const auto row = static_cast<std::size_t>(y) * static_cast<std::size_t>(picture.width);
    const auto begin = picture.pixels.begin() + static_cast<std::ptrdiff_t>(3 * (row + static_cast<std::size_t>(u)));
    std::fill(begin, begin + 3 * scale, grey);
  }
}

/// Black on white, with a border of one glyph's pixel, its top left corner at (u, v).
void draw_number(ColourImage& picture, const std::string& digits, int u, int v, int scale) {
  const int columns = static_cast<int>(digits.size()) * (kGlyphWidth + 1) + 1;
  for (int y = 0; y < kGlyphHeight + 2; ++y) {
    for (int x = 0; x < columns; ++x) {
      const int glyph_x = (x - 1) % (kGlyphWidth + 1);
      const bool inside = x > 0 && glyph_x < kGlyphWidth && y > 0 && y <= kGlyphHeight;
      const int bit = kGlyphWidth * kGlyphHeight - 1 - ((y - 1) * kGlyphWidth + glyph_x);
      const bool ink =
          inside &&
          (kDigits[static_cast<std::size_t>(digits[static_cast<std::size_t>((x - 1) / (kGlyphWidth + 1))] - '0')] >> bit & 1U) !=
              0;
      fill(picture, u + x * scale, v + y * scale, scale, ink ? 0 : 255);
    }
  }
}

}  // namespace

void number_planes(ColourImage& picture, std::span<const std::uint8_t> labels) {
  constexpr int kRowsPerScale = 240;
  if (picture.channels != 3 || labels.empty() || picture.pixels.size() != 3 * labels.size()) return;
  const int scale = std::max(1, picture.height / kRowsPerScale);
  const std::array<Middle, 256> places = middles(labels, picture.width);
  for (int label = kLabelFirst; label <= kMaxPlanes; ++label) {
    const Middle& middle = places[static_cast<std::size_t>(label)];
    const std::string digits = std::to_string(label);
    const int half_width = scale * (static_cast<int>(digits.size()) * (kGlyphWidth + 1) + 1) / 2 + 1;
    const int half_height = scale * (kGlyphHeight + 2) / 2 + 1;
    if (middle.steps < half_width + half_height) continue;  // its corners would leave the plane
    draw_number(picture, digits, middle.u - half_width + 1, middle.v - half_height + 1, scale);
  }
}

}  // namespace fransac::io
