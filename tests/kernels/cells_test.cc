// SPDX-License-Identifier: Apache-2.0
// The cell kernels, once per instruction set that this machine has, against their scalar truth in double and by hand.
#include "kernels/cells.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <string>
#include <tuple>
#include <type_traits>
#include <vector>

#include "kernels/targets.hpp"
#include "support.hpp"

namespace fransac::kernels {
namespace {

constexpr double kRounding = 0x1p-24;  ///< Of one operation on floats, relative.
std::size_t side = 8;                  ///< Pixels of a cell, of the test that runs.
constexpr std::size_t kNumbersOfCells[] = {0, 1, 7, 8, 9, 16, 21, 80};

template <class Raw>
constexpr float kMetres = std::is_same_v<Raw, float> ? 1.0F : 0.001F;

/// A row of cells; every row of pixels has memory of its own that ends with its last eight pixels and starts at an odd place.
template <class Raw>
class Image {
 public:
  explicit Image(std::size_t num_cells, Raw value = Raw{0})
      : cells(num_cells), memory_(side, std::vector<Raw>(1 + (num_cells * side + 7) / 8 * 8)) {
    for (auto& row : memory_) std::fill_n(row.begin() + 1, num_cells * side, value);
  }
  Raw& at(std::size_t u, std::size_t v) { return memory_[v][1 + u]; }
  [[nodiscard]] Raw at(std::size_t u, std::size_t v) const { return memory_[v][1 + u]; }
  [[nodiscard]] CellRows<Raw> rows() const {
    CellRows<Raw> rows{};
    for (std::size_t v = 0; v < side; ++v) rows.rows[v] = memory_[v].data() + 1;
    return rows;
  }
  [[nodiscard]] double z(std::size_t u, std::size_t v) const {
    return static_cast<double>(at(u, v)) * static_cast<double>(kMetres<Raw>);
  }
  std::size_t cells;

