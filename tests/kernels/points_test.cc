// SPDX-License-Identifier: Apache-2.0
// Each kernel against its scalar twin, once per instruction set that this machine has.
#include "kernels/points.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <initializer_list>
#include <limits>
#include <string>
#include <vector>

#include "fransac/core/aligned.hpp"
#include "kernels/targets.hpp"
#include "support.hpp"

namespace fransac::kernels {
namespace {

constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();
constexpr float kInf = std::numeric_limits<float>::infinity();
constexpr std::size_t kSizes[] = {0, kBlock, 2 * kBlock, 3 * kBlock, 17 * kBlock, 128 * kBlock};

using Floats = AlignedVector<float>;

struct Points {
  Floats x, y, z;
  [[nodiscard]] std::size_t n() const { return x.size(); }
};

/// `n` random points, of which `tail` at the end and some in between are NaN.
Points random_points(RandomStream& random, std::size_t n, std::size_t tail) {
  Points p;
  for (Floats* axis : {&p.x, &p.y, &p.z}) {
    for (std::size_t i = 0; i < n; ++i) axis->push_back(static_cast<float>(testing::uniform(random, -2.0, 2.0)));
    for (std::size_t i = n - tail; i < n; ++i) (*axis)[i] = kNaN;
  }
  // A NaN on one axis alone.
  for (std::size_t i = 0; i < n / 20; ++i) (i % 2 == 0 ? p.x : p.z)[random.below(static_cast<std::uint32_t>(n))] = kNaN;
  return p;
}

PlaneF random_plane(RandomStream& random) {
  const Eigen::Vector3f n = testing::unit_vector(random).cast<float>();
  return {n.x(), n.y(), n.z(), static_cast<float>(testing::uniform(random, -1.0, 1.0))};
}

/// Residuals whose rounding could fall on either side of the threshold.
std::uint32_t undecided(const Points& p, const PlaneF& plane, float threshold) {
  std::uint32_t count = 0;
  for (std::size_t i = 0; i < p.n(); ++i) {
    const double r = static_cast<double>(plane.a) * static_cast<double>(p.x[i]) +
                     static_cast<double>(plane.b) * static_cast<double>(p.y[i]) +
                     static_cast<double>(plane.c) * static_cast<double>(p.z[i]) + static_cast<double>(plane.d);
    count += static_cast<std::uint32_t>(std::abs(std::abs(r) - static_cast<double>(threshold)) < 2e-6);  // 8 roundings of about 4
  }
  return count;
}

class Kernels : public ::testing::TestWithParam<std::int64_t> {
 protected:
  void SetUp() override { hwy::SetSupportedTargetsForTest(GetParam()); }
  void TearDown() override { hwy::SetSupportedTargetsForTest(0); }

