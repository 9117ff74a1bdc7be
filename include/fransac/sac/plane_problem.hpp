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

/// A plane fitted by total least squares, with its evidence.
struct PlaneFit {
  Plane plane;               ///< In the coordinates of the moments.
  std::uint64_t points = 0;  ///< That it was fitted to.
  double rms_m = 0.0;        ///< Root mean square distance of the points to the plane, metres.
};

/// Sums over points from which the least-squares plane follows; adding two is adding their points.
struct Moments {
  std::uint64_t count = 0;                              ///< Points.
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();        ///< Of p.
  Eigen::Matrix3d sum_outer = Eigen::Matrix3d::Zero();  ///< Sum of p p^T (symmetric).

  void add(const Eigen::Vector3d& point);     ///< Adds one point.
  Moments& operator+=(const Moments& other);  ///< Adds another's points.
};

/// The plane that minimises the sum of squared distances: through the mean, normal to the eigenvector of the
/// covariance's smallest eigenvalue. Nothing for fewer than three points or for collinear ones (the two smallest
/// eigenvalues cannot be told apart).
/// The moments must be taken about a point near the data (the cloud's local coordinates); `plane` is in those.
std::optional<PlaneFit> fit_plane(const Moments& moments);

/// All the data that a plane is searched in, wherever they are. Points are as in `PlaneProblem`: in one frame of coordinates.
class PlaneData {
 public:
  PlaneData() = default;  ///< Not to be copied.
  PlaneData(const PlaneData&) = delete;
  PlaneData& operator=(const PlaneData&) = delete;
  virtual ~PlaneData() = default;

  /// The number of points.
  [[nodiscard]] virtual std::uint64_t size() const = 0;
  /// Writes `n` points, drawn independently with replacement, to `sample` (capacity is kept); all of them in order when `n` is
  /// at least size().
  virtual void draw(RandomStream& random, std::uint32_t n, PointCloud& sample) const = 0;
  /// Support of a plane; when that cannot be more than `to_beat.value`, any score that is not.
  [[nodiscard]] virtual Score score(const Plane& plane, float threshold, Scoring scoring, const Score& to_beat) const = 0;
  /// Moments of the points within the threshold.
  [[nodiscard]] virtual Moments inlier_moments(const Plane& plane, float threshold) const = 0;
};

/// The points of a cloud (all finite), in its local coordinates.
class CloudData final : public PlaneData {
 public:
  /// `cloud` must outlive this. `threads`: 0 all cores; never changes the answer.
  explicit CloudData(const PointCloud& cloud, int threads = 1) : cloud_(&cloud), threads_(threads) {}

  [[nodiscard]] std::uint64_t size() const override { return cloud_->size(); }
  void draw(RandomStream& random, std::uint32_t n, PointCloud& sample) const override;
  [[nodiscard]] Score score(const Plane& plane, float threshold, Scoring scoring, const Score& to_beat) const override;
  [[nodiscard]] Moments inlier_moments(const Plane& plane, float threshold) const override;

 private:
  const PointCloud* cloud_;
  int threads_;
};

/// Thresholds below this are taken for it: its inverse, times any residual, is still a float.
inline constexpr float kMinThreshold = 1e-20F;

/// Which planes may be found: those whose normal makes an angle with an axis, as undirected lines, whose cosine is within limits.
struct NormalLimits {
  Eigen::Vector3d axis = Eigen::Vector3d::Zero();  ///< Unit vector.
  double min_cosine = 0.0;                         ///< Of the angle, 0 to 1.
  double max_cosine = 1.0;                         ///< Likewise.

  /// Normals within `angle_rad` of the axis.
  static NormalLimits parallel(const Eigen::Vector3d& axis, double angle_rad);
  /// Normals within `angle_rad` of being perpendicular to the axis.
  static NormalLimits perpendicular(const Eigen::Vector3d& axis, double angle_rad);

  /// Whether a plane's normal is within the limits.
  [[nodiscard]] bool allow(const Plane& plane) const;
};

/// A plane through three points; eq. (1): inlier when |n . p + d| <= t.
class PlaneProblem {
 public:
  using Model = Plane;                   ///< Of SamplingProblem.
  static constexpr int kSampleSize = 3;  ///< Of SamplingProblem.

  /// Draws the sample of `data` that hypotheses are made of and first compared on, into `sample`; both must outlive the problem.
  /// `threshold_m` is t. The draw is a function of `seed` and `round` alone. Samples whose plane `limits` do not allow count as
  /// degenerate, and no refinement leaves the limits.
  PlaneProblem(const PlaneData& data, double threshold_m, Scoring scoring, std::uint64_t seed, std::uint32_t round,
               PointCloud& sample, const std::optional<NormalLimits>& limits = std::nullopt);

  /// The number of all data.
  [[nodiscard]] std::uint64_t num_data() const { return data_->size(); }
  /// The number of sampled data.
  [[nodiscard]] std::uint32_t num_sampled() const { return static_cast<std::uint32_t>(sample_->size()); }
  /// The plane through three sampled points; nothing when they are collinear (plane_through).
  [[nodiscard]] std::optional<Plane> generate(const std::array<std::uint32_t, 3>& sample) const;
  /// Eq. (1) for sampled point i.
  [[nodiscard]] bool is_inlier(const Plane& plane, std::uint32_t i) const;
  /// Scores planes on the sample; those below the bar at a checkpoint are given up there.
  void score(std::span<const Plane> planes, const Bar& bar, std::span<SampleScore> scores) const;
  /// Least squares on the plane's sampled inliers.
  [[nodiscard]] std::optional<Plane> refine(const Plane& plane) const;
  /// The score on all data; when that cannot be more than `to_beat.value`, any score that is not.
  [[nodiscard]] Score verify(const Plane& plane, const Score& to_beat) const {
    return data_->score(plane, threshold_, scoring_, to_beat);
  }
  /// Least squares on all inliers.
  [[nodiscard]] std::optional<Plane> refine_on_all(const Plane& plane) const;

 private:
  /// The plane, if it may be found.
  [[nodiscard]] std::optional<Plane> allowed(const std::optional<Plane>& plane) const;

  const PlaneData* data_;
  const PointCloud* sample_;
  float threshold_;
  Scoring scoring_;
  std::optional<NormalLimits> limits_;
};

}  // namespace fransac::sac
