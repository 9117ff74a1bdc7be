// SPDX-License-Identifier: Apache-2.0
#include "fransac/filter/voxel_grid.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdio>
#include <new>
#include <string>

#include "core/caught.hpp"
#include "filter/voxel_grid_scratch.hpp"
#include "fransac/core/parallel.hpp"
#include "kernels/points.h"

namespace fransac {
namespace {

/// Clouds that are numbered by bars have at most so many points: a leaf that is alone in its bar takes up to 512 bytes there.
constexpr std::size_t kMostPointsOfBars = std::size_t{1} << 20;

Result<Lattice> make_lattice(const kernels::Box& box, std::size_t points, const Eigen::Vector3d& origin_m,
                             const Eigen::Vector3d& leaf_size_m) {
  constexpr int kMaxBitsPerAxis = 31;
  constexpr int kMantissaBits = 52;
  constexpr int kBitsOfCoordinate = 30;
  Lattice lattice;
  lattice.leaf_size = leaf_size_m;
  int bits = 0;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const auto along = static_cast<Eigen::Index>(axis);
    const double per_leaf = 1.0 / leaf_size_m[along];
    lattice.to_index.per_leaf[axis] = per_leaf;
    const auto nearest = static_cast<double>(box.min[axis]);
    const auto farthest = static_cast<double>(box.max[axis]);
    const int last_bit = std::ilogb(std::max({1e-30, std::abs(nearest), std::abs(farthest)})) + 1 - kBitsOfCoordinate;
    lattice.unit[axis] = std::ldexp(1.0, last_bit);
    lattice.to_index.rounder[axis] = std::ldexp(1.5, last_bit + kMantissaBits);
    const double origin = origin_m[along] * per_leaf;
    const double smallest = std::floor(nearest * per_leaf + origin);
    lattice.to_index.offset[axis] = origin - smallest;
    const double largest = farthest * per_leaf + lattice.to_index.offset[axis];
    // Doubles hold whole numbers exactly up to 2^53; beyond that floor() means nothing.
    const bool countable = std::abs(smallest) < 0x1p53 && largest < 0x1p31;
    // The kernel may round the other way (fused multiply-add): half a leaf of slack keeps its last index inside the bits.
    const int axis_bits =
        countable ? static_cast<int>(std::bit_width(static_cast<std::uint64_t>(largest + 0.5))) : Lattice::kMostBits + 1;
    lattice.shift[axis] = bits;
    bits += axis_bits;
    if (axis_bits > kMaxBitsPerAxis || bits > Lattice::kMostBits) {
      return too_many_leaves(leaf_size_m[along]);
    }
    lattice.smallest[along] = static_cast<std::int64_t>(smallest);
    lattice.largest[along] = lattice.smallest[along] + static_cast<std::int64_t>(largest);
  }
  lattice.key_bits = std::max(bits, LeafBars::kLeafBits);
  lattice.bars = bits <= LeafBars::kMostBits && points <= kMostPointsOfBars;
  return lattice;
}

/// Fewer points are not worth a thread of their own.
constexpr std::size_t kLeastPart = std::size_t{1} << 17;

/// Points that are looked at together: their runs fit into the first-level cache.
constexpr std::size_t kStretch = 256;

/// Points with x, y and z side by side, all finite.
struct Stretch {
  const float* points;
  std::size_t stride;
  std::size_t size;
  const std::uint32_t* numbers;  ///< Of these among all in the stretch; null: they are all.
};

/// Where points are made into stretches that do not lie in memory like that.
struct StretchBuffer {
  static constexpr std::size_t kStride = 4;
  std::array<float, kStretch * kStride> points;
  std::array<std::uint32_t, kStretch> numbers;
};

/// Points of a cloud, stretch by stretch.
struct CloudStretches {
  const PointCloud& cloud;

  Stretch operator()(std::size_t first, std::size_t size, StretchBuffer& buffer) const {
    const float* const x = cloud.x() + first;
    const float* const y = cloud.y() + first;
    const float* const z = cloud.z() + first;
    for (std::size_t i = 0; i < size; ++i) {
      float* const point = buffer.points.data() + StretchBuffer::kStride * i;
      point[0] = x[i];
      point[1] = y[i];
      point[2] = z[i];
    }
    return {buffer.points.data(), StretchBuffer::kStride, size, nullptr};
  }
};

/// Points where they are; the finite ones are gathered where not all are.
struct ViewStretches {
  PointsView view;
  bool finite;

