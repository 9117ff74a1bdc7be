// SPDX-License-Identifier: Apache-2.0
#include "fransac/io/overlay.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <vector>

#include "fransac/core/labels.hpp"

namespace fransac::io {
namespace {

using Colour = std::array<std::uint8_t, 3>;

constexpr Colour kNoPlaneColour{128, 128, 128};

// Okabe and Ito, "Color Universal Design" (2008): told apart by people with every kind of colour vision.
constexpr std::array<Colour, 7> kFirstColours{
    {{0, 114, 178}, {230, 159, 0}, {0, 158, 115}, {204, 121, 167}, {240, 228, 66}, {86, 180, 233}, {213, 94, 0}}};

// Further colours turn the hue by the golden angle, so that any run of labels spreads evenly over the circle, step through
// lightnesses, which every eye sees, and become paler in the second half, where the hues come close to earlier ones.
constexpr double kGoldenAngle = std::numbers::pi * (3.0 - 2.2360679774997896964);  // sqrt(5)
constexpr double kHueShift =
    25.0 * std::numbers::pi / 180.0;  // of whole 5 degrees the one with the first 20 colours furthest apart
constexpr std::array<double, 6> kLightness{0.80, 0.50, 0.90, 0.40, 0.70, 0.60};
constexpr std::array<double, 2> kChroma{0.14, 0.07};  // the first is about the largest that sRGB has at all hues

std::uint8_t to_byte(double value) { return static_cast<std::uint8_t>(std::lround(std::clamp(value, 0.0, 255.0))); }

/// Oklab (Ottosson, "A perceptual color space for image processing", 2020) in polar form to sRGB (IEC 61966-2-1).
Colour from_oklch(double lightness, double chroma, double hue) {
  const double a = chroma * std::cos(hue);
  const double b = chroma * std::sin(hue);
  const double l = std::pow(lightness + 0.3963377774 * a + 0.2158037573 * b, 3);
  const double m = std::pow(lightness - 0.1055613458 * a - 0.0638541728 * b, 3);
  const double s = std::pow(lightness - 0.0894841775 * a - 1.2914855480 * b, 3);
  const auto gamma = [](double linear) {
    return to_byte(255.0 * (linear <= 0.0031308 ? 12.92 * linear : 1.055 * std::pow(linear, 1.0 / 2.4) - 0.055));
  };
  return {gamma(4.0767416621 * l - 3.3077115913 * m + 0.2309699292 * s),
          gamma(-1.2684380046 * l + 2.6097574011 * m - 0.3413193965 * s),
          gamma(-0.0041960863 * l - 0.7034186147 * m + 1.7076147010 * s)};
}

std::array<Colour, 256> make_colours() {
  std::array<Colour, 256> colours{};
  colours.fill(kNoPlaneColour);
  std::copy(kFirstColours.begin(), kFirstColours.end(), colours.begin() + kLabelFirst);
  for (std::size_t i = kFirstColours.size(); i < kMaxPlanes; ++i) {
    colours[i + kLabelFirst] =
        from_oklch(kLightness[i % kLightness.size()], kChroma[i / 128], kHueShift + kGoldenAngle * static_cast<double>(i));
  }
  return colours;
}

/// z of every pixel, row by row.
std::vector<float> metres_of(const DepthView& depth) {
  std::vector<float> depth_m;
  depth_m.reserve(depth.size());
  for (int v = 0; v < depth.height(); ++v) {
    for (int u = 0; u < depth.width(); ++u) depth_m.push_back(depth.metres(u, v));
  }
  return depth_m;
}

DepthRange range_of(const std::vector<float>& depth_m) {
  std::vector<float> measured;
  std::copy_if(depth_m.begin(), depth_m.end(), std::back_inserter(measured), [](float z) { return z > 0.0F; });
  if (measured.empty()) return {};
  const auto at = [&](double fraction) {
    const auto rank = static_cast<std::ptrdiff_t>(std::lround(fraction * static_cast<double>(measured.size() - 1)));
    std::nth_element(measured.begin(), measured.begin() + rank, measured.end());
    return measured[static_cast<std::size_t>(rank)];
  };
  return {at(0.01), at(0.99)};
}

/// Light when near, darker with distance, by inverse depth: that keeps contrast where things are.
Colour shade(float z_m, const DepthRange& range) {
  constexpr double kNear = 235.0;
  constexpr double kFar = 70.0;
  const auto z = static_cast<double>(std::clamp(z_m, range.nearest_m, range.farthest_m));
  const double span = 1.0 / static_cast<double>(range.nearest_m) - 1.0 / static_cast<double>(range.farthest_m);
  const double nearness = span > 0.0 ? (1.0 / z - 1.0 / static_cast<double>(range.farthest_m)) / span : 1.0;
  const std::uint8_t grey = to_byte(kFar + (kNear - kFar) * nearness);
  return {grey, grey, grey};
}

Colour mix(const Colour& from, const Colour& to, double share) {
  Colour mixed{};
  for (std::size_t c = 0; c < mixed.size(); ++c) mixed[c] = to_byte(from[c] + share * (to[c] - from[c]));
  return mixed;
}

/// Rec. 709 luma as a grey.
Colour grey_of(const Colour& colour) {
  const std::uint8_t luma = to_byte(0.2126 * colour[0] + 0.7152 * colour[1] + 0.0722 * colour[2]);
  return {luma, luma, luma};
}

bool is_plane(std::uint8_t label) { return label != kLabelNoDepth && label != kLabelNoPlane; }

/// Whether a plane's pixel has a pixel of something else beside, above or below it.
bool on_border(std::span<const std::uint8_t> labels, int width, int height, int u, int v) {
  const auto at = [&](int x, int y) {
    return labels[static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x)];
  };
  const std::uint8_t own = at(u, v);
  return (u > 0 && at(u - 1, v) != own) || (u + 1 < width && at(u + 1, v) != own) || (v > 0 && at(u, v - 1) != own) ||
         (v + 1 < height && at(u, v + 1) != own);
}

}  // namespace

