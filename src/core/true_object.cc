// SPDX-License-Identifier: Apache-2.0
#include "fransac/core/true_object.hpp"

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>

namespace fransac {

Eigen::Vector3d ahead_of_camera(const Eigen::Vector3d& up) {
  // Nearer to the viewing direction than this (the sine of the angle between them), `up` leaves it no direction across.
  constexpr double kParallel = 1e-3;
  Eigen::Vector3d ahead = Eigen::Vector3d::UnitZ() - up.z() * up;
  if (ahead.norm() < kParallel) ahead = -Eigen::Vector3d::UnitY() + up.y() * up;
  return ahead.normalized();
}

double OrientedBox::yaw_rad() const {
  const Eigen::Vector3d ahead = ahead_of_camera(up);
  const double yaw = std::atan2(up.cross(ahead).dot(along), ahead.dot(along));
  const double half_turn = std::numbers::pi;
  if (yaw > 0.5 * half_turn) return yaw - half_turn;
  return yaw <= -0.5 * half_turn ? yaw + half_turn : yaw;
}

}  // namespace fransac