 private:
  std::vector<std::vector<Raw>> memory_;
};

using Image16 = Image<std::uint16_t>;
using Image32 = Image<float>;

class Cells : public ::testing::TestWithParam<std::tuple<std::int64_t, std::size_t>> {
 protected:
  void SetUp() override {
    hwy::SetSupportedTargetsForTest(std::get<0>(GetParam()));
    side = std::get<1>(GetParam());
  }
  void TearDown() override { hwy::SetSupportedTargetsForTest(0); }
};

// ---- moments ----

struct Moments {
  explicit Moments(std::size_t cells) : fields(kFields, std::vector<float>(cells + 1, kUntouched)) {}
  CellMoments pointers() {
    return {fields[0].data(), fields[1].data(), fields[2].data(), fields[3].data(), fields[4].data(),
            fields[5].data(), fields[6].data(), fields[7].data(), fields[8].data(), fields[9].data()};
  }
  struct Cell {
    double n, u, v, q, uu, uv, vv, du, dv, residual;
  };
  [[nodiscard]] Cell of(std::size_t c) const {
    const auto value = [&](std::size_t field) { return static_cast<double>(fields[field][c]); };
    return {value(0), value(1), value(2), value(3), value(4), value(5), value(6), value(7), value(8), value(9)};
  }
  static constexpr std::size_t kFields = 10;
  static constexpr float kUntouched = -7.0F;
  std::vector<std::vector<float>> fields;
};

template <class Raw>
Moments moments_of(const CellKernels<Raw>& kernels, const Image<Raw>& image, float least) {
  Moments moments(image.cells);
  kernels.moments(image.rows(), image.cells, kMetres<Raw>, least, moments.pointers());
  for (const auto& field : moments.fields) EXPECT_EQ(field.back(), Moments::kUntouched);  // not a value beyond the cells
  return moments;
}

template <class Raw>
double largest_inverse_depth(const Image<Raw>& image, std::size_t cell) {
  double largest = 0.0;
  for (std::size_t i = 0; i < side * side; ++i) {
    const double z = image.z(cell * side + i % side, i / side);
    if (z > 0.0) largest = std::max(largest, 1.0 / z);
  }
  return largest;
}

/// Compares a cell with its truth, rounding by rounding.
void expect_near(const Moments::Cell& got, const Moments::Cell& truth, double largest_q) {
  constexpr double e = kRounding;
  ASSERT_EQ(got.n, truth.n);  // exact
  if (truth.n == 0.0) {
    EXPECT_EQ(got.residual, static_cast<double>(kNoFit));
    for (const double value : {got.u, got.v, got.q, got.uu, got.uv, got.vv, got.du, got.dv}) EXPECT_EQ(value, 0.0);
    return;
  }
  // Whole sums times a rounded 1 / n, less 3.5.
  EXPECT_NEAR(got.u, truth.u, 3.0 * e * 7.0);
  EXPECT_NEAR(got.v, truth.v, 3.0 * e * 7.0);
  // Whole numbers times a rounded 1 / n^2.
  EXPECT_NEAR(got.uu, truth.uu, 6.0 * e * truth.uu);
  EXPECT_NEAR(got.uv, truth.uv, 6.0 * e * std::abs(truth.uv) + 1e-15);  // the truth rounds, too
  EXPECT_NEAR(got.vv, truth.vv, 6.0 * e * truth.vv);
  // Four roundings of each value, ten of their sum, two of 1 / n, one of the result as the truth stores it.
  const double q_error = 18.0 * e * truth.q;
  EXPECT_NEAR(got.q, truth.q, q_error);
  // Mean products of position and q, each factor of position below 3.5: roundings of the sum, and of what the mean takes off.
  const double product_error = 3.5 * 40.0 * e * truth.q;
  const double det = truth.uu * truth.vv - truth.uv * truth.uv;
  const double det_error = 20.0 * e * truth.uu * truth.vv / det;  // relative
  const double uq = truth.uu * truth.du + truth.uv * truth.dv;
  const double vq = truth.uv * truth.du + truth.vv * truth.dv;
  const auto slope_error = [&](double along, double across, double along_q, double across_q, double slope) {
    return ((along + std::abs(truth.uv)) * product_error +
            8.0 * e * (across * std::abs(along_q) + std::abs(truth.uv * across_q))) /
               det +
           std::abs(slope) * det_error;
  };
  const double du_error = slope_error(truth.vv, truth.vv, uq, vq, truth.du);
  const double dv_error = slope_error(truth.uu, truth.uu, vq, uq, truth.dv);
  EXPECT_NEAR(got.du, truth.du, du_error);
  EXPECT_NEAR(got.dv, truth.dv, dv_error);
  // A residual is off by the roundings of q and of its place on the plane. An error of the plane, whose residuals are the least
  // squares, counts squared only.
  const double reach = std::abs(truth.q) + 7.0 * (std::abs(truth.du) + std::abs(truth.dv));
  const double own = 4.0 * e * largest_q + 6.0 * e * (largest_q + reach);
  const double all = own + q_error + 7.0 * (du_error + dv_error);
  EXPECT_NEAR(got.residual, truth.residual, 2.0 * std::sqrt(truth.residual) * own + all * all + 16.0 * e * truth.residual);
}

/// Fills a cell in one of many ways.
template <class Raw>
void fill_cell(Image<Raw>& image, std::size_t cell, std::uint32_t kind, RandomStream& random) {
  const double base = testing::uniform(random, 0.15, 2.0);
  const double du = base * testing::uniform(random, -0.02, 0.02);
  const double dv = base * testing::uniform(random, -0.02, 0.02);
  const double noise = 2e-3 * random.uniform();
  const std::size_t one = random.below(static_cast<std::uint32_t>(side));
  const std::uint32_t holes = 1 + random.below(9);  // tenths
  for (std::size_t i = 0; i < side * side; ++i) {
    const std::size_t u = i % side;
    const std::size_t v = i / side;
    const double q = base + du * (static_cast<double>(u) - 3.5) + dv * (static_cast<double>(v) - 3.5) + noise * random.normal();
    const auto depth = static_cast<Raw>(1.0 / std::max(q, 0.05) / static_cast<double>(kMetres<Raw>));
    Raw& raw = image.at(cell * side + u, v);
    switch (kind) {
      case 0:
      case 1:
      case 2: raw = depth; break;                                      // full
      case 3: raw = random.below(10) < holes ? Raw{0} : depth; break;  // speckled
      case 4: raw = u + v < one ? Raw{0} : depth; break;               // an edge
      case 5: raw = u == one ? depth : Raw{0}; break;                  // a line
      case 6: raw = v == one ? depth : Raw{0}; break;                  // another
      case 7: raw = u == v ? depth : Raw{0}; break;                    // and another
      case 8: raw = std::is_same_v<Raw, float> ? static_cast<Raw>(65535) : static_cast<Raw>(65535); break;
      case 9: raw = Raw{1}; break;
      case 10: raw = random.below(2) == 0 ? static_cast<Raw>(65535) : Raw{1}; break;
      case 11: raw = u < one ? depth : static_cast<Raw>(depth / Raw{3}); break;  // a depth edge
      case 12: raw = static_cast<Raw>(1 + random.below(65535)); break;           // anything
      default: raw = Raw{0};
    }
  }
}
constexpr std::uint32_t kKinds = 14;

template <class Raw>
Image<Raw> random_image(std::size_t cells, RandomStream& random) {
  Image<Raw> image(cells);
  for (std::size_t c = 0; c < cells; ++c) fill_cell(image, c, random.below(kKinds), random);
  return image;
}

/// Calls check(image) for images of both types and all widths.
template <class Check>
void for_random_images(const Check& check) {
  RandomStream random = testing::test_random();
  for (int repetition = 0; repetition < 4; ++repetition) {
    for (const std::size_t cells : kNumbersOfCells) {
      check(random_image<std::uint16_t>(cells, random));
      check(random_image<float>(cells, random));
    }
  }
}

template <class Raw>
Raw type_of(const Image<Raw>&);
template <class Row>
using RawOf = decltype(type_of(std::declval<Row>()));

TEST_P(Cells, MomentsAreTheTruthsToRounding) {
  for_random_images([](const auto& image) {
    using Raw = RawOf<decltype(image)>;
    for (const float least : {0.0F, 3.0F, 32.0F, 64.0F}) {
      const Moments got = moments_of(cell_kernels<Raw>(static_cast<int>(side)), image, least);
      const Moments truth = moments_of(ref::cell_kernels<Raw>(static_cast<int>(side)), image, least);
      for (std::size_t c = 0; c < image.cells; ++c) expect_near(got.of(c), truth.of(c), largest_inverse_depth(image, c));
    }
  });
}

/// Those of cells without a plane too.
TEST_P(Cells, MomentsReturnTheNumberOfMeasurements) {
  for_random_images([](const auto& image) {
    using Raw = RawOf<decltype(image)>;
    std::size_t measured = 0;
    for (std::size_t u = 0; u < image.cells * side; ++u) {
      for (std::size_t v = 0; v < side; ++v) measured += image.at(u, v) != Raw{0} ? 1U : 0U;
    }
    for (const float least : {0.0F, 32.0F, 65.0F}) {
      for (const auto* kernels : {&cell_kernels<Raw>(static_cast<int>(side)), &ref::cell_kernels<Raw>(static_cast<int>(side))}) {
        Moments moments(image.cells);
        EXPECT_EQ(kernels->moments(image.rows(), image.cells, kMetres<Raw>, least, moments.pointers()), measured);
      }
    }
  });
}

/// Float rows of planes in inverse depth: all that is left are roundings of depth and of its inverse.
TEST_P(Cells, ExactPlanesLeaveNoResidual) {
  RandomStream random = testing::test_random();
  constexpr std::size_t kWidth = 40;
  Image32 image(kWidth);
  for (std::size_t c = 0; c < kWidth; ++c) {
    const double base = testing::uniform(random, 0.15, 2.0);
    const double du = base * testing::uniform(random, -0.05, 0.05);
    const double dv = base * testing::uniform(random, -0.05, 0.05);
    for (std::size_t i = 0; i < side * side; ++i) {
      const double q =
          base + du * (static_cast<double>(i % side) - 3.5) + dv * (static_cast<double>(i / side) - 3.5);  // NOLINT: whole
      const bool hole = side > 2 && c % 2 == 1 && random.below(3) == 0;
      image.at(c * side + i % side, i / side) = hole ? 0.0F : static_cast<float>(1.0 / q);
    }
  }
  const Moments got = moments_of(cell_kernels<float>(static_cast<int>(side)), image, 16.0F);
  const Moments truth = moments_of(ref::cell_kernels<float>(static_cast<int>(side)), image, 16.0F);
  for (std::size_t c = 0; c < kWidth; ++c) {
    const Moments::Cell cell = got.of(c);
    ASSERT_GT(cell.n, 0.0);
    EXPECT_LE(std::sqrt(cell.residual), 2.5e-7 * cell.q) << c;
    EXPECT_NEAR(cell.du, truth.of(c).du, 2.5e-7 * cell.q) << c;
    EXPECT_NEAR(cell.dv, truth.of(c).dv, 2.5e-7 * cell.q) << c;
  }
}

TEST_P(Cells, EveryPixelOfACellCounts) {
  const auto check = [](auto one) {
    using Raw = decltype(one);
    for (std::size_t hole = 0; hole < side * side; ++hole) {
      Image<Raw> image(3, Raw{2});
      image.at(side + hole % side, hole / side) = Raw{0};
      const Moments got = moments_of(cell_kernels<Raw>(static_cast<int>(side)), image, 1.0F);
      const auto pixels = static_cast<double>(side * side);
      const double samples = 8.0 / static_cast<double>(side);  // in the length of a pixel
      const double centre = 0.5 * static_cast<double>(side - 1);
      EXPECT_EQ(got.of(0).n, 64.0);
      EXPECT_EQ(got.of(1).n, 64.0 - samples * samples);
      EXPECT_NEAR(got.of(1).u, samples * (centre - static_cast<double>(hole % side)) / (pixels - 1.0), 1e-6);
      EXPECT_NEAR(got.of(1).v, samples * (centre - static_cast<double>(hole / side)) / (pixels - 1.0), 1e-6);  // NOLINT: whole
      EXPECT_EQ(got.of(2).uu, samples * samples * (pixels - 1.0) / 12.0);
      EXPECT_EQ(got.of(2).uv, 0.0);
      EXPECT_EQ(got.of(2).vv, samples * samples * (pixels - 1.0) / 12.0);
    }
  };
  check(std::uint16_t{});
  check(float{});
}

/// What no sensor measures: depths whose inverse, or its square, is no float.
TEST_P(Cells, AbsurdDepthsGiveNoFit) {
  for (const float depth : {1e-14F, 1e-30F, std::numeric_limits<float>::denorm_min()}) {
    Image32 image(9, 1.0F);
    for (std::size_t c = 0; c < 9; c += 2) image.at(c * side + c % side, side - 1) = depth;
    for (const auto* kernels :
         {&cell_kernels<float>(static_cast<int>(side)), &ref::cell_kernels<float>(static_cast<int>(side))}) {
      const Moments got = moments_of(*kernels, image, 1.0F);
      for (std::size_t c = 0; c < 9; ++c) {
        for (const auto& field : got.fields) EXPECT_TRUE(std::isfinite(field[c]));
      }
      EXPECT_EQ(got.of(1).n, 64.0);
      if (depth < 1e-20F) {
        EXPECT_EQ(got.of(2).n, 0.0);
      }
    }
  }
}

// ---- labels ----

constexpr std::uint8_t kUntouched = 77;

/// Labels and evidence of the cells [first, first + cells) of an image.
template <class Raw>
struct Labelled {
  Labelled(const CellKernels<Raw>& kernels, const Image<Raw>& image, std::size_t first, std::size_t cells, float metres,
           const std::vector<CellPlane>& planes, const CellTolerance& tolerance)
      : labels(side, std::vector<std::uint8_t>(1 + image.cells * side, kUntouched)),
        counts(planes.size(), std::vector<std::uint8_t>(cells + 1, kUntouched)),
        evidence(planes.size()) {
    std::vector<std::uint8_t*> rows;
    for (auto& row : labels) rows.push_back(row.data());
    for (std::size_t p = 0; p < planes.size(); ++p) evidence[p] = {counts[p].data(), -1.0F};
    if (planes.empty()) {
      kernels.label_none(image.rows(), first, cells, rows.data());
    } else {
      kernels.label(image.rows(), first, cells, metres, planes.data(), planes.size(), tolerance, rows.data(), evidence.data());
    }
    for (const auto& count : counts) EXPECT_EQ(count.back(), kUntouched);
    for (const auto& row : labels) {
      EXPECT_TRUE(std::all_of(row.begin(), row.begin() + static_cast<std::ptrdiff_t>(first * side),
                              [](std::uint8_t label) { return label == kUntouched; }));
      EXPECT_TRUE(std::all_of(row.begin() + static_cast<std::ptrdiff_t>((first + cells) * side), row.end(),
                              [](std::uint8_t label) { return label == kUntouched; }));
    }
  }
  std::vector<std::vector<std::uint8_t>> labels;
  std::vector<std::vector<std::uint8_t>> counts;
  std::vector<CellRunEvidence> evidence;
};

/// An image of planes that compete everywhere. No pixel is so near a threshold, or to two planes, that rounding decides.
template <class Raw>
struct Contest {
  Contest(RandomStream& random, std::size_t cells, std::size_t num_planes, float floor_m) : image(cells), floor(floor_m) {
    for (std::size_t p = 0; p < num_planes; ++p) {
      const double base = testing::uniform(random, 0.3, 0.32);
      planes.push_back({static_cast<float>(base), static_cast<float>(testing::uniform(random, -1e-4, 1e-4)),
                        static_cast<float>(testing::uniform(random, -1e-3, 1e-3)), static_cast<std::uint8_t>(254 - 2 * p)});
    }
    for (std::size_t c = 0; c < cells + 8; ++c) per_cell.push_back(static_cast<float>(testing::uniform(random, 1e-3, 5e-3)));
    for (std::size_t c = 0; c < cells; ++c) {
      const std::uint32_t holes =
          std::min(10U, 5U * random.below(4) / 2U);  // tenths: many cells without one, some with nothing else
      for (std::size_t i = 0; i < side * side; ++i) {
        const std::size_t u = c * side + i % side;
        const std::size_t v = i / side;
        if (random.below(10) < holes) continue;
        for (int tries = 0; tries < 20; ++tries) {  // where two planes meet none may do
          image.at(u, v) = draw(random, u, v);
          if (!undecided(u, v)) break;
          image.at(u, v) = Raw{0};
        }
      }
    }
  }

