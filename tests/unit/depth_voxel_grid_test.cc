// SPDX-License-Identifier: Apache-2.0
// The voxel grid of a depth image: against its definition pixel by pixel, and against that of the deprojected cloud.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>
#include <map>
#include <set>
#include <unordered_map>
#include <vector>

#include "filter/leaf_bars.hpp"
#include "filter/leaf_table.hpp"
#include "fransac/filter/deproject.hpp"
#include "fransac/filter/pass_through.hpp"
#include "fransac/filter/voxel_grid.hpp"
#include "support.hpp"

namespace fransac {
namespace {

using Eigen::Vector3d;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

/// A depth image in both formats that owns its pixels. Float depth is the 16-bit one in metres and a little more, so that its
/// lowest bits are in use.
struct Frame {
  Frame(int width, int height, double scale)
      : camera(testing::small_camera(width, height)), units(static_cast<std::size_t>(width) * static_cast<std::size_t>(height)) {
    camera.depth_scale = scale;
    metres.resize(units.size());
    // A field of view of some 70 degrees, whatever the size.
    camera.fx = 0.7 * width + 1.0;
    camera.fy = 0.72 * width + 1.0;
  }

  /// Two slopes, noise, and holes.
  Frame(int width, int height, double scale, RandomStream& random) : Frame(width, height, scale) {
    const Plane left = *make_plane({testing::uniform(random, -0.5, 0.5), testing::uniform(random, -0.5, 0.5), -1.0}, 1.5);
    const Plane right = *make_plane({testing::uniform(random, -0.5, 0.5), testing::uniform(random, -0.5, 0.5), -1.0}, 2.2);
    for (int v = 0; v < height; ++v) {
      for (int u = 0; u < width; ++u) {
        const double z = testing::depth_on(2 * u < width ? left : right, camera, u, v) + 0.003 * random.normal();
        set(u, v, random.below(10) == 0 || z < 0.1 ? 0.0 : z);
      }
    }
  }

  void set(int u, int v, double z) {
    const auto i = static_cast<std::size_t>(v) * static_cast<std::size_t>(camera.width) + static_cast<std::size_t>(u);
    units[i] = static_cast<std::uint16_t>(std::min(z * camera.depth_scale, 65535.0));
    metres[i] = static_cast<float>(z);
  }
  [[nodiscard]] DepthView view(DepthFormat format) const {
    return format == DepthFormat::uint16 ? DepthView::from_uint16(units.data(), camera.width, camera.height, camera.depth_scale)
                                         : DepthView::from_float(metres.data(), camera.width, camera.height);
  }

