// SPDX-License-Identifier: Apache-2.0
#include "fransac/filter/voxel_grid.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdio>
#include <new>
#include <string>

#include "filter/voxel_grid_scratch.hpp"
#include "fransac/core/parallel.hpp"
#include "kernels/points.h"

namespace fransac {
namespace {

Result<Lattice> make_lattice(const PointCloud& cloud, const Eigen::Vector3d& leaf_size_m) {
  constexpr int kMaxBitsPerAxis = 31;
  Lattice lattice;
  lattice.leaf_size = leaf_size_m;
  const std::array<const float*, 3> coordinates{cloud.x(), cloud.y(), cloud.z()};
  int bits = 0;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const auto along = static_cast<Eigen::Index>(axis);
    const double per_leaf = 1.0 / leaf_size_m[along];
    lattice.key.per_leaf[axis] = per_leaf;
    const kernels::Bounds bounds = kernels::bounds(coordinates[axis], cloud.padded_size());
    const double farthest =
        std::max({1e-30, std::abs(static_cast<double>(bounds.min)), std::abs(static_cast<double>(bounds.max))});
    lattice.rounder[axis] = std::ldexp(1.5, std::ilogb(farthest) + 1 + 52 - 30);
    const double origin = cloud.origin[along] * per_leaf;
    const double smallest = std::floor(static_cast<double>(bounds.min) * per_leaf + origin);
    lattice.key.offset[axis] = origin - smallest;
    const double largest = static_cast<double>(bounds.max) * per_leaf + lattice.key.offset[axis];
    // Doubles hold whole numbers exactly up to 2^53; beyond that floor() means nothing.
    const bool countable = std::abs(smallest) < 0x1p53 && largest < 0x1p31;
    // The kernel may round the other way (fused multiply-add): half a leaf of slack keeps its last index inside the bits.
    const int axis_bits =
        countable ? static_cast<int>(std::bit_width(static_cast<std::uint64_t>(largest + 0.5))) : Lattice::kMostBits + 1;
    lattice.key.shift[axis] = bits;
    bits += axis_bits;
    if (axis_bits > kMaxBitsPerAxis || bits > Lattice::kMostBits) {
      return too_many_leaves(leaf_size_m[along]);
    }
    lattice.smallest[along] = static_cast<std::int64_t>(smallest);
    lattice.largest[along] = lattice.smallest[along] + static_cast<std::int64_t>(largest);
  }
  return lattice;
}

/// Fewer points are not worth a thread of their own.
constexpr std::size_t kLeastPart = std::size_t{1} << 17;

/// Points that are looked at together. What is kept of each fits into the first-level cache, coordinates and keys included.
constexpr std::size_t kStretch = 512;

/// Runs of neighbours that share a leaf, in a stretch of points. Where a run ends cannot be predicted, so nothing here branches
/// on it: sums of runs are differences of running sums, which are as exact (Lattice::rounder).
struct Runs {
  std::array<std::uint32_t, kStretch + 1> start;  ///< First point of each run, then the number of points.
  std::array<std::uint32_t, kStretch> run_of;
  std::array<std::uint32_t, kStretch> leaf;                ///< Of each run.
  std::array<std::array<double, 3>, kStretch + 1> before;  ///< Sums of the points before each one.