  /// Calls check(points, plane, threshold) for every size, tail and some random planes.
  template <class Check>
  void for_random_points(const Check& check) {
    RandomStream random = testing::test_random();
    for (const std::size_t n : kSizes) {
      for (const std::size_t tail : {std::size_t{0}, std::size_t{1}, kBlock - 1, kBlock}) {
        if (tail > n) continue;
        for (int i = 0; i < 5; ++i) {
          const Points p = random_points(random, n, tail);
          check(p, random_plane(random), static_cast<float>(testing::uniform(random, 0.01, 0.5)));
        }
      }
    }
  }
};

TEST_P(Kernels, Bounds) {
  for_random_points([](const Points& p, const PlaneF& /*plane*/, float /*threshold*/) {
    const struct Bounds a = bounds(p.x.data(), p.n());
    const struct Bounds b = ref::bounds(p.x.data(), p.n());
    EXPECT_EQ(a.min, b.min);
    EXPECT_EQ(a.max, b.max);
  });
}

TEST_P(Kernels, BoundsInEveryLane) {
  // The extreme value at each place of a block in turn, among NaN only and among numbers; infinities are values.
  for (std::size_t i = 0; i < 3 * kBlock; ++i) {
    for (const float rest : {kNaN, 0.5F}) {
      Floats values(3 * kBlock, rest);
      values[i] = -3.0F;
      EXPECT_EQ(bounds(values.data(), values.size()).min, -3.0F);
      EXPECT_EQ(bounds(values.data(), values.size()).max, std::isnan(rest) ? -3.0F : 0.5F);
      values[i] = kInf;
      EXPECT_EQ(bounds(values.data(), values.size()).max, kInf);
    }
  }
  const Floats nothing(2 * kBlock, kNaN);
  EXPECT_EQ(bounds(nothing.data(), nothing.size()).min, kInf);
  EXPECT_EQ(bounds(nothing.data(), nothing.size()).max, -kInf);
}

TEST_P(Kernels, CountInliers) {
  for_random_points([](const Points& p, const PlaneF& plane, float threshold) {
    const std::uint32_t a = count_inliers(p.x.data(), p.y.data(), p.z.data(), p.n(), plane, threshold);
    const std::uint32_t b = ref::count_inliers(p.x.data(), p.y.data(), p.z.data(), p.n(), plane, threshold);
    EXPECT_LE(a > b ? a - b : b - a, undecided(p, plane, threshold));
  });
}

TEST_P(Kernels, TheThresholdItselfIsAnInlier) {
  // Multiples of 1/8 and powers of two: every step is exact on every target. Residuals -0.75 … 0.75, threshold 0.5.
  const PlaneF plane{0.0F, 0.0F, 1.0F, -1.0F};
  Points p;
  std::uint32_t expected = 0;
  double gain = 0.0;
  for (int i = 0; i < 64; ++i) {
    const double r = (i % 13 - 6) / 8.0;
    p.x.push_back(static_cast<float>(i));
    p.y.push_back(static_cast<float>(-i));
    p.z.push_back(static_cast<float>(1.0 + r));
    if (std::abs(r) > 0.5) continue;
    ++expected;
    gain += 1.0 - 4.0 * r * r;
  }
  EXPECT_EQ(count_inliers(p.x.data(), p.y.data(), p.z.data(), 64, plane, 0.5F), expected);
  EXPECT_EQ(ref::count_inliers(p.x.data(), p.y.data(), p.z.data(), 64, plane, 0.5F), expected);
  EXPECT_EQ(inlier_moments(p.x.data(), p.y.data(), p.z.data(), 64, plane, 0.5F).count, expected);
  const Msac m = msac(p.x.data(), p.y.data(), p.z.data(), 64, plane, 0.5F);
  EXPECT_EQ(m.inliers, expected);
  EXPECT_EQ(static_cast<double>(m.gain), gain);
  // One float step less and the points at the threshold are out.
  const float below = std::nextafter(0.5F, 0.0F);
  EXPECT_EQ(count_inliers(p.x.data(), p.y.data(), p.z.data(), 64, plane, below),
            ref::count_inliers(p.x.data(), p.y.data(), p.z.data(), 64, plane, below));
  EXPECT_LT(count_inliers(p.x.data(), p.y.data(), p.z.data(), 64, plane, below), expected);
}

TEST_P(Kernels, EveryLaneCounts) {
  const PlaneF plane{0.0F, 0.0F, 1.0F, 0.0F};
  for (std::size_t i = 0; i < 2 * kBlock; ++i) {
    Floats zeros(2 * kBlock, 0.0F);
    Floats z(2 * kBlock, kNaN);
    z[i] = 0.25F;
    EXPECT_EQ(count_inliers(zeros.data(), zeros.data(), z.data(), z.size(), plane, 0.5F), 1U);
    EXPECT_EQ(msac(zeros.data(), zeros.data(), z.data(), z.size(), plane, 0.5F).gain, 0.75F);
    const InlierMoments m = inlier_moments(zeros.data(), zeros.data(), z.data(), z.size(), plane, 0.5F);
    EXPECT_EQ(m.count, 1U);
    EXPECT_EQ(m.sums[2], 0.25);
    EXPECT_EQ(m.sums[8], 0.0625);
  }
}

TEST_P(Kernels, Msac) {
  for_random_points([](const Points& p, const PlaneF& plane, float threshold) {
    const struct Msac a = msac(p.x.data(), p.y.data(), p.z.data(), p.n(), plane, threshold);
    const struct Msac b = ref::msac(p.x.data(), p.y.data(), p.z.data(), p.n(), plane, threshold);
    EXPECT_LE(a.inliers > b.inliers ? a.inliers - b.inliers : b.inliers - a.inliers, undecided(p, plane, threshold));
    // A point's gain is off by 2 |r| dr / t^2 <= 2 dr / t, dr <= 2e-6; one at the threshold gains nothing either way.
    EXPECT_NEAR(static_cast<double>(a.gain), static_cast<double>(b.gain),
                (4e-6 / static_cast<double>(threshold) + 1e-5) * (b.inliers + 1.0));
    EXPECT_LE(a.gain, static_cast<float>(a.inliers));
  });
}

TEST_P(Kernels, InlierMoments) {
  for_random_points([](const Points& p, const PlaneF& plane, float threshold) {
    const struct InlierMoments a = inlier_moments(p.x.data(), p.y.data(), p.z.data(), p.n(), plane, threshold);
    const struct InlierMoments b = ref::inlier_moments(p.x.data(), p.y.data(), p.z.data(), p.n(), plane, threshold);
    const double at_the_border = undecided(p, plane, threshold);
    EXPECT_NEAR(static_cast<double>(a.count), static_cast<double>(b.count), at_the_border);
    for (int k = 0; k < 9; ++k) {
      EXPECT_NEAR(a.sums[k], b.sums[k], 1e-9 + 4.0 * at_the_border) << "sum " << k;  // no term is above 4
    }
  });
}

TEST_P(Kernels, MomentsOfMomentsInDouble) {
  // 1 km away the squares need more than 24 bits: 1000.0625^2 is exact in double.
  const Floats x(kBlock, 1000.0625F);
  const Floats y(kBlock, -3.0F);
  const Floats z(kBlock, 2.0F);
  const InlierMoments m = inlier_moments(x.data(), y.data(), z.data(), kBlock, {0.0F, 0.0F, 1.0F, -2.0F}, 0.01F);
  EXPECT_EQ(m.count, kBlock);
  EXPECT_EQ(m.sums[3], 16.0 * 1000.0625 * 1000.0625);
  EXPECT_EQ(m.sums[4], 16.0 * 1000.0625 * -3.0);
  EXPECT_EQ(m.sums[7], 16.0 * -6.0);
}

/// n points side by side, multiples of 2^-10 so that sums and places are exact; the last one ends the memory.
std::vector<float> side_by_side(RandomStream& random, std::size_t n, std::size_t stride) {
  std::vector<float> points(n == 0 ? 0 : (n - 1) * stride + 3, std::numeric_limits<float>::quiet_NaN());
  float place[3] = {0.0F, 0.0F, 0.0F};
  for (std::size_t i = 0; i < n; ++i) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      if (random.below(4) == 0) place[axis] = (static_cast<float>(random.below(4096)) - 2048.0F) / 1024.0F;
      points[i * stride + axis] = place[axis];
    }
  }
  return points;
}

