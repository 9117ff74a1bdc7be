// SPDX-License-Identifier: Apache-2.0
// The voxel grid of a depth image, row by row. A row is cut into runs of pixels with the same leaf; only runs are looked up.
#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <new>
#include <optional>
#include <string>

#include "core/caught.hpp"
#include "filter/voxel_grid_scratch.hpp"
#include "fransac/core/parallel.hpp"
#include "fransac/filter/deproject.hpp"

namespace fransac {
namespace {

/// Where the pixels of an image lie in the grid. See kernels::LeafRow for keys.
struct ImageLattice {
  std::array<int, 3> first{};  ///< What makes an index along x, y, z a leaf's: 0 or more.
  std::array<int, 3> shift{};
  int key_bits = 0;
  double leaf_size = 0.0;

  /// The middle of a leaf, metres.
  [[nodiscard]] Eigen::Vector3d centre(std::uint32_t key) const {
    const auto middle = [&](std::size_t axis) {
      const int next = axis < 2 ? shift[axis + 1] : key_bits;
      const std::uint32_t index = (key >> shift[axis]) & ((1U << (next - shift[axis])) - 1);
      return (static_cast<double>(index) - first[axis] + 0.5) * leaf_size;
    };
    return {middle(0), middle(1), middle(2)};
  }
};

/// The lattice of all pixels up to `largest_m` deep; nothing when there are too many leaves for a table.
std::optional<ImageLattice> make_lattice(const Camera& camera, double leaf_size_m, double largest_m) {
  const double leaves = largest_m / leaf_size_m;
  const std::array<double, 3> low{-camera.cx / camera.fx, -camera.cy / camera.fy, 0.0};
  const std::array<double, 3> high{(camera.width - 1 - camera.cx) / camera.fx, (camera.height - 1 - camera.cy) / camera.fy, 1.0};
  ImageLattice lattice;
  lattice.leaf_size = leaf_size_m;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    // The image's border at depth 0 or at the largest; one leaf more on each side for the rounding of floats. So no leaf is
    // first along an axis, and none has the key kNoLeaf.
    const double smallest = std::floor(std::min(0.0, low[axis]) * leaves) - 1.0;
    const double largest = std::floor(std::max(0.0, high[axis]) * leaves) + 1.0;
    if (!(largest - smallest < 0x1p22)) return std::nullopt;
    lattice.first[axis] = static_cast<int>(-smallest);
    lattice.shift[axis] = lattice.key_bits;
    lattice.key_bits += static_cast<int>(std::bit_width(static_cast<std::uint32_t>(largest - smallest)));
    if (axis == 0) lattice.key_bits = std::max(lattice.key_bits, LeafBars::kLeafBits);
  }
  if (lattice.key_bits > LeafBars::kMostBits) return std::nullopt;
  return lattice;
}

/// Sums of a run of pixels: of d, and of d times the column within kSumColumns.
struct RunSums {
  std::uint64_t d;
  std::uint64_t du;
};

/// Adds up runs of 16-bit depth by differences of running sums: no loop over a run, whose length nobody can predict.
class RunningSums {
 public:
  /// `running` has room for n + 1 sums.
  RunningSums(const std::uint16_t* raw, std::size_t n, std::uint64_t* running) : running_(running) {
    kernels::running_sums(raw, n, running);
  }

  [[nodiscard]] RunSums run(std::size_t first, std::size_t end) const {
    const std::uint64_t sum = running_[end] - running_[first];
    // A borrow from the low half cannot be: the sum of a row fits into it.
    return {sum & 0xFFFFFFFF, sum >> 32};
  }

 private:
  const std::uint64_t* running_;
};

/// The same for float depth, as whole multiples of a unit.
class UnitSums {
 public:
  UnitSums(const float* raw, float per_unit) : raw_(raw), per_unit_(per_unit) {}

  [[nodiscard]] RunSums run(std::size_t first, std::size_t end) const {
    RunSums sums{0, 0};
    for (std::size_t u = first; u < end; ++u) {
      const auto d = static_cast<std::uint64_t>(raw_[u] * per_unit_ + 0.5F);
      sums.d += d;
      sums.du += d * (u % kernels::kSumColumns);
    }
    return sums;
  }

