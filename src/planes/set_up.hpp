// SPDX-License-Identifier: Apache-2.0
/// Which way is up, where the sensor was, and what that makes of the planes.
#pragma once

#include <Eigen/Core>
#include <cmath>
#include <optional>

#include "fransac/core/point_cloud.hpp"
#include "fransac/planes/orientation.hpp"
#include "fransac/planes/segment.hpp"

namespace fransac {

/// A finite vector that is not 0 at unit length, however long it is.
inline Eigen::Vector3d unit(const Eigen::Vector3d& v) {
  const bool squares = std::isnormal(v.squaredNorm());  // they neither overflow nor vanish
  return squares ? v.normalized() : Eigen::Vector3d(v / v.cwiseAbs().maxCoeff()).normalized();
}

/// Of a depth image. What the options leave open is estimated if the planes have areas and covariances: those of `cells`.
inline void set_up(const SegmentOptions& options, Segmentation& s) {
  s.sensor_position = options.sensor_position.value_or(Eigen::Vector3d::Zero());
  if (options.up) {
    s.up = unit(*options.up);
    s.up_source = UpSource::given;
  } else if (s.method == Method::cells) {
    const std::optional<UpEstimate> estimate = estimate_up(s.planes, s.height > s.width);
    if (!estimate) return;
    s.up = estimate->direction;
    s.up_sigma_rad = estimate->sigma_rad;
    s.up_source = UpSource::estimated;
  }
  if (s.up) classify(*s.up, s.planes, *s.sensor_position);
}

/// Of a cloud.
inline void set_up(const SegmentOptions& options, const PointCloud& cloud, Segmentation& s) {
  s.sensor_position = options.sensor_position ? options.sensor_position : cloud.sensor_position;
  if (!options.up) return;
  s.up = unit(*options.up);
  s.up_source = UpSource::given;
  classify(*s.up, cloud, s.labels, s.sensor_position, s.planes);
}

}  // namespace fransac
