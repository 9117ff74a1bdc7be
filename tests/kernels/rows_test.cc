// SPDX-License-Identifier: Apache-2.0
// The row kernels, once per instruction set that this machine has: against their scalar twins, exactly; those that round,
// together with their twins, against the same sums in double as well.
#include "kernels/rows.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <tuple>
#include <type_traits>
#include <vector>

#include "fransac/core/aligned.hpp"
#include "kernels/targets.hpp"
#include "support.hpp"

namespace fransac::kernels {
namespace {

constexpr std::size_t kSizes[] = {0,           kBlock,      2 * kBlock,  3 * kBlock,  15 * kBlock,
                                  17 * kBlock, 40 * kBlock, 64 * kBlock, 128 * kBlock};
constexpr std::size_t kOffsets[] = {0, 1, 3};  // nothing need be aligned

/// Metres per raw value.
template <class Raw>
constexpr double kMetres = std::is_same_v<Raw, float> ? 1.0 : 0.001;

/// Values at an odd place in memory.
template <class T>
class Unaligned {
 public:
  Unaligned(std::size_t n, std::size_t offset, T value = T{}) : memory_(n + offset + 1, value), offset_(offset) {}
  T* data() { return memory_.data() + offset_; }
  const T* data() const { return memory_.data() + offset_; }
  T& operator[](std::size_t i) { return data()[i]; }
  T operator[](std::size_t i) const { return data()[i]; }

 private:
  AlignedVector<T> memory_;
  std::size_t offset_;
};

/// A row that shows planes: pixels within twice the threshold of one of them, others anywhere, and holes.
template <class Raw>
struct RandomRow {
  RandomRow(RandomStream& random, std::size_t size, std::size_t offset, std::size_t num_planes)
      : n(size), raw(size, offset), kept(size, offset), ray{-0.6F, static_cast<float>(1.2 / (static_cast<double>(size) + 1.0))} {
    for (std::size_t p = 0; p < num_planes; ++p) {
      // n . r between -1.2 and -0.4 along the row.
      const double base = testing::uniform(random, -1.0, -0.6);
      const double step = testing::uniform(random, -0.2, 0.2) / (static_cast<double>(size) + 1.0);
      const RowPlane plane{{static_cast<float>(base * kMetres<Raw>), static_cast<float>(step * kMetres<Raw>)},
                           static_cast<float>(testing::uniform(random, 0.5, 3.0))};
      planes.push_back({plane, static_cast<std::uint8_t>(1 + p)});
    }
    for (std::size_t u = 0; u < n; ++u) {
      const std::uint32_t kind = random.below(5);
      const std::uint32_t p = random.below(static_cast<std::uint32_t>(num_planes));
      double z = testing::uniform(random, 0.4, 6.0);
      if (kind < 3) {
        const RowPlane& plane = planes[p].plane;
        const double product =
            (static_cast<double>(plane.ramp.base) + static_cast<double>(plane.ramp.step) * static_cast<double>(u)) / kMetres<Raw>;
        z = (testing::uniform(random, -2.0, 2.0) * threshold - static_cast<double>(plane.d)) / product;
      }
      raw[u] = kind == 4 ? Raw{0} : static_cast<Raw>(z / kMetres<Raw>);
      kept[u] = random.below(6) == 0 ? Raw{0} : raw[u];
      largest = std::max(largest, value(u));
    }
  }

  [[nodiscard]] double value(std::size_t u) const { return static_cast<double>(raw[u]); }
  [[nodiscard]] static double at(const Ramp& ramp, std::size_t u) {
    return static_cast<double>(ramp.base) + static_cast<double>(ramp.step) * static_cast<double>(u);
  }
  [[nodiscard]] double distance(const RowPlane& plane, std::size_t u) const {
    return value(u) * at(plane.ramp, u) + static_cast<double>(plane.d);
  }
  /// How far a distance in float can be from that in double: four roundings of 2^-24 each.
  [[nodiscard]] double rounding(const RowPlane& plane) const {
    const double ramp =
        std::abs(static_cast<double>(plane.ramp.base)) + std::abs(static_cast<double>(plane.ramp.step)) * static_cast<double>(n);
    return 0x1p-22 * (largest * ramp + std::abs(static_cast<double>(plane.d)));
  }
  /// Pixels whose distance may fall on either side of the threshold.
  [[nodiscard]] bool undecided(const RowPlane& plane, double at_threshold, std::size_t u) const {
    return std::abs(std::abs(distance(plane, u)) - at_threshold) <= rounding(plane);
  }
  [[nodiscard]] std::uint32_t undecided(const RowPlane& plane, double at_threshold) const {
    std::uint32_t count = 0;
    for (std::size_t u = 0; u < n; ++u) count += static_cast<std::uint32_t>(value(u) > 0.0 && undecided(plane, at_threshold, u));
    return count;
  }

