// SPDX-License-Identifier: Apache-2.0
/// By how much the floor may seem higher or lower than it is.
#pragma once

#include <Eigen/Core>
#include <cmath>

#include "fransac/core/sensor.hpp"
#include "fransac/planes/segment.hpp"

namespace fransac::obstacles {

/// Errors of heights above a support's plane: the sensor's three (Segmentation), and what they make of the plane. Pixel noise and
/// slow noise err along the ray. Bias does as well, and tilts the plane: what is a length at the support's middle grows with the
/// distance from there over the support's extent. docs/algorithms.md, "Floor that is bent".
class FloorError {
 public:
  /// `pixel` is the pixel noise. Without a centroid or an area of the support nothing is known of its tilt.
  FloorError(const Segmentation& segmentation, const PlaneSegment& support, const DepthNoise& pixel, double sigmas);

  /// Whether the sensor's noise is known at all.
  [[nodiscard]] bool is_known() const { return pixel_ != DepthNoise{}; }
  /// One sigma of the height of a pixel at a point, metres: pixel noise alone.
  [[nodiscard]] double pixel_m(const Eigen::Vector3d& point) const { return pixel_.sigma_m(point.z()) * slant(point); }
  /// One sigma of the slow noise of the height at a point, metres.
  [[nodiscard]] double slow_m(const Eigen::Vector3d& point) const { return slow_.sigma_m(point.z()) * slant(point); }
  /// What no floor exceeds at a point, metres: so many sigmas of noise and of the plane, and the bias.
  [[nodiscard]] double most_m(const Eigen::Vector3d& point) const;

  /// Whether the ray meets the floor at less than ten degrees. There neighbouring rows of pixels are so far apart on the floor
  /// that what is as low as most_m() cannot be told from it, whether it has steps or not.
  [[nodiscard]] bool is_grazing(const Eigen::Vector3d& point) const {
    constexpr double kGrazing = 0.17;  // the sine
    return slant(point) < kGrazing;
  }

 private:
  /// Height per metre of depth along a ray: the sine of the angle at which it meets the floor, times its length at depth 1.
  [[nodiscard]] double slant(const Eigen::Vector3d& point) const {
    return point.z() > 0.0 ? std::abs(normal_.dot(point)) / point.z() : 0.0;
  }

  Eigen::Vector3d normal_;
  Eigen::Matrix4d covariance_;
  DepthNoise pixel_;
  DepthNoise slow_;
  double constant_ = 0.0;  ///< Squares of the terms of both noises, added up.
  double linear_ = 0.0;
  double quadratic_ = 0.0;
  double bias_m_;
  double sigmas_;
  Eigen::Vector3d middle_;
  double tilt_rad_ = 0.0;  ///< By which bias may turn the plane.
};

}  // namespace fransac::obstacles
