// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "commands.hpp"
#include "errors.hpp"
#include "evaluation.hpp"
#include "fransac/io/dataset.hpp"
#include "options.hpp"
#include "output.hpp"

namespace fransac::cli {
namespace {

struct EvaluateCommand {
  std::vector<std::string> datasets;
  Runs runs{3};
  std::string json;
  std::string csv;
};

void check_has_truth(const std::string& name, const io::Dataset& dataset) {
  if (truth_of(dataset) == io::Truth::none) {
    throw Failure(fmt::format("{}: has no truth to compare with (dataset.json says \"truth\": \"none\", or is missing)", name));
  }
  for (const io::FrameFiles& files : dataset.frames) {
    if (!files.labels) throw Failure(fmt::format("{}: frame {} has no truth (labels.png)", name, files.name));
  }
}

std::string table_text(const std::vector<Row>& rows, const std::vector<Row>& means, bool several_datasets) {
  std::vector<std::size_t> shown;
  std::vector<std::string> headings{"<scene", "<method"};
  if (several_datasets) headings.insert(headings.begin(), "<dataset");
  for (std::size_t q = 0; q < kQuantityCount; ++q) {
    const bool present = std::any_of(rows.begin(), rows.end(), [&](const Row& row) { return row.scores.values[q].has_value(); });
    if (kQuantities[q].heading.empty() || !present) continue;
    shown.push_back(q);
    headings.emplace_back(kQuantities[q].heading);
  }
  Table table(std::move(headings));
  const auto add = [&](const Row& row) {
    std::vector<std::string> cells{row.scene, std::string(enum_name(row.method))};
    if (several_datasets) cells.insert(cells.begin(), row.dataset);
    for (const std::size_t q : shown) cells.push_back(value_text(row.scores, static_cast<Quantity>(q)));
    table.add(std::move(cells));
  };
  std::for_each(rows.begin(), rows.end(), add);
  table.rule();
  std::for_each(means.begin(), means.end(), add);
  return table.text();
}

nlohmann::ordered_json rows_to_json(const std::vector<Row>& rows, bool with_scene) {
  nlohmann::ordered_json json = nlohmann::ordered_json::array();
  for (const Row& row : rows) {
    nlohmann::ordered_json entry;
    entry["dataset"] = row.dataset;
    if (with_scene) entry["scene"] = row.scene;
    entry["method"] = enum_name(row.method);
    for (std::size_t q = 0; q < kQuantityCount; ++q) {
      if (!row.scores.values[q]) continue;
      const QuantityInfo& quantity = kQuantities[q];
      nlohmann::ordered_json& values = quantity.group.empty() ? entry : entry[std::string(quantity.group)];
      values[std::string(quantity.key)] = *row.scores.values[q];
    }
    json.push_back(std::move(entry));
  }
  return json;
}

std::string csv_header() {
  std::string header = "dataset,scene,method";
  for (const QuantityInfo& quantity : kQuantities) {
    header += fmt::format(",{}{}{}", quantity.group, quantity.group.empty() ? "" : "_", quantity.key);
  }
  return header;
}

/// RFC 4180: a cell with a comma, a quote or a line end stands in quotes, its quotes doubled.
std::string csv_cell(const std::string& text) {
  if (text.find_first_of(",\"\r\n") == std::string::npos) return text;
  std::string quoted = "\"";
  for (const char c : text) quoted += c == '"' ? "\"\"" : std::string(1, c);
  return quoted + "\"";
}

std::string csv_text(const std::vector<Row>& rows, const std::vector<Row>& means) {
  std::string text = csv_header() + "\n";
  const auto add = [&](const Row& row) {
    text += fmt::format("{},{},{}", csv_cell(row.dataset), csv_cell(row.scene), enum_name(row.method));
    for (std::size_t q = 0; q < kQuantityCount; ++q) {
      const auto& value = row.scores.values[q];
      text += value ? fmt::format(",{:.{}f}", *value, kQuantities[q].decimals + 2) : ",";
    }
    text += "\n";
  };
  std::for_each(rows.begin(), rows.end(), add);
  std::for_each(means.begin(), means.end(), add);
  return text;
}

void check_evaluate(const EvaluateCommand& command) {
  check_named_once(command.datasets);
  check_options(command.runs);
  check_options(command.runs.obstacles.options);
  if (command.json == "-" && command.csv == "-") throw UsageError("--json and --csv both name standard output");
}

void run_evaluate(EvaluateCommand& command) {
  check_evaluate(command);
  std::vector<io::Dataset> datasets;
  for (const std::string& name : command.datasets) {
    datasets.push_back(
        open_dataset(name, command.runs, "a point cloud has no truth to compare with; evaluate takes frames with labels.png"));
    check_has_truth(name, datasets.back());
  }
  command.runs.inputs.files.writes_document("--json", command.json);
  command.runs.inputs.files.writes_document("--csv", command.csv);
  std::vector<Row> rows;
  for (std::size_t i = 0; i < datasets.size(); ++i) {
    evaluate_dataset(command.runs, command.datasets[i], datasets[i],
                     [&](const auto&, const auto&, std::span<const Row> of_frame, const auto&) {
                       rows.insert(rows.end(), of_frame.begin(), of_frame.end());
                     });
  }
  const std::vector<Row> means = means_of(command.datasets, command.runs.methods, rows);
  const auto json = [&] {
    nlohmann::ordered_json options = options_to_json(command.runs.options);
    if (command.runs.obstacles.asked) options.update(options_to_json(command.runs.obstacles.options));
    if (command.runs.hoover.asked) options["hoover"] = command.runs.hoover.tolerance;
    return to_text({{"scenes", rows_to_json(rows, true)}, {"mean", rows_to_json(means, false)}, {"options", std::move(options)}});
  };
  write_results({{command.json, json}, {command.csv, [&] { return csv_text(rows, means); }}},
                [&] { return table_text(rows, means, command.datasets.size() > 1); });
}

}  // namespace

Command evaluate_command() {
  auto request = std::make_shared<EvaluateCommand>();
  Command command{.name = "evaluate", .help = "compare methods with the truth of datasets"};
  add_inputs(command, "DATASET", request->datasets,
             "folders of frames with labels.png and dataset.json, or single frame folders");
  add_document(command, "--json", request->json);
  add_document(command, "--csv", request->csv);
  add_runs(command, request->runs, 100000, "runs per frame; the median time counts");
  add_hoover(command, request->runs.hoover);
  add_obstacle_options(command, request->runs.obstacles,
                       "find obstacles and compare them with objects.png, where frames have one");
  command.examples = {{"--method", "frames --method cells,ransac"},
                      {"--planes", "frames --planes all"},
                      {"--obstacles", "frames --obstacles"},
                      {"--csv", "frames --csv scores.csv"}};
  command.footer = fmt::format(
      "precision, recall, F1: plane 1 against the truth's dominant plane; best F1: the predicted plane that overlaps it most.\n"
      "matched: F1 of plane 1 against the true plane that it fits best. A frame without a true plane has no scores. A plane\n"
      "found mostly where the truth is 0 (ignored) is neither plane 1, which is then the next, nor a false plane.\n"
      "F1@0.5, F1@0.75 (matches of planes by IoU) and wIoU (area-weighted IoU) need a truth of all planes and more than one\n"
      "plane asked for (--planes all). angle, offset: error of the plane that overlaps most, where the truth has coefficients.\n"
      "fps: 1000 / median milliseconds from depth in memory to labels in memory; of means: frames per second over the dataset.\n"
      "--obstacles: objects in the truth, found, false (on most of whose pixels there is no true one: walls are, too), over,\n"
      "under (shares of the true ones found in parts, of the found ones that are several) and F1 by IoU; object IoU: mean over\n"
      "the true ones of the best. Drops are no objects. obstacles [ms]: median of what finding them adds. floor as obstacle:\n"
      "share of the true floor's pixels that are on an obstacle or a drop; the floor is the label that \"floor\" of truth.json\n"
      "or of dataset.json names, else label 1 where the truth holds all planes.\n"
      "--hoover: numbers of regions, true ones from gt_seg.png (values from 10 on) where a frame has one, else the true planes;\n"
      "found ones are the 8-connected parts of planes from 50 pixels on. Needs what F1@0.5 needs. correct share, of means: of\n"
      "all regions.\n"
      "CSV columns (empty: does not apply; a method's mean rows come last, scene \"mean\"):\n{}",
      csv_header());
  command.run = [request] { run_evaluate(*request); };
  return command;
}

}  // namespace fransac::cli