  Camera camera;
  std::vector<std::uint16_t> units;
  std::vector<float> metres;
};

constexpr DepthFormat kFormats[] = {DepthFormat::uint16, DepthFormat::float32};
/// Depths of whole millimetres would lie on the borders of leaves now and then; these hardly ever do.
constexpr double kOddScale = 1013.7;

VoxelGrid grid_of(const DepthView& depth, const Camera& camera, const DepthGridOptions& options) {
  VoxelGrid grid;
  const Status status = voxel_grid(depth, camera, options, grid);
  EXPECT_TRUE(status) << (status ? "" : status.error().message);
  return grid;
}

/// The points that go into the grid, with their pixels.
PointCloud kept_cloud(const DepthView& depth, const Camera& camera, const DepthGridOptions& options, std::size_t* measured) {
  PointCloud cloud;
  deproject(depth, camera, cloud);
  *measured = cloud.size();
  if (options.limits != nullptr) pass_through(*options.limits, cloud);
  return cloud;
}

void expect_same_leaves(const VoxelGrid& a, const VoxelGrid& b) {
  ASSERT_EQ(a.leaves.size(), b.leaves.size());
  EXPECT_TRUE(std::equal(a.leaves.x(), a.leaves.x() + a.leaves.size(), b.leaves.x()));
  EXPECT_TRUE(std::equal(a.leaves.y(), a.leaves.y() + a.leaves.size(), b.leaves.y()));
  EXPECT_TRUE(std::equal(a.leaves.z(), a.leaves.z() + a.leaves.size(), b.leaves.z()));
  EXPECT_TRUE(a.point_count == b.point_count);
  EXPECT_EQ(a.points, b.points);
  EXPECT_EQ(a.measured, b.measured);
}

/// Leaves are numbered as pixels enter them, and hold as many as they say.
void expect_numbers_and_counts(const VoxelGrid& grid) {
  std::uint32_t entered = 0;
  std::vector<std::uint32_t> counts(grid.leaves.size());
  for (const std::uint32_t leaf : grid.leaf_of) {
    if (leaf == VoxelGrid::kNoLeaf) continue;
    ASSERT_LE(leaf, entered);
    ASSERT_LT(leaf, counts.size());
    if (leaf == entered) ++entered;
    ++counts[leaf];
  }
  EXPECT_EQ(entered, grid.leaves.size());
  EXPECT_TRUE(std::equal(counts.begin(), counts.end(), grid.point_count.begin(), grid.point_count.end()));
}

/// Centroids against sums in long double over the pixels of each leaf.
void expect_centroids(const DepthView& depth, const Camera& camera, const VoxelGrid& grid) {
  struct Sum {
    long double x = 0, y = 0, z = 0;
    long double across = 0;  ///< Of what x and y are differences of.
  };
  std::vector<Sum> sums(grid.leaves.size());
  long double largest = 0;
  for (std::size_t i = 0; i < grid.leaf_of.size(); ++i) {
    if (grid.leaf_of[i] == VoxelGrid::kNoLeaf) continue;
    const auto u = static_cast<int>(i) % camera.width;
    const auto v = static_cast<int>(i) / camera.width;
    const long double z = depth.format() == DepthFormat::uint16
                              ? depth.row_uint16(v)[u] * static_cast<long double>(depth.metres_per_unit())
                              : static_cast<long double>(depth.row_float(v)[u]);
    Sum& sum = sums[grid.leaf_of[i]];
    sum.x += z * (u - static_cast<long double>(camera.cx)) / static_cast<long double>(camera.fx);
    sum.y += z * (v - static_cast<long double>(camera.cy)) / static_cast<long double>(camera.fy);
    sum.z += z;
    const double widest = std::max((u + std::abs(camera.cx)) / camera.fx, (v + std::abs(camera.cy)) / camera.fy);
    sum.across += z * static_cast<long double>(widest);
    largest = std::max(largest, z);
  }
  // Sums of 16-bit depth are exact, so some roundings of the result are left; float depth is cut to 2^-24 of the largest, or to
  // what lets the sum of all pixels fit into 40 bits.
  const int bits = std::min(24, 40 - static_cast<int>(std::bit_width(depth.size())));
  const long double cut = depth.format() == DepthFormat::uint16 ? 0.0L : std::ldexp(largest, -bits);
  for (std::size_t leaf = 0; leaf < sums.size(); ++leaf) {
    const Sum& sum = sums[leaf];
    const auto n = static_cast<long double>(grid.point_count[leaf]);
    const Vector3d p = grid.leaves.local(leaf);
    const long double wide = sum.across / sum.z;  // of the largest ray, plus that of the principal point
    ASSERT_NEAR(p.x(), static_cast<double>(sum.x / n), static_cast<double>(0x1p-21L * sum.across / n + cut * wide));
    ASSERT_NEAR(p.y(), static_cast<double>(sum.y / n), static_cast<double>(0x1p-21L * sum.across / n + cut * wide));
    ASSERT_NEAR(p.z(), static_cast<double>(sum.z / n), static_cast<double>(0x1p-22L * sum.z / n + cut));
  }
}

std::array<std::int64_t, 3> index_of(const Vector3d& centre, double leaf_size_m) {
  return {std::llround(centre.x() / leaf_size_m - 0.5), std::llround(centre.y() / leaf_size_m - 0.5),
          std::llround(centre.z() / leaf_size_m - 0.5)};
}

/// Every pixel lies in the cube around its leaf's centre, and no cube is there twice.
void expect_cubes(const DepthView& depth, const Camera& camera, const VoxelGrid& centres, double leaf_size_m) {
  std::set<std::array<std::int64_t, 3>> cubes;
  for (std::size_t leaf = 0; leaf < centres.leaves.size(); ++leaf) {
    const Vector3d halves = centres.leaves.local(leaf) / leaf_size_m - Vector3d::Constant(0.5);
    EXPECT_LT((halves - halves.array().round().matrix()).cwiseAbs().maxCoeff(), 1e-3);
    EXPECT_TRUE(cubes.insert(index_of(centres.leaves.local(leaf), leaf_size_m)).second) << "leaf " << leaf;
  }
  for (std::size_t i = 0; i < centres.leaf_of.size(); ++i) {
    if (centres.leaf_of[i] == VoxelGrid::kNoLeaf) continue;
    const auto u = static_cast<int>(i) % camera.width;
    const auto v = static_cast<int>(i) / camera.width;
    const Vector3d p = static_cast<double>(depth.metres(u, v)) * testing::ray(camera, u, v);
    const Vector3d off = (p - centres.leaves.local(centres.leaf_of[i])).cwiseAbs();
    // Depth in leaves, ray and product are rounded to 2^-24 each; the centre itself, too.
    const double slack = 0x1p-21 * (p.norm() + leaf_size_m);
    ASSERT_LE(off.maxCoeff(), leaf_size_m / 2 + slack) << "pixel " << u << ", " << v;
  }
}

/// All that is true of any grid of a depth image.
void expect_grid(const DepthView& depth, const Camera& camera, DepthGridOptions options, VoxelGrid& grid) {
  options.leaf_of = true;
  options.leaf_point = LeafPoint::centroid;
  const Status status = voxel_grid(depth, camera, options, grid);
  ASSERT_TRUE(status) << status.error().message;
  std::size_t measured = 0;
  const PointCloud cloud = kept_cloud(depth, camera, options, &measured);
  EXPECT_EQ(grid.measured, measured);
  EXPECT_EQ(grid.points, cloud.size());
  EXPECT_TRUE(grid.leaves.source.empty());
  EXPECT_EQ(grid.leaves.origin, Vector3d::Zero());
  EXPECT_EQ(grid.leaves.width, static_cast<int>(grid.leaves.size()));
  for (std::size_t i = grid.leaves.size(); i < grid.leaves.padded_size(); ++i) EXPECT_TRUE(std::isnan(grid.leaves.z()[i]));

  ASSERT_EQ(grid.leaf_of.size(), depth.size());
  std::vector<bool> in_a_leaf(depth.size());
  for (const std::uint32_t pixel : cloud.source) in_a_leaf[pixel] = true;
  for (std::size_t i = 0; i < depth.size(); ++i) ASSERT_EQ(grid.leaf_of[i] != VoxelGrid::kNoLeaf, in_a_leaf[i]) << i;
  expect_numbers_and_counts(grid);
  expect_centroids(depth, camera, grid);

  DepthGridOptions centre_options = options;
  centre_options.leaf_point = LeafPoint::centre;
  const VoxelGrid centres = grid_of(depth, camera, centre_options);
  EXPECT_TRUE(centres.leaf_of == grid.leaf_of);
  expect_cubes(depth, camera, centres, options.leaf_size_m);

  options.leaf_of = false;
  for (const int threads : {1, 2, 5}) {
    options.threads = threads;
    const VoxelGrid bare = grid_of(depth, camera, options);
    EXPECT_TRUE(bare.leaf_of.empty());
    expect_same_leaves(bare, grid);
  }
}

TEST(DepthVoxelGrid, KeepsItsWordAtAnySizeAndLeaf) {
  RandomStream random = testing::test_random();
  VoxelGrid grid;
  for (const auto& [width, height] :
       std::vector<std::pair<int, int>>{{1, 1}, {1, 40}, {15, 3}, {16, 9}, {17, 20}, {80, 60}, {333, 41}, {640, 37}, {700, 11}}) {
    const Frame frame(width, height, kOddScale, random);
    for (const DepthFormat format : kFormats) {
      for (const double leaf_size_m : {0.007, 0.02, 0.3, 4.0}) {
        SCOPED_TRACE(::testing::Message() << width << " x " << height << (format == DepthFormat::uint16 ? " uint16 " : " float ")
                                          << leaf_size_m);
        expect_grid(frame.view(format), frame.camera, {.leaf_size_m = leaf_size_m}, grid);
        if (HasFatalFailure()) return;
      }
    }
  }
}

TEST(DepthVoxelGrid, KeepsItsWordWithinLimits) {
  RandomStream random = testing::test_random();
  VoxelGrid grid;
  const Frame frame(127, 53, kOddScale, random);
  for (const DepthFormat format : kFormats) {
    for (const Axis axis : {Axis::x, Axis::y, Axis::z}) {
      for (const bool outside : {false, true}) {
        for (const auto& [min_m, max_m] : std::vector<std::pair<double, double>>{
                 {0.2, 0.5}, {-0.31, 0.17}, {1.2, 1.9}, {-1e300, 1e300}, {0.0, 4.5}, {7.0, 9.0}, {-9.0, -7.0}, {-3.0, 0.0}}) {
          SCOPED_TRACE(::testing::Message() << "axis " << static_cast<int>(axis) << (outside ? " outside " : " inside ") << min_m
                                            << ' ' << max_m);
          const AxisLimits limits{.axis = axis, .min_m = min_m, .max_m = max_m, .outside = outside};
          expect_grid(frame.view(format), frame.camera, {.limits = &limits}, grid);
          if (HasFatalFailure()) return;
        }
      }
    }
  }
}

TEST(DepthVoxelGrid, LimitsThatNoFloatMeets) {
  // 0.1 lies between two floats: nothing is exactly 0.1 m deep, neither the float above nor the one below. And nothing is deeper
  // than the largest depth.
  const float above = 0.1F;
  const std::vector<float> pixels{above, std::nextafter(above, 0.0F), kMaxDepth_m, 0.0F};
  const Camera camera = testing::small_camera(2, 2);
  for (const auto& [min_m, max_m] : std::vector<std::pair<double, double>>{{0.1, 0.1}, {2e5, 3e5}}) {
    const AxisLimits limits{.axis = Axis::z, .min_m = min_m, .max_m = max_m};
    const VoxelGrid grid = grid_of(DepthView::from_float(pixels.data(), 2, 2), camera, {.limits = &limits});
    EXPECT_EQ(grid.points, 0U);
    EXPECT_EQ(grid.measured, 3U);
    EXPECT_TRUE(grid.leaves.empty());
  }
}

TEST(DepthVoxelGrid, LargeLeavesOfFloatDepthHoldManyPixels) {
  // Four leaves of 76,800 pixels each.
  Frame frame(640, 480, 1000.0);
  for (int v = 0; v < 480; ++v) {
    for (int u = 0; u < 640; ++u) frame.set(u, v, 2.0);
  }
  VoxelGrid grid;
  for (const DepthFormat format : kFormats) expect_grid(frame.view(format), frame.camera, {.leaf_size_m = 5.0}, grid);
}

TEST(DepthVoxelGrid, TheDeepestFramesOf16Bits) {
  // Every value the largest there is, more than 256 columns of it in a leaf.
  Frame frame(1000, 300, 10000.0);
  std::fill(frame.units.begin(), frame.units.end(), std::uint16_t{0xFFFF});
  VoxelGrid grid;
  expect_grid(frame.view(DepthFormat::uint16), frame.camera, {.leaf_size_m = 5.0}, grid);
  expect_grid(frame.view(DepthFormat::uint16), frame.camera, {.leaf_size_m = 0.02}, grid);
}

/// Leaves by their place.
struct Leaf {
  std::uint32_t count;
  Vector3d centroid;
};
std::map<std::array<std::int64_t, 3>, Leaf> by_place(const VoxelGrid& centroids, const VoxelGrid& centres, double leaf_size_m) {
  std::map<std::array<std::int64_t, 3>, Leaf> leaves;
  for (std::size_t i = 0; i < centres.leaves.size(); ++i) {
    leaves[index_of(centres.leaves.local(i), leaf_size_m)] = {centroids.point_count[i], centroids.leaves.local(i)};
  }
  return leaves;
}

TEST(DepthVoxelGrid, TheSameLeavesAsThoseOfTheCloud) {
  RandomStream random = testing::test_random();
  const AxisLimits limits{.axis = Axis::z, .min_m = 0.5, .max_m = 2.5};
  for (const DepthFormat format : kFormats) {
    for (const AxisLimits* within : {static_cast<const AxisLimits*>(nullptr), &limits}) {
      const Frame frame(320, 240, kOddScale, random);
      DepthGridOptions options{.limits = within};
      std::size_t measured = 0;
      const PointCloud cloud = kept_cloud(frame.view(format), frame.camera, options, &measured);
      const VoxelGrid ours = grid_of(frame.view(format), frame.camera, options);
      options.leaf_point = LeafPoint::centre;
      const VoxelGrid our_centres = grid_of(frame.view(format), frame.camera, options);
      VoxelGrid theirs;
      VoxelGrid their_centres;
      ASSERT_TRUE(voxel_grid(cloud, options.leaf_size_m, LeafPoint::centroid, theirs));
      ASSERT_TRUE(voxel_grid(cloud, options.leaf_size_m, LeafPoint::centre, their_centres));

      const auto expected = by_place(theirs, their_centres, options.leaf_size_m);
      const auto found = by_place(ours, our_centres, options.leaf_size_m);
      int different = std::abs(static_cast<int>(expected.size()) - static_cast<int>(found.size()));
      for (const auto& [place, leaf] : found) {
        const auto same = expected.find(place);
        if (same == expected.end() || same->second.count != leaf.count) {
          ++different;  // a pixel on the border went to the neighbour
        } else {
          EXPECT_LT((same->second.centroid - leaf.centroid).norm(), 1e-5);
        }
      }
      EXPECT_GT(found.size(), 3000U);
      EXPECT_LE(different, 10) << "of " << found.size();
    }
  }
}

TEST(DepthVoxelGrid, CentroidsAndCentresByHand) {
  // Focal length 2 px, principal point at the first pixel. Leaves of 1 m; depth in quarters of a metre.
  const Camera camera{.width = 4, .height = 2, .fx = 2.0, .fy = 2.0, .cx = 0.0, .cy = 0.0, .depth_scale = 4.0};
  const std::vector<std::uint16_t> pixels{2, 2, 6, 0,   // (0, 0, .5), (.25, 0, .5), (1.5, 0, 1.5), -
                                          2, 0, 6, 5};  // (0, .25, .5), -, (1.5, .75, 1.5), (1.875, .625, 1.25)
  const DepthView depth = DepthView::from_uint16(pixels.data(), 4, 2, 4.0);
  const VoxelGrid grid = grid_of(depth, camera, {.leaf_size_m = 1.0, .leaf_of = true});
  constexpr std::uint32_t kNone = VoxelGrid::kNoLeaf;
  EXPECT_THAT(grid.leaf_of, ElementsAre(0, 0, 1, kNone, 0, kNone, 1, 1));
  EXPECT_THAT(grid.point_count, ElementsAre(3, 3));
  EXPECT_LT((grid.leaves.local(0) - Vector3d(0.25 / 3, 0.25 / 3, 0.5)).norm(), 1e-7);
  EXPECT_LT((grid.leaves.local(1) - Vector3d(4.875 / 3, 1.375 / 3, 4.25 / 3)).norm(), 2e-7);
  const VoxelGrid centres = grid_of(depth, camera, {.leaf_size_m = 1.0, .leaf_point = LeafPoint::centre});
  ASSERT_EQ(centres.leaves.size(), 2U);
  EXPECT_EQ(centres.leaves.local(0), Vector3d(0.5, 0.5, 0.5));
  EXPECT_EQ(centres.leaves.local(1), Vector3d(1.5, 0.5, 1.5));
}

TEST(DepthVoxelGrid, RowsMayLieAnywhere) {
  RandomStream random = testing::test_random();
  for (const int width : {64, 61}) {
    const Frame frame(width, 40, 1000.0, random);
    const DepthGridOptions options{.leaf_of = true};
    const int padded = width + 7;
    std::vector<std::uint16_t> units(static_cast<std::size_t>(padded) * 40, 1234);  // not zero: nobody may look there
    std::vector<float> metres(units.size(), 1.234F);
    // Rows from the top down, then from the bottom up.
    for (const bool upward : {false, true}) {
      for (int v = 0; v < 40; ++v) {
        const int row = upward ? 39 - v : v;
        std::copy_n(frame.units.begin() + v * width, width, units.begin() + row * padded);
        std::copy_n(frame.metres.begin() + v * width, width, metres.begin() + row * padded);
      }
      const std::ptrdiff_t sign = upward ? -1 : 1;
      const std::ptrdiff_t first = upward ? 39 * padded : 0;
      const VoxelGrid of_units =
          grid_of(DepthView::from_uint16(units.data() + first, width, 40, 1000.0, sign * padded * 2), frame.camera, options);
      const VoxelGrid of_metres =
          grid_of(DepthView::from_float(metres.data() + first, width, 40, sign * padded * 4), frame.camera, options);
      const VoxelGrid expected_units = grid_of(frame.view(DepthFormat::uint16), frame.camera, options);
      const VoxelGrid expected_metres = grid_of(frame.view(DepthFormat::float32), frame.camera, options);
      expect_same_leaves(of_units, expected_units);
      expect_same_leaves(of_metres, expected_metres);
      EXPECT_TRUE(of_units.leaf_of == expected_units.leaf_of);
      EXPECT_TRUE(of_metres.leaf_of == expected_metres.leaf_of);
    }
  }
}

TEST(DepthVoxelGrid, FloatsThatAreNoMeasurements) {
  constexpr float kInf = std::numeric_limits<float>::infinity();
  constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();
  const std::vector<float> pixels{0.0F, 1.0F, -1.0F, kNaN, 2.0F, kInf, -kInf, 3.0F, 2e5F, -0.0F};
  const Camera camera = testing::small_camera(10, 1);
  VoxelGrid grid;
  expect_grid(DepthView::from_float(pixels.data(), 10, 1), camera, {}, grid);
  EXPECT_EQ(grid.measured, 3U);
  EXPECT_EQ(grid.leaf_of[3], VoxelGrid::kNoLeaf);
}

TEST(DepthVoxelGrid, TinyLeavesTakeTheWayThroughTheCloud) {
  RandomStream random = testing::test_random();
  const Frame frame(80, 60, kOddScale, random);
  const AxisLimits limits{.axis = Axis::z, .min_m = 1.0, .max_m = 2.0};
  VoxelGrid grid;
  for (const DepthFormat format : kFormats) {
    for (const double leaf_size_m : {1e-3, 2e-4, 1e-5}) {
      for (const AxisLimits* within : {static_cast<const AxisLimits*>(nullptr), &limits}) {
        DepthGridOptions options{.leaf_size_m = leaf_size_m, .limits = within, .leaf_of = true};
        ASSERT_TRUE(voxel_grid(frame.view(format), frame.camera, options, grid));
        expect_numbers_and_counts(grid);
        expect_centroids(frame.view(format), frame.camera, grid);
        std::size_t measured = 0;
        const PointCloud cloud = kept_cloud(frame.view(format), frame.camera, options, &measured);
        EXPECT_EQ(grid.measured, measured);
        EXPECT_EQ(grid.points, cloud.size());
        ASSERT_EQ(grid.leaf_of.size(), frame.units.size());
        EXPECT_EQ(static_cast<std::size_t>(std::count(grid.leaf_of.begin(), grid.leaf_of.end(), VoxelGrid::kNoLeaf)),
                  frame.units.size() - cloud.size());
        options.leaf_of = false;
        const VoxelGrid bare = grid_of(frame.view(format), frame.camera, options);
        EXPECT_TRUE(bare.leaf_of.empty());
        expect_same_leaves(bare, grid);
      }
    }
  }
}

TEST(DepthVoxelGrid, ReusedForFramesOfAllKinds) {
  // Whatever a frame leaves in the tables must not show in the next, of another size, format, leaf or range.
  RandomStream random = testing::test_random();
  VoxelGrid reused;
  const AxisLimits limits[] = {{.axis = Axis::z, .min_m = 0.0, .max_m = 1.6}, {.axis = Axis::x, .min_m = -0.2, .max_m = 9.0}};
  for (int i = 0; i < 150; ++i) {
    const Frame frame(1 + static_cast<int>(random.below(200)), 1 + static_cast<int>(random.below(60)), 1000.0, random);
    constexpr double kLeaves[] = {0.02, 0.013, 0.1, 1.0, 0.02, 3e-4};
    const std::uint32_t limited = random.below(3);
    const DepthGridOptions options{.leaf_size_m = kLeaves[random.below(6)],
                                   .leaf_point = random.below(4) == 0 ? LeafPoint::centre : LeafPoint::centroid,
                                   .limits = limited < 2 ? &limits[limited] : nullptr,
                                   .leaf_of = random.below(2) == 0};
    const DepthView depth = frame.view(kFormats[random.below(2)]);
    ASSERT_TRUE(voxel_grid(depth, frame.camera, options, reused));
    const VoxelGrid fresh = grid_of(depth, frame.camera, options);
    expect_same_leaves(reused, fresh);
    ASSERT_TRUE(reused.leaf_of == fresh.leaf_of) << i;
    if (random.below(10) == 0) {  // a cloud in between, or an error
      VoxelGrid of_cloud;
      const PointCloud cloud = testing::noisy_plane(300, 100, 0.01, random);
      ASSERT_TRUE(voxel_grid(cloud, 0.05, LeafPoint::centroid, reused));
      ASSERT_TRUE(voxel_grid(cloud, 0.05, LeafPoint::centroid, of_cloud));
      expect_same_leaves(reused, of_cloud);
      EXPECT_FALSE(voxel_grid(depth, frame.camera, {.leaf_size_m = -1.0}, reused));
    }
  }
}

TEST(DepthVoxelGrid, ThreadsChangeNothing) {
  // Large enough for a band of rows per thread.
  RandomStream random = testing::test_random();
  const Frame frame(1023, 1100, kOddScale, random);
  ASSERT_GE(frame.units.size(), std::size_t{1} << 20);
  VoxelGrid reused;
  for (const DepthFormat format : kFormats) {
    for (const LeafPoint leaf_point : {LeafPoint::centroid, LeafPoint::centre}) {
      DepthGridOptions options{.leaf_point = leaf_point, .leaf_of = true};
      const VoxelGrid serial = grid_of(frame.view(format), frame.camera, options);
      expect_numbers_and_counts(serial);
      options.leaf_of = false;
      for (const int threads : {1, 2, 5, 3, 0}) {
        options.threads = threads;
        ASSERT_TRUE(voxel_grid(frame.view(format), frame.camera, options, reused));
        expect_same_leaves(reused, serial);
      }
    }
  }
}

TEST(DepthVoxelGrid, NothingMeasured) {
  const Frame frame(40, 30, 1000.0);
  VoxelGrid grid;
  for (const DepthFormat format : kFormats) {
    for (const double leaf_size_m : {0.02, 1e-9, 1e9}) {
      ASSERT_TRUE(voxel_grid(frame.view(format), frame.camera, {.leaf_size_m = leaf_size_m, .leaf_of = true}, grid));
      EXPECT_TRUE(grid.leaves.empty());
      EXPECT_TRUE(grid.point_count.empty());
      EXPECT_EQ(grid.measured, 0U);
      EXPECT_EQ(grid.points, 0U);
      EXPECT_EQ(grid.leaf_of.size(), 1200U);
    }
  }
}

TEST(DepthVoxelGrid, AbsurdLeafSizes) {
  RandomStream random = testing::test_random();
  const Frame frame(40, 30, 1000.0, random);
  VoxelGrid grid;
  for (const DepthFormat format : kFormats) {
    for (const double leaf_size_m : {0.0, -0.02, std::nan(""), std::numeric_limits<double>::infinity(), 1e-300, 1e-12,
                                     std::numeric_limits<double>::denorm_min(), 1e31, 1e300}) {
      const Status status = voxel_grid(frame.view(format), frame.camera, {.leaf_size_m = leaf_size_m}, grid);
      ASSERT_FALSE(status) << leaf_size_m;
      EXPECT_EQ(status.error().code, ErrorCode::invalid_argument);
      EXPECT_THAT(status.error().message, HasSubstr("leaf-size"));
    }
    for (const double leaf_size_m : {1e3, 1e9, 1e30}) {
      // Four leaves meet at the optical axis.
      expect_grid(frame.view(format), frame.camera, {.leaf_size_m = leaf_size_m}, grid);
      EXPECT_EQ(grid.leaves.size(), 4U);
    }
  }
}

TEST(DepthVoxelGrid, AbsurdCameras) {
  RandomStream random = testing::test_random();
  const Frame frame(40, 30, 1000.0, random);
  VoxelGrid grid;
  for (const auto& [f, c] :
       std::vector<std::pair<double, double>>{{0.1, 20.0}, {1e6, 20.0}, {60.0, 1e6}, {60.0, -1e6}, {0.1, 1e6}}) {
    Camera camera = frame.camera;
    camera.fx = camera.fy = f;
    camera.cx = camera.cy = c;
    for (const DepthFormat format : kFormats) {
      SCOPED_TRACE(::testing::Message() << "f " << f << " c " << c);
      const Status status = voxel_grid(frame.view(format), camera, {.leaf_of = true}, grid);
      if (!status) continue;  // too many leaves
      EXPECT_EQ(grid.points, grid.measured);
      expect_numbers_and_counts(grid);
      expect_centroids(frame.view(format), camera, grid);
    }
  }
}

// ---- the tables behind ----

/// Numbers as a map gives them.
class PlainNumbers {
 public:
  std::uint32_t number_of(std::uint64_t key) {
    return numbers_.emplace(key, static_cast<std::uint32_t>(numbers_.size())).first->second;
  }
  [[nodiscard]] std::uint32_t size() const { return static_cast<std::uint32_t>(numbers_.size()); }