TEST_P(Kernels, LeafRuns) {
  RandomStream random = testing::test_random();
  const Lattice lattice{
      .per_leaf = {50.0, 25.0, 4.0, 0.0}, .offset = {100.25, 200.5, 8.0, 0.0}, .rounder = {0x1.8p24, 0x1.8p25, 0x1.8p23, 0.0}};
  for (const std::size_t stride : std::initializer_list<std::size_t>{3, 4, 8, 9}) {
    for (const std::size_t n : std::initializer_list<std::size_t>{0, 1, 2, 3, 17, 256}) {
      const std::vector<float> points = side_by_side(random, n, stride);
      AlignedVector<LeafRun> a(n);
      AlignedVector<LeafRun> b(n);
      const std::size_t runs = leaf_runs(points.data(), stride, n, lattice, a.data());
      ASSERT_EQ(runs, ref::leaf_runs(points.data(), stride, n, lattice, b.data()));
      for (std::size_t i = 0; i < runs; ++i) {
        EXPECT_TRUE(std::equal(a[i].index, a[i].index + 4, b[i].index));
        EXPECT_TRUE(std::equal(a[i].sum, a[i].sum + 4, b[i].sum));
      }
      EXPECT_EQ(runs == 0 ? 0 : a[runs - 1].sum[3], n);
    }
  }
}

