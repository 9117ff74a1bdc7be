// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numbers>
#include <numeric>
#include <vector>

#include "fransac/obstacles/obstacles.hpp"
#include "obstacles/clusters.hpp"
#include "support.hpp"

namespace fransac {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

/// The clusters of every pair of points, numbered by their first points.
std::vector<std::uint32_t> slow_clusters(const std::vector<Eigen::Vector3f>& points, double distance_m) {
  std::vector<std::uint32_t> of(points.size(), 0xFFFFFFFF);
  std::uint32_t count = 0;
  for (std::size_t first = 0; first < points.size(); ++first) {
    if (of[first] != 0xFFFFFFFF) continue;
    std::vector<std::size_t> queue{first};
    of[first] = count;
    for (std::size_t head = 0; head < queue.size(); ++head) {
      for (std::size_t i = 0; i < points.size(); ++i) {
        const bool near = (points[i].cast<double>() - points[queue[head]].cast<double>()).norm() <= distance_m;
        if (of[i] != 0xFFFFFFFF || !near) continue;
        of[i] = count;
        queue.push_back(i);
      }
    }
    ++count;
  }
  return of;
}

std::vector<Eigen::Vector3f> random_points(std::size_t count, double side) {
  RandomStream random = testing::test_random();
  std::vector<Eigen::Vector3f> points;
  for (std::size_t i = 0; i < count; ++i) points.push_back(testing::uniform_point(random, -side, side).cast<float>());
  return points;
}

TEST(Clusters, AreThoseOfAllPairsOfPoints) {
  const std::vector<Eigen::Vector3f> points = random_points(700, 1.0);
  std::size_t several = 0;
  for (const double distance : {0.01, 0.05, 0.1, 0.13, 0.15, 0.17, 0.2, 0.25, 0.4, 3.0}) {
    const auto clusters = obstacles::find_clusters(points, distance);
    ASSERT_TRUE(clusters.ok());
    EXPECT_EQ(clusters->of_point, slow_clusters(points, distance)) << distance;
    several += static_cast<std::size_t>(clusters->count > 1 && clusters->count < points.size());
  }
  EXPECT_GE(several, 5U);
}

TEST(Clusters, OfManyPointsInNeighbouringCubesAreFoundWithoutAllPairs) {
  // Two walls of 40,000 points each, a little more than the distance apart: 1.6e9 pairs. One point between them joins them.
  std::vector<Eigen::Vector3f> points;
  for (int i = 0; i < 200; ++i) {
    for (int k = 0; k < 200; ++k) {
      const Eigen::Vector3f p(0.0F, static_cast<float>(i) * 1e-3F, static_cast<float>(k) * 1e-3F);
      points.push_back(p);
      points.emplace_back(p + Eigen::Vector3f(1.001F, 0.0F, 0.0F));
    }
  }
  const auto apart = obstacles::find_clusters(points, 1.0);
  ASSERT_TRUE(apart.ok());
  EXPECT_EQ(apart->count, 2U);
  points.emplace_back(0.5F, 0.1F, 0.1F);
  EXPECT_EQ(obstacles::find_clusters(points, 1.0).value().count, 1U);
}

TEST(Clusters, AChainHoldsAtTheDistanceAndNotBelow) {
  std::vector<Eigen::Vector3f> chain;
  for (int i = 0; i < 1000; ++i) chain.emplace_back(0.25F * static_cast<float>(i), 0.0F, 0.0F);
  EXPECT_EQ(obstacles::find_clusters(chain, 0.2501).value().count, 1U);
  EXPECT_EQ(obstacles::find_clusters(chain, 0.2499).value().count, 1000U);
}

TEST(Clusters, OfNoPointsAndOfOnePoint) {
  EXPECT_EQ(obstacles::find_clusters({}, 0.1).value().count, 0U);
  EXPECT_EQ(obstacles::find_clusters({Eigen::Vector3f(1.0F, 2.0F, 3.0F)}, 0.1).value().count, 1U);
  EXPECT_EQ(obstacles::find_clusters({Eigen::Vector3f(1.0F, 2.0F, 3.0F)}, 5e-324).value().count, 1U);
}

TEST(Clusters, OfDuplicatesAreOne) {
  std::vector<Eigen::Vector3f> points(100000, Eigen::Vector3f(0.1F, 0.2F, 0.3F));
  points.insert(points.end(), 100000, Eigen::Vector3f(0.1F, 0.2F, 0.5F));
  const auto clusters = obstacles::find_clusters(points, 0.19);
  ASSERT_TRUE(clusters.ok());
  EXPECT_EQ(clusters->count, 2U);
  EXPECT_EQ(clusters->of_point.front(), 0U);
  EXPECT_EQ(clusters->of_point.back(), 1U);
}

TEST(Clusters, OfPointsAtTheEndsOfTheWorld) {
  constexpr float kMost = std::numeric_limits<float>::max();
  const std::vector<Eigen::Vector3f> points{{-kMost, kMost, 0.0F}, {kMost, -kMost, 0.0F}, {1.0F, 0.0F, 0.0F}, {1.5F, 0.0F, 0.0F}};
  const auto refused = obstacles::find_clusters(points, 1.0);
  ASSERT_FALSE(refused.ok());
  EXPECT_THAT(refused.error().message, HasSubstr("cluster-distance"));
  EXPECT_THAT(obstacles::find_clusters(points, 1e30).value().of_point, ElementsAre(0, 1, 2, 2));
  const std::vector<Eigen::Vector3f> far{{-1e6F, 0.0F, 0.0F}, {1e6F, 0.0F, 0.0F}, {1e6F, 0.0F, 1e6F}};
  EXPECT_EQ(obstacles::find_clusters(far, 0.01).value().count, 3U);
}

/// A segmented cloud in a camera's optical frame: a floor 1 m under the camera as a lattice of points 2 cm apart, and what is
/// put on it.
struct Scene {
  static constexpr double kSpacing = 0.02;

