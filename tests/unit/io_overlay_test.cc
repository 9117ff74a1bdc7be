// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <span>
#include <string>
#include <vector>

#include "fransac/io/overlay.hpp"

namespace fransac::io {
namespace {

using Colour = std::array<std::uint8_t, 3>;

Colour pixel(const ColourImage& image, std::size_t i) {
  return {image.pixels[3 * i], image.pixels[3 * i + 1], image.pixels[3 * i + 2]};
}

/// Squared distance in red, green and blue.
int distance(const Colour& a, const Colour& b) {
  int sum = 0;
  for (std::size_t c = 0; c < 3; ++c) sum += (a[c] - b[c]) * (a[c] - b[c]);
  return sum;
}

TEST(LabelColour, AllLabelsDifferAndNoneIsTheGreyOfNoPlane) {
  std::set<Colour> colours;
  for (int label = 1; label <= 254; ++label) colours.insert(label_colour(static_cast<std::uint8_t>(label)));
  EXPECT_EQ(colours.size(), 254U);
  EXPECT_EQ(label_colour(0), label_colour(255));
  EXPECT_FALSE(colours.contains(label_colour(255)));
}

TEST(LabelColour, NeighboursInNumberAreFarApart) {
  for (int label = 1; label < 254; ++label) {
    EXPECT_GT(distance(label_colour(static_cast<std::uint8_t>(label)), label_colour(static_cast<std::uint8_t>(label + 1))),
              60 * 60)
        << label;
  }
  for (std::uint8_t a = 1; a <= 12; ++a) {
    for (std::uint8_t b = 1; b < a; ++b)
      EXPECT_GT(distance(label_colour(a), label_colour(b)), 30 * 30) << int{a} << " " << int{b};
  }
}

/// 5 x 3 pixels: plane 1 in the left three columns, plane 2 in the fourth; the last column has no plane, its last pixel no depth.
struct Scene {
  std::vector<std::uint16_t> raw{1000, 1000, 1000, 2000, 3000, 1000, 1000, 1000, 2000, 3000, 1000, 1000, 1000, 2000, 0};
  std::vector<std::uint8_t> labels{1, 1, 1, 2, 255, 1, 1, 1, 2, 255, 1, 1, 1, 2, 0};
  DepthView depth = DepthView::from_uint16(raw.data(), 5, 3, 1000.0);
};

TEST(Overlay, DrawsBordersFullAndBlendsTheInside) {
  const Scene scene;
  const ColourImage image = overlay(scene.depth, scene.labels, nullptr);
  ASSERT_EQ(image.width, 5);
  ASSERT_EQ(image.height, 3);
  ASSERT_EQ(image.pixels.size(), 45U);
  EXPECT_EQ(pixel(image, 2), label_colour(1));
  EXPECT_EQ(pixel(image, 3), label_colour(2));
  EXPECT_NE(pixel(image, 6), label_colour(1));
  EXPECT_LT(distance(pixel(image, 6), label_colour(1)), distance(pixel(image, 6), label_colour(2)));
}

TEST(Overlay, ShadesByDistanceAndDarkensWhereNothingWasMeasured) {
  const std::vector<std::uint16_t> raw{1000, 2000, 3000, 0};
  const std::vector<std::uint8_t> labels{255, 255, 255, 0};
  const ColourImage image = overlay(DepthView::from_uint16(raw.data(), 4, 1, 1000.0), labels, nullptr);
  EXPECT_GT(pixel(image, 0)[0], pixel(image, 1)[0]);
  EXPECT_GT(pixel(image, 1)[0], pixel(image, 2)[0]);
  EXPECT_GT(pixel(image, 2)[0], 2 * pixel(image, 3)[0]);
  EXPECT_EQ(pixel(image, 0)[0], pixel(image, 0)[1]);
}

TEST(Overlay, LiesOverThePictureOfTheSameSizeOnly) {
  const Scene scene;
  ColourImage picture{5, 3, 3, std::vector<std::uint8_t>(45, 0)};
  for (std::size_t i = 0; i < 45; i += 3) picture.pixels[i] = 250;
  const ColourImage over_depth = overlay(scene.depth, scene.labels, nullptr);
  const ColourImage over_picture = overlay(scene.depth, scene.labels, &picture);
  EXPECT_NE(over_picture.pixels, over_depth.pixels);
  EXPECT_GT(pixel(over_picture, 6)[0], pixel(over_depth, 6)[0] - 100);
  EXPECT_EQ(pixel(over_picture, 2), label_colour(1));
  EXPECT_LT(pixel(over_picture, 14)[0], pixel(over_picture, 4)[0]);  // no depth: darker
  const ColourImage other{3, 5, 3, std::vector<std::uint8_t>(45, 9)};
  EXPECT_EQ(overlay(scene.depth, scene.labels, &other).pixels, over_depth.pixels);
}

TEST(Overlay, HandlesFloatDepthOneDistanceAndNone) {
  const std::vector<float> metres{1.0F, 1.0F, std::nanf(""), -1.0F};
  const std::vector<std::uint8_t> labels{255, 1, 0, 0};
  const ColourImage image = overlay(DepthView::from_float(metres.data(), 2, 2), labels, nullptr);
  EXPECT_GT(pixel(image, 0)[0], 200);
  EXPECT_EQ(pixel(image, 2), pixel(image, 3));
  const std::vector<std::uint16_t> nothing(4);
  EXPECT_EQ(overlay(DepthView::from_uint16(nothing.data(), 2, 2, 1000.0), labels, nullptr).pixels.size(), 12U);
}

TEST(Overlay, NeedsOneLabelPerPixel) {
  const Scene scene;
  EXPECT_TRUE(overlay(scene.depth, std::span(scene.labels).first(14), nullptr).pixels.empty());
}

/// A picture of one grey, and its labels.
struct Numbered {
  int width;
  int height;
  std::vector<std::uint8_t> labels = std::vector<std::uint8_t>(static_cast<std::size_t>(width * height), 255);
  ColourImage picture{width, height, 3, std::vector<std::uint8_t>(static_cast<std::size_t>(3 * width * height), 100)};

