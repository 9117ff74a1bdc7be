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
#include "fransac/core/point_cloud.hpp"
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
    // The kernel may round the other way: half a leaf of slack keeps its last index inside the bits.
    const int axis_bits =
        countable ? static_cast<int>(std::bit_width(static_cast<std::uint64_t>(largest + 0.5))) : Lattice::kMostBits + 1;
    lattice.to_index.shift[axis] = static_cast<std::uint64_t>(bits);
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
    return {buffer.points.data(), StretchBuffer::kStride, size, nullptr, first};
  }
};

/// Points where they are; the finite ones are gathered where not all are.
struct ViewStretches {
  PointsView view;
  bool finite;

  Stretch operator()(std::size_t first, std::size_t size, StretchBuffer& buffer) const {
    const float* const from = view.data + first * view.stride;
    if (finite) return {from, view.stride, size, nullptr, first};
    std::size_t n = 0;
    for (std::size_t i = 0; i < size; ++i) {
      const float* const point = from + i * view.stride;
      float* const to = buffer.points.data() + StretchBuffer::kStride * n;
      to[0] = point[0];
      to[1] = point[1];
      to[2] = point[2];
      buffer.numbers[n] = static_cast<std::uint32_t>(first + i);
      n += static_cast<std::size_t>(((point[0] - point[0]) + (point[1] - point[1])) + (point[2] - point[2]) == 0.0F);
    }
    return {buffer.points.data(), StretchBuffer::kStride, n, buffer.numbers.data(), first};
  }
};

/// The same leaf for all points of each run. Leaves of short runs are written in one go, past their end.
class LeavesOfPoints {
 public:
  void set(std::size_t begin, std::size_t end, std::uint32_t leaf) {
    for (std::size_t i = begin; i < end; i += kAtOnce) std::fill_n(leaf_.data() + i, kAtOnce, leaf);
  }

  void copy(const Stretch& stretch, std::uint32_t* leaf_of) const {
    if (stretch.numbers == nullptr) {
      std::copy_n(leaf_.data(), stretch.size, leaf_of + stretch.first);
      return;
    }
    for (std::size_t i = 0; i < stretch.size; ++i) leaf_of[stretch.numbers[i]] = leaf_[i];
  }

 private:
  static constexpr std::size_t kAtOnce = 8;
  std::array<std::uint32_t, kStretch + kAtOnce> leaf_;
};

/// Numbers of leaves by key.
class BarNumbers {
 public:
  explicit BarNumbers(LeafBars& bars) : row_(bars) {}
  [[nodiscard]] std::uint32_t leaves() const { return row_.leaves(); }
  std::uint32_t number_of(std::uint64_t key) { return row_.number_of(static_cast<std::uint32_t>(key)); }

 private:
  LeafBars::Row row_;
};

/// The same of keys that are too long for bars.
class TableNumbers {
 public:
  explicit TableNumbers(LeafTable<std::uint64_t>& table) : table_(table) {}
  [[nodiscard]] std::uint32_t leaves() const { return table_.size(); }
  std::uint32_t number_of(std::uint64_t key) { return table_.find_or_add(key); }

 private:
  LeafTable<std::uint64_t>& table_;
};

/// Makes room for as many leaves and one more, those beyond region.count without points.
void grow(std::size_t leaves, LeafRegion& region) {
  if (region.leaves.size() <= leaves) {
    region.keys.resize(2 * leaves + 1);
    region.first.resize(2 * leaves + 1);
    region.leaves.resize(2 * leaves + 1);  // last: its size says what there is room for, also after an allocation that failed
  }
  std::fill(region.leaves.begin() + static_cast<std::ptrdiff_t>(region.count),
            region.leaves.begin() + static_cast<std::ptrdiff_t>(leaves), CloudLeaf{});
}

/// Points of a stretch and the keys of their leaves, one by one.
struct SinglePoints {
  std::size_t count = 0;
  std::array<kernels::LeafTerm, kStretch> sums;
  std::array<std::uint64_t, kStretch> keys;

