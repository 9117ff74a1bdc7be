// SPDX-License-Identifier: Apache-2.0
// The height kernels, once per instruction set that this machine has: by hand, and against their scalar twin.
#include "kernels/heights.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <type_traits>
#include <vector>

#include "kernels/targets.hpp"
#include "support.hpp"

namespace fransac::kernels {
namespace {

constexpr std::size_t kSizes[] = {0, 8, 16, 24, 32, 56, 80, 120, 640, 1280};
constexpr std::size_t kOffsets[] = {0, 1, 3};  // nothing need be aligned

/// Metres per raw value.
template <class Raw>
constexpr double kMetres = std::is_same_v<Raw, float> ? 1.0 : 0.001;

/// What the kernel writes; sums begin with `before`.
struct Found {
  explicit Found(std::size_t n, std::uint16_t before = 0)
      : sides(n + 1, kUntouched),
        above(n / kQuad + 1, before),
        below(n / kQuad + 1, before),
        above_z(n / kQuad + 1, static_cast<float>(before)),
        below_z(n / kQuad + 1, static_cast<float>(before)) {}
  QuadSums sums() { return {above.data(), above_z.data(), below.data(), below_z.data()}; }

  static constexpr std::uint8_t kUntouched = 99;
  std::vector<std::uint8_t> sides;
  std::vector<std::uint16_t> above, below;
  std::vector<float> above_z, below_z;
};

template <class Raw>
Found find(const HeightKernels<Raw>& kernels, const std::vector<Raw>& raw, const std::vector<std::uint8_t>& kinds, float metres,
           const HeightRow& row, const HeightLimits& limits, std::size_t offset = 0, std::uint16_t before = 0) {
  const std::size_t n = raw.size() - offset;
  Found found(n, before);
  kernels.find_sides(raw.data() + offset, kinds.data() + offset, n, metres, row, limits, found.sides.data(), found.sums());
  EXPECT_EQ(found.sides[n], Found::kUntouched);  // nor are sums beyond the row touched
  EXPECT_EQ(found.above[n / kQuad], before);
  EXPECT_EQ(found.below[n / kQuad], before);
  return found;
}

/// Calls check(kernels) with both types, with the instruction set under test and with the twin.
template <class Check>
void for_all_kernels(const Check& check) {
  check(height_kernels<std::uint16_t>());
  check(height_kernels<float>());
  check(ref::height_kernels<std::uint16_t>());
  check(ref::height_kernels<float>());
}

template <class Raw>
Raw type_of(const HeightKernels<Raw>&);
template <class Kernels>
using RawOf = decltype(type_of(std::declval<Kernels>()));

class Heights : public ::testing::TestWithParam<std::int64_t> {
 protected:
  void SetUp() override { hwy::SetSupportedTargetsForTest(GetParam()); }
  void TearDown() override { hwy::SetSupportedTargetsForTest(0); }
};

/// Without noise.
constexpr HeightLimits kExact{0.0F, 0.0F, 0.0F, 0.25F, 0.5F};

TEST_P(Heights, ByHand) {
  for_all_kernels([](const auto& kernels) {
    using Raw = RawOf<decltype(kernels)>;
    // Height 2 - z; a raw unit is an eighth of a metre.
    const std::vector<Raw> raw{0, 8, 14, 13, 16, 20, 21, 24, 8, 8, 8, 24, 24, 24, 0, 1};
    std::vector<std::uint8_t> kinds(16, kOffPlane);
    kinds[8] = kOnPlane;
    kinds[9] = 0;
    kinds[11] = kOnPlane;
    kinds[12] = 0;
    const Found found = find(kernels, raw, kinds, 0.125F, {-1.0F, 0.0F, 2.0F}, kExact, 0, 5);
    const std::vector<std::uint8_t> sides{0, kAbove, 0,      kAbove,  // 1/4 above is not more than 1/4
                                          0, 0,      kBelow, kBelow,  // 1/2 below is not more than 1/2
                                          0, 0,      kAbove, 0,      0, kBelow, 0, kAbove, Found::kUntouched};
    EXPECT_EQ(found.sides, sides);
    EXPECT_EQ(found.above, (std::vector<std::uint16_t>{7, 5, 6, 6, 5}));
    EXPECT_EQ(found.below, (std::vector<std::uint16_t>{5, 7, 5, 6, 5}));
    EXPECT_EQ(found.above_z, (std::vector<float>{5 + 2.625F, 5, 6, 5.125F, 5}));
    EXPECT_EQ(found.below_z, (std::vector<float>{5, 5 + 5.625F, 5, 8, 5}));
  });
}

TEST_P(Heights, NoiseGrowsWithTheDepthAndTheRay) {
  for_all_kernels([](const auto& kernels) {
    using Raw = RawOf<decltype(kernels)>;
    // In column u the ray rises by u + 1 metres per metre and height is z (u + 1); noise is that of z times u + 1. So columns do
    // not matter, only whether z^2 is more than constant + linear z^2 + quadratic z^4.
    const auto is_above = [&](Raw z, const HeightLimits& limits) {
      const Found found =
          find(kernels, std::vector<Raw>(16, z), std::vector<std::uint8_t>(16, kOffPlane), 1.0F, {1.0F, 1.0F, 0.0F}, limits);
      EXPECT_EQ(std::count(found.sides.begin(), found.sides.end(), found.sides[0]), 16);
      return found.sides[0] == kAbove;
    };
    const auto limits = [](float constant, float linear, float quadratic) {
      return HeightLimits{constant, linear, quadratic, 0.0F, 0.0F};
    };
    EXPECT_FALSE(is_above(3, limits(9.0F, 0.0F, 0.0F)));
    EXPECT_TRUE(is_above(4, limits(9.0F, 0.0F, 0.0F)));
    EXPECT_FALSE(is_above(4, limits(0.0F, 1.0F, 0.0F)));
    EXPECT_TRUE(is_above(4, limits(0.0F, 0.5F, 0.0F)));
    EXPECT_FALSE(is_above(4, limits(0.0F, 0.0F, 0.0625F)));
    EXPECT_TRUE(is_above(3, limits(0.0F, 0.0F, 0.0625F)));
    EXPECT_FALSE(is_above(4, limits(8.0F, 0.25F, 0.015625F)));  // 8 + 4 + 4 = 16
    EXPECT_TRUE(is_above(4, limits(7.5F, 0.25F, 0.015625F)));
  });
}

TEST_P(Heights, EveryColumnCounts) {
  for_all_kernels([](const auto& kernels) {
    using Raw = RawOf<decltype(kernels)>;
    constexpr std::size_t kColumns = 4 * kHeightGroup;
    // At one metre: height 8.5 - u.
    for (std::size_t u = 0; u < kColumns; ++u) {
      std::vector<Raw> raw(kColumns, Raw{0});
      raw[u] = Raw{2};
      const Found found = find(kernels, raw, std::vector<std::uint8_t>(kColumns, kOffPlane), 0.5F, {8.0F, -1.0F, 0.5F}, kExact);
      const std::uint8_t side = u <= 8 ? kAbove : u == 9 ? std::uint8_t{0} : kBelow;  // heights 8.5 … 0.5, -0.5, -1.5 …
      for (std::size_t i = 0; i < kColumns; ++i) EXPECT_EQ(found.sides[i], i == u ? side : 0) << i << ' ' << u;
      for (std::size_t quad = 0; quad < kColumns / kQuad; ++quad) {
        EXPECT_EQ(found.above[quad], quad == u / kQuad && side == kAbove ? 1 : 0);
        EXPECT_EQ(found.below[quad], quad == u / kQuad && side == kBelow ? 1 : 0);
        EXPECT_EQ(found.above_z[quad], static_cast<float>(found.above[quad]));
        EXPECT_EQ(found.below_z[quad], static_cast<float>(found.below[quad]));
      }
    }
  });
}

TEST_P(Heights, TheLargestUnitIsPositive) {
  const std::vector<std::uint16_t> raw(8, 0xFFFF);
  const Found found =
      find(height_kernels<std::uint16_t>(), raw, std::vector<std::uint8_t>(8, kOffPlane), 0.001F, {-1.0F, 0.0F, 2.0F}, kExact);
  EXPECT_EQ(found.below[0], 4);
  EXPECT_NEAR(found.below_z[1], 4 * 65.535, 1e-4);
}

/// A floor seen from a metre above, with kinds in stretches as labels have them.
template <class Raw>
struct RandomRow {
  RandomRow(RandomStream& random, std::size_t size)
      : raw(size),
        kinds(size),
        row{static_cast<float>(testing::uniform(random, -0.6, -0.2)),
            static_cast<float>(testing::uniform(random, -0.3, 0.3) / (static_cast<double>(size) + 1.0)), 1.0F},
        limits{static_cast<float>(testing::uniform(random, 0.0, 1e-4)), static_cast<float>(testing::uniform(random, 0.0, 1e-5)),
               static_cast<float>(testing::uniform(random, 0.0, 3e-5)), static_cast<float>(testing::uniform(random, 0.0, 0.02)),
               static_cast<float>(testing::uniform(random, 0.0, 0.05))} {
    std::uint8_t kind = kOffPlane;
    for (std::size_t u = 0; u < size; ++u) {
      if (random.below(7) == 0) kind = static_cast<std::uint8_t>(random.below(3));
      kinds[u] = kind;
      const double on_floor = -1.0 / slope(u);
      const double z = random.below(4) == 0 ? testing::uniform(random, 0.4, 9.0) : on_floor + testing::uniform(random, -0.3, 0.3);
      raw[u] = random.below(9) == 0 ? Raw{0} : static_cast<Raw>(z / kMetres<Raw>);
    }
  }
  [[nodiscard]] double slope(std::size_t u) const {
    return static_cast<double>(row.base) + static_cast<double>(row.step) * static_cast<double>(u);
  }
  [[nodiscard]] double depth(std::size_t u) const { return static_cast<double>(raw[u]) * kMetres<Raw>; }
  /// Whether rounding to float, a few times 2^-24 of what is added up, may move the pixel to another side.
  [[nodiscard]] bool is_undecided(std::size_t u) const {
    const double z = depth(u);
    const double height = z * slope(u) + static_cast<double>(row.d);
    const double rounding = 0x1p-21 * (std::abs(z * slope(u)) + 1.0);
    const double sigma = std::abs(slope(u)) *
                         std::sqrt(static_cast<double>(limits.constant) +
                                   z * z * (static_cast<double>(limits.linear) + z * z * static_cast<double>(limits.quadratic)));
    const auto is_near = [&](double limit) { return std::abs(height - limit) <= rounding; };
    return is_near(sigma) || is_near(-sigma) || is_near(static_cast<double>(limits.least_height)) ||
           is_near(-static_cast<double>(limits.least_drop));
  }

