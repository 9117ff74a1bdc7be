// SPDX-License-Identifier: Apache-2.0
/// Giving up on a hypothesis before all data have been looked at.
///
/// Hypotheses are scored on a sample of kSampledData data, drawn independently, and given up at a checkpoint where they lie so
/// far behind the best model that a better one would be there with probability below kMissProbability. This is the bail-out
/// test of Capel ("An effective bail-out test for RANSAC consensus scoring", BMVC 2005) with a bound that holds for any score
/// between 0 and 1 a datum, not for inlier counts only: if the expected share is F, the share s of m independent data is as
/// small as that with probability at most exp(-m KL(s || F)), KL(s || F) = s ln(s / F) + (1 - s) ln((1 - s) / (1 - F))
/// (Hoeffding, "Probability inequalities for sums of bounded random variables", 1963, theorem 1).
/// With few data the sample is all of them, and a hypothesis is given up only when it can win no more: that costs nothing.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>

namespace fransac::sac {

/// Data that hypotheses are first scored on: three float coordinates of each fill the second-level cache by a tenth, and a share
/// is known to 2 % (three standard deviations).
inline constexpr std::uint32_t kSampledData = 4096;

/// At most the probability that a model better than the best is given up at one of the checkpoints, over the choice of the
/// sample; it adds to the 1 - p that eq. (2) leaves, and is a tenth of it at p = 0.99. docs/algorithms.md derives it.
inline constexpr double kMissProbability = 1e-3;

/// Where hypotheses are compared with the bar: after so many sampled data.
inline constexpr std::array<std::uint32_t, 3> kCheckpoints{256, 1024, kSampledData};

/// A model's support in the sample, up to each checkpoint. Beyond one that was not reached: -1.
struct SampleScore {
  std::array<double, kCheckpoints.size()> value{-1.0, -1.0, -1.0};  ///< What is maximised.
  std::uint64_t inliers = 0;                                        ///< Of the whole sample.
};

/// The least value at each checkpoint with which a hypothesis stays in the race.
struct Bar {
  /// By default every model passes that has any support.
  std::array<double, kCheckpoints.size()> least{-std::numeric_limits<double>::infinity(),
                                                -std::numeric_limits<double>::infinity(), 0.0};

  /// Every model that reaches more than `to_beat` in the end passes: a datum adds at most 1. For `sampled` data that are all.
  static Bar exact(double to_beat, std::uint64_t sampled);
  /// A model whose share of the data (value / number) is at least `share` passes with probability 1 - kMissProbability.
  static Bar likely(double share, std::uint64_t sampled);

  /// Whether a model with this value stays at one checkpoint.
  [[nodiscard]] bool passed_at(std::size_t checkpoint, double value) const { return value > least[checkpoint]; }
  /// Whether a model stays at all of them.
  [[nodiscard]] bool passed_by(const SampleScore& score) const {
    return passed_at(0, score.value[0]) && passed_at(1, score.value[1]) && passed_at(2, score.value[2]);
  }
};

/// The smallest share that m data show with probability above `miss` when the expected share is `expected` (the bound above).
double least_likely_share(double expected, std::uint64_t m, double miss);

}  // namespace fransac::sac