  /// Returns the number of runs; `leaf` is left to the caller.
  std::size_t find(const PointCloud& cloud, std::size_t first, std::size_t size, const std::uint64_t* keys,
                   const std::array<double, 3>& rounder) {
    const float* const x = cloud.x() + first;
    const float* const y = cloud.y() + first;
    const float* const z = cloud.z() + first;
    std::array<double, 3> sum{};
    std::uint32_t runs = 0;
    std::uint64_t previous = ~keys[0];
    for (std::size_t i = 0; i < size; ++i) {
      start[runs] = static_cast<std::uint32_t>(i);
      runs += static_cast<std::uint32_t>(keys[i] != previous);
      previous = keys[i];
      run_of[i] = runs - 1;
      before[i] = sum;
      sum[0] += (static_cast<double>(x[i]) + rounder[0]) - rounder[0];
      sum[1] += (static_cast<double>(y[i]) + rounder[1]) - rounder[1];
      sum[2] += (static_cast<double>(z[i]) + rounder[2]) - rounder[2];
    }
    start[runs] = static_cast<std::uint32_t>(size);
    before[size] = sum;
    return runs;
  }
};

/// Numbers the leaves of the points [begin, end) and adds their points up, a look-up for each run of equal keys.
void add_points(const PointCloud& cloud, const Lattice& lattice, std::size_t begin, std::size_t end, CloudPart& part,
                std::uint32_t* leaf_of) {
  const std::array<double, 3> rounder = lattice.rounder;
  part.table.restart();
  part.leaves.clear();
  alignas(kAlignment) std::array<std::uint64_t, kStretch> keys;
  Runs runs;
  for (std::size_t first = begin; first < end; first += kStretch) {
    const std::size_t size = std::min(kStretch, end - first);
    kernels::leaf_keys(cloud.x() + first, cloud.y() + first, cloud.z() + first, std::min(kStretch, cloud.padded_size() - first),
                       lattice.key, keys.data());
    const std::size_t count = runs.find(cloud, first, size, keys.data(), rounder);
    for (std::size_t run = 0; run < count; ++run) {
      const std::uint32_t from = runs.start[run];
      const std::uint32_t to = runs.start[run + 1];
      const std::uint32_t number = part.table.find_or_add(keys[from]);
      if (number == part.leaves.size()) part.leaves.push_back({.key = keys[from]});
      CloudLeaf& leaf = part.leaves[number];
      leaf.count += to - from;
      for (std::size_t axis = 0; axis < 3; ++axis) leaf.sum[axis] += runs.before[to][axis] - runs.before[from][axis];
      runs.leaf[run] = number;
    }
    for (std::size_t i = 0; i < size; ++i) leaf_of[first + i] = runs.leaf[runs.run_of[i]];
  }
}

/// Adds a part to the first, whose points come before it; `part.number` then says what its leaves are called there.
void merge(CloudPart& part, CloudPart& into) {
  part.number.resize(part.leaves.size());
  for (std::size_t leaf = 0; leaf < part.leaves.size(); ++leaf) {
    const CloudLeaf& from = part.leaves[leaf];
    const std::uint32_t number = into.table.find_or_add(from.key);
    if (number == into.leaves.size()) into.leaves.push_back({.key = from.key});
    CloudLeaf& to = into.leaves[number];
    to.count += from.count;
    for (std::size_t axis = 0; axis < 3; ++axis) to.sum[axis] += from.sum[axis];
    part.number[leaf] = number;
  }
}

/// Numbers the leaves and adds up their points: a part of the cloud for each thread, merged in order.
void add_points(const PointCloud& cloud, const Lattice& lattice, int threads, VoxelGrid& grid) {
  std::vector<CloudPart>& parts = grid.scratch->parts;
  grid.leaf_of.resize(cloud.size());
  const std::size_t worthwhile = std::max<std::size_t>(1, cloud.size() / kLeastPart);
  const auto count = std::min(static_cast<std::size_t>(resolve_threads(threads)), worthwhile);
  parts.resize(std::max(parts.size(), count));
  // Whole blocks: kernels read no less.
  const auto begin_of = [&](std::size_t part) {
    return part == count ? cloud.size() : part * (cloud.size() / count) / PointCloud::kBlock * PointCloud::kBlock;
  };
  parallel_for(threads, count,
               [&](std::size_t i) { add_points(cloud, lattice, begin_of(i), begin_of(i + 1), parts[i], grid.leaf_of.data()); });
  for (std::size_t i = 1; i < count; ++i) merge(parts[i], parts.front());
  parallel_for(threads, count - 1, [&](std::size_t i) {
    const AlignedVector<std::uint32_t>& number = parts[i + 1].number;
    for (std::size_t p = begin_of(i + 1); p < begin_of(i + 2); ++p) grid.leaf_of[p] = number[grid.leaf_of[p]];
  });
}

}  // namespace

VoxelGrid::VoxelGrid() : scratch(std::make_unique<Scratch>()) {}
VoxelGrid::~VoxelGrid() = default;
VoxelGrid::VoxelGrid(VoxelGrid&&) noexcept = default;
VoxelGrid& VoxelGrid::operator=(VoxelGrid&&) noexcept = default;

std::uint32_t VoxelGrid::leaf_at(const Index& index) const {
  if (!scratch->lattice) return kNoLeaf;
  const Lattice& lattice = *scratch->lattice;
  std::uint64_t key = 0;
  for (int axis = 0; axis < 3; ++axis) {
    // Rounding can put a point at the box's border one leaf beyond it.
    if (index[axis] < smallest[axis] || index[axis] > largest[axis] + 1) return kNoLeaf;
    const auto part = static_cast<std::uint64_t>(index[axis] - smallest[axis]);
    if (part >> lattice.bits(axis) != 0) return kNoLeaf;
    key |= part << lattice.key.shift[axis];
  }
  return scratch->parts.front().table.number_of(key).value_or(kNoLeaf);
}

