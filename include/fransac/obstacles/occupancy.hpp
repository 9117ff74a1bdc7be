// SPDX-License-Identifier: Apache-2.0
/// The ground as a map of free, occupied and unknown squares.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <limits>
#include <vector>

#include "fransac/core/camera.hpp"
#include "fransac/core/depth_image.hpp"
#include "fransac/core/result.hpp"
#include "fransac/obstacles/obstacles.hpp"
#include "fransac/planes/segment.hpp"

namespace fransac {

struct OccupancyOptions {
  double resolution_m = 0.05;  ///< Side of a square.
  double max_range_m = 10.0;   ///< What is farther from the camera's foot is left out.
  /// Obstacles that are higher above the support than this are none: a robot of this height passes under them.
  double clearance_m = std::numeric_limits<double>::infinity();
};
Status validate(const OccupancyOptions& options);

/// In the ground frame (GroundFrame: x ahead of the camera, y left). Values as in ROS's nav_msgs/OccupancyGrid.
struct OccupancyGrid {
  static constexpr std::int8_t kUnknown = -1;
  static constexpr std::int8_t kFree = 0;
  static constexpr std::int8_t kOccupied = 100;

  double resolution_m = 0.05;
  int width = 0;                                       ///< Along x.
  int height = 0;                                      ///< Along y.
  Eigen::Vector2d origin_m = Eigen::Vector2d::Zero();  ///< Of the corner of cells[0] with the smallest x and y.
  std::vector<std::int8_t> cells;                      ///< Row by row of y, the smallest y first.
};

/// Squares with obstacle pixels are occupied, drops too; squares on which the support is seen are free; the others are unknown.
/// An empty grid without a support. Errors: invalid_argument.
Result<OccupancyGrid> occupancy_grid(const DepthView& depth, const Camera& camera, const Segmentation& segmentation,
                                     const Obstacles& obstacles, const OccupancyOptions& options = {});

}  // namespace fransac
