// SPDX-License-Identifier: Apache-2.0
#include "fransac/filter/voxel_grid.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdio>
#include <limits>
#include <new>
#include <string>

#include "kernels/points.h"

namespace fransac {
namespace {

using Slot = VoxelGrid::Slot;

/// The grid over one cloud: along each axis, index = floor(p / leaf) - (smallest index), in as many bits as it needs.
struct Lattice {
  kernels::Lattice key{};
  double leaf_size = 0.0;

  /// The middle of a leaf in local coordinates, metres.
  [[nodiscard]] Eigen::Vector3d centre(std::uint64_t leaf_key) const {
    const auto index = [&](int axis) {
      const int next_shift = axis < 2 ? key.shift[axis + 1] : 64;
      const int bits = next_shift - key.shift[axis];
      return bits == 0 ? 0 : (leaf_key >> key.shift[axis]) & (~std::uint64_t{0} >> (64 - bits));
    };
    const auto middle = [&](int axis) { return (static_cast<double>(index(axis)) + 0.5 - key.offset[axis]) * leaf_size; };
    return {middle(0), middle(1), middle(2)};
  }
};

std::string leaf_size_text(double leaf_size_m) {
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), "leaf-size: %g", leaf_size_m);
  return text.data();
}

Result<Lattice> make_lattice(const PointCloud& cloud, double leaf_size_m) {
  constexpr int kMaxBitsPerAxis = 31;
  constexpr int kMaxBits = 63;  // every shift then stays below the width of a key
  Lattice lattice;
  lattice.key.per_leaf = 1.0 / leaf_size_m;
  lattice.leaf_size = leaf_size_m;
  const std::array<const float*, 3> coordinates{cloud.x(), cloud.y(), cloud.z()};
  int bits = 0;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const kernels::Bounds bounds = kernels::bounds(coordinates[axis], cloud.padded_size());
    const double origin = cloud.origin[static_cast<Eigen::Index>(axis)] * lattice.key.per_leaf;
    const double smallest = std::floor(static_cast<double>(bounds.min) * lattice.key.per_leaf + origin);
    lattice.key.offset[axis] = origin - smallest;
    const double largest = static_cast<double>(bounds.max) * lattice.key.per_leaf + lattice.key.offset[axis];
    // Doubles hold whole numbers exactly up to 2^53; beyond that floor() means nothing.
    const bool countable = std::abs(smallest) < 0x1p53 && largest < 0x1p31;
    // The kernel may round the other way (fused multiply-add): half a leaf of slack keeps its last index inside the bits.
    const int axis_bits = countable ? static_cast<int>(std::bit_width(static_cast<std::uint64_t>(largest + 0.5))) : kMaxBits + 1;
    lattice.key.shift[axis] = bits;
    bits += axis_bits;
    if (axis_bits > kMaxBitsPerAxis || bits > kMaxBits) {
      return Error{ErrorCode::invalid_argument, leaf_size_text(leaf_size_m) +
                                                    " m divides the cloud into more leaves than 63-bit keys can tell apart"
                                                    " (2^31 along an axis); take a larger one"};
    }
  }
  return lattice;
}

/// Leaf numbers by key: open addressing with linear probing. A slot belongs to the current cloud when its frame number
/// does, so nothing is cleared between clouds.
class LeafTable {
 public:
  explicit LeafTable(VoxelGrid& grid) : table_(grid.table), frame_(grid.frame) {
    constexpr std::size_t kFirstCapacity = std::size_t{1} << 14;
    if (table_.empty()) table_.assign(kFirstCapacity, Slot{});
    if (frame_ == std::numeric_limits<std::uint32_t>::max()) {
      std::fill(table_.begin(), table_.end(), Slot{});
      frame_ = 0;
    }
    ++frame_;
  }

  /// The slot of a key; its frame differs from `frame()` when the key is new.
  Slot& find(std::uint64_t key) {
    constexpr std::uint64_t kFibonacci = 0x9E3779B97F4A7C15;  // 2^64 / golden ratio (Knuth, TAOCP 3, 6.4)
    const std::size_t mask = table_.size() - 1;
    std::size_t i = static_cast<std::size_t>((key * kFibonacci) >> std::countl_zero(mask));
    while (table_[i].frame == frame_ && table_[i].key != key) i = (i + 1) & mask;
    return table_[i];
  }

