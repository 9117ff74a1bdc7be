// SPDX-License-Identifier: Apache-2.0
// From coordinates in double to a PointCloud and back.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <limits>

#include "fransac/core/labels.hpp"
#include "fransac/core/origin.hpp"
#include "fransac/core/point_cloud.hpp"
#include "fransac/io/overlay.hpp"

namespace fransac::io::cloud_formats {

/// `coordinate(i)` is the i-th point in the input's coordinates. Points that are not finite, or too far from the rest for
/// float, become NaN on all axes.
template <class Coordinate>
PointCloud assemble(std::size_t width, std::size_t height, const Coordinate& coordinate) {
  constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();
  PointCloud cloud;
  cloud.resize_uninitialised(width * height);
  cloud.width = static_cast<int>(width);
  cloud.height = static_cast<int>(height);
  cloud.origin = choose_origin(cloud.size(), coordinate);
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const Eigen::Vector3d local = coordinate(i) - cloud.origin;
    const bool fits = local.allFinite() && local.cwiseAbs().maxCoeff() <= static_cast<double>(std::numeric_limits<float>::max());
    cloud.set(i, fits ? Eigen::Vector3f(local.cast<float>()) : Eigen::Vector3f::Constant(kNaN));
  }
  return cloud;
}

/// The i-th point in the input's coordinates, NaN on all axes when one is not finite.
inline Eigen::Vector3d point_to_write(const PointCloud& cloud, std::size_t i) {
  return cloud.finite(i) ? cloud.point(i) : Eigen::Vector3d(Eigen::Vector3d::Constant(std::numeric_limits<double>::quiet_NaN()));
}

/// Coordinates with an origin need double; without one they are floats already.
inline bool needs_double(const PointCloud& cloud) { return !cloud.origin.isZero(0.0); }

struct Extent {
  std::size_t width = 0;
  std::size_t height = 0;
};
/// Columns and rows to write: those of an organised cloud, else one row.
inline Extent extent(const PointCloud& cloud) {
  const auto width = static_cast<std::size_t>(std::max(cloud.width, 0));
  const auto height = static_cast<std::size_t>(std::max(cloud.height, 0));
  return cloud.organised() && width * height == cloud.size() ? Extent{width, height} : Extent{cloud.size(), 1};
}

/// Grey where there is no plane.
inline std::array<std::uint8_t, 3> point_colour(std::uint8_t label) {
  constexpr std::uint8_t kGrey = 128;
  if (label == kLabelNoDepth || label == kLabelNoPlane) return {kGrey, kGrey, kGrey};
  return label_colour(label);
}

}  // namespace fransac::io::cloud_formats