  Scene() {
    for (int i = -50; i < 50; ++i) {
      for (int k = 0; k < 100; ++k) add({kSpacing * (i + 0.5), 1.0, 1.0 + kSpacing * (k + 0.5)}, 1);
    }
    segmentation.planes.push_back(
        {.id = 1, .plane = {-Eigen::Vector3d::UnitY(), 1.0}, .inliers = points.size(), .kind = PlaneKind::floor, .area_m2 = 4.0});
    segmentation.up = -Eigen::Vector3d::UnitY();
    segmentation.up_source = UpSource::given;
    segmentation.sensor_position = Eigen::Vector3d::Zero();
  }

  void add(const Eigen::Vector3d& point, std::uint8_t label = kLabelNoPlane) {
    points.push_back(point);
    segmentation.labels.push_back(label);
  }
  /// A block of points 1 cm apart; `low` is its corner nearest to the camera, to the left and at its foot.
  void add_block(const Eigen::Vector3d& low, int nx, int ny, int nz, std::uint8_t label = kLabelNoPlane) {
    for (int i = 0; i < nx; ++i) {
      for (int j = 0; j < ny; ++j) {
        for (int k = 0; k < nz; ++k) add(low + 0.01 * Eigen::Vector3d(i, -j, k), label);
      }
    }
  }
  [[nodiscard]] PointCloud cloud() const { return testing::cloud_of(points); }
  Result<Obstacles> find(const ObstacleOptions& options = {}, const AxisLimits* limits = nullptr) {
    segmentation.width = static_cast<int>(points.size());
    segmentation.height = 1;
    return find_obstacles(cloud(), segmentation, options, limits);
  }