  void read(const Stretch& stretch, const Lattice& lattice) {
    count = stretch.size;
    kernels::leaf_terms(stretch.points, stretch.stride, stretch.size, lattice.to_index, sums.data(), keys.data());
  }
  [[nodiscard]] static std::size_t begin(std::size_t i) { return i; }
  [[nodiscard]] static std::size_t end(std::size_t i) { return i + 1; }
  void add(std::size_t i, CloudLeaf& leaf) const {
    for (std::size_t k = 0; k < 4; ++k) leaf.sum[k] += sums[i].sum[k];
  }
};

/// The same of neighbours in one leaf, run by run.
struct RunsOfPoints {
  std::size_t count = 0;
  std::array<kernels::LeafRun, kStretch + 1> runs{};  ///< The first holds nothing.
  std::array<std::uint64_t, kStretch> keys;

  void read(const Stretch& stretch, const Lattice& lattice) {
    count = kernels::leaf_runs(stretch.points, stretch.stride, stretch.size, lattice.to_index, runs.data() + 1);
    for (std::size_t i = 0; i < count; ++i) keys[i] = lattice.key(runs[i + 1].index);
  }
  [[nodiscard]] std::size_t begin(std::size_t i) const { return runs[i].sum[3]; }
  [[nodiscard]] std::size_t end(std::size_t i) const { return runs[i + 1].sum[3]; }
  void add(std::size_t i, CloudLeaf& leaf) const {
    for (std::size_t k = 0; k < 4; ++k) leaf.sum[k] += runs[i + 1].sum[k] - runs[i].sum[k];
  }
};

/// What is to be said of each point's leaf, and where.
struct LeafOf {
  enum Name { number, first_point } name;  ///< The leaf's number in its region, or the first of its points.
  std::uint32_t* of_point;                 ///< Null where nobody wants it.
};

/// Numbers the leaves of the points [begin, end), all of one region, and adds their points up, with a look-up for each item of
/// `Items`: SinglePoints or RunsOfPoints.
template <class Items, class Numbers, class Stretches>
void add_points(const Stretches& stretches, const Lattice& lattice, std::size_t begin, std::size_t end, LeafOf leaf_of,
                Numbers numbers, LeafRegion& region) {
  Items items;
  std::array<std::uint32_t, kStretch> leaves;
  StretchBuffer buffer;
  LeavesOfPoints of_points;
  for (std::size_t first = begin; first < end; first += kStretch) {
    const Stretch stretch = stretches(first, std::min(kStretch, end - first), buffer);
    items.read(stretch, lattice);
    // Two short loops: the look-ups of several items are then on their way at once.
    for (std::size_t i = 0; i < items.count; ++i) leaves[i] = numbers.number_of(items.keys[i]);
    grow(numbers.leaves(), region);
    std::size_t known = region.count;
    for (std::size_t i = 0; i < items.count; ++i) {
      items.add(i, region.leaves[leaves[i]]);
      // New leaves come in the order of their numbers. Whether one is new cannot be predicted, so it is no branch.
      region.keys[known] = items.keys[i];
      region.first[known] = stretch.number(items.begin(i));
      known += static_cast<std::size_t>(leaves[i] == known);
    }
    region.count = known;
    if (leaf_of.of_point == nullptr) continue;
    for (std::size_t i = 0; i < items.count; ++i) {
      of_points.set(items.begin(i), items.end(i), leaf_of.name == LeafOf::number ? leaves[i] : region.first[leaves[i]]);
    }
    of_points.copy(stretch, leaf_of.of_point);
  }
}

/// Whether neighbours in the cloud mostly lie in different leaves, by some of them.
template <class Stretches>
bool in_any_order(const Stretches& stretches, std::size_t size, const Lattice& lattice) {
  constexpr std::size_t kLeastPoints = std::size_t{1} << 16;  // the leaves of fewer fit into the second-level cache
  constexpr std::size_t kLooks = 64;
  constexpr std::size_t kLength = 64;
  if (size < kLeastPoints) return false;
  std::array<kernels::LeafRun, kLength> runs;
  StretchBuffer buffer;
  std::size_t points = 0;
  std::size_t changes = 0;
  for (std::size_t look = 0; look < kLooks; ++look) {
    const Stretch stretch = stretches(look * (size / kLooks), kLength, buffer);
    points += stretch.size;
    changes += kernels::leaf_runs(stretch.points, stretch.stride, stretch.size, lattice.to_index, runs.data());
  }
  return 2 * changes > points;
}

