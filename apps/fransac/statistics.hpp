// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <vector>

namespace fransac::cli {

/// The smallest value that at least `share` of the values do not exceed (nearest rank); 0 without values.
inline double quantile(std::vector<double> values, double share) {
  if (values.empty()) return 0.0;
  const auto rank = static_cast<std::size_t>(std::ceil(share * static_cast<double>(values.size())));
  const auto at = values.begin() + static_cast<std::ptrdiff_t>(std::clamp<std::size_t>(rank, 1, values.size()) - 1);
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

inline double median(std::vector<double> values) { return quantile(std::move(values), 0.5); }

/// Quantiles of however many positive numbers in constant memory. Each is right to within kError of itself, between 1e-3 and 1e6
/// (Masson, Rim and Lee 2019, "DDSketch", section 2.2: counts in bins of equal ratio).
class QuantileSketch {
 public:
  static constexpr double kError = 0.005;

  void add(double value) {
    const double bin = std::ceil(std::log(value / kSmallest) / std::log(kRatio));
    ++counts_[static_cast<std::size_t>(std::clamp(bin, 0.0, static_cast<double>(kBins - 1)))];
    ++count_;
  }
  [[nodiscard]] std::size_t count() const { return count_; }
  /// As quantile() of all values.
  [[nodiscard]] double quantile(double share) const {
    const auto rank = std::max(1.0, std::ceil(share * static_cast<double>(count_)));
    std::size_t below = 0;
    for (std::size_t bin = 0; bin < kBins; ++bin) {
      below += counts_[bin];
      if (static_cast<double>(below) >= rank)
        return kSmallest * std::pow(kRatio, static_cast<double>(bin)) * 2.0 / (kRatio + 1.0);
    }
    return 0.0;
  }

 private:
  static constexpr double kSmallest = 1e-3;
  static constexpr double kRatio = (1.0 + kError) / (1.0 - kError);
  static constexpr std::size_t kBins = 2074;  // up to 1e6

  std::array<std::size_t, kBins> counts_{};
  std::size_t count_ = 0;
};

}  // namespace fransac::cli
