// SPDX-License-Identifier: Apache-2.0
/// What a plane is to somebody who stands on the ground.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <span>

#include "fransac/core/plane.hpp"

namespace fransac {

struct PlaneSegment;

/// What a plane is to somebody who stands on the ground.
enum class PlaneKind {
  unknown,     ///< No up direction is known.
  floor,       ///< The lowest level plane below the camera, with what else is at its level, unless something is seen lower.
  ceiling,     ///< The same upside down: the highest level plane above the camera.
  wall,        ///< Vertical.
  horizontal,  ///< Another level plane: a table top, a step, a shelf.
  other,       ///< Inclined.
};

/// How it is known what is up.
enum class UpSource {
  none,       ///< Unknown.
  given,      ///< By the user or an IMU.
  estimated,  ///< From the planes.
};

/// The up direction that the planes suggest, a unit vector in their coordinates, which must be a camera's (x right, y down,
/// z forward): the direction that makes most square metres level or vertical, for a camera that is held more or less level
/// (up to some 20 degrees to the side, between 40 up and 70 down). Nothing when that leaves a doubt: no plane, walls of one
/// direction only, a plane that could as well be the floor as a wall.
std::optional<Eigen::Vector3d> estimate_up(std::span<const PlaneSegment> planes);

/// Fills `kind` of every plane. `up` is a unit vector in the planes' coordinates, whose origin is the camera. Level and
/// vertical mean: to within 10 degrees.
void classify(const Eigen::Vector3d& up, std::span<PlaneSegment> planes);

}  // namespace fransac
