// SPDX-License-Identifier: Apache-2.0
/// When to stop sampling.
#pragma once

#include <cstdint>
#include <string_view>

namespace fransac {

/// Why the sampling loop ended.
enum class StopReason {
  confidence,      ///< Eq. (2): with the asked probability no better model was missed.
  max_iterations,  ///< The cap I.
  degenerate,      ///< No non-degenerate sample was found: the points are collinear or coincide.
};

/// The name of a reason as it stands in this header, for example "confidence".
std::string_view to_string(StopReason reason);

/// The number of iterations after which, with probability `probability`, at least one sample held inliers only and was
/// scored (Zeineldin & El-Fishawy eq. 2; Fischler & Bolles 1981):
///   N = log(1 - p) / log(1 - q^(m + d)),   q = inliers / points, m = sample size.
/// d is the number of pre-test points of T(d,d) (Matas & Chum 2004): a good hypothesis passes the pre-test with
/// probability q^d, so more must be drawn; d = 0 is eq. (2) itself.
/// Rounded up; at least 1; saturates at 2^63.
std::uint64_t required_iterations(double probability, double inlier_ratio, int sample_size, int pretest_points = 0);

}  // namespace fransac