  void plane(int u0, int v0, int u1, int v1, std::uint8_t label) {
    for (int v = v0; v < v1; ++v) std::fill_n(labels.begin() + v * width + u0, u1 - u0, label);
  }
  /// '#' black, '.' white, ' ' as it was.
  [[nodiscard]] std::vector<std::string> drawn(int u0, int v0, int u1, int v1) const {
    std::vector<std::string> rows;
    for (int v = v0; v < v1; ++v) {
      std::string& row = rows.emplace_back();
      for (int u = u0; u < u1; ++u) {
        const Colour colour = pixel(picture, static_cast<std::size_t>(v * width + u));
        row += colour == Colour{0, 0, 0} ? '#' : colour == Colour{255, 255, 255} ? '.' : ' ';
      }
    }
    return rows;
  }
};

TEST(NumberPlanes, WritesTheNumberWhereThePlaneIsWidest) {
  Numbered image{60, 40};
  image.plane(0, 0, 3, 40, 17);  // a strip, then
  image.plane(3, 0, 43, 40, 17);
  number_planes(image.picture, image.labels);
  const std::vector<std::string> number = {".........", "..#..###.", ".##....#.", "..#....#.",
                                           "..#....#.", ".###...#.", "........."};
  int found = 0;
  for (int v = 0; v + 7 <= 40; ++v) {
    for (int u = 0; u + 9 <= 43; ++u) found += image.drawn(u, v, u + 9, v + 7) == number ? 1 : 0;
  }
  EXPECT_EQ(found, 1);
  EXPECT_EQ(image.drawn(43, 0, 60, 40), std::vector<std::string>(40, std::string(17, ' ')));
  EXPECT_EQ(std::count(image.picture.pixels.begin(), image.picture.pixels.end(), 100), 3 * (60 * 40 - 63));
}

TEST(NumberPlanes, LeavesOutWhatDoesNotFit) {
  Numbered image{60, 40};
  image.plane(0, 0, 60, 6, 1);
  image.plane(0, 30, 5, 40, 2);
  const auto before = image.picture.pixels;
  number_planes(image.picture, image.labels);
  EXPECT_EQ(image.picture.pixels, before);
  image.plane(0, 0, 60, 40, 3);
  number_planes(image.picture, std::span(image.labels).first(60));  // not one for each pixel
  EXPECT_EQ(image.picture.pixels, before);
  number_planes(image.picture, image.labels);
  EXPECT_NE(image.picture.pixels, before);
}

TEST(NumberPlanes, GrowsWithThePicture) {
  Numbered image{640, 480};
  image.plane(100, 100, 300, 300, 8);
  number_planes(image.picture, image.labels);
  EXPECT_EQ(std::count(image.picture.pixels.begin(), image.picture.pixels.end(), 0), 3 * 4 * 13);  // 13 squares of 2 x 2
}

}  // namespace
}  // namespace fransac::io
