// SPDX-License-Identifier: Apache-2.0
/// The origin of a cloud whose coordinates are too large for float.
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <vector>

namespace fransac {

/// Above this a float is coarser than 0.06 mm (2^-14 m from 1024 m on), and a cloud gets a local origin. Metres.
inline constexpr double kFarFromZero_m = 1000.0;

/// For PointCloud::origin: the coordinate-wise median, in whole metres so that subtracting it is exact; zero for clouds near
/// zero. The median and not the box's centre: one wild point must not spoil the others' precision.
/// `coordinate(i)` is the i-th point, an Eigen::Vector3d; those that are not finite do not count.
template <class Coordinate>
Eigen::Vector3d choose_origin(std::size_t size, const Coordinate& coordinate) {
  bool far = false;
  for (std::size_t i = 0; i < size && !far; ++i) {
    const Eigen::Vector3d point = coordinate(i);
    far = point.allFinite() && point.cwiseAbs().maxCoeff() > kFarFromZero_m;
  }
  if (!far) return Eigen::Vector3d::Zero();
  std::array<std::vector<double>, 3> axes;
  for (std::size_t i = 0; i < size; ++i) {
    const Eigen::Vector3d point = coordinate(i);
    if (!point.allFinite()) continue;
    for (int axis = 0; axis < 3; ++axis) axes[static_cast<std::size_t>(axis)].push_back(point[axis]);
  }
  Eigen::Vector3d origin;
  for (int axis = 0; axis < 3; ++axis) {
    auto& values = axes[static_cast<std::size_t>(axis)];
    const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
    std::nth_element(values.begin(), middle, values.end());
    origin[axis] = std::round(*middle);
  }
  return origin;
}

}  // namespace fransac
