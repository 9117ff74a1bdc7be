// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <set>
#include <vector>

#include "fransac/filter/deproject.hpp"
#include "fransac/planes/segment.hpp"
#include "support.hpp"

namespace fransac {
namespace {

using Eigen::Vector3d;
using ::testing::Each;
using testing::FloatImage;
using ::testing::HasSubstr;
using testing::kMethods;

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr double kInf = std::numeric_limits<double>::infinity();

Segmentation segmented(const DepthView& depth, const Camera& camera, const SegmentOptions& options) {
  const Result<Segmentation> result = segment(depth, camera, options);
  EXPECT_TRUE(result) << (result ? "" : result.error().message);
  return result ? *result : Segmentation{};
}
Segmentation segmented(const FloatImage& image, const SegmentOptions& options) {
  return segmented(image.view(), image.camera, options);
}
Segmentation segmented(const PointCloud& cloud, const SegmentOptions& options) {
  const Result<Segmentation> result = segment(cloud, options);
  EXPECT_TRUE(result) << (result ? "" : result.error().message);
  return result ? *result : Segmentation{};
}

SegmentOptions options_for(Method method) {
  SegmentOptions options;
  options.method = method;
  return options;
}

std::size_t count(const Segmentation& s, int label) {
  return static_cast<std::size_t>(std::count(s.labels.begin(), s.labels.end(), static_cast<std::uint8_t>(label)));
}

/// A wall 2 m away on the left of the picture, a slope on the right. No pixel of either comes near the other's plane.
struct TwoPlanes {
  TwoPlanes() : image(testing::small_camera()) {
    image.draw(wall, 0, 50);
    image.draw(slope, 50, 80);
  }
  Plane wall = *make_plane({0, 0, -1}, 2.0);
  Plane slope = *make_plane({0.1, -0.6, -0.7}, 0.7);
  FloatImage image;
};

// ---- one plane ----

TEST(Segment, OneExactPlane) {
  FloatImage image(testing::small_camera());
  const Plane truth = *make_plane({0.2, -0.3, -1.0}, 1.5);
  image.draw(truth);
  for (const Method method : kMethods) {
    const Segmentation s = segmented(image, options_for(method));
    EXPECT_EQ(s.method, method);
    EXPECT_EQ(s.width, 80);
    EXPECT_EQ(s.height, 60);
    EXPECT_EQ(s.valid_points, 4800U);
    EXPECT_THAT(s.labels, Each(kLabelFirst));
    ASSERT_EQ(s.planes.size(), 1U);
    EXPECT_EQ(s.planes[0].id, 1);
    EXPECT_EQ(s.planes[0].inliers, 4800U);
    EXPECT_EQ(s.planes[0].support, s.sampled_points);
    EXPECT_LT(angle_between(s.planes[0].plane, truth), 1e-6);
    EXPECT_NEAR(s.planes[0].plane.d, truth.d, 1e-6);
    EXPECT_LT(s.planes[0].rms_m, 1e-6);  // float depth: 1.2e-7 at 1.5 m
    EXPECT_EQ(s.stop_reason, StopReason::confidence);
    EXPECT_EQ(s.iterations, 1U);
  }
}

TEST(Segment, AreaOfAWallIsWidthTimesHeight) {
  // Each pixel covers z^2 / (fx fy): 80 x 60 pixels at 2 m.
  FloatImage image(testing::small_camera());
  image.draw(*make_plane({0, 0, -1}, 2.0));
  const Segmentation s = segmented(image, options_for(Method::ransac));
  ASSERT_EQ(s.planes.size(), 1U);
  EXPECT_NEAR(s.planes[0].area_m2, 80 * 60 * 4.0 / (70.0 * 72.0), 1e-5);
}

TEST(Segment, AreaOfATiltedPlaneIsItsTrueArea) {
  // The picture's outline projected onto the plane: the quadrilateral of the four corner rays.
  FloatImage image(testing::small_camera());
  const Plane plane = *make_plane({0.3, -0.4, -1.0}, 1.5);
  image.draw(plane);
  const auto corner = [&](double u, double v) -> Vector3d {
    const Vector3d r((u - image.camera.cx) / image.camera.fx, (v - image.camera.cy) / image.camera.fy, 1.0);
    return -plane.d / plane.normal.dot(r) * r;
  };
  const Vector3d a = corner(-0.5, -0.5), b = corner(79.5, -0.5), c = corner(79.5, 59.5), d = corner(-0.5, 59.5);
  const double area = 0.5 * (c - a).cross(d - b).norm();
  const Segmentation s = segmented(image, options_for(Method::ransac));
  ASSERT_EQ(s.planes.size(), 1U);
  EXPECT_NEAR(s.planes[0].area_m2, area, 1e-3 * area);  // each pixel counts with its middle's depth
}

TEST(Segment, AreaOfACloudIsWithinItsRectangleWhereverZeroIs) {
  for (const double shift : {0.0, 0.3, 100.0}) {
    const std::vector<Vector3d> square{{1 + shift, 1, 1}, {-1 + shift, 1, 1}, {-1 + shift, -1, 1}, {1 + shift, -1, 1}};
    const Segmentation s = segmented(testing::cloud_of(square), options_for(Method::fransac));
    ASSERT_EQ(s.planes.size(), 1U);
    EXPECT_NEAR(s.planes[0].area_m2, 4.0, 1e-3) << shift;
  }
}

TEST(Segment, BetweenParallelSheetsIsNoPlane) {
  for (const double gap_m : {0.01, 0.015, 0.02}) {
    RandomStream random = testing::test_random(static_cast<std::uint64_t>(1000.0 * gap_m));
    std::vector<Vector3d> points;
    for (int i = 0; i < 32000; ++i) {
      const double x = testing::uniform(random, -1.0, 1.0);
      const double y = testing::uniform(random, -1.0, 1.0);
      points.emplace_back(x, y, 1.0 + (i % 8 < 5 ? 0.0 : gap_m) + 0.001 * random.normal());
    }
    SegmentOptions options = options_for(Method::fransac);
    options.max_planes = 0;
    options.ransac.threshold_m = 0.004;
    const Segmentation s = segmented(testing::cloud_of(points), options);
    EXPECT_GE(s.planes.size(), 1U) << gap_m;
    for (const PlaneSegment& plane : s.planes) {
      EXPECT_GT(plane.inliers, 5000U) << gap_m;
      EXPECT_EQ(count(s, plane.id), plane.inliers) << gap_m;
      EXPECT_LT(std::min(std::abs(plane.plane.d - 1.0), std::abs(plane.plane.d - 1.0 - gap_m)), 0.3 * gap_m) << gap_m;
    }
  }
}

TEST(Segment, AStrayPointFarAwayLeavesTheOthersTheirPlane) {
  RandomStream random = testing::test_random();
  std::vector<Vector3d> points;
  for (int i = 0; i < 5000; ++i) {
    points.emplace_back(testing::uniform(random, -1.0, 1.0), testing::uniform(random, -1.0, 1.0), 2.0 + 0.001 * random.normal());
  }
  const Segmentation clean = segmented(testing::cloud_of(points), options_for(Method::fransac));
  for (const double far_m : {1e6, 1e12, 1e30}) {
    std::vector<Vector3d> with_stray = points;
    with_stray.insert(with_stray.begin() + 100, Vector3d(far_m, -far_m, far_m));
    const Segmentation s = segmented(testing::cloud_of(with_stray), options_for(Method::fransac));
    ASSERT_EQ(s.planes.size(), 1U) << far_m;
    EXPECT_EQ(s.planes[0].inliers, clean.planes[0].inliers) << far_m;
    EXPECT_NEAR(s.planes[0].plane.d, clean.planes[0].plane.d, 1e-9) << far_m;
    EXPECT_EQ(s.labels[100], kLabelNoPlane) << far_m;
  }
  // A leaf that is too small for the points themselves is still an error.
  SegmentOptions tiny = options_for(Method::fransac);
  tiny.voxel_grid.leaf_size_m = 1e-12;
  EXPECT_FALSE(segment(testing::cloud_of(points), tiny));
}

TEST(Segment, OfVeryLargeCloudsASampleIsSearchedAndEveryPointLabelled) {
  RandomStream random = testing::test_random();
  constexpr std::size_t kPoints = 1200000;  // more than are sorted into leaves
  std::vector<Vector3d> points;
  for (std::size_t i = 0; i < kPoints; ++i) {
    const Vector3d point = testing::uniform_point(random, -1.0, 1.0);
    points.push_back(i % 4 == 0 ? Vector3d(0.1 * point) : Vector3d(point.x(), point.y(), 1.5));
  }
  SegmentOptions options;
  options.method = Method::fransac;
  const PointCloud cloud = testing::cloud_of(points);
  const Result<Segmentation> found = segment(cloud, options);
  ASSERT_TRUE(found);
  ASSERT_EQ(found->planes.size(), 1U);
  EXPECT_EQ(found->valid_points, kPoints);
  EXPECT_NEAR(found->planes[0].plane.d, 1.5, 1e-4);
  EXPECT_EQ(found->planes[0].inliers, kPoints / 4 * 3);
  EXPECT_NEAR(found->planes[0].area_m2, 4.0, 0.05);
  for (std::size_t i = 0; i < kPoints; ++i) ASSERT_EQ(found->labels[i], i % 4 == 0 ? kLabelNoPlane : kLabelFirst);
  options.threads = 3;
  const Result<Segmentation> in_threads = segment(cloud, options);
  ASSERT_TRUE(in_threads);
  EXPECT_EQ(in_threads->planes[0].plane.normal, found->planes[0].plane.normal);
  EXPECT_EQ(in_threads->planes[0].area_m2, found->planes[0].area_m2);
  EXPECT_EQ(in_threads->planes[0].rms_m, found->planes[0].rms_m);
}

TEST(Segment, AreaOfACloudIsAboutItsSquares) {
  RandomStream random = testing::test_random();
  std::vector<Vector3d> points;
  for (int i = 0; i < 20000; ++i)
    points.emplace_back(testing::uniform(random, 10.0, 12.0), testing::uniform(random, -5.0, -4.0), 3.0);
  for (const Vector3d& origin : {Vector3d(0, 0, 0), Vector3d(5e5, 5.4e6, 200.0)}) {
    const Segmentation s = segmented(testing::cloud_of(points, origin), options_for(Method::ransac));
    ASSERT_EQ(s.planes.size(), 1U);
    EXPECT_NEAR(s.planes[0].area_m2, 2.0, 0.1);
  }
}

TEST(Segment, RmsIsTheNoise) {
  // Two depths 4 mm apart in a checkerboard: no tilt explains them, so every pixel is 2 mm off.
  FloatImage image(testing::small_camera());
  for (int v = 0; v < 60; ++v) {
    for (int u = 0; u < 80; ++u) image.at(u, v) = (u + v) % 2 == 0 ? 1.002F : 0.998F;
  }
  const Segmentation s = segmented(image, options_for(Method::ransac));
  ASSERT_EQ(s.planes.size(), 1U);
  EXPECT_NEAR(s.planes[0].rms_m, 0.002, 1e-6);
  EXPECT_NEAR(s.planes[0].plane.d, 1.0, 1e-4);
}

TEST(Segment, AutomaticIsCellsOfImagesAndFransacOfClouds) {
  const TwoPlanes scene;
  testing::expect_same(segmented(scene.image, options_for(Method::automatic)),
                       segmented(scene.image, options_for(Method::cells)));
  const PointCloud cloud = testing::noisy_plane(200, 20, 0.001, testing::test_random());
  const auto automatic = segment(cloud, options_for(Method::automatic));
  const auto fransac = segment(cloud, options_for(Method::fransac));
  ASSERT_TRUE(automatic && fransac);
  testing::expect_same(*automatic, *fransac);
}

TEST(Segment, MethodsSampleWhatTheyShould) {
  FloatImage image(testing::small_camera());
  image.draw(*make_plane({0, 0, -1}, 0.5), 0, 60);   // pixels 7 mm apart: several in a leaf
  image.draw(*make_plane({0, 0, -1}, 6.0), 60, 80);  // beyond the 4.5 m of the paper
  const Segmentation ransac = segmented(image, options_for(Method::ransac));
  EXPECT_EQ(ransac.sampled_points, 4800U);
  EXPECT_EQ(ransac.rejected, 0U);
  EXPECT_EQ(segmented(image, options_for(Method::rransac)).sampled_points, 4800U);
  const Segmentation voxels = segmented(image, options_for(Method::voxel_ransac));
  const Segmentation fransac = segmented(image, options_for(Method::fransac));
  EXPECT_LT(voxels.sampled_points, 4800U);
  EXPECT_LT(fransac.sampled_points, voxels.sampled_points);
  EXPECT_EQ(fransac.valid_points, 4800U);
}

// ---- several planes ----

TEST(Segment, TwoPlanesPeeledOff) {
  const TwoPlanes scene;
  for (const Method method : kMethods) {
    SegmentOptions options = options_for(method);
    options.max_planes = 0;
    const Segmentation s = segmented(scene.image, options);
    ASSERT_EQ(s.planes.size(), 2U) << enum_name(method);
    EXPECT_GE(s.planes[0].support, s.planes[1].support);
    std::set<double> found;
    for (std::size_t i = 0; i < 2; ++i) {
      EXPECT_EQ(s.planes[i].id, static_cast<int>(i) + 1);
      EXPECT_EQ(s.planes[i].inliers, count(s, s.planes[i].id));
      for (const Plane& truth : {scene.wall, scene.slope}) {
        const Plane& plane = s.planes[i].plane;
        if (angle_between(plane, truth) < 1e-5 && std::abs(plane.d - truth.d) < 1e-5) found.insert(truth.d);
      }
    }
    EXPECT_EQ(found.size(), 2U) << enum_name(method);
    EXPECT_EQ(count(s, kLabelNoDepth), 4800U - s.valid_points);
  }
}

TEST(Segment, AskedForOneGivesOne) {
  const TwoPlanes scene;
  SegmentOptions options = options_for(Method::ransac);
  const Segmentation s = segmented(scene.image, options);
  ASSERT_EQ(s.planes.size(), 1U);
  EXPECT_LT(angle_between(s.planes[0].plane, scene.wall), 1e-5);
  EXPECT_EQ(count(s, 2), 0U);
  EXPECT_GT(count(s, kLabelNoPlane), 1000U);
}

TEST(Segment, MinSupportEndsThePeeling) {
  const TwoPlanes scene;  // the slope has 3/8 of the pixels
  SegmentOptions options = options_for(Method::ransac);
  options.max_planes = 0;
  options.min_support = 0.5;
  EXPECT_EQ(segmented(scene.image, options).planes.size(), 1U);
  options.min_support = 0.7;
  const Segmentation none = segmented(scene.image, options);
  EXPECT_TRUE(none.planes.empty());
  EXPECT_THAT(none.labels, Each(kLabelNoPlane));
}

TEST(Segment, PixelsGoToTheNearestPlane) {
  // Two walls 6 mm apart with a threshold of 10 mm: both planes reach both, and each pixel must take its own.
  FloatImage image(testing::small_camera());
  image.draw(*make_plane({0, 0, -1}, 1.000), 0, 80);
  image.draw(*make_plane({0, -0.5, -1}, 1.2), 0, 40);
  SegmentOptions options = options_for(Method::ransac);
  options.max_planes = 0;
  options.ransac.threshold_m = 0.03;
  const Segmentation s = segmented(image, options);
  ASSERT_EQ(s.planes.size(), 2U);
  for (int v = 0; v < 60; ++v) {
    for (int u = 0; u < 80; ++u) {
      const Vector3d p = static_cast<double>(image.at(u, v)) * testing::ray(image.camera, u, v);
      const double d1 = std::abs(s.planes[0].plane.signed_distance(p));
      const double d2 = std::abs(s.planes[1].plane.signed_distance(p));
      if (std::abs(d1 - d2) < 1e-6 || std::abs(std::min(d1, d2) - 0.03) < 1e-6) continue;
      const int expected = std::min(d1, d2) > 0.03 ? kLabelNoPlane : d1 < d2 ? 1 : 2;
      ASSERT_EQ(s.labels[static_cast<std::size_t>(v * 80 + u)], expected);
    }
  }
}

TEST(Segment, AreaOrderPutsTheLargerPlaneFirst) {
  // A wall 4 m away on the right has fewer pixels than one at 1 m on the left, but more square metres.
  FloatImage image(testing::small_camera());
  image.draw(*make_plane({0, 0, -1}, 1.0), 0, 50);
  image.draw(*make_plane({0, 0, -1}, 4.0), 50, 80);
  SegmentOptions options = options_for(Method::ransac);
  options.max_planes = 0;
  const Segmentation by_support = segmented(image, options);
  options.order = PlaneOrder::area;
  const Segmentation by_area = segmented(image, options);
  ASSERT_EQ(by_support.planes.size(), 2U);
  ASSERT_EQ(by_area.planes.size(), 2U);
  EXPECT_NEAR(by_support.planes[0].plane.d, 1.0, 1e-6);
  EXPECT_NEAR(by_area.planes[0].plane.d, 4.0, 1e-6);
  for (std::size_t i = 0; i < 2; ++i) {
    EXPECT_EQ(by_area.planes[i].id, static_cast<int>(i) + 1);
    EXPECT_EQ(by_area.planes[i].inliers, by_support.planes[1 - i].inliers);
    EXPECT_EQ(count(by_area, by_area.planes[i].id), by_area.planes[i].inliers);
  }
  options.order = PlaneOrder::support;
  testing::expect_same(segmented(image, options), by_support);
}

TEST(Segment, SmallAreasAreLeftOut) {
  FloatImage image(testing::small_camera());
  image.draw(*make_plane({0, 0, -1}, 1.0), 0, 50);
  image.draw(*make_plane({0, 0, -1}, 4.0), 50, 80);
  PointCloud points;
  deproject(image.view(), image.camera, points);
  for (const bool cloud : {false, true}) {
    SegmentOptions options = options_for(Method::ransac);
    options.max_planes = 0;
    options.cells.min_area_m2 = 2.0;  // the near wall has 0.6, the far one 5.7
    const Segmentation s = cloud ? segmented(points, options) : segmented(image, options);
    ASSERT_EQ(s.planes.size(), 1U);
    EXPECT_NEAR(s.planes[0].plane.d, 4.0, 1e-6);
    EXPECT_EQ(s.planes[0].id, 1);
    EXPECT_EQ(count(s, 1), 30U * 60U);
    EXPECT_EQ(count(s, kLabelNoPlane), 50U * 60U);
  }
}

// ---- labels ----

TEST(Segment, LabelsFromLeavesAreTheLeafsLabel) {
  // A wall, and steps of growing height on it. A pixel's leaf decides, not the pixel: on the steps the two ways differ.
  FloatImage image(testing::small_camera());
  image.draw(*make_plane({0, 0, -1}, 0.515));
  for (int v = 0; v < 60; ++v) {
    for (int u = 60; u < 80; ++u) image.at(u, v) = 0.515F - 0.003F * static_cast<float>(u - 59);
  }
  SegmentOptions options = options_for(Method::voxel_ransac);
  const Segmentation pixels = segmented(image, options);
  options.labels_from = LabelsFrom::leaves;
  const Segmentation leaves = segmented(image, options);
  ASSERT_EQ(leaves.planes.size(), 1U);
  EXPECT_EQ(leaves.planes[0].plane.normal, pixels.planes[0].plane.normal);
  EXPECT_EQ(leaves.planes[0].plane.d, pixels.planes[0].plane.d);
  EXPECT_NE(leaves.labels, pixels.labels);
  EXPECT_EQ(leaves.planes[0].inliers, count(leaves, 1));

  PointCloud cloud;
  deproject(image.view(), image.camera, cloud);
  VoxelGrid grid;
  ASSERT_TRUE(voxel_grid(cloud, options.voxel_grid.leaf_size_m, LeafPoint::centroid, grid));
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const double distance = std::abs(leaves.planes[0].plane.signed_distance(grid.leaves.point(grid.leaf_of[i])));
    ASSERT_EQ(leaves.labels[cloud.source[i]], distance <= 0.01 ? kLabelFirst : kLabelNoPlane);
  }
}

TEST(Segment, LabelsFromLeavesWithoutAGridAreLabelsFromPixels) {
  const TwoPlanes scene;
  SegmentOptions options = options_for(Method::ransac);
  const Segmentation pixels = segmented(scene.image, options);
  options.labels_from = LabelsFrom::leaves;
  testing::expect_same(segmented(scene.image, options), pixels);
}

TEST(Segment, BeyondTheLimitsNothingIsLabelled) {
  // One plane that reaches through the limits: the part outside belongs to it and is still 255.
  FloatImage image(testing::small_camera());
  const Plane plane = *make_plane({0.4, 0.0, -1.0}, 2.0);
  image.draw(plane);
  image.at(3, 4) = 0.0F;
  for (const bool outside : {false, true}) {
    for (const LabelsFrom labels_from : {LabelsFrom::pixels, LabelsFrom::leaves}) {
      SegmentOptions options = options_for(Method::fransac);
      options.pass_through.limits = {.axis = Axis::z, .min_m = 1.8, .max_m = 2.3, .outside = outside};
      options.labels_from = labels_from;
      const Segmentation s = segmented(image, options);
      for (int v = 0; v < 60; ++v) {
        for (int u = 0; u < 80; ++u) {
          const double z = static_cast<double>(image.at(u, v));
          const bool kept = (z >= 1.8 && z <= 2.3) != outside;
          const int expected = z == 0.0 ? kLabelNoDepth : kept ? kLabelFirst : kLabelNoPlane;
          ASSERT_EQ(s.labels[static_cast<std::size_t>(v * 80 + u)], expected) << "z = " << z;
        }
      }
      EXPECT_EQ(s.planes[0].inliers, count(s, 1));
    }
  }
}

TEST(Segment, ChosenLimitsSwitchThePassThroughOn) {
  FloatImage image(testing::small_camera());
  image.draw(*make_plane({0.4, 0.0, -1.0}, 2.0));
  for (const Method method : kMethods) {
    SegmentOptions options = options_for(method);
    EXPECT_EQ(count(segmented(image, options), kLabelFirst), 4800U);
    options.pass_through.limits.max_m = 2.0;
    EXPECT_LT(count(segmented(image, options), kLabelFirst), 4000U) << enum_name(method);
    options.pass_through.use = false;
    EXPECT_EQ(count(segmented(image, options), kLabelFirst), 4800U) << enum_name(method);
  }
}

TEST(Segment, LimitsAlongXAndYLabelTheSamePixelsTheyFilter) {
  FloatImage image(testing::small_camera());
  image.draw(*make_plane({0.1, -0.2, -1.0}, 1.5));
  for (const Axis axis : {Axis::x, Axis::y}) {
    SegmentOptions options = options_for(Method::ransac);
    options.pass_through.use = true;
    options.pass_through.limits = {.axis = axis, .min_m = -0.21, .max_m = 0.33, .outside = false};
    const Segmentation s = segmented(image, options);
    // The label and the filter compute the coordinate in different ways: they may differ within a rounding of a limit only.
    EXPECT_NEAR(static_cast<double>(count(s, 1)), static_cast<double>(s.sampled_points), 1.0);
    EXPECT_EQ(count(s, 1) + count(s, kLabelNoPlane), 4800U);
  }
}

TEST(Segment, PixelsWithoutDepthAreNoPointsAtTheOrigin) {
  // 60 % of the frame without depth, a small wall, and noise elsewhere. Were the zeros points at the origin, every plane
  // through it would have more support than the wall.
  RandomStream random = testing::test_random();
  const Camera camera = testing::small_camera();
  std::vector<std::uint16_t> pixels(4800);
  for (std::size_t i = 0; i < pixels.size(); ++i) {
    if (i % 5 < 3) continue;
    const std::size_t v = i / 80;
    pixels[i] = v < 20 ? std::uint16_t{1500} : static_cast<std::uint16_t>(500 + random.below(3500));
  }
  const DepthView depth = DepthView::from_uint16(pixels.data(), 80, 60, 1000.0);
  for (const Method method : kMethods) {
    const Segmentation s = segmented(depth, camera, options_for(method));
    EXPECT_EQ(s.valid_points, 1920U);
    EXPECT_EQ(count(s, kLabelNoDepth), 2880U);
    ASSERT_EQ(s.planes.size(), 1U);
    EXPECT_LT(angle_between(s.planes[0].plane, {Vector3d::UnitZ(), 0.0}), 0.01) << enum_name(method);
    EXPECT_NEAR(s.planes[0].plane.d, 1.5, 0.005) << enum_name(method);
    for (std::size_t i = 0; i < pixels.size(); ++i) ASSERT_EQ(s.labels[i] == kLabelNoDepth, pixels[i] == 0);
  }
}

TEST(Segment, CloudPointsAtInvalidPlacesGetLabelZero) {
  std::vector<Vector3d> points;
  for (int v = 0; v < 20; ++v) {
    for (int u = 0; u < 30; ++u) points.emplace_back(0.1 * u, 0.1 * v, (u + v) % 3 == 0 ? kNaN : 2.0);
  }
  points[7].x() = kInf;
  PointCloud cloud = testing::cloud_of(points);
  cloud.width = 30;
  cloud.height = 20;
  for (const Method method : kMethods) {
    const Segmentation s = segmented(cloud, options_for(method));
    EXPECT_EQ(s.width, 30);
    EXPECT_EQ(s.height, 20);
    for (std::size_t i = 0; i < points.size(); ++i) ASSERT_EQ(s.labels[i], cloud.finite(i) ? kLabelFirst : kLabelNoDepth);
  }
}

// ---- the same answer ----

TEST(Segment, FloatAndUint16DepthAgree) {
  RandomStream random = testing::test_random();
  const TwoPlanes scene;
  std::vector<std::uint16_t> raw(4800);
  FloatImage image(scene.image.camera);
  // A scale that is a power of two, so that both formats hold the very same depth.
  for (std::size_t i = 0; i < raw.size(); ++i) {
    raw[i] = static_cast<std::uint16_t>(std::lround(static_cast<double>(scene.image.metres[i]) * 4096.0) + random.below(9));
    image.metres[i] = static_cast<float>(raw[i]) / 4096.0F;
  }
  for (const Method method : kMethods) {
    SegmentOptions options = options_for(method);
    options.max_planes = 0;
    const Segmentation of_units = segmented(DepthView::from_uint16(raw.data(), 80, 60, 4096.0), image.camera, options);
    const Segmentation of_metres = segmented(image, options);
    if (method == Method::ransac || method == Method::rransac) {
      testing::expect_same(of_units, of_metres);
      continue;
    }
    // The voxel grid adds up 16-bit depth in its own units, float depth in multiples of 2^-24 of the largest.
    EXPECT_EQ(of_units.labels, of_metres.labels);
    EXPECT_EQ(of_units.sampled_points, of_metres.sampled_points);
    EXPECT_EQ(of_units.iterations, of_metres.iterations);
    ASSERT_EQ(of_units.planes.size(), of_metres.planes.size());
    for (std::size_t i = 0; i < of_units.planes.size(); ++i) {
      EXPECT_LT(angle_between(of_units.planes[i].plane, of_metres.planes[i].plane), 1e-6);
      EXPECT_NEAR(of_units.planes[i].plane.d, of_metres.planes[i].plane.d, 1e-6);
      EXPECT_EQ(of_units.planes[i].support, of_metres.planes[i].support);
    }
  }
}

TEST(Segment, RowStrideChangesNothing) {
  const TwoPlanes scene;
  std::vector<float> padded(100 * 60, -7.0F);
  for (int v = 0; v < 60; ++v) std::copy_n(scene.image.metres.begin() + 80 * v, 80, padded.begin() + 100 * v);
  const SegmentOptions options;
  testing::expect_same(segmented(DepthView::from_float(padded.data(), 80, 60, 400), scene.image.camera, options),
                       segmented(scene.image, options));
}

TEST(Segment, ReusedWorkspaceAndThreadsChangeNothing) {
  RandomStream random = testing::test_random();
  std::vector<FloatImage> images;
  for (const int width : {80, 33, 120}) {  // growing and shrinking buffers
    FloatImage& image = images.emplace_back(testing::small_camera(width, 45));
    image.draw(*make_plane({0.3, -0.2, -1.0}, 1.4), 0, width / 2);
    image.draw(*make_plane({-0.1, -0.5, -1.0}, 1.8), width / 2, width);
    for (float& z : image.metres) z += static_cast<float>(0.004 * random.normal());
    for (int i = 0; i < 300; ++i) image.metres[random.below(static_cast<std::uint32_t>(image.metres.size()))] = 0.0F;
  }
  Workspace workspace;
  Segmentation reused;
  for (const Method method : kMethods) {
    for (const FloatImage& image : images) {
      SegmentOptions options = options_for(method);
      options.max_planes = 3;
      options.ransac.max_iterations = 200;
      const Segmentation fresh = segmented(image, options);
      for (const int threads : {1, 2, 5, 0}) {
        options.threads = threads;
        ASSERT_TRUE(segment(image.view(), image.camera, options, workspace, reused));
        testing::expect_same(reused, fresh);
      }
    }
  }
}

TEST(Segment, WorkspaceSurvivesErrors) {
  const TwoPlanes scene;
  const SegmentOptions options;
  const Segmentation fresh = segmented(scene.image, options);
  Workspace workspace;
  Segmentation s;
  const FloatImage empty(scene.image.camera);
  for (int i = 0; i < 3; ++i) {
    EXPECT_FALSE(segment(empty.view(), empty.camera, options, workspace, s));
    EXPECT_TRUE(s.planes.empty());
    ASSERT_TRUE(segment(scene.image.view(), scene.image.camera, options, workspace, s));
    testing::expect_same(s, fresh);
  }
}

TEST(Segment, SeedsDrawDifferentSamples) {
  RandomStream random = testing::test_random();
  FloatImage image(testing::small_camera());
  image.draw(*make_plane({0.2, -0.3, -1.0}, 1.5));
  for (float& z : image.metres) z += static_cast<float>(0.02 * random.normal());
  SegmentOptions options = options_for(Method::ransac);
  options.ransac.refine = options.ransac.local_optimisation = false;
  const Segmentation a = segmented(image, options);
  options.seed = 1;
  EXPECT_NE(segmented(image, options).planes[0].plane.normal, a.planes[0].plane.normal);
}

TEST(Segment, DepthImageAndItsCloudAgree) {
  // The cloud holds one point per pixel, unorganised with a source of its own, or organised.
  const TwoPlanes scene;
  PointCloud list;
  deproject(scene.image.view(), scene.image.camera, list);
  PointCloud organised;
  organised.resize(4800);
  organised.width = 80;
  organised.height = 60;
  for (std::size_t i = 0; i < list.size(); ++i) organised.set(list.source[i], list.local(i).cast<float>());

  for (const Method method : kMethods) {
    for (const LabelsFrom labels_from : {LabelsFrom::pixels, LabelsFrom::leaves}) {
      SegmentOptions options = options_for(method);
      options.max_planes = 2;
      options.labels_from = labels_from;
      const Segmentation image = segmented(scene.image, options);
      const Segmentation from_organised = segmented(organised, options);
      EXPECT_EQ(from_organised.labels, image.labels);
      EXPECT_EQ(from_organised.planes[0].plane.normal, image.planes[0].plane.normal);
      const Segmentation from_list = segmented(list, options);
      EXPECT_EQ(from_list.width, static_cast<int>(list.size()));
      EXPECT_EQ(from_list.height, 1);
      ASSERT_EQ(from_list.labels.size(), list.size());
      for (std::size_t i = 0; i < list.size(); ++i) ASSERT_EQ(from_list.labels[i], image.labels[list.source[i]]);
    }
  }
}

TEST(Segment, AFilteredCloudsLabelsAreItsOwn) {
  // The cloud's `source` names pixels of an image that is not there: far beyond the labels.
  std::vector<Vector3d> points;
  for (int i = 0; i < 400; ++i) points.emplace_back(0.1 * (i % 20), 0.1 * (i / 20), 2.0);
  PointCloud cloud = testing::cloud_of(points);
  for (std::uint32_t i = 0; i < 400; ++i) cloud.source.push_back(1000000 + i);
  for (const LabelsFrom labels_from : {LabelsFrom::pixels, LabelsFrom::leaves}) {
    SegmentOptions options = options_for(Method::voxel_ransac);
    options.labels_from = labels_from;
    EXPECT_THAT(segmented(cloud, options).labels, Each(kLabelFirst));
  }
}

TEST(Segment, CloudWithAnOrigin) {
  // The same room near zero and in UTM coordinates: the same labels, the plane moved with the origin.
  const TwoPlanes scene;
  PointCloud near;
  deproject(scene.image.view(), scene.image.camera, near);
  PointCloud far = near;
  far.origin = {5e5, 5.4e6, 200.0};
  for (const Method method : kMethods) {
    SegmentOptions options = options_for(method);
    options.max_planes = 2;
    const Segmentation a = segmented(near, options);
    const Segmentation b = segmented(far, options);
    ASSERT_EQ(b.planes.size(), a.planes.size());
    EXPECT_EQ(a.labels, b.labels);
    for (std::size_t i = 0; i < a.planes.size(); ++i) {
      EXPECT_LT(angle_between(a.planes[i].plane, b.planes[i].plane), 1e-12);
      EXPECT_EQ(a.planes[i].inliers, b.planes[i].inliers);
      EXPECT_NEAR(a.planes[i].rms_m, b.planes[i].rms_m, 1e-8);
      EXPECT_NEAR(a.planes[i].area_m2, b.planes[i].area_m2, 1e-9);
      const Vector3d on_plane = -a.planes[i].plane.d * a.planes[i].plane.normal + far.origin;
      EXPECT_NEAR(b.planes[i].plane.signed_distance(on_plane), 0.0, 1e-8);
    }
  }
}

TEST(Segment, LimitsOfACloudAreInItsCoordinates) {
  std::vector<Vector3d> points;
  for (int i = 0; i < 400; ++i) points.emplace_back(0.1 * (i % 20), 0.1 * (i / 20), 0.0);
  SegmentOptions options = options_for(Method::fransac);
  options.pass_through.use = true;
  options.pass_through.limits = {.axis = Axis::y, .min_m = 5400000.45, .max_m = 5400000.95, .outside = false};
  const Segmentation s = segmented(testing::cloud_of(points, {5e5, 5.4e6, 200.0}), options);
  EXPECT_EQ(count(s, 1), 100U);
  for (std::size_t i = 0; i < 400; ++i) EXPECT_EQ(s.labels[i] == kLabelFirst, i / 20 >= 5 && i / 20 <= 9) << i;
}

// ---- errors ----

struct BadCase {
  const char* what;
  std::function<void(SegmentOptions&)> spoil;
};

TEST(SegmentErrors, AbsurdOptionsAreNamed) {
  const TwoPlanes scene;
  const BadCase cases[] = {
      {"method", [](SegmentOptions& o) { o.method = static_cast<Method>(99); }},
      {"method", [](SegmentOptions& o) { o.method = static_cast<Method>(-1); }},
      {"planes", [](SegmentOptions& o) { o.max_planes = -1; }},
      {"planes", [](SegmentOptions& o) { o.max_planes = kMaxPlanes + 1; }},
      {"min-support", [](SegmentOptions& o) { o.min_support = -0.1; }},
      {"min-support", [](SegmentOptions& o) { o.min_support = 1.1; }},
      {"min-support", [](SegmentOptions& o) { o.min_support = kNaN; }},
      {"order", [](SegmentOptions& o) { o.order = static_cast<PlaneOrder>(2); }},
      {"min-area", [](SegmentOptions& o) { o.cells.min_area_m2 = -1.0; }},
      {"min-area", [](SegmentOptions& o) { o.cells.min_area_m2 = kInf; }},
      {"sensor", [](SegmentOptions& o) { o.sensor.kind = static_cast<SensorKind>(9); }},
      {"sensor-param bias", [](SegmentOptions& o) { o.sensor.bias_m = -0.01; }},
      {"sensor-param baseline", [](SegmentOptions& o) { o.sensor = {.kind = SensorKind::stereo, .baseline_m = kNaN}; }},
      {"sensor-param linear", [](SegmentOptions& o) { o.sensor = {.linear = 0.01}; }},
      {"sensor-param slow", [](SegmentOptions& o) { o.sensor.slow = 10.5; }},
      {"min-confidence", [](SegmentOptions& o) { o.cells.min_confidence = -0.01; }},
      {"min-confidence", [](SegmentOptions& o) { o.cells.min_confidence = 1.01; }},
      {"min-confidence", [](SegmentOptions& o) { o.cells.min_confidence = kNaN; }},
      {"sensor-position", [](SegmentOptions& o) { o.sensor_position = Vector3d(0, kNaN, 0); }},
      {"sensor-position", [](SegmentOptions& o) { o.sensor_position = Vector3d(0, 0, -1.01 * kMaxCoordinate_m); }},
      {"saturated", [](SegmentOptions& o) { o.saturated = -1; }},
      {"saturated", [](SegmentOptions& o) { o.saturated = 65536; }},
      {"parallel-to", [](SegmentOptions& o) { o.cells.parallel_to = Vector3d::Zero(); }},
      {"parallel-to", [](SegmentOptions& o) { o.cells.parallel_to = Vector3d(0, kNaN, 1); }},
      {"perpendicular-to", [](SegmentOptions& o) { o.cells.perpendicular_to = Vector3d(kInf, 0, 0); }},
      {"up", [](SegmentOptions& o) { o.up = Vector3d::Zero(); }},
      {"prior-angle", [](SegmentOptions& o) { o.cells.prior_angle_deg = 0.0; }},
      {"prior-angle", [](SegmentOptions& o) { o.cells.prior_angle_deg = 91.0; }},
      {"labels-from", [](SegmentOptions& o) { o.labels_from = static_cast<LabelsFrom>(7); }},
      {"threads", [](SegmentOptions& o) { o.threads = -1; }},
      {"threads", [](SegmentOptions& o) { o.threads = 1000000; }},
      {"pass-through-axis", [](SegmentOptions& o) { o.pass_through.limits.axis = static_cast<Axis>(3); }},
      {"pass-through-min", [](SegmentOptions& o) { o.pass_through.limits.min_m = -kInf; }},
      {"pass-through-min", [](SegmentOptions& o) { o.pass_through.limits.min_m = 5.0; }},
      {"pass-through-max", [](SegmentOptions& o) { o.pass_through.limits.max_m = kNaN; }},
      {"leaf-size", [](SegmentOptions& o) { o.voxel_grid.leaf_size_m = 0.0; }},
      {"leaf-size", [](SegmentOptions& o) { o.voxel_grid.leaf_size_m = -0.02; }},
      {"leaf-size", [](SegmentOptions& o) { o.voxel_grid.leaf_size_m = kInf; }},
      {"leaf-point", [](SegmentOptions& o) { o.voxel_grid.leaf_point = static_cast<LeafPoint>(2); }},
      {"threshold", [](SegmentOptions& o) { o.ransac.threshold_m = 0.0; }},
      {"threshold", [](SegmentOptions& o) { o.ransac.threshold_m = kNaN; }},
      {"threshold", [](SegmentOptions& o) { o.ransac.threshold_m = kInf; }},
      {"probability", [](SegmentOptions& o) { o.ransac.probability = 0.0; }},
      {"probability", [](SegmentOptions& o) { o.ransac.probability = 1.0; }},
      {"max-iterations", [](SegmentOptions& o) { o.ransac.max_iterations = 0; }},
      {"pretest-points", [](SegmentOptions& o) { o.ransac.pretest_points = -1; }},
      {"pretest-points", [](SegmentOptions& o) { o.ransac.pretest_points = 101; }},
      {"scoring", [](SegmentOptions& o) { o.ransac.scoring = static_cast<sac::Scoring>(5); }},
  };
  for (const BadCase& bad : cases) {
    SegmentOptions options;
    bad.spoil(options);
    const auto result = segment(scene.image.view(), scene.image.camera, options);
    ASSERT_FALSE(result) << bad.what;
    EXPECT_EQ(result.error().code, ErrorCode::invalid_argument);
    EXPECT_THAT(result.error().message, HasSubstr(bad.what));
  }
}

TEST(Segment, UpTellsKindsWhateverTheMethod) {
  const TwoPlanes scene;
  for (const Method method : kMethods) {
    SegmentOptions options = options_for(method);
    options.max_planes = 0;
    EXPECT_FALSE(segmented(scene.image, options).up) << enum_name(method);
    options.up = Vector3d(0.0, 0.0, -2.0);  // the camera looks straight down
    const Segmentation found = segmented(scene.image, options);
    ASSERT_TRUE(found.up) << enum_name(method);
    EXPECT_EQ(*found.up, Vector3d(0.0, 0.0, -1.0));
    EXPECT_EQ(found.up_source, UpSource::given);
    ASSERT_EQ(found.planes.size(), 2U) << enum_name(method);
    for (const PlaneSegment& plane : found.planes) {
      const bool wall = plane.plane.normal.dot(scene.wall.normal) > 0.99;  // which is a floor to who looks down
      EXPECT_EQ(plane.kind, wall ? PlaneKind::floor : PlaneKind::other) << enum_name(method);
    }
  }
}

TEST(SegmentErrors, WhatOnlyCellsKnowsIsRefusedByTheOtherMethods) {
  const TwoPlanes scene;
  const BadCase cases[] = {
      {"parallel-to", [](SegmentOptions& o) { o.cells.parallel_to = Vector3d::UnitX(); }},
      {"perpendicular-to", [](SegmentOptions& o) { o.cells.perpendicular_to = Vector3d::UnitX(); }},
      {"residuals", [](SegmentOptions& o) { o.cells.residuals = true; }},
      {"min-confidence", [](SegmentOptions& o) { o.cells.min_confidence = 0.9; }},
  };
  for (const BadCase& asked : cases) {
    for (const Method method : kMethods) {
      SegmentOptions options = options_for(method);
      asked.spoil(options);
      const auto result = segment(scene.image.view(), scene.image.camera, options);
      ASSERT_FALSE(result) << asked.what;
      EXPECT_EQ(result.error().code, ErrorCode::invalid_argument);
      EXPECT_THAT(result.error().message, HasSubstr(asked.what));
      EXPECT_THAT(result.error().message, HasSubstr(std::string(enum_name(method))));
    }
    SegmentOptions options = options_for(Method::cells);
    asked.spoil(options);
    EXPECT_TRUE(validate(options)) << asked.what;
  }
}

TEST(SegmentOptions, WhatTheMethodDecides) {
  for (const Method method : kMethods) {
    const SegmentOptions options = with_defaults({}, method);
    EXPECT_EQ(options.max_planes, 1);
    EXPECT_EQ(options.min_support, 0.02);
    EXPECT_EQ(options.order, PlaneOrder::support);
  }
  const SegmentOptions cells = with_defaults({}, Method::cells);
  EXPECT_EQ(cells.max_planes, 0);
  EXPECT_EQ(cells.min_support, 0.002);
  EXPECT_EQ(cells.order, PlaneOrder::area);
  SegmentOptions chosen;
  chosen.max_planes = 5;
  chosen.min_support = 0.5;
  chosen.order = PlaneOrder::area;
  EXPECT_EQ(with_defaults(chosen, Method::ransac).max_planes, 5);
  EXPECT_EQ(with_defaults(chosen, Method::ransac).min_support, 0.5);
  EXPECT_EQ(with_defaults(chosen, Method::ransac).order, PlaneOrder::area);
}

TEST(SegmentErrors, EveryOptionIsListedOnceAndItsDefaultIsValid) {
  SegmentOptions options;
  std::set<std::string_view> names;
  int total = 0;
  for_each_option(options, [&](const OptionInfo& info, auto& /*value*/) {
    names.insert(info.name);
    ++total;
    EXPECT_FALSE(info.help.empty()) << info.name;
  });
  EXPECT_EQ(static_cast<int>(names.size()), total);
  EXPECT_TRUE(validate(options));
}

TEST(SegmentErrors, FramesWithoutEnoughPoints) {
  FloatImage image(testing::small_camera());
  const auto error = [&](const SegmentOptions& options) {
    const auto result = segment(image.view(), image.camera, options);
    return result ? Error{ErrorCode::unsupported, "no error"} : result.error();
  };
  for (const Method method : {Method::cells, Method::fransac}) {
    SegmentOptions options = options_for(method);
    image = FloatImage(image.camera);
    EXPECT_EQ(error(options).code, ErrorCode::no_data);
    EXPECT_THAT(error(options).message, HasSubstr("0 with a measurement"));
    image.at(5, 5) = 1.0F;
    EXPECT_THAT(error(options).message, HasSubstr("1 with a measurement"));
    image.at(6, 5) = 1.0F;
    EXPECT_THAT(error(options).message, HasSubstr("2 with a measurement"));
    image.draw(*make_plane({0, 0, -1}, 8.0));
    options.pass_through.use = true;  // the default of `fransac` alone
    EXPECT_EQ(error(options).code, ErrorCode::no_data);
    EXPECT_THAT(error(options).message, HasSubstr("pass-through"));
  }
  SegmentOptions coarse = options_for(Method::fransac);
  EXPECT_THAT(error(coarse).message, HasSubstr("pass-through"));
  coarse.pass_through.use = false;
  coarse.voxel_grid.leaf_size_m = 1000.0;
  image.draw(*make_plane({0, 0, -1}, 8.0));
  for (float& z : image.metres) z = std::abs(z);
  EXPECT_EQ(segment(image.view(), image.camera, coarse).ok(), true);  // four leaves meet at the optical axis
  coarse.voxel_grid.leaf_size_m = 1e-12;
  EXPECT_THAT(error(coarse).message, HasSubstr("leaf-size"));
}

TEST(SegmentErrors, TooFewLeaves) {
  std::vector<Vector3d> points;
  for (int i = 0; i < 100; ++i) points.emplace_back(0.01 * (i % 10) + 1.0, 0.01 * (i / 10) + 1.0, 1.0);
  SegmentOptions options = options_for(Method::voxel_ransac);
  options.voxel_grid.leaf_size_m = 10.0;
  const auto result = segment(testing::cloud_of(points), options);
  ASSERT_FALSE(result);
  EXPECT_EQ(result.error().code, ErrorCode::no_data);
  EXPECT_THAT(result.error().message, HasSubstr("leaf-size"));
}

TEST(SegmentErrors, CollinearOrCoincidingPoints) {
  for (const Vector3d& step : {Vector3d(0.1, 0.2, -0.05), Vector3d(0, 0, 0)}) {
    std::vector<Vector3d> points;
    for (int i = 0; i < 50; ++i) points.emplace_back(Vector3d(1, 2, 3) + i * step);
    for (const Method method : {Method::ransac, Method::rransac}) {
      const auto result = segment(testing::cloud_of(points), options_for(method));
      ASSERT_FALSE(result);
      EXPECT_EQ(result.error().code, ErrorCode::no_data);
      EXPECT_THAT(result.error().message, HasSubstr("collinear"));
    }
  }
}

TEST(SegmentErrors, CameraAndViewAreChecked) {
  const TwoPlanes scene;
  Camera camera = scene.image.camera;
  camera.width = 81;
  auto result = segment(scene.image.view(), camera);
  ASSERT_FALSE(result);
  EXPECT_THAT(result.error().message, HasSubstr("81 x 60"));
  camera = scene.image.camera;
  camera.fy = 0.0;
  result = segment(scene.image.view(), camera);
  ASSERT_FALSE(result);
  EXPECT_THAT(result.error().message, HasSubstr("fy"));
  result = segment(DepthView::from_float(nullptr, 80, 60), scene.image.camera);
  ASSERT_FALSE(result);
  EXPECT_THAT(result.error().message, HasSubstr("null"));
}

TEST(SegmentErrors, AnErrorLeavesNoPlanesOfTheFrameBefore) {
  const std::vector<float> wall(80 * 60, 2.0F);
  const std::vector<float> nothing(80 * 60, 0.0F);
  const Camera camera{80, 60, 60.0, 60.0, 39.5, 29.5};
  Workspace workspace;
  Segmentation result;
  for (const Method method : {Method::cells, Method::fransac}) {
    const SegmentOptions options = options_for(method);
    ASSERT_TRUE(segment(DepthView::from_float(wall.data(), 80, 60), camera, options, workspace, result));
    ASSERT_EQ(result.planes.size(), 1U);
    if (method == Method::fransac) {
      EXPECT_GT(result.planes[0].iterations, 0U);
      EXPECT_EQ(result.planes[0].stop_reason, StopReason::confidence);
    }
    for (const auto& [data, width] : {std::pair{nothing.data(), 80}, std::pair{wall.data(), 79}}) {
      ASSERT_TRUE(segment(DepthView::from_float(wall.data(), 80, 60), camera, options, workspace, result));
      EXPECT_FALSE(segment(DepthView::from_float(data, width, 60), camera, options, workspace, result));
      EXPECT_TRUE(result.planes.empty());
      EXPECT_TRUE(result.labels.empty());
    }
  }
}

TEST(SegmentErrors, MalformedClouds) {
  PointCloud cloud;
  EXPECT_EQ(segment(cloud).error().code, ErrorCode::no_data);
  cloud = testing::cloud_of({{0, 0, 1}, {1, 0, 1}, {0, 1, 1}, {1, 1, 1}});
  cloud.width = 3;
  cloud.height = 2;
  ASSERT_FALSE(segment(cloud));
  EXPECT_THAT(segment(cloud).error().message, HasSubstr("width x height"));
  cloud.width = 2;
  cloud.origin.y() = kNaN;
  ASSERT_FALSE(segment(cloud));
  EXPECT_THAT(segment(cloud).error().message, HasSubstr("origin"));
}

/// Whatever comes in: an error with a message, or finite planes and labels of the right size.
void expect_sane(const Result<Segmentation>& result) {
  if (!result) {
    EXPECT_FALSE(result.error().message.empty());
    return;
  }
  EXPECT_EQ(result->labels.size(), static_cast<std::size_t>(result->width) * static_cast<std::size_t>(result->height));
  for (const PlaneSegment& plane : result->planes) {
    EXPECT_TRUE(plane.plane.normal.allFinite());
    EXPECT_NEAR(plane.plane.normal.norm(), 1.0, 1e-9);
    EXPECT_TRUE(std::isfinite(plane.plane.d));
    EXPECT_TRUE(std::isfinite(plane.rms_m));
    EXPECT_GE(plane.area_m2, 0.0);
    EXPECT_TRUE(std::isfinite(plane.area_m2));
    EXPECT_EQ(plane.inliers, count(*result, plane.id));
  }
}

TEST(SegmentErrors, HostileNumbersEndInAnErrorOrASaneAnswer) {
  constexpr float kHuge = std::numeric_limits<float>::max();
  constexpr float kTiny = std::numeric_limits<float>::denorm_min();
  FloatImage flat(testing::small_camera(32, 24));
  FloatImage mixed(testing::small_camera(32, 24));
  RandomStream random = testing::test_random();
  const float values[] = {kHuge, 1e30F, 1e20F, 1e10F, 1.0F, 2.0F, kTiny, 1e-30F, 0.0F, -1.0F};
  for (float& z : mixed.metres) z = values[random.below(10)];
  for (const Method method : kMethods) {
    for (const bool limited : {false, true}) {
      SegmentOptions options = options_for(method);
      options.max_planes = 3;
      options.pass_through.use = limited;
      options.ransac.max_iterations = 50;
      for (const float z : {kHuge, 1e30F, 1e19F, 1e10F, 1e-20F, kTiny}) {
        std::fill(flat.metres.begin(), flat.metres.end(), z);
        expect_sane(segment(flat.view(), flat.camera, options));
      }
      expect_sane(segment(mixed.view(), mixed.camera, options));
      std::fill(flat.metres.begin(), flat.metres.end(), 1.0F);
      for (const double extreme : {1e-300, 1e-40, 1e-10, 1e10, 1e40, 1e300}) {
        Camera camera = flat.camera;
        camera.fx = extreme;
        expect_sane(segment(flat.view(), camera, options));
        camera.fy = extreme;
        expect_sane(segment(flat.view(), camera, options));
        camera = flat.camera;
        camera.cx = -extreme;
        expect_sane(segment(flat.view(), camera, options));
      }
      for (const double extreme : {1e-300, 1e-9, 1e9, 1e300}) {
        SegmentOptions odd = options;
        odd.ransac.threshold_m = extreme;
        expect_sane(segment(flat.view(), flat.camera, odd));
        odd = options;
        odd.voxel_grid.leaf_size_m = extreme;
        expect_sane(segment(flat.view(), flat.camera, odd));
        PointCloud cloud;
        deproject(flat.view(), flat.camera, cloud);
        expect_sane(segment(cloud, odd));
      }
    }
  }
}

}  // namespace
}  // namespace fransac