 private:
  const float* raw_;
  float per_unit_;
};

/// One image's grid in the making.
template <class Raw>
class Builder {
 public:
  Builder(const DepthRows<Raw>& rows, const ImageLattice& lattice, double largest_m, VoxelGrid& grid)
      : rows_(rows), lattice_(lattice), grid_(grid) {
    const Camera& camera = rows.camera();
    const double metres = static_cast<double>(rows.view().metres_per_unit());
    if constexpr (std::is_same_v<Raw, float>)
      per_unit_ = static_cast<float>(std::ldexp(1.0 / largest_m, unit_bits(rows.view().size())));
    metres_per_count_ = std::is_same_v<Raw, float> ? 1.0 / static_cast<double>(per_unit_) : metres;
    leaf_row_.per_unit = static_cast<float>(metres / lattice.leaf_size);
    std::copy(lattice.first.begin(), lattice.first.end(), leaf_row_.first);
    leaf_row_.shift_y = lattice.shift[1];
    leaf_row_.shift_z = lattice.shift[2];
    AlignedVector<float>& ray_x = grid.scratch->ray_x;
    ray_x.resize(rows.padded_width());
    for (std::size_t u = 0; u < ray_x.size(); ++u) {
      ray_x[u] = u < rows.width() ? static_cast<float>((static_cast<double>(u) - camera.cx) / camera.fx) : 0.0F;
    }
    leaf_row_.ray_x = ray_x.data();
  }

  /// Adds up the rows [first, end).
  void add_rows(int first, int end, bool leaf_of, RowBand& band) const {
    begin(band);
    for (int v = first; v < end; ++v) {
      if (leaf_of) {
        add_row<true>(v, band);
      } else {
        add_row<false>(v, band);
      }
    }
  }

  /// Adds a band to the first, whose rows lie above it.
  static void merge(RowBand& band, RowBand& into) {
    reserve(into, band.bars.leaves());
    LeafBars::Row numbers(into.bars);
    for (std::uint32_t leaf = 1; leaf < band.bars.leaves(); ++leaf) {
      const LeafSums& from = band.sums[leaf];
      LeafSums& to = into.sums[numbers.number_of(static_cast<std::uint32_t>(from.key))];
      to.d_and_count += from.d_and_count;
      to.du += from.du;
      to.dv += from.dv;
      to.key = from.key;
    }
    into.measured += band.measured;
    clear(band);
  }

  /// Turns sums into points.
  void finish(LeafPoint leaf_point, RowBand& band) const {
    const Camera& camera = rows_.camera();
    const std::size_t leaves = band.bars.leaves() - 1;  // without that of the unmeasured pixels
    grid_.leaves.resize_uninitialised(leaves);
    grid_.leaves.width = static_cast<int>(leaves);
    grid_.leaves.height = 1;
    grid_.point_count.resize(leaves);
    const auto metres = static_cast<float>(metres_per_count_);
    const auto cx = static_cast<float>(camera.cx);
    const auto cy = static_cast<float>(camera.cy);
    const auto metres_per_fx = static_cast<float>(metres_per_count_ / camera.fx);
    const auto metres_per_fy = static_cast<float>(metres_per_count_ / camera.fy);
    float* const x = grid_.leaves.x();
    float* const y = grid_.leaves.y();
    float* const z = grid_.leaves.z();
    std::uint64_t points = 0;
    for (std::size_t leaf = 0; leaf < leaves; ++leaf) {
      const LeafSums& s = band.sums[leaf + 1];
      const float per_count = 1.0F / static_cast<float>(s.count());
      const auto d = static_cast<float>(static_cast<std::int64_t>(s.d()));
      x[leaf] = (static_cast<float>(static_cast<std::int64_t>(s.du)) - cx * d) * metres_per_fx * per_count;
      y[leaf] = (static_cast<float>(static_cast<std::int64_t>(s.dv)) - cy * d) * metres_per_fy * per_count;
      z[leaf] = d * metres * per_count;
      grid_.point_count[leaf] = s.count();
      points += s.count();
    }
    if (leaf_point == LeafPoint::centre) {
      for (std::size_t leaf = 0; leaf < leaves; ++leaf) {
        const auto key = static_cast<std::uint32_t>(band.sums[leaf + 1].key);
        grid_.leaves.set(leaf, lattice_.centre(key).template cast<float>());
      }
    }
    grid_.points = points;
    grid_.measured = band.measured;
    clear(band);
  }