  std::vector<Eigen::Vector3d> points;
  Segmentation segmentation;
};

TEST(CloudObstacles, TwoBoxesAGapApartAreTwoNearestFirst) {
  Scene scene;
  const std::size_t floor = scene.points.size();
  scene.add_block({0.5, 0.99, 2.0}, 11, 21, 31);   // the far one
  scene.add_block({0.39, 0.99, 1.5}, 11, 11, 49);  // 1.5 to 1.98 m ahead
  scene.add_block({-0.5, 0.50, 1.2}, 5, 5, 5);     // hangs
  const auto found = scene.find({.cluster_distance_m = 0.02});
  ASSERT_TRUE(found.ok());
  ASSERT_EQ(found->obstacles.size(), 3U);
  EXPECT_THAT(found->support, ElementsAre(1));
  EXPECT_EQ(found->width, static_cast<int>(scene.points.size()));
  EXPECT_EQ(found->height, 1);
  EXPECT_TRUE(std::all_of(found->labels.begin(), found->labels.begin() + static_cast<std::ptrdiff_t>(floor),
                          [](std::uint16_t id) { return id == 0; }));
  EXPECT_EQ(found->labels[floor], 3);
  EXPECT_EQ(found->labels[floor + 11 * 21 * 31], 2);
  EXPECT_EQ(found->labels.back(), 1);

  const Obstacle& hanging = found->obstacles[0];
  EXPECT_FALSE(hanging.contact);
  EXPECT_NEAR(hanging.min_height_m, 0.50, 1e-6);
  EXPECT_NEAR(hanging.max_height_m, 0.54, 1e-6);
  EXPECT_NEAR(hanging.nearest_m, Eigen::Vector3d(-0.46, 0.46, 1.2).norm(), 1e-6);

  const Obstacle& far = found->obstacles[2];
  EXPECT_EQ(far.id, 3);
  EXPECT_EQ(far.kind, ObstacleKind::object);
  EXPECT_EQ(far.pixels, 11U * 21U * 31U);
  EXPECT_TRUE(far.contact);
  EXPECT_TRUE(far.centroid.isApprox(Eigen::Vector3d(0.55, 0.89, 2.15), 1e-5)) << far.centroid.transpose();
  // The ground's x is ahead, y to the left.
  EXPECT_TRUE(far.box.centre.isApprox(Eigen::Vector3d(2.15, -0.55, 0.11), 1e-5)) << far.box.centre.transpose();
  EXPECT_TRUE(far.box.size.isApprox(Eigen::Vector3d(0.3, 0.1, 0.2), 1e-5)) << far.box.size.transpose();
  EXPECT_NEAR(far.box.yaw_rad, 0.0, 1e-5);

  const auto joined = scene.find({.cluster_distance_m = 0.025});
  ASSERT_TRUE(joined.ok());
  EXPECT_EQ(joined->obstacles.size(), 2U);
}

TEST(CloudObstacles, TheDistanceIsFourSpacingsOfThePlanesUnlessChosen) {
  for (const double gap : {0.079, 0.081}) {
    Scene scene;
    scene.add_block({0.0, 0.98, 1.5}, 11, 11, 11);
    scene.add_block({0.1 + gap, 0.98, 1.5}, 11, 11, 11);
    EXPECT_EQ(scene.find().value().obstacles.size(), gap < 4 * Scene::kSpacing ? 1U : 2U) << gap;
  }
}

TEST(CloudObstacles, AChainOfPointsIsOneAndItsLinksAreNone) {
  Scene scene;
  for (int i = 0; i < 100; ++i) scene.add({-0.9 + 0.015 * i, 0.5, 1.8});
  const auto chain = scene.find({.cluster_distance_m = 0.016});
  ASSERT_TRUE(chain.ok());
  ASSERT_EQ(chain->obstacles.size(), 1U);
  EXPECT_EQ(chain->obstacles[0].pixels, 100U);
  EXPECT_NEAR(chain->obstacles[0].box.size.x(), 99 * 0.015, 1e-5);
  EXPECT_NEAR(std::abs(chain->obstacles[0].box.yaw_rad), std::numbers::pi / 2.0, 1e-5);
  EXPECT_TRUE(scene.find({.cluster_distance_m = 0.014}).value().obstacles.empty());
}

TEST(CloudObstacles, SmallerThanTheLeastSizeAreLeftOut) {
  Scene scene;  // a point stands for 2 cm x 2 cm
  for (int i = 0; i < 25; ++i) scene.add({0.01 * i, 0.5, 1.8});
  EXPECT_EQ(scene.find({.min_size_m = 0.0999}).value().obstacles.size(), 1U);
  EXPECT_EQ(scene.find({.min_size_m = 0.1001}).value().obstacles.size(), 0U);
}

TEST(CloudObstacles, OnePointAndNoPointsAreNone) {
  Scene scene;
  EXPECT_TRUE(scene.find().value().obstacles.empty());
  scene.add({0.0, 0.5, 1.5});
  EXPECT_TRUE(scene.find({.min_size_m = 0.0}).value().obstacles.empty());
}

TEST(CloudObstacles, PointsThatAreNoMeasurementsAreOnNone) {
  constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
  constexpr double kInf = std::numeric_limits<double>::infinity();
  Scene scene;
  scene.add_block({0.0, 0.98, 1.5}, 5, 5, 5);
  // Whatever their labels say.
  for (const std::uint8_t label : {kLabelNoDepth, kLabelFirst, kLabelNoPlane}) {
    scene.add({kNaN, kNaN, kNaN}, label);
    scene.add({0.0, 0.9, kNaN}, label);
    scene.add({0.0, -kInf, 1.5}, label);
    scene.add({0.0, 0.0, 0.0}, label);
  }
  const auto found = scene.find();
  ASSERT_TRUE(found.ok());
  ASSERT_EQ(found->obstacles.size(), 1U);
  EXPECT_EQ(found->obstacles[0].pixels, 125U);
  EXPECT_TRUE(std::all_of(found->labels.end() - 12, found->labels.end(), [](std::uint16_t id) { return id == 0; }));
  EXPECT_TRUE(found->obstacles[0].centroid.allFinite());
}

TEST(CloudObstacles, DuplicatedPointsAreOne) {
  Scene scene;
  for (int i = 0; i < 1000; ++i) scene.add({0.25, 0.5, 1.5});
  const auto found = scene.find();
  ASSERT_TRUE(found.ok());
  ASSERT_EQ(found->obstacles.size(), 1U);
  EXPECT_EQ(found->obstacles[0].pixels, 1000U);
  EXPECT_EQ(found->obstacles[0].box.size.norm(), 0.0);
  EXPECT_TRUE(found->obstacles[0].box.centre.allFinite());
}

TEST(CloudObstacles, PointsAThousandKilometresApartTakeNoMoreMemory) {
  Scene scene;
  scene.add_block({0.0, 0.98, 1.5}, 5, 5, 5);
  for (const double far : {-1e6, 1e6}) {
    for (int i = 0; i < 5; ++i) scene.add({far, -1e6, std::abs(far)});
  }
  EXPECT_EQ(scene.find().value().obstacles.size(), 3U);
  EXPECT_EQ(scene.find({.cluster_distance_m = 0.011}).value().obstacles.size(), 3U);
  const auto refused = scene.find({.cluster_distance_m = 1e-4});
  ASSERT_FALSE(refused.ok());
  EXPECT_EQ(refused.error().code, ErrorCode::invalid_argument);
  EXPECT_THAT(refused.error().message, HasSubstr("cluster-distance"));
}

TEST(CloudObstacles, AnOriginFarAwayChangesNothing) {
  Scene scene;
  scene.add_block({0.0, 0.98, 1.5}, 5, 5, 5);
  const auto near = scene.find();
  PointCloud cloud = scene.cloud();
  cloud.origin = {512345.5, 1000.25, 5400000.75};
  Segmentation segmentation = scene.segmentation;
  segmentation.planes[0].plane.d += cloud.origin.y();
  const auto far = find_obstacles(cloud, segmentation);
  ASSERT_TRUE(near.ok() && far.ok());
  ASSERT_EQ(far->obstacles.size(), 1U);
  EXPECT_EQ(far->labels, near->labels);
  EXPECT_NEAR(far->obstacles[0].max_height_m, near->obstacles[0].max_height_m, 1e-6);
  EXPECT_TRUE((far->obstacles[0].centroid - cloud.origin).isApprox(near->obstacles[0].centroid, 1e-6));
}

TEST(CloudObstacles, WhatTheSegmentationTookForNoiseIsNoObstacle) {
  Scene scene;
  scene.add({0.5, 0.970, 1.5}, 1);                 // the floor's farthest point: 3 cm
  scene.add_block({0.0, 0.975, 1.5}, 5, 1, 5, 2);  // nearer to another plane than to the floor
  scene.add_block({-0.5, 0.965, 1.5}, 5, 1, 5, 2);
  scene.segmentation.planes.push_back({.id = 2, .plane = {Eigen::Vector3d::UnitX(), 0.5}, .inliers = 50, .area_m2 = 0.02});
  const auto found = scene.find();
  ASSERT_TRUE(found.ok());
  ASSERT_EQ(found->obstacles.size(), 1U);
  EXPECT_NEAR(found->obstacles[0].centroid.y(), 0.965, 1e-6);
  EXPECT_EQ(found->obstacles[0].kind, ObstacleKind::plane);
  EXPECT_THAT(found->obstacles[0].planes, ElementsAre(2));
}

TEST(CloudObstacles, KnownNoiseIsThatOfTheHeight) {
  // 4 sigmas of depth at 2 m are 4 cm, of the height there, the ray coming down by 1 in 2, half of that.
  Scene scene;
  scene.segmentation.noise.constant_m = 0.01;
  scene.add_block({0.0, 0.981, 2.0}, 5, 1, 1);
  scene.add_block({-0.5, 0.979, 2.0}, 5, 1, 1);
  const auto found = scene.find();
  ASSERT_TRUE(found.ok());
  ASSERT_EQ(found->obstacles.size(), 1U);
  EXPECT_NEAR(found->obstacles[0].centroid.y(), 0.979, 1e-6);
}

TEST(CloudObstacles, WhatLimitsLeaveOutIsNone) {
  Scene scene;
  scene.add_block({0.0, 0.98, 1.5}, 5, 5, 5);
  scene.add_block({0.0, 0.98, 2.5}, 5, 5, 5);
  const AxisLimits limits{.axis = Axis::z, .min_m = 2.0, .max_m = 3.0};
  const auto found = scene.find({}, &limits);
  ASSERT_TRUE(found.ok());
  ASSERT_EQ(found->obstacles.size(), 1U);
  EXPECT_GT(found->obstacles[0].centroid.z(), 2.0);
}

TEST(CloudObstacles, UpDecidesWhichSideIsAbove) {
  Scene scene;
  scene.add_block({0.0, 1.1, 1.5}, 5, 5, 5);  // under the floor, for an origin above it
  const ObstacleOptions named{.support = {SupportKind::plane, 1}};
  EXPECT_TRUE(scene.find(named).value().obstacles.empty());
  scene.segmentation.up.reset();
  EXPECT_TRUE(scene.find(named).value().obstacles.empty());
  scene.segmentation.sensor_position = Eigen::Vector3d(0.0, 2.0, 0.0);
  EXPECT_EQ(scene.find(named).value().obstacles.size(), 1U);
  scene.segmentation.sensor_position.reset();
  scene.segmentation.up = Eigen::Vector3d::UnitY();
  const auto found = scene.find(named);
  ASSERT_TRUE(found.ok());
  ASSERT_EQ(found->obstacles.size(), 1U);
  EXPECT_NEAR(found->obstacles[0].min_height_m, 0.06, 1e-6);
}

TEST(CloudObstacles, DistancesAndTheGroundAreFromTheSensor) {
  Scene scene;
  scene.add_block({0.0, 0.98, 1.5}, 5, 5, 5);
  const auto at_origin = scene.find();
  const Eigen::Vector3d moved(0.0, -0.5, 1.0);
  scene.segmentation.sensor_position = moved;
  const auto found = scene.find();
  ASSERT_TRUE(at_origin.ok() && found.ok());
  ASSERT_EQ(found->obstacles.size(), 1U);
  double nearest = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < scene.points.size(); ++i) {
    if (found->labels[i] == 1) nearest = std::min(nearest, (scene.points[i] - moved).norm());
  }
  EXPECT_NEAR(found->obstacles[0].nearest_m, nearest, 1e-6);
  EXPECT_NEAR((found->ground.origin - Eigen::Vector3d(0.0, 1.0, 1.0)).norm(), 0.0, 1e-12);
  EXPECT_NEAR(found->obstacles[0].box.centre.x(), at_origin->obstacles[0].box.centre.x() - 1.0, 1e-6);
}

