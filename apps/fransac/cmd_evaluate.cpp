// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <filesystem>
#include <memory>
#include <numbers>
#include <optional>
#include <string>
#include <string_view>
#include <system_error>
#include <vector>

#include "commands.hpp"
#include "errors.hpp"
#include "fransac/eval/metrics.hpp"
#include "fransac/io/dataset.hpp"
#include "inputs.hpp"
#include "options.hpp"
#include "output.hpp"
#include "progress.hpp"
#include "statistics.hpp"

namespace fransac::cli {
namespace {

/// What is measured of one scene with one method.
enum class Quantity {
  precision,
  recall,
  f1,
  best_f1,
  instance_f1_50,
  instance_precision_50,
  instance_recall_50,
  mean_iou_50,
  instance_f1_75,
  instance_precision_75,
  instance_recall_75,
  mean_iou_75,
  weighted_iou,
  plane_pixel_f1,
  under_segmentation,
  over_segmentation,
  missed,
  noise,
  angle_deg,
  offset_m,
  planes,
  median_ms,
  fps,
};

struct QuantityInfo {
  std::string_view key;      ///< In JSON and CSV.
  std::string_view heading;  ///< In the table; empty: not shown there.
  int decimals;
};

constexpr QuantityInfo kQuantities[] = {
    {"precision", "precision", 4},
    {"recall", "recall", 4},
    {"f1", "F1", 4},
    {"best_f1", "best F1", 4},
    {"instance_f1_50", "F1@0.5", 4},
    {"instance_precision_50", "", 4},
    {"instance_recall_50", "", 4},
    {"mean_iou_50", "", 4},
    {"instance_f1_75", "F1@0.75", 4},
    {"instance_precision_75", "", 4},
    {"instance_recall_75", "", 4},
    {"mean_iou_75", "", 4},
    {"weighted_iou", "wIoU", 4},
    {"plane_pixel_f1", "", 4},
    {"under_segmentation", "", 4},
    {"over_segmentation", "", 4},
    {"missed", "", 4},
    {"noise", "", 4},
    {"angle_deg", "angle [deg]", 3},
    {"offset_m", "offset [m]", 4},
    {"planes", "", 2},
    {"median_ms", "", 3},
    {"fps", "fps", 1},
};
constexpr std::size_t kQuantityCount = std::size(kQuantities);
static_assert(kQuantityCount == static_cast<std::size_t>(Quantity::fps) + 1);

/// Values by quantity; nothing where it does not apply.
struct Scores {
  std::array<std::optional<double>, kQuantityCount> values;
  std::optional<double>& operator[](Quantity quantity) { return values[static_cast<std::size_t>(quantity)]; }
};

struct Row {
  std::string dataset;
  std::string scene;
  Method method = Method::automatic;
  Scores scores;
};

struct EvaluateCommand {
  std::vector<std::string> datasets;
  std::vector<Method> methods{Method::automatic};
  CameraFile camera;
  std::string json;
  std::string csv;
  int repeat = 3;
  SegmentOptions options;
};

void score_instances(Scores& scores, const eval::InstanceMetrics& metrics) {
  scores[Quantity::instance_f1_50] = metrics.at50.f1;
  scores[Quantity::instance_precision_50] = metrics.at50.precision;
  scores[Quantity::instance_recall_50] = metrics.at50.recall;
  scores[Quantity::mean_iou_50] = metrics.at50.mean_iou;
  scores[Quantity::instance_f1_75] = metrics.at75.f1;
  scores[Quantity::instance_precision_75] = metrics.at75.precision;
  scores[Quantity::instance_recall_75] = metrics.at75.recall;
  scores[Quantity::mean_iou_75] = metrics.at75.mean_iou;
  scores[Quantity::weighted_iou] = metrics.weighted_iou;
  scores[Quantity::plane_pixel_f1] = metrics.plane_pixel_f1;
  scores[Quantity::under_segmentation] = metrics.under_segmentation;
  scores[Quantity::over_segmentation] = metrics.over_segmentation;
  scores[Quantity::missed] = metrics.missed;
  scores[Quantity::noise] = metrics.noise;
}

/// Error of the predicted plane that overlaps the dominant one most, where the truth has its coefficients.
void score_coefficients(Scores& scores, const io::Frame& frame, const Segmentation& segmentation, std::uint8_t best_label) {
  const auto truth =
      std::find_if(frame.true_planes.begin(), frame.true_planes.end(), [](const auto& plane) { return plane.first == 1; });
  if (truth == frame.true_planes.end() || best_label == 0) return;
  const eval::PlaneError error = eval::plane_error(truth->second, segmentation.planes[best_label - 1U].plane);
  scores[Quantity::angle_deg] = error.angle_rad * 180.0 / std::numbers::pi;
  scores[Quantity::offset_m] = error.offset_m;
}

Scores score(const io::Frame& frame, io::Truth truth, const SegmentOptions& options, const Segmentation& segmentation) {
  const auto& true_labels = frame.labels->pixels;
  const auto dominant = unwrap(eval::dominant_plane(true_labels, segmentation.labels));
  const auto best = unwrap(eval::best_overlap(true_labels, segmentation.labels));
  Scores scores;
  scores[Quantity::precision] = dominant.precision();
  scores[Quantity::recall] = dominant.recall();
  scores[Quantity::f1] = dominant.f1();
  scores[Quantity::best_f1] = best.detection.f1();
  scores[Quantity::planes] = static_cast<double>(segmentation.planes.size());
  if (truth == io::Truth::planes && options.max_planes != 1) {
    score_instances(scores, unwrap(eval::instance_metrics(true_labels, segmentation.labels)));
  }
  score_coefficients(scores, frame, segmentation, best.label);
  return scores;
}

void set_fps(Scores& scores) {
  const double ms = scores[Quantity::median_ms].value_or(0.0);
  scores[Quantity::fps] = ms > 0.0 ? std::optional(1e3 / ms) : std::nullopt;
}

/// Mean of each quantity over the rows that have it; fps: of the mean time.
Scores mean_of(const std::vector<const Row*>& rows) {
  Scores mean;
  for (std::size_t q = 0; q < kQuantityCount; ++q) {
    double sum = 0.0;
    double count = 0.0;
    for (const Row* row : rows) {
      sum += row->scores.values[q].value_or(0.0);
      count += row->scores.values[q] ? 1.0 : 0.0;
    }
    if (count > 0.0) mean.values[q] = sum / count;
  }
  set_fps(mean);
  return mean;
}

std::vector<Row> means_of(const EvaluateCommand& command, const std::vector<Row>& rows) {
  std::vector<Row> means;
  for (const std::string& dataset : command.datasets) {
    for (const Method method : command.methods) {
      std::vector<const Row*> chosen;
      for (const Row& row : rows) {
        if (row.dataset == dataset && row.method == method) chosen.push_back(&row);
      }
      means.push_back({dataset, "mean", method, mean_of(chosen)});
    }
  }
  return means;
}

Row evaluate_frame(const EvaluateCommand& command, const std::string& dataset, io::Truth truth, const io::Frame& frame,
                   Method method, Workspace& workspace) {
  SegmentOptions options = command.options;
  options.method = method;
  Segmentation segmentation;
  std::vector<double> total_ms;
  for (int run = 0; run < command.repeat; ++run) {
    if (const Status status = segment(frame.view(), frame.camera, options, workspace, segmentation); !status) {
      throw Failure(fmt::format("{}: {}: {}", dataset, frame.name, status.error().message));
    }
    total_ms.push_back(segmentation.timing.total_ms);
  }
  Row row{dataset, frame.name, method, score(frame, truth, options, segmentation)};
  row.scores[Quantity::median_ms] = median(total_ms);
  set_fps(row.scores);
  return row;
}

/// A frame folder with labels but without a dataset.json: label 1 is all that is known to mean anything.
io::Truth truth_of(const io::Dataset& dataset) {
  const bool labelled_frame = dataset.kind == io::InputKind::frame && dataset.frames.front().labels;
  return dataset.truth == io::Truth::none && labelled_frame ? io::Truth::dominant : dataset.truth;
}

void evaluate_dataset(const EvaluateCommand& command, const std::string& name, const io::Dataset& dataset,
                      std::vector<Row>& rows) {
  const io::Truth truth = truth_of(dataset);
  Progress progress(dataset.frames.size());
  Workspace workspace;
  for (const io::FrameFiles& files : dataset.frames) {
    progress.step(files.name);
    const io::Frame frame = unwrap(io::load_frame(files));
    for (const Method method : command.methods) rows.push_back(evaluate_frame(command, name, truth, frame, method, workspace));
  }
}

io::Dataset open_dataset(const std::string& name, const CameraFile& camera) {
  const io::InputKind kind = unwrap(io::detect_kind(name));
  if (kind == io::InputKind::pcd || kind == io::InputKind::ply) {
    throw Failure(fmt::format("{}: a point cloud has no truth to compare with; evaluate takes frames with labels.png", name));
  }
  io::Dataset dataset = unwrap(io::list_frames(name));
  use_camera(camera, dataset.frames);
  if (truth_of(dataset) == io::Truth::none) {
    throw Failure(fmt::format("{}: has no truth to compare with (dataset.json says \"truth\": \"none\", or is missing)", name));
  }
  for (const io::FrameFiles& files : dataset.frames) {
    if (!files.labels) throw Failure(fmt::format("{}: frame {} has no truth (labels.png)", name, files.name));
  }
  return dataset;
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
    for (const std::size_t q : shown) {
      const auto& value = row.scores.values[q];
      cells.push_back(value ? fmt::format("{:.{}f}", *value, kQuantities[q].decimals) : "-");
    }
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
      if (row.scores.values[q]) entry[std::string(kQuantities[q].key)] = *row.scores.values[q];
    }
    json.push_back(std::move(entry));
  }
  return json;
}