/// Leaves in the order in which points enter them, looked up point by point.
template <class Stretches>
void add_in_order(const Stretches& stretches, std::size_t size, const Lattice& lattice, std::uint32_t* leaf_of,
                  VoxelGrid::Scratch& work) {
  LeafRegion& all = work.use_regions(1).front();
  all.count = 0;
  const LeafOf number{LeafOf::number, leaf_of};
  if (lattice.bars) {
    work.bars.restart(lattice.key_bits);
    add_points<RunsOfPoints>(stretches, lattice, 0, size, number, BarNumbers(work.bars), all);
  } else {
    all.table.restart();
    add_points<RunsOfPoints>(stretches, lattice, 0, size, number, TableNumbers(all.table), all);
  }
}

/// The same leaves bucket by bucket, numbered in the same order at the end.
template <class Stretches>
void add_by_buckets(const Stretches& stretches, std::size_t size, Lattice& lattice, std::uint32_t* leaf_of, int threads,
                    VoxelGrid::Scratch& work) {
  constexpr std::size_t kAtOnce = std::size_t{1} << 21;  // points; their copies take 32 MiB
  lattice.bars = false;
  const std::span<LeafRegion> regions = work.use_regions(PointBuckets::kBuckets);
  for (LeafRegion& region : regions) {
    region.count = 0;
    region.table.restart();
  }
  for (std::size_t begin = 0; begin < size; begin += kAtOnce) {
    work.buckets.sort(stretches, lattice.to_index, begin, std::min(size, begin + kAtOnce), threads);
    parallel_for(threads, regions.size(), [&](std::size_t i) {
      const std::size_t first = work.buckets.first_of(i);
      add_points<SinglePoints>(work.buckets, lattice, first, work.buckets.first_of(i + 1), {LeafOf::first_point, leaf_of},
                               TableNumbers(regions[i].table), regions[i]);
    });
  }
  work.ranks.restart(size);
  for (const LeafRegion& region : regions) {
    for (std::size_t i = 0; i < region.count; ++i) work.ranks.add(region.first[i]);
  }
  work.ranks.count_up();
  if (leaf_of == nullptr) return;
  for (std::size_t i = 0; i < size; ++i) {
    if (leaf_of[i] != VoxelGrid::kNoLeaf) leaf_of[i] = work.ranks.of(leaf_of[i]);
  }
}

