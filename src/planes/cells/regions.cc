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

namespace fransac::cells {

/// Sums over a region's cells that tell its curvature and its evidence. Positions are in cells from the region's mean.
struct RegionBuffers::Shape {
  std::array<std::array<double, 5>, 5> position{};  ///< [i][j]: of x^i y^j, i + j <= 4.
  std::array<std::array<double, 3>, 3> offset{};    ///< [i][j]: of x^i y^j times the distance of the mean, i + j <= 2.
  double off = 0.0;                                 ///< Squared distances of means.
  double slope = 0.0;                               ///< Of slopes, times half a cell.
  int border = 0;                                   ///< Sides of cells with another owner beyond,
  int smooth = 0;                                   ///< of them crossed by a smooth surface.
};
RegionBuffers::RegionBuffers() = default;
RegionBuffers::~RegionBuffers() = default;

namespace {

constexpr const Constants& kC = kConstants;

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
    b_.moments.resize(grid.size());
    for (std::size_t i = 0; i < grid.size(); ++i) {
      if (grid.usable[i] != 0) b_.moments[i] = grid.moments(static_cast<int>(i));
    }
    seed_length_ = std::hypot(kC.usable_m * grid.noise.bias_scale, kC.flat_in_cell_m);
  }

  void run(const SeedBlock& block) {
    find_seeds(block);
    for (const std::int32_t seed : b_.seeds) {
      if (regions_.list.size() >= static_cast<std::size_t>(std::numeric_limits<std::int16_t>::max())) return;
      if (regions_.owner[at(seed)] == kNobody) grow(block, seed);
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

  /// The leading bits of a mean squared residual in units of the noise: steps of an eighth.
  static constexpr int kDropped = 20;
  static constexpr std::uint16_t kNone = 1U << (32 - kDropped - 1);
  [[nodiscard]] std::uint16_t rank_of(float squared_residual, int cell) const {
    const float shape = grid_.shape[at(cell)];
    return static_cast<std::uint16_t>(std::bit_cast<std::uint32_t>(squared_residual / (shape * shape)) >> kDropped);
  }

  /// The plane through the free cells of a block; nothing where they are too few or not on one.
  [[nodiscard]] std::optional<PlaneFit> fit_block(const SeedBlock& block, int centre) const {
    Moments moments;
    int usable = 0;
    for_each_of(block, centre, [&](int i) {
      if (grid_.usable[at(i)] == 0 || regions_.owner[at(i)] != kNobody) return;
      moments += b_.moments[at(i)];
      ++usable;
    });
    if (usable < block.least) return std::nullopt;
    const auto plane = fit(moments);
    const auto most = static_cast<double>(grid_.tolerance(centre, kC.usable_k * grid_.noise.pixel, seed_length_));
    if (!plane || plane->mean_squared_residual > most) return std::nullopt;
    return plane;
  }

  /// Blocks of free usable cells, the flattest first; of equally flat ones the upper left.
  void find_seeds(const SeedBlock& block) {
    const std::size_t size = grid_.size();
    b_.free.resize(size);
    for (std::size_t i = 0; i < size; ++i) {
      b_.free[i] = static_cast<std::uint8_t>(grid_.usable[i] & static_cast<int>(regions_.owner[i] == kNobody));
    }
    if (block.rows == 3) fit_full_blocks();
    // A counting sort.
    b_.first.assign(std::size_t{kNone} + 2, 0);
    b_.rank.resize(size);
    const int begin = grid_.index(0, 0);
    const int end = grid_.index(grid_.rows - 1, grid_.columns);
    for (int i = begin; i < end; ++i) {
      b_.rank[at(i)] = b_.free[at(i)] != 0 ? rank_of_block(block, i) : kNone;
      ++b_.first[b_.rank[at(i)] + 1U];
    }
    std::partial_sum(b_.first.begin(), b_.first.end(), b_.first.begin());
    b_.seeds.resize(at(b_.first[kNone]));
    for (int i = begin; i < end; ++i) {
      if (const std::uint16_t rank = b_.rank[at(i)]; rank != kNone) b_.seeds[at(b_.first[rank]++)] = i;
    }
  }

  [[nodiscard]] std::uint16_t rank_of_block(const SeedBlock& block, int centre) const {
    if (block.rows == 3 && b_.full[at(centre)] != 0) return rank_of(b_.residual[at(centre)], centre);
    const auto plane = fit_block(block, centre);
    return plane ? rank_of(static_cast<float>(plane->mean_squared_residual), centre) : kNone;
  }

  /// The residuals of the planes through all 3 x 3 blocks of free cells, as if no cell lacked a pixel: it is for their order
  /// only.
  void fit_full_blocks() {
    const std::size_t size = grid_.size();
    b_.residual.resize(size);
    b_.full.resize(size);
    const auto stride = static_cast<std::ptrdiff_t>(grid_.stride);
    const float* const __restrict q = grid_.q.data();
    const float* const __restrict du = grid_.du.data();
    const float* const __restrict dv = grid_.dv.data();
    const float* const __restrict inside = grid_.residual.data();
    const std::uint8_t* const __restrict is_free = b_.free.data();
    float* const __restrict residual = b_.residual.data();
    std::uint8_t* const __restrict full = b_.full.data();
    constexpr float kSize = kernels::kCell;
    constexpr float kSpread = (kSize * kSize - 1.0F) / 12.0F;              // mean square of a cell's columns about their mean
    constexpr float kBlockSpread = 6.0F * kSize * kSize + 9.0F * kSpread;  // nine times that of the block's
    const auto end = static_cast<std::ptrdiff_t>(size) - stride - 1;
    for (std::ptrdiff_t i = stride + 1; i < end; ++i) {
      // About the plane of the cell in the middle, so that floats are enough.
      float sum = 0.0F;
      float squares = 0.0F;
      float along_u = 0.0F;
      float along_v = 0.0F;
      for (int y = -1; y <= 1; ++y) {
        for (int x = -1; x <= 1; ++x) {
          const std::ptrdiff_t j = i + y * stride + x;
          const float off = q[j] - q[i] - kSize * (static_cast<float>(x) * du[i] + static_cast<float>(y) * dv[i]);
          const float a = du[j] - du[i];
          const float b = dv[j] - dv[i];
          sum += off;
          squares += off * off + kSpread * (a * a + b * b) + inside[j];
          along_u += kSize * static_cast<float>(x) * off + kSpread * a;
          along_v += kSize * static_cast<float>(y) * off + kSpread * b;
        }
      }
      const float rest = squares - sum * sum / 9.0F - (along_u * along_u + along_v * along_v) / kBlockSpread;
      residual[i] = rest > 0.0F ? rest / 9.0F : 0.0F;
    }
    for (std::ptrdiff_t i = stride + 1; i < end; ++i) {
      int all = 1;
      for (int y = -1; y <= 1; ++y) {
        for (int x = -1; x <= 1; ++x) all &= is_free[i + y * stride + x];
      }
      full[i] = static_cast<std::uint8_t>(all);
    }
  }

  void grow(const SeedBlock& block, int centre) {
    std::optional<PlaneFit> plane = fit_block(block, centre);
    if (!plane) return;
    Moments moments;
    // The first flood refits as it goes; the others begin anew with the last plane, so that what an early one took by mistake
    // goes.
    constexpr int kFloods = 3;
    for (int flood = 0; flood < kFloods; ++flood) {
      plane = spread(centre, *plane, flood == 0, moments);
      if (!plane) return;
    }
    if (static_cast<int>(b_.members.size()) < block.least_members) return;
    const auto id = static_cast<std::int16_t>(regions_.list.size());
    for (const int i : b_.members) regions_.owner[at(i)] = id;
    regions_.list.push_back({.moments = moments, .fit = *plane, .cells = static_cast<int>(b_.members.size())});
  }

  void add(int cell) {
    b_.members.push_back(cell);
    b_.mark[at(cell)] = stamp_;
  }

  /// Makes the members those free cells that links join to `centre` and that fit; the plane through them.
  std::optional<PlaneFit> spread(int centre, const PlaneFit& start, bool refit, Moments& moments) {
    FloatPlane plane(start.plane);
    if (!grid_.fits(centre, plane)) return std::nullopt;
    moments = {};
    b_.members.clear();
    ++stamp_;
    add(centre);
    auto next = static_cast<std::size_t>(kC.least_cells * kC.grow_ratio);
    for (std::size_t head = 0; head < b_.members.size(); ++head) {
      const int i = b_.members[head];
      moments += b_.moments[at(i)];
      if (refit && head + 1 >= next) {
        if (const auto better = fit(moments)) plane = FloatPlane(better->plane);
        next = static_cast<std::size_t>(static_cast<double>(next) * kC.grow_ratio) + 1;
      }
      const std::uint8_t links = grid_.links[at(i)];
      const auto try_cell = [&](std::uint8_t link, int j) {
        if ((links & link) == 0 || b_.mark[at(j)] == stamp_ || regions_.owner[at(j)] != kNobody) return;
        if (grid_.fits(j, plane)) add(j);
      };
      try_cell(Grid::kRight, i + 1);
      try_cell(Grid::kDown, i + grid_.stride);
      try_cell(Grid::kLeft, i - 1);
      try_cell(Grid::kUp, i - grid_.stride);
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
      for (int first = grid_.index(r, 0); first < grid_.index(r, grid_.columns);) {
        const std::int16_t owner = regions_.owner[at(first)];
        int end = first + 1;
        while (end < grid_.index(r, grid_.columns) && regions_.owner[at(end)] == owner) ++end;
        if (owner != kNobody) {
          add(first, end, regions_.list[at(owner)].fit, shapes_[at(owner)]);
          for (int i = first; i < end; ++i) look_around(i, owner, i == first, i + 1 == end, shapes_[at(owner)]);
        }
        first = end;
      }
    }
    for (std::size_t g = 0; g < regions_.list.size(); ++g) {
      Region& region = regions_.list[g];
      if (!region.alive) continue;
      const RegionBuffers::Shape& shape = shapes_[g];
      region.alive = evidence(region, shape) >= kC.least_evidence && shape.smooth <= kC.smooth_share * shape.border &&
                     !is_curved(region, shape);
    }
    release_cells(regions_);
  }

 private:
  static constexpr double kPerPixel = 1.0 / kernels::kCell;

  /// Adds a run of cells of one row; their centres stand for their mean rows, which differ little.
  void add(int first, int end, const PlaneFit& plane, RegionBuffers::Shape& shape) const {
    std::array<double, 5> x_power{};
    std::array<double, 3> off_x{};
    for (int i = first; i < end; ++i) {
      const auto u = static_cast<double>(grid_.u[at(i)]);
      const double x = (u - plane.u) * kPerPixel;
      const double off = static_cast<double>(grid_.q[at(i)]) - plane.plane.at(u, static_cast<double>(grid_.v[at(i)]));
      const double a = static_cast<double>(Grid::kHalfCell) * (static_cast<double>(grid_.du[at(i)]) - plane.plane.du);
      const double b = static_cast<double>(Grid::kHalfCell) * (static_cast<double>(grid_.dv[at(i)]) - plane.plane.dv);
      const double xx = x * x;
      x_power[1] += x;
      x_power[2] += xx;
      x_power[3] += xx * x;
      x_power[4] += xx * xx;
      off_x[0] += off;
      off_x[1] += off * x;
      off_x[2] += off * xx;
      shape.off += off * off;
      shape.slope += a * a + b * b;
    }
    x_power[0] = end - first;
    const double y = (static_cast<double>(grid_.v[at(first)]) - plane.v) * kPerPixel;
    double y_power = 1.0;
    for (std::size_t j = 0; j < 5; ++j, y_power *= y) {
      for (std::size_t i = 0; i + j < 5; ++i) shape.position[i][j] += x_power[i] * y_power;
      for (std::size_t i = 0; i + j < 3; ++i) shape.offset[i][j] += off_x[i] * y_power;
    }
  }

  /// Planes end at edges. Where the surface goes on smoothly, without a jump and with a slight bend, it is a curved one.
  void look_around(int i, std::int16_t owner, bool first, bool last, RegionBuffers::Shape& shape) const {
    const auto look = [&](int j) {
      if (regions_.owner[at(j)] == owner) return;
      ++shape.border;
      if (grid_.usable[at(j)] != 0 && goes_on(i, j)) ++shape.smooth;
    };
    if (first) look(i - 1);
    if (last) look(i + 1);
    look(i - grid_.stride);
    look(i + grid_.stride);
  }

  [[nodiscard]] bool goes_on(int i, int j) const {
    const auto difference = [&](const AlignedVector<float>& values) { return values[at(j)] - values[at(i)]; };
    const auto mean = [&](const AlignedVector<float>& values) { return 0.5F * (values[at(j)] + values[at(i)]); };
    const float jump = difference(grid_.q) - mean(grid_.du) * difference(grid_.u) - mean(grid_.dv) * difference(grid_.v);
    const float shape = std::max(grid_.shape[at(i)], grid_.shape[at(j)]);
    const float q = mean(grid_.q);
    const float squared_q = q * q;
    const float squared_shape = shape * shape;
    if (jump * jump > jump_noise_ * squared_shape + jump_length_ * squared_q * squared_q) return false;
    // A plane's slope in depth over the image plane at z = 1 is its slope in q over q.
    const float x = static_cast<float>(camera_.fx) * difference(grid_.du);
    const float y = static_cast<float>(camera_.fy) * difference(grid_.dv);
    return x * x + y * y <= slight_bend_ * squared_q + bend_noise_ * squared_shape;
  }

  /// A surface of radius R bends q by 1 / (R f^2) per squared pixel, however far it is (docs/algorithms.md, "Curved surfaces").
  [[nodiscard]] bool is_curved(const Region& region, const RegionBuffers::Shape& shape) const {
    // Least squares of the distances in 1, x, y, x^2/2, xy, y^2/2.
    struct Term {
      std::size_t x, y;
      double factor;
    };
    constexpr std::array<Term, 6> kTerms{{{0, 0, 1.0}, {1, 0, 1.0}, {0, 1, 1.0}, {2, 0, 0.5}, {1, 1, 1.0}, {0, 2, 0.5}}};
    Eigen::Matrix<double, 6, 6> normal;
    Eigen::Matrix<double, 6, 1> right;
    for (std::size_t i = 0; i < 6; ++i) {
      const Term& a = kTerms[i];
      for (std::size_t j = 0; j < 6; ++j) {
        const Term& b = kTerms[j];
        normal(static_cast<int>(i), static_cast<int>(j)) = a.factor * b.factor * shape.position[a.x + b.x][a.y + b.y];
      }
      right[static_cast<int>(i)] = a.factor * shape.offset[a.x][a.y];
    }
    const Eigen::LDLT<Eigen::Matrix<double, 6, 6>> solver(normal);
    const Eigen::Matrix<double, 6, 1> solution = solver.solve(right);
    const double rest = std::max(0.0, shape.off - solution.dot(right)) / std::max(1, region.cells - 6);
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
    const double radius = 1.0 / (bend * camera_.fx * camera_.fy);
    // The wider a surface curves, the more of its sag may be the sensor's.
    const double wide = std::max(1.0, std::pow(radius / kC.curved_radius_m, kC.curved_wide));
    const double length = kC.curved_m * grid_.noise.bias_scale * f.q * f.q;
    return sag > wide * std::hypot(kC.curved_k * grid_.noise.cell, length);
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

  static float square(double x) { return static_cast<float>(x * x); }

  const Grid& grid_;
  const Camera& camera_;
  std::vector<RegionBuffers::Shape>& shapes_;
  Regions& regions_;
  float jump_noise_ = square(kC.jump_k * grid_.noise.cell);
  float jump_length_ = square(kC.jump_m);
  float slight_bend_ = square(kC.slight_bend);
  float bend_noise_ = square(kC.bend_k * grid_.noise.cell * camera_.fx / static_cast<double>(Grid::kHalfCell));
};

}  // namespace

void release_cells(Regions& regions) {
  for (std::int16_t& owner : regions.owner) {
    if (owner != kNobody && !regions.list[at(owner)].alive) owner = kNobody;
  }
}

void find_uniform(const Grid& grid, const AlignedVector<std::int16_t>& owner, UniformBuffers& buffers) {
  buffers.row.resize(grid.size());
  buffers.uniform.resize(grid.size());
  const auto stride = at(grid.stride);
  const std::int16_t* const __restrict o = owner.data();
  std::uint8_t* const __restrict row = buffers.row.data();
  const std::size_t size = grid.size();
  for (std::size_t i = 1; i < size - 1; ++i) {
    row[i] = static_cast<std::uint8_t>(static_cast<int>(o[i - 1] == o[i]) & static_cast<int>(o[i] == o[i + 1]));
  }
  std::uint8_t* const __restrict uniform = buffers.uniform.data();
  for (std::size_t i = stride + 1; i < size - stride - 1; ++i) {
    uniform[i] = static_cast<std::uint8_t>(row[i - stride] & row[i] & row[i + stride] & static_cast<int>(o[i - stride] == o[i]) &
                                           static_cast<int>(o[i] == o[i + stride]));
  }
}

void grow_regions(const Grid& grid, RegionBuffers& buffers, Regions& regions) {
  Grower grower(grid, buffers, regions);
  for (const SeedBlock& block : seed_blocks()) grower.run(block);
}

void judge_regions(const Grid& grid, const Camera& camera, RegionBuffers& buffers, Regions& regions) {
  Judge(grid, camera, buffers, regions).run();
}

}  // namespace fransac::cells
