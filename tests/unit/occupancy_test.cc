// SPDX-License-Identifier: Apache-2.0
#include "fransac/obstacles/occupancy.hpp"

#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <vector>

#include "support.hpp"

namespace fransac {
namespace {

using testing::FloatImage;
using ::testing::HasSubstr;

constexpr std::uint16_t kObject = 1;
constexpr std::uint16_t kDrop = 2;

/// A segmented view of a floor 1.2 m under a camera that looks down by 35 degrees, every pixel on the floor.
struct Scene {
  Scene() : image(testing::small_camera()) {
    const double down = 35.0 * std::acos(-1.0) / 180.0;
    const Plane floor{Eigen::Vector3d(0.0, -std::cos(down), -std::sin(down)), 1.2};
    image.draw(floor);
    segmentation.width = obstacles.width = image.camera.width;
    segmentation.height = obstacles.height = image.camera.height;
    segmentation.planes.push_back({.id = 1, .plane = floor});
    segmentation.labels.assign(image.metres.size(), 1);
    obstacles.labels.assign(image.metres.size(), 0);
    obstacles.support = {1};
    obstacles.support_plane = floor;
    obstacles.ground = ground_frame(floor);
    obstacles.obstacles.resize(2);
    obstacles.obstacles[kObject - 1].kind = ObstacleKind::object;
    obstacles.obstacles[kDrop - 1].kind = ObstacleKind::drop;
  }

  void put(int u, int v, float z, std::uint16_t id) {
    image.at(u, v) = z;
    segmentation.labels[index(u, v)] = kLabelNoPlane;
    obstacles.labels[index(u, v)] = id;
  }
  [[nodiscard]] std::size_t index(int u, int v) const { return static_cast<std::size_t>(v * image.camera.width + u); }
  [[nodiscard]] double floor_depth(int u, int v) const { return testing::depth_on(obstacles.support_plane, image.camera, u, v); }
  [[nodiscard]] Eigen::Vector3d on_ground(int u, int v, double z) const {
    return obstacles.ground.from_camera(z * testing::ray(image.camera, u, v));
  }
  [[nodiscard]] OccupancyGrid grid(const OccupancyOptions& options = {}) const {
    const Result<OccupancyGrid> result = occupancy_grid(image.view(), image.camera, segmentation, obstacles, options);
    EXPECT_TRUE(result.ok());
    return result ? *result : OccupancyGrid{};
  }