VoxelGrid::Index VoxelGrid::index_at(const Eigen::Vector3f& local_point) const {
  Index index = Index::Zero();
  if (!scratch->lattice) return index;
  const Lattice& lattice = *scratch->lattice;
  const auto place = [&](int axis) {
    return static_cast<double>(local_point[axis]) * lattice.key.per_leaf[axis] + lattice.key.offset[axis];
  };
  const auto within = [&](int axis) {
    return place(axis) >= 0.0 && place(axis) < static_cast<double>(largest[axis] - smallest[axis] + 1);
  };
  if (within(0) && within(1) && within(2)) {  // through the kernel, which may round the other way (fused multiply-add)
    alignas(kAlignment) std::array<std::array<float, kernels::kBlock>, 3> point{};
    for (int axis = 0; axis < 3; ++axis) point[static_cast<std::size_t>(axis)].fill(local_point[axis]);
    std::array<std::uint64_t, kernels::kBlock> keys;
    kernels::leaf_keys(point[0].data(), point[1].data(), point[2].data(), kernels::kBlock, lattice.key, keys.data());
    for (int axis = 0; axis < 3; ++axis) {
      index[axis] = smallest[axis] + static_cast<std::int64_t>(lattice.index(keys[0], axis));
    }
    return index;
  }
  constexpr double kFarthest = 0x1p53;  // doubles beyond it are far off any lattice, and hold no fractions
  for (int axis = 0; axis < 3; ++axis) {
    index[axis] = smallest[axis] + static_cast<std::int64_t>(std::floor(std::clamp(place(axis), -kFarthest, kFarthest)));
  }
  return index;
}

int Lattice::bits(int axis) const { return (axis < 2 ? key.shift[axis + 1] : kMostBits) - key.shift[axis]; }

std::uint64_t Lattice::index(std::uint64_t leaf_key, int axis) const {
  return bits(axis) == 0 ? 0 : (leaf_key >> key.shift[axis]) & (~std::uint64_t{0} >> (64 - bits(axis)));
}

Eigen::Vector3d Lattice::centre(std::uint64_t leaf_key) const {
  const auto middle = [&](int axis) {
    return (static_cast<double>(index(leaf_key, axis)) + 0.5 - key.offset[axis]) * leaf_size[axis];
  };
  return {middle(0), middle(1), middle(2)};
}

Error too_many_leaves(double leaf_size_m) {
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), "leaf-size: %g", leaf_size_m);
  return Error{ErrorCode::invalid_argument, std::string(text.data()) +
                                                " m divides the cloud into more leaves than 63-bit keys can tell apart"
                                                " (2^31 along an axis); take a larger one"};
}

Status check_leaf_size(double leaf_size_m) {
  if (leaf_size_m > 0.0 && std::isfinite(leaf_size_m)) return {};
  return Error{ErrorCode::invalid_argument, "leaf-size: must be a positive number of metres"};
}

Status voxel_grid(const PointCloud& cloud, double leaf_size_m, LeafPoint leaf_point, VoxelGrid& grid, int threads) {
  return voxel_grid(cloud, Eigen::Vector3d::Constant(leaf_size_m), leaf_point, grid, threads);
}

Status voxel_grid(const PointCloud& cloud, const Eigen::Vector3d& leaf_size_m, LeafPoint leaf_point, VoxelGrid& grid,
                  int threads) try {
  for (const double edge : leaf_size_m) {
    if (Status status = check_leaf_size(edge); !status) return status;
  }
  grid.scratch->lattice.reset();
  grid.smallest.setZero();
  grid.largest.setZero();
  grid.leaves.origin = cloud.origin;
  grid.leaves.source.clear();
  grid.leaves.clear();
  grid.points = cloud.size();
  grid.measured = cloud.size();
  if (cloud.empty()) {
    grid.leaf_of.clear();
    grid.point_count.clear();
    return {};
  }
  const Result<Lattice> lattice = make_lattice(cloud, leaf_size_m);
  if (!lattice) return lattice.error();
  add_points(cloud, *lattice, threads, grid);
  grid.scratch->lattice = *lattice;
  grid.smallest = lattice->smallest;
  grid.largest = lattice->largest;

  const AlignedVector<CloudLeaf>& leaves = grid.scratch->parts.front().leaves;
  grid.leaves.resize_uninitialised(leaves.size());
  grid.leaves.width = static_cast<int>(leaves.size());
  grid.leaves.height = 1;
  grid.point_count.resize(leaves.size());
  for (std::size_t i = 0; i < leaves.size(); ++i) {
    const CloudLeaf& leaf = leaves[i];
    const Eigen::Vector3d point = leaf_point == LeafPoint::centroid
                                      ? Eigen::Map<const Eigen::Vector3d>(leaf.sum.data()) / leaf.count
                                      : lattice->centre(leaf.key);
    grid.leaves.set(i, point.cast<float>());
    grid.point_count[i] = leaf.count;
  }
  return {};
} catch (const std::bad_alloc&) {
  return Error{ErrorCode::out_of_memory, "not enough memory for the voxel grid of " + std::to_string(cloud.size()) + " points"};
}

}  // namespace fransac
