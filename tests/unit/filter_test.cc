// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <numeric>
#include <vector>

#include "fransac/filter/deproject.hpp"
#include "fransac/filter/pass_through.hpp"
#include "fransac/filter/voxel_grid.hpp"
#include "support.hpp"

namespace fransac {
namespace {

using Eigen::Vector3d;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

constexpr float kInf = std::numeric_limits<float>::infinity();
constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();

// ---- deprojection ----

TEST(Deproject, FollowsTheFormulaPixelByPixel) {
  const Camera camera = testing::small_camera(37, 23);
  std::vector<std::uint16_t> pixels(37 * 23);
  RandomStream random = testing::test_random();
  for (std::uint16_t& pixel : pixels)
    pixel = random.below(3) == 0 ? std::uint16_t{0} : static_cast<std::uint16_t>(1 + random.below(65535));
  const DepthView depth = DepthView::from_uint16(pixels.data(), 37, 23, 5000.0);
  PointCloud cloud;
  deproject(depth, camera, cloud);

  std::size_t k = 0;
  for (int v = 0; v < 23; ++v) {
    for (int u = 0; u < 37; ++u) {
      const std::uint16_t raw = depth.row_uint16(v)[u];
      if (raw == 0) continue;
      ASSERT_LT(k, cloud.size());
      EXPECT_EQ(cloud.source[k], static_cast<std::uint32_t>(v * 37 + u));
      const Vector3d expected = raw / 5000.0 * testing::ray(camera, u, v);
      EXPECT_LT((cloud.point(k) - expected).norm(), 1e-6 * expected.norm());
      ++k;
    }
  }
  EXPECT_EQ(cloud.size(), k);
  EXPECT_EQ(cloud.source.size(), k);
  EXPECT_FALSE(cloud.organised());
}

TEST(Deproject, NothingWithoutMeasurements) {
  const Camera camera = testing::small_camera();
  const std::vector<std::uint16_t> zeros(80 * 60);
  PointCloud cloud = testing::cloud_of({{1, 2, 3}}, {4, 5, 6});  // leftovers of an earlier use
  deproject(DepthView::from_uint16(zeros.data(), 80, 60, 1000.0), camera, cloud);
  EXPECT_TRUE(cloud.empty());
  EXPECT_EQ(cloud.origin, Vector3d::Zero());
}

TEST(Deproject, FloatDepthDropsWhatIsNoMeasurement) {
  Camera camera = testing::small_camera(8, 1);
  const std::vector<float> pixels{0.0F, 1.0F, -1.0F, kNaN, 2.0F, kInf, -kInf, 3.0F};
  PointCloud cloud;
  deproject(DepthView::from_float(pixels.data(), 8, 1), camera, cloud);
  EXPECT_THAT(cloud.source, ElementsAre(1, 4, 7));
  EXPECT_EQ(cloud.z()[0], 1.0F);
  EXPECT_EQ(cloud.z()[1], 2.0F);
  EXPECT_EQ(cloud.z()[2], 3.0F);
}

TEST(Deproject, PaddedAndUpwardRows) {
  const Camera camera = testing::small_camera(2, 2);
  const std::vector<std::uint16_t> pixels{1000, 2000, 9999, 3000, 4000, 9999};
  PointCloud cloud;
  deproject(DepthView::from_uint16(pixels.data(), 2, 2, 1000.0, 6), camera, cloud);
  ASSERT_EQ(cloud.size(), 4U);
  EXPECT_FLOAT_EQ(cloud.z()[2], 3.0F);
  deproject(DepthView::from_uint16(pixels.data() + 3, 2, 2, 1000.0, -6), camera, cloud);
  ASSERT_EQ(cloud.size(), 4U);
  EXPECT_FLOAT_EQ(cloud.z()[0], 3.0F);
  EXPECT_FLOAT_EQ(cloud.z()[2], 1.0F);
}

// ---- pass-through ----

AxisLimits limits(Axis axis, double min_m, double max_m, bool outside = false) {
  return {.axis = axis, .min_m = min_m, .max_m = max_m, .outside = outside};
}

TEST(PassThrough, EachAxisInsideAndOutsideEndsIncluded) {
  // Along the axis under test -1, 0, 1, 2, 3; far outside the limits along the others.
  for (const Axis axis : {Axis::x, Axis::y, Axis::z}) {
    std::vector<Vector3d> points(5, Vector3d::Constant(100.0));
    for (int i = 0; i < 5; ++i) points[static_cast<std::size_t>(i)][static_cast<int>(axis)] = i - 1;
    PointCloud inside = testing::cloud_of(points);
    pass_through(limits(axis, 0.0, 2.0), inside);
    EXPECT_THAT(inside.source, ElementsAre(1, 2, 3));
    EXPECT_EQ(inside.local(0), points[1]);
    EXPECT_EQ(inside.local(2), points[3]);
    PointCloud outside = testing::cloud_of(points);
    pass_through(limits(axis, 0.0, 2.0, true), outside);
    EXPECT_THAT(outside.source, ElementsAre(0, 4));
  }
}

TEST(PassThrough, EndsThatAreNoFloats) {
  // A coordinate is float, a limit double: the comparison must mean what it means in double.
  const double limit = 0.1;  // lies below the float nearest to it
  const float above = 0.1F;
  const float below = std::nextafter(above, 0.0F);
  ASSERT_GT(static_cast<double>(above), limit);
  PointCloud cloud = testing::cloud_of({{0, 0, static_cast<double>(below)}, {0, 0, static_cast<double>(above)}});
  pass_through(limits(Axis::z, 0.0, limit), cloud);
  EXPECT_THAT(cloud.source, ElementsAre(0));
  cloud = testing::cloud_of({{0, 0, static_cast<double>(below)}, {0, 0, static_cast<double>(above)}});
  pass_through(limits(Axis::z, limit, 1.0), cloud);
  EXPECT_THAT(cloud.source, ElementsAre(1));
}

TEST(PassThrough, LimitsAreInTheInputsCoordinates) {
  PointCloud cloud = testing::cloud_of({{0, 0, 0}, {1, 0, 0}, {2, 0, 0}}, {5e5, 5.4e6, 200.0});
  pass_through(limits(Axis::x, 500000.5, 500001.5), cloud);
  EXPECT_THAT(cloud.source, ElementsAre(1));
  EXPECT_EQ(cloud.point(0), Vector3d(500001.0, 5.4e6, 200.0));
}

TEST(PassThrough, LimitsBeyondFloatKeepEverything) {
  PointCloud cloud = testing::cloud_of({{0, 0, -1e30}, {0, 0, 1e30}});
  pass_through(limits(Axis::z, -1e300, 1e300), cloud);
  EXPECT_EQ(cloud.size(), 2U);
}

TEST(PassThrough, DropsInvalidPointsInsideAndOutside) {
  const double inf = static_cast<double>(kInf);
  const double nan = static_cast<double>(kNaN);
  const std::vector<Vector3d> points{{0, 0, 1}, {nan, 0, 1}, {0, inf, 1}, {0, 0, nan}, {0, 0, 9}, {nan, 0, 9}, {0, 0, inf}};
  PointCloud inside = testing::cloud_of(points);
  pass_through(limits(Axis::z, 0.0, 2.0), inside);
  EXPECT_THAT(inside.source, ElementsAre(0));
  PointCloud outside = testing::cloud_of(points);
  pass_through(limits(Axis::z, 0.0, 2.0, true), outside);
  EXPECT_THAT(outside.source, ElementsAre(4));
}

TEST(PassThrough, SourcesChain) {
  PointCloud cloud = testing::cloud_of({{0, 0, 1}, {static_cast<double>(kNaN), 0, 1}, {5, 0, 1}, {1, 0, 1}, {1, 0, 7}});
  remove_unmeasured(cloud);
  EXPECT_THAT(cloud.source, ElementsAre(0, 2, 3, 4));
  pass_through(limits(Axis::x, 0.0, 2.0), cloud);
  EXPECT_THAT(cloud.source, ElementsAre(0, 3, 4));
  pass_through(limits(Axis::z, 0.0, 2.0), cloud);
  EXPECT_THAT(cloud.source, ElementsAre(0, 3));
}

TEST(RemoveUnmeasured, ZerosAreNoPointsWhereverTheOriginIs) {
  PointCloud cloud = testing::cloud_of({{0, 0, 1}, {0, 0, 0}, {1, 0, 0}, {0, -0.0, 0}});
  remove_unmeasured(cloud);
  EXPECT_THAT(cloud.source, ElementsAre(0, 2));

  PointCloud far;
  far.origin = {5.0e5, 5.4e6, 200.0};
  far.resize(3);
  far.set(0, {1, 2, 3});
  far.set(1, (-far.origin).cast<float>());  // (0, 0, 0) in the input
  far.set(2, {0, 0, 0});                    // the origin itself is a place like any other
  remove_unmeasured(far);
  EXPECT_THAT(far.source, ElementsAre(0, 2));
}

TEST(RemoveUnmeasured, OrganisedCloudBecomesAList) {
  PointCloud cloud = testing::cloud_of({{0, 0, 1}, {0, 0, static_cast<double>(kNaN)}, {0, 0, 2}, {0, 0, 3}});
  cloud.width = cloud.height = 2;
  ASSERT_TRUE(cloud.organised());
  remove_unmeasured(cloud);
  EXPECT_FALSE(cloud.organised());
  EXPECT_THAT(cloud.source, ElementsAre(0, 2, 3));
  EXPECT_TRUE(std::isnan(cloud.z()[3]));  // padding
}

// ---- voxel grid ----

VoxelGrid grid_of(const PointCloud& cloud, double leaf_size_m, LeafPoint leaf_point = LeafPoint::centroid) {
  VoxelGrid grid;
  const Status status = voxel_grid(cloud, leaf_size_m, leaf_point, grid);
  EXPECT_TRUE(status) << (status ? "" : status.error().message);
  return grid;
}

// Three leaves of 1 m: the cube at the origin (points 0 and 2), the one before it on x (1), the one at (2, 0, 0) (3, 4, 5).
PointCloud hand_made() {
  return testing::cloud_of(
      {{0.25, 0.5, 0.5}, {-0.25, 0.5, 0.5}, {0.75, 0.25, 0.0}, {2.0, 0.0, 0.0}, {2.5, 0.5, 0.75}, {2.75, 0.25, 0.75}});
}

TEST(VoxelGrid, CentroidsByHand) {
  const VoxelGrid grid = grid_of(hand_made(), 1.0);
  ASSERT_EQ(grid.leaves.size(), 3U);
  EXPECT_THAT(grid.leaf_of, ElementsAre(0, 1, 0, 2, 2, 2));
  EXPECT_THAT(grid.point_count, ElementsAre(2, 1, 3));
  EXPECT_EQ(grid.leaves.local(0), Vector3d(0.5, 0.375, 0.25));
  EXPECT_EQ(grid.leaves.local(1), Vector3d(-0.25, 0.5, 0.5));
  EXPECT_LT((grid.leaves.local(2) - Vector3d(7.25 / 3, 0.25, 0.5)).norm(), 1e-6);
  EXPECT_FALSE(grid.leaves.organised());
  EXPECT_EQ(grid.leaves.width, 3);
}

TEST(VoxelGrid, CentresByHand) {
  const VoxelGrid grid = grid_of(hand_made(), 1.0, LeafPoint::centre);
  ASSERT_EQ(grid.leaves.size(), 3U);
  EXPECT_EQ(grid.leaves.local(0), Vector3d(0.5, 0.5, 0.5));
  EXPECT_EQ(grid.leaves.local(1), Vector3d(-0.5, 0.5, 0.5));
  EXPECT_EQ(grid.leaves.local(2), Vector3d(2.5, 0.5, 0.5));
}

TEST(VoxelGrid, FlooringIsTowardsMinusInfinity) {
  // One point on each side of every lattice plane; leaf size 0.5 m, a power of two, so that nothing rounds.
  std::vector<Vector3d> points;
  for (int i = -4; i <= 4; ++i) {
    points.emplace_back(0.5 * i, -7.0, 3.0);           // on the lattice: belongs to the leaf above
    points.emplace_back(0.5 * i + 0.4375, -7.0, 3.0);  // the same leaf
  }
  const VoxelGrid grid = grid_of(testing::cloud_of(points), 0.5, LeafPoint::centre);
  ASSERT_EQ(grid.leaves.size(), 9U);
  for (std::size_t leaf = 0; leaf < 9; ++leaf) {
    EXPECT_EQ(grid.point_count[leaf], 2U);
    EXPECT_EQ(grid.leaves.local(leaf), Vector3d(0.5 * (static_cast<double>(leaf) - 4.0) + 0.25, -6.75, 3.25));
  }
}

TEST(VoxelGrid, BoxesOfAnyEdges) {
  VoxelGrid grid;
  const PointCloud cloud =
      testing::cloud_of({{0.5, 0.5, 0.5}, {1.5, 0.25, 0.75}, {0.5, 1.5, 0.5}, {0.5, 0.5, 2.5}, {-0.5, 0, 0}});
  ASSERT_TRUE(voxel_grid(cloud, {.leaf_size_m = {2.0, 1.0, 4.0}, .leaf_point = LeafPoint::centre, .leaf_of = true}, grid));
  EXPECT_THAT(grid.leaf_of, ElementsAre(0, 0, 1, 0, 2));
  EXPECT_EQ(grid.leaves.local(0), Vector3d(1.0, 0.5, 2.0));
  EXPECT_EQ(grid.leaves.local(1), Vector3d(1.0, 1.5, 2.0));
  EXPECT_EQ(grid.leaves.local(2), Vector3d(-1.0, 0.5, 2.0));
  EXPECT_EQ(grid.smallest, VoxelGrid::Index(-1, 0, 0));
  EXPECT_EQ(grid.largest, VoxelGrid::Index(0, 1, 0));
  EXPECT_FALSE(voxel_grid(cloud, {.leaf_size_m = {1.0, 0.0, 1.0}}, grid));
}

TEST(VoxelGrid, LeavesByAnIndexBeyondTheLastBit) {
  const VoxelGrid tall = grid_of(testing::cloud_of({{0.25, 0.25, 0.25}, {0.25, 0.25, 63.25}}), 1.0);
  EXPECT_EQ(tall.leaf_at({0, 0, 63}), 1U);
  EXPECT_EQ(tall.leaf_at({0, 0, 64}), VoxelGrid::kNoLeaf);
}

TEST(VoxelGrid, LeavesByTheirIndex) {
  const VoxelGrid grid = grid_of(hand_made(), 1.0);
  EXPECT_EQ(grid.leaf_at({0, 0, 0}), 0U);
  EXPECT_EQ(grid.leaf_at({-1, 0, 0}), 1U);
  EXPECT_EQ(grid.leaf_at({2, 0, 0}), 2U);
  constexpr std::int64_t kFar = std::numeric_limits<std::int64_t>::max();
  for (const VoxelGrid::Index& empty : {VoxelGrid::Index(1, 0, 0), VoxelGrid::Index(0, 1, 0), VoxelGrid::Index(-2, 0, 0),
                                        VoxelGrid::Index(3, 0, 0), VoxelGrid::Index(0, 0, -kFar), VoxelGrid::Index(kFar, 0, 0)}) {
    EXPECT_EQ(grid.leaf_at(empty), VoxelGrid::kNoLeaf);
  }
  EXPECT_EQ(grid.index_at({2.5F, 0.5F, 0.5F}), VoxelGrid::Index(2, 0, 0));
  EXPECT_EQ(grid.index_at({-7.5F, 40.0F, -0.5F}), VoxelGrid::Index(-8, 40, -1));
  EXPECT_EQ(grid.leaf_at(grid.index_at({1e30F, -1e30F, 0.0F})), VoxelGrid::kNoLeaf);
  EXPECT_EQ(VoxelGrid{}.leaf_at({0, 0, 0}), VoxelGrid::kNoLeaf);
}

// What a map of the points says. Coordinates are multiples of 2^-10 m, so that sums are exact.
void expect_leaves_of_a_map(const PointCloud& cloud, const VoxelGrid& grid, double leaf_size_m) {
  std::map<std::array<std::int64_t, 3>, std::uint32_t> numbers;
  std::vector<Vector3d> sums;
  std::vector<std::uint32_t> counts;
  ASSERT_EQ(grid.leaf_of.size(), cloud.size());
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const Vector3d point = cloud.local(i);
    const VoxelGrid::Index index = (point / leaf_size_m).array().floor().cast<std::int64_t>();
    const auto [leaf, is_new] = numbers.try_emplace({index[0], index[1], index[2]}, static_cast<std::uint32_t>(numbers.size()));
    if (is_new) {
      sums.emplace_back(0, 0, 0);
      counts.push_back(0);
      ASSERT_EQ(grid.leaf_at(index), leaf->second);
    }
    sums[leaf->second] += point;
    ++counts[leaf->second];
    ASSERT_EQ(grid.leaf_of[i], leaf->second) << i;
  }
  ASSERT_EQ(grid.leaves.size(), counts.size());
  EXPECT_TRUE(std::equal(counts.begin(), counts.end(), grid.point_count.begin()));
  EXPECT_EQ(grid.points, cloud.size());
  for (std::size_t leaf = 0; leaf < counts.size(); ++leaf) {
    const Vector3d mean = sums[leaf] / counts[leaf];
    ASSERT_LT((grid.leaves.local(leaf) - mean).norm(), 1e-6) << leaf;
  }
}

TEST(VoxelGrid, PointsInAnyOrderGiveTheLeavesOfAMap) {
  RandomStream random = testing::test_random();
  VoxelGrid grid;  // one for all: what a larger cloud left must not matter
  // The first too small to be sorted into buckets, the last sorted in two goes.
  for (const std::size_t size : {std::size_t{5000}, std::size_t{100001}, (std::size_t{1} << 21) + 77, std::size_t{70000}}) {
    std::vector<Vector3d> points;
    for (std::size_t i = 0; i < size; ++i) {
      const auto coordinate = [&] { return static_cast<double>(random.below(4096)) / 1024.0 - 2.0; };
      points.emplace_back(coordinate(), coordinate(), 0.25 * coordinate());
    }
    const PointCloud cloud = testing::cloud_of(points);
    for (const int threads : {1, 3}) {
      ASSERT_TRUE(voxel_grid(cloud, 0.0625, LeafPoint::centroid, grid, threads));
      expect_leaves_of_a_map(cloud, grid, 0.0625);
    }
  }
}

TEST(VoxelGrid, PointsInAnyOrderSomeOfThemNoneAreThoseOfTheOthers) {
  RandomStream random = testing::test_random();
  constexpr std::size_t kSize = 80000;
  std::vector<float> points;
  std::vector<Vector3d> finite;
  for (std::size_t i = 0; i < kSize; ++i) {
    const Vector3d point = testing::uniform_point(random, -1.0, 1.0);
    const bool none = random.below(5) == 0;
    for (int axis = 0; axis < 3; ++axis) points.push_back(none ? kNaN : static_cast<float>(point[axis]));
    if (!none) finite.push_back(point);
  }
  VoxelGrid grid;
  VoxelGrid expected;
  ASSERT_TRUE(voxel_grid(PointsView{points.data(), kSize, 3}, {.leaf_size_m = Vector3d::Constant(0.05), .leaf_of = true}, grid));
  ASSERT_TRUE(voxel_grid(testing::cloud_of(finite), 0.05, LeafPoint::centroid, expected));
  EXPECT_EQ(grid.point_count, expected.point_count);
  std::size_t k = 0;
  for (std::size_t i = 0; i < kSize; ++i) {
    ASSERT_EQ(grid.leaf_of[i], std::isnan(points[3 * i]) ? VoxelGrid::kNoLeaf : expected.leaf_of[k++]);
  }
}

TEST(VoxelGrid, TheWholeCloudInOneLeaf) {
  const VoxelGrid grid = grid_of(testing::cloud_of({{1, 2, 3}, {3, 2, 1}}), 10.0, LeafPoint::centre);
  ASSERT_EQ(grid.leaves.size(), 1U);
  EXPECT_EQ(grid.leaves.local(0), Vector3d(5, 5, 5));
}

TEST(VoxelGrid, UtmOriginGivesTheSameLeaves) {
  // The shift is a whole number of 2 cm leaves along every axis, so each point keeps its place in its leaf.
  RandomStream random = testing::test_random();
  std::vector<Vector3d> points;
  for (int i = 0; i < 3000; ++i) points.push_back(testing::uniform_point(random, -0.5, 0.5));
  for (const LeafPoint leaf_point : {LeafPoint::centroid, LeafPoint::centre}) {
    const VoxelGrid near = grid_of(testing::cloud_of(points), 0.02, leaf_point);
    const VoxelGrid far = grid_of(testing::cloud_of(points, {5e5, 5.4e6, 200.0}), 0.02, leaf_point);
    EXPECT_EQ(near.leaf_of, far.leaf_of);
    EXPECT_EQ(near.point_count, far.point_count);
    ASSERT_EQ(near.leaves.size(), far.leaves.size());
    EXPECT_EQ(far.leaves.origin, Vector3d(5e5, 5.4e6, 200.0));
    for (std::size_t leaf = 0; leaf < near.leaves.size(); ++leaf) {
      EXPECT_LT((near.leaves.local(leaf) - far.leaves.local(leaf)).norm(), 1e-6);  // one float step at 0.5 m is 6e-8
    }
  }
}

TEST(VoxelGrid, WideKeysStayApart) {
  // 2 cm leaves over 2 000 km x 2 000 km x 1 cm: 27 + 27 bits. Two points in far corners, two in neighbouring leaves.
  const PointCloud cloud = testing::cloud_of(
      {{-1e6, -1e6, 0.005}, {1e6, -1e6, 0.005}, {-1e6, 1e6, 0.005}, {1e6, 1e6, 0.005}, {0.01, 0.01, 0.005}, {0.03, 0.01, 0.005}});
  const VoxelGrid grid = grid_of(cloud, 0.02, LeafPoint::centre);
  EXPECT_THAT(grid.point_count, ElementsAre(1, 1, 1, 1, 1, 1));
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    EXPECT_LE((grid.leaves.local(i) - cloud.local(i)).cwiseAbs().maxCoeff(), 0.0101 + 1e6 * 6e-8) << i;
  }
}