TEST_P(Kernels, LeafRunsByHand) {
  // Units of 2^-28 m; the largest index is 2^31 - 128, of the largest float below 2^31.
  const Lattice lattice{
      .per_leaf = {1.0, 1.0, 0x1p30, 0.0}, .offset = {0.0, 10.0, 0.0, 0.0}, .rounder = {0x1.8p24, 0x1.8p24, 0x1.8p24, 0.0}};
  const std::vector<float> points{0.5F, -0.25F, 0.0F, 0.75F, -0.5F, 0.0F, 1.0F, -0.5F, 0x1p1F - 0x1p-23F};
  AlignedVector<LeafRun> runs(3);
  ASSERT_EQ(leaf_runs(points.data(), 3, 3, lattice, runs.data()), 2U);
  const std::uint32_t first[3] = {0, 9, 0};
  const std::uint32_t second[3] = {1, 9, 0x7FFFFF80U};
  EXPECT_TRUE(std::equal(first, first + 3, runs[0].index));
  EXPECT_TRUE(std::equal(second, second + 3, runs[1].index));
  const std::uint64_t one = std::uint64_t{1} << 28;
  EXPECT_EQ(runs[0].sum[0], one + one / 4);
  EXPECT_EQ(runs[0].sum[1], 0U - one / 4 * 3);
  EXPECT_EQ(runs[0].sum[3], 2U);
  EXPECT_EQ(runs[1].sum[0], 2 * one + one / 4);
  EXPECT_EQ(runs[1].sum[2], 2 * one - 32);
  EXPECT_EQ(runs[1].sum[3], 3U);
}

TEST_P(Kernels, LeafTermsAndBuckets) {
  RandomStream random = testing::test_random();
  const Lattice lattice{.per_leaf = {50.0, 25.0, 4.0, 0.0},
                        .offset = {100.25, 200.5, 8.0, 0.0},
                        .rounder = {0x1.8p24, 0x1.8p25, 0x1.8p23, 0.0},
                        .shift = {0, 9, 40, 0}};
  for (const std::size_t stride : std::initializer_list<std::size_t>{3, 4, 9}) {
    for (const std::size_t n : std::initializer_list<std::size_t>{0, 1, 2, 17, 256}) {
      const std::vector<float> points = side_by_side(random, n, stride);
      AlignedVector<LeafTerm> a(n);
      AlignedVector<LeafTerm> b(n);
      AlignedVector<std::uint64_t> keys(n);
      AlignedVector<std::uint64_t> expected_keys(n);
      std::vector<std::uint8_t> buckets(n);
      std::vector<std::uint8_t> expected_buckets(n);
      leaf_terms(points.data(), stride, n, lattice, a.data(), keys.data());
      ref::leaf_terms(points.data(), stride, n, lattice, b.data(), expected_keys.data());
      leaf_buckets(points.data(), stride, n, lattice, buckets.data());
      ref::leaf_buckets(points.data(), stride, n, lattice, expected_buckets.data());
      EXPECT_EQ(keys, expected_keys);
      EXPECT_EQ(buckets, expected_buckets);
      // Against the kernel of runs, which knows no keys.
      AlignedVector<LeafRun> runs(n);
      const std::size_t count = leaf_runs(points.data(), stride, n, lattice, runs.data());
      std::size_t run = 0;
      for (std::size_t i = 0; i < n; ++i) {
        EXPECT_TRUE(std::equal(a[i].sum, a[i].sum + 4, b[i].sum));
        while (runs[run].sum[3] <= i) ++run;
        ASSERT_LT(run, count);
        const auto* const index = runs[run].index;
        EXPECT_EQ(keys[i], index[0] | std::uint64_t{index[1]} << 9 | std::uint64_t{index[2]} << 40);
        EXPECT_EQ(buckets[i], bucket_of(index));
      }
    }
  }
}

TEST_P(Kernels, CountMeasured) {
  RandomStream random = testing::test_random();
  for (const std::size_t n : kSizes) {
    Points p = random_points(random, n, n / 10);
    const float unmeasured[3] = {0.5F, -1.0F, 0.25F};
    for (std::size_t i = 0; i < n; i += 7) {
      p.x[i] = unmeasured[0];
      p.y[i] = unmeasured[1];
      if (i % 2 == 0) p.z[i] = unmeasured[2];
      if (i % 3 == 0) p.y[i] = kInf;
    }
    const std::size_t expected = ref::count_measured(p.x.data(), p.y.data(), p.z.data(), n, unmeasured);
    EXPECT_EQ(count_measured(p.x.data(), p.y.data(), p.z.data(), n, unmeasured), expected);
  }
}

