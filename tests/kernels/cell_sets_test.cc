// SPDX-License-Identifier: Apache-2.0
// The kernels over sets of cells, once per instruction set that this machine has: against sums and decisions made cell by cell
// with the roundings of floats, and so is their scalar truth; and by hand.
#include "kernels/cell_sets.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <limits>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "kernels/cell_sums.hpp"
#include "kernels/cells.h"
#include "kernels/targets.hpp"
#include "rounded.hpp"
#include "support.hpp"

namespace fransac::kernels {
namespace {

using testing::agree;
using testing::at_most;
using testing::both;
using testing::CellOffset;
using testing::Rounded;
using testing::uniform;
using Verdict = std::optional<bool>;

constexpr std::size_t kWidths[] = {1, 7, 8, 9, 63, 64, 65, 80, 240};
constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();
constexpr std::uint64_t kUntouchedWord = 0xA5A5A5A5A5A5A5A5U;
constexpr float kUntouched = -7.0F;
constexpr float kWhole = kCell;  ///< A cell's side.

constexpr double d(float value) { return static_cast<double>(value); }

class CellSets : public ::testing::TestWithParam<std::int64_t> {
 protected:
  void SetUp() override { hwy::SetSupportedTargetsForTest(GetParam()); }
  void TearDown() override { hwy::SetSupportedTargetsForTest(0); }
};

constexpr CellSetPlane kPlane{12.0F, -20.0F, 0.7F, 3e-4F, -5e-4F};
constexpr double kNear = 0.02;  ///< How far cells are from the plane.

/// Rows of cells with a border of one cell and room for whole vectors, all of which, the room too, looks like cells near kPlane.
struct Field {
  static constexpr std::size_t kFields = 10;
  static constexpr std::size_t kRoom = 64;

  Field(std::size_t num_rows, std::size_t num_cells)
      : rows(num_rows), cells(num_cells), stride(static_cast<std::ptrdiff_t>(num_cells) + 2) {
    const std::size_t size = static_cast<std::size_t>(stride) * (rows + 2) + kRoom;
    fields.assign(kFields, std::vector<float>(size));
    shape.assign(size, 1.0F);
    slack.assign(size, static_cast<float>(kNear * kNear));
    weight.assign(size, 1.0F);
  }
  Field(std::size_t num_rows, std::size_t num_cells, RandomStream& random) : Field(num_rows, num_cells) {
    const auto f = [&](double low, double high) { return static_cast<float>(uniform(random, low, high)); };
    for (std::size_t i = 0; i < slack.size(); ++i) {
      const auto column = static_cast<double>(i % static_cast<std::size_t>(stride));
      const auto row = static_cast<double>(i / static_cast<std::size_t>(stride));  // NOLINT: whole
      const double u = kCell * column + uniform(random, -1.0, 1.0);
      const double v = kCell * row + uniform(random, -1.0, 1.0);
      constexpr double kSlope = 2.0 * kNear / kCell;
      const auto& [u0, v0, q0, du, dv] = kPlane;
      const double on_plane = d(q0) + d(du) * (u - d(u0)) + d(dv) * (v - d(v0));
      const double values[kFields] = {1.0 + random.below(64),
                                      u,
                                      v,
                                      on_plane + 1.5 * uniform(random, -kNear, kNear),
                                      uniform(random, 3.0, 5.25),
                                      uniform(random, -1.0, 1.0),
                                      uniform(random, 3.0, 5.25),
                                      d(du) + uniform(random, -kSlope, kSlope),
                                      d(dv) + uniform(random, -kSlope, kSlope),
                                      uniform(random, 0.0, kNear * kNear)};
      for (std::size_t k = 0; k < kFields; ++k) fields[k][i] = static_cast<float>(values[k]);
      shape[i] = f(0.5, 2.0);
      slack[i] = static_cast<float>(kNear * kNear) * f(0.5, 2.0);
    }
  }
  [[nodiscard]] std::size_t at(std::size_t row, std::size_t column) const {
    return (row + 1) * static_cast<std::size_t>(stride) + column + 1;
  }
  [[nodiscard]] CellArrays arrays(std::size_t row = 0) const {
    const std::size_t i = at(row, 0);
    return {&fields[0][i], &fields[1][i], &fields[2][i], &fields[3][i], &fields[4][i], &fields[5][i],
            &fields[6][i], &fields[7][i], &fields[8][i], &fields[9][i], stride};
  }
  [[nodiscard]] const float* from(const std::vector<float>& values, std::size_t row = 0) const { return &values[at(row, 0)]; }
  /// Makes a cell what must not count.
  void spoil(std::size_t i) {
    for (std::size_t k = 0; k < kFields; ++k) fields[k][i] = (i + k) % 3 == 0 ? kNoFit : kNaN;
  }

  std::size_t rows, cells;
  std::ptrdiff_t stride;
  std::vector<std::vector<float>> fields;  ///< As CellArrays.
  std::vector<float> shape, slack, weight;
};

/// Calls check(field, random) for random fields of all widths.
void for_random_fields(std::size_t rows, const std::function<void(Field&, RandomStream&)>& check) {
  RandomStream random = testing::test_random();
  for (int repetition = 0; repetition < 4; ++repetition) {
    for (const std::size_t cells : kWidths) {
      SCOPED_TRACE(::testing::Message() << cells << " cells");
      Field field(rows, cells, random);
      check(field, random);
    }
  }
}

// ---- sets that are made ----

/// Compares a set with what is expected of each cell, but for those that rounding may decide; a word behind it is not touched,
/// and bits behind the row are 0.
class MadeSet {
 public:
  explicit MadeSet(std::size_t cells) : cells_(cells), words_(words_of(cells) + 1, kUntouchedWord) {}
  std::uint64_t* data() { return words_.data(); }
  [[nodiscard]] bool has(std::size_t i) const { return (words_[i / kWordBits] >> (i % kWordBits) & 1U) != 0; }
  void expect(const std::vector<Verdict>& verdicts) const {
    ASSERT_EQ(verdicts.size(), cells_);
    EXPECT_EQ(words_.back(), kUntouchedWord);
    for (std::size_t i = 0; i + kWordBits < words_.size() * kWordBits; ++i) {
      if (i >= cells_) {
        EXPECT_FALSE(has(i)) << "cell " << i << " of " << cells_;
      } else if (verdicts[i]) {
        EXPECT_EQ(has(i), *verdicts[i]) << "cell " << i;
      }
    }
  }

