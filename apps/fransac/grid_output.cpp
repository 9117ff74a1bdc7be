// SPDX-License-Identifier: Apache-2.0
#include "grid_output.hpp"

#include <fmt/format.h>

#include "errors.hpp"
#include "fransac/io/ros_map.hpp"
#include "numbers.hpp"
#include "options.hpp"

namespace fransac::cli {

void add_grid_options(Command& command, GridRequest& request) {
  const auto take = [&request](const std::string& text) {
    const auto number = parse_number<double>(text);
    if (!number) reject("a number", text);
    request.options.resolution_m = *number;
  };
  command.add({.name = "--grid",
               .value = "M",
               .help = "make a map of free and occupied squares of this side, within 10 m of the camera's foot (depth images)",
               .needs = {"--grid-out"},
               .group = kObstacleGroup,
               .take = take});
  Option& out =
      add_output(command, "--grid-out", request.base, "BASE", "where to: BASE.pgm and BASE.yaml, as ROS's map_server reads them");
  out.needs = {"--grid", "--obstacles"};
  out.group = kObstacleGroup;
}

void check_options(const GridRequest& request) {
  if (!request.asked()) return;
  if (const Status status = validate(request.options); !status)
    throw UsageError(fmt::format("--grid: {}", status.error().message));
}

void check_place(const std::filesystem::path& base, RunFiles& files) {
  for (const char* const suffix : {".pgm", ".yaml"}) files.writes("--grid-out", std::filesystem::path(base) += suffix);
}

void write_grid(const GridRequest& request, const std::filesystem::path& base, const io::Frame& frame,
                const Segmentation& segmentation, const Obstacles& obstacles, Outputs& outputs) {
  if (!request.asked()) return;
  const OccupancyGrid grid = unwrap(occupancy_grid(frame.view(), frame.camera, segmentation, obstacles, request.options));
  const io::RosMap map = unwrap(io::encode_ros_map(base, grid));
  outputs.write(std::filesystem::path(base) += ".pgm", map.pgm);
  outputs.write(std::filesystem::path(base) += ".yaml", map.yaml);
}

}  // namespace fransac::cli
