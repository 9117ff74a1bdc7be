// SPDX-License-Identifier: Apache-2.0
/// A map of the ground in squares.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

namespace fransac {

/// Values as in ROS's nav_msgs/OccupancyGrid.
struct OccupancyGrid {
  static constexpr std::int8_t kUnknown = -1;    ///< Not seen.
  static constexpr std::int8_t kFree = 0;        ///< The support is seen, and nothing on it.
  static constexpr std::int8_t kOccupied = 100;  ///< Something is there, or the ground is missing.

  double resolution_m = 0.05;                          ///< Side of a square.
  int width = 0;                                       ///< Along x.
  int height = 0;                                      ///< Along y.
  Eigen::Vector2d origin_m = Eigen::Vector2d::Zero();  ///< Of the corner of cells[0] with the smallest x and y.
  std::vector<std::int8_t> cells;                      ///< Row by row of y, the smallest y first.
};

}  // namespace fransac
