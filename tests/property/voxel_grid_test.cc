// SPDX-License-Identifier: Apache-2.0
#include "fransac/filter/voxel_grid.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <map>
#include <numeric>
#include <vector>

#include "property/property.hpp"

namespace fransac {
namespace {

using Eigen::Vector3d;
using testing::any_number;

/// Up to 400 points, in clumps so that leaves hold several, up to 20 m from the local origin.
std::vector<Vector3d> any_points() {
  RandomStream random = testing::any_stream();
  const int size = *rc::gen::inRange(1, 400);
  const Vector3d centre = testing::uniform_point(random, -20.0, 20.0);
  std::vector<Vector3d> points;
  for (int i = 0; i < size; ++i) {
    const double spread = i % 3 == 0 ? 0.5 : 0.05;
    points.push_back((centre + testing::uniform_point(random, -spread, spread)).cast<float>().cast<double>());
  }
  return points;
}

Vector3d any_origin() {
  return *rc::gen::element(Vector3d(0, 0, 0), Vector3d(0.013, -7.7, 1234.5), Vector3d(5e5 + 0.37, 5.4e6 + 0.11, 200.005));
}

/// Two steps of a float at 20 m, and of a double at 5.4e6 m: what rounding may move a point.
constexpr double kRounding = 2 * 1.9e-6;

VoxelGrid grid_of(const PointCloud& cloud, double leaf_size_m, LeafPoint leaf_point) {
  VoxelGrid grid;
  RC_ASSERT(voxel_grid(cloud, leaf_size_m, leaf_point, grid).ok());
  return grid;
}

TEST(VoxelGridProperty, PointsAndCentroidsLieInTheirLeafAndCountsAddUp) {
  testing::check_property(60, [] {
    const PointCloud cloud = testing::cloud_of(any_points(), any_origin());
    const double leaf = any_number(0.005, 0.5);
    const VoxelGrid centroids = grid_of(cloud, leaf, LeafPoint::centroid);
    const VoxelGrid centres = grid_of(cloud, leaf, LeafPoint::centre);
    const std::size_t leaves = centroids.leaves.size();
    RC_ASSERT(centroids.leaf_of == centres.leaf_of);
    RC_ASSERT(centroids.leaf_of.size() == cloud.size());
    RC_ASSERT(centroids.point_count.size() == leaves);

    std::vector<std::uint32_t> counts(leaves);
    std::vector<Vector3d> sums(leaves, Vector3d::Zero());
    std::uint32_t seen = 0;
    for (std::size_t i = 0; i < cloud.size(); ++i) {
      const std::uint32_t l = centroids.leaf_of[i];
      RC_ASSERT(l <= seen);  // numbered in the order of their first point
      if (l == seen) ++seen;
      ++counts[l];
      sums[l] += cloud.local(i);
      // In the cube around the centre.
      RC_ASSERT((cloud.local(i) - centres.leaves.local(l)).cwiseAbs().maxCoeff() <= leaf / 2 + kRounding);
    }
    RC_ASSERT(seen == leaves);
    for (std::size_t l = 0; l < leaves; ++l) {
      RC_ASSERT(counts[l] == centroids.point_count[l]);
      RC_ASSERT((sums[l] / counts[l] - centroids.leaves.local(l)).norm() <= kRounding);
      RC_ASSERT((centroids.leaves.local(l) - centres.leaves.local(l)).cwiseAbs().maxCoeff() <= leaf / 2 + kRounding);
      // The lattice contains the origin of the input's coordinates: centres are odd multiples of half a leaf.
      const Vector3d halves = centres.leaves.point(l) / leaf - Vector3d::Constant(0.5);
      RC_ASSERT((halves - halves.array().round().matrix()).cwiseAbs().maxCoeff() * leaf <= kRounding);
    }
    for (std::size_t i = 0; i < cloud.size(); ++i) {
      RC_ASSERT(centroids.leaf_at(centroids.index_at(cloud.local(i).cast<float>())) == centroids.leaf_of[i]);
    }
    // No two leaves are the same cube.
    for (std::size_t a = 0; a < leaves; ++a) {
      for (std::size_t b = 0; b < a; ++b) {
        RC_ASSERT((centres.leaves.local(a) - centres.leaves.local(b)).cwiseAbs().maxCoeff() > leaf / 2);
      }
    }
  });
}

TEST(VoxelGridProperty, OrderOfThePointsChangesOnlyTheOrderOfTheLeaves) {
  testing::check_property(60, [] {
    const std::vector<Vector3d> points = any_points();
    const Vector3d origin = any_origin();
    const double leaf = any_number(0.01, 0.5);
    std::vector<std::size_t> order(points.size());
    std::iota(order.begin(), order.end(), std::size_t{0});
    RandomStream random = testing::any_stream();
    for (std::size_t i = order.size(); i > 1; --i) std::swap(order[i - 1], order[random.below(static_cast<std::uint32_t>(i))]);
    std::vector<Vector3d> shuffled;
    for (const std::size_t i : order) shuffled.push_back(points[i]);

    const VoxelGrid a = grid_of(testing::cloud_of(points, origin), leaf, LeafPoint::centroid);
    const VoxelGrid b = grid_of(testing::cloud_of(shuffled, origin), leaf, LeafPoint::centroid);
    RC_ASSERT(a.leaves.size() == b.leaves.size());
    std::map<std::uint32_t, std::uint32_t> partner;  // the leaf of `a` that a leaf of `b` must be
    for (std::size_t i = 0; i < order.size(); ++i) {
      const auto [place, added] = partner.emplace(b.leaf_of[i], a.leaf_of[order[i]]);
      RC_ASSERT(place->second == a.leaf_of[order[i]]);
    }
    for (const auto& [of_b, of_a] : partner) {
      RC_ASSERT(b.point_count[of_b] == a.point_count[of_a]);
      RC_ASSERT((b.leaves.local(of_b) - a.leaves.local(of_a)).norm() <= kRounding);  // sums of doubles in another order
    }
  });
}

}  // namespace
}  // namespace fransac
