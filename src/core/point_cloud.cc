// SPDX-License-Identifier: Apache-2.0
#include "fransac/core/point_cloud.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

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

}  // namespace fransac