TEST_P(Kernels, LabelPoints) {
  RandomStream random = testing::test_random();
  for (const std::size_t n : kSizes) {
    for (const std::size_t count : std::initializer_list<std::size_t>{0, 1, 2, 254}) {
      Points p = random_points(random, n, n / 10);
      std::vector<PlaneD> planes;
      for (std::size_t k = 0; k < count; ++k) {
        const Eigen::Vector3d normal = testing::unit_vector(random);
        planes.push_back({normal.x(), normal.y(), normal.z(), testing::uniform(random, -1.0, 1.0)});
      }
      if (count == 254) planes[100] = planes[50];  // a tie for all points
      const NearestPlane rule{planes.data(), count, 0.1, {0.5F, -1.0F, 0.25F}, 0, 255, 1};
      if (n > 0) {
        p.x[0] = 0.5F;
        p.y[0] = -1.0F;
        p.z[0] = 0.25F;
        p.x[1] = -kInf;
      }
      std::vector<std::uint8_t> labels(n);
      std::vector<std::uint8_t> expected(n);
      label_points(p.x.data(), p.y.data(), p.z.data(), n, rule, labels.data());
      ref::label_points(p.x.data(), p.y.data(), p.z.data(), n, rule, expected.data());
      EXPECT_EQ(labels, expected);
      EXPECT_EQ(std::count(labels.begin(), labels.end(), 101), 0);
      if (n > 0) {
        EXPECT_EQ(labels[0], 0);
        EXPECT_EQ(labels[1], 0);
      }
    }
  }
}

TEST_P(Kernels, LabelsDoNotHangOnRounding) {
  // Whole millimetres on a threshold of whole millimetres: with other roundings, points would fall to the other side.
  const PlaneD plane{0.6, 0.0, 0.8, -0.48};
  Points p;
  for (int x = 0; x < 64; ++x) {
    for (int z = 0; z < 64; ++z) {
      p.x.push_back(static_cast<float>(x) * 0.01F);
      p.y.push_back(0.0F);
      p.z.push_back(static_cast<float>(z) * 0.01F);
    }
  }
  const NearestPlane rule{&plane, 1, 0.02, {kNaN, kNaN, kNaN}, 0, 255, 1};
  std::vector<std::uint8_t> labels(p.n());
  std::vector<std::uint8_t> expected(p.n());
  label_points(p.x.data(), p.y.data(), p.z.data(), p.n(), rule, labels.data());
  ref::label_points(p.x.data(), p.y.data(), p.z.data(), p.n(), rule, expected.data());
  EXPECT_EQ(labels, expected);
}

TEST_P(Kernels, BoxOfThreePoints) {
  constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
  const std::vector<float> points{1, -2, 3, kNan, 0, 0, -1, 5, 2};
  const fransac::kernels::Box found = box(points.data(), 3, 3);
  const float least[3] = {-1, -2, 2};
  const float greatest[3] = {1, 5, 3};
  EXPECT_TRUE(std::equal(least, least + 3, found.min));
  EXPECT_TRUE(std::equal(greatest, greatest + 3, found.max));
  EXPECT_FALSE(found.finite);
}

TEST_P(Kernels, Box) {
  RandomStream random = testing::test_random();
  for (const std::size_t stride : std::initializer_list<std::size_t>{3, 4, 8}) {
    for (const std::size_t n : std::initializer_list<std::size_t>{0, 1, 2, 3, 4, 101}) {
      for (const float wrong : {0.0F, std::numeric_limits<float>::quiet_NaN(), -std::numeric_limits<float>::infinity()}) {
        std::vector<float> points = side_by_side(random, n, stride);
        if (n > 0 && wrong != 0.0F) points[random.below(static_cast<std::uint32_t>(n)) * stride + random.below(3)] = wrong;
        const fransac::kernels::Box a = box(points.data(), stride, n);
        const fransac::kernels::Box b = ref::box(points.data(), stride, n);
        EXPECT_EQ(a.finite, n == 0 || wrong == 0.0F);
        EXPECT_EQ(b.finite, a.finite);
        EXPECT_TRUE(std::equal(a.min, a.min + 3, b.min));
        EXPECT_TRUE(std::equal(a.max, a.max + 3, b.max));
      }
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Targets, Kernels, ::testing::ValuesIn(targets()),
                         [](const ::testing::TestParamInfo<std::int64_t>& target) {
                           return std::string(hwy::TargetName(target.param));
                         });

}  // namespace
}  // namespace fransac::kernels
