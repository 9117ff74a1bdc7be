// SPDX-License-Identifier: Apache-2.0
#include "fransac/sac/plane_problem.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "core/parallel_sum.hpp"
#include "kernels/points.h"

namespace fransac::sac {
namespace {

static_assert(kernels::kBlock == PointCloud::kBlock);

kernels::PlaneF to_float(const Plane& plane) {
  return {static_cast<float>(plane.normal.x()), static_cast<float>(plane.normal.y()), static_cast<float>(plane.normal.z()),
          static_cast<float>(plane.d)};
}

/// Blocks of points [first, end) of a cloud, as kernels want them.
struct Stretch {
  const float* x;
  const float* y;
  const float* z;
  std::size_t size;
};

Stretch stretch(const PointCloud& cloud, std::size_t first, std::size_t end) {
  return {cloud.x() + first, cloud.y() + first, cloud.z() + first, end - first};
}

/// Score of a stretch that is short enough for a float to hold its gain.
Score score_of(const Stretch& s, const kernels::PlaneF& plane, float threshold, Scoring scoring) {
  if (scoring == Scoring::inliers) {
    const std::uint32_t inliers = kernels::count_inliers(s.x, s.y, s.z, s.size, plane, threshold);
    return {static_cast<double>(inliers), inliers};
  }
  const kernels::Msac msac = kernels::msac(s.x, s.y, s.z, s.size, plane, threshold);
  return {static_cast<double>(msac.gain), msac.inliers};
}

Moments moments_of(const Stretch& stretch, const kernels::PlaneF& plane, float threshold) {
  const kernels::InlierMoments m = kernels::inlier_moments(stretch.x, stretch.y, stretch.z, stretch.size, plane, threshold);
  const double* const s = m.sums;
  Moments moments;
  moments.count = m.count;
  moments.sum << s[0], s[1], s[2];
  moments.sum_outer << s[3], s[4], s[5], s[4], s[6], s[7], s[5], s[7], s[8];
  return moments;
}

std::optional<Plane> plane_of(const Moments& moments) {
  const std::optional<PlaneFit> fit = fit_plane(moments);
  if (!fit) return std::nullopt;
  return fit->plane;
}

/// What one task looks at; fixed, so that sums do not depend on the number of threads.
constexpr std::size_t kTaskPoints = std::size_t{1} << 16;
/// Points whose MSAC gain a float holds well, and which stay in the first-level cache (3 x 8 KiB).
constexpr std::size_t kStretchPoints = 2048;

/// Adds up part(first, end) over the tasks of a cloud, in order.
template <class Sum, class Part>
Sum sum_over_tasks(const PointCloud& cloud, int threads, const Part& part) {
  const std::size_t n = cloud.padded_size();
  const std::size_t tasks = (n + kTaskPoints - 1) / kTaskPoints;
  return parallel_sum<Sum>(threads, tasks,
                           [&](std::size_t task) { return part(task * kTaskPoints, std::min(n, (task + 1) * kTaskPoints)); });
}

}  // namespace

Score& operator+=(Score& sum, const Score& part) {
  sum.value += part.value;
  sum.inliers += part.inliers;
  return sum;
}

void CloudData::draw(RandomStream& random, std::uint32_t n, PointCloud& sample) const {
  if (n >= cloud_->size()) {
    sample = *cloud_;
    return;
  }
  sample.origin = cloud_->origin;
  sample.source.clear();
  sample.resize_uninitialised(n);
  const auto size = static_cast<std::uint32_t>(cloud_->size());
  for (std::uint32_t k = 0; k < n; ++k) {
    const std::uint32_t i = random.below(size);
    sample.x()[k] = cloud_->x()[i];
    sample.y()[k] = cloud_->y()[i];
    sample.z()[k] = cloud_->z()[i];
  }
}

Score CloudData::score(const Plane& plane, float threshold, Scoring scoring, const Score& to_beat) const {
  const kernels::PlaneF plane_f = to_float(plane);
  const auto part = [&](std::size_t first, std::size_t end) {
    Score sum;
    for (; first < end; first += kStretchPoints) {
      sum += score_of(stretch(*cloud_, first, std::min(end, first + kStretchPoints)), plane_f, threshold, scoring);
    }
    return sum;
  };
  if (threads_ != 1) return sum_over_tasks<Score>(*cloud_, threads_, part);
  // Bail-out: a point adds at most 1, so after some tasks a plane may be unable to win. Exact: it costs nothing but losers.
  Score sum;
  for (std::size_t first = 0; first < cloud_->padded_size(); first += kTaskPoints) {
    if (sum.value + static_cast<double>(cloud_->size() - first) <= to_beat.value) break;
    sum += part(first, std::min(cloud_->padded_size(), first + kTaskPoints));
  }
  return sum;
}

Moments CloudData::inlier_moments(const Plane& plane, float threshold) const {
  const kernels::PlaneF plane_f = to_float(plane);
  return sum_over_tasks<Moments>(*cloud_, threads_, [&](std::size_t first, std::size_t end) {
    return moments_of(stretch(*cloud_, first, end), plane_f, threshold);
  });
}

NormalLimits NormalLimits::parallel(const Eigen::Vector3d& axis, double angle_rad) {
  return {.axis = axis.normalized(), .min_cosine = std::cos(std::clamp(angle_rad, 0.0, std::numbers::pi / 2))};
}

NormalLimits NormalLimits::perpendicular(const Eigen::Vector3d& axis, double angle_rad) {
  return {.axis = axis.normalized(), .max_cosine = std::sin(std::clamp(angle_rad, 0.0, std::numbers::pi / 2))};
}

bool NormalLimits::allow(const Plane& plane) const {
  const double cosine = std::abs(plane.normal.dot(axis));
  return cosine >= min_cosine && cosine <= max_cosine;
}

PlaneProblem::PlaneProblem(const PlaneData& data, double threshold_m, Scoring scoring, std::uint64_t seed, std::uint32_t round,
                           PointCloud& sample, const std::optional<NormalLimits>& limits)
    : data_(&data),
      sample_(&sample),
      threshold_(std::max(static_cast<float>(threshold_m), kMinThreshold)),
      scoring_(scoring),
      limits_(limits) {
  constexpr std::uint64_t kStream = 0xFFFFFFFF;  // no hypothesis has this number
  RandomStream random(seed, (std::uint64_t{round} << 32) + kStream);
  data.draw(random, kSampledData, sample);
}

std::optional<Plane> PlaneProblem::generate(const std::array<std::uint32_t, 3>& sample) const {
  return allowed(plane_through(sample_->local(sample[0]), sample_->local(sample[1]), sample_->local(sample[2])));
}

bool PlaneProblem::is_inlier(const Plane& plane, std::uint32_t i) const {
  return std::abs(plane.signed_distance(sample_->local(i))) <= static_cast<double>(threshold_);
}

void PlaneProblem::score(std::span<const Plane> planes, const Bar& bar, std::span<SampleScore> scores) const {
  for (std::size_t m = 0; m < planes.size(); ++m) {
    const kernels::PlaneF plane = to_float(planes[m]);
    scores[m] = {};
    Score sum;
    std::size_t first = 0;
    for (std::size_t c = 0; c < kCheckpoints.size(); ++c) {
      const std::size_t end = std::min<std::size_t>(kCheckpoints[c], sample_->padded_size());
      for (; first < end; first += kStretchPoints) {
        sum += score_of(stretch(*sample_, first, std::min(end, first + kStretchPoints)), plane, threshold_, scoring_);
      }
      first = end;
      scores[m].value[c] = sum.value;
      if (!bar.passed_at(c, sum.value)) break;
    }
    scores[m].inliers = sum.inliers;
  }
}

std::optional<Plane> PlaneProblem::refine(const Plane& plane) const {
  return allowed(plane_of(moments_of(stretch(*sample_, 0, sample_->padded_size()), to_float(plane), threshold_)));
}

std::optional<Plane> PlaneProblem::refine_on_all(const Plane& plane) const {
  return allowed(plane_of(data_->inlier_moments(plane, threshold_)));
}

std::optional<Plane> PlaneProblem::allowed(const std::optional<Plane>& plane) const {
  return plane && limits_ && !limits_->allow(*plane) ? std::nullopt : plane;
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

}  // namespace fransac::sac
