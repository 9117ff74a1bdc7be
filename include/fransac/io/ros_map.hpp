// SPDX-License-Identifier: Apache-2.0
/// Occupancy grids as ROS's map_server reads them.
#pragma once

#include <filesystem>
#include <string>

#include "fransac/core/occupancy_grid.hpp"
#include "fransac/core/result.hpp"

namespace fransac::io {

/// The bytes of a map's two files.
struct RosMap {
  std::string pgm;   ///< BASE.pgm.
  std::string yaml;  ///< BASE.yaml, which names the other.
};
/// What write_ros_map writes, and its errors but io.
Result<RosMap> encode_ros_map(const std::filesystem::path& base, const OccupancyGrid& grid);

/// Writes BASE.pgm (254 free, 0 occupied, 205 unknown; the first row is the one with the largest y) and BASE.yaml, which names
/// it; both under temporary names, then renamed. Errors: invalid_argument for a base that names no file, or cells that are not
/// width x height; no_data for a grid without squares; io.
Status write_ros_map(const std::filesystem::path& base, const OccupancyGrid& grid);

}  // namespace fransac::io
