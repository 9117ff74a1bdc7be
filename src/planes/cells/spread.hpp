// SPDX-License-Identifier: Apache-2.0
/// Sets of connected cells on one plane, a row of cells as a few words of bits.
#pragma once

#include <algorithm>
#include <bit>
#include <cstdint>
#include <vector>

#include "fransac/core/aligned.hpp"
#include "planes/cells/grid.hpp"

namespace fransac::cells {

/// The reference that a set's moments are summed about: near the set, so that floats are enough.
kernels::CellSetPlane about(const InversePlane& plane, double u, double v);

/// Moments from sums about a plane.
Moments moments_of(const kernels::CellSetSums& sums, const kernels::CellSetPlane& plane);

/// The bits [first, last] of a word whose first bit is `begin`.
inline std::uint64_t bits_between(int first, int last, int begin) {
  const int from = std::max(first - begin, 0);
  const int to = std::min(last - begin, kernels::kWordBits - 1);
  if (from > to) return 0;
  return (~std::uint64_t{0} >> (kernels::kWordBits - 1 - to)) & (~std::uint64_t{0} << from);
}

/// A set of cells: a bit each, rows of Grid::words words, from row `top` to row `bottom`.
struct CellSet {
  const std::uint64_t* bits;  ///< Of row `top`.
  int top;
  int bottom;

  [[nodiscard]] std::size_t rows() const { return at(bottom - top + 1); }
};

/// Memory of Spread.
struct SpreadBuffers {
  std::vector<std::uint64_t> free;     ///< Usable cells of no region.
  std::vector<std::uint64_t> on;       ///< Free cells on the plane; rows are made when they are first entered.
  std::vector<std::uint64_t> reached;  ///< All zero outside the rows of the last set.
  std::vector<std::uint8_t> known;     ///< Rows of `on` that are made.
};

/// Spreads from a cell over links to free cells on a plane.
class Spread {
 public:
  Spread(const Grid& grid, SpreadBuffers& buffers);

  /// Cells of rows [top, bottom] and columns [left, right].
  struct Window {
    int top;
    int bottom;
    int left;
    int right;
  };
  /// The cells at most `reach` rows and columns away.
  [[nodiscard]] Window window(int row, int column, int reach) const;

  /// Makes the set. Nothing, when the cell is not on the plane itself.
  void run(int row, int column, const kernels::CellSetPlane& plane, const Window& window);
  /// Makes the set the free cells of a window, linked or not.
  void take(const Window& window);

  [[nodiscard]] int free_cells(const Window& window) const;
  /// How many cells are in the set, and their moments.
  [[nodiscard]] kernels::CellSetSums sums(const kernels::CellSetPlane& about) const;
  /// Whether the set goes up to an edge of the window that is not the image's.
  [[nodiscard]] bool touches(const Window& window) const;
  /// The set itself, until the next one is made.
  [[nodiscard]] CellSet set() const { return {&b_.reached[word(top_)], top_, bottom_}; }
  /// Calls visit(cell) for each cell, row by row.
  template <class Visitor>
  void for_each(Visitor visit) const;
  /// Its cells are free no more.
  void claim();
  [[nodiscard]] bool is_free(int row, int column) const {
    return (b_.free[word(row) + at(column / kernels::kWordBits)] >> (column % kernels::kWordBits) & 1U) != 0;
  }

 private:
  [[nodiscard]] std::size_t word(int row) const { return at(row) * words_; }
  [[nodiscard]] int rows() const { return bottom_ - top_ + 1; }
  /// The free cells of a row that are in the window.
  [[nodiscard]] std::uint64_t free_in(const Window& window, int row, std::size_t w) const {
    return b_.free[word(row) + w] & bits_between(window.left, window.right, static_cast<int>(w) * kernels::kWordBits);
  }
  void clear();
  void make_row(int row, const kernels::CellSetPlane& plane, const Window& window);
  void fill_row(int row);

  const Grid& grid_;
  SpreadBuffers& b_;
  std::size_t words_;
  int top_ = 0;  ///< Rows of the set.
  int bottom_ = -1;
};

template <class Visitor>
void Spread::for_each(Visitor visit) const {
  for (int r = top_; r <= bottom_; ++r) {
    for (std::size_t w = 0; w < words_; ++w) {
      for (std::uint64_t bits = b_.reached[word(r) + w]; bits != 0; bits &= bits - 1) {
        visit(grid_.index(r, static_cast<int>(w) * kernels::kWordBits + std::countr_zero(bits)));
      }
    }
  }
}

}  // namespace fransac::cells
