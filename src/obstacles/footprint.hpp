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
  static constexpr int kDirections = 16;  ///< Over half a turn;
  static constexpr std::size_t kExtremes = 2 * std::size_t{kDirections};

  Footprint() { extremes_.fill(Eigen::Vector2d::Zero()); }

  void add(const Eigen::Vector2d& point);
  /// The rectangle of least area around what was added; at least one point.
  [[nodiscard]] Rectangle rectangle() const;

 private:
  using Reaches = Eigen::Array<double, kDirections, 1>;
  using Rough = Eigen::Array<float, kDirections, 1>;

  Reaches most_ = Reaches::Constant(-std::numeric_limits<double>::infinity());
  Reaches least_ = Reaches::Constant(std::numeric_limits<double>::infinity());
  // What floats say is within these is within those.
  double size_ = 0.0;  ///< Of the points' coordinates.
  Rough inner_most_ = Rough::Constant(-std::numeric_limits<float>::infinity());
  Rough inner_least_ = Rough::Constant(std::numeric_limits<float>::infinity());
  std::array<Eigen::Vector2d, kExtremes> extremes_;  ///< Where they were seen, the most and the least of a direction in turn.
};

}  // namespace fransac::obstacles
