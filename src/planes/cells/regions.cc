// SPDX-License-Identifier: Apache-2.0
#include "planes/cells/regions.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <limits>
#include <numeric>
#include <optional>

#include "planes/cells/constants.hpp"
#include "planes/cells/judge.hpp"
#include "planes/cells/spread.hpp"

namespace fransac::cells {

namespace {

constexpr const Constants& kC = kConstants;

/// A block of cells that a region starts from.
struct SeedBlock {
  kernels::CellBlock block;
  int least_members;
};
// 3 x 3 cells have a normal that is known to a degree; strips and corners too thin for that start from 2 x 2, and one more.
constexpr std::array<SeedBlock, 2> kSeedBlocks{{{{3, 3, 1, 1, 7}, 9}, {{2, 2, 1, 1, 4}, 5}}};

class Grower {
 public:
  Grower(const Grid& grid, int threads, RegionBuffers& buffers, JudgeBuffers& judge, Regions& regions)
      : grid_(grid), threads_(threads), b_(buffers), regions_(regions), spread_(grid, buffers.spread), judge_(grid, judge) {
    regions.list.clear();
    regions.owner.assign(grid.size(), kNobody);
    b_.tried.assign(grid.size(), 0);
    b_.weight.assign(grid.size() + Grid::kPadding, 0.0F);
    for (std::size_t i = 0; i < grid.size(); ++i) b_.weight[i] = static_cast<float>(grid.usable[i]);
  }

  /// Planes that are expected need not be found: they start where they were seen, from a cell on them nearby.
  void run(std::span<const ExpectedPlane> expected) {
    constexpr int kNear = 2;
    for (const ExpectedPlane& plane : expected) {
      const int row = std::clamp(static_cast<int>((plane.v + 0.5 * grid_.height) / kernels::kCell), 0, grid_.rows - 1);
      const int column = std::clamp(static_cast<int>((plane.u + 0.5 * grid_.width) / kernels::kCell), 0, grid_.columns - 1);
      const FloatPlane test(plane.plane);
      int best_row = -1;
      int best_column = 0;
      float least = std::numeric_limits<float>::infinity();
      const Spread::Window near = spread_.window(row, column, kNear);
      for (int r = near.top; r <= near.bottom; ++r) {
        for (int c = near.left; c <= near.right; ++c) {
          const int i = grid_.index(r, c);
          const Grid::Distance distance = grid_.distance(i, test);
          if (!spread_.is_free(r, c) || !distance.within(grid_.slack[at(i)]) || distance.mean + distance.slope >= least) continue;
          least = distance.mean + distance.slope;
          best_row = r;
          best_column = c;
        }
      }
      if (best_row < 0) continue;
      PlaneFit start;
      start.plane = plane.plane;
      start.u = plane.u;
      start.v = plane.v;
      cells_ = 0;
      finish(best_row, best_column, start, kSeedBlocks[0].least_members);
    }
  }

  void run(const SeedBlock& seed) {
    find_seeds(seed.block);
    b_.tried.assign(grid_.size(), 0);
    for (const std::int32_t cell : b_.seeds) {
      if (regions_.list.size() == kMostRegions) return;
      const int row = cell / grid_.stride - 1;
      const int column = cell % grid_.stride - 1;
      if (b_.tried[at(cell)] == 0 && spread_.is_free(row, column)) grow(seed, row, column);
    }
  }

 private:
  /// Blocks of free usable cells on one plane, the flattest first; of equally flat ones the upper left.
  void find_seeds(const kernels::CellBlock& block) {
    b_.flatness.resize(grid_.size());
    const auto square = [](double x) { return static_cast<float>(x * x); };
    const float usable_noise = square(kC.sigmas);
    const float usable_length = square(grid_.noise.near_m) + square(kC.flat_m / 3.0);
    for_each_row(threads_, grid_, [&](int r) {
      const int i = grid_.index(r, 0);
      kernels::measure_blocks(grid_.arrays(i), b_.weight.data() + i, grid_.sigma.data() + i, at(grid_.columns), block,
                              usable_noise, usable_length, b_.flatness.data() + i);
    });
    b_.candidates.resize(grid_.size());
    std::size_t count = 0;
    for (int r = 0; r < grid_.rows; ++r) {
      for (int i = grid_.index(r, 0); i < grid_.index(r, grid_.columns); ++i) {
        b_.candidates[count] = i;  // to be written over unless it counts: faster than a branch that nobody can foretell
        count += static_cast<std::size_t>(b_.flatness[at(i)] < kernels::kNotFlat);
      }
    }
    b_.candidates.resize(count);
    sort_candidates();
  }

