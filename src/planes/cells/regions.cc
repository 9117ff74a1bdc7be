// SPDX-License-Identifier: Apache-2.0
#include "planes/cells/regions.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <limits>
#include <numeric>
#include <optional>

#include "planes/cells/constants.hpp"
#include "planes/cells/spread.hpp"

namespace fransac::cells {

namespace {

constexpr const Constants& kC = kConstants;

/// A block of cells that a region starts from.
struct SeedBlock {
  kernels::CellBlock block;
  int least_members;
};
// 3 x 3 cells have a normal that is known to a degree; strips and corners too thin for that start from 2 x 2.
std::array<SeedBlock, 2> seed_blocks() {
  return {
      {{{3, 3, 1, 1, 7}, static_cast<int>(kC.least_cells)}, {{2, 2, 1, 1, 4}, static_cast<int>(kC.least_cells_of_small_seed)}}};
}

/// The direction in which a quadratic with second derivatives (xx, xy, yy) bends most.
struct Bend {
  double curvature;
  Eigen::Vector2d direction;
};
Bend strongest_bend(double xx, double xy, double yy) {
  const double mean = 0.5 * (xx + yy);
  const double curvature = mean + std::copysign(std::hypot(0.5 * (xx - yy), xy), mean);
  const Eigen::Vector2d a(curvature - yy, xy);
  const Eigen::Vector2d b(xy, curvature - xx);
  const Eigen::Vector2d& longer = a.squaredNorm() > b.squaredNorm() ? a : b;
  const double norm = longer.norm();
  return {curvature, norm > 0.0 ? Eigen::Vector2d(longer / norm) : Eigen::Vector2d::UnitX()};
}

/// Tells planes from curved surfaces and from chance.
class Judge {
 public:
  explicit Judge(const Grid& grid) : grid_(grid), camera_(grid.camera) {}

  /// Whether a region may be a plane, or a piece of one; how evident it is.
  [[nodiscard]] std::optional<double> evidence_of_plane(const Region& region, const Spread& spread) const {
    const kernels::CellSetShape shape = spread.shape(about(region.fit.plane, region.fit.u, region.fit.v));
    const double found = evidence(region, shape);
    if (found < kC.piece_share * kC.least_evidence) return std::nullopt;
    // Planes end at edges. Where the surface goes on smoothly, it is a curved one.
    const Spread::Border border = spread.border();
    if (border.smooth > kC.smooth_share * border.length || is_curved(region, shape)) return std::nullopt;
    return found;
  }

 private:
  /// One sigma of a cell's mean, of inverse depth.
  [[nodiscard]] double cell_noise(const Region& region) const { return grid_.noise.cell * region.sigma(); }

  /// A surface of radius R bends q by 1 / (R f^2) per squared pixel, however far it is (docs/algorithms.md, "Curved surfaces").
  [[nodiscard]] bool is_curved(const Region& region, const kernels::CellSetShape& shape) const {
    // Least squares of the distances in 1, x, y, x^2/2, xy, y^2/2.
    struct Term {
      int x, y;
      double factor;
    };
    constexpr std::array<Term, 6> kTerms{{{0, 0, 1.0}, {1, 0, 1.0}, {0, 1, 1.0}, {2, 0, 0.5}, {1, 1, 1.0}, {0, 2, 0.5}}};
    // Where sums of x^i y^j stand, i + j <= degree.
    const auto place = [](int x, int y, int degree) { return at(x + y * (degree + 1) - y * (y - 1) / 2); };
    Eigen::Matrix<double, 6, 6> normal;
    Eigen::Matrix<double, 6, 1> right;
    for (int i = 0; i < 6; ++i) {
      const Term& a = kTerms[at(i)];
      for (int j = 0; j < 6; ++j) {
        const Term& b = kTerms[at(j)];
        normal(i, j) = a.factor * b.factor * static_cast<double>(shape.position[place(a.x + b.x, a.y + b.y, 4)]);
      }
      right[i] = a.factor * static_cast<double>(shape.offset[place(a.x, a.y, 2)]);
    }
    // A strip two cells wide says nothing of how it bends across: before looking, a bend is anything up to that of a surface too
    // round for a cell to be flat.
    constexpr double kRoundest_m = 0.05;
    const double before = 1.0 / (kRoundest_m * camera_.fx * camera_.fy * kPerPixel * kPerPixel);
    const double least_variance = std::pow(kC.curved_noise * cell_noise(region), 2);
    for (int i = 3; i < 6; ++i) normal(i, i) += least_variance / (before * before);
    const Eigen::LDLT<Eigen::Matrix<double, 6, 6>> solver(normal);
    const Eigen::Matrix<double, 6, 1> solution = solver.solve(right);
    const double rest = std::max(0.0, static_cast<double>(shape.off) - solution.dot(right)) / std::max(1, region.cells - 6);
    const double variance = std::max(rest, least_variance);
    const Bend most = strongest_bend(solution[3], solution[4], solution[5]);
    const Eigen::Vector2d& e = most.direction;
    Eigen::Matrix<double, 6, 1> direction;
    direction << 0.0, 0.0, 0.0, e[0] * e[0], 2.0 * e[0] * e[1], e[1] * e[1];
    const double sigma = std::sqrt(std::max(0.0, variance * direction.dot(solver.solve(direction))));
    const double bend = (std::abs(most.curvature) - 2.0 * sigma) * kPerPixel * kPerPixel;  // per squared pixel
    if (!(bend > 0.0)) return false;
    const PlaneFit& f = region.fit;
    // A strip of uniform density has twelve times its variance as squared length.
    const double squared_length = 12.0 * (e[0] * e[0] * f.uu + 2.0 * e[0] * e[1] * f.uv + e[1] * e[1] * f.vv);
    const double sag = bend * squared_length / 8.0;  // of inverse depth
    const double radius = 1.0 / (bend * camera_.fx * camera_.fy);
    // The wider a surface curves, the more of its sag may be the sensor's.
    const double wide = std::max(1.0, std::pow(radius / kC.curved_radius_m, kC.curved_wide));
    const double length = kC.curved_m * grid_.noise.bias_scale * f.q * f.q;
    return sag > wide * std::hypot(kC.curved_k * cell_noise(region), length);
  }

