// SPDX-License-Identifier: Apache-2.0
#include "results.hpp"

#include <fmt/format.h>
#include <sys/utsname.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <tuple>

#include "machine.hpp"
#include "output.hpp"
#include "statistics.hpp"

namespace fransac::bench {
namespace {

std::string kernel() {
  utsname name{};
  if (::uname(&name) != 0) return "unknown";
  return fmt::format("{} {}", name.sysname, name.release);
}

/// Ten nanoseconds are as fine as a clock is.
double rounded(double ms) { return std::round(ms * 1e5) / 1e5; }

/// Where there is nothing that could be found, only false objects count.
bool has_true_objects(const Row& row) { return row.objects && row.objects->true_objects > 0; }

nlohmann::ordered_json to_json(const Row& row) {
  nlohmann::ordered_json json;
  json["suite"] = row.suite;
  json["peer"] = row.entry->id;
  json["library"] = row.entry->library;
  json["build"] = row.entry->build;
  json["method"] = row.entry->method;
  json["dataset"] = row.dataset;
  json["scene"] = row.scene;
  json["width"] = row.width;
  json["height"] = row.height;
  json["points"] = row.points;
  json["threads"] = row.threads;
  json["times_ms"] = nlohmann::ordered_json::array();
  for (const double ms : row.times_ms) json["times_ms"].push_back(rounded(ms));
  for (const auto& [stage, ms] : row.stages_ms) json["stages_ms"][stage] = rounded(ms);
  if (row.planes > 0) {
    json["planes"] = row.planes;
    json["inliers"] = row.inliers;
  }
  if (row.dominant) {
    json["precision"] = row.dominant->precision();
    json["recall"] = row.dominant->recall();
    json["f1"] = row.dominant->f1();
    json["best_f1"] = *row.best_f1;
  }
  if (row.matched_f1) json["matched_f1"] = *row.matched_f1;
  if (row.instances) {
    json["instance_f1_50"] = row.instances->at50.f1;
    json["instance_f1_75"] = row.instances->at75.f1;
    json["weighted_iou"] = row.instances->weighted_iou;
    json["plane_pixel_f1"] = row.instances->plane_pixel_f1;
  }
  if (row.objects) {
    json["true_objects"] = row.objects->true_objects;
    json["predicted_objects"] = row.objects->predicted_objects;
    json["false_objects"] = row.objects->false_objects;
  }
  if (has_true_objects(row)) {
    json["object_f1_50"] = row.objects->at50.f1;
    json["object_f1_75"] = row.objects->at75.f1;
    json["over_segmentation"] = row.objects->over_segmentation;
    json["under_segmentation"] = row.objects->under_segmentation;
  }
  if (row.leaves > 0) json["leaves"] = row.leaves;
  if (!row.note.empty()) json["note"] = row.note;
  return json;
}

/// The rows of one line of the table.
struct Line {
  const Row* first = nullptr;
  std::string input;  ///< Dataset, or the scene where scenes are sizes.
  std::vector<double> all_ms;
  std::vector<double> frame_medians_ms;
  std::vector<double> f1;
  std::vector<double> best_f1;
  std::string note;

