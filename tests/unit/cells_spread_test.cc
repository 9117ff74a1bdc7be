// SPDX-License-Identifier: Apache-2.0
// Spreading over sets of bits against a plain search, cell by cell, on random grids.
#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "kernels/cell_sums.hpp"
#include "planes/cells/spread.hpp"
#include "property/property.hpp"

namespace fransac::cells {
namespace {

using Window = Spread::Window;

/// A grid whose cells are on a plane or far from it, with random links; some cells are unusable.
class World {
 public:
  World(int num_rows, int num_columns, RandomStream& random) {
    grid.rows = num_rows;
    grid.columns = num_columns;
    grid.stride = num_columns + 2;
    grid.width = num_columns * kernels::kCell;
    grid.height = num_rows * kernels::kCell;
    grid.words = kernels::words_of(at(num_columns));
    const std::size_t size = grid.size() + Grid::kPadding;
    for (auto* values : {&grid.n, &grid.u, &grid.v, &grid.q, &grid.uu, &grid.uv, &grid.vv, &grid.du, &grid.dv, &grid.residual,
                         &grid.sigma, &grid.slack}) {
      values->assign(size, 0.0F);
    }
    grid.usable.assign(grid.size(), 0);
    const std::size_t words = at(num_rows) * grid.words;
    for (auto* set : {&grid.usable_set, &grid.links.right, &grid.links.down, &grid.smooth.right, &grid.smooth.down}) {
      set->assign(words, 0);
    }
    free.assign(grid.size(), false);
    // Of ten.
    const std::uint32_t usable = 8 + random.below(3);
    const std::uint32_t on_plane = 8 + random.below(3);
    for (int r = 0; r < num_rows; ++r) {
      for (int c = 0; c < num_columns; ++c) draw_cell(r, c, random.below(10) < usable, random.below(10) < on_plane, random);
    }
    draw_links(grid.links, 6 + random.below(5), random);
    draw_links(grid.smooth, random.below(11), random);
  }

  static bool has(const Grid& grid, const std::vector<std::uint64_t>& set, int row, int column) {
    return (set[at(row) * grid.words + at(column / kernels::kWordBits)] >> (column % kernels::kWordBits) & 1U) != 0;
  }
  [[nodiscard]] bool is_linked(const Grid::Links& links, int row, int column, int direction) const {
    const int up = direction == 3 ? 1 : 0;
    const int left = direction == 2 ? 1 : 0;
    if (row - up < 0 || column - left < 0) return false;
    return has(grid, direction % 2 == 0 ? links.right : links.down, row - up, column - left);
  }

  Grid grid;
  std::vector<bool> free;  ///< By index.
  std::vector<bool> on;
  InversePlane plane{.du = 1e-4, .dv = -2e-4, .base = 0.6};

