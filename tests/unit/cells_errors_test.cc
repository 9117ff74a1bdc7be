// SPDX-License-Identifier: Apache-2.0
// What `cells` takes a frame's errors for, what it takes for no measurement, and how certain it is of planes.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numeric>
#include <vector>

#include "cells.hpp"
#include "fransac/planes/segment.hpp"
#include "support.hpp"

namespace fransac {
namespace {

using testing::cells;
using testing::cells_options;
using testing::expect_sane;
using testing::FloatImage;
using testing::kinect;

/// A floor 1.2 m below a camera that looks down by 30 degrees, and a wall 4 m away.
FloatImage room(const Camera& camera) {
  const double pitch = 0.5236;
  FloatImage image(camera);
  image.draw(*make_plane({0.0, -std::cos(pitch), -std::sin(pitch)}, 1.2));
  const Plane wall = *make_plane({0.0, std::sin(pitch), -std::cos(pitch)}, 4.0);
  for (int v = 0; v < camera.height; ++v) {
    for (int u = 0; u < camera.width; ++u) {
      const auto z = static_cast<float>(testing::depth_on(wall, camera, u, v));
      if (z > 0.0F && (image.at(u, v) <= 0.0F || z < image.at(u, v))) image.at(u, v) = z;
    }
  }
  return image;
}

void add_noise(const DepthNoise& noise, RandomStream& random, FloatImage& image) {
  for (float& z : image.metres) {
    if (z > 0.0F) z += static_cast<float>(noise.sigma_m(static_cast<double>(z)) * random.normal());
  }
}

std::vector<std::uint16_t> in_units(const FloatImage& image, double scale) {
  std::vector<std::uint16_t> raw(image.metres.size());
  std::transform(image.metres.begin(), image.metres.end(), raw.begin(),
                 [&](float z) { return static_cast<std::uint16_t>(std::lround(static_cast<double>(z) * scale)); });
  return raw;
}

TEST(CellsErrors, PixelNoiseByDepth) {
  for (const DepthNoise& noise : {DepthNoise{.quadratic_per_m = 1.425e-3}, DepthNoise{.constant_m = 0.004},
                                  DepthNoise{.constant_m = 0.002, .quadratic_per_m = 1e-3}}) {
    RandomStream random = testing::test_random();
    FloatImage image = room(kinect());
    add_noise(noise, random, image);
    const Segmentation s = cells(image.view(), image.camera);
    EXPECT_EQ(s.planes.size(), 2U);
    for (const double z : {1.5, 2.5, 3.5}) {
      EXPECT_NEAR(s.noise.sigma_m(z) / noise.sigma_m(z), 1.0, 0.25) << "at " << z << " m of " << noise.constant_m;
    }
  }
}

TEST(CellsErrors, RoundingIsNoise) {
  FloatImage image(kinect());
  image.draw(*make_plane({0.0, 0.0, -1.0}, 1.0));  // every pixel rounds to the same value
  const std::vector<std::uint16_t> raw = in_units(image, 1000.0);
  const Segmentation s = cells(DepthView::from_uint16(raw.data(), 640, 480, 1000.0), image.camera);
  ASSERT_EQ(s.planes.size(), 1U);
  EXPECT_GE(s.noise.sigma_m(1.0), 1e-3 / std::sqrt(12.0) * 0.999);
}

TEST(CellsErrors, BiasIsOfSensorsAndNotOfRenderedDepth) {
  FloatImage image = room(kinect());
  EXPECT_LT(cells(image.view(), image.camera).bias_m, 1e-3);
  RandomStream random = testing::test_random();
  add_noise({.quadratic_per_m = 1.425e-3}, random, image);
  EXPECT_NEAR(cells(image.view(), image.camera).bias_m, 0.01, 1e-9);
  SegmentOptions options = cells_options();
  options.sensor.bias_m = 0.03;
  EXPECT_EQ(cells(image.view(), image.camera, options).bias_m, 0.03);
}

TEST(CellsErrors, SlowNoiseIsTheFramesOrWhatIsGiven) {
  RandomStream random = testing::test_random();
  FloatImage image = room(kinect());
  add_noise({.quadratic_per_m = 1.425e-3}, random, image);
  const Segmentation s = cells(image.view(), image.camera);
  EXPECT_GT(s.slow_noise.quadratic_per_m, 0.1 * s.noise.quadratic_per_m);
  SegmentOptions options = cells_options();
  options.sensor.slow = 0.25;
  const Segmentation given = cells(image.view(), image.camera, options);
  EXPECT_NEAR(given.slow_noise.quadratic_per_m, 0.25 * given.noise.quadratic_per_m, 1e-12);
}

/// Of the pixels that two answers have on planes, those whose planes are the same: at most so far apart.
double share_on_same_planes(const Segmentation& a, const Segmentation& b, const std::vector<std::uint8_t>& asked) {
  std::size_t same = 0;
  std::size_t all = 0;
  for (std::size_t i = 0; i < asked.size(); ++i) {
    if (asked[i] == 0 || a.labels[i] == kLabelNoPlane || a.labels[i] == kLabelNoDepth) continue;
    ++all;
    if (b.labels[i] == kLabelNoPlane || b.labels[i] == kLabelNoDepth) continue;
    const Plane& p = a.planes[a.labels[i] - 1U].plane;
    const Plane& q = b.planes[b.labels[i] - 1U].plane;
    same += static_cast<std::size_t>(angle_between(p, q) < 0.02 && std::abs(p.d - q.d) < 0.02);
  }
  return static_cast<double>(same) / static_cast<double>(std::max<std::size_t>(all, 1));
}

/// A constant says nothing of noise, and 65535 is no measurement, wherever they are.
TEST(CellsErrors, RegionsOfOneValueDoNoHarm) {
  RandomStream random = testing::test_random();
  FloatImage image = room(kinect());
  add_noise({.quadratic_per_m = 1.425e-3}, random, image);
  const std::vector<std::uint16_t> raw = in_units(image, 5000.0);
  const DepthView depth = DepthView::from_uint16(raw.data(), 640, 480, 5000.0);
  const Segmentation before = cells(depth, image.camera);
  ASSERT_EQ(before.planes.size(), 2U);
  for (const std::uint16_t value : {std::uint16_t{65535}, std::uint16_t{8000}, std::uint16_t{40000}}) {
    for (const double share : {0.1, 0.35, 0.5}) {
      std::vector<std::uint16_t> changed = raw;
      std::vector<std::uint8_t> kept(raw.size(), 1);
      for (int v = 0; v < 480; ++v) {
        for (int u = 0; u < static_cast<int>(640 * share); ++u) {
          changed[static_cast<std::size_t>(v * 640 + u)] = value;
          kept[static_cast<std::size_t>(v * 640 + u)] = 0;
        }
      }
      const Segmentation after = cells(DepthView::from_uint16(changed.data(), 640, 480, 5000.0), image.camera);
      EXPECT_GT(share_on_same_planes(before, after, kept), 0.97) << value << " in " << share;
      EXPECT_EQ(after.saturated, value == 65535 ? 65535 : 0);
      if (value == 65535) {
        EXPECT_EQ(after.labels[0], kLabelNoDepth);
      }
    }
  }
}

TEST(CellsErrors, TheSaturatedValueIsAChoice) {
  FloatImage image(kinect());
  image.draw(*make_plane({0.0, 0.0, -1.0}, 1.0));
  const std::vector<std::uint16_t> raw = in_units(image, 5000.0);  // 5000 throughout
  const DepthView depth = DepthView::from_uint16(raw.data(), 640, 480, 5000.0);
  SegmentOptions options = cells_options();
  options.saturated = 5000;
  EXPECT_EQ(segment(depth, image.camera, options).error().code, ErrorCode::no_data);
  options.saturated = 0;
  std::vector<std::uint16_t> far(raw.size(), 65535);
  EXPECT_EQ(cells(DepthView::from_uint16(far.data(), 640, 480, 50000.0), image.camera, options).planes.size(), 1U);
}

/// Holes cost accuracy, not the answer.
TEST(CellsErrors, MissingPixels) {
  RandomStream random = testing::test_random();
  FloatImage image = room(kinect());
  add_noise({.quadratic_per_m = 1.425e-3}, random, image);
  const Segmentation before = cells(image.view(), image.camera);
  std::vector<std::uint8_t> kept(image.metres.size(), 1);
  for (std::size_t i = 0; i < kept.size(); ++i) {
    kept[i] = static_cast<std::uint8_t>(random.below(10) >= 3);
    if (kept[i] == 0) image.metres[i] = 0.0F;
  }
  const Segmentation after = cells(image.view(), image.camera);
  expect_sane(after, image.view());
  EXPECT_EQ(after.planes.size(), before.planes.size());
  EXPECT_GT(share_on_same_planes(before, after, kept), 0.97);
}

TEST(CellsConfidence, IsAProbabilityAndThreshold) {
  synth::SynthOptions of_frame;
  of_frame.scene = "office";
  const auto frame = synth::render(of_frame);
  ASSERT_TRUE(frame);
  SegmentOptions options = cells_options();
  options.cells.min_confidence = 0.0;
  const Segmentation all = cells(testing::view_of(*frame), frame->camera, options);
  std::size_t certain = 0;
  for (const PlaneSegment& plane : all.planes) {
    EXPECT_GT(plane.confidence, 0.0);
    EXPECT_LT(plane.confidence, 1.0);
    EXPECT_GT(plane.evidence.share, 0.0);
    EXPECT_GE(plane.evidence.turn_rad, 0.0);
    EXPECT_GE(plane.evidence.smooth_border, 0.0);
    EXPECT_LE(plane.evidence.smooth_border, 1.0);
    certain += static_cast<std::size_t>(plane.confidence >= 0.9);
  }
  EXPECT_GT(certain, 2U);
  EXPECT_LT(certain, all.planes.size());
  options.cells.min_confidence = 0.9;
  const Segmentation few = cells(testing::view_of(*frame), frame->camera, options);
  EXPECT_EQ(few.planes.size(), certain);
  for (const PlaneSegment& plane : few.planes) EXPECT_GE(plane.confidence, 0.9);
}

}  // namespace
}  // namespace fransac