TEST(CloudObstacles, TheSensorsPositionAndTheOriginAreFiniteAndNotTooFar) {
  Scene scene;
  scene.add_block({0.0, 0.98, 1.5}, 5, 5, 5);
  for (const double far_m : {kMaxCoordinate_m, -kMaxCoordinate_m}) {
    scene.segmentation.sensor_position = Eigen::Vector3d(0.0, 0.0, far_m);
    const auto found = scene.find();
    ASSERT_TRUE(found.ok());
    EXPECT_TRUE(found->ground.origin.allFinite());
    EXPECT_TRUE(std::isfinite(found->support_plane.d));
  }
  for (const double wrong : {1.01 * kMaxCoordinate_m, std::numeric_limits<double>::infinity(), std::nan("")}) {
    scene.segmentation.sensor_position = Eigen::Vector3d(0.0, wrong, 0.0);
    const auto found = scene.find();
    ASSERT_FALSE(found.ok()) << wrong;
    EXPECT_EQ(found.error().code, ErrorCode::invalid_argument);
    EXPECT_THAT(found.error().message, HasSubstr("segmentation: sensor position: must be finite"));
    scene.segmentation.sensor_position.reset();
    PointCloud cloud = testing::cloud_of(scene.points);
    cloud.origin.x() = wrong;
    EXPECT_THAT(find_obstacles(cloud, scene.segmentation).error().message, HasSubstr("point cloud: origin"));
  }
}

