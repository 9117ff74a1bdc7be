// SPDX-License-Identifier: Apache-2.0
/// Objects: boxes that stand upright on something.
#pragma once

#include <Eigen/Core>
#include <optional>

#include "fransac/core/plane.hpp"

namespace fransac {

/// The camera's viewing direction as it lies across `up`, a unit vector; where it looks along `up`, the image's upward direction.
Eigen::Vector3d ahead_of_camera(const Eigen::Vector3d& up);

/// A box with one edge along the normal of what it stands on.
struct OrientedBox {
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();  ///< Metres.
  Eigen::Vector3d size = Eigen::Vector3d::Zero();    ///< Edges along `along`, `up` x `along` and `up`, metres.
  Eigen::Vector3d along = Eigen::Vector3d::UnitX();  ///< Unit vector across `up`.
  Eigen::Vector3d up = -Eigen::Vector3d::UnitY();    ///< Unit vector.

  /// Angle of `along` about `up` from ahead_of_camera(up), radians. A box looks the same after half a turn, so in (-pi/2, pi/2].
  [[nodiscard]] double yaw_rad() const;
};

/// What is known of a free-standing thing, in the camera's frame.
struct TrueObject {
  int id = 0;                    ///< As in the image of objects, 1 to 65535.
  OrientedBox box;               ///< Around all of it, seen or not.
  std::optional<Plane> support;  ///< The level surface under its middle, other objects aside; nothing where there is none.
  double lowest_m = 0.0;         ///< Where it begins above the support; 0 without one.
  double highest_m = 0.0;        ///< Where it ends.
};

}  // namespace fransac