 private:
  void draw_cell(int r, int c, bool usable, bool on_plane, RandomStream& random) {
    constexpr double kNear = 0.01;
    const std::size_t i = at(grid.index(r, c));
    const double u = kernels::kCell * (c + 0.5) - 0.5 * grid.width;
    const double v = kernels::kCell * (r + 0.5) - 0.5 * grid.height;
    const auto noise = [&](double size) { return static_cast<float>(testing::uniform(random, -size, size)); };
    grid.n[i] = static_cast<float>(1 + random.below(64));
    grid.u[i] = static_cast<float>(u) + noise(0.5);
    grid.v[i] = static_cast<float>(v) + noise(0.5);
    grid.q[i] = static_cast<float>(plane.at(u, v) + (on_plane ? 0.0 : 0.5)) + noise(0.5 * kNear);
    grid.uu[i] = 5.0F + noise(0.2);
    grid.uv[i] = noise(0.2);
    grid.vv[i] = 5.0F + noise(0.2);
    grid.du[i] = static_cast<float>(plane.du) + noise(0.1 * kNear);
    grid.dv[i] = static_cast<float>(plane.dv) + noise(0.1 * kNear);
    grid.residual[i] = 1e-5F + noise(1e-5);
    grid.slack[i] = static_cast<float>(kNear * kNear);
    grid.usable[i] = usable ? 1 : 0;
    free[i] = usable;
    on.resize(grid.size());
    on[i] = on_plane;
    if (usable) set_bit(grid.usable_set, r, c);
  }
  /// Only between usable cells of the image, as a grid's links are.
  void draw_links(Grid::Links& links, std::uint32_t tenths, RandomStream& random) {
    for (int r = 0; r < grid.rows; ++r) {
      for (int c = 0; c < grid.columns; ++c) {
        const int i = grid.index(r, c);
        const auto link = [&](int j) {
          const bool drawn = random.below(10) < tenths;
          return drawn && free[at(i)] && free[at(j)];
        };
        if (link(i + 1)) set_bit(links.right, r, c);
        if (link(i + grid.stride)) set_bit(links.down, r, c);
      }
    }
  }
  void set_bit(std::vector<std::uint64_t>& set, int row, int column) const {
    set[at(row) * grid.words + at(column / kernels::kWordBits)] |= std::uint64_t{1} << (column % kernels::kWordBits);
  }
};

int row_of(const Grid& grid, int i) { return i / grid.stride - 1; }
int column_of(const Grid& grid, int i) { return i % grid.stride - 1; }
bool contains(const Window& window, int row, int column) {
  return row >= window.top && row <= window.bottom && column >= window.left && column <= window.right;
}

/// The indices of the cells that can be reached from one, sorted.
std::vector<int> search(const World& world, int row, int column, const Window& window) {
  const Grid& grid = world.grid;
  std::vector<bool> seen(grid.size(), false);
  std::vector<int> queue;
  const auto visit = [&](int i) {
    const bool inside = contains(window, row_of(grid, i), column_of(grid, i));
    if (!inside || seen[at(i)] || !world.free[at(i)] || !world.on[at(i)]) return;
    seen[at(i)] = true;
    queue.push_back(i);
  };
  visit(grid.index(row, column));
  for (std::size_t head = 0; head < queue.size(); ++head) {
    for (int direction = 0; direction < 4; ++direction) {
      const int i = queue[head];
      if (world.is_linked(grid.links, row_of(grid, i), column_of(grid, i), direction)) visit(i + grid.step(direction));
    }
  }
  std::sort(queue.begin(), queue.end());
  return queue;
}

std::vector<int> free_cells(const World& world, const Window& window) {
  std::vector<int> cells;
  for (int r = window.top; r <= window.bottom; ++r) {
    for (int c = window.left; c <= window.right; ++c) {
      if (world.free[at(world.grid.index(r, c))]) cells.push_back(world.grid.index(r, c));
    }
  }
  return cells;
}

std::vector<int> cells_of(const Spread& spread) {
  std::vector<int> cells;
  spread.for_each([&](int i) { cells.push_back(i); });
  return cells;
}

/// Everything that a set says of itself.
void check_set(const World& world, const Spread& spread, const std::vector<int>& expected, const kernels::CellSetPlane& about) {
  const Grid& grid = world.grid;
  RC_ASSERT(cells_of(spread) == expected);  // each once, row by row
  const std::vector<std::ptrdiff_t> indices(expected.begin(), expected.end());
  const kernels::CellSetSums sums = spread.sums(about);
  RC_ASSERT(sums.cells == static_cast<int>(expected.size()));
  RC_ASSERT(testing::agree(testing::values_of(sums), testing::sums_of(grid.arrays(0), indices, about)));
  // The set is what the cells are.
  const CellSet set = spread.set();
  std::vector<int> of_set;
  for (int r = set.top; r <= set.bottom; ++r) {
    for (int c = 0; c < grid.columns; ++c) {
      const std::uint64_t word = set.bits[at(r - set.top) * grid.words + at(c / kernels::kWordBits)];
      if ((word >> (c % kernels::kWordBits) & 1U) != 0) of_set.push_back(grid.index(r, c));
    }
  }
  RC_ASSERT(of_set == expected);
}

bool touches(const World& world, const std::vector<int>& cells, const Window& window) {
  return std::any_of(cells.begin(), cells.end(), [&](int i) {
    const int row = row_of(world.grid, i);
    const int column = column_of(world.grid, i);
    return (row == window.top && row > 0) || (row == window.bottom && row < world.grid.rows - 1) ||
           (column == window.left && column > 0) || (column == window.right && column < world.grid.columns - 1);
  });
}

World any_world(RandomStream& random) {
  const int rows = *rc::gen::inRange(1, 25);
  const int columns = *rc::gen::inRange(1, 201);
  return {rows, columns, random};
}

TEST(CellsSpread, ReachesWhatASearchReaches) {
  std::size_t largest = 0;
  testing::check_property(400, [&] {
    RandomStream random = testing::any_stream();
    World world = any_world(random);
    const Grid& grid = world.grid;
    SpreadBuffers buffers;
    Spread spread(grid, buffers);
    const auto below = [&](int size) { return static_cast<int>(random.below(static_cast<std::uint32_t>(size))); };
    for (int again = 0; again < 8; ++again) {
      const int row = below(grid.rows);
      const int column = below(grid.columns);
      const Window window = spread.window(row, column, again % 2 == 0 ? below(20) : 200);
      RC_ASSERT(contains(window, row, column));
      const std::size_t i = at(grid.index(row, column));
      const kernels::CellSetPlane plane = about(world.plane, static_cast<double>(grid.u[i]), static_cast<double>(grid.v[i]));
      spread.run(row, column, plane, window);
      const std::vector<int> expected = search(world, row, column, window);
      largest = std::max(largest, expected.size());
      check_set(world, spread, expected, plane);
      RC_ASSERT(spread.touches(window) == touches(world, expected, window));
      if (again % 3 == 2) {
        spread.claim();
        for (const int cell : expected) world.free[at(cell)] = false;
      }
    }
    for (int r = 0; r < grid.rows; ++r) {
      for (int c = 0; c < grid.columns; ++c) RC_ASSERT(spread.is_free(r, c) == world.free[at(grid.index(r, c))]);
    }
  });
  EXPECT_GT(largest, 1000U);
}

TEST(CellsSpread, TakesTheFreeCellsOfAWindow) {
  testing::check_property(100, [] {
    RandomStream random = testing::any_stream();
    World world = any_world(random);
    const Grid& grid = world.grid;
    SpreadBuffers buffers;
    Spread spread(grid, buffers);
    for (int again = 0; again < 4; ++again) {
      const int row = static_cast<int>(random.below(static_cast<std::uint32_t>(grid.rows)));
      const int column = static_cast<int>(random.below(static_cast<std::uint32_t>(grid.columns)));
      const Window window = spread.window(row, column, static_cast<int>(random.below(70)));
      spread.take(window);
      const std::vector<int> expected = free_cells(world, window);
      check_set(world, spread, expected, about(world.plane, 0.0, 0.0));
      spread.claim();
      for (const int cell : expected) world.free[at(cell)] = false;
    }
  });
}

/// A path of single cells that winds through all rows, there and back.
TEST(CellsSpread, GoesRoundEveryCorner) {
  constexpr int kRows = 9;
  for (const int columns : {1, 2, 63, 64, 65, 128, 129, 200}) {
    RandomStream random = testing::test_random();
    World world(kRows, columns, random);
    Grid& grid = world.grid;
    SpreadBuffers buffers;
    const auto all = [&](std::vector<std::uint64_t>& set) {
      for (std::size_t w = 0; w < set.size(); ++w) {
        set[w] = bits_between(0, columns - 1, static_cast<int>(w % grid.words) * kernels::kWordBits);
      }
    };
    const auto remove = [&](std::vector<std::uint64_t>& set, int row, int column) {
      set[at(row) * grid.words + at(column / kernels::kWordBits)] &= ~(std::uint64_t{1} << (column % kernels::kWordBits));
    };
    all(grid.usable_set);
    all(grid.links.right);
    std::fill(grid.links.down.begin(), grid.links.down.end(), 0);
    for (int r = 0; r < kRows; ++r) {
      remove(grid.links.right, r, columns - 1);
      const int turn = r % 2 == 0 ? columns - 1 : 0;
      if (r + 1 < kRows)
        grid.links.down[at(r) * grid.words + at(turn / kernels::kWordBits)] |= std::uint64_t{1} << (turn % kernels::kWordBits);
    }
    for (float& slack : grid.slack) slack = 1e6F;
    Spread spread(grid, buffers);
    const Window window = spread.window(0, 0, std::max(kRows, columns));
    const auto reached = [&](int row, int column) {
      spread.run(row, column, about(world.plane, 0.0, 0.0), window);
      return cells_of(spread).size();
    };
    EXPECT_EQ(reached(0, 0), at(kRows * columns));
    EXPECT_EQ(reached(kRows - 1, columns - 1), at(kRows * columns));
    EXPECT_EQ(reached(kRows / 2, columns / 2), at(kRows * columns));
    EXPECT_FALSE(spread.touches(window));
    if (columns < 2) continue;
    // Cut in the middle of a row, the path ends there.
    remove(grid.links.right, 4, columns / 2 - 1);
    EXPECT_EQ(reached(0, 0), at(4 * columns + columns / 2));
    EXPECT_EQ(reached(8, 0), at(5 * columns - columns / 2));
  }
}

TEST(CellsSpread, NothingWhereTheCellItselfIsNotOnThePlane) {
  RandomStream random = testing::test_random();
  World world(5, 70, random);
  SpreadBuffers buffers;
  Spread spread(world.grid, buffers);
  const Window window = spread.window(2, 66, 70);
  spread.take(window);
  const kernels::CellSetPlane far{0.0F, 0.0F, 9.0F, 0.0F, 0.0F};
  spread.run(2, 66, far, window);
  EXPECT_TRUE(cells_of(spread).empty());
  EXPECT_EQ(spread.sums(far).cells, 0);
  EXPECT_EQ(spread.sums(far).n, 0.0F);
  EXPECT_FALSE(spread.touches(window));
  spread.claim();
  for (int r = 0; r < 5; ++r) {
    for (int c = 0; c < 70; ++c) EXPECT_EQ(spread.is_free(r, c), world.free[at(world.grid.index(r, c))]);
  }
}

/// Numbers that no operation rounds: the moments of the sums are those of the cells, to the last bit.
TEST(CellsSpread, MomentsOfSumsAreThoseOfItsCells) {
  RandomStream random = testing::test_random();
  const auto whole = [&](int low, int high) {
    return low + static_cast<int>(random.below(static_cast<std::uint32_t>(high - low + 1)));
  };
  for (const int columns : {1, 8, 66}) {
    World world(3, columns, random);
    Grid& grid = world.grid;
    SpreadBuffers buffers;
    Spread spread(grid, buffers);
    const Window window = spread.window(1, columns - 1, 2);
    Moments expected;
    int cells = 0;
    for (const int i : free_cells(world, window)) {
      const std::size_t k = at(i);
      const double n = whole(1, 4), u = 4 * whole(-4, 4), v = 4 * whole(-4, 4), q = 0.25 * whole(1, 12);
      const double uu = whole(1, 5), uv = whole(-1, 1), vv = whole(1, 5), du = whole(-2, 2) / 16.0, dv = whole(-2, 2) / 16.0;
      const double residual = whole(0, 8) / 256.0;
      ++cells;
      const double uq = uu * du + uv * dv;
      const double vq = uv * du + vv * dv;
      expected += {.n = n,
                   .u = n * u,
                   .v = n * v,
                   .q = n * q,
                   .uu = n * (uu + u * u),
                   .uv = n * (uv + u * v),
                   .vv = n * (vv + v * v),
                   .uq = n * (uq + u * q),
                   .vq = n * (vq + v * q),
                   .qq = n * (residual + du * uq + dv * vq + q * q)};
      const auto set = [&](AlignedVector<float>& values, double value) { values[k] = static_cast<float>(value); };
      set(grid.n, n), set(grid.u, u), set(grid.v, v), set(grid.q, q), set(grid.uu, uu), set(grid.uv, uv), set(grid.vv, vv);
      set(grid.du, du), set(grid.dv, dv), set(grid.residual, residual);
    }
    spread.take(window);
    for (const kernels::CellSetPlane& plane :
         {kernels::CellSetPlane{0.0F, 0.0F, 0.0F, 0.0F, 0.0F}, {4.0F, -8.0F, 1.5F, 0.0625F, -0.125F}}) {
      const kernels::CellSetSums sums = spread.sums(plane);
      EXPECT_EQ(sums.cells, cells);
      const Moments got = moments_of(sums, plane);
      EXPECT_EQ(got.n, expected.n);
      EXPECT_EQ(got.u, expected.u);
      EXPECT_EQ(got.v, expected.v);
      EXPECT_EQ(got.q, expected.q);
      EXPECT_EQ(got.uu, expected.uu);
      EXPECT_EQ(got.uv, expected.uv);
      EXPECT_EQ(got.vv, expected.vv);
      EXPECT_EQ(got.uq, expected.uq);
      EXPECT_EQ(got.vq, expected.vq);
      EXPECT_EQ(got.qq, expected.qq);
    }
  }
}

TEST(CellsSpread, BitsBetween) {
  for (const int begin : {0, 64, 128}) {
    for (int first = 0; first < 200; first += 7) {
      for (int last = first; last < 200; last += 3) {
        const std::uint64_t bits = bits_between(first, last, begin);
        for (int k = 0; k < kernels::kWordBits; ++k) EXPECT_EQ(bits >> k & 1U, begin + k >= first && begin + k <= last ? 1U : 0U);
      }
    }
  }
  EXPECT_EQ(bits_between(0, 63, 0), ~std::uint64_t{0});
}

}  // namespace
}  // namespace fransac::cells