 private:
  std::unordered_map<std::uint64_t, std::uint32_t> numbers_;
};

TEST(LeafBars, NumberLikeAMapOverManyFrames) {
  RandomStream random = testing::test_random();
  LeafBars bars;
  for (int frame = 0; frame < 60; ++frame) {
    const int key_bits = LeafBars::kLeafBits + static_cast<int>(random.below(15));
    bars.restart(key_bits);
    PlainNumbers expected;
    const std::uint32_t lookups = random.below(3000);
    const std::uint32_t range = 1U << key_bits;
    for (std::uint32_t done = 0; done < lookups;) {
      LeafBars::Row row(bars);
      for (std::uint32_t end = done + 1 + random.below(100); done < end; ++done) {
        const std::uint32_t key = random.below(3) == 0 ? random.below(range) : random.below(std::min(range, 200U));
        ASSERT_EQ(row.number_of(key), expected.number_of(key));
      }
    }
    EXPECT_EQ(bars.leaves(), expected.size());
  }
}

TEST(LeafTable, NumbersLikeAMapOverManyFrames) {
  RandomStream random = testing::test_random();
  LeafTable<std::uint64_t> table;
  for (int frame = 0; frame < 60; ++frame) {
    table.restart();
    PlainNumbers expected;
    // Enough to make the table grow in the middle of a frame now and then; keys in clumps and far apart.
    const std::uint32_t lookups = random.below(frame % 10 == 5 ? 40000U : 2000U);
    for (std::uint32_t i = 0; i < lookups; ++i) {
      const std::uint64_t far = std::uint64_t{random.next()} << 31 | random.next();
      const std::uint64_t key = random.below(2) == 0 ? far : random.below(5000);
      ASSERT_EQ(table.find_or_add(key), expected.number_of(key));
    }
    EXPECT_EQ(table.size(), expected.size());
  }
}

}  // namespace
}  // namespace fransac
