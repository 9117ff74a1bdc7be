// SPDX-License-Identifier: Apache-2.0
/// Memory of voxel grids between calls.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "filter/depth_rows.hpp"
#include "filter/leaf_bars.hpp"
#include "filter/leaf_table.hpp"
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
struct alignas(32) CloudLeaf {
  std::array<std::uint64_t, 4> sum{};

  [[nodiscard]] std::uint64_t count() const { return sum[3]; }
};

/// Leaves of a stretch of a cloud: numbered by bars where these serve, else by the table.
struct CloudPart {
  LeafBars bars;
  LeafTable<std::uint64_t> table;
  AlignedVector<CloudLeaf> leaves;    ///< `count` of them, then others.
  AlignedVector<std::uint64_t> keys;  ///< Their places in the grid, packed.
  std::size_t count = 0;
  AlignedVector<std::uint32_t> number;  ///< What they are called in the whole.
};

/// The grid over one cloud: along each axis, index = floor(p / leaf) - (smallest index), in as many bits as it needs.
struct Lattice {
  /// Of a key; every shift, also by the bits of a whole axis, then stays below its width.
  static constexpr int kMostBits = 63;

  /// Its rounder makes coordinates multiples of 2^-30 of the largest along their axis. Sums of such numbers are whole, so that
  /// they do not depend on their order and with it on the number of threads.
  kernels::Lattice to_index{};
  std::array<int, 3> shift{};    ///< Of each axis' index in a key.
  std::array<double, 3> unit{};  ///< Metres, of sums.
  Eigen::Vector3d leaf_size = Eigen::Vector3d::Zero();
  VoxelGrid::Index smallest = VoxelGrid::Index::Zero();
  VoxelGrid::Index largest = VoxelGrid::Index::Zero();
  int key_bits = 0;
  bool bars = false;  ///< Whether leaves are numbered by LeafBars.

  /// Indices along this axis fit into so many bits.
  [[nodiscard]] int bits(int axis) const;
  [[nodiscard]] std::uint64_t key(const std::uint32_t* index) const {
    return std::uint64_t{index[0]} << shift[0] | std::uint64_t{index[1]} << shift[1] | std::uint64_t{index[2]} << shift[2];
  }
  /// What of a key is the index along this axis.
  [[nodiscard]] std::uint64_t index(std::uint64_t leaf_key, int axis) const;
  /// The middle of a leaf in local coordinates, metres.
  [[nodiscard]] Eigen::Vector3d centre(std::uint64_t leaf_key) const;
};

struct VoxelGrid::Scratch {
  std::vector<CloudPart> parts;
  std::optional<Lattice> lattice;  ///< Of the last cloud.

  std::vector<RowBand> bands;
  AlignedVector<float> ray_x;
  PointCloud cloud;  ///< Of a depth image whose leaves are too many for 32-bit keys.
};

/// "leaf-size: 0.001 m divides …": the one message for a lattice that is too fine.
Error too_many_leaves(double leaf_size_m);

/// Makes it the grid of no points, in local coordinates with this origin.
void clear(const Eigen::Vector3d& origin_m, VoxelGrid& grid);

/// Checks the leaf size.
Status check_leaf_size(double leaf_size_m);

}  // namespace fransac
