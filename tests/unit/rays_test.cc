// SPDX-License-Identifier: Apache-2.0
#include "fransac/filter/rays.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "fransac/core/labels.hpp"
#include "support.hpp"

namespace fransac {
namespace {

using Eigen::Vector2d;
using testing::FloatImage;
using ::testing::HasSubstr;

RayTable pinhole_rays(const Camera& camera) {
  RayTable rays{camera.width, camera.height, {}, {}};
  for (int v = 0; v < camera.height; ++v) {
    for (int u = 0; u < camera.width; ++u) {
      rays.x.push_back(static_cast<float>((u - camera.cx) / camera.fx));
      rays.y.push_back(static_cast<float>((v - camera.cy) / camera.fy));
    }
  }
  return rays;
}

/// Brown and Conrady: where the lens puts the ideal ray.
Vector2d distorted(const Vector2d& ray) {
  constexpr double k1 = -0.28;
  constexpr double k2 = 0.07;
  constexpr double p1 = 0.001;
  constexpr double p2 = -0.002;
  const double x = ray.x();
  const double y = ray.y();
  const double r2 = ray.squaredNorm();
  const double radial = 1.0 + k1 * r2 + k2 * r2 * r2;
  return {x * radial + 2.0 * p1 * x * y + p2 * (r2 + 2.0 * x * x), y * radial + p1 * (r2 + 2.0 * y * y) + 2.0 * p2 * x * y};
}

/// The rays of a lens with that distortion, by iteration.
RayTable lens_rays(const Camera& camera) {
  RayTable rays = pinhole_rays(camera);
  for (std::size_t i = 0; i < rays.x.size(); ++i) {
    const Vector2d seen(static_cast<double>(rays.x[i]), static_cast<double>(rays.y[i]));
    Vector2d ray = seen;
    for (int k = 0; k < 50; ++k) ray += seen - distorted(ray);
    EXPECT_LT((distorted(ray) - seen).norm(), 1e-9);
    rays.x[i] = static_cast<float>(ray.x());
    rays.y[i] = static_cast<float>(ray.y());
  }
  return rays;
}

RayMap map_of(const RayTable& rays, const Camera& ideal) {
  const Result<RayMap> map = ray_map(rays, ideal);
  EXPECT_TRUE(map) << (map ? "" : map.error().message);
  return map ? *map : RayMap{};
}

/// A lens of 160 x 120 pixels, and an ideal camera of its focal length that sees all of its rays.
struct Lens {
  Camera camera{.width = 160, .height = 120, .fx = 120.0, .fy = 121.0, .cx = 79.0, .cy = 60.5};
  Camera ideal{.width = 220, .height = 160, .fx = 120.0, .fy = 121.0, .cx = 109.0, .cy = 80.5};
  RayTable rays = lens_rays(camera);