  [[nodiscard]] CellTolerance tolerance() const { return {per_cell.data(), floor}; }
  [[nodiscard]] static double at(const CellPlane& plane, std::size_t u, std::size_t v) {
    return static_cast<double>(plane.base) + static_cast<double>(plane.du) * static_cast<double>(u) +
           static_cast<double>(plane.dv) * static_cast<double>(v);
  }
  /// z q - 1 in float: six roundings of the terms, one of the sum.
  [[nodiscard]] double rounding(std::size_t u, std::size_t v) const {
    double reach = 0.0;
    for (const CellPlane& plane : planes) {
      reach = std::max(reach, std::abs(static_cast<double>(plane.base)) +
                                  std::abs(static_cast<double>(plane.du)) * static_cast<double>(u) +
                                  std::abs(static_cast<double>(plane.dv)) * static_cast<double>(v));
    }
    return kRounding * (6.0 * image.z(u, v) * reach + 1.0);
  }

  Image<Raw> image;
  std::vector<CellPlane> planes;
  std::vector<float> per_cell;
  float floor;

 private:
  Raw draw(RandomStream& random, std::size_t u, std::size_t v) const {
    const auto plane = random.below(static_cast<std::uint32_t>(planes.size()));
    const double z = 1.0 / (at(planes[plane], u, v) + 3.0 * testing::uniform(random, -1.0, 1.0) * 5e-3);
    return static_cast<Raw>(random.below(8) == 0 ? testing::uniform(random, 0.5, 60.0) / static_cast<double>(kMetres<Raw>)
                                                 : z / static_cast<double>(kMetres<Raw>));
  }
  [[nodiscard]] bool undecided(std::size_t u, std::size_t v) const {
    const double z = image.z(u, v);
    const double error = rounding(u, v);
    double nearest = std::numeric_limits<double>::infinity();
    double second = nearest;
    for (const CellPlane& plane : planes) {
      const double residual = std::abs(z * at(plane, u, v) - 1.0);
      second = std::min(second, std::max(residual, nearest));
      nearest = std::min(nearest, residual);
    }
    const double bound = static_cast<double>(per_cell[u / side]) * z * z + static_cast<double>(floor);
    // The tolerance rounds three times more, and so does what is left of the residual.
    const bool at_threshold = std::abs(nearest * z - bound) <= error * z + 6.0 * kRounding * (bound + nearest * z);
    return at_threshold || second - nearest <= 2.0 * error;
  }
};

/// Runs of cells that start and end anywhere in an image.
struct Stretch {
  std::size_t cells_of_image, first, cells;
};
constexpr Stretch kStretches[] = {{1, 0, 1}, {5, 0, 5}, {5, 1, 3}, {5, 4, 1}, {80, 0, 80}, {80, 13, 40}};

template <class Raw>
void expect_labels_of_the_truth(const Contest<Raw>& contest, const Stretch& run) {
  const auto& [image, planes, per_cell, floor] = contest;
  const Labelled<Raw> got(cell_kernels<Raw>(static_cast<int>(side)), image, run.first, run.cells, kMetres<Raw>, planes,
                          contest.tolerance());
  const Labelled<Raw> truth(ref::cell_kernels<Raw>(static_cast<int>(side)), image, run.first, run.cells, kMetres<Raw>, planes,
                            contest.tolerance());
  EXPECT_EQ(got.labels, truth.labels);
  EXPECT_EQ(got.counts, truth.counts);
  for (std::size_t p = 0; p < planes.size(); ++p) {
    double squared = 0.0;
    double error = 0.0;
    double pixels = 0.0;
    for (std::size_t u = run.first * side; u < (run.first + run.cells) * side; ++u) {
      for (std::size_t v = 0; v < side; ++v) {
        if (truth.labels[v][u] != planes[p].label) continue;
        const double residual = image.z(u, v) * contest.at(planes[p], u, v) - 1.0;
        const double rounding = contest.rounding(u, v);
        squared += residual * residual;
        error += 2.0 * std::abs(residual) * rounding + rounding * rounding;
        ++pixels;
      }
    }
    // Every addition rounds, and so does a square.
    error += kRounding * (pixels + 4.0) * squared;
    EXPECT_NEAR(static_cast<double>(got.evidence[p].squared_residual), squared, error);
    EXPECT_NEAR(static_cast<double>(truth.evidence[p].squared_residual), squared, error);
  }
}

TEST_P(Cells, LabelsAreTheTruths) {
  RandomStream random = testing::test_random();
  for (const std::size_t num_planes : {1U, 2U, 3U, 9U}) {
    for (const float floor : {0.0F, 0.005F}) {
      for (const Stretch& run : kStretches) {
        expect_labels_of_the_truth(Contest<std::uint16_t>(random, run.cells_of_image, num_planes, floor), run);
        expect_labels_of_the_truth(Contest<float>(random, run.cells_of_image, num_planes, floor), run);
      }
    }
  }
}

TEST_P(Cells, FitsAreTheTruths) {
  RandomStream random = testing::test_random();
  const auto check = [](const auto& contest) {
    using Raw = RawOf<decltype(contest.image)>;
    std::uint32_t fitting = 0;
    for (std::size_t c = 0; c < contest.image.cells; ++c) {
      const auto got = cell_kernels<Raw>(static_cast<int>(side))
                           .fits(contest.image.rows(), c, kMetres<Raw>, contest.planes[0], contest.tolerance());
      const auto truth = ref::cell_kernels<Raw>(static_cast<int>(side))
                             .fits(contest.image.rows(), c, kMetres<Raw>, contest.planes[0], contest.tolerance());
      EXPECT_EQ(got.fitting, truth.fitting);
      EXPECT_EQ(got.measured, truth.measured);
      fitting += truth.fitting;
    }
    EXPECT_GT(fitting, 0U);
  };
  for (int repetition = 0; repetition < 8; ++repetition) {
    check(Contest<std::uint16_t>(random, 20, 1, 0.005F));
    check(Contest<float>(random, 20, 1, 0.005F));
  }
}

TEST_P(Cells, LabelNoneTellsMeasurementsFromHoles) {
  for_random_images([](const auto& image) {
    using Raw = RawOf<decltype(image)>;
    for (std::size_t first = 0; first < image.cells; first += 3) {
      const std::size_t cells = std::min<std::size_t>(image.cells - first, 5);
      for (const auto* kernels : {&cell_kernels<Raw>(static_cast<int>(side)), &ref::cell_kernels<Raw>(static_cast<int>(side))}) {
        const Labelled<Raw> got(*kernels, image, first, cells, kMetres<Raw>, {}, {});
        for (std::size_t u = first * side; u < (first + cells) * side; ++u) {
          for (std::size_t v = 0; v < side; ++v) EXPECT_EQ(got.labels[v][u], image.at(u, v) == Raw{0} ? 0 : 255);
        }
      }
    }
  });
}

/// One measurement in three cells, wherever it is.
TEST_P(Cells, EveryPixelIsLabelled) {
  const auto check = [](auto zero) {
    using Raw = decltype(zero);
    constexpr std::size_t kWidth = 3;
    const float per_cell[kWidth + 8] = {};
    for (std::size_t pixel = 0; pixel < kWidth * side * side; ++pixel) {
      const std::size_t u = pixel / side;
      const std::size_t v = pixel % side;
      Image<Raw> image(kWidth);
      image.at(u, v) = Raw{2};
      // q = 1/2 at that pixel alone, and 5/8 there: residuals 0 and 1/4.
      const auto plane = [&](float q, std::uint8_t label) {
        return CellPlane{q - static_cast<float>(u) - 16.0F * static_cast<float>(v), 1.0F, 16.0F, label};
      };
      for (const std::size_t num_planes : {1U, 2U, 4U}) {
        std::vector<CellPlane> planes(num_planes - 1, plane(0.625F, 3));
        planes.push_back(plane(0.5F, 9));
        const Labelled<Raw> got(cell_kernels<Raw>(static_cast<int>(side)), image, 0, kWidth, 1.0F, planes, {per_cell, 0.25F});
        for (std::size_t i = 0; i < kWidth * side * side; ++i) {
          EXPECT_EQ(got.labels[i % side][i / side], i == pixel ? 9 : 0);
        }
        for (std::size_t p = 0; p < num_planes; ++p) {
          for (std::size_t c = 0; c < kWidth; ++c) EXPECT_EQ(got.counts[p][c], p + 1 == num_planes && c == u / side ? 1 : 0);
          EXPECT_EQ(got.evidence[p].squared_residual, 0.0F);
        }
      }
      const auto fits =
          cell_kernels<Raw>(static_cast<int>(side)).fits(image.rows(), u / side, 1.0F, plane(0.625F, 1), {per_cell, 0.5F});
      EXPECT_EQ(fits.fitting, 1U);  // 1/4 x 2 m on the border
      EXPECT_EQ(fits.measured, 1U);
    }
  };
  check(std::uint16_t{});
  check(float{});
}

/// All numbers are exact here: borders belong to the plane, and of equally near planes the first has a pixel.
TEST_P(Cells, BordersAndTies) {
  const auto check = [](auto zero) {
    using Raw = decltype(zero);
    const Image<Raw> image(2, Raw{2});  // 1 m at half a metre per unit
    constexpr float kHalf = 0.5F;
    const float per_cell[2 + 8] = {0.125F, 0.125F - 0x1p-20F};
    const CellPlane above{1.25F, 0.0F, 0.0F, 5};  // 1/4
    const CellPlane below{0.75F, 0.0F, 0.0F, 4};  // -1/4
    const CellPlane nearer{1.125F, 0.0F, 0.0F, 3};
    const CellPlane far{3.0F, 0.0F, 0.0F, 2};
    const struct {
      std::vector<CellPlane> planes;
      std::uint8_t label_0, label_1;
    } cases[] = {{{above}, 5, 255},
                 {{below}, 4, 255},
                 {{far}, 255, 255},
                 {{above, below}, 5, 255},
                 {{below, above}, 4, 255},
                 {{above, nearer}, 3, 3},
                 {{far, above}, 5, 255},
                 {{far, far, below}, 4, 255},
                 {{above, below, above}, 5, 255},
                 {{far, below, above}, 4, 255}};
    for (const auto& [planes, label_0, label_1] : cases) {
      for (const auto* kernels : {&cell_kernels<Raw>(static_cast<int>(side)), &ref::cell_kernels<Raw>(static_cast<int>(side))}) {
        const Labelled<Raw> got(*kernels, image, 0, 2, kHalf, planes, {per_cell, 0.125F});
        for (std::size_t u = 0; u < 2 * side; ++u) {
          for (std::size_t v = 0; v < side; ++v) EXPECT_EQ(got.labels[v][u], u < side ? label_0 : label_1);
        }
      }
    }
  };
  check(std::uint16_t{});
  check(float{});
}

INSTANTIATE_TEST_SUITE_P(Targets, Cells, ::testing::Combine(::testing::ValuesIn(targets()), ::testing::Values(8U, 4U, 2U)),
                         [](const ::testing::TestParamInfo<Cells::ParamType>& run) {
                           return std::string(hwy::TargetName(std::get<0>(run.param))) + "_" +
                                  std::to_string(std::get<1>(run.param));
                         });

}  // namespace
}  // namespace fransac::kernels
