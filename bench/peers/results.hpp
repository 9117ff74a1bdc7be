// SPDX-License-Identifier: Apache-2.0
/// Rows as JSON and as a table.
#pragma once

#include <map>
#include <nlohmann/json.hpp>
#include <span>
#include <string>

#include "timing.hpp"

namespace fransac::bench {

/// What the rows were measured with.
struct Setting {
  std::map<std::string, std::string> versions;  ///< Library and version.
  std::string commit;
  std::string date;
  std::string command;
};

nlohmann::ordered_json to_json(const Setting& setting, std::span<const Row> rows);

/// One line per suite, dataset and contestant (and scene, where scenes are sizes): the fastest run, the median over frames of
/// each frame's median, the 99th percentile of all runs; these against the deprojection floor and against the best rival of the
/// same method.
std::string table_text(const Setting& setting, std::span<const Row> rows);

}  // namespace fransac::bench
