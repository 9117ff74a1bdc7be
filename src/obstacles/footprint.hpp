// SPDX-License-Identifier: Apache-2.0
/// The smallest rectangle around points of the ground.
#pragma once

#include <Eigen/Core>
#include <array>
#include <limits>

namespace fransac::obstacles {

struct Rectangle {
  Eigen::Vector2d centre = Eigen::Vector2d::Zero();
  double length = 0.0;  ///< The longer side.
  double width = 0.0;
  double yaw_rad = 0.0;  ///< Of the longer side, in (-pi/2, pi/2].
};

/// Keeps the extreme points in some directions; what is between these directions sticks out of their hull: by less than half a
/// percent of a round thing's radius, at worst, a flat triangle's top, by a twentieth of its length.
class Footprint {
 public:
  static constexpr std::size_t kDirections = 16;  ///< Over half a turn;
  static constexpr std::size_t kExtremes = 2 * kDirections;

  void add(const Eigen::Vector2d& point);
  /// The rectangle of least area around what was added; at least one point.
  [[nodiscard]] Rectangle rectangle() const;

 private:
  struct Extreme {
    double reach = -std::numeric_limits<double>::infinity();
    Eigen::Vector2d point = Eigen::Vector2d::Zero();
  };
  std::array<Extreme, kExtremes> extremes_;
};

}  // namespace fransac::obstacles
