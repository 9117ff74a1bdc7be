// SPDX-License-Identifier: Apache-2.0
#include "calibrate/noise.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>

namespace fransac::calibration {
namespace {

constexpr double kBinRatio = 1.15;          // of a bin's depths
constexpr std::size_t kMinInBin = 30;       // the median's own error: a quarter of a window's
constexpr double kMinDepthRatio = 1.5;      // of the farthest bin to the nearest: the terms' variances differ by 2.2 and 5
constexpr int kSlowWindows = 6;             // 48 pixels of 640: "tens of pixels"
constexpr double kMedianOfNormal = 0.6745;  // |x| of a standard normal x is below it in half of all cases

/// The terms' variances at a depth, of coefficients 1.
Eigen::Vector3d terms_at(double z) { return {1.0, z * z, z * z * z * z}; }

}  // namespace

double median(std::vector<double>& values) {
  if (values.empty()) return 0.0;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

std::vector<NoiseAtDepth> noise_by_depth(std::span<const PlaneWindows> planes) {
  struct Bin {
    std::vector<double> depths;
    std::vector<double> variances;
  };
  std::map<int, Bin> bins;
  double freedom = 1.0;
  for (const PlaneWindows& plane : planes) {
    for (const Window& window : plane.windows) {
      const double z = 1.0 / window.q;
      Bin& bin = bins[static_cast<int>(std::floor(std::log(z) / std::log(kBinRatio)))];
      bin.depths.push_back(z);
      bin.variances.push_back(window.variance * z * z * z * z);
      freedom = window.count - 3.0;
    }
  }
  // The median of chi squared over its degrees of freedom (Wilson & Hilferty 1931).
  const double of_chi_squared = std::pow(1.0 - 2.0 / (9.0 * freedom), 3);
  std::vector<NoiseAtDepth> noise;
  for (auto& [number, bin] : bins) {
    if (bin.depths.size() < kMinInBin) continue;
    noise.push_back({median(bin.depths), std::sqrt(median(bin.variances) / of_chi_squared), bin.depths.size()});
  }
  return noise;
}

DepthNoise fit_law(std::span<const NoiseAtDepth> noise, SensorKind kind) {
  if (noise.empty()) return {};
  const bool told_apart = noise.back().z_m >= kMinDepthRatio * noise.front().z_m;
  const unsigned alone = kind == SensorKind::time_of_flight ? 2U : 4U;
  // With three terms every set of those that are not zero can be tried.
  double least = std::numeric_limits<double>::infinity();
  Eigen::Vector3d best = Eigen::Vector3d::Zero();
  for (unsigned set = 1; set < 8; ++set) {
    if (!told_apart && set != alone) continue;
    Eigen::Matrix3d normal = Eigen::Matrix3d::Zero();
    Eigen::Vector3d right = Eigen::Vector3d::Zero();
    double windows = 0.0;
    for (const NoiseAtDepth& bin : noise) {
      if (!(bin.sigma_m > 0.0)) continue;
      const auto weight = static_cast<double>(bin.windows);
      Eigen::Vector3d row = terms_at(bin.z_m) / (bin.sigma_m * bin.sigma_m);
      for (unsigned i = 0; i < 3; ++i) row[i] *= (set >> i) & 1U;
      normal += weight * row * row.transpose();
      right += weight * row;
      windows += weight;
    }
    for (unsigned i = 0; i < 3; ++i) {
      if (((set >> i) & 1U) == 0) normal(i, i) = 1.0;
    }
    const Eigen::Vector3d solution = normal.ldlt().solve(right);
    if (!solution.allFinite() || solution.minCoeff() < 0.0) continue;
    const double left = windows - solution.dot(right);
    if (left < least) {
      least = left;
      best = solution;
    }
  }
  return {std::sqrt(best[0]), std::sqrt(best[1]), std::sqrt(best[2])};
}

double slow_share(std::span<const PlaneWindows> planes, const Distortion& distortion, const DepthNoise& law) {
  std::vector<double> differences;
  double count = 1.0;
  const auto corrected = [&](const Window& w) { return w.q + correction_at(distortion, w.x, w.y, w.q); };
  for (const PlaneWindows& plane : planes) {
    for (const Window& here : plane.windows) {
      for (const auto& [down, right] : {std::array{0, kSlowWindows}, std::array{kSlowWindows, 0}}) {
        const Window* const before = plane.find(here.row - down, here.column - right);
        const Window* const after = plane.find(here.row + down, here.column + right);
        if (before == nullptr || after == nullptr) continue;
        const double difference = corrected(here) - 0.5 * (corrected(*before) + corrected(*after));
        const double sigma = law.sigma_m(1.0 / here.q) * here.q * here.q;
        if (sigma > 0.0) differences.push_back(std::abs(difference) / sigma);
        count = here.count;
      }
    }
  }
  // A difference has 1.5 times a window's variance; what of it is the mean of independent pixels is not slow.
  const double window = median(differences) / kMedianOfNormal;
  return std::sqrt(std::max(0.0, window * window / 1.5 - 1.0 / count));
}

}  // namespace fransac::calibration