  /// A counting sort by the leading bits of flatness, steps of an eighth.
  void sort_candidates() {
    constexpr int kDropped = 20;
    const auto rank = [&](int i) { return at(static_cast<int>(std::bit_cast<std::uint32_t>(b_.flatness[at(i)]) >> kDropped)); };
    b_.first.assign(std::size_t{1} << (32 - kDropped - 1), 0);  // less the sign's bit
    for (const std::int32_t i : b_.candidates) ++b_.first[rank(i)];
    std::exclusive_scan(b_.first.begin(), b_.first.end(), b_.first.begin(), 0);
    b_.seeds.resize(b_.candidates.size());
    for (const std::int32_t i : b_.candidates) b_.seeds[at(b_.first[rank(i)]++)] = i;
  }

  /// The plane through the set that the spread is, which is near the given one.
  [[nodiscard]] std::optional<PlaneFit> fit_set(const kernels::CellSetPlane& plane) {
    const kernels::CellSetSums sums = spread_.sums(plane);
    cells_ = sums.cells;
    moments_ = moments_of(sums, plane);
    return fit(moments_);
  }

  /// The plane through the free cells of a block; nothing where they are too few.
  [[nodiscard]] std::optional<PlaneFit> fit_block(const kernels::CellBlock& block, int row, int column) {
    const int top = row - block.up;
    const int left = column - block.left;
    const Spread::Window window{std::max(top, 0), std::min(top + block.rows, grid_.rows) - 1, std::max(left, 0),
                                std::min(left + block.columns, grid_.columns) - 1};
    if (spread_.free_cells(window) < block.least)
      return std::nullopt;  // others have taken them since: the more seeds, the more so
    spread_.take(window);
    const std::size_t i = at(grid_.index(row, column));
    return fit_set({grid_.u[i], grid_.v[i], grid_.q[i], grid_.du[i], grid_.dv[i]});
  }

  void grow(const SeedBlock& seed, int row, int column) {
    std::optional<PlaneFit> plane = fit_block(seed.block, row, column);
    if (!plane) return;
    const auto spread = [&](const Spread::Window& window) {
      const kernels::CellSetPlane reference = about(plane->plane, plane->u, plane->v);
      spread_.run(row, column, reference, window);
      plane = fit_set(reference);
      return plane.has_value();
    };
    // A plane is trusted some way beyond the cells it goes through.
    for (double reach = 2.0;; reach *= 2.0) {
      const Spread::Window window = spread_.window(row, column, static_cast<int>(reach));
      if (!spread(window)) return give_up();
      if (!spread_.touches(window)) break;
    }
    if (cells_ < seed.least_members) return give_up();
    finish(row, column, *plane, seed.least_members);
  }

  void give_up() {
    spread_.for_each([&](int i) { b_.tried[at(i)] = 1; });
  }

  /// Spreads without a limit, and keeps what comes of it.
  void finish(int row, int column, PlaneFit plane, int least_members) {
    // Anew with the last plane, so that what an early one took by mistake goes.
    const kernels::CellSetPlane reference = about(plane.plane, plane.u, plane.v);
    spread_.run(row, column, reference, spread_.window(row, column, std::max(grid_.rows, grid_.columns)));
    const auto better = fit_set(reference);
    if (!better) return give_up();
    plane = *better;
    if (cells_ < least_members) return give_up();
    // Whether it is a plane or not, its cells have been looked at.
    spread_.claim();
    Region region;
    region.moments = moments_;
    region.fit = plane;
    region.cells = cells_;
    region.sum_errors(grid_, spread_.set());
    const bool may_be_plane = judge_.may_be_plane(region, spread_.set());
    const std::int16_t owner = may_be_plane ? static_cast<std::int16_t>(regions_.list.size()) : kNobody;
    spread_.for_each([&](int i) {
      b_.weight[at(i)] = 0.0F;
      regions_.owner[at(i)] = owner;
    });
    if (may_be_plane) regions_.list.push_back(region);
  }

  /// More planes than labels; it bounds the memory for pairs of them.
  static constexpr std::size_t kMostRegions = 1024;

  const Grid& grid_;
  int threads_;
  RegionBuffers& b_;
  Regions& regions_;
  Spread spread_;
  Judge judge_;
  Moments moments_;  ///< Of the last set that was fitted.
  int cells_ = 0;
};

}  // namespace

void grow_regions(const Grid& grid, std::span<const ExpectedPlane> expected, int threads, RegionBuffers& buffers,
                  JudgeBuffers& judge, Regions& regions) {
  Grower grower(grid, threads, buffers, judge, regions);
  grower.run(expected);
  for (const SeedBlock& block : kSeedBlocks) grower.run(block);
}

}  // namespace fransac::cells