  std::uint32_t find_or_add(std::uint64_t key) {
    Slot& slot = find(key);
    if (slot.frame == frame_) return slot.leaf;
    slot = {key, leaves_, frame_};
    if (2 * ++leaves_ > table_.size()) grow();
    return leaves_ - 1;
  }

  [[nodiscard]] std::uint32_t leaves() const { return leaves_; }

 private:
  void grow() {
    AlignedVector<Slot> old(2 * table_.size(), Slot{});
    old.swap(table_);
    for (const Slot& slot : old) {
      if (slot.frame == frame_) find(slot.key) = slot;
    }
  }

  AlignedVector<Slot>& table_;
  std::uint32_t& frame_;
  std::uint32_t leaves_ = 0;
};

/// Numbers the leaves and adds up their points. Neighbours mostly share a leaf, so a run of equal keys is looked up once
/// and added up in registers.
void accumulate(const PointCloud& cloud, const Lattice& lattice, VoxelGrid& grid) {
  constexpr std::size_t kStretch = 1024;  // points whose keys are made at a time: 8 KiB
  LeafTable table(grid);
  grid.leaf_of.resize(cloud.size());
  grid.point_count.clear();
  grid.keys.clear();
  grid.sums.clear();
  alignas(kAlignment) std::array<std::uint64_t, kStretch> keys;
  for (std::size_t first = 0; first < cloud.size(); first += kStretch) {
    const float* const x = cloud.x() + first;
    const float* const y = cloud.y() + first;
    const float* const z = cloud.z() + first;
    std::uint32_t* const leaf_of = grid.leaf_of.data() + first;
    kernels::leaf_keys(x, y, z, std::min(kStretch, cloud.padded_size() - first), lattice.key, keys.data());
    const std::size_t size = std::min(kStretch, cloud.size() - first);
    for (std::size_t i = 0; i < size;) {
      const std::uint64_t key = keys[i];
      const std::uint32_t leaf = table.find_or_add(key);
      if (leaf == grid.point_count.size()) {
        grid.point_count.push_back(0);
        grid.keys.push_back(key);
        grid.sums.resize(grid.sums.size() + 3, 0.0);
      }
      const std::size_t run = i;
      std::array<double, 3> sum{};
      for (; i < size && keys[i] == key; ++i) {
        sum[0] += static_cast<double>(x[i]);
        sum[1] += static_cast<double>(y[i]);
        sum[2] += static_cast<double>(z[i]);
        leaf_of[i] = leaf;
      }
      grid.point_count[leaf] += static_cast<std::uint32_t>(i - run);
      for (std::size_t axis = 0; axis < 3; ++axis) grid.sums[3 * std::size_t{leaf} + axis] += sum[axis];
    }
  }
}

}  // namespace

Status voxel_grid(const PointCloud& cloud, double leaf_size_m, LeafPoint leaf_point, VoxelGrid& grid) try {
  if (!(leaf_size_m > 0.0) || !std::isfinite(leaf_size_m)) {
    return Error{ErrorCode::invalid_argument, "leaf-size: must be a positive number of metres"};
  }
  grid.leaves.origin = cloud.origin;
  grid.leaves.source.clear();
  grid.leaves.clear();
  if (cloud.empty()) {
    grid.leaf_of.clear();
    grid.point_count.clear();
    grid.keys.clear();
    return {};
  }
  const Result<Lattice> lattice = make_lattice(cloud, leaf_size_m);
  if (!lattice) return lattice.error();
  accumulate(cloud, *lattice, grid);

  const std::size_t leaves = grid.point_count.size();
  grid.leaves.resize_uninitialised(leaves);
  grid.leaves.width = static_cast<int>(leaves);
  grid.leaves.height = 1;
  for (std::size_t leaf = 0; leaf < leaves; ++leaf) {
    const Eigen::Map<const Eigen::Vector3d> sum(&grid.sums[3 * leaf]);
    const Eigen::Vector3d point =
        leaf_point == LeafPoint::centroid ? sum / grid.point_count[leaf] : lattice->centre(grid.keys[leaf]);
    grid.leaves.set(leaf, point.cast<float>());
  }
  return {};
} catch (const std::bad_alloc&) {
  return Error{ErrorCode::out_of_memory, "not enough memory for the voxel grid of " + std::to_string(cloud.size()) + " points"};
}

}  // namespace fransac
