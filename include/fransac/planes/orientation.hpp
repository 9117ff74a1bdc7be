// SPDX-License-Identifier: Apache-2.0
/// What a plane is to somebody who stands on the ground.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <span>

#include "fransac/core/plane.hpp"

namespace fransac {

struct PlaneSegment;

enum class PlaneKind {
  unknown,     ///< No up direction is known.
  floor,       ///< The lowest horizontal plane below the camera that faces up.
  ceiling,     ///< Horizontal, above the camera, facing down, and the highest.
  wall,        ///< Vertical.
  horizontal,  ///< A table top, a step, a shelf.
  other,       ///< Inclined.
};

enum class UpSource {
  none,       ///< Unknown.
  given,      ///< By the user or an IMU.
  estimated,  ///< From the largest horizontal support that is consistent with the camera.
};

/// The up direction that the planes suggest: the normal of the plane with the most square metres that can be a floor, a table or
/// a ceiling to a camera that is held more or less level. Nothing when no plane can.
std::optional<Eigen::Vector3d> estimate_up(std::span<const PlaneSegment> planes);

/// Fills `kind` of every plane. `up` is a unit vector in the planes' coordinates.
void classify(const Eigen::Vector3d& up, std::span<PlaneSegment> planes);

}  // namespace fransac
