// SPDX-License-Identifier: Apache-2.0
/// The sums over a set of cells, one cell after the other, with the roundings of floats.
#pragma once

#include <gtest/gtest.h>

#include <cstddef>
#include <utility>
#include <vector>

#include "kernels/cell_sets.h"
#include "rounded.hpp"

namespace fransac::testing {

/// Where a cell is from a plane: its place, the distance of its mean, the differences of its slopes. What is stored of it was
/// rounded so many times.
struct CellOffset {
  CellOffset(const kernels::CellArrays& cells, std::ptrdiff_t i, const kernels::CellSetPlane& plane, double roundings = 0.0)
      : x(Rounded(cells.u[i], roundings) - plane.u0),
        y(Rounded(cells.v[i], roundings) - plane.v0),
        r(Rounded(cells.q[i], roundings) - plane.q0 - Rounded(plane.du) * x - Rounded(plane.dv) * y),
        a(Rounded(cells.du[i], roundings) - plane.du),
        b(Rounded(cells.dv[i], roundings) - plane.dv) {}
  Rounded x, y, r, a, b;
};

/// In the order of kernels::CellSetSums: 1, u, v, r, uu, uv, vv, ur, vr, rr.
constexpr std::size_t kCellSums = 10;

inline std::vector<Rounded> sums_of(const kernels::CellArrays& cells, const std::vector<std::ptrdiff_t>& set,
                                    const kernels::CellSetPlane& plane, double roundings = 0.0) {
  std::vector<std::vector<Rounded>> terms(kCellSums);
  for (const std::ptrdiff_t i : set) {
    const auto [x, y, r, a, b] = CellOffset(cells, i, plane, roundings);
    const Rounded n = cells.n[i];
    const Rounded xx(cells.uu[i], roundings), xy(cells.uv[i], roundings), yy(cells.vv[i], roundings);
    // A pixel's residual is the cell's, and that of the cell's plane, whose slopes are off by (a, b).
    const Rounded xr = xx * a + xy * b;
    const Rounded yr = xy * a + yy * b;
    const Rounded rr = Rounded(cells.residual[i], roundings) + b * yr + a * xr;
    const Rounded products[kCellSums] = {n,
                                         n * x,
                                         n * y,
                                         n * r,
                                         n * (xx + x * x),
                                         n * (xy + x * y),
                                         n * (yy + y * y),
                                         n * (xr + x * r),
                                         n * (yr + y * r),
                                         n * (rr + r * r)};
    for (std::size_t k = 0; k < kCellSums; ++k) terms[k].push_back(products[k]);
  }
  std::vector<Rounded> sums;
  for (const auto& of_one : terms) sums.push_back(sum(of_one));
  return sums;
}

inline std::vector<float> values_of(const kernels::CellSetSums& s) {
  return {s.n, s.u, s.v, s.r, s.uu, s.uv, s.vv, s.ur, s.vr, s.rr};
}

/// All values may be what is expected of them.
inline ::testing::AssertionResult agree(const std::vector<float>& got, const std::vector<Rounded>& expected) {
  if (got.size() != expected.size()) return ::testing::AssertionFailure() << got.size() << " values, not " << expected.size();
  for (std::size_t k = 0; k < got.size(); ++k) {
    if (!expected[k].may_be(got[k]))
      return ::testing::AssertionFailure() << "value " << k << ": " << got[k] << ", not " << expected[k];
  }
  return ::testing::AssertionSuccess();
}

}  // namespace fransac::testing