std::string csv_header() {
  std::string header = "dataset,scene,method";
  for (const QuantityInfo& quantity : kQuantities) header += fmt::format(",{}", quantity.key);
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

/// Rows of the same data twice would be averaged together.
void check_named_once(const std::vector<std::string>& datasets) {
  for (auto later = datasets.begin(); later != datasets.end(); ++later) {
    const auto same = [&](const std::string& earlier) {
      std::error_code error;
      return earlier == *later || (std::filesystem::equivalent(earlier, *later, error) && !error);
    };
    if (std::any_of(datasets.begin(), later, same)) throw UsageError(fmt::format("DATASET: '{}' is named twice", *later));
  }
}

void check_evaluate(const EvaluateCommand& command) {
  check_named_once(command.datasets);
  check_options(command.options);
  if (!command.json.empty() && command.json == command.csv) {
    throw UsageError(fmt::format("--json and --csv both name '{}'", command.json));
  }
  if (!command.json.empty() && command.json != "-") check_output_file("--json", command.json);
  if (!command.csv.empty() && command.csv != "-") check_output_file("--csv", command.csv);
}

void run_evaluate(const EvaluateCommand& command) {
  check_evaluate(command);
  std::vector<io::Dataset> datasets;
  for (const std::string& name : command.datasets) datasets.push_back(open_dataset(name, command.camera));
  std::vector<Row> rows;
  for (std::size_t i = 0; i < datasets.size(); ++i) evaluate_dataset(command, command.datasets[i], datasets[i], rows);
  const std::vector<Row> means = means_of(command, rows);
  if (!command.json.empty()) {
    const nlohmann::ordered_json json = {{"scenes", rows_to_json(rows, true)},
                                         {"mean", rows_to_json(means, false)},
                                         {"options", options_to_json(command.options)}};
    write_text(command.json, to_text(json));
  }
  if (!command.csv.empty()) write_text(command.csv, csv_text(rows, means));
  if (command.json != "-" && command.csv != "-") write_stdout(table_text(rows, means, command.datasets.size() > 1));
}

}  // namespace