  Stretch operator()(std::size_t first, std::size_t size, StretchBuffer& buffer) const {
    const float* const from = view.data + first * view.stride;
    if (finite) return {from, view.stride, size, nullptr};
    std::size_t n = 0;
    for (std::size_t i = 0; i < size; ++i) {
      const float* const point = from + i * view.stride;
      float* const to = buffer.points.data() + StretchBuffer::kStride * n;
      to[0] = point[0];
      to[1] = point[1];
      to[2] = point[2];
      buffer.numbers[n] = static_cast<std::uint32_t>(i);
      n += static_cast<std::size_t>(((point[0] - point[0]) + (point[1] - point[1])) + (point[2] - point[2]) == 0.0F);
    }
    return {buffer.points.data(), StretchBuffer::kStride, n, buffer.numbers.data()};
  }
};

/// The same leaf for all points of each run. Leaves of short runs are written in one go, past their end.
class LeavesOfPoints {
 public:
  void set(std::size_t begin, std::size_t end, std::uint32_t leaf) {
    for (std::size_t i = begin; i < end; i += kAtOnce) std::fill_n(leaf_.data() + i, kAtOnce, leaf);
  }

  /// Of the `size` points that the stretch was made of.
  void copy(const Stretch& stretch, std::size_t size, std::uint32_t* leaf_of) const {
    if (stretch.numbers == nullptr) {
      std::copy_n(leaf_.data(), size, leaf_of);
      return;
    }
    std::fill_n(leaf_of, size, VoxelGrid::kNoLeaf);
    for (std::size_t i = 0; i < stretch.size; ++i) leaf_of[stretch.numbers[i]] = leaf_[i];
  }

 private:
  static constexpr std::size_t kAtOnce = 8;
  std::array<std::uint32_t, kStretch + kAtOnce> leaf_;
};

/// Numbers of leaves by key.
class BarNumbers {
 public:
  explicit BarNumbers(CloudPart& part) : row_(part.bars) {}
  [[nodiscard]] std::uint32_t leaves() const { return row_.leaves(); }
  std::uint32_t number_of(std::uint64_t key) { return row_.number_of(static_cast<std::uint32_t>(key)); }

 private:
  LeafBars::Row row_;
};

/// The same of keys that are too long for bars.
class TableNumbers {
 public:
  explicit TableNumbers(CloudPart& part) : table_(part.table) {}
  [[nodiscard]] std::uint32_t leaves() const { return table_.size(); }
  std::uint32_t number_of(std::uint64_t key) { return table_.find_or_add(key); }

