// SPDX-License-Identifier: Apache-2.0
/// The page of a report: one file that needs no network and no script.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "../machine.hpp"
#include "../options.hpp"
#include "scene.hpp"

namespace fransac::cli::report {

struct DatasetReport {
  std::string name;
  io::Truth truth = io::Truth::none;
  std::string sensor;
  std::vector<Scene> scenes;
  std::vector<Row> means;  ///< One per method.
};

struct Report {
  Machine machine;
  Runs runs{1};
  std::size_t open_scenes = 0;  ///< Scenes of a dataset that are unfolded when the page opens.
  std::vector<DatasetReport> datasets;
};

std::string page(const Report& report);

}  // namespace fransac::cli::report
