// SPDX-License-Identifier: Apache-2.0
/// The ground as a map of free, occupied and unknown squares.
#pragma once

#include <limits>

#include "fransac/core/camera.hpp"
#include "fransac/core/depth_image.hpp"
#include "fransac/core/occupancy_grid.hpp"
#include "fransac/core/result.hpp"
#include "fransac/obstacles/obstacles.hpp"
#include "fransac/planes/segment.hpp"

namespace fransac {

/// What the map covers.
struct OccupancyOptions {
  double resolution_m = 0.05;  ///< Side of a square.
  double max_range_m = 10.0;   ///< What is farther from the camera's foot is left out.
  /// What is higher above the support than this is no obstacle: a robot of this height passes under it.
  double clearance_m = std::numeric_limits<double>::infinity();
};
/// Checks every range and the number of squares. The message names the option.
Status validate(const OccupancyOptions& options);

/// More squares than this are refused: 64 MB, or a kilometre square at 12.5 cm.
inline constexpr double kMaxSquares = 64e6;

/// The ground around the camera's foot, as far as max_range_m in all directions: x ahead of the camera, y left (GroundFrame).
/// Squares with obstacle pixels are occupied, and so are those of a drop: where its pixels' rays go through the support, the
/// ground is missing. Squares on which the support is seen and no obstacle are free; the others are unknown.
/// Without a support no square is free; an empty grid of obstacles that were not looked for. Errors: invalid_argument (options,
/// more than kMaxSquares squares, sizes that differ), out_of_memory.
Result<OccupancyGrid> occupancy_grid(const DepthView& depth, const Camera& camera, const Segmentation& segmentation,
                                     const Obstacles& obstacles, const OccupancyOptions& options = {});

}  // namespace fransac
