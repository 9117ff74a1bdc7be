// SPDX-License-Identifier: Apache-2.0
#include "planes/cells/judge.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <bit>
#include <cmath>

#include "planes/cells/constants.hpp"
#include "planes/cells/spread.hpp"

namespace fransac::cells {
namespace {

constexpr const Constants& kC = kConstants;
constexpr double kPerSample = 1.0 / kernels::kCell;

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

}  // namespace

/// A surface of radius R bends q by 1 / (R f^2) per squared sample, however far it is (docs/algorithms.md, "Curved surfaces").
Judge::Turn Judge::turn(const Region& region, const kernels::CellSetShape& shape) const {
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
  const double cells = normal(0, 0);
  // A strip two cells wide says nothing of how it bends across: before looking, a bend is anything up to that of a surface too
  // round for a cell to be flat.
  constexpr double kRoundest_m = 0.05;
  const Camera& camera = grid_.camera;
  const double before = 1.0 / (kRoundest_m * camera.fx * camera.fy * kPerSample * kPerSample);
  const double least_variance = std::pow(0.5 * grid_.noise.cell * region.sigma(), 2);
  for (int i = 3; i < 6; ++i) normal(i, i) += least_variance / (before * before);
  const Eigen::LDLT<Eigen::Matrix<double, 6, 6>> solver(normal);
  const Eigen::Matrix<double, 6, 1> solution = solver.solve(right);
  const double rest = std::max(0.0, static_cast<double>(shape.off) - solution.dot(right)) / std::max(1.0, cells - 6.0);
  const double variance = std::max(rest, least_variance);
  const Bend most = strongest_bend(solution[3], solution[4], solution[5]);
  const Eigen::Vector2d& e = most.direction;
  Eigen::Matrix<double, 6, 1> direction;
  direction << 0.0, 0.0, 0.0, e[0] * e[0], 2.0 * e[0] * e[1], e[1] * e[1];
  const double sigma = std::sqrt(std::max(0.0, variance * direction.dot(solver.solve(direction))));
  // A strip of uniform density has twelve times its variance as squared length.
  const double x = normal(0, 1) / cells;
  const double y = normal(0, 2) / cells;
  const double xx = static_cast<double>(shape.position[place(2, 0, 4)]) / cells - x * x + 1.0 / 12.0;
  const double xy = static_cast<double>(shape.position[place(1, 1, 4)]) / cells - x * y;
  const double yy = static_cast<double>(shape.position[place(0, 2, 4)]) / cells - y * y + 1.0 / 12.0;
  const double length = std::sqrt(12.0 * (e[0] * e[0] * xx + 2.0 * e[0] * e[1] * xy + e[1] * e[1] * yy));
  // Curvature per squared metre times metres: lengths on the surface are samples over f q.
  const double to_rad = kPerSample * length * std::sqrt(camera.fx * camera.fy) / region.fit.q;
  return {std::abs(most.curvature) * to_rad, sigma * to_rad};
}

/// How improbable it is that cells of unrelated surfaces agree this well, in nats (docs/algorithms.md, "Evidence").
double Judge::evidence(const Region& region, const kernels::CellSetShape& shape) const {
  constexpr double kSteepest = 1.73;  // surfaces are seen up to 60 degrees from the front
  const double prior = static_cast<double>(Grid::kHalfCell) * kSteepest * region.fit.q / grid_.camera.fx;
  const double least = 0.5 * grid_.noise.cell * region.sigma();
  const double slope = std::max(std::sqrt(static_cast<double>(shape.slope) / (2.0 * region.cells)), least);
  const double off = std::max(std::sqrt(static_cast<double>(shape.off) / region.cells), least);
  return (region.cells - 1) * (2.0 * std::max(0.0, std::log(prior / slope)) + std::max(0.0, std::log(2.0 * prior / off)));
}

double Judge::smooth_border(const CellSet& set) const {
  int measured = 0;
  int smooth = 0;
  const auto count = [&](std::uint64_t sides, std::uint64_t links) {
    measured += std::popcount(sides);
    smooth += std::popcount(sides & links);
  };
  constexpr int kLast = kernels::kWordBits - 1;
  const std::size_t words = grid_.words;
  for (int r = set.top; r <= set.bottom; ++r) {
    const std::uint64_t* const row = set.bits + at(r - set.top) * words;
    const std::size_t first = at(r) * words;
    const std::uint64_t* const known = &grid_.measured_set[first];
    const std::uint64_t* const right = &grid_.smooth.right[first];
    for (std::size_t w = 0; w < words; ++w) {
      if (row[w] == 0) continue;
      // Bit c of `before` says something of column c - 1, of `after` of column c + 1.
      const auto before = [&](const std::uint64_t* bits) { return bits[w] << 1 | (w > 0 ? bits[w - 1] >> kLast : 0); };
      const auto after = [&](const std::uint64_t* bits) { return bits[w] >> 1 | (w + 1 < words ? bits[w + 1] << kLast : 0); };
      count(row[w] & ~before(row) & before(known), before(right));
      count(row[w] & ~after(row) & after(known), right[w]);
      if (r > 0) {
        const std::uint64_t above = r > set.top ? (row - words)[w] : 0;
        count(row[w] & ~above & (known - words)[w], grid_.smooth.down[first - words + w]);
      }
      if (r + 1 < grid_.rows) {
        const std::uint64_t below = r < set.bottom ? (row + words)[w] : 0;
        count(row[w] & ~below & (known + words)[w], grid_.smooth.down[first + w]);
      }
    }
  }
  return measured > 0 ? static_cast<double>(smooth) / measured : 0.0;
}

CellSet Judge::erode(const CellSet& set) const {
  const std::size_t words = grid_.words;
  b_.eroded.resize(at(grid_.rows) * words);  // of any set, so that it is not made larger set by set
  std::fill_n(b_.eroded.begin(), set.rows() * words, std::uint64_t{0});
  constexpr int kLast = kernels::kWordBits - 1;
  for (std::size_t r = 1; r + 1 < set.rows(); ++r) {
    const std::uint64_t* const row = set.bits + r * words;
    for (std::size_t w = 0; w < words; ++w) {
      const std::uint64_t before = w > 0 ? row[w - 1] >> kLast : 0;
      const std::uint64_t after = w + 1 < words ? row[w + 1] << kLast : 0;
      b_.eroded[r * words + w] = row[w] & (row[w] << 1 | before) & (row[w] >> 1 | after) & (row + words)[w] & (row - words)[w];
    }
  }
  return {b_.eroded.data(), set.top, set.bottom};
}

kernels::CellSetShape Judge::shape(const Region& region, const CellSet& set) const {
  return kernels::sum_shape(grid_.arrays(grid_.index(set.top, 0)), set.bits, set.rows(), grid_.words,
                            about(region.fit.plane, region.fit.u, region.fit.v));
}

Judge::Turn Judge::core_turn(const Region& region, const CellSet& set, const Turn& whole) const {
  constexpr float kEnough = 9.0F;  // cells
  const kernels::CellSetShape core = shape(region, erode(set));
  return core.position[0] >= kEnough ? turn(region, core) : whole;
}

bool Judge::may_be_plane(const Region& region, const CellSet& set) const {
  const kernels::CellSetShape all = shape(region, set);
  if (evidence(region, all) < kC.least_evidence) return false;
  constexpr double kSigmas = 2.0;
  const auto is_straight = [](const Turn& t) { return t.rad - kSigmas * t.sigma <= kC.most_turn; };
  const Turn whole = turn(region, all);
  return is_straight(whole) || is_straight(core_turn(region, set, whole));
}

PlaneEvidence Judge::look(const Region& region, const CellSet& set, double measured) const {
  const Turn whole = turn(region, shape(region, set));
  return {.share = region.moments.n / std::max(measured, 1.0),
          .turn_rad = std::min(whole.rad, core_turn(region, set, whole).rad),
          .turn_sigma_rad = whole.sigma,
          .smooth_border = smooth_border(set)};
}

double Judge::confidence(const PlaneEvidence& e) {
  const double x = kConfidence.bias + kConfidence.share * std::log(std::max(e.share, 1e-6)) +
                   kConfidence.turn * std::log(e.turn_rad + 0.03) +
                   kConfidence.turn_sigma * std::log(std::max(e.turn_sigma_rad, 0.005)) + kConfidence.smooth * e.smooth_border;
  return 1.0 / (1.0 + std::exp(-x));
}

}  // namespace fransac::cells
