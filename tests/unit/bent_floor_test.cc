// SPDX-License-Identifier: Apache-2.0
// Floor that a sensor bends is floor; what stands on it is not.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <vector>

#include "cells.hpp"
#include "fransac/eval/metrics.hpp"
#include "fransac/obstacles/obstacles.hpp"
#include "fransac/planes/segment.hpp"
#include "fransac/synth/synth.hpp"
#include "obstacles/floor_error.hpp"
#include "support.hpp"

namespace fransac {
namespace {

using Eigen::Vector3d;
using obstacles::FloorError;
using testing::FloatImage;

// ---- how far off a floor may be ----

/// A floor a metre below a camera that looks ahead, seen around 2 m before it.
PlaneSegment level_floor() {
  return {.id = 1, .plane = *make_plane(-Vector3d::UnitY(), 1.0), .centroid = {0.0, 1.0, 2.0}, .area_m2 = std::numbers::pi};
}

TEST(FloorError, IsTheSumOfItsParts) {
  Segmentation errors;
  const DepthNoise pixel{.quadratic_per_m = 0.001};
  const PlaneSegment floor = level_floor();
  const Vector3d far(0.0, 1.0, 4.0);  // the ray falls by a quarter
  const auto most = [&] { return FloorError(errors, floor, pixel, 3.0).most_m(far); };
  EXPECT_NEAR(most(), 3.0 * 0.016 / 4.0, 1e-12);
  errors.slow_noise = {.quadratic_per_m = 0.002};
  EXPECT_NEAR(most(), 3.0 * std::sqrt(5.0) * 0.016 / 4.0, 1e-12);
  errors.slow_noise = {};
  // A centimetre along the ray is 5 mm of height in the middle, half a metre of which is one deviation of the floor's disc.
  errors.bias_m = 0.01;
  EXPECT_NEAR(most(), 0.012 + 0.01 / 4.0 + 0.005 * 2.0 / 0.5, 1e-12);
}

TEST(FloorError, OfAPlaneGrowsWithTheDistance) {
  PlaneSegment floor = level_floor();
  floor.covariance(2, 2) = 1e-6;  // turns about the image's x: a milliradian
  EXPECT_NEAR(FloorError({}, floor, {}, 2.0).most_m({0.0, 1.0, 6.0}), 0.012, 1e-12);
}

TEST(FloorError, WithoutACentroidOrAnAreaNoTiltIsKnown) {
  Segmentation errors;
  errors.bias_m = 0.01;
  for (const bool centroid : {false, true}) {
    PlaneSegment floor = level_floor();
    if (centroid) floor.centroid.setZero();
    if (!centroid) floor.area_m2 = 0.0;
    EXPECT_NEAR(FloorError(errors, floor, {}, 4.0).most_m({0.0, 1.0, 4.0}), 0.0025, 1e-12);
  }
}

TEST(FloorError, GrazingIsBelowTenDegrees) {
  const FloorError error({}, level_floor(), {}, 4.0);
  EXPECT_FALSE(error.is_grazing({0.0, 1.0, 5.8}));
  EXPECT_TRUE(error.is_grazing({0.0, 1.0, 6.0}));
}

// ---- exact floors that are bent ----

/// A view of a floor under a Kinect, 0.8 m above it and 20 degrees down, without noise though it counts as having some. Heights
/// above the floor are drawn into it; what is within the noise is labelled as the floor, as segmentations do.
struct BentView {
  BentView() : image(testing::kinect()) {
    const double down = 20.0 * std::numbers::pi / 180.0;
    floor = Plane{Vector3d(0.0, -std::cos(down), -std::sin(down)), 0.8};
    image.draw(floor);
    planes.width = image.camera.width;
    planes.height = image.camera.height;
    planes.noise = {.quadratic_per_m = kKinectNoise_per_m};
    planes.slow_noise = planes.noise;
    planes.bias_m = 0.01;
    planes.planes.push_back({.id = 1, .plane = floor, .centroid = foot(320, 380), .area_m2 = 4.0});
    planes.planes.front().kind = PlaneKind::floor;
    for (float& z : image.metres) {
      if (z > 8.0F) z = 0.0F;
    }
  }