 private:
  std::size_t cells_;
  std::vector<std::uint64_t> words_;
};

/// Of many verdicts hardly any may be left to rounding, and both must occur.
struct Tally {
  std::size_t yes = 0, no = 0, open = 0;
  void add(const std::vector<Verdict>& verdicts) {
    for (const Verdict& verdict : verdicts) ++(!verdict ? open : *verdict ? yes : no);
  }
  ~Tally() {
    EXPECT_GT(yes, (yes + no) / 20);
    EXPECT_GT(no, (yes + no) / 20);
    EXPECT_LT(open, 2 + (yes + no) / 1000);
  }
};

/// Squared distances of a cell's mean, and of its slopes over half a cell.
struct Far {
  Far(const CellArrays& cells, std::size_t i, const CellSetPlane& plane) {
    const CellOffset o(cells, static_cast<std::ptrdiff_t>(i), plane);
    const Rounded a = Rounded(0.5F * kWhole) * o.a;
    const Rounded b = Rounded(0.5F * kWhole) * o.b;
    mean = o.r * o.r;
    slope = a * a + b * b;
  }
  [[nodiscard]] Verdict within(float slack) const { return both(at_most(mean, slack), at_most(slope, slack)); }
  Rounded mean, slope;
};

TEST_P(CellSets, FindsCellsOnAPlane) {
  Tally tally;
  for_random_fields(2, [&](const Field& field, RandomStream&) {
    for (std::size_t row = 0; row < 2; ++row) {
      const CellArrays arrays = field.arrays(row);
      const float* const slack = field.from(field.slack, row);
      std::vector<Verdict> verdicts;
      for (std::size_t i = 0; i < field.cells; ++i) verdicts.push_back(Far(arrays, i, kPlane).within(slack[i]));
      tally.add(verdicts);
      for (const auto kernel : {find_on_plane, ref::find_on_plane}) {
        MadeSet set(field.cells);
        kernel(arrays, slack, field.cells, kPlane, set.data());
        set.expect(verdicts);
      }
    }
  });
}

/// A field whose cells are all on q = 1/2 + u / 1024 - v / 512 at whole places: no operation rounds.
Field exact_field(std::size_t rows, std::size_t cells) {
  Field field(rows, cells);
  for (std::size_t i = 0; i < field.slack.size(); ++i) {
    const auto u = kWhole * static_cast<float>(i % static_cast<std::size_t>(field.stride));
    const auto v = kWhole * static_cast<float>(i / static_cast<std::size_t>(field.stride));
    const float values[Field::kFields] = {static_cast<float>(1 + i % 5),
                                          u,
                                          v,
                                          0.5F + u * 0x1p-10F - v * 0x1p-9F,
                                          5.0F,
                                          static_cast<float>(i % 3) - 1.0F,
                                          4.0F,
                                          0x1p-10F,
                                          -0x1p-9F,
                                          0.0F};
    for (std::size_t k = 0; k < Field::kFields; ++k) field.fields[k][i] = values[k];
    field.slack[i] = 0.0F;
  }
  return field;
}
constexpr CellSetPlane kExactPlane{16.0F, 8.0F, 0.5F, 0x1p-10F, -0x1p-9F};

TEST_P(CellSets, ACellAtTheLimitIsOnThePlane) {
  for (const std::size_t cells : kWidths) {
    Field field = exact_field(1, cells);
    std::vector<Verdict> verdicts;
    for (std::size_t i = 0; i < cells; ++i) {
      // Off by 1/8: in its mean, or by 1/32 in one of its slopes, over half a cell; each at the limit or just beyond.
      const std::size_t k = field.at(0, i);
      const std::size_t where = i % 4;
      if (where < 3) field.fields[where == 0 ? 3 : where + 6][k] += (i % 8 < 4 ? 1.0F : -1.0F) * (where == 0 ? 0.125F : 0x1p-5F);
      const bool at_limit = i % 3 != 0;
      if (where < 3) field.slack[k] = at_limit ? 0x1p-6F : 0x1p-6F - 0x1p-28F;
      verdicts.emplace_back(where == 3 || at_limit);
    }
    for (const auto kernel : {find_on_plane, ref::find_on_plane}) {
      MadeSet set(cells);
      kernel(field.arrays(), field.from(field.slack), cells, kExactPlane, set.data());
      set.expect(verdicts);
    }
  }
}

Verdict is_linked(const Field& field, std::size_t i, std::size_t j, const CellLinkLimits& limits) {
  const auto [n, u, v, q, uu, uv, vv, du, dv, residual, stride] = field.arrays();
  const std::size_t first = field.at(0, 0);
  i -= first;
  j -= first;
  const auto difference = [&](const float* values) { return Rounded(values[j]) - values[i]; };
  const auto mean = [&](const float* values) { return Rounded(0.5F) * (Rounded(values[i]) + values[j]); };
  const Rounded jump = difference(q) - mean(du) * difference(u) - mean(dv) * difference(v);
  const Rounded a = Rounded(limits.slope_u) * difference(du);
  const Rounded b = Rounded(limits.slope_v) * difference(dv);
  const Rounded shape = std::max(field.shape[first + i], field.shape[first + j]);
  const Rounded noise = shape * shape;
  const Rounded squared = mean(q) * mean(q);
  const Rounded fourth = squared * squared;
  return both(at_most(jump * jump, Rounded(limits.jump_noise) * noise + Rounded(limits.jump_m) * fourth),
              at_most(a * a + b * b,
                      Rounded(limits.bend_noise) * noise + Rounded(limits.bend_m) * fourth + Rounded(limits.bend_rad) * squared));
}

using FindLinks = void (*)(const CellArrays&, const float*, std::size_t, std::ptrdiff_t, const CellLinkLimits&, std::uint64_t*);
constexpr FindLinks kFindLinks[] = {find_links, ref::find_links};

TEST_P(CellSets, FindsLinks) {
  Tally tally;
  for_random_fields(2, [&](const Field& field, RandomStream& random) {
    // Each limit alone, all at once, and all but one.
    const auto square = [](double x) { return static_cast<float>(x * x); };
    for (unsigned kind = 0; kind < 6; ++kind) {
      const auto limit = [&](unsigned which, double size) {
        const bool counts = kind == 5 || which == kind % 2 || which == 2 + kind % 3;
        return counts ? square(size * uniform(random, 0.7, 1.5)) : 0.0F;
      };
      const CellLinkLimits limits{limit(0, 1.0 * kNear), limit(1, 3.0 * kNear), 4.0F, 3.0F, limit(2, 1.5 * kNear),
                                  limit(3, 4.0 * kNear), limit(4, 2.5 * kNear)};
      for (const std::ptrdiff_t step : {std::ptrdiff_t{1}, field.stride, std::ptrdiff_t{-1}}) {
        std::vector<Verdict> verdicts;
        for (std::size_t c = 0; c < field.cells; ++c) {
          const std::size_t i = field.at(1, c) - static_cast<std::size_t>(field.stride);
          verdicts.push_back(is_linked(field, i, step < 0 && c == 0 ? i : i + static_cast<std::size_t>(step), limits));
        }
        if (step < 0) verdicts[0].reset();
        tally.add({verdicts.begin() + (step < 0 ? 1 : 0), verdicts.end()});
        for (const FindLinks kernel : kFindLinks) {
          MadeSet set(field.cells);
          kernel(field.arrays(), field.from(field.shape), field.cells, step, limits, set.data());
          set.expect(verdicts);
        }
      }
    }
  });
}

/// One plane at whole places is linked with no tolerance at all; what breaks it breaks both links of a cell.
TEST_P(CellSets, LinksOfAnExactPlaneBreakWhereACellDiffers) {
  const CellLinkLimits none{0.0F, 0.0F, 4.0F, 4.0F, 0.0F, 0.0F, 0.0F};
  for (const std::size_t cells : kWidths) {
    for (std::size_t which = 0; which < 4; ++which) {  // none, mean, slopes
      Field field = exact_field(2, cells);
      const std::size_t odd = cells / 2;
      if (which > 0) field.fields[which == 1 ? 3 : which + 5][field.at(0, odd)] += 0x1p-12F;
      for (const FindLinks kernel : kFindLinks) {
        MadeSet right(cells), down(cells);
        kernel(field.arrays(), field.from(field.shape), cells, 1, none, right.data());
        kernel(field.arrays(), field.from(field.shape), cells, field.stride, none, down.data());
        std::vector<Verdict> expected_right(cells, true), expected_down(cells, true);
        if (which > 0) {
          expected_right[odd] = expected_down[odd] = false;
          if (odd > 0) expected_right[odd - 1] = false;
        }
        right.expect(expected_right);
        down.expect(expected_down);
      }
    }
  }
}

TEST_P(CellSets, ALinkAtEachLimitHolds) {
  // Means differ by 1/8 around 1/2, or slopes by 1/16; the larger shape is 2.
  const auto is_linked = [](FindLinks kernel, bool bend, bool shape_of_second, const CellLinkLimits& limits) {
    Field field(1, 1);
    const std::size_t i = field.at(0, 0);
    field.fields[3][i] = bend ? 0.5F : 0.4375F;
    field.fields[3][i + 1] = bend ? 0.5F : 0.5625F;
    if (bend) field.fields[7][i + 1] = 0.0625F;
    field.shape[i + (shape_of_second ? 1 : 0)] = 2.0F;
    field.shape[i + (shape_of_second ? 0 : 1)] = 0.5F;
    MadeSet set(1);
    kernel(field.arrays(), field.from(field.shape), 1, 1, limits, set.data());
    return set.has(0);
  };
  constexpr float kLess = 1.0F - 0x1p-20F;
  constexpr float kAny = 4.0F;
  for (const FindLinks kernel : kFindLinks) {
    for (const bool second : {false, true}) {
      for (const float factor : {1.0F, kLess}) {
        const bool linked = factor == 1.0F;
        // (1/8)^2 of 2^2, of (1/2)^4.
        EXPECT_EQ(is_linked(kernel, false, second, {factor * 0x1p-8F, 0.0F, 1.0F, 1.0F, kAny, 0.0F, 0.0F}), linked);
        EXPECT_EQ(is_linked(kernel, false, second, {0.0F, factor * 0x1p-2F, 1.0F, 1.0F, kAny, 0.0F, 0.0F}), linked);
        // (2 / 16)^2 of 2^2, of (1/2)^4, of (1/2)^2.
        EXPECT_EQ(is_linked(kernel, true, second, {kAny, 0.0F, 2.0F, 0.0F, factor * 0x1p-8F, 0.0F, 0.0F}), linked);
        EXPECT_EQ(is_linked(kernel, true, second, {kAny, 0.0F, 2.0F, 0.0F, 0.0F, factor * 0x1p-2F, 0.0F}), linked);
        EXPECT_EQ(is_linked(kernel, true, second, {kAny, 0.0F, 2.0F, 0.0F, 0.0F, 0.0F, factor * 0x1p-4F}), linked);
      }
    }
  }
}

// ---- sums over sets ----

/// A set of some cells of a field, a random one or none or all of them.
struct SomeCells {
  SomeCells(const Field& field, std::size_t tenths, RandomStream& random)
      : words(words_of(field.cells)), bits(words * field.rows, 0) {
    for (std::size_t row = 0; row < field.rows; ++row) {
      for (std::size_t c = 0; c < field.cells; ++c) {
        if (random.below(10) < tenths) add(field, row, c);
      }
    }
  }
  SomeCells(const Field& field, std::size_t row, std::size_t column) : words(words_of(field.cells)), bits(words * field.rows, 0) {
    add(field, row, column);
  }
  void add(const Field& field, std::size_t row, std::size_t c) {
    bits[row * words + c / kWordBits] |= std::uint64_t{1} << (c % kWordBits);
    cells.push_back(static_cast<std::ptrdiff_t>(field.at(row, c) - field.at(0, 0)));
  }
  /// Whatever is not in the set must not count.
  void spoil_others(Field& field) const {
    const std::set<std::ptrdiff_t> mine(cells.begin(), cells.end());
    const auto first = static_cast<std::ptrdiff_t>(field.at(0, 0));
    for (std::size_t i = 0; i < field.slack.size(); ++i) {
      if (mine.count(static_cast<std::ptrdiff_t>(i) - first) == 0) field.spoil(i);
    }
  }
  std::size_t words;
  std::vector<std::uint64_t> bits;
  std::vector<std::ptrdiff_t> cells;  ///< From the field's first.
};

/// Calls check(field, set) for random fields and sets, with what is outside the set spoiled.
void for_random_sets(const std::function<void(const Field&, const SomeCells&)>& check) {
  for_random_fields(3, [&](const Field& field, RandomStream& random) {
    for (const std::size_t tenths : {0U, 1U, 5U, 10U}) {
      Field spoiled = field;
      const SomeCells set(field, tenths, random);
      set.spoil_others(spoiled);
      check(spoiled, set);
    }
    Field spoiled = field;
    const SomeCells last(field, 2, field.cells - 1);
    last.spoil_others(spoiled);
    check(spoiled, last);
  });
}

TEST_P(CellSets, SumsOverSets) {
  for_random_sets([](const Field& field, const SomeCells& set) {
    const std::vector<Rounded> expected = testing::sums_of(field.arrays(), set.cells, kPlane);
    for (const auto kernel : {sum_cells, ref::sum_cells}) {
      const CellSetSums got = kernel(field.arrays(), set.bits.data(), field.rows, set.words, kPlane);
      EXPECT_EQ(got.cells, static_cast<std::int32_t>(set.cells.size()));
      EXPECT_TRUE(agree(testing::values_of(got), expected));
    }
  });
}

TEST_P(CellSets, AnExactPlaneHasNoResidual) {
  RandomStream random = testing::test_random();
  for (const std::size_t cells : kWidths) {
    const Field field = exact_field(3, cells);
    const SomeCells set(field, 7, random);
    for (const auto kernel : {sum_cells, ref::sum_cells}) {
      const CellSetSums got = kernel(field.arrays(), set.bits.data(), 3, set.words, kExactPlane);
      for (const float residual : {got.r, got.ur, got.vr, got.rr}) EXPECT_EQ(residual, 0.0F);
      float n = 0.0F;
      for (const std::ptrdiff_t i : set.cells) n += field.arrays().n[i];
      EXPECT_EQ(got.n, n);
    }
  }
}

/// A few cells of pixels, measured as a depth image's are.
struct Pixels {
  Pixels(std::size_t num_rows, std::size_t num_cells, bool holes, RandomStream& random) : field(num_rows, num_cells) {
    const std::size_t width = num_cells * kCell;
    z.assign(num_rows * kCell * width, 0.0F);
    for (std::size_t i = 0; i < z.size(); ++i) {
      const double q = on_plane(i % width, i / width) + 0.01 * random.normal();
      if (!holes || random.below(4) != 0) z[i] = static_cast<float>(1.0 / q);
    }
    for (std::size_t row = 0; row < num_rows; ++row) {
      CellRows<float> rows{};
      for (std::size_t v = 0; v < kCell; ++v) rows.rows[v] = &z[(row * kCell + v) * width];
      const std::size_t first = field.at(row, 0);
      const auto to = [&](std::size_t k) { return &field.fields[k][first]; };
      ref::cell_kernels<float>(kCell).moments(rows, num_cells, 1.0F, 1.0F,
                                              {to(0), to(1), to(2), to(3), to(4), to(5), to(6), to(7), to(8), to(9)});
      for (std::size_t c = 0; c < num_cells; ++c) {
        field.fields[1][first + c] += static_cast<float>(c * kCell) + 3.5F;
        field.fields[2][first + c] += static_cast<float>(row * kCell) + 3.5F;
      }
    }
  }
  static double on_plane(std::size_t u, std::size_t v) {
    return 0.8 + 2e-3 * static_cast<double>(u) - 3e-3 * static_cast<double>(v);
  }
  /// Calls visit(column, row, q) for those pixels that there are.
  template <class Visitor>
  void for_each(Visitor visit) const {
    const std::size_t width = field.cells * kCell;
    for (std::size_t i = 0; i < z.size(); ++i) {
      if (z[i] > 0.0F)
        visit(static_cast<double>(i % width), static_cast<double>(i / width), 1.0 / static_cast<double>(z[i]));  // NOLINT: whole
    }
  }
  Field field;
  std::vector<float> z;
};

constexpr double kRoundingsOfMoments = 2.0;  ///< As they are stored, and where places are moved.

TEST_P(CellSets, SumsAreThoseOfPixels) {
  RandomStream random = testing::test_random();
  const CellSetPlane plane{40.0F, 10.0F, 0.85F, 1e-3F, -2e-3F};
  const Pixels pixels(3, 9, true, random);
  const SomeCells all(pixels.field, 10, random);
  std::array<double, testing::kCellSums> sums{};
  pixels.for_each([&](double u, double v, double q) {
    const double x = u - d(plane.u0);
    const double y = v - d(plane.v0);
    const double r = q - d(plane.q0) - d(plane.du) * x - d(plane.dv) * y;
    const double terms[] = {1.0, x, y, r, x * x, x * y, y * y, x * r, y * r, r * r};
    for (std::size_t k = 0; k < testing::kCellSums; ++k) sums[k] += terms[k];
  });
  const auto bounds = testing::sums_of(pixels.field.arrays(), all.cells, plane, kRoundingsOfMoments);
  for (const auto kernel : {sum_cells, ref::sum_cells}) {
    const auto got = testing::values_of(kernel(pixels.field.arrays(), all.bits.data(), 3, all.words, plane));
    for (std::size_t k = 0; k < testing::kCellSums; ++k) EXPECT_NEAR(d(got[k]), sums[k], bounds[k].error) << k;
  }
}

std::vector<float> values_of(const CellSetShape& shape) {
  std::vector<float> values(std::begin(shape.position), std::end(shape.position));
  values.insert(values.end(), std::begin(shape.offset), std::end(shape.offset));
  values.push_back(shape.off);
  values.push_back(shape.slope);
  return values;
}

/// x^a y^b.
struct Powers {
  int a, b;
};
constexpr Powers kPositions[] = {{0, 0}, {1, 0}, {2, 0}, {3, 0}, {4, 0}, {0, 1}, {1, 1}, {2, 1},
                                 {3, 1}, {0, 2}, {1, 2}, {2, 2}, {0, 3}, {1, 3}, {0, 4}};
constexpr Powers kOffsets[] = {{0, 0}, {1, 0}, {2, 0}, {0, 1}, {1, 1}, {0, 2}};
static_assert(std::size(kPositions) == CellSetShape::kPositions && std::size(kOffsets) == CellSetShape::kOffsets);

TEST_P(CellSets, ShapesOfSets) {
  for_random_sets([](const Field& field, const SomeCells& set) {
    std::vector<std::vector<Rounded>> terms(CellSetShape::kPositions + CellSetShape::kOffsets + 2);
    for (const std::ptrdiff_t i : set.cells) {
      const CellOffset o(field.arrays(), i, kPlane);
      const Far far(field.arrays(), static_cast<std::size_t>(i), kPlane);
      const auto product = [&](Rounded value, const Powers& powers) {
        for (int k = 0; k < powers.b; ++k) value = value * (o.y / kWhole);
        for (int k = 0; k < powers.a; ++k) value = value * (o.x / kWhole);
        return value;
      };
      auto term = terms.begin();
      for (const Powers& powers : kPositions) (term++)->push_back(product(1.0F, powers));
      for (const Powers& powers : kOffsets) (term++)->push_back(product(o.r, powers));
      (term++)->push_back(far.mean);
      (term++)->push_back(far.slope);
    }
    std::vector<Rounded> expected;
    for (const auto& of_one : terms) expected.push_back(testing::sum(of_one));
    for (const auto kernel : {sum_shape, ref::sum_shape}) {
      EXPECT_TRUE(agree(values_of(kernel(field.arrays(), set.bits.data(), field.rows, set.words, kPlane)), expected));
    }
  });
}

TEST_P(CellSets, ShapeOfOneCell) {
  for (const std::size_t column : {0U, 5U, 63U, 64U, 69U}) {
    Field field(2, 70);
    const std::size_t i = field.at(1, column);
    // Two cells right and three above the plane's point, 1/4 off, and slopes that are 1/16 and 1/8 off.
    const float values[] = {1.0F, 16.0F, -24.0F, 0.75F, 5.0F, 0.0F, 5.0F, 0.0625F, 0.125F, 0.0F};
    for (std::size_t k = 0; k < Field::kFields; ++k) field.fields[k][i] = values[k];
    const SomeCells set(field, 1, column);
    for (const auto kernel : {sum_shape, ref::sum_shape}) {
      const CellSetShape got = kernel(field.arrays(), set.bits.data(), 2, set.words, {0.0F, 0.0F, 0.5F, 0.0F, 0.0F});
      for (std::size_t k = 0; k < std::size(kPositions); ++k) {
        EXPECT_EQ(d(got.position[k]), std::pow(2.0, kPositions[k].a) * std::pow(-3.0, kPositions[k].b)) << k;
      }
      for (std::size_t k = 0; k < std::size(kOffsets); ++k) {
        EXPECT_EQ(d(got.offset[k]), 0.25 * std::pow(2.0, kOffsets[k].a) * std::pow(-3.0, kOffsets[k].b)) << k;
      }
      EXPECT_EQ(got.off, 0.0625F);
      EXPECT_EQ(got.slope, 0.0625F + 0.25F);
    }
  }
}

// ---- the nearest plane ----

TEST_P(CellSets, TheNearestPlane) {
  Tally tally;
  constexpr std::int32_t kId = 3, kBefore = 8;
  for_random_fields(1, [&](const Field& field, RandomStream& random) {
    for (const std::size_t tenths : {0U, 5U, 10U}) {
      Field spoiled = field;
      const SomeCells set(field, tenths, random);
      set.spoil_others(spoiled);
      const std::size_t size = field.cells + Field::kRoom;
      std::vector<float> before(size);
      for (float& least : before) least = static_cast<float>(kNear * kNear * uniform(random, 0.0, 3.0));
      const float* const slack = field.from(field.slack);
      std::vector<Verdict> verdicts(size, false);
      std::vector<Verdict> of_set;
      std::vector<Rounded> sums(size);
      for (const std::ptrdiff_t cell : set.cells) {
        const auto i = static_cast<std::size_t>(cell);
        const Far far(field.arrays(), i, kPlane);
        sums[i] = far.mean + far.slope;
        const Verdict farther = at_most(before[i], sums[i]);
        verdicts[i] = both(far.within(slack[i]), farther ? Verdict(!*farther) : std::nullopt);
        of_set.push_back(verdicts[i]);
      }
      tally.add(of_set);
      const auto check = [&](const Field& cells, auto kernel) {
        std::vector<float> least = before;
        std::vector<std::int32_t> nearest(size, kBefore);
        kernel(cells.arrays(), slack, field.cells, kPlane, set.bits.data(), kId, least.data(), nearest.data());
        for (std::size_t i = 0; i < size; ++i) {
          if (!verdicts[i]) continue;
          EXPECT_EQ(nearest[i], *verdicts[i] ? kId : kBefore) << i;
          if (*verdicts[i]) {
            EXPECT_TRUE(sums[i].may_be(least[i])) << i;
          } else {
            EXPECT_EQ(least[i], before[i]) << i;
          }
        }
      };
      check(field, find_nearest);
      check(spoiled, find_nearest);
      check(field, ref::find_nearest);
      check(spoiled, ref::find_nearest);
    }
  });
}

/// At the limit a cell is on the plane; of two equally near planes the first one keeps it.
TEST_P(CellSets, TheFirstOfEquallyNearPlanes) {
  for (const auto kernel : {find_nearest, ref::find_nearest}) {
    Field field(1, 9);
    const std::uint64_t all = 0x1FF;
    for (std::size_t c = 0; c < 9; ++c) {
      field.fields[3][field.at(0, c)] = 0.5F;
      field.slack[field.at(0, c)] = c % 2 == 0 ? 0x1p-4F : 0x1p-4F - 0x1p-20F;
    }
    std::vector<float> least(9 + Field::kRoom, std::numeric_limits<float>::infinity());
    std::vector<std::int32_t> nearest(9 + Field::kRoom, -1);
    const auto offer = [&](float q, std::int32_t id) {
      kernel(field.arrays(), field.from(field.slack), 9, {0.0F, 0.0F, q, 0.0F, 0.0F}, &all, id, least.data(), nearest.data());
    };
    offer(0.75F, 5);
    offer(0.25F, 6);
    for (std::size_t c = 0; c < 9; ++c) EXPECT_EQ(nearest[c], c % 2 == 0 ? 5 : -1);
    for (std::size_t c = 0; c < 9; c += 2) EXPECT_EQ(least[c], 0x1p-4F);
    offer(0.375F, 7);
    for (std::size_t c = 0; c < 9; ++c) EXPECT_EQ(nearest[c], 7);
    offer(0.75F, 5);
    for (std::size_t c = 0; c < 9; ++c) {
      EXPECT_EQ(nearest[c], 7);
      EXPECT_EQ(least[c], 0x1p-6F);
    }
  }
}

TEST_P(CellSets, ErrorsOfSets) {
  for_random_sets([](const Field& field, const SomeCells& set) {
    Rounded variance(0.0F);
    Rounded q4(0.0F);
    std::vector<float> sigma(field.slack.size(), kNaN);  // whatever is not in the set must not count
    const std::size_t first = field.at(0, 0);
    for (const std::ptrdiff_t cell : set.cells) {
      const std::size_t i = first + static_cast<std::size_t>(cell);
      sigma[i] = field.shape[i];
      const Rounded q(field.fields[3][i]);
      variance = variance + Rounded(sigma[i]) * Rounded(sigma[i]);
      q4 = q4 + q * q * (q * q);
    }
    for (const auto kernel : {sum_errors, ref::sum_errors}) {
      const CellSetErrors got = kernel(field.arrays(), &sigma[first], set.bits.data(), field.rows, set.words);
      EXPECT_TRUE(variance.may_be(got.variance)) << got.variance;
      EXPECT_TRUE(q4.may_be(got.q4)) << got.q4;
    }
  });
}

// ---- one row of numbers ----

TEST_P(CellSets, ValuesBelowALimit) {
  const std::vector<float> values = {0.0F,      1.0F, kNone, 2.0F, 1.0F, 0.5F,  kNone, 3.0F, 1.0F, 0.0F, 2.0F,
                                     0x1p-100F, 1.0F, kNone, 7.0F, 1.0F, 0.25F, 1.0F,  2.0F, 1.0F, kNone};
  for (const auto kernel : {count_less, ref::count_less}) {
    for (std::size_t count = 0; count <= values.size(); ++count) {
      for (const float limit : {0.0F, 0x1p-100F, 1.0F, 1.5F, kNone}) {
        const auto less = std::count_if(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(count),
                                        [=](float value) { return value < limit; });
        EXPECT_EQ(kernel(values.data(), count, limit), static_cast<std::size_t>(less));
      }
    }
  }
}

void expect_untouched(const std::vector<float>& values, std::size_t first) {
  EXPECT_TRUE(std::all_of(values.begin() + static_cast<std::ptrdiff_t>(first), values.end(),
                          [](float value) { return value == kUntouched; }));
}

TEST_P(CellSets, DifferencesFromTheMeanOfNeighbours) {
  std::size_t full = 0;
  for_random_fields(3, [&](const Field& field, RandomStream& random) {
    constexpr float kLeast = 20.0F;
    const std::size_t first = field.at(1, 0);
    for (const std::ptrdiff_t step : {std::ptrdiff_t{1}, field.stride}) {
      std::vector<float> n(field.slack.size()), q = field.fields[3];
      for (std::size_t i = 0; i < n.size(); ++i) {
        n[i] = random.below(8) == 0 ? kLeast - 1.0F : kLeast + static_cast<float>(random.below(2));
        if (n[i] < kLeast) q[i] = kNaN;
      }
      for (const auto kernel : {measure_differences, ref::measure_differences}) {
        std::vector<float> out(field.cells + Field::kRoom, kUntouched);
        kernel(&n[first], &q[first], &field.shape[first], field.cells, step, kLeast, out.data());
        expect_untouched(out, field.cells);
        for (std::size_t c = 0; c < field.cells; ++c) {
          const std::size_t i = first + c;
          const std::size_t before = i - static_cast<std::size_t>(step);
          const std::size_t after = i + static_cast<std::size_t>(step);
          if (std::min({n[before], n[i], n[after]}) < kLeast) {
            EXPECT_EQ(out[c], kNone);
            continue;
          }
          ++full;
          Rounded difference = Rounded(q[i]) - Rounded(0.5F) * (Rounded(q[before]) + q[after]);
          difference.value = std::abs(difference.value);
          EXPECT_TRUE((difference / field.shape[i]).may_be(out[c]))
              << c << ": " << out[c] << ", not " << difference / field.shape[i];
        }
      }
    }
  });
  EXPECT_GT(full, 1000U);
}

// ---- blocks ----

constexpr CellBlock kBlocks[] = {{3, 3, 1, 1, 7}, {2, 2, 1, 1, 4}, {2, 3, 0, 1, 3}, {1, 1, 0, 0, 1}};

/// The mean squared residual of the plane through a block; nothing where its cells are too few.
std::optional<Rounded> residual_of(const Field& field, std::size_t centre, const CellBlock& block, double roundings = 0.0) {
  const Rounded spread = (kWhole * kWhole - 1.0F) / 12.0F;
  const auto value = [&](std::size_t k, std::size_t i) { return Rounded(field.fields[k][i], roundings); };
  enum : std::size_t { kN, kU, kV, kR, kUU, kUV, kVV, kUR, kVR, kRR };
  std::vector<std::vector<Rounded>> terms(10);
  for (int y = -block.up; y < block.rows - block.up; ++y) {
    for (int x = -block.left; x < block.columns - block.left; ++x) {
      const std::size_t j = centre + static_cast<std::size_t>(y * field.stride + x);
      if (field.weight[j] == 0.0F) continue;
      const Rounded up = kWhole * static_cast<float>(x);
      const Rounded vp = kWhole * static_cast<float>(y);
      const Rounded off = value(3, j) - value(3, centre) - value(7, centre) * up - value(8, centre) * vp;
      const Rounded a = value(7, j) - value(7, centre);
      const Rounded b = value(8, j) - value(8, centre);
      terms[kN].emplace_back(1.0F);
      terms[kU].push_back(up);
      terms[kV].push_back(vp);
      terms[kR].push_back(off);
      terms[kUU].push_back(spread + up * up);
      terms[kUV].push_back(up * vp);
      terms[kVV].push_back(spread + vp * vp);
      for (const Rounded& term : {spread * a, up * off}) terms[kUR].push_back(term);
      for (const Rounded& term : {spread * b, vp * off}) terms[kVR].push_back(term);
      for (const Rounded& term : {value(9, j) + spread * (a * a + b * b), off * off}) terms[kRR].push_back(term);
    }
  }
  if (field.weight[centre] == 0.0F || terms[kN].size() < static_cast<std::size_t>(block.least)) return std::nullopt;
  std::vector<Rounded> s;
  for (const auto& of_one : terms) s.push_back(testing::sum(of_one));
  const Rounded per_n = Rounded(1.0F) / s[kN];
  const Rounded u = s[kU] * per_n, v = s[kV] * per_n, r = s[kR] * per_n;
  const Rounded uu = s[kUU] - u * s[kU], uv = s[kUV] - u * s[kV], vv = s[kVV] - v * s[kV];
  const Rounded ur = s[kUR] - u * s[kR], vr = s[kVR] - v * s[kR], rr = s[kRR] - r * s[kR];
  const Rounded explained = ((vv * ur - uv * vr) * ur + (uu * vr - uv * ur) * vr) / (uu * vv - uv * uv);
  return testing::larger(rr - explained, 0.0F) * per_n;
}

TEST_P(CellSets, FlatnessOfBlocks) {
  std::size_t flat = 0, uneven = 0, few = 0, open = 0;
  for_random_fields(2, [&](Field& field, RandomStream& random) {
    constexpr float kMostNoise = 0.5F * static_cast<float>(kNear * kNear);
    constexpr float kMostM = 2.0F * static_cast<float>(kNear * kNear);
    for (std::size_t i = 0; i < field.slack.size(); ++i) {
      field.weight[i] = random.below(6) == 0 ? 0.0F : 1.0F;
      if (field.weight[i] == 0.0F) field.spoil(i);
    }
    for (const CellBlock& block : kBlocks) {
      for (std::size_t row = 0; row < 2; ++row) {
        for (const auto kernel : {measure_blocks, ref::measure_blocks}) {
          std::vector<float> out(field.cells + Field::kRoom, kUntouched);
          kernel(field.arrays(row), field.from(field.weight, row), field.from(field.shape, row), field.cells, block, kMostNoise,
                 kMostM, out.data());
          expect_untouched(out, field.cells);
          for (std::size_t c = 0; c < field.cells; ++c) {
            const std::size_t i = field.at(row, c);
            const std::optional<Rounded> residual = residual_of(field, i, block);
            if (!residual) {
              ++few;
              EXPECT_EQ(out[c], kNotFlat) << c;
              continue;
            }
            const Rounded shape = Rounded(field.shape[i]) * field.shape[i];
            const Rounded q = Rounded(field.fields[3][i]) * field.fields[3][i];
            const Verdict is_flat = at_most(*residual, Rounded(kMostNoise) * shape + Rounded(kMostM) * (q * q));
            ++(!is_flat ? open : *is_flat ? flat : uneven);
            if (is_flat == false) {
              EXPECT_EQ(out[c], kNotFlat) << c;
            } else if (is_flat == true) {
              EXPECT_TRUE((*residual / shape).may_be(out[c])) << c << ": " << out[c] << ", not " << *residual / shape;
            }
          }
        }
      }
    }
  });
  for (const std::size_t count : {flat, uneven, few}) EXPECT_GT(count, 500U);
  EXPECT_LT(open, (flat + uneven) / 500);
}

/// All blocks of an exact plane are flat to the last bit, but for those that lack cells.
TEST_P(CellSets, BlocksOfAnExactPlane) {
  for (const std::size_t cells : kWidths) {
    Field field = exact_field(3, cells);
    const std::size_t hole = cells / 2;
    field.weight[field.at(1, hole)] = 0.0F;
    field.spoil(field.at(1, hole));
    for (const int least : {8, 9}) {
      for (const auto kernel : {measure_blocks, ref::measure_blocks}) {
        std::vector<float> out(cells + Field::kRoom, kUntouched);
        kernel(field.arrays(1), field.from(field.weight, 1), field.from(field.shape, 1), cells, {3, 3, 1, 1, least}, 0.0F, 0.0F,
               out.data());
        expect_untouched(out, cells);
        for (std::size_t c = 0; c < cells; ++c) {
          const std::size_t away = c > hole ? c - hole : hole - c;
          EXPECT_EQ(out[c], away == 0 || (away == 1 && least == 9) ? kNotFlat : 0.0F) << c;
        }
      }
    }
  }
}

/// Full cells: the residual of the least-squares plane through all pixels of a block.
TEST_P(CellSets, FlatnessIsThatOfPixels) {
  RandomStream random = testing::test_random();
  for (int repetition = 0; repetition < 8; ++repetition) {
    const Pixels pixels(3, 3, false, random);
    Eigen::Matrix3d normal = Eigen::Matrix3d::Zero();
    Eigen::Vector3d right = Eigen::Vector3d::Zero();
    double squared = 0.0;
    pixels.for_each([&](double u, double v, double q) {
      const Eigen::Vector3d place(1.0, u - 11.5, v - 11.5);
      const double r = q - Pixels::on_plane(11, 11);
      normal += place * place.transpose();
      right += r * place;
      squared += r * r;
    });
    const double expected = (squared - right.dot(normal.inverse() * right)) / normal(0, 0);
    const std::optional<Rounded> bound = residual_of(pixels.field, pixels.field.at(1, 1), kBlocks[0], kRoundingsOfMoments);
    ASSERT_TRUE(bound);
    const double error = bound->error;
    EXPECT_LT(error, 0.01 * expected);
    for (const auto kernel : {measure_blocks, ref::measure_blocks}) {
      float out = 0.0F;
      const Field& field = pixels.field;
      kernel({field.arrays(1).n + 1, field.arrays(1).u + 1, field.arrays(1).v + 1, field.arrays(1).q + 1, field.arrays(1).uu + 1,
              field.arrays(1).uv + 1, field.arrays(1).vv + 1, field.arrays(1).du + 1, field.arrays(1).dv + 1,
              field.arrays(1).residual + 1, field.stride},
             field.from(field.weight, 1) + 1, field.from(field.shape, 1) + 1, 1, kBlocks[0], 1.0F, 0.0F, &out);
      EXPECT_NEAR(d(out), expected, error);
    }
  }
}

// ---- pixels of a run ----

TEST_P(CellSets, PixelsOfARun) {
  RandomStream random = testing::test_random();
  std::size_t own = 0, planes = 0, bounded = 0;
  for (int repetition = 0; repetition < 16; ++repetition) {
    for (const std::size_t cells : kWidths) {
      // From a plane near to the cells to one that leaves them, past its horizon.
      const auto on_plane = static_cast<float>(uniform(random, 0.3, 1.0));
      const auto du = static_cast<float>(uniform(random, -1.5, 0.5) / static_cast<double>(kCell * cells));
      constexpr float kLeast = 0.35F;
      std::vector<std::uint8_t> count(cells + Field::kRoom, 255);
      std::vector<float> q(cells + Field::kRoom, kNaN);
      std::vector<std::vector<Rounded>> terms(4);
      for (std::size_t i = 0; i < cells; ++i) {
        count[i] = static_cast<std::uint8_t>(random.below(65));
        const Rounded u = kWhole * static_cast<float>(i);
        const Rounded expected = Rounded(du) * u + on_plane;
        Verdict is_near;  // drawn until rounding does not decide
        while (!is_near) {
          q[i] = static_cast<float>(uniform(random, 0.1, 1.0));
          is_near = at_most(Rounded(kHorizon) * q[i], expected);
        }
        const Rounded chosen = *is_near ? expected : Rounded(q[i]);
        ++(*is_near ? planes : own);
        if (chosen.value < d(kLeast)) ++bounded;
        const Rounded depth = Rounded(1.0F) / testing::larger(chosen, kLeast);
        const Rounded pixels = static_cast<float>(count[i]);
        const Rounded weighted = pixels * depth;
        const Rounded products[] = {pixels, weighted, weighted * u, weighted * (depth * depth)};
        for (std::size_t k = 0; k < 4; ++k) terms[k].push_back(products[k]);
      }
      for (const auto kernel : {sum_pixels, ref::sum_pixels}) {
        const PixelSums got = kernel(count.data(), q.data(), cells, on_plane, du, kLeast);
        EXPECT_TRUE(agree({got.n, got.z, got.zu, got.zzz},
                          {testing::sum(terms[0]), testing::sum(terms[1]), testing::sum(terms[2]), testing::sum(terms[3])}))
            << cells;
      }
    }
  }
  for (const std::size_t some : {own, planes, bounded}) EXPECT_GT(some, 300U);
}

TEST_P(CellSets, PixelsAtTwoMetres) {
  for (const std::size_t cells : kWidths) {
    std::vector<std::uint8_t> count(cells, 3);
    std::vector<float> q(cells, 0.5F);
    count.resize(cells + Field::kRoom, 255);
    q.resize(cells + Field::kRoom, kNaN);
    const auto n = static_cast<float>(3 * cells);
    const auto columns = static_cast<float>(3 * kCell * cells * (cells - 1) / 2);
    for (const auto kernel : {sum_pixels, ref::sum_pixels}) {
      // The plane is there, or beyond its horizon, or near that, so that the cells count.
      for (const float on_plane : {0.5F, -1.0F, 0.25F}) {
        const PixelSums got = kernel(count.data(), q.data(), cells, on_plane, 0.0F, 0.125F);
        EXPECT_EQ(got.n, n);
        EXPECT_EQ(got.z, 2.0F * n);
        EXPECT_EQ(got.zu, 2.0F * columns);
        EXPECT_EQ(got.zzz, 8.0F * n);
      }
      // The plane is nearer; and what is farther than a quarter of a metre counts as there.
      EXPECT_EQ(kernel(count.data(), q.data(), cells, 1.0F, 0.0F, 0.125F).z, n);
      EXPECT_EQ(kernel(count.data(), q.data(), cells, 1.0F, 0.0F, 4.0F).z, 0.25F * n);
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Targets, CellSets, ::testing::ValuesIn(targets()),
                         [](const ::testing::TestParamInfo<std::int64_t>& target) {
                           return std::string(hwy::TargetName(target.param));
                         });

}  // namespace
}  // namespace fransac::kernels
