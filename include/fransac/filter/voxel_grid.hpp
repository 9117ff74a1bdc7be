// SPDX-License-Identifier: Apache-2.0
/// One point per occupied leaf of a regular grid.
#pragma once

#include <cstdint>

#include "fransac/core/aligned.hpp"
#include "fransac/core/point_cloud.hpp"
#include "fransac/core/result.hpp"

namespace fransac {

/// Which point stands for a leaf.
enum class LeafPoint {
  centroid,  ///< The mean of the leaf's points.
  centre,    ///< The middle of the leaf's cube.
};

/// The result of a voxel grid. Leaves are numbered in the order in which the input first enters them.
struct VoxelGrid {
  PointCloud leaves;                         ///< One point per occupied leaf; `source` is empty.
  AlignedVector<std::uint32_t> leaf_of;      ///< For each input point its leaf.
  AlignedVector<std::uint32_t> point_count;  ///< For each leaf the number of its input points.

  AlignedVector<std::uint64_t> keys;  ///< For each leaf its place in the grid, packed.

  /// Memory between frames; not part of the result.
  struct Slot {
    std::uint64_t key;
    std::uint32_t leaf;
    std::uint32_t frame;
  };
  AlignedVector<Slot> table;
  std::uint32_t frame = 0;
  AlignedVector<double> sums;
};

/// Sorts the cloud's points (all finite) into cubes with an edge of `leaf_size_m` metres whose lattice contains the
/// origin of the input's coordinates: leaf index = floor(p / leaf_size), as in PCL. Keys are 64-bit and relative to the
/// cloud's smallest corner.
/// Fails with invalid_argument where leaf_size_m is not positive, or so small that keys of 63 bits (31 per axis) cannot tell
/// the cloud's leaves apart.
/// Reuses the grid's memory.
Status voxel_grid(const PointCloud& cloud, double leaf_size_m, LeafPoint leaf_point, VoxelGrid& grid);

}  // namespace fransac
