// SPDX-License-Identifier: Apache-2.0
#include "fransac/core/true_object.hpp"

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>

namespace fransac {

double OrientedBox::yaw_rad() const {
  // Nearer to `up` than this (the sine of the angle between them), the x axis has no direction across it.
  constexpr double kParallel = 1e-6;
  Eigen::Vector3d forward = Eigen::Vector3d::UnitX() - up.x() * up;
  if (forward.norm() < kParallel) forward = Eigen::Vector3d::UnitZ() - up.z() * up;
  forward.normalize();
  const double yaw = std::atan2(up.cross(forward).dot(along), forward.dot(along));
  const double half_turn = std::numbers::pi;
  if (yaw > 0.5 * half_turn) return yaw - half_turn;
  return yaw <= -0.5 * half_turn ? yaw + half_turn : yaw;
}

}  // namespace fransac