TEST(VoxelGrid, CentresWhenTheKeyIsFull) {
  // Two axes of 31 bits each, in every position.
  const double largest = 0x1p31 - 128;  // the largest float below 2^31
  for (const Vector3d& far :
       {Vector3d(largest, largest, 0.5), Vector3d(largest, 0.5, largest), Vector3d(0.5, largest, largest)}) {
    const VoxelGrid grid = grid_of(testing::cloud_of({{0.5, 0.5, 0.5}, far}), 1.0, LeafPoint::centre);
    ASSERT_EQ(grid.leaves.size(), 2U);
    EXPECT_EQ(grid.leaves.local(0), Vector3d(0.5, 0.5, 0.5));
    EXPECT_LE((grid.leaves.local(1) - far).cwiseAbs().maxCoeff(), 64.5);  // half a leaf and half a float step
  }
}

TEST(VoxelGrid, RoundingNeverSpillsIntoTheNextAxis) {
  // Find a coordinate whose leaf index is just below 2^16 when product and sum are rounded one after the other and 2^16 when
  // they are rounded once (fused multiply-add). With 16 bits for x, that point at y = 0 would get the key of x = 0, y = 1.
  constexpr double kLeaf = 0.03;
  const double per_leaf = 1.0 / kLeaf;
  int found = 0;
  for (float x = 1966.065F; x < 1966.075F; x = std::nextafter(x, kInf)) {
    const double exact_product = std::fma(static_cast<double>(x), per_leaf, -65536.0);  // nearly: the sum is small
    const double origin = (-exact_product - 3e-12) * kLeaf;
    const double offset = origin * per_leaf;
    const volatile double product = static_cast<double>(x) * per_leaf;
    const bool differ = (product + offset < 65536.0) != (std::fma(static_cast<double>(x), per_leaf, offset) < 65536.0);
    if (!differ || origin < 0.0) continue;
    ++found;
    const PointCloud cloud =
        testing::cloud_of({{0.0, 1.5 * kLeaf, 0.0}, {static_cast<double>(x), 0.5 * kLeaf, 0.0}}, {origin, 0.0, 0.0});
    ASSERT_EQ(grid_of(cloud, kLeaf).leaves.size(), 2U) << x;
  }
  EXPECT_GT(found, 0);
}

