// SPDX-License-Identifier: Apache-2.0
/// Occupancy grids as maps for ROS: "--grid RES --grid-out BASE".
#pragma once

#include <filesystem>
#include <string>

#include "command.hpp"
#include "fransac/io/dataset.hpp"
#include "fransac/obstacles/occupancy.hpp"
#include "output.hpp"
#include "run_files.hpp"

namespace fransac::cli {

struct GridRequest {
  OccupancyOptions options;
  std::string base;  ///< Of the files' names, or the folder for a folder of frames; empty: not asked for.

  [[nodiscard]] bool asked() const { return !base.empty(); }
};

/// Adds both options, which need each other.
void add_grid_options(Command& command, GridRequest& request);

/// Throws UsageError when the grid cannot be made.
void check_options(const GridRequest& request);

/// Notes BASE.pgm and BASE.yaml as outputs. Throws Failure or UsageError.
void check_place(const std::filesystem::path& base, RunFiles& files);

/// Writes BASE.pgm and BASE.yaml; nothing without a support.
void write_grid(const GridRequest& request, const std::filesystem::path& base, const io::Frame& frame,
                const Segmentation& segmentation, const Obstacles& obstacles, Outputs& outputs);

}  // namespace fransac::cli
