// SPDX-License-Identifier: Apache-2.0
#include "planes/cells/regions.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>

#include "planes/cells/constants.hpp"

namespace fransac::cells {

/// Sums over a region's cells that tell its curvature and its evidence. Positions are in cells from the region's mean.
struct RegionBuffers::Shape {
  Eigen::Matrix<double, 6, 6> normal = Eigen::Matrix<double, 6, 6>::Zero();
  Eigen::Matrix<double, 6, 1> right = Eigen::Matrix<double, 6, 1>::Zero();
  double off = 0.0;    ///< Squared distances of means.
  double slope = 0.0;  ///< Of slopes, times half a cell.
};
RegionBuffers::RegionBuffers() = default;
RegionBuffers::~RegionBuffers() = default;

namespace {

constexpr const Constants& kC = kConstants;

std::size_t at(int i) { return static_cast<std::size_t>(i); }

/// A block of cells that a region starts from.
struct SeedBlock {
  int rows;
  int columns;
  int least;  ///< Usable cells.
  int least_members;
};
// 3 x 3 cells have a normal that is known to a degree; strips and corners too thin for that start from 2 x 2.
std::array<SeedBlock, 2> seed_blocks() {
  return {{{3, 3, 7, static_cast<int>(kC.least_cells)}, {2, 2, 4, static_cast<int>(kC.least_cells_of_small_seed)}}};
}

class Grower {
 public:
  Grower(const Grid& grid, RegionBuffers& buffers, Regions& regions) : grid_(grid), b_(buffers), regions_(regions) {
    regions.list.clear();
    regions.owner.assign(grid.size(), kNobody);
    b_.mark.assign(grid.size(), -1);
    seed_length_ = std::hypot(kC.usable_m * grid.noise.bias_scale, kC.flat_in_cell_m);
  }

  void run(const SeedBlock& block) {
    find_seeds(block);
    for (const RegionBuffers::Seed& seed : b_.seeds) {
      if (regions_.list.size() >= static_cast<std::size_t>(std::numeric_limits<std::int16_t>::max())) return;
      if (regions_.owner[at(seed.cell)] == kNobody) grow(block, seed.cell);
    }
  }

 private:
  /// The cell from which a block's first cell is reached.
  [[nodiscard]] int first_cell(const SeedBlock& block, int centre) const {
    return centre - (block.rows / 2) * grid_.stride - block.columns / 2;
  }

  template <class Visitor>
  void for_each_of(const SeedBlock& block, int centre, Visitor visit) const {
    const int first = first_cell(block, centre);
    for (int r = 0; r < block.rows; ++r) {
      for (int c = 0; c < block.columns; ++c) visit(first + r * grid_.stride + c);
    }
  }

  /// Blocks of usable cells, the flattest first.
  void find_seeds(const SeedBlock& block) {
    b_.seeds.clear();
    for (int r = 0; r < grid_.rows; ++r) {
      for (int c = 0; c < grid_.columns; ++c) {
        const int centre = grid_.index(r, c);
        if (grid_.usable[at(centre)] == 0 || regions_.owner[at(centre)] != kNobody) continue;
        int usable = 0;
        float sum = 0.0F;
        for_each_of(block, centre, [&](int i) {
          const bool is_free = grid_.usable[at(i)] != 0 && regions_.owner[at(i)] == kNobody;
          usable += is_free ? 1 : 0;
          sum += is_free ? grid_.residual[at(i)] : 0.0F;
        });
        if (usable < block.least) continue;
        const float shape = grid_.shape[at(centre)];
        b_.seeds.push_back({sum / (static_cast<float>(usable) * shape * shape), centre});
      }
    }
    std::sort(b_.seeds.begin(), b_.seeds.end(),
              [](const auto& a, const auto& b) { return a.score < b.score || (a.score == b.score && a.cell < b.cell); });
  }

  void grow(const SeedBlock& block, int centre) {
    Moments moments;
    int usable = 0;
    for_each_of(block, centre, [&](int i) {
      if (grid_.usable[at(i)] == 0 || regions_.owner[at(i)] != kNobody) return;
      moments += grid_.moments(i);
      ++usable;
    });
    if (usable < block.least) return;
    std::optional<PlaneFit> plane = fit(moments);
    if (!plane || plane->mean_squared_residual >
                      static_cast<double>(grid_.tolerance(centre, kC.usable_k * grid_.noise.pixel, seed_length_))) {
      return;
    }
    constexpr int kPasses = 2;
    for (int pass = 0; pass < kPasses; ++pass) {
      plane = flood(centre, *plane, pass == 0, moments);
      if (!plane) return;
    }
    if (static_cast<int>(b_.members.size()) < block.least_members) return;
    const auto id = static_cast<std::int16_t>(regions_.list.size());
    for (const int i : b_.members) regions_.owner[at(i)] = id;
    regions_.list.push_back({.moments = moments, .fit = *plane, .cells = static_cast<int>(b_.members.size())});
  }