TEST(VoxelGrid, TooManyLeavesIsAnError) {
  VoxelGrid grid;
  const auto error_of = [&](const PointCloud& cloud, double leaf_size_m) {
    const Status status = voxel_grid(cloud, leaf_size_m, LeafPoint::centroid, grid);
    EXPECT_FALSE(status);
    if (!status) {
      EXPECT_EQ(status.error().code, ErrorCode::invalid_argument);
      EXPECT_THAT(status.error().message, HasSubstr("leaf-size"));
    }
  };
  error_of(testing::cloud_of({{0, 0, 0}, {1e6, 1e6, 1e6}}), 1e-3);   // 3 x 30 bits
  error_of(testing::cloud_of({{0, 0, 0}, {3e9, 0, 0}}), 1.0);        // 32 bits on one axis
  error_of(testing::cloud_of({{-3e38, 0, 0}, {3e38, 0, 0}}), 1e-3);  // no integer holds it
  error_of(testing::cloud_of({{0, 0, 0}, {1, 1, 1}}), 1e-300);
  error_of(testing::cloud_of({{0, 0, 0}, {1, 1, 1}}), std::numeric_limits<double>::denorm_min());
  error_of(testing::cloud_of({{0, 0, 0}, {1, 1, 1}}, Vector3d::Constant(1e300)), 0.02);
  error_of(testing::cloud_of({{0, 0, 0}, {1, 1, 1}}, Vector3d::Constant(std::nan(""))), 0.02);
}