TEST(CloudObstacles, WithoutASupportAllIsAnObstacleAndSizesMustAgree) {
  Scene scene;
  const auto expect_all = [&](SupportReason reason) {
    const auto none = scene.find();
    ASSERT_TRUE(none.ok());
    EXPECT_TRUE(none->support.empty());
    EXPECT_EQ(enum_name(none->support_reason), enum_name(reason));
    ASSERT_EQ(none->obstacles.size(), 1U);
    EXPECT_EQ(none->obstacles[0].pixels, scene.points.size());
    EXPECT_FALSE(none->obstacles[0].contact);
  };
  scene.segmentation.up.reset();
  scene.segmentation.planes[0].kind = PlaneKind::unknown;
  expect_all(SupportReason::up_unknown);
  scene.segmentation.up = Eigen::Vector3d::UnitZ();
  scene.segmentation.planes[0].kind = PlaneKind::wall;
  expect_all(SupportReason::no_level_plane);
  scene.segmentation.planes.clear();
  scene.segmentation.labels.assign(scene.segmentation.labels.size(), kLabelNoPlane);
  expect_all(SupportReason::no_planes);
  scene.segmentation.labels.pop_back();
  EXPECT_EQ(scene.find().error().code, ErrorCode::invalid_argument);
  EXPECT_THAT(validate(ObstacleOptions{.cluster_distance_m = -1.0}).error().message, HasSubstr("cluster-distance"));
}

}  // namespace
}  // namespace fransac
