// SPDX-License-Identifier: Apache-2.0
// Scalar truth of the kernels over sets of cells: as plain as can be, in double.
#include <algorithm>
#include <cmath>
#include <iterator>

#include "kernels/cell_sets.h"
#include "kernels/cells.h"

namespace fransac::kernels::ref {
namespace {

double offset(const CellArrays& cells, std::ptrdiff_t i, const CellSetPlane& plane) {
  const double u = static_cast<double>(cells.u[i]) - static_cast<double>(plane.u0);
  const double v = static_cast<double>(cells.v[i]) - static_cast<double>(plane.v0);
  return static_cast<double>(cells.q[i]) - static_cast<double>(plane.q0) - static_cast<double>(plane.du) * u -
         static_cast<double>(plane.dv) * v;
}

double difference(float a, float b) { return static_cast<double>(a) - static_cast<double>(b); }

/// Squared distances of a cell's mean, and of its slopes over half a cell.
struct Distance {
  double mean;
  double slope;
};
Distance distance(const CellArrays& cells, std::ptrdiff_t i, const CellSetPlane& plane) {
  const double off = offset(cells, i, plane);
  const double a = 0.5 * kCell * difference(cells.du[i], plane.du);
  const double b = 0.5 * kCell * difference(cells.dv[i], plane.dv);
  return {off * off, a * a + b * b};
}

bool has(const std::uint64_t* set, std::size_t i) { return (set[i / kWordBits] >> (i % kWordBits) & 1U) != 0; }

}  // namespace

void find_on_plane(const CellArrays& row, const float* slack, std::size_t cells, const CellSetPlane& plane, std::uint64_t* set) {
  std::fill_n(set, words_of(cells), std::uint64_t{0});
  for (std::size_t i = 0; i < cells; ++i) {
    const Distance far = distance(row, static_cast<std::ptrdiff_t>(i), plane);
    const auto most = static_cast<double>(slack[i]);
    if (far.mean <= most && far.slope <= most) set[i / kWordBits] |= std::uint64_t{1} << (i % kWordBits);
  }
}

void find_links(const CellArrays& row, const float* shape, std::size_t cells, std::ptrdiff_t step, const CellLinkLimits& limits,
                std::uint64_t* set) {
  std::fill_n(set, words_of(cells), std::uint64_t{0});
  const auto d = [](float value) { return static_cast<double>(value); };
  for (std::size_t k = 0; k < cells; ++k) {
    const auto i = static_cast<std::ptrdiff_t>(k);
    const std::ptrdiff_t j = i + step;
    const double jump = difference(row.q[j], row.q[i]) - 0.5 * ((d(row.du[i]) + d(row.du[j])) * difference(row.u[j], row.u[i]) +
                                                                (d(row.dv[i]) + d(row.dv[j])) * difference(row.v[j], row.v[i]));
    const double a = d(limits.slope_u) * difference(row.du[j], row.du[i]);
    const double b = d(limits.slope_v) * difference(row.dv[j], row.dv[i]);
    const double noise = d(std::max(shape[i], shape[j]));
    const double q = 0.5 * (d(row.q[i]) + d(row.q[j]));
    const double squared = q * q;
    const bool level = jump * jump <= d(limits.jump_noise) * noise * noise + d(limits.jump_m) * squared * squared;
    const bool straight = a * a + b * b <= d(limits.bend_noise) * noise * noise + d(limits.bend_m) * squared * squared +
                                               d(limits.bend_rad) * squared;
    if (level && straight) set[k / kWordBits] |= std::uint64_t{1} << (k % kWordBits);
  }
}

CellSetSums sum_cells(const CellArrays& first, const std::uint64_t* set, std::size_t rows, std::size_t words,
                      const CellSetPlane& plane) {
  double n = 0.0, u = 0.0, v = 0.0, r = 0.0, uu = 0.0, uv = 0.0, vv = 0.0, ur = 0.0, vr = 0.0, rr = 0.0;
  std::int32_t cells = 0;
  for (std::size_t row = 0; row < rows; ++row) {
    for (std::size_t column = 0; column < words * kWordBits; ++column) {
      if (!has(set + row * words, column)) continue;
      ++cells;
      const std::ptrdiff_t i = static_cast<std::ptrdiff_t>(row) * first.stride + static_cast<std::ptrdiff_t>(column);
      const auto count = static_cast<double>(first.n[i]);
      const double x = difference(first.u[i], plane.u0);
      const double y = difference(first.v[i], plane.v0);
      const double off = offset(first, i, plane);
      const double a = difference(first.du[i], plane.du);
      const double b = difference(first.dv[i], plane.dv);
      const double xx = static_cast<double>(first.uu[i]);
      const double xy = static_cast<double>(first.uv[i]);
      const double yy = static_cast<double>(first.vv[i]);
      const double xr = xx * a + xy * b;
      const double yr = xy * a + yy * b;
      n += count;
      u += count * x;
      v += count * y;
      r += count * off;
      uu += count * (xx + x * x);
      uv += count * (xy + x * y);
      vv += count * (yy + y * y);
      ur += count * (xr + x * off);
      vr += count * (yr + y * off);
      rr += count * (static_cast<double>(first.residual[i]) + a * xr + b * yr + off * off);
    }
  }
  const auto f = [](double value) { return static_cast<float>(value); };
  return {f(n), f(u), f(v), f(r), f(uu), f(uv), f(vv), f(ur), f(vr), f(rr), cells};
}

CellSetShape sum_shape(const CellArrays& first, const std::uint64_t* set, std::size_t rows, std::size_t words,
                       const CellSetPlane& plane) {
  double position[CellSetShape::kPositions] = {};
  double offsets[CellSetShape::kOffsets] = {};
  double off = 0.0;
  double slope = 0.0;
  for (std::size_t row = 0; row < rows; ++row) {
    for (std::size_t column = 0; column < words * kWordBits; ++column) {
      if (!has(set + row * words, column)) continue;
      const std::ptrdiff_t i = static_cast<std::ptrdiff_t>(row) * first.stride + static_cast<std::ptrdiff_t>(column);
      const double x = difference(first.u[i], plane.u0) / kCell;
      const double y = difference(first.v[i], plane.v0) / kCell;
      const double r = offset(first, i, plane);
      int p = 0;
      int o = 0;
      for (int b = 0; b <= 4; ++b) {
        for (int a = 0; a + b <= 4; ++a) {
          position[p++] += std::pow(x, a) * std::pow(y, b);
          if (a + b <= 2) offsets[o++] += r * std::pow(x, a) * std::pow(y, b);
        }
      }
      const Distance far = distance(first, i, plane);
      off += far.mean;
      slope += far.slope;
    }
  }
  CellSetShape shape{};
  std::transform(std::begin(position), std::end(position), shape.position,
                 [](double value) { return static_cast<float>(value); });
  std::transform(std::begin(offsets), std::end(offsets), shape.offset, [](double value) { return static_cast<float>(value); });
  shape.off = static_cast<float>(off);
  shape.slope = static_cast<float>(slope);
  return shape;
}

CellSetErrors sum_errors(const CellArrays& first, const float* sigma, const std::uint64_t* set, std::size_t rows,
                         std::size_t words) {
  double variance = 0.0;
  double q4 = 0.0;
  for (std::size_t row = 0; row < rows; ++row) {
    for (std::size_t column = 0; column < words * kWordBits; ++column) {
      if (!has(set + row * words, column)) continue;
      const std::ptrdiff_t i = static_cast<std::ptrdiff_t>(row) * first.stride + static_cast<std::ptrdiff_t>(column);
      variance += std::pow(static_cast<double>(sigma[i]), 2);
      q4 += std::pow(static_cast<double>(first.q[i]), 4);
    }
  }
  return {static_cast<float>(variance), static_cast<float>(q4)};
}

void find_nearest(const CellArrays& row, const float* slack, std::size_t cells, const CellSetPlane& plane,
                  const std::uint64_t* set, std::int32_t id, float* least, std::int32_t* nearest) {
  for (std::size_t i = 0; i < cells; ++i) {
    if (!has(set, i)) continue;
    const Distance far = distance(row, static_cast<std::ptrdiff_t>(i), plane);
    const auto most = static_cast<double>(slack[i]);
    if (far.mean > most || far.slope > most || far.mean + far.slope >= static_cast<double>(least[i])) continue;
    least[i] = static_cast<float>(far.mean + far.slope);
    nearest[i] = id;
  }
}

void measure_differences(const float* n, const float* values, const float* shape, std::size_t cells, std::ptrdiff_t step,
                         float least, float* out) {
  for (std::size_t k = 0; k < cells; ++k) {
    const auto i = static_cast<std::ptrdiff_t>(k);
    const double mean = 0.5 * (static_cast<double>(values[i - step]) + static_cast<double>(values[i + step]));
    const bool full = std::min(n[i], std::min(n[i - step], n[i + step])) >= least;
    out[k] = full ? static_cast<float>(std::abs(static_cast<double>(values[i]) - mean) / static_cast<double>(shape[i])) : kNone;
  }
}

std::size_t count_less(const float* values, std::size_t count, float limit) {
  return static_cast<std::size_t>(std::count_if(values, values + count, [=](float value) { return value < limit; }));
}

void measure_blocks(const CellArrays& row, const float* weight, const float* shape, std::size_t cells, const CellBlock& block,
                    float most_noise, float most_m, float* flatness) {
  constexpr double kSize = kCell;
  constexpr double kSpread = (kSize * kSize - 1.0) / 12.0;  // mean square of a cell's columns about their mean
  for (std::size_t i = 0; i < cells; ++i) {
    double n = 0.0, u = 0.0, v = 0.0, r = 0.0, uu = 0.0, uv = 0.0, vv = 0.0, ur = 0.0, vr = 0.0, rr = 0.0;
    for (int y = -block.up; y < block.rows - block.up; ++y) {
      for (int x = -block.left; x < block.columns - block.left; ++x) {
        const std::ptrdiff_t j = static_cast<std::ptrdiff_t>(i) + y * row.stride + x;
        if (weight[j] == 0.0F) continue;
        // About the plane of the cell itself.
        const double up = kSize * x;
        const double vp = kSize * y;
        const double off =
            difference(row.q[j], row.q[i]) - static_cast<double>(row.du[i]) * up - static_cast<double>(row.dv[i]) * vp;
        const double a = difference(row.du[j], row.du[i]);
        const double b = difference(row.dv[j], row.dv[i]);
        n += 1.0;
        u += up;
        v += vp;
        r += off;
        uu += kSpread + up * up;
        uv += up * vp;
        vv += kSpread + vp * vp;
        ur += kSpread * a + up * off;
        vr += kSpread * b + vp * off;
        rr += static_cast<double>(row.residual[j]) + kSpread * (a * a + b * b) + off * off;
      }
    }
    flatness[i] = kNotFlat;
    if (weight[i] == 0.0F || n < block.least) continue;
    uu -= u * u / n;
    uv -= u * v / n;
    vv -= v * v / n;
    ur -= u * r / n;
    vr -= v * r / n;
    rr -= r * r / n;
    const double explained = (vv * ur * ur - 2.0 * uv * ur * vr + uu * vr * vr) / (uu * vv - uv * uv);
    const double residual = std::max(0.0, rr - explained) / n;
    const double squared_shape = static_cast<double>(shape[i]) * static_cast<double>(shape[i]);
    const double most = static_cast<double>(most_noise) * squared_shape +
                        static_cast<double>(most_m) * std::pow(static_cast<double>(row.q[i]), 4);
    if (residual <= most) flatness[i] = static_cast<float>(residual / squared_shape);
  }
}

PixelSums sum_pixels(const std::uint8_t* count, const float* q, std::size_t cells, float on_plane, float du, float least) {
  double n = 0.0, z = 0.0, zu = 0.0, zzz = 0.0;
  for (std::size_t i = 0; i < cells; ++i) {
    const double u = static_cast<double>(i) * kCell;
    const double expected = static_cast<double>(on_plane) + static_cast<double>(du) * u;
    const auto own = static_cast<double>(q[i]);
    const double depth =
        1.0 / std::max(expected < static_cast<double>(kHorizon) * own ? own : expected, static_cast<double>(least));
    const auto pixels = static_cast<double>(count[i]);
    n += pixels;
    z += pixels * depth;
    zu += pixels * depth * u;
    zzz += pixels * depth * depth * depth;
  }
  return {static_cast<float>(n), static_cast<float>(z), static_cast<float>(zu), static_cast<float>(zzz)};
}

}  // namespace fransac::kernels::ref