TEST(VoxelGrid, LeafSizeMustBePositiveAndItsMiddleAFloat) {
  VoxelGrid grid;
  for (const double leaf_size_m : {0.0, -0.02, std::nan(""), std::numeric_limits<double>::infinity(), 1e31}) {
    for (const PointCloud& cloud : {hand_made(), PointCloud()}) {
      const Status status = voxel_grid(cloud, leaf_size_m, LeafPoint::centroid, grid);
      ASSERT_FALSE(status) << leaf_size_m;
      EXPECT_THAT(status.error().message, HasSubstr("leaf-size"));
    }
  }
}

/// The grid as an ordered map from floor(p / leaf) computed point by point: the definition.
std::map<std::array<std::int64_t, 3>, std::uint32_t> leaves_by_definition(const PointCloud& cloud, double leaf_size_m) {
  std::map<std::array<std::int64_t, 3>, std::uint32_t> leaves;
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    std::array<std::int64_t, 3> index{};
    for (int axis = 0; axis < 3; ++axis)
      index[static_cast<std::size_t>(axis)] = static_cast<std::int64_t>(std::floor(cloud.point(i)[axis] / leaf_size_m));
    ++leaves[index];
  }
  return leaves;
}

TEST(VoxelGrid, ReusedAcrossCloudsAndTableGrowth) {
  // More than 2^14 / 2 leaves make the table grow; a smaller cloud afterwards must not see them, nor the other way round.
  RandomStream random = testing::test_random();
  VoxelGrid grid;
  for (const std::size_t size : std::initializer_list<std::size_t>{100, 12000, 50, 30000, 1, 0, 500}) {
    std::vector<Vector3d> points;
    for (std::size_t i = 0; i < size; ++i) points.push_back(testing::uniform_point(random, -1.0, 1.0));
    const PointCloud cloud = testing::cloud_of(points);
    ASSERT_TRUE(voxel_grid(cloud, 0.0625, LeafPoint::centroid, grid));
    const auto expected = leaves_by_definition(cloud, 0.0625);
    EXPECT_EQ(grid.leaves.size(), expected.size());
    EXPECT_EQ(grid.point_count.size(), expected.size());
    EXPECT_EQ(grid.points, size);
    EXPECT_EQ(grid.measured, size);
    EXPECT_EQ(grid.leaf_of.size(), size);
    EXPECT_EQ(std::accumulate(grid.point_count.begin(), grid.point_count.end(), std::size_t{0}), size);
    for (std::size_t i = 0; i < size; ++i) {
      const Vector3d index = (cloud.local(i) / 0.0625).array().floor();
      const Vector3d leaf_index = (grid.leaves.local(grid.leaf_of[i]) / 0.0625).array().floor();
      ASSERT_EQ(index, leaf_index);
    }
    VoxelGrid fresh;
    ASSERT_TRUE(voxel_grid(cloud, 0.0625, LeafPoint::centroid, fresh));
    EXPECT_EQ(grid.leaf_of, fresh.leaf_of);
    EXPECT_EQ(grid.point_count, fresh.point_count);
  }
}

