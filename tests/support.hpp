// SPDX-License-Identifier: Apache-2.0
/// What several test programs need: seeds, small clouds, depth images of known planes.
#pragma once

#include <gtest/gtest.h>

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "fransac/core/camera.hpp"
#include "fransac/core/depth_image.hpp"
#include "fransac/core/plane.hpp"
#include "fransac/core/point_cloud.hpp"
#include "fransac/core/random.hpp"
#include "fransac/planes/segment.hpp"

namespace fransac::testing {

/// A seed that follows from the running test's name alone (FNV-1a, 64 bits).
inline std::uint64_t seed_of_test() {
  const ::testing::TestInfo* const info = ::testing::UnitTest::GetInstance()->current_test_info();
  std::uint64_t hash = 0xcbf29ce484222325;
  for (const char c : std::string(info->test_suite_name()) + "." + info->name()) {
    hash = (hash ^ static_cast<unsigned char>(c)) * 0x100000001b3;
  }
  return hash;
}

/// Random numbers of the running test; different `index` values give independent ones.
inline RandomStream test_random(std::uint64_t index = 0) { return {seed_of_test(), index}; }

inline double uniform(RandomStream& random, double low, double high) { return low + (high - low) * random.uniform(); }

inline Eigen::Vector3d uniform_point(RandomStream& random, double low, double high) {
  const double x = uniform(random, low, high);
  const double y = uniform(random, low, high);
  return {x, y, uniform(random, low, high)};
}

inline Eigen::Vector3d unit_vector(RandomStream& random) {
  const double x = random.normal();
  const double y = random.normal();
  return Eigen::Vector3d(x, y, random.normal()).normalized();
}

/// An unorganised cloud; `points` are relative to its origin.
inline PointCloud cloud_of(const std::vector<Eigen::Vector3d>& points, const Eigen::Vector3d& origin = Eigen::Vector3d::Zero()) {
  PointCloud cloud;
  cloud.resize(points.size());
  for (std::size_t i = 0; i < points.size(); ++i) cloud.set(i, points[i].cast<float>());
  cloud.origin = origin;
  cloud.width = static_cast<int>(points.size());
  cloud.height = 1;
  return cloud;
}

/// Points on the unit square of the plane z = 1 + 0.3 x - 0.2 y with normal noise, then outliers in the cube around it.
inline PointCloud noisy_plane(std::size_t inliers, std::size_t outliers, double noise_m, RandomStream random) {
  std::vector<Eigen::Vector3d> points;
  for (std::size_t i = 0; i < inliers; ++i) {
    const double x = random.uniform();
    const double y = random.uniform();
    points.emplace_back(x, y, 1.0 + 0.3 * x - 0.2 * y + noise_m * random.normal());
  }
  for (std::size_t i = 0; i < outliers; ++i) points.push_back(uniform_point(random, 0.0, 2.0));
  return cloud_of(points);
}

inline Camera small_camera(int width = 80, int height = 60) {
  return {.width = width,
          .height = height,
          .fx = 70.0,
          .fy = 72.0,
          .cx = width / 2.0 - 0.3,
          .cy = height / 2.0 + 0.2,
          .depth_scale = 1000.0};
}

inline Eigen::Vector3d ray(const Camera& camera, int u, int v) {
  return {(u - camera.cx) / camera.fx, (v - camera.cy) / camera.fy, 1.0};
}

/// The depth at which a pixel's ray meets the plane; not positive where it never does.
inline double depth_on(const Plane& plane, const Camera& camera, int u, int v) {
  return -plane.d / plane.normal.dot(ray(camera, u, v));
}

/// A float depth image that owns its pixels; 0 everywhere at first.
struct FloatImage {
  explicit FloatImage(const Camera& c)
      : camera(c), metres(static_cast<std::size_t>(c.width) * static_cast<std::size_t>(c.height)) {}

  float& at(int u, int v) {
    return metres[static_cast<std::size_t>(v) * static_cast<std::size_t>(camera.width) + static_cast<std::size_t>(u)];
  }
  /// Draws the plane on the columns [first, end).
  void draw(const Plane& plane, int first, int end) {
    for (int v = 0; v < camera.height; ++v) {
      for (int u = first; u < end; ++u) {
        const double z = depth_on(plane, camera, u, v);
        at(u, v) = z > 0.0 ? static_cast<float>(z) : 0.0F;
      }
    }
  }
  void draw(const Plane& plane) { draw(plane, 0, camera.width); }
  [[nodiscard]] DepthView view() const { return DepthView::from_float(metres.data(), camera.width, camera.height); }

  Camera camera;
  std::vector<float> metres;
};

/// Everything but the timing is equal, to the last bit.
inline void expect_same(const Segmentation& a, const Segmentation& b) {
  EXPECT_EQ(a.method, b.method);
  EXPECT_EQ(a.width, b.width);
  EXPECT_EQ(a.height, b.height);
  EXPECT_TRUE(a.labels == b.labels);
  EXPECT_EQ(a.valid_points, b.valid_points);
  EXPECT_EQ(a.sampled_points, b.sampled_points);
  EXPECT_EQ(a.iterations, b.iterations);
  EXPECT_EQ(a.rejected, b.rejected);
  EXPECT_EQ(a.degenerate, b.degenerate);
  EXPECT_EQ(a.stop_reason, b.stop_reason);
  ASSERT_EQ(a.planes.size(), b.planes.size());
  for (std::size_t i = 0; i < a.planes.size(); ++i) {
    EXPECT_EQ(a.planes[i].id, b.planes[i].id);
    EXPECT_EQ(a.planes[i].plane.normal, b.planes[i].plane.normal);
    EXPECT_EQ(a.planes[i].plane.d, b.planes[i].plane.d);
    EXPECT_EQ(a.planes[i].inliers, b.planes[i].inliers);
    EXPECT_EQ(a.planes[i].support, b.planes[i].support);
    EXPECT_EQ(a.planes[i].rms_m, b.planes[i].rms_m);
    EXPECT_EQ(a.planes[i].area_m2, b.planes[i].area_m2);
  }
}

inline constexpr Method kMethods[] = {Method::fransac, Method::voxel_ransac, Method::rransac, Method::ransac};

}  // namespace fransac::testing