  std::vector<Raw> raw;
  std::vector<std::uint8_t> kinds;
  HeightRow row;
  HeightLimits limits;
};

template <class Raw>
void compare_with_twin(const RandomRow<Raw>& r, std::size_t offset, std::size_t& decided) {
  const auto metres = static_cast<float>(kMetres<Raw>);
  HeightRow row = r.row;
  row.base += row.step * static_cast<float>(offset);
  const Found found = find(height_kernels<Raw>(), r.raw, r.kinds, metres, row, r.limits, offset);
  const Found twin = find(ref::height_kernels<Raw>(), r.raw, r.kinds, metres, row, r.limits, offset);
  const std::size_t n = r.raw.size() - offset;
  for (std::size_t quad = 0; quad < n / kQuad; ++quad) {
    std::uint16_t count[3] = {};
    double sum[3] = {};
    for (std::size_t i = quad * kQuad; i < (quad + 1) * kQuad; ++i) {
      if (!r.is_undecided(i + offset)) {
        ASSERT_EQ(found.sides[i], twin.sides[i]) << i;
        ++decided;
      }
      ASSERT_LE(found.sides[i], kBelow);
      ++count[found.sides[i]];
      sum[found.sides[i]] += r.depth(i + offset);
    }
    // What is added up is what is written.
    ASSERT_EQ(found.above[quad], count[kAbove]);
    ASSERT_EQ(found.below[quad], count[kBelow]);
    ASSERT_NEAR(found.above_z[quad], sum[kAbove], 0x1p-21 * sum[kAbove]);
    ASSERT_NEAR(found.below_z[quad], sum[kBelow], 0x1p-21 * sum[kBelow]);
  }
}

TEST_P(Heights, AgreesWithTheTwin) {
  RandomStream random = testing::test_random();
  std::size_t decided = 0;
  std::size_t all = 0;
  for (const std::size_t n : kSizes) {
    for (const std::size_t offset : kOffsets) {
      for (int repeat = 0; repeat < 5; ++repeat) {
        compare_with_twin(RandomRow<std::uint16_t>(random, n + offset), offset, decided);
        compare_with_twin(RandomRow<float>(random, n + offset), offset, decided);
        all += 2 * n;
      }
    }
  }
  EXPECT_GT(decided, all - all / 1000);
}

INSTANTIATE_TEST_SUITE_P(Targets, Heights, ::testing::ValuesIn(targets()),
                         [](const ::testing::TestParamInfo<std::int64_t>& target) {
                           return std::string(hwy::TargetName(target.param));
                         });

}  // namespace
}  // namespace fransac::kernels
