// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "commands.hpp"
#include "errors.hpp"
#include "evaluation.hpp"
#include "fransac/io/dataset.hpp"
#include "fransac/io/file.hpp"
#include "machine.hpp"
#include "options.hpp"
#include "output.hpp"
#include "report/page.hpp"

namespace fransac::cli {
namespace {

namespace fs = std::filesystem;

constexpr int kPictureWidth_px = 320;
constexpr int kSmallPictureWidth_px = 160;

struct ReportCommand {
  std::vector<std::string> datasets;
  std::string folder;
  int pictures = 12;
  Runs runs{3, {Method::cells, Method::ransac, Method::rransac, Method::voxel_ransac, Method::fransac}};  // and the paper's
};

fs::path page_of(const ReportCommand& command) { return fs::path(command.folder) / "index.html"; }

void check_report(const ReportCommand& command) {
  check_named_once(command.datasets);
  check_options(command.runs.options);
  check_output_folder("--out", command.folder);
  if (fs::exists(command.folder)) check_output_file("--out", page_of(command));
}

report::DatasetReport report_dataset(const ReportCommand& command, const std::string& name, const io::Dataset& dataset) {
  report::DatasetReport result{name, truth_of(dataset), dataset.sensor, {}, {}};
  std::vector<Row> rows;
  evaluate_dataset(command.runs, name, dataset, [&](const auto& files, const auto& frame, auto of_frame, auto segmentations) {
    const bool large = result.scenes.size() < static_cast<std::size_t>(command.pictures);
    result.scenes.push_back(report::draw_scene(files, frame, result.truth, of_frame, segmentations,
                                               large ? kPictureWidth_px : kSmallPictureWidth_px));
    rows.insert(rows.end(), of_frame.begin(), of_frame.end());
  });
  result.means = means_of({name}, command.runs.methods, rows);
  return result;
}

void run_report(const ReportCommand& command) {
  check_report(command);
  std::vector<io::Dataset> datasets;
  for (const std::string& name : command.datasets) {
    datasets.push_back(open_dataset(name, command.runs, "a point cloud has no frames to show; report takes depth frames"));
  }
  report::Report report{this_machine(), command.runs, static_cast<std::size_t>(command.pictures), {}};
  for (std::size_t i = 0; i < datasets.size(); ++i) {
    report.datasets.push_back(report_dataset(command, command.datasets[i], datasets[i]));
  }
  Unfinished output;
  output.make_folder(command.folder);
  check(io::write_file(output.add(page_of(command)), report::page(report)));
  output.finish();
}

}  // namespace

Command add_report(CLI::App& parent) {
  CLI::App* app = parent.add_subcommand("report", "compare methods on datasets in a page of tables, plots and pictures");
  auto command = std::make_shared<ReportCommand>();
  app->add_option("DATASET", command->datasets,
                  "frames with or without truth: folders of frames, single frames, TUM RGB-D sequences")
      ->required();
  add_output(*app, "--out", command->folder, "folder of the page, made if need be", "DIR");
  app->get_option("--out")->required();
  add_count(*app, "--pictures", command->pictures, 0, 100000,
            "scenes of each dataset shown unfolded and large; later ones are folded and small");
  add_runs(*app, command->runs, 100000, "runs per frame; the median time counts");
  app->footer(
      "Writes DIR/index.html: one file that opens from disk and needs no network. What the truth does not tell is left out: "
      "frames\n"
      "without truth have pictures and times.");
  return {app, [command] { run_report(*command); }};
}

}  // namespace fransac::cli
