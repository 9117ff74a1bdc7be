// SPDX-License-Identifier: Apache-2.0
/// Memory of voxel grids between calls.
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "filter/depth_rows.hpp"
#include "filter/leaf_bars.hpp"
#include "filter/leaf_table.hpp"
#include "filter/point_buckets.hpp"
#include "filter/ranks.hpp"
#include "fransac/filter/voxel_grid.hpp"
#include "kernels/points.h"

namespace fransac {

/// The pixels of one leaf: sums of raw depth d, d u and d v, which are whole numbers. They hold kMostPixels pixels.
struct LeafSums {
  static constexpr int kCountShift = 40;
  static constexpr std::size_t kMostPixels = std::size_t{1} << (64 - kCountShift);

  std::uint64_t d_and_count = 0;  ///< d in the low 40 bits, the number of pixels above.
  std::uint64_t du = 0;
  std::uint64_t dv = 0;
  std::uint64_t key = 0;

  [[nodiscard]] std::uint64_t d() const { return d_and_count & ((std::uint64_t{1} << kCountShift) - 1); }
  [[nodiscard]] std::uint32_t count() const { return static_cast<std::uint32_t>(d_and_count >> kCountShift); }
};

/// Leaves of a stretch of rows.
struct RowBand {
  LeafBars bars;
  AlignedVector<LeafSums> sums;  ///< By leaf number; those not in use are zero.
  std::uint64_t measured = 0;
  DepthRowBuffer row;
  AlignedVector<std::uint32_t> keys;
  AlignedVector<std::uint32_t> starts;
  AlignedVector<std::uint64_t> running;
};

/// The points of one leaf of a cloud: sums of x, y and z in whole numbers (kernels::Lattice), modulo 2^64, and how many there
/// are.
using CloudLeaf = kernels::LeafTerm;

/// The leaves of one bucket of points, or of all.
struct LeafRegion {
  LeafTable<std::uint64_t> table;      ///< Their numbers, where there are no bars.
  AlignedVector<CloudLeaf> leaves;     ///< `count` of them, then others.
  AlignedVector<std::uint64_t> keys;   ///< Their places in the grid, packed.
  AlignedVector<std::uint32_t> first;  ///< Their first points.
  std::size_t count = 0;
};

/// The grid over one cloud: along each axis, index = floor(p / leaf) - (smallest index), in as many bits as it needs.
struct Lattice {
  /// Of a key; every shift, also by the bits of a whole axis, then stays below its width.
  static constexpr int kMostBits = 63;

  /// Its rounder makes coordinates multiples of 2^-30 of the largest along their axis. Sums of such numbers are whole, so that
  /// they do not depend on their order and with it on the number of threads.
  kernels::Lattice to_index{};
  std::array<double, 3> unit{};  ///< Metres, of sums.
  Eigen::Vector3d leaf_size = Eigen::Vector3d::Zero();
  VoxelGrid::Index smallest = VoxelGrid::Index::Zero();
  VoxelGrid::Index largest = VoxelGrid::Index::Zero();
  int key_bits = 0;
  bool bars = false;  ///< Whether LeafBars number the leaves, not LeafTable.

  /// Indices along this axis fit into so many bits.
  [[nodiscard]] int bits(int axis) const;
  [[nodiscard]] std::uint64_t key(const std::uint32_t* index) const { return kernels::key_of(index, to_index); }
  /// What of a key is the index along this axis.
  [[nodiscard]] std::uint64_t index(std::uint64_t leaf_key, int axis) const;
  /// The middle of a leaf in local coordinates, metres.
  [[nodiscard]] Eigen::Vector3d centre(std::uint64_t leaf_key) const;
};

struct VoxelGrid::Scratch {
  std::vector<LeafRegion> regions;
  std::size_t regions_used = 0;  ///< By the last cloud: one, or PointBuckets::kBuckets.
  LeafBars bars;                 ///< Numbers of the leaves of one region, where keys are short.
  PointBuckets buckets;
  Ranks ranks;                     ///< Of leaves by their first points.
  std::optional<Lattice> lattice;  ///< Of the last cloud.

  std::vector<RowBand> bands;
  AlignedVector<float> ray_x;
  [[nodiscard]] std::span<const LeafRegion> regions_in_use() const { return std::span(regions).first(regions_used); }
  std::span<LeafRegion> use_regions(std::size_t count) {
    regions.resize(std::max(regions.size(), count));
    regions_used = count;
    return std::span(regions).first(count);
  }

  PointCloud cloud;  ///< Of a depth image whose leaves are too many for 32-bit keys.
};

/// "leaf-size: 0.001 m divides …": the one message for a lattice that is too fine.
Error too_many_leaves(double leaf_size_m);

/// Makes it the grid of no points, in local coordinates with this origin.
void clear(const Eigen::Vector3d& origin_m, VoxelGrid& grid);

/// Checks the leaf size.
Status check_leaf_size(double leaf_size_m);

}  // namespace fransac
