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

/// The points of one leaf of a cloud.
struct CloudLeaf {
  std::array<double, 3> sum{};
  std::uint64_t key = 0;  ///< Its place in the grid, packed.
  std::uint32_t count = 0;
};

/// Leaves of a stretch of a cloud.
struct CloudPart {
  LeafTable<std::uint64_t> table;
  AlignedVector<CloudLeaf> leaves;
  AlignedVector<std::uint32_t> number;  ///< What they are called in the whole.
};

/// The grid over one cloud: along each axis, index = floor(p / leaf) - (smallest index), in as many bits as it needs.
struct Lattice {
  /// Of a key; every shift, also by the bits of a whole axis, then stays below its width.
  static constexpr int kMostBits = 63;

  kernels::Lattice key{};
  Eigen::Vector3d leaf_size = Eigen::Vector3d::Zero();
  VoxelGrid::Index smallest = VoxelGrid::Index::Zero();
  VoxelGrid::Index largest = VoxelGrid::Index::Zero();
  /// Adding and subtracting this rounds a coordinate to a multiple of 2^-30 of the largest along its axis. Sums of up to 2^22
  /// such numbers are exact, so that they do not depend on their order and with it on the number of threads.
  std::array<double, 3> rounder{};

  /// Indices along this axis fit into so many bits.
  [[nodiscard]] int bits(int axis) const;
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

/// Checks the leaf size.
Status check_leaf_size(double leaf_size_m);

}  // namespace fransac
