// SPDX-License-Identifier: Apache-2.0
#include "fransac/sac/plane_problem.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <cmath>

#include "kernels/points.h"

namespace fransac::sac {
namespace {

static_assert(kernels::kBlock == PointCloud::kBlock);

kernels::PlaneF to_float(const Plane& plane) {
  return {static_cast<float>(plane.normal.x()), static_cast<float>(plane.normal.y()), static_cast<float>(plane.normal.z()),
          static_cast<float>(plane.d)};
}

/// Moments of the inliers among `size` (whole blocks) points from `first` on.
Moments stretch_moments(const PointCloud& cloud, std::size_t first, std::size_t size, const Plane& plane, float threshold) {
  const kernels::InlierMoments m =
      kernels::inlier_moments(cloud.x() + first, cloud.y() + first, cloud.z() + first, size, to_float(plane), threshold);
  const double* const s = m.sums;
  Moments moments;
  moments.count = m.count;
  moments.sum << s[0], s[1], s[2];
  moments.sum_outer << s[3], s[4], s[5], s[4], s[6], s[7], s[5], s[7], s[8];
  return moments;
}

}  // namespace

std::optional<Plane> PlaneProblem::generate(const std::array<std::uint32_t, 3>& sample) const {
  return plane_through(cloud_->local(sample[0]), cloud_->local(sample[1]), cloud_->local(sample[2]));
}

bool PlaneProblem::is_inlier(const Plane& plane, std::uint32_t i) const {
  return std::abs(plane.signed_distance(cloud_->local(i))) <= static_cast<double>(threshold_);
}

void PlaneProblem::score(std::span<const Plane> planes, const Score& to_beat, std::span<Score> scores) const {
  // A stretch of points that stays in the first-level cache (3 x 8 KiB) while every plane looks at it.
  constexpr std::size_t kStretch = 2048;
  constexpr std::size_t kMaxPlanes = 64;
  if (planes.size() > kMaxPlanes) {
    score(planes.first(kMaxPlanes), to_beat, scores.first(kMaxPlanes));
    score(planes.subspan(kMaxPlanes), to_beat, scores.subspan(kMaxPlanes));
    return;
  }
  std::array<kernels::PlaneF, kMaxPlanes> plane_f{};
  std::transform(planes.begin(), planes.end(), plane_f.begin(), to_float);
  std::fill(scores.begin(), scores.end(), Score{});

  const std::size_t n = cloud_->padded_size();
  for (std::size_t first = 0; first < n; first += kStretch) {
    const std::size_t size = std::min(kStretch, n - first);
    const float* const x = cloud_->x() + first;
    const float* const y = cloud_->y() + first;
    const float* const z = cloud_->z() + first;
    for (std::size_t m = 0; m < planes.size(); ++m) {
      // Bail-out: a point adds at most 1, so this plane can no longer win. Exact: it costs nothing but losers.
      const auto remaining = static_cast<double>(cloud_->size() - first);
      if (scores[m].value + remaining <= to_beat.value) continue;
      if (scoring_ == Scoring::inliers) {
        scores[m].inliers += kernels::count_inliers(x, y, z, size, plane_f[m], threshold_);
        scores[m].value = static_cast<double>(scores[m].inliers);
      } else {
        const kernels::Msac part = kernels::msac(x, y, z, size, plane_f[m], threshold_);
        scores[m].inliers += part.inliers;
        scores[m].value += static_cast<double>(part.gain);
      }
    }
  }
}

std::optional<Plane> PlaneProblem::refine(const Plane& plane) const {
  // Some ten thousand inliers fix a plane far better than its noise matters to the score; a larger cloud is looked at in
  // evenly spread stretches.
  constexpr std::size_t kEnough = 32768;
  constexpr std::size_t kStretch = 256;
  const std::size_t n = cloud_->padded_size();
  const std::size_t step = std::max<std::size_t>(n / kEnough, 1) * kStretch;
  Moments moments;
  for (std::size_t first = 0; first < n; first += step) {
    moments += stretch_moments(*cloud_, first, std::min(kStretch, n - first), plane, threshold_);
  }
  const std::optional<PlaneFit> fit = fit_plane(moments);
  if (!fit) return std::nullopt;
  return fit->plane;
}

void Moments::add(const Eigen::Vector3d& point) {
  ++count;
  sum += point;
  sum_outer += point * point.transpose();
}

Moments& Moments::operator+=(const Moments& other) {
  count += other.count;
  sum += other.sum;
  sum_outer += other.sum_outer;
  return *this;
}

std::optional<PlaneFit> fit_plane(const Moments& moments) {
  if (moments.count < 3) return std::nullopt;
  const auto n = static_cast<double>(moments.count);
  const Eigen::Vector3d mean = moments.sum / n;
  const Eigen::Matrix3d covariance = moments.sum_outer / n - mean * mean.transpose();
  if (!covariance.allFinite()) return std::nullopt;
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(covariance);
  const Eigen::Vector3d& variance = solver.eigenvalues();  // ascending
  // What the subtraction above cannot resolve counts as zero: points that spread in one direction only are collinear.
  const double resolution = 1e-12 * (moments.sum_outer.trace() / n);
  if (!(variance[1] > resolution) || !(variance[1] > 1e-8 * variance[2])) return std::nullopt;
  const Eigen::Vector3d normal = solver.eigenvectors().col(0);
  const std::optional<Plane> plane = make_plane(normal, -normal.dot(mean));
  if (!plane) return std::nullopt;
  return PlaneFit{*plane, moments.count, std::sqrt(std::max(0.0, variance[0]))};
}

Moments inlier_moments(const PointCloud& cloud, const Plane& plane, double threshold_m) {
  return stretch_moments(cloud, 0, cloud.padded_size(), plane, static_cast<float>(threshold_m));
}

}  // namespace fransac::sac