  std::size_t n;
  double threshold = 0.01;
  double largest = 0.0;  ///< Raw value.
  Unaligned<Raw> raw;
  Unaligned<Raw> kept;
  std::vector<LabelPlane> planes;
  Ramp ray;
};

/// What a sum of n floats may be off by, beside the roundings of its terms: every addition rounds, 2^-24 of the sum each.
double summing(std::size_t n, double sum_of_sizes) { return 0x1p-24 * (static_cast<double>(n) + 4.0) * sum_of_sizes; }

class Rows : public ::testing::TestWithParam<std::int64_t> {
 protected:
  void SetUp() override { hwy::SetSupportedTargetsForTest(GetParam()); }
  void TearDown() override { hwy::SetSupportedTargetsForTest(0); }

  /// Calls check(row) for rows of both types, of every size and place in memory.
  template <class Check>
  void for_random_rows(const Check& check, std::size_t num_planes = 1) {
    RandomStream random = testing::test_random();
    for (const std::size_t n : kSizes) {
      for (const std::size_t offset : kOffsets) {
        check(RandomRow<std::uint16_t>(random, n, offset, num_planes));
        check(RandomRow<float>(random, n, offset, num_planes));
      }
    }
  }
};

template <class Raw>
Raw type_of(const RandomRow<Raw>&);
template <class Row>
using RawOf = decltype(type_of(std::declval<Row>()));

TEST_P(Rows, SumsAndLabelsAreThoseOfTheScalarTwins) {
  for_random_rows(
      [](const auto& row) {
        using Raw = RawOf<decltype(row)>;
        const RowKernels<Raw>& own = row_kernels<Raw>();
        const RowKernels<Raw>& twin = ref::row_kernels<Raw>();
        const LabelPlane& one = row.planes.front();
        const RowPlane in_thresholds{{one.plane.ramp.base * 100.0F, one.plane.ramp.step * 100.0F}, one.plane.d * 100.0F};
        const Msac score = own.score(row.raw.data(), row.n, in_thresholds);
        const Msac expected_score = twin.score(row.raw.data(), row.n, in_thresholds);
        EXPECT_EQ(score.inliers, expected_score.inliers);
        EXPECT_EQ(score.gain, expected_score.gain);
        const RowMoments m = own.moments(row.raw.data(), row.n, one.plane, 0.01F, row.ray);
        const RowMoments e = twin.moments(row.raw.data(), row.n, one.plane, 0.01F, row.ray);
        EXPECT_EQ(std::tie(m.count, m.z, m.zz, m.za, m.zza, m.zzaa), std::tie(e.count, e.z, e.zz, e.za, e.zza, e.zzaa));
        std::vector<Raw> left(row.n);
        std::vector<Raw> expected_left(row.n);
        own.remove(row.raw.data(), row.n, in_thresholds, left.data());
        twin.remove(row.raw.data(), row.n, in_thresholds, expected_left.data());
        EXPECT_EQ(left, expected_left);
        std::vector<std::uint8_t> labels(row.n);
        std::vector<std::uint8_t> expected_labels(row.n);
        const auto expect_same_evidence = [&](const RowEvidence& a, const RowEvidence& b) {
          EXPECT_EQ(std::tie(a.count, a.squared_distance, a.cubed_depth), std::tie(b.count, b.squared_distance, b.cubed_depth));
          EXPECT_EQ(labels, expected_labels);
        };
        expect_same_evidence(own.label_one(row.raw.data(), row.kept.data(), row.n, one, 0.01F, labels.data()),
                             twin.label_one(row.raw.data(), row.kept.data(), row.n, one, 0.01F, expected_labels.data()));
        const auto planes = row.planes.size();
        own.label(row.raw.data(), row.kept.data(), row.n, row.planes.data(), planes, 0.01F, labels.data());
        twin.label(row.raw.data(), row.kept.data(), row.n, row.planes.data(), planes, 0.01F, expected_labels.data());
        expect_same_evidence(own.evidence(row.raw.data(), labels.data(), row.n, one),
                             twin.evidence(row.raw.data(), labels.data(), row.n, one));
      },
      3);
}

// ---- exact ones ----

TEST_P(Rows, KeepRange) {
  for_random_rows([](const auto& row) {
    using Raw = RawOf<decltype(row)>;
    const auto unit = static_cast<Raw>(1.0 / kMetres<Raw>);
    std::vector<std::pair<Raw, Raw>> ranges{{Raw{0}, static_cast<Raw>(2 * unit)},
                                            {unit, static_cast<Raw>(3 * unit)},
                                            {static_cast<Raw>(2 * unit), static_cast<Raw>(60 * unit)},
                                            {Raw{1}, Raw{0}}};  // nothing
    if (row.n > 0) ranges.push_back({row.raw[row.n / 2], row.raw[row.n / 2]});
    for (const auto& [min, max] : ranges) {
      Unaligned<Raw> a(row.n, 1, Raw{7});
      Unaligned<Raw> b(row.n, 0, Raw{8});
      row_kernels<Raw>().keep_range(row.raw.data(), row.n, min, max, a.data());
      ref::row_kernels<Raw>().keep_range(row.raw.data(), row.n, min, max, b.data());
      for (std::size_t u = 0; u < row.n; ++u) ASSERT_EQ(a[u], b[u]) << u;
      EXPECT_EQ(a[row.n], Raw{7});  // not a value beyond the row
    }
  });
}

TEST_P(Rows, CountMeasuredAndLargest) {
  for_random_rows([](const auto& row) {
    using Raw = RawOf<decltype(row)>;
    std::size_t measured = 0;
    Raw largest = 0;
    for (std::size_t u = 0; u < row.n; ++u) {
      measured += static_cast<std::size_t>(row.raw[u] > Raw{0});
      largest = std::max(largest, row.raw[u]);
    }
    for (const auto* kernels : {&row_kernels<Raw>(), &ref::row_kernels<Raw>()}) {
      EXPECT_EQ(kernels->count_measured(row.raw.data(), row.n), measured);
      EXPECT_EQ(kernels->largest(row.raw.data(), row.n), largest);
    }
  });
}

TEST_P(Rows, EveryColumnCounts) {
  const auto check = [](auto raw_one) {
    using Raw = decltype(raw_one);
    const RowPlane plane{{-0.5F, 0.0F}, 1.25F};  // distance of raw 2: 0.25
    constexpr std::size_t kColumns = 3 * kBlock;
    const auto& kernels = row_kernels<Raw>();
    for (std::size_t u = 0; u < kColumns; ++u) {
      Unaligned<Raw> row(kColumns, 0);
      row[u] = Raw{2};
      EXPECT_EQ(kernels.count_measured(row.data(), kColumns), 1U);
      EXPECT_EQ(kernels.largest(row.data(), kColumns), Raw{2});
      const Msac msac = kernels.score(row.data(), kColumns, plane);
      EXPECT_EQ(msac.inliers, 1U);
      EXPECT_EQ(msac.gain, 1.0F - 0.0625F);
      const RowMoments m = kernels.moments(row.data(), kColumns, plane, 0.25F, {0.5F, 0.0F});
      EXPECT_EQ(m.count, 1U);
      EXPECT_EQ(m.z, 2.0F);
      EXPECT_EQ(m.zz, 4.0F);
      EXPECT_EQ(m.za, 1.0F);
      EXPECT_EQ(m.zza, 2.0F);
      EXPECT_EQ(m.zzaa, 1.0F);
      Unaligned<std::uint8_t> labels(kColumns, 0, 77);
      const RowEvidence e = kernels.label_one(row.data(), row.data(), kColumns, {plane, 254}, 0.25F, labels.data());
      EXPECT_EQ(e.count, 1U);
      EXPECT_EQ(e.squared_distance, 0.0625F);
      EXPECT_EQ(e.cubed_depth, 8.0F);
      for (std::size_t i = 0; i < kColumns; ++i) EXPECT_EQ(labels[i], i == u ? 254 : 0);
    }
  };
  check(std::uint16_t{});
  check(float{});
}

TEST_P(Rows, RunningSums) {
  RandomStream random = testing::test_random();
  for (const std::size_t n : kSizes) {
    for (const std::size_t offset : kOffsets) {
      for (const bool full : {false, true}) {  // all of the largest value: the sums of products wrap beyond 1000 columns
        Unaligned<std::uint16_t> raw(n, offset, 0xFFFF);
        if (!full) std::generate_n(raw.data(), n, [&] { return static_cast<std::uint16_t>(random.next()); });
        Unaligned<std::uint64_t> a(n + 1, offset, 9);
        Unaligned<std::uint64_t> b(n + 1, 0, 8);
        running_sums(raw.data(), n, a.data());
        ref::running_sums(raw.data(), n, b.data());
        for (std::size_t u = 0; u <= n; ++u) ASSERT_EQ(a[u], b[u]) << u;
      }
    }
  }
}

TEST_P(Rows, DifferencesOfRunningSumsAreExact) {
  constexpr std::size_t kWidth = 2048;
  RandomStream random = testing::test_random();
  Unaligned<std::uint16_t> raw(kWidth, 0);
  std::generate_n(raw.data(), kWidth, [&] { return static_cast<std::uint16_t>(0xFFFF - random.below(100)); });
  Unaligned<std::uint64_t> sums(kWidth + 1, 0);
  running_sums(raw.data(), kWidth, sums.data());
  for (int i = 0; i < 500; ++i) {
    const std::size_t stretch = kSumColumns * random.below(kWidth / kSumColumns);
    const std::size_t first = stretch + random.below(kSumColumns);
    const std::size_t end = first + random.below(static_cast<std::uint32_t>(stretch + kSumColumns - first + 1));
    std::uint64_t d = 0;
    std::uint64_t du = 0;
    for (std::size_t u = first; u < end; ++u) {
      d += raw[u];
      du += raw[u] * (u % kSumColumns);
    }
    const std::uint64_t difference = sums[end] - sums[first];
    EXPECT_EQ(difference & 0xFFFFFFFF, d);
    EXPECT_EQ(difference >> 32, du);
  }
}

/// Leaves of 2 cm as a camera with a focal length of half the row's width sees them, or such that products fall on whole numbers.
template <class Raw>
struct RandomLeaves {
  RandomLeaves(RandomStream& random, std::size_t n, bool on_borders) : ray_x(n, 1) {
    const double focal = 0.5 * static_cast<double>(n) + 1.0;
    for (std::size_t u = 0; u < n; ++u) {
      const double ray = (static_cast<double>(u) - 0.5 * static_cast<double>(n)) / focal;
      ray_x[u] = static_cast<float>(on_borders ? std::round(ray * 4.0) / 4.0 : ray);
    }
    const double leaf = on_borders ? kMetres<Raw> * 0x1p-2 : 0.02;
    row = {.per_unit = static_cast<float>(kMetres<Raw> / leaf),
           .ray_x = ray_x.data(),
           .ray_y = static_cast<float>(on_borders ? -0.75 : testing::uniform(random, -1.0, 1.0)),
           .first = {0x40000, 0x40000, 1},
           .shift_y = 19,
           .shift_z = 25};  // the indices' upper bits may be lost: keys are sums mod 2^32
  }
  Unaligned<float> ray_x;
  LeafRow row{};
};

TEST_P(Rows, LeafRuns) {
  RandomStream random = testing::test_random(1);
  for_random_rows([&](const auto& row) {
    using Raw = RawOf<decltype(row)>;
    for (const bool on_borders : {false, true}) {
      const RandomLeaves<Raw> leaves(random, row.n, on_borders);
      Unaligned<std::uint32_t> keys(row.n + 1, 1, random.next());
      Unaligned<std::uint32_t> keys_ref(row.n + 1, 0, random.next());
      Unaligned<std::uint32_t> starts(row.n + kBlock, 1);
      Unaligned<std::uint32_t> starts_ref(row.n + kBlock, 0);
      const std::size_t runs = row_kernels<Raw>().leaf_runs(row.raw.data(), row.n, leaves.row, keys.data() + 1, starts.data());
      ASSERT_EQ(runs,
                ref::row_kernels<Raw>().leaf_runs(row.raw.data(), row.n, leaves.row, keys_ref.data() + 1, starts_ref.data()));
      for (std::size_t u = 1; u <= row.n; ++u) ASSERT_EQ(keys[u], keys_ref[u]) << u;
      for (std::size_t r = 0; r <= runs; ++r) ASSERT_EQ(starts[r], starts_ref[r]) << r;
    }
  });
}

TEST_P(Rows, LeafRunsByHand) {
  // Leaves of one unit; rays 0, 1/4, 1/2 … : a wall of raw 4 has x = u, one of raw 1 has x = u / 4. Key = x + 64 y + 4096 z.
  const auto check = [](auto raw_one) {
    using Raw = decltype(raw_one);
    Unaligned<Raw> raw(2 * kBlock, 1);
    Unaligned<float> ray_x(2 * kBlock, 0);
    for (std::size_t u = 0; u < 2 * kBlock; ++u) ray_x[u] = 0.25F * static_cast<float>(u);
    for (std::size_t u = 0; u < 6; ++u) raw[u] = Raw{4};
    for (std::size_t u = 8; u < 20; ++u) raw[u] = Raw{1};
    const LeafRow row{.per_unit = 1.0F, .ray_x = ray_x.data(), .ray_y = -0.5F, .first = {1, 3, 1}, .shift_y = 6, .shift_z = 12};
    Unaligned<std::uint32_t> keys(2 * kBlock + 1, 0, 99);
    Unaligned<std::uint32_t> starts(3 * kBlock, 0);
    const std::size_t runs = row_kernels<Raw>().leaf_runs(raw.data(), 2 * kBlock, row, keys.data() + 1, starts.data());
    ASSERT_EQ(runs, 11U);  // six, a hole, three, a hole
    constexpr std::uint32_t kStarts[] = {0, 1, 2, 3, 4, 5, 6, 8, 12, 16, 20, 32};
    for (std::size_t r = 0; r <= runs; ++r) EXPECT_EQ(starts[r], kStarts[r]);
    for (std::uint32_t u = 0; u < 6; ++u) EXPECT_EQ(keys[1 + u], (1 + u) + 64U * (3 - 2) + 4096U * 5);
    for (std::uint32_t u = 8; u < 20; ++u) EXPECT_EQ(keys[1 + u], 1 + u / 4 + 64U * (3 - 1) + 4096U * 2);
    EXPECT_EQ(keys[1 + 6], kNoLeaf);
    EXPECT_EQ(keys[1 + 31], kNoLeaf);
  };
  check(std::uint16_t{});
  check(float{});
}

TEST_P(Rows, LongRunsAreCutEvery256Columns) {
  const auto check = [](auto raw_one) {
    using Raw = decltype(raw_one);
    constexpr std::size_t kWidth = 640;
    const Unaligned<Raw> raw(kWidth, 0, Raw{1});
    const Unaligned<float> ray_x(kWidth, 0, 0.0F);
    const LeafRow row{.per_unit = 0.5F, .ray_x = ray_x.data(), .ray_y = 0.0F, .first = {1, 1, 1}, .shift_y = 6, .shift_z = 12};
    Unaligned<std::uint32_t> keys(kWidth + 1, 0);
    Unaligned<std::uint32_t> starts(kWidth + kBlock, 0);
    ASSERT_EQ(row_kernels<Raw>().leaf_runs(raw.data(), kWidth, row, keys.data() + 1, starts.data()), 3U);
    for (std::uint32_t r = 0; r < 3; ++r) EXPECT_EQ(starts[r], kSumColumns * r);
    EXPECT_EQ(starts[3], kWidth);
  };
  check(std::uint16_t{});
  check(float{});
}

// ---- those that round ----

TEST_P(Rows, Score) {
  for_random_rows([](const auto& row) {
    using Raw = RawOf<decltype(row)>;
    const auto t = static_cast<float>(row.threshold);
    RowPlane plane = row.planes.front().plane;
    plane = {{plane.ramp.base / t, plane.ramp.step / t}, plane.d / t};
    double gain = 0.0;
    double inliers = 0.0;
    for (std::size_t u = 0; u < row.n; ++u) {
      const double r = row.distance(plane, u);
      if (row.value(u) == 0.0 || std::abs(r) > 1.0) continue;
      gain += 1.0 - r * r;
      ++inliers;
    }
    const double undecided = row.undecided(plane, 1.0);
    for (const auto* kernels : {&row_kernels<Raw>(), &ref::row_kernels<Raw>()}) {
      const Msac msac = kernels->score(row.raw.data(), row.n, plane);
      EXPECT_NEAR(msac.inliers, inliers, undecided);
      // 1 - r^2 is off by 2 |r| dr <= 2 dr; a pixel at the threshold gains no more than that.
      EXPECT_NEAR(static_cast<double>(msac.gain), gain,
                  2.0 * row.rounding(plane) * (inliers + undecided) + summing(row.n, gain + undecided));
    }
  });
}

TEST_P(Rows, RemoveLeavesWhatIsNoInlier) {
  for_random_rows([](const auto& row) {
    using Raw = RawOf<decltype(row)>;
    const auto t = static_cast<float>(row.threshold);
    RowPlane plane = row.planes.front().plane;
    plane = {{plane.ramp.base / t, plane.ramp.step / t}, plane.d / t};
    Unaligned<Raw> apart(row.n, 1, Raw{7});
    row_kernels<Raw>().remove(row.raw.data(), row.n, plane, apart.data());
    Unaligned<Raw> in_place(row.n, 1, Raw{7});
    std::copy(row.raw.data(), row.raw.data() + row.n, in_place.data());
    row_kernels<Raw>().remove(in_place.data(), row.n, plane, in_place.data());
    Unaligned<Raw> truth(row.n, 1, Raw{7});
    ref::row_kernels<Raw>().remove(row.raw.data(), row.n, plane, truth.data());
    double different = 0.0;
    for (std::size_t u = 0; u < row.n; ++u) {
      ASSERT_EQ(apart[u], in_place[u]) << u;
      ASSERT_TRUE(apart[u] == row.raw[u] || apart[u] == Raw{0}) << u;
      different += apart[u] != truth[u] ? 1.0 : 0.0;
    }
    EXPECT_LE(different, row.undecided(plane, 1.0));
    EXPECT_EQ(apart[row.n], Raw{7});
  });
}

TEST_P(Rows, TheThresholdItselfIsAnInlier) {
  // Distances of -0.75 … 0.75 in steps of 1/8: exact everywhere.
  const auto check = [](auto raw_one) {
    using Raw = decltype(raw_one);
    Unaligned<Raw> raw(kBlock, 1);
    for (std::size_t u = 0; u < 13; ++u) raw[u] = static_cast<Raw>(2 + u);
    const RowPlane plane{{0.125F, 0.0F}, -1.0F};  // raw / 8 - 1: -6/8 … 6/8
    const RowPlane in_thresholds{{0.25F, 0.0F}, -2.0F};
    for (const auto* kernels : {&row_kernels<Raw>(), &ref::row_kernels<Raw>()}) {
      EXPECT_EQ(kernels->score(raw.data(), kBlock, in_thresholds).inliers, 9U);
      EXPECT_EQ(kernels->score(raw.data(), kBlock, in_thresholds).gain, 9.0F - (60.0F / 16.0F));
      EXPECT_EQ(kernels->moments(raw.data(), kBlock, plane, 0.5F, {}).count, 9U);
      EXPECT_EQ(kernels->moments(raw.data(), kBlock, plane, std::nextafter(0.5F, 0.0F), {}).count, 7U);
      Unaligned<std::uint8_t> labels(kBlock, 1);
      const LabelPlane labelled{plane, 3};
      kernels->label(raw.data(), raw.data(), kBlock, &labelled, 1, 0.5F, labels.data());
      EXPECT_EQ(std::count(labels.data(), labels.data() + kBlock, 3), 9);
      EXPECT_EQ(kernels->label_one(raw.data(), raw.data(), kBlock, labelled, 0.5F, labels.data()).count, 9U);
    }
  };
  check(std::uint16_t{});
  check(float{});
}

TEST_P(Rows, Moments) {
  for_random_rows([](const auto& row) {
    using Raw = RawOf<decltype(row)>;
    const RowPlane& plane = row.planes.front().plane;
    double count = 0.0;
    double expected[5] = {};
    double sizes[5] = {};
    double largest[5] = {};  // of one term
    for (std::size_t u = 0; u < row.n; ++u) {
      const double z = row.value(u);
      const double x = z * row.at(row.ray, u);
      const double terms[5] = {z, z * z, x, z * x, x * x};
      const bool inlier = z > 0.0 && std::abs(row.distance(plane, u)) <= static_cast<double>(static_cast<float>(row.threshold));
      count += static_cast<double>(inlier);
      for (std::size_t k = 0; k < 5; ++k) {
        largest[k] = std::max(largest[k], std::abs(terms[k]));
        if (!inlier) continue;
        expected[k] += terms[k];
        sizes[k] += std::abs(terms[k]);
      }
    }
    // A ray is off by 2^-23 of its base at most, which counts twice in x^2.
    const double rays = 0x1p-22 * std::abs(static_cast<double>(row.ray.base));
    const double undecided = row.undecided(plane, row.threshold);
    for (const auto* kernels : {&row_kernels<Raw>(), &ref::row_kernels<Raw>()}) {
      const RowMoments m = kernels->moments(row.raw.data(), row.n, plane, static_cast<float>(row.threshold), row.ray);
      EXPECT_NEAR(m.count, count, undecided);
      const float sums[5] = {m.z, m.zz, m.za, m.zza, m.zzaa};
      for (std::size_t k = 0; k < 5; ++k) {
        const double of_rays = k < 2 ? 0.0 : rays * sizes[k < 3 ? 0 : 1];
        EXPECT_NEAR(static_cast<double>(sums[k]), expected[k], summing(row.n, sizes[k]) + of_rays + undecided * largest[k]) << k;
      }
    }
  });
}

constexpr int kUndecided = -1;

/// The label of a pixel; kUndecided where another plane, or the threshold, is as near as the nearest plane to rounding.
template <class Raw>
int expected_label(const RandomRow<Raw>& row, std::size_t u) {
  if (row.raw[u] == Raw{0}) return 0;
  if (row.kept[u] == Raw{0}) return 255;
  int label = 255;
  double nearest = row.threshold;
  double second = std::numeric_limits<double>::infinity();
  double rounding = 0.0;
  for (const LabelPlane& plane : row.planes) {
    const double distance = std::abs(row.distance(plane.plane, u));
    rounding = std::max(rounding, row.rounding(plane.plane));
    second = std::min(second, std::max(distance, nearest));
    if (distance < nearest) label = plane.label;
    nearest = std::min(nearest, distance);
  }
  return second - nearest <= 2.0 * rounding ? kUndecided : label;
}

TEST_P(Rows, Label) {
  std::size_t undecided = 0;
  std::size_t pixels = 0;
  for (const std::size_t num_planes : {std::size_t{1}, std::size_t{3}, std::size_t{254}}) {
    for_random_rows(
        [&](const auto& row) {
          using Raw = RawOf<decltype(row)>;
          for (const auto* kernels : {&row_kernels<Raw>(), &ref::row_kernels<Raw>()}) {
            Unaligned<std::uint8_t> labels(row.n, 1, 77);
            kernels->label(row.raw.data(), row.kept.data(), row.n, row.planes.data(), row.planes.size(),
                           static_cast<float>(row.threshold), labels.data());
            for (std::size_t u = 0; u < row.n; ++u) {
              const int expected = expected_label(row, u);
              ++pixels;
              undecided += static_cast<std::size_t>(expected == kUndecided);
              if (expected == kUndecided) continue;
              ASSERT_EQ(labels[u], expected) << u;
            }
            EXPECT_EQ(labels[row.n], 77);
          }
        },
        num_planes);
  }
  EXPECT_LT(static_cast<double>(undecided), 0.02 * static_cast<double>(pixels));
}

TEST_P(Rows, OfEquallyNearPlanesTheFirst) {
  const auto check = [](auto raw_one) {
    using Raw = decltype(raw_one);
    const Unaligned<Raw> raw(kBlock, 0, Raw{2});
    const Unaligned<Raw> nothing(kBlock, 0);
    const RowPlane above{{0.5F, 0.0F}, -0.75F};  // 0.25
    const RowPlane below{{0.5F, 0.0F}, -1.25F};  // -0.25
    const RowPlane on{{0.5F, 0.0F}, -1.0F};
    const LabelPlane tie[] = {{above, 1}, {below, 2}, {above, 3}};
    const LabelPlane better[] = {{above, 1}, {below, 2}, {on, 3}};
    for (const auto* kernels : {&row_kernels<Raw>(), &ref::row_kernels<Raw>()}) {
      Unaligned<std::uint8_t> labels(kBlock, 1);
      const auto expect_all = [&](int label) {
        for (std::size_t u = 0; u < kBlock; ++u) EXPECT_EQ(labels[u], label);
      };
      kernels->label(raw.data(), raw.data(), kBlock, tie, 3, 0.5F, labels.data());
      expect_all(1);
      kernels->label(raw.data(), raw.data(), kBlock, better, 3, 0.5F, labels.data());
      expect_all(3);
      kernels->label(raw.data(), raw.data(), kBlock, better, 0, 0.5F, labels.data());
      expect_all(255);
      kernels->label(raw.data(), nothing.data(), kBlock, better, 3, 0.5F, labels.data());
      expect_all(255);
      kernels->label(nothing.data(), nothing.data(), kBlock, better, 3, 0.5F, labels.data());
      expect_all(0);
    }
  };
  check(std::uint16_t{});
  check(float{});
}

/// The evidence of the pixels that carry a label, in double, with what float sums may be off by.
template <class Raw>
void expect_evidence(const RandomRow<Raw>& row, const LabelPlane& plane, const Unaligned<std::uint8_t>& labels,
                     const RowEvidence& evidence) {
  double count = 0.0;
  double squared = 0.0;
  double sizes = 0.0;
  double cubed = 0.0;
  for (std::size_t u = 0; u < row.n; ++u) {
    if (labels[u] != plane.label) continue;
    ++count;
    const double r = row.distance(plane.plane, u);
    squared += r * r;
    sizes += std::abs(r);
    cubed += std::pow(row.value(u), 3.0);
  }
  const double rounding = row.rounding(plane.plane);
  EXPECT_EQ(evidence.count, count);
  EXPECT_NEAR(static_cast<double>(evidence.squared_distance), squared,
              summing(row.n, squared) + 2.0 * rounding * sizes + rounding * rounding * count);
  EXPECT_NEAR(static_cast<double>(evidence.cubed_depth), cubed, summing(row.n, cubed));
}

TEST_P(Rows, Evidence) {
  RandomStream random = testing::test_random(1);
  for_random_rows(
      [&](const auto& row) {
        using Raw = RawOf<decltype(row)>;
        Unaligned<std::uint8_t> labels(row.n, 3);
        for (std::size_t u = 0; u < row.n; ++u) {
          labels[u] = static_cast<std::uint8_t>(row.raw[u] == Raw{0} ? 0U : random.below(4) == 0 ? 255U : 1 + random.below(3));
        }
        for (const LabelPlane& plane : row.planes) {
          for (const auto* kernels : {&row_kernels<Raw>(), &ref::row_kernels<Raw>()}) {
            expect_evidence(row, plane, labels, kernels->evidence(row.raw.data(), labels.data(), row.n, plane));
          }
        }
      },
      3);
}

TEST_P(Rows, LabelOneIsLabelAndEvidence) {
  for_random_rows([](const auto& row) {
    using Raw = RawOf<decltype(row)>;
    const LabelPlane& plane = row.planes.front();
    const auto threshold = static_cast<float>(row.threshold);
    for (const auto* kernels : {&row_kernels<Raw>(), &ref::row_kernels<Raw>()}) {
      Unaligned<std::uint8_t> one(row.n, 1, 77);
      Unaligned<std::uint8_t> many(row.n, 0, 78);
      const RowEvidence evidence = kernels->label_one(row.raw.data(), row.kept.data(), row.n, plane, threshold, one.data());
      kernels->label(row.raw.data(), row.kept.data(), row.n, &plane, 1, threshold, many.data());
      for (std::size_t u = 0; u < row.n; ++u) ASSERT_EQ(one[u], many[u]) << u;  // the same steps: not even rounding differs
      EXPECT_EQ(one[row.n], 77);
      expect_evidence(row, plane, one, evidence);
    }
  });
}

INSTANTIATE_TEST_SUITE_P(Targets, Rows, ::testing::ValuesIn(targets()), [](const ::testing::TestParamInfo<std::int64_t>& target) {
  return std::string(hwy::TargetName(target.param));
});

}  // namespace
}  // namespace fransac::kernels
