// SPDX-License-Identifier: Apache-2.0
#include "grid_output.hpp"

#include <fmt/format.h>

#include "errors.hpp"
#include "fransac/io/ros_map.hpp"
#include "options.hpp"

namespace fransac::cli {

void add_grid_options(CLI::App& app, GridRequest& request, const std::string& group) {
  CLI::Option* const grid =
      app.add_option("--grid", request.options.resolution_m,
                     "make a map of free and occupied squares of this side, within 10 m of the camera's foot (depth images)")
          ->type_name("M")
          ->group(group);
  add_output(app, "--grid-out", request.base, "where to: BASE.pgm and BASE.yaml, as ROS's map_server reads them", "BASE");
  CLI::Option* const out = app.get_option("--grid-out")->group(group)->needs(grid)->needs(app.get_option("--obstacles"));
  grid->needs(out);
}

void check_options(const GridRequest& request) {
  if (!request.asked()) return;
  if (const Status status = validate(request.options); !status)
    throw UsageError(fmt::format("--grid: {}", status.error().message));
}

void check_place(const GridRequest& request, bool folder) {
  if (!request.asked()) return;
  if (folder) return check_output_folder("--grid-out", request.base);
  for (const char* const suffix : {".pgm", ".yaml"}) check_output_file("--grid-out", request.base + suffix);
}

void write_grid(const GridRequest& request, const std::filesystem::path& base, const io::Frame& frame,
                const Segmentation& segmentation, const Obstacles& obstacles, Unfinished& written) {
  if (!request.asked() || obstacles.support.empty()) return;
  const OccupancyGrid grid = unwrap(occupancy_grid(frame.view(), frame.camera, segmentation, obstacles, request.options));
  for (const char* const suffix : {".pgm", ".yaml"}) written.add(std::filesystem::path(base) += suffix);
  check(io::write_ros_map(base, grid));
}

}  // namespace fransac::cli