Command add_evaluate(CLI::App& parent) {
  CLI::App* app = parent.add_subcommand("evaluate", "compare methods with the truth of datasets");
  auto command = std::make_shared<EvaluateCommand>();
  app->add_option("DATASET", command->datasets, "folders of frames with labels.png and dataset.json, or single frame folders")
      ->required();
  add_output(*app, "--json", command->json, "results; '-' is standard output, instead of the table", "FILE|-");
  add_output(*app, "--csv", command->csv, "results; '-' is standard output, instead of the table", "FILE|-");
  add_count(*app, "--repeat", command->repeat, 1, 100000, "runs per frame; the median time counts");
  add_camera(*app, command->camera);
  add_segment_options(*app, command->options, &command->methods);
  app->footer(fmt::format(
      "precision, recall, F1: plane 1 against the truth's dominant plane; best F1: the predicted plane that overlaps it most.\n"
      "F1@0.5, F1@0.75 (matches of planes by IoU) and wIoU (area-weighted IoU) need a truth of all planes and more than one "
      "plane asked for\n"
      "(--planes all). angle, offset: error of the plane that overlaps most, where the truth has coefficients.\n"
      "fps: 1000 / median milliseconds from depth in memory to labels in memory; of means: frames per second over the dataset.\n"
      "CSV columns (empty: does not apply; a method's mean rows come last, scene \"mean\"):\n{}",
      csv_header()));
  return {app, [command] { run_evaluate(*command); }};
}

}  // namespace fransac::cli
