// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "commands.hpp"
#include "errors.hpp"
#include "evaluation.hpp"
#include "fransac/io/dataset.hpp"
#include "machine.hpp"
#include "options.hpp"
#include "output.hpp"
#include "report/page.hpp"
#include "report/sequence.hpp"
#include "report/sequence_page.hpp"
#include "sequence.hpp"

namespace fransac::cli {
namespace {

namespace fs = std::filesystem;

constexpr int kPictureWidth_px = 320;
constexpr int kSmallPictureWidth_px = 160;
constexpr int kThumbnailWidth_px = 240;

struct ReportCommand {
  std::vector<std::string> datasets;
  std::string folder;
  int pictures = 12;
  Runs runs{3, {Method::cells, Method::ransac, Method::rransac, Method::voxel_ransac, Method::fransac}};  // and the paper's
  ObstacleRequest obstacles;                                                                              // of sequences
  TrackOptions track;
};

constexpr const char* kIndex = "index.html";

/// What is written at the end.
struct Page {
  fs::path file;
  std::string html;
};

void check_report(ReportCommand& command) {
  check_named_once(command.datasets);
  check_options(command.runs);
  check_options(command.obstacles.options);
  check_options(command.track);
  command.runs.inputs.files.writes_folder("--out", command.folder);
}

/// "sequence2-desk.html": whatever a folder's name is, this one is a link, and no other dataset's.
std::string sequence_file(const io::Dataset& dataset, std::size_t number) {
  constexpr std::size_t kLongest = 60;  // of 255 bytes that file systems take
  constexpr std::string_view kPlain = "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_-";
  std::string name = dataset.name.substr(0, kLongest);
  std::replace_if(
      name.begin(), name.end(), [&](char c) { return kPlain.find(c) == std::string_view::npos; }, '_');
  return fmt::format("sequence{}-{}.html", number, name);
}

/// `cells` gives what following needs, whichever methods are compared.
FollowRequest follow_request(const ReportCommand& command) {
  return {command.runs.options_of(Method::cells), command.obstacles, command.track, {}, {}};
}

/// Follows a sequence and adds its page; the dataset keeps the frames that methods are compared on.
report::SequenceLink report_sequence(const ReportCommand& command, const std::string& name, std::size_t number,
                                     const Machine& machine, io::Dataset& dataset, std::vector<Page>& pages) {
  const FollowRequest request = follow_request(command);
  const report::SequenceReport sequence = report::watch_sequence(name, dataset.frames, request, kThumbnailWidth_px);
  const std::string file = sequence_file(dataset, number);
  pages.push_back({file, report::sequence_page(sequence, request, machine, kIndex)});
  std::vector<io::FrameFiles> compared;
  for (const std::size_t i : report::evenly_chosen(sequence.usable.size(), report::kMostThumbnails)) {
    compared.push_back(dataset.frames[sequence.usable[i]]);
  }
  dataset.frames = std::move(compared);
  return {file, report::gist(sequence), sequence.frames};
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

std::vector<io::Dataset> open_datasets(ReportCommand& command) {
  std::vector<io::Dataset> datasets;
  for (const std::string& name : command.datasets) {
    datasets.push_back(open_dataset(name, command.runs, "a point cloud has no frames to show; report takes depth frames"));
  }
  command.runs.inputs.files.writes("--out", fs::path(command.folder) / kIndex);
  for (std::size_t i = 0; i < datasets.size(); ++i) {
    if (!is_sequence(datasets[i].frames)) continue;
    command.runs.inputs.files.writes("--out", fs::path(command.folder) / sequence_file(datasets[i], i + 1));
  }
  return datasets;
}

void run_report(ReportCommand& command) {
  check_report(command);
  std::vector<io::Dataset> datasets = open_datasets(command);
  report::Report report{this_machine(), command.runs, static_cast<std::size_t>(command.pictures), {}};
  std::vector<Page> pages;
  for (std::size_t i = 0; i < datasets.size(); ++i) {
    const std::string& name = command.datasets[i];
    std::optional<report::SequenceLink> sequence;
    if (is_sequence(datasets[i].frames)) sequence = report_sequence(command, name, i + 1, report.machine, datasets[i], pages);
    report.datasets.push_back(report_dataset(command, name, datasets[i]));
    report.datasets.back().sequence = std::move(sequence);
  }
  pages.push_back({kIndex, report::page(report)});
  Outputs outputs;
  outputs.make_folder(command.folder);
  for (const Page& page : pages) outputs.write(command.folder / page.file, page.html);
  outputs.commit();
}

}  // namespace

Command report_command() {
  auto request = std::make_shared<ReportCommand>();
  Command command{.name = "report", .help = "compare methods on datasets in a page of tables, plots and pictures"};
  add_inputs(command, "DATASET", request->datasets,
             "frames with or without truth: folders of frames, single frames, TUM RGB-D sequences");
  add_output(command, "--out", request->folder, "DIR", "folder of the page, made if need be").required = true;
  add_count(command, "--pictures", request->pictures, 0, 100000,
            "scenes of each dataset shown unfolded and large; later ones are folded and small");
  add_runs(command, request->runs, 100000, "runs per frame; the median time counts");
  add_track_options(command, request->track);
  add_hoover(command, request->runs.hoover);
  request->runs.hoover.curve = true;
  add_obstacle_options(command, request->obstacles, "of sequences: objects over time, too");
  command.examples = {{"--out", "frames --out page"},
                      {"--method", "frames --out page --method cells,ransac"},
                      {"--obstacles", "sequence --out page --obstacles"}};
  command.footer = fmt::format(
      "Writes DIR/index.html: one file that opens from disk and needs no network. What the truth does not tell is left out:\n"
      "frames without truth have pictures and times. A folder with a depth.txt that gives its frames (two or more) their times\n"
      "is a sequence; any other holds scenes that have nothing to do with each other. A sequence is followed by cells, as\n"
      "`fransac track` does, and has a page of its own beside the first, DIR/sequenceN-NAME.html: pictures, planes and objects\n"
      "over time, times and the camera's path; methods are compared on {} of its frames at most, evenly chosen. Its frames\n"
      "that cannot be used are skipped; broken scenes are errors. With --hoover, and where frames have a gt_seg.png, regions "
      "are\n"
      "classified, at tolerances of {:.2f} to {:.2f} in curves; --planes all asks every method for all planes, which that needs.",
      report::kMostThumbnails, kHooverCurveFrom_percent / 100.0, kHooverCurveTo_percent / 100.0);
  command.run = [request] { run_report(*request); };
  return command;
}

}  // namespace fransac::cli
