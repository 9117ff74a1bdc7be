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
  if (!(middle_.z() > 0.0) || !(support.area_m2 > 0.0)) return;
  // A disc's standard deviation along a line is half of its radius.
  const double spread = 0.5 * std::sqrt(support.area_m2 / std::numbers::pi);
  tilt_rad_ = bias_m_ * slant(middle_) / spread;
}

double FloorError::slant(const Eigen::Vector3d& point) const {
  return point.z() > 0.0 ? std::abs(normal_.dot(point)) / point.z() : 0.0;
}

double FloorError::most_m(const Eigen::Vector3d& point) const {
  const double of_plane = std::sqrt(std::max(0.0, point.homogeneous().dot(covariance_ * point.homogeneous())));
  const double noise = std::hypot(pixel_m(point), slow_m(point), of_plane);
  return sigmas_ * noise + bias_m_ * slant(point) + tilt_rad_ * (point - middle_).norm();
}

}  // namespace fransac::obstacles
