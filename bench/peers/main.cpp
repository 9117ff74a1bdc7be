// SPDX-License-Identifier: Apache-2.0
/// Times fransac and its rivals side by side.
#include <dlfcn.h>
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <exception>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "errors.hpp"
#include "fransac/io/file.hpp"
#include "output.hpp"
#include "results.hpp"
#include "run_files.hpp"
#include "timing.hpp"

namespace fransac::bench {
namespace {

struct Command {
  std::vector<std::string> suites{"segment", "planes", "voxel_grid", "sac", "floor"};
  std::vector<std::string> datasets;
  bool chosen_datasets = true;  ///< By the user.
  std::vector<std::string> peers;
  std::size_t frames = 0;
  std::string json;
  TimingOptions timing;
  Setting setting;
};

const std::filesystem::path kData = FRANSAC_BENCH_DATA;

/// The rivals that are compiled for this machine's own instruction set. The module stays open: its objects outlive this call.
void add_native(Party& party) {
  void* const module = ::dlopen(FRANSAC_BENCH_MODULE, RTLD_NOW | RTLD_LOCAL);
  if (module == nullptr) throw cli::Failure(::dlerror());
  void* const factory = ::dlsym(module, "fransac_bench_native");
  if (factory == nullptr) throw cli::Failure(::dlerror());
  reinterpret_cast<void (*)(Party*)>(factory)(&party);
}

Party everybody() {
  Party party;
  add_ours(party, 1);
  add_native(party);
#ifdef FRANSAC_BENCH_HAS_PCL
  add_pcl_sac(party);
  add_pcl_organized(party);
  add_pcl_clouds(party);
  add_pcl_clusters(party);
  add_pcl_adapter(party);
#endif
#ifdef FRANSAC_BENCH_HAS_OPEN3D
  add_open3d(party);
#endif
#ifdef FRANSAC_BENCH_HAS_OPENCV
  add_opencv(party);
#endif
  return party;
}

/// Whether the user asked for this peer.
bool wanted(const Command& command, std::string_view id) {
  const auto within = [id](const std::string& part) { return id.find(part) != std::string_view::npos; };
  return command.peers.empty() || std::any_of(command.peers.begin(), command.peers.end(), within);
}

using Choice = bool (*)(const Entry&);

/// Those of the roster that a suite and the user ask for, with the peers that were built.
std::vector<Contestant> contestants_of(const Command& command, const Party& party, Choice choice, int threads = 1) {
  std::vector<Contestant> contestants;
  for (const Entry& entry : kRoster) {
    if (!choice(entry) || !wanted(command, entry.id)) continue;
    const auto has_id = [&](const auto& peer) { return peer->id() == entry.id; };
    const auto found = std::find_if(party.peers.begin(), party.peers.end(), has_id);
    contestants.push_back({&entry, found == party.peers.end() ? nullptr : found->get(), threads});
  }
  return contestants;
}

bool is_segment(const Entry& entry) { return entry.task == Task::segment; }
bool is_voxel_grid(const Entry& entry) { return entry.task == Task::voxel_grid; }
bool is_sac(const Entry& entry) { return entry.task == Task::sac; }
bool is_objects(const Entry& entry) { return entry.task == Task::objects || entry.id == "floor-deproject"; }
bool is_floor(const Entry& entry) { return entry.task == Task::floor; }
bool finds_all_planes(const Entry& entry) { return entry.method == kAllPlanes || entry.id == "floor-deproject"; }
bool for_resolutions(const Entry& entry) {
  return entry.id == "cells" || entry.id == "fransac" || entry.id == "pcl-fransac-native" || entry.id == "floor-deproject";
}
/// Methods that know clouds: no organised neighbours, no camera.
bool for_points(const Entry& entry) {
  return (is_voxel_grid(entry) && entry.id != "voxel-grid-depth" && entry.id != "adapter-voxelgrid") ||
         (is_segment(entry) && (entry.method == "ransac" || entry.method == "fransac" || entry.id == "open3d-segment-voxel"));
}
bool for_threads(const Entry& entry) { return entry.id == "cells" || entry.id == "fransac" || entry.id == "ransac"; }

template <class Item>
void append(std::vector<Item>& items, std::vector<Item> more) {
  items.insert(items.end(), std::make_move_iterator(more.begin()), std::make_move_iterator(more.end()));
}

void run_on_datasets(const Command& command, const Party& party, const std::string& suite, Choice choice,
                     std::vector<Row>& rows) {
  const std::vector<Contestant> contestants = contestants_of(command, party, choice);
  for (const std::string& dataset : command.datasets) {
    const std::vector<Scene> scenes = dataset == "synth" ? synth_dataset(command.frames) : load_dataset(dataset, command.frames);
    append(rows, time_suite(suite, scenes, contestants, command.timing));
  }
}

/// Frames whose objects are known.
void run_objects(const Command& command, const Party& party, std::vector<Row>& rows) {
  const std::vector<Contestant> contestants = contestants_of(command, party, is_objects);
  for (const std::string& dataset : command.datasets) {
    std::vector<Scene> scenes = dataset == "synth" ? synth_dataset(command.frames) : load_dataset(dataset, command.frames);
    std::erase_if(scenes, [](const Scene& scene) { return scene.objects.empty(); });
    if (!scenes.empty()) append(rows, time_suite("objects", scenes, contestants, command.timing));
  }
}

/// A real frame of 1920 x 1080 pixels, where there is one.
std::vector<Scene> azure_frame() {
  const std::filesystem::path folder = kData / "other" / "azure_kinect__office_000053735188";
  if (!std::filesystem::is_directory(folder)) return {};
  std::vector<Scene> scenes = load_dataset(folder, 1);
  for (Scene& scene : scenes) {
    scene.dataset = "azure";
    scene.name = "azure";
  }
  return scenes;
}

/// Whoever finds every plane, in turns with the deprojection loop; on a rendered room and a large frame as well.
void run_planes(const Command& command, const Party& party, std::vector<Row>& rows) {
  run_on_datasets(command, party, "planes", finds_all_planes, rows);
  if (command.chosen_datasets) return;
  const std::vector<Contestant> contestants = contestants_of(command, party, finds_all_planes);
  std::vector<Scene> room;
  if (std::filesystem::is_directory(kData / "icl_nuim")) room = load_dataset(kData / "icl_nuim", command.frames);
  for (const std::vector<Scene>& scenes : {std::move(room), azure_frame()}) {
    if (!scenes.empty()) append(rows, time_suite("planes", scenes, contestants, command.timing));
  }
}

std::vector<Scene> clouds() {
  std::vector<Scene> scenes;
  for (std::size_t points = 1000; points <= 10'000'000; points *= 10) scenes.push_back(synth_cloud(points));
  return scenes;
}

void run_threads(const Command& command, std::vector<Row>& rows) {
  Party parties[2];
  std::vector<Contestant> contestants;
  for (const int threads : {1, 2}) {
    Party& party = parties[threads - 1];
    add_ours(party, threads);
    const std::vector<Contestant> more = contestants_of(command, party, for_threads, threads);
    contestants.insert(contestants.end(), more.begin(), more.end());
  }
  std::vector<Scene> scenes;
  scenes.push_back(synth_desk(640, 480));
  scenes.push_back(synth_desk(1920, 1080));
  scenes.push_back(synth_cloud(1'000'000));
  append(scenes, azure_frame());
  append(rows, time_suite("threads", scenes, contestants, command.timing));
}

void run_suite(const Command& command, const Party& party, const std::string& suite, std::vector<Row>& rows) {
  if (suite == "segment") return run_on_datasets(command, party, suite, is_segment, rows);
  if (suite == "voxel_grid") return run_on_datasets(command, party, suite, is_voxel_grid, rows);
  if (suite == "sac") return run_on_datasets(command, party, suite, is_sac, rows);
  if (suite == "planes") return run_planes(command, party, rows);
  if (suite == "objects") return run_objects(command, party, rows);
  if (suite == "floor") return run_on_datasets(command, party, suite, is_floor, rows);
  if (suite == "threads") return run_threads(command, rows);
  const bool resolution = suite == "resolution";
  const std::vector<Scene> scenes = resolution ? synth_resolutions() : clouds();
  TimingOptions timing = command.timing;
  timing.scenes_stand_alone = true;
  const Choice choice = resolution ? for_resolutions : for_points;
  append(rows, time_suite(suite, scenes, contestants_of(command, party, choice), timing));
}

void run(Command& command) {
  cli::RunFiles().writes_document("--json", command.json);
  if (!command.timing.overlays.empty()) std::filesystem::create_directories(command.timing.overlays);
  if (command.datasets.empty()) {
    command.chosen_datasets = false;
    for (const char* const name : {"tum", "mosd"}) {
      if (std::filesystem::is_directory(kData / name)) command.datasets.push_back((kData / name).lexically_normal().string());
    }
    if (command.datasets.empty()) command.datasets.emplace_back("synth");
  }
  const Party party = everybody();
  command.setting.versions.insert(party.versions.begin(), party.versions.end());
  std::vector<Row> rows;
  for (const std::string& suite : command.suites) run_suite(command, party, suite, rows);
  if (!command.json.empty()) {
    const std::string text = cli::to_text(to_json(command.setting, rows), 1);
    if (command.json == "-") {
      cli::write_stdout(text);
    } else {
      cli::check(io::write_file(command.json, std::string_view(text)));
    }
  }
  if (command.json != "-") cli::write_stdout(table_text(command.setting, rows));
}

int parse_and_run(int argc, char** argv) {
  Command command;
  CLI::App app("Times fransac and its rivals side by side, frame by frame in turns, one thread unless a row says otherwise.",
               "bench_peers");
  app.add_option("--suite", command.suites, "what is timed")
      ->delimiter(',')
      ->check(CLI::IsMember({"segment", "planes", "objects", "voxel_grid", "sac", "floor", "resolution", "points", "threads"}))
      ->capture_default_str();
  app.add_option("--dataset", command.datasets,
                 "folders of frames, or 'synth'; default: tum and mosd of ../shared/data if there, else synth");
  app.add_option("--frames", command.frames, "at most this many frames of each dataset, 0 for all");
  app.add_option("--peer", command.peers, "only those whose name has one of these in it")->delimiter(',');
  app.add_option("--repeat", command.timing.repeat, "timed runs per frame and peer")
      ->check(CLI::Range(1, 1000000))
      ->capture_default_str();
  app.add_option("--max-seconds-per-row", command.timing.max_seconds_per_row, "no further run of a peer on a frame beyond it")
      ->check(CLI::PositiveNumber)
      ->capture_default_str();
  app.add_option("--max-seconds-per-run", command.timing.max_seconds_per_run, "who takes longer is not timed")
      ->check(CLI::PositiveNumber)
      ->capture_default_str();
  app.add_flag("--cpu-time", command.timing.cpu_time,
               "processor time of the thread, for a look on a busy machine; not for two threads");
  app.add_option("--json", command.json, "results; '-' is standard output, instead of the table");
  app.add_option("--overlays", command.timing.overlays, "folder for pictures of the labels of everybody on depth frames");
  app.add_option("--commit", command.setting.commit, "noted in the results");
  app.add_option("--date", command.setting.date, "noted in the results");
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? cli::kExitDone : cli::kExitUsage;
  }
  for (int i = 0; i < argc; ++i) command.setting.command += fmt::format("{}{}", i == 0 ? "" : " ", argv[i]);
  run(command);
  return cli::kExitDone;
}

}  // namespace
}  // namespace fransac::bench

int main(int argc, char** argv) {
  try {
    return fransac::bench::parse_and_run(argc, argv);
  } catch (const std::exception& error) {
    fmt::print(stderr, "bench_peers: {}\n", error.what());
    return fransac::cli::kExitFailure;
  }
}
