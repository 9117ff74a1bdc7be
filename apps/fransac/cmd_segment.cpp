// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <array>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "commands.hpp"
#include "errors.hpp"
#include "numbers.hpp"
#include "segment/checks.hpp"
#include "segment/result.hpp"
#include "segment/writers.hpp"

namespace fransac::cli {
namespace {

/// Checks everything, then finds and writes, frame after frame. A bad frame among several does not stop the others; a standard
/// output that is gone does.
void run_segment(SegmentRequest& request) {
  check_request(request);
  Input input = open_input(request.input, request.inputs);
  check_outputs(request, input);
  input.metres_per_unit = request.metres_per_unit.value_or(1.0);

  Segmenter segmenter(request, input);
  ResultTables tables(input, request.obstacles.asked);
  Progress progress(input.size());
  bool any_planes = false;
  std::size_t failed = 0;
  for (std::size_t i = 0; i < input.size(); ++i) {
    progress.step(input.name_of(i));
    try {
      const SegmentResult& result = segmenter.find(i, progress);
      write_outputs(request, input, i, result);
      if (!request.asks_for_output()) tables.add(result);
      any_planes = any_planes || !result.segmentation.planes.empty();
      progress.clear();
      explain(request, result);
    } catch (const StdoutFailure&) {
      throw;
    } catch (const Failure& error) {
      if (!input.is_folder_of_frames()) throw;
      progress.clear();
      log(error.what());
      ++failed;
    }
  }
  progress.clear();
  if (!request.asks_for_output() && (any_planes || request.obstacles.asked)) write_stdout(tables.text());
  if (failed > 0) throw Failure(fmt::format("{}: {} of {} frames failed", input.name, failed, input.size()));
}

/// Units of a cloud's coordinates, and what they are in metres.
constexpr std::array<std::pair<const char*, double>, 5> kUnits{
    {{"m", 1.0}, {"cm", 0.01}, {"mm", 0.001}, {"in", 0.0254}, {"ft", 0.3048}}};

void add_unit(Command& command, std::optional<double>& metres_per_unit) {
  std::vector<std::string> names;
  for (const auto& [name, metres] : kUnits) names.emplace_back(name);
  add_choice(command, "--unit", names, names.front(), "unit of a point cloud's coordinates",
             [&metres_per_unit](std::size_t unit) { metres_per_unit = kUnits[unit].second; });
}

/// "--grid M --grid-out BASE", which need each other.
void add_grid(Command& command, SegmentRequest& request) {
  const auto take = [&request](const std::string& text) {
    const auto metres = parse_number<double>(text);
    if (!metres) reject("a number", text);
    request.occupancy.resolution_m = *metres;
  };
  command.add({.name = "--grid",
               .value = "M",
               .help = "make a map of free and occupied squares of this side, within 10 m of the camera's foot (depth images)",
               .needs = {"--grid-out"},
               .group = kObstacleGroup,
               .take = take});
  Option& out = add_output(command, "--grid-out", request.grid.path, "BASE",
                           "where to: BASE.pgm and BASE.yaml, as ROS's map_server reads them");
  out.needs = {"--grid", "--obstacles"};
  out.group = kObstacleGroup;
}

}  // namespace

Command segment_command() {
  auto request = std::make_shared<SegmentRequest>();
  Command command{.name = "segment", .help = "find planes in a depth frame, a folder of frames or a point cloud"};
  add_input(command, "INPUT", request->input,
            "a depth image (PNG, TIFF, PGM or NPY, with its camera beside it), a frame folder, a folder of frames, a TUM "
            "RGB-D sequence, a PCD, PLY or XYZ file");
  add_input_options(command, request->inputs);
  add_unit(command, request->metres_per_unit);
  add_output(command, "--labels", request->labels.path, "FILE",
             "label image: 8-bit PNG, 0 no depth, 1, 2, ... planes, 255 on no plane");
  add_output(command, "--json", request->json.path, "FILE|-", "planes, obstacles, evidence and timing; '-' is standard output");
  add_flag(command, "--outlines", request->outlines,
           "the planes', drops' and free space's outlines in --json: polygons with holes, in pixels and on the plane in metres "
           "(depth images)");
  add_output(command, "--overlay", request->overlay.path, "FILE",
             "picture of the planes with their numbers, or of the obstacles: PNG");
  add_output(command, "--cloud", request->cloud.path, "FILE",
             "coloured points with labels, and with --obstacles their numbers: .pcd or .ply");
  add_segment_options(command, request->options, request->inputs.files);
  add_obstacle_options(command, request->obstacles,
                       "find what stands on or hangs above a plane, in depth images also what falls away from it");
  add_output(command, "--obstacle-labels", request->obstacle_labels.path, "FILE",
             "which obstacle each pixel is on: 16-bit PNG, 0 none, else the number in table and --json (clouds without rows "
             "and columns: the field obstacle of --cloud)")
      .group = kObstacleGroup;
  add_grid(command, *request);
  need_obstacles(command);
  command.examples = {{"--camera", "depth.png --camera camera.json"},
                      {"--overlay", "desk --overlay planes.png"},
                      {"--json", "desk --json -"},
                      {"--labels", "desk --labels labels.png"},
                      {"--cloud", "desk --cloud planes.ply"},
                      {"--obstacles", "desk --obstacles"},
                      {"--up", "desk --up 0,-1,0"},
                      {"--method", "desk --method fransac"},
                      {"--planes", "scan.pcd --planes all"},
                      {"--threshold", "scan.pcd --threshold 0.02"}};
  command.footer =
      "Without any output file a table of the planes, and of the obstacles, is printed.\n"
      "For a folder of frames or a sequence, the outputs name folders (made when missing): one file per frame, named after it "
      "(clouds: .ply);\n"
      "--json - then prints one document per line. A frame that fails is named on standard error, the others are done, and the "
      "exit code is 1\n"
      "at the end. A frame without a plane of the minimum support is no error: its list of "
      "planes is empty.";
  command.run = [request] { run_segment(*request); };
  return command;
}

}  // namespace fransac::cli
