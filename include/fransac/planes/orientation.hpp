// SPDX-License-Identifier: Apache-2.0
/// What a plane is to somebody who stands on the ground.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <numbers>
#include <optional>
#include <span>

#include "fransac/core/plane.hpp"

namespace fransac {

class PointCloud;
struct PlaneSegment;

/// What a plane is to somebody who stands on the ground.
enum class PlaneKind {
  unknown,     ///< No up direction is known.
  floor,       ///< The lowest level plane below the sensor, with what else is at its level, unless something is seen lower.
  ceiling,     ///< The same upside down: the highest level plane above the sensor.
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

/// An up direction, and how well it is known.
struct UpEstimate {
  Eigen::Vector3d direction = Eigen::Vector3d::Zero();  ///< Unit vector.
  double sigma_rad = 0.0;                               ///< One sigma of its angle, in the direction known worst, radians.
};

/// The up direction that the planes suggest, in their coordinates, which must be a camera's (x right, y down, z forward): the one
/// that makes most planes level or vertical, each counting by its extent, confidence and the error of its normal, for a camera
/// that is held more or less level (up to some 20 degrees to the side, between 40 up and 70 down) or, rarely, turned by a
/// quarter. `portrait`: the image is higher than wide, so that a quarter turn is as likely as none. Nothing when that leaves a
/// doubt: no plane, walls of one direction only, a plane that could as well be the floor as a wall.
std::optional<UpEstimate> estimate_up(std::span<const PlaneSegment> planes, bool portrait = false);

/// How far a floor may be from level: a ramp of 1 : 12 is still one. Radians.
inline constexpr double kRamp_rad = 5.0 * std::numbers::pi / 180.0;
/// The most that counts as level or vertical, errors included. Radians.
inline constexpr double kLevel_rad = 10.0 * std::numbers::pi / 180.0;

/// One sigma of the angle of a plane's normal, radians; 0 where its covariance is not known.
double normal_sigma_rad(const PlaneSegment& plane);

/// How high a plane's visible part lies along `up` above the origin, metres; without a centroid its point nearest to the origin.
double height_along(const Eigen::Vector3d& up, const PlaneSegment& plane);

/// Fills `kind` of every plane. `up` is a unit vector in the planes' coordinates, `sensor` the position that they are seen from,
/// metres. Level and vertical mean: to within 10 degrees.
void classify(const Eigen::Vector3d& up, std::span<PlaneSegment> planes, const Eigen::Vector3d& sensor = Eigen::Vector3d::Zero());

/// The same of the planes of a cloud, whose `labels` are one per point. Points that lie lower tell that a plane is no floor.
/// Without the sensor's position, floor and ceiling follow from what lies above what: nothing lies above a ceiling, and it is two
/// metres or more above what lies lowest.
void classify(const Eigen::Vector3d& up, const PointCloud& cloud, std::span<const std::uint8_t> labels,
              const std::optional<Eigen::Vector3d>& sensor, std::span<PlaneSegment> planes);

}  // namespace fransac
