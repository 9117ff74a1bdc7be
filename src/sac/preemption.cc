// SPDX-License-Identifier: Apache-2.0
#include "fransac/sac/preemption.hpp"

#include <algorithm>
#include <cmath>

namespace fransac::sac {
namespace {

double divergence(double s, double f) {
  const auto term = [](double a, double b) { return a > 0.0 ? a * std::log(a / b) : 0.0; };
  return term(s, f) + term(1.0 - s, 1.0 - f);
}

}  // namespace

double least_likely_share(double expected, std::uint64_t m, double miss) {
  if (!(expected > 0.0)) return 0.0;
  if (expected >= 1.0) return 1.0;
  constexpr int kBisections = 40;
  const double most = -std::log(miss) / static_cast<double>(m);
  double low = 0.0;
  double high = expected;
  if (divergence(low, expected) <= most) return 0.0;
  for (int i = 0; i < kBisections; ++i) {
    const double middle = 0.5 * (low + high);
    (divergence(middle, expected) > most ? low : high) = middle;
  }
  return low;
}

Bar Bar::exact(double to_beat, std::uint64_t sampled) {
  Bar bar;
  for (std::size_t c = 0; c < kCheckpoints.size(); ++c) {
    const std::uint64_t seen = std::min<std::uint64_t>(kCheckpoints[c], sampled);
    bar.least[c] = to_beat - static_cast<double>(sampled - seen);
  }
  return bar;
}

Bar Bar::likely(double share, std::uint64_t sampled) {
  Bar bar;
  bar.least.fill(-std::numeric_limits<double>::infinity());
  constexpr double kMiss = kMissProbability / static_cast<double>(kCheckpoints.size());
  for (std::size_t c = 0; c < kCheckpoints.size(); ++c) {
    const std::uint64_t seen = std::min<std::uint64_t>(kCheckpoints[c], sampled);
    const double least_share = least_likely_share(share, seen, kMiss);
    if (least_share > 0.0) bar.least[c] = static_cast<double>(seen) * least_share;  // else even nothing is likely enough
  }
  return bar;
}

}  // namespace fransac::sac