/// The grid of points side by side is that of the cloud of the finite ones.
void expect_grid_of_cloud(const std::vector<float>& data, std::size_t stride, double leaf_size_m, int threads) {
  const std::size_t size = data.empty() ? 0 : (data.size() - 3) / stride + 1;
  PointCloud cloud;
  std::vector<std::size_t> finite;
  for (std::size_t i = 0; i < size; ++i) {
    const Eigen::Map<const Eigen::Vector3f> p(data.data() + i * stride);
    if (p.allFinite()) finite.push_back(i);
  }
  cloud.resize(finite.size());
  for (std::size_t i = 0; i < finite.size(); ++i)
    cloud.set(i, Eigen::Map<const Eigen::Vector3f>(data.data() + finite[i] * stride));
  const VoxelGrid wanted = grid_of(cloud, leaf_size_m);
  VoxelGrid found;
  const PointsView view{.data = data.data(), .size = size, .stride = stride};
  const Vector3d leaf = Vector3d::Constant(leaf_size_m);
  ASSERT_TRUE(voxel_grid(view, {.leaf_size_m = leaf, .threads = threads}, found));
  EXPECT_TRUE(found.leaf_of.empty());
  ASSERT_TRUE(voxel_grid(view, {.leaf_size_m = leaf, .leaf_of = true, .threads = threads}, found));
  EXPECT_EQ(found.point_count, wanted.point_count);
  EXPECT_EQ(found.points, finite.size());
  EXPECT_EQ(found.smallest, wanted.smallest);
  EXPECT_EQ(found.largest, wanted.largest);
  ASSERT_EQ(found.leaves.size(), wanted.leaves.size());
  for (std::size_t i = 0; i < wanted.leaves.size(); ++i) ASSERT_EQ(found.leaves.local(i), wanted.leaves.local(i));
  std::vector<std::uint32_t> leaf_of(size, VoxelGrid::kNoLeaf);
  for (std::size_t i = 0; i < finite.size(); ++i) leaf_of[finite[i]] = wanted.leaf_of[i];
  EXPECT_TRUE(std::equal(leaf_of.begin(), leaf_of.end(), found.leaf_of.begin(), found.leaf_of.end()));
  for (std::size_t i = 0; i < finite.size(); i += 97) {
    EXPECT_EQ(found.leaf_at(found.index_at(Eigen::Map<const Eigen::Vector3f>(data.data() + finite[i] * stride))),
              wanted.leaf_of[i]);
  }
}