  /// How improbable it is that cells of unrelated surfaces agree this well, in nats (docs/algorithms.md, "Evidence").
  [[nodiscard]] double evidence(const Region& region, const kernels::CellSetShape& shape) const {
    constexpr double kSteepest = 1.73;  // surfaces are seen up to 60 degrees from the front
    const double prior = static_cast<double>(Grid::kHalfCell) * kSteepest * region.fit.q / camera_.fx;
    const double least = 0.5 * cell_noise(region);
    const double slope = std::max(std::sqrt(static_cast<double>(shape.slope) / (2.0 * region.cells)), least);
    const double off = std::max(std::sqrt(static_cast<double>(shape.off) / region.cells), least);
    return (region.cells - 1) * (2.0 * std::max(0.0, std::log(prior / slope)) + std::max(0.0, std::log(2.0 * prior / off)));
  }

  static constexpr double kPerPixel = 1.0 / kernels::kCell;

  const Grid& grid_;
  const Camera& camera_;
};

class Grower {
 public:
  Grower(const Grid& grid, RegionBuffers& buffers, Regions& regions)
      : grid_(grid), b_(buffers), regions_(regions), spread_(grid, buffers.spread), judge_(grid) {
    regions.list.clear();
    regions.owner.assign(grid.size(), kNobody);
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
      finish(best_row, best_column, start, static_cast<int>(kC.least_cells));
    }
  }

  void run(const SeedBlock& seed) {
    find_seeds(seed.block);
    for (const std::int32_t cell : b_.seeds) {
      if (regions_.list.size() == kMostRegions) return;
      const int row = cell / grid_.stride - 1;
      const int column = cell % grid_.stride - 1;
      if (spread_.is_free(row, column)) grow(seed, row, column);
    }
  }

 private:
  /// Blocks of free usable cells on one plane, the flattest first; of equally flat ones the upper left.
  void find_seeds(const kernels::CellBlock& block) {
    b_.flatness.resize(grid_.size());
    const auto square = [](double x) { return static_cast<float>(x * x); };
    const float usable_noise = square(kC.usable_k);
    const float usable_length = square(kC.usable_m * grid_.noise.bias_scale) + square(kC.flat_in_cell_m);
    for (int r = 0; r < grid_.rows; ++r) {
      const int i = grid_.index(r, 0);
      kernels::measure_blocks(grid_.arrays(i), b_.weight.data() + i, grid_.sigma.data() + i, at(grid_.columns), block,
                              usable_noise, usable_length, b_.flatness.data() + i);
    }
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
    for (double reach = kC.grow_reach;; reach *= kC.grow_reach) {
      const Spread::Window window = spread_.window(row, column, static_cast<int>(reach));
      if (!spread(window)) return;
      if (!spread_.touches(window)) break;
    }
    if (cells_ < seed.least_members) return;
    finish(row, column, *plane, seed.least_members);
  }

  /// Spreads without a limit, and keeps what comes of it.
  void finish(int row, int column, PlaneFit plane, int least_members) {
    // Anew with the last plane, so that what an early one took by mistake goes, until nothing changes, or twice.
    const Spread::Window all = spread_.window(row, column, std::max(grid_.rows, grid_.columns));
    constexpr int kAgain = 2;
    for (int again = 0, before = -1; again < kAgain && cells_ != before; ++again) {
      before = cells_;
      const kernels::CellSetPlane reference = about(plane.plane, plane.u, plane.v);
      spread_.run(row, column, reference, all);
      const auto better = fit_set(reference);
      if (!better) return;
      plane = *better;
    }
    if (cells_ < least_members) return;
    // Whether it is a plane or not, its cells have been looked at.
    spread_.claim();
    spread_.for_each([&](int i) { b_.weight[at(i)] = 0.0F; });
    Region region{.moments = moments_, .fit = plane, .cells = cells_};
    spread_.for_each([&](int i) { region.add(grid_, i); });
    const std::optional<double> evidence = judge_.evidence_of_plane(region, spread_);
    if (!evidence) return;
    region.evidence = *evidence;
    const auto id = static_cast<std::int16_t>(regions_.list.size());
    spread_.for_each([&](int i) { regions_.owner[at(i)] = id; });
    regions_.list.push_back(region);
  }

  /// More planes than labels; it bounds the memory for pairs of them.
  static constexpr std::size_t kMostRegions = 1024;

  const Grid& grid_;
  RegionBuffers& b_;
  Regions& regions_;
  Spread spread_;
  Judge judge_;
  Moments moments_;  ///< Of the last set that was fitted.
  int cells_ = 0;
};

}  // namespace

void release_cells(Regions& regions) {
  for (std::int16_t& owner : regions.owner) {
    if (owner != kNobody && !regions.list[at(owner)].alive) owner = kNobody;
  }
}

void grow_regions(const Grid& grid, std::span<const ExpectedPlane> expected, RegionBuffers& buffers,
                  Regions& regions) {
  Grower grower(grid, buffers, regions);
  grower.run(expected);
  for (const SeedBlock& block : seed_blocks()) grower.run(block);
}

}  // namespace fransac::cells
