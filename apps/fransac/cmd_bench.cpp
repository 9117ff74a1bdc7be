// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <memory>
#include <string>
#include <vector>

#include "commands.hpp"
#include "errors.hpp"
#include "inputs.hpp"
#include "machine.hpp"
#include "options.hpp"
#include "output.hpp"
#include "progress.hpp"
#include "statistics.hpp"

namespace fransac::cli {
namespace {

struct BenchCommand {
  std::vector<std::string> inputs;
  Runs runs{100};
  std::string json;
};

/// One method's buffers and times.
struct Contestant {
  SegmentOptions options;
  Workspace workspace;
  Segmentation segmentation;
  std::vector<double> total_ms;
  std::array<std::vector<double>, kStages> stage_ms;

  void run(const std::string& name, const Content& content) { segment(name, content, options, workspace, segmentation); }

  void run_timed(const std::string& name, const Content& content) {
    const auto start = std::chrono::steady_clock::now();
    run(name, content);
    const auto end = std::chrono::steady_clock::now();
    total_ms.push_back(std::chrono::duration<double, std::milli>(end - start).count());
    for (std::size_t s = 0; s < kStages; ++s) stage_ms[s].push_back(segmentation.timing.stage_ms[s]);
  }
};

struct BenchResult {
  std::string input;
  std::size_t frames = 0;
  Method method = Method::automatic;
  int repeat = 0;
  std::array<double, kStages> stages_ms{};
  double min_ms = 0.0;
  double median_ms = 0.0;
  double p99_ms = 0.0;

  [[nodiscard]] double fps() const { return 1e3 / median_ms; }
};

/// The methods take turns, so that a machine that slows down or speeds up meanwhile does so for all of them.
void time_frame(const std::string& name, const Content& content, int repeat, std::vector<Contestant>& contestants) {
  std::vector<std::vector<std::uint8_t>> expected;
  for (Contestant& contestant : contestants) {
    contestant.run(name, content);  // warm-up
    expected.push_back(contestant.segmentation.labels);
  }
  for (int r = 0; r < repeat; ++r) {
    for (std::size_t c = 0; c < contestants.size(); ++c) {
      contestants[c].run_timed(name, content);
      if (contestants[c].segmentation.labels != expected[c]) {
        throw Failure(fmt::format("{}: {} gave other labels on another run", name, enum_name(contestants[c].options.method)));
      }
    }
  }
}

BenchResult summarise(const Input& input, int repeat, const Contestant& contestant) {
  BenchResult result{input.name, input.size(), contestant.segmentation.method, repeat, {}, 0.0, 0.0, 0.0};
  for (std::size_t s = 0; s < kStages; ++s) result.stages_ms[s] = median(contestant.stage_ms[s]);
  result.min_ms = quantile(contestant.total_ms, 0.0);
  result.median_ms = median(contestant.total_ms);
  result.p99_ms = quantile(contestant.total_ms, 0.99);
  return result;
}

std::vector<BenchResult> bench_input(const BenchCommand& command, const Input& input) {
  const Runs& runs = command.runs;
  std::vector<Contestant> contestants(runs.methods.size());
  for (std::size_t c = 0; c < contestants.size(); ++c) contestants[c].options = runs.options_of(runs.methods[c]);
  Progress progress(input.size());
  Doubts doubts;
  for (std::size_t i = 0; i < input.size(); ++i) {
    progress.step(input.name_of(i));
    time_frame(input.name_of(i), load(input, i, doubts, progress), runs.repeat, contestants);
  }
  std::vector<BenchResult> results;
  for (const Contestant& contestant : contestants) results.push_back(summarise(input, runs.repeat, contestant));
  return results;
}

nlohmann::ordered_json to_json(const Machine& machine, const SegmentOptions& options, const std::vector<BenchResult>& results) {
  nlohmann::ordered_json json;
  json["machine"] = to_json(machine);
  json["options"] = options_to_json(options);
  json["results"] = nlohmann::ordered_json::array();
  for (const BenchResult& result : results) {
    nlohmann::ordered_json stages;
    for (std::size_t s = 0; s < kStages; ++s) stages[std::string(EnumNames<Stage>::values[s])] = result.stages_ms[s];
    json["results"].push_back({{"input", result.input},
                               {"frames", result.frames},
                               {"method", enum_name(result.method)},
                               {"repeat", result.repeat},
                               {"stages_ms", stages},
                               {"min_ms", result.min_ms},
                               {"median_ms", result.median_ms},
                               {"p99_ms", result.p99_ms},
                               {"fps", result.fps()}});
  }
  return json;
}

std::string table_text(const Machine& machine, const SegmentOptions& options, const std::vector<BenchResult>& results) {
  std::vector<std::string> headings{"<input", "frames", "<method"};
  for (const std::string_view stage : EnumNames<Stage>::values) headings.emplace_back(stage);
  for (const char* heading : {"min", "median", "p99", "fps"}) headings.emplace_back(heading);
  Table table(std::move(headings));
  for (const BenchResult& result : results) {
    std::vector<std::string> cells{result.input, fmt::format("{}", result.frames), std::string(enum_name(result.method))};
    for (const double ms : result.stages_ms) cells.push_back(fmt::format("{:.3f}", ms));
    for (const double ms : {result.min_ms, result.median_ms, result.p99_ms}) cells.push_back(fmt::format("{:.3f}", ms));
    cells.push_back(fmt::format("{:.1f}", result.fps()));
    table.add(std::move(cells));
  }
  return fmt::format("{}, threads {}; milliseconds, stages: medians, {} runs per frame\n\n{}", to_text(machine), options.threads,
                     results.front().repeat, table.text());
}

void run_bench(BenchCommand& command) {
  check_options(command.runs);
  const Machine machine = this_machine();
  if (machine.build_type != "Release") log(fmt::format("note: this is a {} build; only Release is fast", machine.build_type));
  std::vector<Input> inputs;
  for (const std::string& name : command.inputs) inputs.push_back(open_input(name, command.runs.inputs));
  command.runs.inputs.files.writes_document("--json", command.json);
  std::vector<BenchResult> results;
  for (const Input& input : inputs) {
    for (BenchResult& result : bench_input(command, input)) results.push_back(std::move(result));
  }
  write_results({{command.json, [&] { return to_text(to_json(machine, command.runs.options, results)); }}},
                [&] { return table_text(machine, command.runs.options, results); });
}

}  // namespace

Command bench_command() {
  auto request = std::make_shared<BenchCommand>();
  Command command{.name = "bench", .help = "time methods on inputs"};
  add_inputs(command, "INPUT", request->inputs,
             "depth images, frame folders, folders of frames, TUM RGB-D sequences, PCD or PLY files");
  add_document(command, "--json", request->json);
  add_runs(command, request->runs, 1000000, "timed runs per frame and method, after one to warm up");
  command.examples = {{"--method", "desk --method cells,ransac"}, {"--repeat", "desk --repeat 5"}, {"--json", "desk --json -"}};
  command.footer =
      "Time is from depth (or points) in memory to labels in memory, with buffers reused. An input with several frames gives one "
      "result over all\n"
      "its frames. Methods take turns, and every run must give the same labels.";
  command.run = [request] { run_bench(*request); };
  return command;
}

}  // namespace fransac::cli