std::array<std::uint8_t, 3> label_colour(std::uint8_t label) {
  static const std::array<Colour, 256> colours = make_colours();
  return colours[label];
}

DepthRange depth_range(const DepthView& depth) { return range_of(metres_of(depth)); }

ColourImage overlay(const DepthView& depth, std::span<const std::uint8_t> labels, const ColourImage* background) {
  constexpr double kPlaneShare = 0.55;  // how much of a plane's colour covers the background
  constexpr double kGreyShare = 0.7;    // how much of its own colour the rest of a picture loses
  constexpr double kDarkShare = 0.75;   // how dark a picture becomes where nothing was measured
  constexpr Colour kDark{16, 16, 20};
  if (labels.size() != depth.size()) return {};
  const int width = depth.width();
  const int height = depth.height();
  const std::vector<float> depth_m = metres_of(depth);
  const DepthRange range = range_of(depth_m);
  const bool over_picture = background != nullptr && background->width == width && background->height == height &&
                            background->channels == 3 && background->pixels.size() == 3 * depth.size();
  ColourImage image{width, height, 3, std::vector<std::uint8_t>(3 * depth.size())};
  for (std::size_t i = 0; i < depth.size(); ++i) {
    const std::uint8_t label = labels[i];
    Colour colour = kDark;
    if (over_picture) {
      const std::uint8_t* const pixel = &background->pixels[3 * i];
      colour = {pixel[0], pixel[1], pixel[2]};
      if (!is_plane(label)) colour = mix(colour, grey_of(colour), kGreyShare);
      if (depth_m[i] == 0.0F) colour = mix(colour, kDark, kDarkShare);
    } else if (depth_m[i] > 0.0F) {
      colour = shade(depth_m[i], range);
    }
    if (is_plane(label)) {
      const bool border = on_border(labels, width, height, static_cast<int>(i) % width, static_cast<int>(i) / width);
      colour = mix(colour, label_colour(label), border ? 1.0 : kPlaneShare);
    }
    std::copy(colour.begin(), colour.end(), image.pixels.begin() + static_cast<std::ptrdiff_t>(3 * i));
  }
  return image;
}

}  // namespace fransac::io
