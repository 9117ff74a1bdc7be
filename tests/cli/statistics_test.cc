// SPDX-License-Identifier: Apache-2.0
// Quantiles in constant memory against those of all values.
#include "../../apps/fransac/statistics.hpp"

#include <gtest/gtest.h>

#include <random>
#include <type_traits>
#include <vector>

namespace fransac::cli {
namespace {

static_assert(std::is_trivially_copyable_v<QuantileSketch>, "nothing of it grows");

TEST(QuantileSketch, IsRightToWithinItsError) {
  std::mt19937 random(1);
  std::lognormal_distribution<double> times(1.0, 1.2);
  for (const std::size_t count : {1U, 2U, 10U, 100000U}) {
    QuantileSketch sketch;
    std::vector<double> all;
    for (std::size_t i = 0; i < count; ++i) {
      all.push_back(times(random));
      sketch.add(all.back());
    }
    EXPECT_EQ(sketch.count(), count);
    for (const double share : {0.0, 0.01, 0.5, 0.9, 0.99, 1.0}) {
      const double exact = quantile(all, share);
      EXPECT_NEAR(sketch.quantile(share), exact, 1.001 * QuantileSketch::kError * exact) << count << ", " << share;
    }
  }
}

TEST(QuantileSketch, TakesAnyNumber) {
  QuantileSketch sketch;
  EXPECT_EQ(sketch.quantile(0.5), 0.0);
  for (const double value : {0.0, 1e-9, 1e12}) sketch.add(value);
  EXPECT_NEAR(sketch.quantile(0.5), 1e-3, 1e-5);
  EXPECT_NEAR(sketch.quantile(1.0), 1e6, 2e4);
}

}  // namespace
}  // namespace fransac::cli
