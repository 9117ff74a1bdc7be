// SPDX-License-Identifier: Apache-2.0
#include "obstacles/floor_error.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

namespace fransac::obstacles {

FloorError::FloorError(const Segmentation& segmentation, const PlaneSegment& support, const DepthNoise& pixel, double sigmas)
    : normal_(support.plane.normal),
      covariance_(support.covariance),
      pixel_(pixel),
      slow_(segmentation.slow_noise),
      bias_m_(segmentation.bias_m),
      sigmas_(sigmas),
      middle_(support.centroid) {
  const auto squares = [](double a, double b) { return a * a + b * b; };
  constant_ = squares(pixel_.constant_m, slow_.constant_m);
  linear_ = squares(pixel_.linear, slow_.linear);
  quadratic_ = squares(pixel_.quadratic_per_m, slow_.quadratic_per_m);
  if (!(middle_.z() > 0.0) || !(support.area_m2 > 0.0)) return;
  // A disc's standard deviation along a line is half of its radius.
  const double spread = 0.5 * std::sqrt(support.area_m2 / std::numbers::pi);
  tilt_rad_ = bias_m_ * slant(middle_) / spread;
}

double FloorError::most_m(const Eigen::Vector3d& point) const {
  const double steep = slant(point);
  const double zz = point.z() * point.z();
  const double along_ray = constant_ + zz * (linear_ + zz * quadratic_);
  const double of_plane = covariance_(3, 3) + 2.0 * covariance_.topRightCorner<3, 1>().dot(point) +
                          point.dot(covariance_.topLeftCorner<3, 3>() * point);
  const double noise = std::sqrt(steep * steep * along_ray + std::max(0.0, of_plane));
  return sigmas_ * noise + bias_m_ * steep + tilt_rad_ * (point - middle_).norm();
}

}  // namespace fransac::obstacles
