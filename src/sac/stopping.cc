// SPDX-License-Identifier: Apache-2.0
#include "fransac/sac/stopping.hpp"

#include <cmath>

namespace fransac {

std::string_view to_string(StopReason reason) {
  switch (reason) {
    case StopReason::confidence: return "confidence";
    case StopReason::max_iterations: return "max_iterations";
    case StopReason::degenerate: return "degenerate";
  }
  return "unknown";
}

std::uint64_t required_iterations(double probability, double inlier_ratio, int sample_size, int pretest_points) {
  constexpr double kMost = 0x1p63;
  const double good = std::pow(inlier_ratio, sample_size + pretest_points);
  if (good >= 1.0) return 1;
  if (!(good > 0.0)) return static_cast<std::uint64_t>(kMost);
  // log1p keeps its precision where good is tiny.
  const double n = std::ceil(std::log1p(-probability) / std::log1p(-good));
  if (!(n < kMost)) return static_cast<std::uint64_t>(kMost);
  return n < 1.0 ? 1 : static_cast<std::uint64_t>(n);
}

}  // namespace fransac