  /// Fills `members` with the free cells that links join to `centre` and that fit; the plane through them.
  std::optional<PlaneFit> flood(int centre, const PlaneFit& start, bool refit, Moments& moments) {
    std::vector<std::int32_t>& members = b_.members;
    members.clear();
    moments = {};
    InversePlane plane = start.plane;
    if (!grid_.fits(centre, plane, grid_.slack[at(centre)])) return std::nullopt;
    ++stamp_;
    members.push_back(centre);
    b_.mark[at(centre)] = stamp_;
    auto next = static_cast<std::size_t>(kC.least_cells * kC.grow_ratio);
    for (std::size_t head = 0; head < members.size(); ++head) {
      const int i = members[head];
      moments += grid_.moments(i);
      if (refit && head + 1 >= next) {
        if (const auto better = fit(moments)) plane = better->plane;
        next = static_cast<std::size_t>(static_cast<double>(next) * kC.grow_ratio) + 1;
      }
      const std::uint8_t links = grid_.links[at(i)];
      for (int direction = 0; direction < 4; ++direction) {
        if ((links >> direction & 1) == 0) continue;
        const int j = i + grid_.step(direction);
        if (b_.mark[at(j)] == stamp_ || regions_.owner[at(j)] != kNobody) continue;
        if (!grid_.fits(j, plane, grid_.slack[at(j)])) continue;
        b_.mark[at(j)] = stamp_;
        members.push_back(j);
      }
    }
    return fit(moments);
  }

  const Grid& grid_;
  RegionBuffers& b_;
  Regions& regions_;
  double seed_length_ = 0.0;
  int stamp_ = 0;
};

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
  Judge(const Grid& grid, const Camera& camera, RegionBuffers& buffers, Regions& regions)
      : grid_(grid), camera_(camera), shapes_(buffers.shapes), regions_(regions) {}

  void run() {
    shapes_.assign(regions_.list.size(), {});
    for (int r = 0; r < grid_.rows; ++r) {
      for (int c = 0; c < grid_.columns; ++c) add(grid_.index(r, c));
    }
    for (std::size_t g = 0; g < regions_.list.size(); ++g) {
      Region& region = regions_.list[g];
      region.alive = !is_curved(region, shapes_[g]) && evidence(region, shapes_[g]) >= kC.least_evidence;
    }
    for (std::int16_t& owner : regions_.owner) {
      if (owner != kNobody && !regions_.list[static_cast<std::size_t>(owner)].alive) owner = kNobody;
    }
  }

 private:
  static constexpr double kPerPixel = 1.0 / kernels::kCell;

  void add(int cell) {
    const std::int16_t owner = regions_.owner[at(cell)];
    if (owner == kNobody) return;
    const PlaneFit& plane = regions_.list[static_cast<std::size_t>(owner)].fit;
    RegionBuffers::Shape& shape = shapes_[static_cast<std::size_t>(owner)];
    const auto u = static_cast<double>(grid_.u[at(cell)]);
    const auto v = static_cast<double>(grid_.v[at(cell)]);
    const double x = (u - plane.u) * kPerPixel;
    const double y = (v - plane.v) * kPerPixel;
    const double off = static_cast<double>(grid_.q[at(cell)]) - plane.plane.at(u, v);
    Eigen::Matrix<double, 6, 1> basis;
    basis << 1.0, x, y, 0.5 * x * x, x * y, 0.5 * y * y;
    shape.normal.selfadjointView<Eigen::Lower>().rankUpdate(basis);
    shape.right += off * basis;
    shape.off += off * off;
    const double a = static_cast<double>(Grid::kHalfCell) * (static_cast<double>(grid_.du[at(cell)]) - plane.plane.du);
    const double b = static_cast<double>(Grid::kHalfCell) * (static_cast<double>(grid_.dv[at(cell)]) - plane.plane.dv);
    shape.slope += a * a + b * b;
  }

  /// A surface of radius R bends q by 1 / (R f^2) per squared pixel, however far it is (docs/algorithms.md, "Curved surfaces").
  [[nodiscard]] bool is_curved(const Region& region, const RegionBuffers::Shape& shape) const {
    const Eigen::Matrix<double, 6, 6> normal = shape.normal.selfadjointView<Eigen::Lower>();
    const Eigen::LDLT<Eigen::Matrix<double, 6, 6>> solver(normal);
    const Eigen::Matrix<double, 6, 1> solution = solver.solve(shape.right);
    const double rest = std::max(0.0, shape.off - solution.dot(shape.right)) / std::max(1, region.cells - 6);
    const double variance = std::max(rest, std::pow(kC.curved_noise * grid_.noise.cell, 2));
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
    const double length = kC.curved_m * grid_.noise.bias_scale * f.q * f.q;
    return bend * camera_.fx * camera_.fy * kC.curved_radius_m > 1.0 && sag > std::hypot(kC.curved_k * grid_.noise.cell, length);
  }

  /// How improbable it is that cells of unrelated surfaces agree this well, in nats (docs/algorithms.md, "Evidence").
  [[nodiscard]] double evidence(const Region& region, const RegionBuffers::Shape& shape) const {
    constexpr double kSteepest = 1.73;  // surfaces are seen up to 60 degrees from the front
    const double prior = static_cast<double>(Grid::kHalfCell) * kSteepest * region.fit.q / camera_.fx;
    const double least = 0.5 * grid_.noise.cell;
    const double slope = std::max(std::sqrt(shape.slope / (2.0 * region.cells)), least);
    const double off = std::max(std::sqrt(shape.off / region.cells), least);
    return (region.cells - 1) * (2.0 * std::max(0.0, std::log(prior / slope)) + std::max(0.0, std::log(2.0 * prior / off)));
  }

  const Grid& grid_;
  const Camera& camera_;
  std::vector<RegionBuffers::Shape>& shapes_;
  Regions& regions_;
};

}  // namespace

void grow_regions(const Grid& grid, const Camera& camera, RegionBuffers& buffers, Regions& regions) {
  Grower grower(grid, buffers, regions);
  for (const SeedBlock& block : seed_blocks()) grower.run(block);
  Judge(grid, camera, buffers, regions).run();
}

}  // namespace fransac::cells
