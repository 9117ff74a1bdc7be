// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <iostream>
#include <memory>
#include <optional>
#include <string>

#include "commands.hpp"
#include "depth_stream.hpp"
#include "errors.hpp"
#include "fransac/io/file.hpp"
#include "fransac/io/trajectory.hpp"
#include "fransac/obstacles/obstacles.hpp"
#include "fransac/track/tracker.hpp"
#include "geometry_json.hpp"
#include "inputs.hpp"
#include "obstacle_output.hpp"
#include "options.hpp"
#include "output.hpp"
#include "process.hpp"
#include "sequence.hpp"

namespace fransac::cli {
namespace {

struct TrackCommand {
  std::string input;
  InputOptions inputs;
  std::string json = "-";
  FollowRequest request;
};

/// Where JSON lines go: standard output, or a file that has its name only when it is whole.
class Lines {
 public:
  explicit Lines(const std::string& file) {
    if (file != "-") file_ = unwrap(io::OutputFile::create(file));
  }
  void write(const std::string& line) { file_ ? check(file_->write(line)) : write_stdout(line); }
  void finish() {
    if (file_) check(file_->commit());
  }

 private:
  std::optional<io::OutputFile> file_;
};

nlohmann::ordered_json pose_to_json(const TrackedFrame& frame) {
  const Eigen::Quaterniond q(frame.T_world_camera.linear());
  return {{"source", enum_name(frame.pose_source)},
          {"translation", vector_to_json(Eigen::Vector3d(frame.T_world_camera.translation()))},
          {"quaternion", {q.x(), q.y(), q.z(), q.w()}}};
}

nlohmann::ordered_json plane_to_json(const TrackedPlane& tracked, const PlaneSegment& measured) {
  return {{"id", tracked.id},
          {"label", tracked.label},
          {"kind", enum_name(measured.kind)},
          {"normal", vector_to_json(tracked.plane.normal)},
          {"d", tracked.plane.d},
          {"measured", {{"normal", vector_to_json(measured.plane.normal)}, {"d", measured.plane.d}}},
          {"inliers", measured.inliers},
          {"area_m2", measured.area_m2},
          {"confidence", measured.confidence},
          {"age", tracked.age}};
}

/// Its id is the one that stays; "obstacle" is its number in this frame, as in obstacle labels.
nlohmann::ordered_json object_to_json(const TrackedObject& tracked, const Obstacle& obstacle) {
  nlohmann::ordered_json json = obstacle_to_json(obstacle);
  json["id"] = tracked.id;
  json["obstacle"] = tracked.obstacle;
  json["age"] = tracked.age;
  return json;
}

/// Drops are not followed, so nothing but their number in this frame tells them apart.
nlohmann::ordered_json drop_to_json(const Obstacle& obstacle) {
  nlohmann::ordered_json json = obstacle_to_json(obstacle);
  json.erase("id");
  json["obstacle"] = obstacle.id;
  return json;
}

void add_obstacles(nlohmann::ordered_json& json, const TrackedFrame& tracked, const Segmentation& segmentation,
                   const Obstacles& found) {
  add_support(json, segmentation, found);
  json["objects"] = nlohmann::ordered_json::array();
  json["drops"] = nlohmann::ordered_json::array();
  for (const TrackedObject& object : tracked.objects) {
    json["objects"].push_back(object_to_json(object, found.obstacles[static_cast<std::size_t>(object.obstacle - 1)]));
  }
  for (const Obstacle& obstacle : found.obstacles) {
    if (obstacle.kind == ObstacleKind::drop) json["drops"].push_back(drop_to_json(obstacle));
  }
}

nlohmann::ordered_json times_to_json(const FollowedFrame& frame) {
  nlohmann::ordered_json json{{"decode", frame.decode_ms}, {"segment", frame.segmentation->timing.total_ms}};
  if (frame.obstacles != nullptr) json["obstacles"] = frame.obstacles->total_ms;
  json["track"] = frame.track_ms;
  return json;
}

/// A frame's line.
std::string line_of(const FollowedFrame& frame, bool warm_start) {
  nlohmann::ordered_json json{{"frame", frame.number}, {"name", frame.name}};
  json["timestamp_s"] = frame.timestamp_s ? nlohmann::ordered_json(*frame.timestamp_s) : nlohmann::ordered_json();
  if (!frame.error.empty()) {
    json["error"] = frame.error;
    return to_text(json, -1);
  }
  json["pose"] = pose_to_json(*frame.tracked);
  json["planes"] = nlohmann::ordered_json::array();
  for (const TrackedPlane& plane : frame.tracked->planes) {
    json["planes"].push_back(plane_to_json(plane, frame.segmentation->planes[static_cast<std::size_t>(plane.label - 1)]));
  }
  if (frame.obstacles != nullptr) add_obstacles(json, *frame.tracked, *frame.segmentation, *frame.obstacles);
  if (warm_start) json["warm"] = frame.warm;
  json["timing_ms"] = times_to_json(frame);
  return to_text(json, -1);
}

void summarise(const FollowTotals& totals, bool warm_start) {
  const auto followed = static_cast<double>(totals.followed());
  std::string text = fmt::format(
      "{} frames in {:.2f} s, {:.1f} frames a second from end to end; medians of a frame: {:.2f} ms decoding, {:.2f} ms "
      "segmenting and tracking",
      totals.followed(), 1e-3 * totals.total_ms, 1e3 * followed / totals.total_ms, totals.decode_ms.quantile(0.5),
      totals.work_ms.quantile(0.5));
  if (warm_start) {
    text +=
        fmt::format("; segmenting alone: {:.2f} ms from cold ({} frames), {:.2f} ms with a warm start ({})",
                    totals.cold_ms.quantile(0.5), totals.cold_ms.count(), totals.warm_ms.quantile(0.5), totals.warm_ms.count());
  }
  log(text + (totals.skipped > 0 ? fmt::format("; {} skipped", totals.skipped) : ""));
}

template <class Frames>
void track(const TrackCommand& command, Frames& frames) {
  const InterruptGuard guard;
  Lines lines(command.json);
  const FollowRequest& request = command.request;
  const FollowHooks hooks{[&](const FollowedFrame& frame) { return line_of(frame, request.warm_start); },
                          [&](const std::string& line) { lines.write(line); }, InterruptGuard::interrupted};
  const FollowTotals totals = follow_frames(frames, request, hooks);
  const bool interrupted = InterruptGuard::interrupted();
  if (!interrupted) lines.finish();
  if (totals.followed() > 0) summarise(totals, request.warm_start);
  if (interrupted) {
    const char* const lost = command.json == "-" ? "" : ", so --json is not written";
    throw Failure(fmt::format("interrupted after {} frames{}", totals.followed() + totals.skipped, lost));
  }
}

void run_track(TrackCommand& command) {
  FollowRequest& request = command.request;
  check_options(request.options);
  check_options(request.obstacles.options);
  check_options(request.track);
  if (request.options.method != Method::cells && request.options.method != Method::automatic) {
    throw UsageError("--method: only cells gives the planes' covariances, which tracking needs");
  }
  if (!request.poses_file.empty()) {
    command.inputs.files.reads(request.poses_file);
    request.poses = unwrap(io::read_trajectory(request.poses_file));
  }
  if (command.input == "-") {
    if (command.inputs.camera) throw UsageError("--camera: a stream says its camera in its first line");
    if (command.inputs.depth_scale) throw UsageError("--depth-scale: a stream says its METRES_PER_UNIT in its first line");
    command.inputs.files.writes_document("--json", command.json);
    DepthStream stream(std::cin, command.inputs.limits());
    return track(command, stream);
  }
  const Input input = open_input(command.input, command.inputs);
  if (!input.is_folder_of_frames()) throw UsageError(fmt::format("{}: not a folder of frames or a TUM sequence", command.input));
  command.inputs.files.writes_document("--json", command.json);
  track(command, input.frames);
}

}  // namespace

Command track_command() {
  auto request = std::make_shared<TrackCommand>();
  FollowRequest& follow = request->request;
  follow.options.method = Method::cells;
  follow.options.threads = 0;
  Command command{.name = "track",
                  .help = "follow planes and objects through the frames of a moving camera; a line of JSON for each frame"};
  add_input(command, "INPUT", request->input,
            "folder of frames, TUM RGB-D sequence, or '-': raw frames on standard input, after a line \"fransac-depth 1 WIDTH "
            "HEIGHT uint16|float32 METRES_PER_UNIT FX FY CX CY\", each a 64-bit timestamp and the rows, little-endian");
  add_input_options(command, request->inputs);
  add_text(command, "--json", request->json, "FILE", "where the lines go, '-' for standard output").notes = "default: -";
  add_text(command, "--poses", follow.poses_file, "FILE",
           "camera poses, a TUM trajectory such as groundtruth.txt; else they are estimated");
  add_flag(command, "--warm-start", follow.warm_start,
           fmt::format("look for the last frame's planes first, but in every {}th frame: a little faster", kColdEvery));
  add_flag(command, "--strict", follow.strict, "stop at a frame that cannot be used instead of skipping it");
  add_segment_options(command, follow.options, request->inputs.files);
  add_track_options(command, follow.track);
  add_obstacle_options(command, follow.obstacles, "follow objects on the support, too, and list drops");
  command.examples = {{"--json", "walk --json planes.jsonl"},
                      {"--obstacles", "walk --obstacles"},
                      {"--poses", "walk --poses walk/groundtruth.txt"},
                      {"--strict", "walk --strict"}};
  command.run = [request] { run_track(*request); };
  return command;
}

}  // namespace fransac::cli