 private:
  /// Bits of a float depth as a whole number: as many as a float has, and as let all pixels lie in one leaf.
  static int unit_bits(std::size_t pixels) {
    return std::min(24, LeafSums::kCountShift - static_cast<int>(std::bit_width(pixels)));
  }

  void begin(RowBand& band) const {
    clear(band);  // what a call that ran out of memory left behind
    band.bars.restart(lattice_.key_bits);
    band.measured = 0;
    reserve(band, 1);
    LeafBars::Row(band.bars).number_of(kernels::kNoLeaf);  // leaf 0 takes what belongs to none
    band.keys.resize(rows_.padded_width() + 1);
    band.keys[0] = kernels::kNoLeaf;
    band.running.resize(rows_.padded_width() + 1);
    band.starts.resize(rows_.padded_width() + kernels::kBlock);
  }

  /// Makes room for more leaves.
  static void reserve(RowBand& band, std::size_t more) {
    const std::size_t needed = band.bars.leaves() + more;
    if (needed > band.sums.size()) band.sums.resize(2 * needed, LeafSums{});
  }

  /// Leaves the sums zero, as they must be for new leaves.
  static void clear(RowBand& band) {
    std::fill_n(band.sums.begin(), band.bars.leaves(), LeafSums{});
    band.bars.forget();
  }

  template <bool kLeafOf>
  void add_row(int v, RowBand& band) const {
    const std::size_t n = rows_.padded_width();
    const typename DepthRows<Raw>::Row values = rows_.row(v, band.row);
    const Raw* const raw = values.kept;
    band.measured += rows_.count(values.measured);
    kernels::LeafRow row = leaf_row_;
    row.ray_y = static_cast<float>((v - rows_.camera().cy) / rows_.camera().fy);
    const std::uint32_t* const keys = band.keys.data() + 1;
    const std::uint32_t* const starts = band.starts.data();
    const std::size_t runs = kernels::row_kernels<Raw>().leaf_runs(raw, n, row, band.keys.data() + 1, band.starts.data());
    const auto run_sums = [&] {
      if constexpr (std::is_same_v<Raw, float>) {
        return UnitSums(raw, per_unit_);
      } else {
        return RunningSums(raw, n, band.running.data());
      }
    }();
    reserve(band, n);
    LeafSums* const sums = band.sums.data();
    LeafBars::Row numbers(band.bars);

    for (std::size_t r = 0; r < runs; ++r) {
      const std::size_t first = starts[r];
      const std::size_t end = starts[r + 1];
      const std::uint32_t key = keys[first];
      const std::uint32_t number = numbers.number_of(key);
      const RunSums run = run_sums.run(first, end);
      LeafSums& leaf = sums[number];
      leaf.d_and_count += run.d | std::uint64_t{end - first} << LeafSums::kCountShift;
      leaf.du += run.du + run.d * (first & ~std::size_t{kernels::kSumColumns - 1});
      leaf.dv += run.d * static_cast<std::uint64_t>(v);
      leaf.key = key;
      if constexpr (kLeafOf) {
        std::uint32_t* const of = grid_.leaf_of.data() + static_cast<std::size_t>(v) * rows_.width();
        std::fill(of + std::min(first, rows_.width()), of + std::min(end, rows_.width()), number - 1);  // 0 becomes kNoLeaf
      }
    }
  }

