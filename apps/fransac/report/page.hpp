// SPDX-License-Identifier: Apache-2.0
/// The first page of a report. Each page is one file that needs no network and no script.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "../machine.hpp"
#include "../options.hpp"
#include "scene.hpp"

namespace fransac::cli::report {

/// A sequence's own page.
struct SequenceLink {
  std::string file;  ///< Beside this page.
  std::string gist;  ///< What it shows, in a line.
  std::size_t frames = 0;
};

struct DatasetReport {
  std::string name;
  io::Truth truth = io::Truth::none;
  std::string sensor;
  std::vector<Scene> scenes;
  std::vector<Row> means;  ///< One per method.
  std::optional<SequenceLink> sequence{};
};

struct Report {
  Machine machine;
  Runs runs{1};
  std::size_t open_scenes = 0;  ///< Scenes of a dataset that are unfolded when the page opens.
  std::vector<DatasetReport> datasets;
};

std::string page(const Report& report);

/// "threshold 0.01, leaf-size 0.02, …": all options but the method.
std::string options_text(const SegmentOptions& options);

}  // namespace fransac::cli::report
