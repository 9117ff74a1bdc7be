// SPDX-License-Identifier: Apache-2.0
#include "planes/cells/spread.hpp"

#include <algorithm>
#include <bit>

namespace fransac::cells {
namespace {

constexpr std::uint64_t kOne = 1;

}  // namespace

kernels::CellSetPlane about(const InversePlane& plane, double u, double v) {
  return {static_cast<float>(u), static_cast<float>(v), static_cast<float>(plane.at(u, v)), static_cast<float>(plane.du),
          static_cast<float>(plane.dv)};
}

Moments moments_of(const kernels::CellSetSums& sums, const kernels::CellSetPlane& plane) {
  const auto d = [](float value) { return static_cast<double>(value); };
  const double n = d(sums.n), u0 = d(plane.u0), v0 = d(plane.v0);
  const double du = d(plane.du), dv = d(plane.dv);
  // From the plane's point and residuals to the image's centre and inverse depth: u = u0 + x, v = v0 + y, q = p + r.
  const double x = d(sums.u), y = d(sums.v), xx = d(sums.uu), xy = d(sums.uv), yy = d(sums.vv);
  const double r = d(sums.r), xr = d(sums.ur), yr = d(sums.vr), q0 = d(plane.q0);
  const double p = n * q0 + du * x + dv * y;
  const double xp = q0 * x + du * xx + dv * xy;
  const double yp = q0 * y + du * xy + dv * yy;
  const double pp = q0 * p + du * xp + dv * yp;
  const double pr = q0 * r + du * xr + dv * yr;
  const double q = p + r;
  return {.n = n,
          .u = x + n * u0,
          .v = y + n * v0,
          .q = q,
          .uu = xx + 2.0 * u0 * x + n * u0 * u0,
          .uv = xy + u0 * y + v0 * x + n * u0 * v0,
          .vv = yy + 2.0 * v0 * y + n * v0 * v0,
          .uq = xp + xr + u0 * q,
          .vq = yp + yr + v0 * q,
          .qq = pp + 2.0 * pr + d(sums.rr)};
}

Spread::Spread(const Grid& grid, SpreadBuffers& buffers) : grid_(grid), b_(buffers), words_(grid.words) {
  const std::size_t size = at(grid.rows) * words_;
  b_.free.assign(grid.usable_set.begin(), grid.usable_set.end());
  b_.on.resize(size);
  b_.reached.assign(size, 0);
  b_.known.resize(at(grid.rows));
}

Spread::Window Spread::window(int row, int column, int reach) const {
  return {std::max(row - reach, 0), std::min(row + reach, grid_.rows - 1), std::max(column - reach, 0),
          std::min(column + reach, grid_.columns - 1)};
}

void Spread::clear() {
  if (bottom_ < top_) return;
  std::fill(b_.reached.begin() + static_cast<std::ptrdiff_t>(word(top_)),
            b_.reached.begin() + static_cast<std::ptrdiff_t>(word(bottom_ + 1)), 0);
  bottom_ = top_ - 1;
}

void Spread::take(const Window& window) {
  clear();
  top_ = window.top;
  bottom_ = window.bottom;
  for (int r = top_; r <= bottom_; ++r) {
    for (std::size_t w = 0; w < words_; ++w) b_.reached[word(r) + w] = free_in(window, r, w);
  }
}

int Spread::free_cells(const Window& window) const {
  int count = 0;
  for (int r = window.top; r <= window.bottom; ++r) {
    for (std::size_t w = at(window.left / kernels::kWordBits); w <= at(window.right / kernels::kWordBits); ++w) {
      for (std::uint64_t bits = free_in(window, r, w); bits != 0; bits &= bits - 1) ++count;
    }
  }
  return count;
}

/// Which free cells of a row in the window are on the plane.
void Spread::make_row(int row, const kernels::CellSetPlane& plane, const Window& window) {
  if (b_.known[at(row)] != 0) return;
  b_.known[at(row)] = 1;
  std::uint64_t* const on = &b_.on[word(row)];
  // Whole words, so that a narrow window costs little.
  const int first = window.left / kernels::kWordBits;
  const int begin = first * kernels::kWordBits;
  const int i = grid_.index(row, begin);
  kernels::find_on_plane(grid_.arrays(i), grid_.slack.data() + i, at(window.right + 1 - begin), plane, on + first);
  for (std::size_t w = 0; w < words_; ++w) on[w] &= free_in(window, row, w);
}

/// Along a row, over the links, as far as the cells are on the plane. Doubling steps: after the first a bit has gone one cell,
/// then three, seven, ...
void Spread::fill_row(int row) {
  std::uint64_t* const reached = &b_.reached[word(row)];
  const std::uint64_t* const on = &b_.on[word(row)];
  const std::uint64_t* const links = &grid_.links.right[word(row)];
  std::uint64_t last = 0;  // whether the word before goes on into this one
  for (std::size_t w = 0; w < words_; ++w) {
    std::uint64_t bits = reached[w] | (last & on[w]);
    last = 0;
    if (bits == 0) continue;
    std::uint64_t open = on[w] & (links[w] << 1);
    for (int step = 1; step < kernels::kWordBits; step *= 2) {
      bits |= open & (bits << step);
      open &= open << step;
    }
    reached[w] = bits;
    last = (bits & links[w]) >> (kernels::kWordBits - 1);
  }
  last = 0;
  for (std::size_t w = words_; w-- > 0;) {
    std::uint64_t bits = reached[w] | (last & on[w] & links[w]);
    last = 0;
    if (bits == 0) continue;
    std::uint64_t open = on[w] & links[w];
    for (int step = 1; step < kernels::kWordBits; step *= 2) {
      bits |= open & (bits >> step);
      open &= open >> step;
    }
    reached[w] = bits;
    last = bits << (kernels::kWordBits - 1);
  }
}

void Spread::run(int row, int column, const kernels::CellSetPlane& plane, const Window& window) {
  clear();
  std::fill(b_.known.begin(), b_.known.end(), std::uint8_t{0});
  make_row(row, plane, window);
  const std::uint64_t start = kOne << (column % kernels::kWordBits);
  const std::size_t start_word = word(row) + at(column / kernels::kWordBits);
  if ((b_.on[start_word] & start) == 0) return;
  b_.reached[start_word] = start;
  top_ = bottom_ = row;
  fill_row(row);
  // From the row `from` into `to`, over the links of the upper one.
  const auto enter = [&](int to, int from) {
    const std::uint64_t* const links = &grid_.links.down[word(std::min(from, to))];
    bool any = false;
    for (std::size_t w = 0; w < words_; ++w) {
      any |= (b_.reached[word(from) + w] & links[w] & b_.free[word(to) + w] & ~b_.reached[word(to) + w]) != 0;
    }
    if (!any) return false;
    make_row(to, plane, window);
    any = false;
    for (std::size_t w = 0; w < words_; ++w) {
      const std::uint64_t entered = b_.reached[word(from) + w] & links[w] & b_.on[word(to) + w] & ~b_.reached[word(to) + w];
      b_.reached[word(to) + w] |= entered;
      any |= entered != 0;
    }
    if (any) fill_row(to);
    return any;
  };
  // A way down leaves nothing more to go down to, unless the way up after it finds something.
  for (bool changed = true; changed;) {
    changed = false;
    for (int r = top_ + 1; r <= std::min(bottom_ + 1, window.bottom); ++r) {
      if (enter(r, r - 1)) bottom_ = std::max(bottom_, r);
    }
    for (int r = bottom_ - 1; r >= std::max(top_ - 1, window.top); --r) {
      if (!enter(r, r + 1)) continue;
      changed = true;
      top_ = std::min(top_, r);
    }
  }
}

bool Spread::touches(const Window& window) const {
  if (bottom_ < top_) return false;
  if ((top_ == window.top && top_ > 0) || (bottom_ == window.bottom && bottom_ < grid_.rows - 1)) return true;
  const auto any_at = [&](int column) {
    const std::uint64_t bit = kOne << (column % kernels::kWordBits);
    for (int r = top_; r <= bottom_; ++r) {
      if ((b_.reached[word(r) + at(column / kernels::kWordBits)] & bit) != 0) return true;
    }
    return false;
  };
  return (window.left > 0 && any_at(window.left)) || (window.right < grid_.columns - 1 && any_at(window.right));
}

kernels::CellSetSums Spread::sums(const kernels::CellSetPlane& about) const {
  if (bottom_ < top_) return {};
  return kernels::sum_cells(grid_.arrays(grid_.index(top_, 0)), &b_.reached[word(top_)], at(rows()), words_, about);
}

void Spread::claim() {
  for (std::size_t i = word(top_); i < word(bottom_ + 1); ++i) b_.free[i] &= ~b_.reached[i];
}

}  // namespace fransac::cells