  [[nodiscard]] Vector3d ray(int u, int v) const { return testing::ray(image.camera, u, v); }
  [[nodiscard]] Vector3d foot(int u, int v) const { return testing::depth_on(floor, image.camera, u, v) * ray(u, v); }

  /// Raises what is seen of the floor where height(u, v), metres, is not 0.
  template <class Height>
  void raise(const Height& height) {
    for (int v = 0; v < image.camera.height; ++v) {
      for (int u = 0; u < image.camera.width; ++u) {
        float& z = image.at(u, v);
        if (!(z > 0.0F)) continue;
        const double up = height(u, v, static_cast<double>(z));
        if (up == 0.0) continue;
        z = static_cast<float>((up - floor.d) / floor.normal.dot(ray(u, v)));
      }
    }
  }

  Obstacles find() {
    planes.labels.assign(image.metres.size(), kLabelNoDepth);
    for (int v = 0; v < image.camera.height; ++v) {
      for (int u = 0; u < image.camera.width; ++u) {
        const auto z = static_cast<double>(image.at(u, v));
        if (!(z > 0.0)) continue;
        const double sigma = planes.noise.sigma_m(z) * std::abs(floor.normal.dot(ray(u, v)));
        const bool is_on = std::abs(floor.signed_distance(z * ray(u, v))) <= 2.2 * sigma;
        planes.labels[index(u, v)] = is_on ? std::uint8_t{1} : kLabelNoPlane;
      }
    }
    Result<Obstacles> found = find_obstacles(image.view(), image.camera, planes);
    EXPECT_TRUE(found.ok());
    return found ? *std::move(found) : Obstacles{};
  }

  [[nodiscard]] std::size_t index(int u, int v) const { return static_cast<std::size_t>(v * image.camera.width + u); }

