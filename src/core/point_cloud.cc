// SPDX-License-Identifier: Apache-2.0
#include "fransac/core/point_cloud.hpp"

#include <algorithm>
#include <cmath>
#include <exception>
#include <limits>
#include <string>

#include "core/caught.hpp"
#include "core/number_text.hpp"

namespace fransac {

bool PointCloud::finite(std::size_t i) const { return std::isfinite(x_[i]) && std::isfinite(y_[i]) && std::isfinite(z_[i]); }

bool PointCloud::measured(std::size_t i) const {
  const Eigen::Vector3f zero = (-origin).cast<float>();  // where the reader put (0, 0, 0)
  return finite(i) && !(x_[i] == zero.x() && y_[i] == zero.y() && z_[i] == zero.z());
}

void PointCloud::resize(std::size_t size) {
  const std::size_t old_size = size_;
  resize_uninitialised(size);
  constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();
  for (auto* axis : {&x_, &y_, &z_}) {
    if (size > old_size) std::fill(axis->begin() + static_cast<std::ptrdiff_t>(old_size), axis->end(), kNaN);
  }
}

void PointCloud::resize_uninitialised(std::size_t size) {
  size_ = size;
  for (auto* axis : {&x_, &y_, &z_}) {
    if (axis->size() < padded_size()) axis->resize(padded_size());
  }
  pad();
}

void PointCloud::set(std::size_t i, const Eigen::Vector3f& local_point) {
  x_[i] = local_point.x();
  y_[i] = local_point.y();
  z_[i] = local_point.z();
}

void PointCloud::pad() {
  constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();
  for (auto* axis : {&x_, &y_, &z_}) {
    std::fill(axis->begin() + static_cast<std::ptrdiff_t>(size_), axis->begin() + static_cast<std::ptrdiff_t>(padded_size()),
              kNaN);
  }
}

Status validate_position(const Eigen::Vector3d& position, std::string_view name) try {
  if ((position.array().abs() <= kMaxCoordinate_m).all()) return {};  // false for NaN
  return Error{ErrorCode::invalid_argument,
               std::string(name) + ": must be finite, with no coordinate beyond " + number_text(kMaxCoordinate_m) + " m"};
} catch (const std::exception& exception) {
  return caught(exception, "position");
}

Status validate(const PointCloud& cloud) try {
  if (cloud.size() > static_cast<std::size_t>(std::numeric_limits<int>::max())) {
    return Error{ErrorCode::unsupported,
                 "point cloud: " + std::to_string(cloud.size()) + " points; at most 2^31 - 1 are supported"};
  }
  const std::size_t organised_size =
      static_cast<std::size_t>(std::max(cloud.width, 0)) * static_cast<std::size_t>(std::max(cloud.height, 0));
  if (cloud.organised() && organised_size != cloud.size()) {
    return Error{ErrorCode::invalid_argument, "point cloud: width x height is not its number of points"};
  }
  if (Status status = validate_position(cloud.origin, "point cloud: origin"); !status) return status;
  return cloud.sensor_position ? validate_position(*cloud.sensor_position, "point cloud: sensor position") : Status();
} catch (const std::exception& exception) {
  return caught(exception, "point cloud");
}

}  // namespace fransac