  [[nodiscard]] Vector2d place(std::size_t i) const {
    return {ideal.fx * static_cast<double>(rays.x[i]) + ideal.cx, ideal.fy * static_cast<double>(rays.y[i]) + ideal.cy};
  }
};

TEST(Rays, ThoseOfThePinholeItselfChangeNothing) {
  const Camera camera = testing::small_camera();
  const RayMap map = map_of(pinhole_rays(camera), camera);
  for (std::uint32_t i = 0; i < map.original.size(); ++i) {
    ASSERT_EQ(map.original[i], i);
    ASSERT_EQ(map.projected[i], i);
  }
  FloatImage image(camera);
  image.draw(*make_plane({0.2, -0.5, -1.0}, 1.5), 0, 50);
  std::vector<float> metres;
  ASSERT_TRUE(undistort(image.view(), map, metres));
  EXPECT_EQ(metres, image.metres);
}

TEST(Rays, AnIdealPixelShowsTheNearestRayAndThereAreNoHoles) {
  const Lens lens;
  const RayMap map = map_of(lens.rays, lens.ideal);
  int inside = 0;
  for (int v = 0; v < lens.ideal.height; ++v) {
    for (int u = 0; u < lens.ideal.width; ++u) {
      const Vector2d seen = distorted(testing::ray(lens.ideal, u, v).head<2>());
      const double lens_u = lens.camera.fx * seen.x() + lens.camera.cx;
      const double lens_v = lens.camera.fy * seen.y() + lens.camera.cy;
      if (lens_u < 0.01 || lens_u > lens.camera.width - 1.01 || lens_v < 0.01 || lens_v > lens.camera.height - 1.01) continue;
      const std::uint32_t shown = map.original[static_cast<std::size_t>(v * lens.ideal.width + u)];
      ASSERT_NE(shown, RayMap::kNone) << u << ", " << v;
      if (++inside % 29 != 0) continue;  // the search through all rays takes its time
      double nearest = std::numeric_limits<double>::infinity();
      for (std::size_t i = 0; i < lens.rays.x.size(); ++i) nearest = std::min(nearest, (lens.place(i) - Vector2d(u, v)).norm());
      ASSERT_NEAR((lens.place(shown) - Vector2d(u, v)).norm(), nearest, 1e-4) << u << ", " << v;
    }
  }
  EXPECT_GT(inside, lens.camera.width * lens.camera.height);  // the lens makes pixels smaller than the ideal camera does
}

TEST(Rays, APlaneSeenThroughTheLensIsThePlane) {
  const Lens lens;
  const Plane plane = *make_plane({0.1, -0.4, -1.0}, 1.5);
  FloatImage image(lens.camera);
  for (std::size_t i = 0; i < image.metres.size(); ++i) {
    const Eigen::Vector3d ray(static_cast<double>(lens.rays.x[i]), static_cast<double>(lens.rays.y[i]), 1.0);
    const double z = -plane.d / plane.normal.dot(ray);
    image.metres[i] = z > 0.0 && z < 10.0 ? static_cast<float>(z) : 0.0F;
  }
  const RayMap map = map_of(lens.rays, lens.ideal);
  std::vector<float> metres;
  ASSERT_TRUE(undistort(image.view(), map, metres));
  const auto off_plane = [&](const Camera& camera, int u, int v, float z) {
    return std::abs(plane.signed_distance(static_cast<double>(z) * testing::ray(camera, u, v)));
  };
  // On the ideal image a point is off by the sideways half pixel at most (here one and a half, where the lens stretches), taken
  // as it is, the image would be off by the lens's error.
  double worst = 0.0;
  double worst_untreated = 0.0;
  std::size_t shown = 0;
  for (int v = 0; v < lens.ideal.height; ++v) {
    for (int u = 0; u < lens.ideal.width; ++u) {
      const std::size_t i = static_cast<std::size_t>(v * lens.ideal.width + u);
      if (metres[i] == 0.0F) continue;
      ++shown;
      const double pixel_m = static_cast<double>(metres[i]) / lens.ideal.fx;
      worst = std::max(worst, off_plane(lens.ideal, u, v, metres[i]) / pixel_m);
    }
  }
  for (int v = 0; v < lens.camera.height; ++v) {
    for (int u = 0; u < lens.camera.width; ++u) {
      const float z = image.at(u, v);
      if (z > 0.0F)
        worst_untreated = std::max(worst_untreated, off_plane(lens.camera, u, v, z) / (static_cast<double>(z) / lens.camera.fx));
    }
  }
  EXPECT_GT(shown, image.metres.size());
  EXPECT_LT(worst, 1.0);
  EXPECT_GT(worst_untreated, 3.0);

  // Labels come back to the pixels that were measured.
  std::vector<std::uint8_t> ideal_labels(metres.size());
  for (std::size_t i = 0; i < metres.size(); ++i) ideal_labels[i] = metres[i] > 0.0F ? kLabelFirst : kLabelNoDepth;
  std::vector<std::uint8_t> labels(image.metres.size(), 77);
  ASSERT_TRUE(labels_to_original(image.view(), map, ideal_labels, labels));
  for (std::size_t i = 0; i < labels.size(); ++i) {
    if (image.metres[i] == 0.0F) {
      ASSERT_EQ(labels[i], kLabelNoDepth);
    } else {
      // At the border of what is measured the ideal pixel may show a neighbour without depth.
      ASSERT_TRUE(labels[i] == kLabelFirst || labels[i] == kLabelNoPlane);
    }
  }
  EXPECT_GT(std::count(labels.begin(), labels.end(), kLabelFirst), 0.99 * static_cast<double>(image.metres.size()));
}

TEST(Rays, PixelsWithoutARayOrOutsideTheIdealImageAreOnNoPlane) {
  const Camera camera = testing::small_camera();
  RayTable rays = pinhole_rays(camera);
  rays.x[0] = std::numeric_limits<float>::quiet_NaN();
  rays.y[1] = std::numeric_limits<float>::infinity();
  Camera ideal = camera;
  ideal.height = 30;
  const RayMap map = map_of(rays, ideal);
  EXPECT_EQ(map.projected[0], RayMap::kNone);
  EXPECT_EQ(map.projected[1], RayMap::kNone);
  EXPECT_EQ(map.original[0], RayMap::kNone);
  FloatImage image(camera);
  image.draw(*make_plane({0.0, 0.0, -1.0}, 1.5));
  const std::vector<std::uint8_t> ideal_labels(80 * 30, 3);
  std::vector<std::uint8_t> labels(80 * 60);
  ASSERT_TRUE(labels_to_original(image.view(), map, ideal_labels, labels));
  EXPECT_EQ(labels[0], kLabelNoPlane);
  EXPECT_EQ(labels[1], kLabelNoPlane);
  EXPECT_EQ(labels[2], 3);
  EXPECT_EQ(labels[80 * 30 - 1], 3);
  EXPECT_EQ(labels[80 * 30], kLabelNoPlane);
}

TEST(Rays, ATableOfNoLensIsHarmless) {
  RandomStream random = testing::test_random();
  RayTable rays{50, 40, {}, {}};
  for (int i = 0; i < 2000; ++i) {
    rays.x.push_back(static_cast<float>(std::pow(10.0, testing::uniform(random, -30.0, 38.0)) * random.normal()));
    rays.y.push_back(static_cast<float>(testing::uniform(random, -2.0, 2.0)));
  }
  const RayMap map = map_of(rays, testing::small_camera());
  for (const std::uint32_t i : map.original) ASSERT_TRUE(i == RayMap::kNone || i < 2000U);
  for (const std::uint32_t i : map.projected) ASSERT_TRUE(i == RayMap::kNone || i < map.original.size());
}

TEST(Rays, WhatDoesNotFitIsNamed) {
  const Camera camera = testing::small_camera();
  RayTable rays = pinhole_rays(camera);
  const RayMap map = map_of(rays, camera);
  rays.x.pop_back();
  EXPECT_THAT(ray_map(rays, camera).error().message, HasSubstr("4800 values"));
  rays.width = 0;
  EXPECT_THAT(ray_map(rays, camera).error().message, HasSubstr("0 x 60"));
  Camera bad = camera;
  bad.fx = -1.0;
  EXPECT_THAT(ray_map(pinhole_rays(camera), bad).error().message, HasSubstr("fx"));
  const FloatImage other(testing::small_camera(40, 30));
  std::vector<float> metres;
  EXPECT_THAT(undistort(other.view(), map, metres).error().message, HasSubstr("80 x 60"));
  const FloatImage image(camera);
  std::vector<std::uint8_t> labels(10);
  EXPECT_THAT(labels_to_original(image.view(), map, labels, labels).error().message, HasSubstr("4800"));
}

}  // namespace
}  // namespace fransac