  FloatImage image;
  Segmentation segmentation;
  Obstacles obstacles;
};

std::int8_t& cell_at(OccupancyGrid& grid, const Eigen::Vector3d& place) {
  const auto x = static_cast<std::size_t>(std::floor((place.x() - grid.origin_m.x()) / grid.resolution_m));
  const auto y = static_cast<std::size_t>(std::floor((place.y() - grid.origin_m.y()) / grid.resolution_m));
  return grid.cells.at(y * static_cast<std::size_t>(grid.width) + x);
}

/// What the grid shall be, pixel by pixel: all free squares first, then the occupied ones.
OccupancyGrid expected(const Scene& scene, const DepthView& depth, const OccupancyOptions& options) {
  OccupancyGrid grid;
  grid.resolution_m = options.resolution_m;
  const int ahead = static_cast<int>(std::ceil(options.max_range_m / options.resolution_m));
  grid.width = grid.height = 2 * ahead;
  grid.origin_m.setConstant(-ahead * options.resolution_m);
  grid.cells.assign(static_cast<std::size_t>(grid.width * grid.height), OccupancyGrid::kUnknown);
  for (const bool occupied : {false, true}) {
    for (int v = 0; v < depth.height(); ++v) {
      for (int u = 0; u < depth.width(); ++u) {
        const auto z = static_cast<double>(depth.metres(u, v));
        const std::uint16_t id = scene.obstacles.labels[scene.index(u, v)];
        const bool on_support = scene.segmentation.labels[scene.index(u, v)] == 1;
        if (z == 0.0 || (id != 0) != occupied || (id == 0 && !on_support)) continue;
        const Eigen::Vector3d place = scene.on_ground(u, v, id == kDrop ? scene.floor_depth(u, v) : z);
        if (place.z() > options.clearance_m || place.head<2>().norm() > options.max_range_m) continue;
        cell_at(grid, place) = occupied ? OccupancyGrid::kOccupied : OccupancyGrid::kFree;
      }
    }
  }
  return grid;
}

void scatter(Scene& scene) {
  RandomStream random = testing::test_random();
  for (int v = 0; v < scene.image.camera.height; ++v) {
    for (int u = 0; u < scene.image.camera.width; ++u) {
      const double floor = scene.floor_depth(u, v);
      const double choice = random.uniform();
      if (choice < 0.05) scene.put(u, v, static_cast<float>(floor * testing::uniform(random, 0.3, 0.95)), kObject);
      if (choice > 0.95) scene.put(u, v, static_cast<float>(floor * testing::uniform(random, 1.05, 2.0)), kDrop);
      if (choice > 0.4 && choice < 0.45) scene.put(u, v, static_cast<float>(floor), 0);  // on no plane, on no obstacle
      if (choice > 0.5 && choice < 0.55) scene.image.at(u, v) = 0.0F;
    }
  }
}

void expect_same(const OccupancyGrid& a, const OccupancyGrid& b) {
  EXPECT_EQ(a.resolution_m, b.resolution_m);
  EXPECT_EQ(a.width, b.width);
  EXPECT_EQ(a.height, b.height);
  EXPECT_EQ(a.origin_m, b.origin_m);
  EXPECT_TRUE(a.cells == b.cells);
}

TEST(OccupancyGrid, EveryPixelOfFloatDepthMarksItsSquare) {
  Scene scene;
  scatter(scene);
  const OccupancyOptions options{.resolution_m = 0.07, .max_range_m = 2.4, .clearance_m = 0.6};
  expect_same(scene.grid(options), expected(scene, scene.image.view(), options));
}

TEST(OccupancyGrid, EveryPixelOf16BitDepthMarksItsSquare) {
  Scene scene;
  scatter(scene);
  std::vector<std::uint16_t> units(scene.image.metres.size());
  for (std::size_t i = 0; i < units.size(); ++i) units[i] = static_cast<std::uint16_t>(scene.image.metres[i] * 1000.0F);
  const Camera& camera = scene.image.camera;
  const DepthView depth = DepthView::from_uint16(units.data(), camera.width, camera.height, camera.depth_scale);
  const OccupancyOptions options{.resolution_m = 0.03, .max_range_m = 3.0};
  const Result<OccupancyGrid> grid = occupancy_grid(depth, camera, scene.segmentation, scene.obstacles, options);
  ASSERT_TRUE(grid.ok());
  expect_same(*grid, expected(scene, depth, options));
}

TEST(OccupancyGrid, AnObstacleOccupiesItsSquareAmidTheFloor) {
  Scene scene;
  const int u = 40;
  const int v = 50;
  scene.put(u, v, static_cast<float>(0.8 * scene.floor_depth(u, v)), kObject);
  OccupancyGrid grid = scene.grid();
  EXPECT_EQ(cell_at(grid, scene.on_ground(u, v, static_cast<double>(scene.image.at(u, v)))), OccupancyGrid::kOccupied);
  EXPECT_EQ(std::count(grid.cells.begin(), grid.cells.end(), OccupancyGrid::kOccupied), 1);
  EXPECT_GT(std::count(grid.cells.begin(), grid.cells.end(), OccupancyGrid::kFree), 100);
  EXPECT_EQ(grid.cells.front(), OccupancyGrid::kUnknown);
}

TEST(OccupancyGrid, ADropOccupiesTheSquareWhereTheGroundIsMissing) {
  Scene scene;
  const int u = 30;
  const int v = 45;
  scene.put(u, v, 4.0F * static_cast<float>(scene.floor_depth(u, v)), kDrop);
  OccupancyGrid grid = scene.grid();
  EXPECT_EQ(cell_at(grid, scene.on_ground(u, v, scene.floor_depth(u, v))), OccupancyGrid::kOccupied);
  EXPECT_EQ(std::count(grid.cells.begin(), grid.cells.end(), OccupancyGrid::kOccupied), 1);
}

TEST(OccupancyGrid, ARayThatNeverMeetsTheSupportMarksNoDrop) {
  Scene scene;
  scene.segmentation.labels.assign(scene.segmentation.labels.size(), kLabelNoPlane);
  const double down = -40.0 * std::acos(-1.0) / 180.0;  // looks up: the rays never come down
  scene.obstacles.support_plane.normal << 0.0, -std::cos(down), -std::sin(down);
  scene.obstacles.ground = ground_frame(scene.obstacles.support_plane);
  scene.put(40, 30, 2.0F, kDrop);
  const OccupancyGrid grid = scene.grid();
  EXPECT_EQ(std::count(grid.cells.begin(), grid.cells.end(), OccupancyGrid::kUnknown),
            static_cast<std::ptrdiff_t>(grid.cells.size()));
}

TEST(OccupancyGrid, WhatIsHigherThanTheClearanceIsPassedUnder) {
  Scene scene;
  const int u = 41;
  const int v = 52;
  const auto z = static_cast<float>(0.5 * scene.floor_depth(u, v));  // 0.6 m above the floor
  scene.put(u, v, z, kObject);
  const Eigen::Vector3d place = scene.on_ground(u, v, static_cast<double>(z));
  OccupancyGrid low = scene.grid({.clearance_m = 0.59});
  OccupancyGrid high = scene.grid({.clearance_m = 0.61});
  EXPECT_NE(cell_at(low, place), OccupancyGrid::kOccupied);
  EXPECT_EQ(cell_at(high, place), OccupancyGrid::kOccupied);
}

TEST(OccupancyGrid, NothingIsFreeWithoutASupport) {
  Scene scene;
  scene.put(10, 10, 1.0F, 1);
  scene.obstacles.support.clear();
  scene.obstacles.obstacles.resize(1);
  const OccupancyGrid grid = scene.grid();
  EXPECT_EQ(std::count(grid.cells.begin(), grid.cells.end(), OccupancyGrid::kFree), 0);
  EXPECT_GT(std::count(grid.cells.begin(), grid.cells.end(), OccupancyGrid::kOccupied), 0);
}

TEST(OccupancyGrid, NothingIsKnownBeforeObstaclesAreLookedFor) {
  Scene scene;
  scene.obstacles = {};
  const OccupancyGrid grid = scene.grid();
  EXPECT_EQ(grid.width, 0);
  EXPECT_EQ(grid.height, 0);
  EXPECT_TRUE(grid.cells.empty());
}

TEST(OccupancyGrid, LabelsThatMeanNothingAreIgnored) {
  Scene scene;
  scene.obstacles.labels.assign(scene.obstacles.labels.size(), 4000);
  scene.segmentation.labels.assign(scene.segmentation.labels.size(), 200);
  const OccupancyGrid grid = scene.grid();
  EXPECT_EQ(std::count(grid.cells.begin(), grid.cells.end(), OccupancyGrid::kUnknown),
            static_cast<std::ptrdiff_t>(grid.cells.size()));
}

TEST(OccupancyOptions, ErrorsNameTheOption) {
  constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
  constexpr double kInf = std::numeric_limits<double>::infinity();
  for (const double bad : {0.0, -1.0, kNaN, kInf}) {
    EXPECT_THAT(validate(OccupancyOptions{.resolution_m = bad}).error().message, HasSubstr("resolution"));
    EXPECT_THAT(validate(OccupancyOptions{.max_range_m = bad}).error().message, HasSubstr("max-range"));
  }
  for (const double bad : {0.0, -1.0, kNaN}) {
    EXPECT_THAT(validate(OccupancyOptions{.clearance_m = bad}).error().message, HasSubstr("clearance"));
  }
  // 8000 squares along a side are 64 million.
  EXPECT_TRUE(validate(OccupancyOptions{.resolution_m = 0.25, .max_range_m = 1000.0}).ok());
  const Status status = validate(OccupancyOptions{.resolution_m = 0.2499, .max_range_m = 1000.0});
  ASSERT_FALSE(status.ok());
  EXPECT_THAT(status.error().message, HasSubstr("resolution"));
  EXPECT_THAT(status.error().message, HasSubstr("64 million"));
  EXPECT_FALSE(validate(OccupancyOptions{.resolution_m = 1e-300, .max_range_m = 1e300}).ok());
}

TEST(OccupancyGrid, RefusesObstaclesOfAnotherImage) {
  Scene scene;
  scene.obstacles.labels.pop_back();
  const auto grid = occupancy_grid(scene.image.view(), scene.image.camera, scene.segmentation, scene.obstacles);
  ASSERT_FALSE(grid.ok());
  EXPECT_EQ(grid.error().code, ErrorCode::invalid_argument);
}

}  // namespace
}  // namespace fransac