 private:
  LeafTable<std::uint64_t>& table_;
};

void restart(const Lattice& lattice, CloudPart& part) {
  part.count = 0;
  if (lattice.bars) {
    part.bars.restart(lattice.key_bits);
  } else {
    part.table.restart();
  }
}

/// Makes room for as many leaves, those beyond part.count without points.
void grow(std::size_t leaves, CloudPart& part) {
  if (part.leaves.size() < leaves) {
    part.keys.resize(2 * leaves);
    part.leaves.resize(2 * leaves);  // last: its size says what there is room for, also after an allocation that failed
  }
  std::fill(part.leaves.begin() + static_cast<std::ptrdiff_t>(part.count),
            part.leaves.begin() + static_cast<std::ptrdiff_t>(leaves), CloudLeaf{});
  part.count = leaves;
}

void add(std::uint64_t key, const CloudLeaf& points, std::uint32_t number, CloudPart& part) {
  CloudLeaf& leaf = part.leaves[number];
  for (std::size_t i = 0; i < leaf.sum.size(); ++i) leaf.sum[i] += points.sum[i];
  part.keys[number] = key;
}

/// Numbers the leaves of the points [begin, end) and adds their points up, a look-up for each run of neighbours in one leaf.
/// `leaf_of` is null where nobody wants it.
template <class Numbers, class Stretches>
void add_points(const Stretches& stretches, const Lattice& lattice, std::size_t begin, std::size_t end, CloudPart& part,
                std::uint32_t* leaf_of) {
  restart(lattice, part);
  std::array<kernels::LeafRun, kStretch> runs;
  std::array<std::uint64_t, kStretch> keys;
  std::array<std::uint32_t, kStretch> leaves;
  StretchBuffer buffer;
  LeavesOfPoints of_points;
  Numbers numbers(part);
  for (std::size_t first = begin; first < end; first += kStretch) {
    const std::size_t size = std::min(kStretch, end - first);
    const Stretch stretch = stretches(first, size, buffer);
    const std::size_t count = kernels::leaf_runs(stretch.points, stretch.stride, stretch.size, lattice.to_index, runs.data());
    // Three short loops: the look-ups of several runs are then on their way at once.
    for (std::size_t i = 0; i < count; ++i) keys[i] = lattice.key(runs[i].index);
    for (std::size_t i = 0; i < count; ++i) leaves[i] = numbers.number_of(keys[i]);
    grow(numbers.leaves(), part);
    CloudLeaf before;
    for (std::size_t i = 0; i < count; ++i) {
      CloudLeaf points;
      for (std::size_t k = 0; k < points.sum.size(); ++k) points.sum[k] = runs[i].sum[k] - before.sum[k];
      add(keys[i], points, leaves[i], part);
      if (leaf_of != nullptr) of_points.set(before.count(), runs[i].sum[3], leaves[i]);
      std::copy_n(runs[i].sum, before.sum.size(), before.sum.begin());
    }
    if (leaf_of != nullptr) of_points.copy(stretch, size, leaf_of + first);
  }
}

/// Adds a part to the first, whose points come before it; `part.number` then says what its leaves are called there.
template <class Numbers>
void merge(CloudPart& part, CloudPart& into) {
  part.number.resize(part.count);
  Numbers numbers(into);
  for (std::size_t leaf = 0; leaf < part.count; ++leaf) part.number[leaf] = numbers.number_of(part.keys[leaf]);
  grow(numbers.leaves(), into);
  for (std::size_t leaf = 0; leaf < part.count; ++leaf) add(part.keys[leaf], part.leaves[leaf], part.number[leaf], into);
}

/// Numbers the leaves and adds up their points: a part of them for each thread, merged in order.
template <class Numbers, class Stretches>
void add_points(const Stretches& stretches, std::size_t size, const Lattice& lattice, bool leaf_of, int threads,
                VoxelGrid& grid) {
  std::vector<CloudPart>& parts = grid.scratch->parts;
  grid.leaf_of.resize(leaf_of ? size : 0);
  std::uint32_t* const leaves = leaf_of ? grid.leaf_of.data() : nullptr;
  const std::size_t worthwhile = std::max<std::size_t>(1, size / kLeastPart);
  const auto count = std::min(static_cast<std::size_t>(resolve_threads(threads)), worthwhile);
  parts.resize(std::max(parts.size(), count));
  const auto begin_of = [&](std::size_t part) { return part == count ? size : part * (size / count); };
  parallel_for(threads, count,
               [&](std::size_t i) { add_points<Numbers>(stretches, lattice, begin_of(i), begin_of(i + 1), parts[i], leaves); });
  for (std::size_t i = 1; i < count; ++i) merge<Numbers>(parts[i], parts.front());
  if (!leaf_of) return;
  parallel_for(threads, count - 1, [&](std::size_t i) {
    const AlignedVector<std::uint32_t>& number = parts[i + 1].number;
    for (std::size_t p = begin_of(i + 1); p < begin_of(i + 2); ++p) {
      if (leaves[p] != VoxelGrid::kNoLeaf) leaves[p] = number[leaves[p]];
    }
  });
}

kernels::Box box_of(const PointCloud& cloud) {
  const std::array<const float*, 3> coordinates{cloud.x(), cloud.y(), cloud.z()};
  kernels::Box box{};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const kernels::Bounds bounds = kernels::bounds(coordinates[axis], cloud.padded_size());
    box.min[axis] = bounds.min;
    box.max[axis] = bounds.max;
  }
  return box;
}

void write_leaves(LeafPoint leaf_point, VoxelGrid& grid) {
  const Lattice& lattice = *grid.scratch->lattice;
  const CloudPart& all = grid.scratch->parts.front();
  const std::size_t leaves = all.count;
  grid.leaves.resize_uninitialised(leaves);
  grid.leaves.width = static_cast<int>(leaves);
  grid.leaves.height = 1;
  grid.point_count.resize(leaves);
  float* const x = grid.leaves.x();
  float* const y = grid.leaves.y();
  float* const z = grid.leaves.z();
  for (std::size_t i = 0; i < leaves; ++i) {
    const CloudLeaf& leaf = all.leaves[i];
    const auto coordinate = [&](std::size_t axis) {
      const auto sum = static_cast<double>(static_cast<std::int64_t>(leaf.sum[axis]));
      return static_cast<float>(sum * lattice.unit[axis] / static_cast<double>(leaf.count()));
    };
    x[i] = coordinate(0);
    y[i] = coordinate(1);
    z[i] = coordinate(2);
    grid.point_count[i] = static_cast<std::uint32_t>(leaf.count());
    grid.points += leaf.count();
  }
  if (leaf_point == LeafPoint::centre) {
    for (std::size_t i = 0; i < leaves; ++i) grid.leaves.set(i, lattice.centre(all.keys[i]).cast<float>());
  }
  grid.measured = grid.points;
}

/// Into a grid that is empty. `size` points, at least one of them finite.
template <class Stretches>
Status make_grid(const Stretches& stretches, std::size_t size, const kernels::Box& box, const PointsGridOptions& options,
                 VoxelGrid& grid) {
  const Result<Lattice> lattice = make_lattice(box, size, grid.leaves.origin, options.leaf_size_m);
  if (!lattice) return lattice.error();
  if (lattice->bars) {
    add_points<BarNumbers>(stretches, size, *lattice, options.leaf_of, options.threads, grid);
  } else {
    add_points<TableNumbers>(stretches, size, *lattice, options.leaf_of, options.threads, grid);
  }
  grid.scratch->lattice = *lattice;
  grid.smallest = lattice->smallest;
  grid.largest = lattice->largest;
  write_leaves(options.leaf_point, grid);
  return {};
}

