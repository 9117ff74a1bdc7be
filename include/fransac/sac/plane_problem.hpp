// SPDX-License-Identifier: Apache-2.0
/// Plane fitting as a problem for the sampling loop.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <optional>
#include <span>

#include "fransac/core/plane.hpp"
#include "fransac/core/point_cloud.hpp"
#include "fransac/sac/ransac.hpp"

namespace fransac::sac {

/// How hypotheses are compared.
enum class Scoring {
  inliers,  ///< The number of inliers (the paper, eq. 1).
  msac,     ///< The sum over the inliers of 1 - (r / t)^2: the truncated squared loss of MSAC (Torr & Zisserman 2000).
};

/// A plane in the cloud's local coordinates; three points; eq. (1): inlier when |n . p + d| <= t.
class PlaneProblem {
 public:
  using Model = Plane;
  static constexpr int kSampleSize = 3;

  /// `cloud` (all points finite, at most 2^32 - 1 of them) must outlive the problem. `threshold_m` is t.
  PlaneProblem(const PointCloud& cloud, double threshold_m, Scoring scoring)
      : cloud_(&cloud), threshold_(std::max(static_cast<float>(threshold_m), kMinThreshold)), scoring_(scoring) {}

  [[nodiscard]] std::uint32_t num_data() const { return static_cast<std::uint32_t>(cloud_->size()); }
  [[nodiscard]] std::optional<Plane> generate(const std::array<std::uint32_t, 3>& sample) const;
  [[nodiscard]] bool is_inlier(const Plane& plane, std::uint32_t i) const;
  void score(std::span<const Plane> planes, const Score& to_beat, std::span<Score> scores) const;
  /// Least squares on the plane's inliers; in large clouds on those of evenly spread stretches, some ten thousand points.
  [[nodiscard]] std::optional<Plane> refine(const Plane& plane) const;

 private:
  static constexpr float kMinThreshold = 1e-20F;  // its inverse, times any residual, is still a float

  const PointCloud* cloud_;
  float threshold_;
  Scoring scoring_;
};

/// A plane fitted by total least squares, with its evidence.
struct PlaneFit {
  Plane plane;
  std::uint64_t points = 0;
  double rms_m = 0.0;  ///< Root mean square distance of the points to the plane, metres.
};

/// Sums over points from which the least-squares plane follows; adding two is adding their points.
struct Moments {
  std::uint64_t count = 0;
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  Eigen::Matrix3d sum_outer = Eigen::Matrix3d::Zero();  ///< Sum of p p^T (symmetric).

  void add(const Eigen::Vector3d& point);
  Moments& operator+=(const Moments& other);
};

/// The plane that minimises the sum of squared distances: through the mean, normal to the eigenvector of the
/// covariance's smallest eigenvalue. Nothing for fewer than three points or for collinear ones (the two smallest
/// eigenvalues cannot be told apart).
/// The moments must be taken about a point near the data (the cloud's local coordinates); `plane` is in those.
std::optional<PlaneFit> fit_plane(const Moments& moments);

/// Moments of the points of the cloud (local coordinates) within `threshold_m` of the plane.
Moments inlier_moments(const PointCloud& cloud, const Plane& plane, double threshold_m);

}  // namespace fransac::sac