  const DepthRows<Raw>& rows_;
  const ImageLattice& lattice_;
  VoxelGrid& grid_;
  kernels::LeafRow leaf_row_{};
  float per_unit_ = 0.0F;          ///< Float depth: whole numbers per metre.
  double metres_per_count_ = 0.0;  ///< What one of the whole numbers stands for.
};

template <class Raw>
double largest_depth(const DepthRows<Raw>& rows, DepthRowBuffer& buffer) {
  Raw largest = 0;
  for (int v = 0; v < rows.height(); ++v) {
    largest = std::max(largest, kernels::row_kernels<Raw>().largest(rows.row(v, buffer).kept, rows.padded_width()));
  }
  return static_cast<double>(largest) * static_cast<double>(rows.view().metres_per_unit());
}

/// Bands of rows for the threads; small images are not worth a second one.
int band_count(int threads, std::size_t width, int height) {
  constexpr std::size_t kLeastPixels = std::size_t{1} << 17;
  const std::size_t worthwhile = std::max<std::size_t>(1, width * static_cast<std::size_t>(height) / kLeastPixels);
  return static_cast<int>(std::min<std::size_t>(static_cast<std::size_t>(resolve_threads(threads)), worthwhile));
}

/// False when the image has too many leaves for this way.
template <class Raw>
bool build(const DepthRows<Raw>& rows, const DepthGridOptions& options, VoxelGrid& grid) {
  VoxelGrid::Scratch& work = *grid.scratch;
  const int bands = options.leaf_of ? 1 : band_count(options.threads, rows.width(), rows.height());
  if (work.bands.size() < static_cast<std::size_t>(bands)) work.bands.resize(static_cast<std::size_t>(bands));
  double largest_m = static_cast<double>(rows.largest_kept()) * static_cast<double>(rows.view().metres_per_unit());
  std::optional<ImageLattice> lattice = make_lattice(rows.camera(), options.leaf_size_m, largest_m);
  if (!lattice || std::is_same_v<Raw, float>) {
    largest_m = largest_depth(rows, work.bands.front().row);
    lattice = make_lattice(rows.camera(), options.leaf_size_m, largest_m);
    if (!lattice) return false;
  }
  grid.leaf_of.resize(options.leaf_of ? rows.view().size() : 0);
  const Builder<Raw> builder(rows, *lattice, std::max(largest_m, 1e-6), grid);
  const int height = rows.height();
  parallel_for(options.threads, static_cast<std::size_t>(bands), [&](std::size_t i) {
    const auto row_of = [&](std::size_t band) {
      return static_cast<int>(band * static_cast<std::size_t>(height) / static_cast<std::size_t>(bands));
    };
    builder.add_rows(row_of(i), row_of(i + 1), options.leaf_of, work.bands[i]);
  });
  for (std::size_t i = 1; i < static_cast<std::size_t>(bands); ++i) Builder<Raw>::merge(work.bands[i], work.bands.front());
  builder.finish(options.leaf_point, work.bands.front());
  return true;
}

/// By way of the cloud: for leaves that are tiny beside the depth range.
Status voxel_grid_of_cloud(const DepthView& depth, const Camera& camera, const DepthGridOptions& options, VoxelGrid& grid) {
  PointCloud& cloud = grid.scratch->cloud;
  deproject(depth, camera, cloud);
  const std::uint64_t measured = cloud.size();
  if (options.limits != nullptr) pass_through(*options.limits, cloud);
  const PointsGridOptions of_points{.leaf_size_m = Eigen::Vector3d::Constant(options.leaf_size_m),
                                    .leaf_point = options.leaf_point,
                                    .leaf_of = options.leaf_of,
                                    .threads = options.threads};
  if (Status status = voxel_grid(cloud, of_points, grid); !status) return status;
  grid.measured = measured;
  if (!options.leaf_of) return {};
  AlignedVector<std::uint32_t> leaf_of(depth.size(), VoxelGrid::kNoLeaf);
  for (std::size_t i = 0; i < cloud.size(); ++i) leaf_of[cloud.source[i]] = grid.leaf_of[i];
  grid.leaf_of.swap(leaf_of);
  return {};
}

}  // namespace

Status voxel_grid(const DepthView& depth, const Camera& camera, const DepthGridOptions& options, VoxelGrid& grid) try {
  if (Status status = check_leaf_size(options.leaf_size_m); !status) return status;
  clear(Eigen::Vector3d::Zero(), grid);
  const bool small = depth.size() < LeafSums::kMostPixels;
  const bool built = small && with_raw_type(depth.format(), [&](auto raw) {
                       return build(DepthRows<decltype(raw)>(depth, camera, options.limits), options, grid);
                     });
  if (built) return {};
  return voxel_grid_of_cloud(depth, camera, options, grid);
} catch (const std::exception& exception) {
  return caught(exception, [&] {
    return "voxel grid of " + std::to_string(depth.width()) + " x " + std::to_string(depth.height()) + " pixels";
  });
}

}  // namespace fransac