TEST(VoxelGrid, PointsWhereTheyLie) {
  RandomStream random = testing::test_random();
  for (const std::size_t stride : std::initializer_list<std::size_t>{3, 4, 8}) {
    for (const std::size_t size : std::initializer_list<std::size_t>{0, 1, 300, 300'001}) {
      for (const bool holes : {false, true}) {
        std::vector<float> data(size == 0 ? 0 : (size - 1) * stride + 3, kNaN);
        for (std::size_t i = 0; i < size; ++i) {
          const double along = 3e-5 * static_cast<double>(i);
          const Vector3d p(along, 0.3 * std::sin(along), 2.0 + 0.01 * random.normal());
          Eigen::Map<Eigen::Vector3f>(data.data() + i * stride) = p.cast<float>();
          if (holes && random.below(3) == 0) data[i * stride + random.below(3)] = random.below(2) == 0 ? kNaN : -INFINITY;
        }
        expect_grid_of_cloud(data, stride, 0.02, size > 300 ? 3 : 1);  // 24 bits of a key or fewer
        expect_grid_of_cloud(data, stride, 1e-6, size > 300 ? 3 : 1);  // more than 32
      }
    }
  }
}

TEST(VoxelGrid, OfPointsThatAreAllNotFiniteIsEmpty) {
  const std::vector<float> data(30, kNaN);
  VoxelGrid grid = grid_of(hand_made(), 1.0);
  ASSERT_TRUE(voxel_grid({.data = data.data(), .size = 10}, {.leaf_of = true}, grid));
  EXPECT_TRUE(grid.leaves.empty());
  EXPECT_THAT(grid.leaf_of, ::testing::Each(VoxelGrid::kNoLeaf));
  EXPECT_EQ(grid.leaf_of.size(), 10U);
  EXPECT_EQ(grid.leaf_at(VoxelGrid::Index::Zero()), VoxelGrid::kNoLeaf);
  EXPECT_FALSE(voxel_grid({.data = data.data(), .size = 10}, {.leaf_size_m = Vector3d::Zero()}, grid));
  EXPECT_FALSE(voxel_grid({.data = data.data(), .size = 10, .stride = 2}, {}, grid));
  EXPECT_FALSE(voxel_grid({.data = nullptr, .size = 10}, {}, grid));
}

TEST(VoxelGrid, ThreadsChangeNothing) {
  // Several parts of a cloud, the last one short; points jump about, so that parts share most of their leaves.
  RandomStream random = testing::test_random();
  constexpr std::size_t kPoints = 700'001;
  PointCloud cloud;
  cloud.resize(kPoints);
  for (std::size_t i = 0; i < kPoints; ++i) cloud.set(i, testing::uniform_point(random, -1.0, 1.0).cast<float>());
  VoxelGrid reused;
  for (const LeafPoint leaf_point : {LeafPoint::centroid, LeafPoint::centre}) {
    const VoxelGrid serial = grid_of(cloud, 0.125, leaf_point);
    EXPECT_EQ(serial.leaves.size(), leaves_by_definition(cloud, 0.125).size());
    std::uint32_t entered = 0;
    std::vector<std::uint32_t> counts(serial.leaves.size());
    for (const std::uint32_t leaf : serial.leaf_of) {
      ASSERT_LE(leaf, entered);  // numbered in the order of their first point
      entered += static_cast<std::uint32_t>(leaf == entered);
      ++counts[leaf];
    }
    EXPECT_TRUE(std::equal(counts.begin(), counts.end(), serial.point_count.begin(), serial.point_count.end()));
    for (const int threads : {2, 5, 3, 0, 1}) {
      ASSERT_TRUE(voxel_grid(cloud, 0.125, leaf_point, reused, threads));
      EXPECT_TRUE(reused.leaf_of == serial.leaf_of);
      EXPECT_TRUE(reused.point_count == serial.point_count);
      ASSERT_EQ(reused.leaves.size(), serial.leaves.size());
      for (std::size_t leaf = 0; leaf < serial.leaves.size(); ++leaf) {
        ASSERT_EQ(reused.leaves.local(leaf), serial.leaves.local(leaf));
      }
    }
  }
}

}  // namespace
}  // namespace fransac