Status check_leaf_sizes(const Eigen::Vector3d& leaf_size_m) {
  for (const double edge : leaf_size_m) {
    if (Status status = check_leaf_size(edge); !status) return status;
  }
  return {};
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
    key |= part << lattice.shift[static_cast<std::size_t>(axis)];
  }
  if (key >> lattice.key_bits != 0) return kNoLeaf;  // along z the key has more bits than there are leaves
  const CloudPart& all = scratch->parts.front();
  return (lattice.bars ? all.bars.number_of(static_cast<std::uint32_t>(key)) : all.table.number_of(key)).value_or(kNoLeaf);
}

VoxelGrid::Index VoxelGrid::index_at(const Eigen::Vector3f& local_point) const {
  Index index = Index::Zero();
  if (!scratch->lattice) return index;
  const Lattice& lattice = *scratch->lattice;
  const auto place = [&](int axis) {
    return static_cast<double>(local_point[axis]) * lattice.to_index.per_leaf[axis] + lattice.to_index.offset[axis];
  };
  const auto within = [&](int axis) {
    return place(axis) >= 0.0 && place(axis) < static_cast<double>(largest[axis] - smallest[axis] + 1);
  };
  if (within(0) && within(1) && within(2)) {  // through the kernel, which may round the other way (fused multiply-add)
    kernels::LeafRun run{};
    kernels::leaf_runs(local_point.data(), 3, 1, lattice.to_index, &run);
    return smallest + Index(run.index[0], run.index[1], run.index[2]);
  }
  constexpr double kFarthest = 0x1p53;  // doubles beyond it are far off any lattice, and hold no fractions
  for (int axis = 0; axis < 3; ++axis) {
    index[axis] = smallest[axis] + static_cast<std::int64_t>(std::floor(std::clamp(place(axis), -kFarthest, kFarthest)));
  }
  return index;
}

int Lattice::bits(int axis) const {
  const auto along = static_cast<std::size_t>(axis);
  return (axis < 2 ? shift[along + 1] : kMostBits) - shift[along];
}

std::uint64_t Lattice::index(std::uint64_t leaf_key, int axis) const {
  return bits(axis) == 0 ? 0 : (leaf_key >> shift[static_cast<std::size_t>(axis)]) & (~std::uint64_t{0} >> (64 - bits(axis)));
}

Eigen::Vector3d Lattice::centre(std::uint64_t leaf_key) const {
  const auto middle = [&](int axis) {
    return (static_cast<double>(index(leaf_key, axis)) + 0.5 - to_index.offset[axis]) * leaf_size[axis];
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

void clear(const Eigen::Vector3d& origin_m, VoxelGrid& grid) {
  grid.scratch->lattice.reset();
  grid.smallest.setZero();
  grid.largest.setZero();
  grid.leaves.origin = origin_m;
  grid.leaves.source.clear();
  grid.leaves.clear();
  grid.leaf_of.clear();
  grid.point_count.clear();
  grid.points = grid.measured = 0;
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
  if (Status status = check_leaf_sizes(leaf_size_m); !status) return status;
  clear(cloud.origin, grid);
  if (cloud.empty()) return {};
  return make_grid(CloudStretches{cloud}, cloud.size(), box_of(cloud), {leaf_size_m, leaf_point, true, threads}, grid);
} catch (const std::exception& exception) {
  return caught(exception, [&] { return "voxel grid of " + std::to_string(cloud.size()) + " points"; });
}

Status voxel_grid(const PointsView& points, const PointsGridOptions& options, VoxelGrid& grid) try {
  if (Status status = check_leaf_sizes(options.leaf_size_m); !status) return status;
  if (points.stride < 3) return Error{ErrorCode::invalid_argument, "points: a stride of less than three floats"};
  if (points.data == nullptr && points.size > 0) return Error{ErrorCode::invalid_argument, "points: no data"};
  clear(Eigen::Vector3d::Zero(), grid);
  const kernels::Box box = kernels::box(points.data, points.stride, points.size);
  if (box.min[0] > box.max[0]) {  // no finite point
    if (options.leaf_of) grid.leaf_of.assign(points.size, VoxelGrid::kNoLeaf);
    return {};
  }
  return make_grid(ViewStretches{points, box.finite}, points.size, box, options, grid);
} catch (const std::exception& exception) {
  return caught(exception, [&] { return "voxel grid of " + std::to_string(points.size) + " points"; });
}

}  // namespace fransac