  [[nodiscard]] bool timed() const { return !all_ms.empty(); }
  [[nodiscard]] double median_ms() const { return cli::median(frame_medians_ms); }
};

bool scenes_are_sizes(const Row& row) { return row.suite == "resolution" || row.suite == "points" || row.suite == "threads"; }

std::vector<Line> lines_of(std::span<const Row> rows) {
  std::vector<Line> lines;
  std::map<std::tuple<std::string, std::string, std::string_view, int>, std::size_t> places;
  for (const Row& row : rows) {
    const std::string& input = scenes_are_sizes(row) ? row.scene : row.dataset;
    const auto [place, is_new] = places.try_emplace({row.suite, input, row.entry->id, row.threads}, lines.size());
    if (is_new) {
      lines.emplace_back();
      lines.back().first = &row;
      lines.back().input = input;
    }
    Line& line = lines[place->second];
    line.all_ms.insert(line.all_ms.end(), row.times_ms.begin(), row.times_ms.end());
    if (!row.times_ms.empty()) line.frame_medians_ms.push_back(cli::median(row.times_ms));
    if (row.dominant) line.f1.push_back(row.dominant->f1());
    if (row.best_f1) line.best_f1.push_back(*row.best_f1);
    if (line.note.empty()) line.note = row.note;
  }
  return lines;
}

std::string mean_text(const std::vector<double>& values) {
  if (values.empty()) return "-";
  double sum = 0.0;
  for (const double value : values) sum += value;
  return fmt::format("{:.4f}", sum / static_cast<double>(values.size()));
}

/// Times the deprojection of the same frames.
std::string floor_text(std::span<const Line> lines, const Line& line) {
  for (const Line& floor : lines) {
    if (floor.first->entry->id != "floor-deproject" || floor.input != line.input || !floor.timed()) continue;
    return fmt::format("{:.1f}", line.median_ms() / floor.median_ms());
  }
  return "-";
}

/// How many times longer the best rival of the same method takes; for the project's own lines.
std::string rival_text(std::span<const Line> lines, const Line& line) {
  if (line.first->entry->library != "fransac") return "";
  const Line* best = nullptr;
  for (const Line& rival : lines) {
    const bool comparable = rival.timed() && rival.first->suite == line.first->suite && rival.input == line.input &&
                            rival.first->entry->method == line.first->entry->method && rival.first->entry->library != "fransac";
    if (comparable && (best == nullptr || rival.median_ms() < best->median_ms())) best = &rival;
  }
  return best == nullptr ? "-" : fmt::format("{:.1f} {}", best->median_ms() / line.median_ms(), best->first->entry->id);
}

/// Means over frames, and all false objects together, of whoever finds objects; nothing when nobody does.
std::string objects_text(std::span<const Row> rows, std::span<const Line> lines) {
  cli::Table table({"<input", "<peer", "frames", "F1@0.5", "F1@0.75", "over", "under", "false", "median ms"});
  bool any = false;
  for (const Line& line : lines) {
    double sums[4] = {};
    int false_objects = 0;
    std::size_t frames = 0;
    for (const Row& row : rows) {
      if (!row.objects || row.entry != line.first->entry || row.dataset != line.first->dataset) continue;
      const eval::ObjectMetrics& m = *row.objects;
      false_objects += m.false_objects;
      if (!has_true_objects(row)) continue;
      const double values[4] = {m.at50.f1, m.at75.f1, m.over_segmentation, m.under_segmentation};
      for (std::size_t i = 0; i < 4; ++i) sums[i] += values[i];
      ++frames;
    }
    if (frames == 0) continue;
    any = true;
    std::vector<std::string> cells{line.input, std::string(line.first->entry->id), fmt::format("{}", frames)};
    for (const double sum : sums) cells.push_back(fmt::format("{:.3f}", sum / static_cast<double>(frames)));
    cells.push_back(fmt::format("{}", false_objects));
    cells.push_back(line.timed() ? fmt::format("{:.3f}", line.median_ms()) : "-");
    table.add(std::move(cells));
  }
  return any ? "\nobjects: means over frames; false: of all frames together\n\n" + table.text() : "";
}

}  // namespace

nlohmann::ordered_json to_json(const Setting& setting, std::span<const Row> rows) {
  const cli::Machine machine = cli::this_machine();
  nlohmann::ordered_json json;
  json["machine"] = {{"cpu", machine.cpu},
                     {"cores", machine.cores},
                     {"kernel", kernel()},
                     {"compiler", machine.compiler},
                     {"build_type", machine.build_type},
                     {"flags_native", FRANSAC_BENCH_NATIVE_FLAGS},
                     {"libraries", setting.versions},
                     {"commit", setting.commit},
                     {"date", setting.date}};
  json["command"] = setting.command;
  json["rows"] = nlohmann::ordered_json::array();
  for (const Row& row : rows) json["rows"].push_back(to_json(row));
  return json;
}

std::string table_text(const Setting& setting, std::span<const Row> rows) {
  const cli::Machine machine = cli::this_machine();
  std::string text = fmt::format("{}, {} cores, {}, {}, {} build, native {}\n", machine.cpu, machine.cores, kernel(),
                                 machine.compiler, machine.build_type, FRANSAC_BENCH_NATIVE_FLAGS);
  for (const auto& [library, version] : setting.versions) text += fmt::format("{} {}  ", library, version);
  text +=
      "\nmilliseconds; F1: means over frames; 'x floor': times the deprojection loop; 'best rival': how many times longer it "
      "takes\n\n";

  const std::vector<Line> lines = lines_of(rows);
  cli::Table table({"<suite", "<input", "<peer", "threads", "frames", "min", "median", "p99", "x floor", "<best rival", "F1",
                    "best F1", "<note"});
  const Line* previous = nullptr;
  for (const Line& line : lines) {
    if (previous != nullptr && (previous->first->suite != line.first->suite || previous->input != line.input)) table.rule();
    previous = &line;
    std::vector<std::string> cells{line.first->suite, line.input, std::string(line.first->entry->id),
                                   fmt::format("{}", line.first->threads), fmt::format("{}", line.frame_medians_ms.size())};
    if (line.timed()) {
      for (const double ms : {cli::quantile(line.all_ms, 0.0), line.median_ms(), cli::quantile(line.all_ms, 0.99)}) {
        cells.push_back(fmt::format("{:.3f}", ms));
      }
      cells.push_back(floor_text(lines, line));
      cells.push_back(rival_text(lines, line));
    } else {
      cells.insert(cells.end(), {"-", "-", "-", "-", ""});
    }
    cells.push_back(mean_text(line.f1));
    cells.push_back(mean_text(line.best_f1));
    cells.push_back(line.note);
    table.add(std::move(cells));
  }
  return text + table.text() + objects_text(rows, lines);
}

}  // namespace fransac::bench