/// Numbers the leaves and adds up their points.
template <class Stretches>
void add_points(const Stretches& stretches, std::size_t size, Lattice& lattice, bool leaf_of, int threads, VoxelGrid& grid) {
  grid.leaf_of.clear();
  if (leaf_of) grid.leaf_of.resize(size, VoxelGrid::kNoLeaf);
  std::uint32_t* const leaves = leaf_of ? grid.leaf_of.data() : nullptr;
  if (in_any_order(stretches, size, lattice)) {
    add_by_buckets(stretches, size, lattice, leaves, threads, *grid.scratch);
  } else {
    add_in_order(stretches, size, lattice, leaves, *grid.scratch);
  }
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

void write_leaves(LeafPoint leaf_point, int threads, VoxelGrid& grid) {
  const Lattice& lattice = *grid.scratch->lattice;
  const std::span<const LeafRegion> regions = grid.scratch->regions_in_use();
  std::size_t leaves = 0;
  for (const LeafRegion& region : regions) leaves += region.count;
  grid.leaves.resize_uninitialised(leaves);
  grid.leaves.width = static_cast<int>(leaves);
  grid.leaves.height = 1;
  grid.point_count.resize(leaves);
  parallel_for(threads, regions.size(), [&](std::size_t r) {
    const LeafRegion& region = regions[r];
    for (std::size_t i = 0; i < region.count; ++i) {
      const CloudLeaf& leaf = region.leaves[i];
      const std::size_t number = regions.size() == 1 ? i : grid.scratch->ranks.of(region.first[i]);
      const auto mean = [&](std::size_t axis) {
        const auto sum = static_cast<double>(static_cast<std::int64_t>(leaf.sum[axis]));
        return static_cast<float>(sum * lattice.unit[axis] / static_cast<double>(leaf.sum[3]));
      };
      const bool centroid = leaf_point == LeafPoint::centroid;
      grid.leaves.set(number,
                      centroid ? Eigen::Vector3f(mean(0), mean(1), mean(2)) : lattice.centre(region.keys[i]).cast<float>());
      grid.point_count[number] = static_cast<std::uint32_t>(leaf.sum[3]);
    }
  });
  for (const std::uint32_t count : grid.point_count) grid.points += count;
  grid.measured = grid.points;
}

/// Into a grid that is empty. `size` points, at least one of them finite.
template <class Stretches>
Status make_grid(const Stretches& stretches, std::size_t size, const kernels::Box& box, const PointsGridOptions& options,
                 VoxelGrid& grid) {
  Result<Lattice> lattice = make_lattice(box, size, grid.leaves.origin, options.leaf_size_m);
  if (!lattice) return lattice.error();
  add_points(stretches, size, *lattice, options.leaf_of, options.threads, grid);
  grid.scratch->lattice = *lattice;
  grid.smallest = lattice->smallest;
  grid.largest = lattice->largest;
  write_leaves(options.leaf_point, options.threads, grid);
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
  std::array<std::uint32_t, 3> place{};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const auto along = static_cast<Eigen::Index>(axis);
    // Rounding can put a point at the box's border one leaf beyond it.
    if (index[along] < smallest[along] || index[along] > largest[along] + 1) return kNoLeaf;
    const auto part = static_cast<std::uint64_t>(index[along] - smallest[along]);
    if (part >> lattice.bits(static_cast<int>(axis)) != 0) return kNoLeaf;
    place[axis] = static_cast<std::uint32_t>(part);
  }
  const std::uint64_t key = lattice.key(place.data());
  if (key >> lattice.key_bits != 0) return kNoLeaf;  // along z the key has more bits than there are leaves
  const std::span<const LeafRegion> regions = scratch->regions_in_use();
  const LeafRegion& region = regions.size() == 1 ? regions.front() : regions[kernels::bucket_of(place.data())];
  const std::optional<std::uint32_t> number =
      lattice.bars ? scratch->bars.number_of(static_cast<std::uint32_t>(key)) : region.table.number_of(key);
  if (!number) return kNoLeaf;
  return regions.size() == 1 ? *number : scratch->ranks.of(region.first[*number]);
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
  if (within(0) && within(1) && within(2)) {  // through the kernel, which may round the other way
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
  const auto shift = [this](int a) { return static_cast<int>(to_index.shift[static_cast<std::size_t>(a)]); };
  return (axis < 2 ? shift(axis + 1) : kMostBits) - shift(axis);
}

std::uint64_t Lattice::index(std::uint64_t leaf_key, int axis) const {
  return bits(axis) == 0
             ? 0
             : (leaf_key >> to_index.shift[static_cast<std::size_t>(axis)]) & (~std::uint64_t{0} >> (64 - bits(axis)));
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
  if (leaf_size_m > 0.0 && leaf_size_m <= kMaxCoordinate_m) return {};  // the middle of a larger leaf may be no float
  return Error{ErrorCode::invalid_argument, "leaf-size: must be a positive number of metres, at most 1e30"};
}

Status voxel_grid(const PointCloud& cloud, double leaf_size_m, LeafPoint leaf_point, VoxelGrid& grid, int threads) {
  const auto edges_m = Eigen::Vector3d::Constant(leaf_size_m);
  return voxel_grid(cloud, {.leaf_size_m = edges_m, .leaf_point = leaf_point, .leaf_of = true, .threads = threads}, grid);
}

Status voxel_grid(const PointCloud& cloud, const PointsGridOptions& options, VoxelGrid& grid) try {
  if (Status status = check_leaf_sizes(options.leaf_size_m); !status) return status;
  clear(cloud.origin, grid);
  if (cloud.empty()) return {};
  return make_grid(CloudStretches{cloud}, cloud.size(), box_of(cloud), options, grid);
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