  FloatImage image;
  Plane floor;
  Segmentation planes;
};

/// Rises to the right edge and with the distance, by as much as the floor's errors make: wide, low and far.
double bend(int u, int /*v*/, double z) {
  return u < 400 ? 0.0 : 0.035 * std::min(1.0, (u - 400) / 120.0) * (z > 2.5 ? 1.0 : 0.0) * std::min(1.0, (z - 2.5) / 1.5);
}

TEST(BentFloor, AWideStripThatRisesSlowlyIsFloor) {
  BentView view;
  view.raise(bend);
  EXPECT_TRUE(view.find().obstacles.empty());
  view.planes.bias_m = 0.0;
  view.planes.slow_noise = {};
  EXPECT_FALSE(view.find().obstacles.empty()) << "a sensor without bias and slow noise bends nothing";
}

TEST(BentFloor, AStripThatFallsSlowlyIsNoDrop) {
  BentView view;
  view.raise([](int u, int v, double z) { return -1.4 * bend(u, v, z); });
  EXPECT_TRUE(view.find().obstacles.empty());
  view.planes.bias_m = 0.0;
  view.planes.slow_noise = {};
  EXPECT_FALSE(view.find().obstacles.empty());
}

TEST(BentFloor, WhatStandsOnABentStripIsFound) {
  BentView view;
  const auto stands = [](int u, int v) { return u >= 560 && u < 600 && v >= 196 && v < 240; };  // 15 cm wide, whole cells
  view.raise([&](int u, int v, double z) { return stands(u, v) ? 0.2 : bend(u, v, z); });
  const Obstacles found = view.find();
  ASSERT_EQ(found.obstacles.size(), 1U);
  EXPECT_NEAR(found.obstacles.front().max_height_m, 0.2, 0.01);
  EXPECT_GE(found.labels[view.index(580, 215)], 1);
}

TEST(BentFloor, ALowPlateWithAStepIsFound) {
  // As low as bias and slow noise together may lift the floor, but with edges, and not at a grazing angle.
  BentView view;
  const auto stands = [](int u, int v) { return u >= 280 && u < 360 && v >= 300 && v < 340; };
  view.raise([&](int u, int v, double) { return stands(u, v) ? 0.014 : 0.0; });
  const Vector3d middle = view.foot(320, 320);
  const FloorError error(view.planes, view.planes.planes.front(), view.planes.noise, 4.0);
  ASSERT_LT(0.014, error.most_m(middle));
  ASSERT_GT(0.014, 4.0 * error.pixel_m(middle));
  const Obstacles found = view.find();
  ASSERT_EQ(found.obstacles.size(), 1U);
  EXPECT_EQ(found.labels[view.index(320, 320)], 1);
}

TEST(BentFloor, ASpeckAsSlowNoiseMakesItIsFloor) {
  // Three cells of an otherwise flat floor, five sigmas high.
  for (const bool slow : {false, true}) {
    BentView view;
    view.planes.slow_noise = {.quadratic_per_m = (slow ? 3.0 : 0.0) * kKinectNoise_per_m};
    const FloorError error(view.planes, view.planes.planes.front(), view.planes.noise, 4.0);
    const double height = 5.0 * error.pixel_m(view.foot(326, 302));
    view.raise([&](int u, int v, double) { return u >= 320 && u < 332 && v >= 300 && v < 304 ? height : 0.0; });
    EXPECT_EQ(view.find().obstacles.size(), slow ? 0U : 1U);
  }
}

TEST(BentFloor, AGroupIsFloorWhereThreeQuartersOfItJoinTheFloor) {
  // Four cells in a row, of which so many are as low as slow noise makes floors.
  for (const int joining : {2, 3}) {
    BentView view;
    view.planes.slow_noise = {.quadratic_per_m = 3.0 * kKinectNoise_per_m};
    const FloorError error(view.planes, view.planes.planes.front(), view.planes.noise, 4.0);
    const double pixel_m = error.pixel_m(view.foot(328, 302));
    view.raise([&](int u, int v, double) {
      if (u < 320 || u >= 336 || v < 300 || v >= 304) return 0.0;
      return (u < 320 + 4 * joining ? 5.0 : 9.0) * pixel_m;
    });
    ASSERT_LT(9.0 * pixel_m, error.most_m(view.foot(328, 302)));
    const Obstacles found = view.find();
    EXPECT_EQ(found.labels[view.index(322, 302)], joining == 2 ? 1 : 0);
    EXPECT_EQ(found.obstacles.size(), joining == 2 ? 1U : 0U);
  }
}

TEST(BentFloor, AFarPlaneOfTheFloorIsSupportAtAGrazingAngleOnly) {
  BentView view;
  view.planes.slow_noise = {.quadratic_per_m = 2.0 * kKinectNoise_per_m};
  for (const int row : {100, 330}) {  // 6 m and 1.6 m away
    const Vector3d middle = view.foot(320, row);
    const FloorError error(view.planes, view.planes.planes.front(), view.planes.noise, 4.0);
    const double height = 0.8 * error.most_m(middle);
    ASSERT_GT(height, 4.0 * error.pixel_m(middle));
    view.planes.planes.resize(1);
    view.planes.planes.push_back({.id = 2,
                                  .plane = Plane{view.floor.normal, view.floor.d - height},
                                  .centroid = middle + height * view.floor.normal,
                                  .kind = PlaneKind::floor,
                                  .area_m2 = 1.0});
    EXPECT_EQ(view.find().support.size(), error.is_grazing(middle) ? 2U : 1U);
  }
}

TEST(BentFloor, GrazingClustersOfCloudsAreFloor) {
  Segmentation planes;
  planes.noise = {.quadratic_per_m = kKinectNoise_per_m};
  planes.bias_m = 0.01;
  planes.planes.push_back(level_floor());
  planes.planes.back().kind = PlaneKind::floor;
  std::vector<Vector3d> points;
  for (const double z : {3.0, 7.0}) {
    for (int i = 0; i < 100; ++i) points.emplace_back(0.02 * (i % 10), 1.0 - 0.04, z + 0.02 * (i / 10));
  }
  const PointCloud cloud = testing::cloud_of(points);
  planes.width = cloud.width;
  planes.height = 1;
  planes.labels.assign(cloud.size(), kLabelNoPlane);
  const auto found = find_obstacles(cloud, planes, {.cluster_distance_m = 0.05});
  ASSERT_TRUE(found.ok());
  ASSERT_EQ(found->obstacles.size(), 1U);
  EXPECT_NEAR(found->obstacles.front().nearest_m, 3.15, 0.05);
  planes.bias_m = 0.0;
  EXPECT_EQ(find_obstacles(cloud, planes, {.cluster_distance_m = 0.05})->obstacles.size(), 2U);
}

// ---- rendered rooms through a lens ----

/// Bends inverse depth with the squared distance from the image's middle, by a centimetre at 2 m in the corners.
std::vector<std::uint16_t> through_lens(const synth::SynthFrame& frame, double sign) {
  const double corner_m = 0.01;
  const double corner = std::pow(frame.camera.cx, 2) + std::pow(frame.camera.cy, 2);
  std::vector<std::uint16_t> bent(frame.depth);
  for (std::size_t i = 0; i < bent.size(); ++i) {
    if (bent[i] == 0) continue;
    const auto width = static_cast<std::size_t>(frame.camera.width);
    const double u = static_cast<double>(i % width) - frame.camera.cx;
    const double v = static_cast<double>(i / width) - frame.camera.cy;
    const double q = frame.camera.depth_scale / bent[i] + sign * corner_m / 4.0 * (u * u + v * v) / corner;
    bent[i] = static_cast<std::uint16_t>(std::clamp(std::lround(frame.camera.depth_scale / q), 1L, 65534L));
  }
  return bent;
}

TEST(BentFloor, OfRenderedRoomsIsNoObstacle) {
  for (const char* scene : {"hall", "office", "empty_room"}) {
    std::size_t on_floor = 0;
    std::size_t on_obstacle = 0;
    for (const std::uint64_t seed : {0U, 1U, 2U}) {
      const Result<synth::SynthFrame> frame = synth::render({.scene = scene, .seed = seed});
      ASSERT_TRUE(frame.ok());
      // The floor is the lowest plane that faces the world's z.
      const Vector3d up = frame->T_world_camera.linear().transpose() * Vector3d::UnitZ();
      int floor = 0;
      double lowest = 0.0;
      for (const auto& [label, plane] : frame->true_planes) {
        if (plane.normal.dot(up) < 0.999 || plane.d < lowest) continue;
        floor = label;
        lowest = plane.d;
      }
      if (floor == 0) continue;
      for (const double sign : {-1.0, 1.0}) {
        const std::vector<std::uint16_t> bent = through_lens(*frame, sign);
        const DepthView depth =
            DepthView::from_uint16(bent.data(), frame->camera.width, frame->camera.height, frame->camera.depth_scale);
        const Result<Segmentation> planes = segment(depth, frame->camera);
        ASSERT_TRUE(planes.ok());
        const Result<Obstacles> found = find_obstacles(depth, frame->camera, *planes);
        ASSERT_TRUE(found.ok());
        const auto counts = eval::floor_as_obstacle(frame->labels, found->labels, static_cast<std::uint8_t>(floor));
        ASSERT_TRUE(counts.ok());
        on_floor += counts->floor;
        on_obstacle += counts->obstacle;
        RecordProperty(std::string(scene) + std::to_string(seed) + (sign > 0 ? "+" : "-"), std::to_string(counts->share()));
      }
    }
    EXPECT_GT(on_floor, 100000U) << scene;
    EXPECT_LE(static_cast<double>(on_obstacle), 0.003 * static_cast<double>(on_floor)) << scene;
  }
}

}  // namespace
}  // namespace fransac
