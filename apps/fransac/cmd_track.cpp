// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <array>
#include <chrono>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "commands.hpp"
#include "depth_stream.hpp"
#include "errors.hpp"
#include "fransac/core/parallel.hpp"
#include "fransac/io/trajectory.hpp"
#include "fransac/obstacles/obstacles.hpp"
#include "fransac/track/tracker.hpp"
#include "geometry_json.hpp"
#include "inputs.hpp"
#include "obstacle_output.hpp"
#include "options.hpp"
#include "output.hpp"
#include "progress.hpp"
#include "statistics.hpp"

namespace fransac::cli {
namespace {

namespace fs = std::filesystem;

struct TrackCommand {
  std::string input;
  CameraFile camera;
  std::string poses;
  std::string json = "-";
  ObstacleRequest obstacles;
  bool strict = false;
  bool warm_start = false;
  SegmentOptions options;
  TrackOptions track;
};

volatile std::sig_atomic_t g_interrupted = 0;  // NOLINT: a signal handler can reach nothing else

/// Lets Ctrl-C end the reading of frames; what is on its way is still finished. A second one ends the program.
class InterruptGuard {
 public:
  InterruptGuard() : before_(std::signal(SIGINT, handle)) { g_interrupted = 0; }
  InterruptGuard(const InterruptGuard&) = delete;
  InterruptGuard& operator=(const InterruptGuard&) = delete;
  ~InterruptGuard() { std::signal(SIGINT, before_); }
  [[nodiscard]] static bool interrupted() { return g_interrupted != 0; }

 private:
  static void handle(int /*signal*/) {
    g_interrupted = 1;
    std::signal(SIGINT, SIG_DFL);
  }
  void (*before_)(int);
};

/// Where JSON lines go: standard output, or a file that has its name only when it is whole. Devices and pipes are written in
/// place.
class Lines {
 public:
  explicit Lines(const std::string& file) : file_(file) {
    if (file_ == "-") return;
    const bool in_place = fs::exists(file_) && !fs::is_regular_file(file_);
    if (fs::is_regular_file(file_)) file_ = fs::canonical(file_).string();  // of a link its target: the link stays
    part_ = in_place ? file_ : file_ + ".part";
    if (part_ != file_) unfinished_.add(part_);
    out_.open(part_, std::ios::binary | std::ios::trunc);
    check_written();
  }
  void write(const std::string& line) {
    if (file_ == "-") return write_stdout(line);
    out_ << line;
    check_written();
  }
  void finish() {
    if (file_ == "-") return;
    out_.close();
    check_written();
    if (part_ == file_) return;
    std::error_code error;
    fs::rename(part_, file_, error);
    if (error) throw Failure(fmt::format("{}: {}", file_, error.message()));
    unfinished_.finish();
  }

 private:
  void check_written() const {
    if (!out_) throw Failure(fmt::format("{}: could not be written", part_));
  }

  std::string file_;
  std::string part_;
  Unfinished unfinished_;
  std::ofstream out_;
};

double milliseconds_since(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
}

/// One frame on its way.
struct Slot {
  std::size_t number = 0;
  std::string name;
  std::optional<double> timestamp_s;
  io::Frame frame;     ///< From a file, or
  StreamFrame stream;  ///< from the stream.
  std::string error;   ///< Not empty: the frame is skipped.
  double decode_ms = 0.0;
  std::string line;
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

/// The frames themselves keep the cores busy.
SegmentOptions on_one_thread(SegmentOptions options) {
  options.threads = 1;
  return options;
}

/// Reads, segments, follows and writes, each while others do the rest.
class Run {
 public:
  Run(const TrackCommand& command, const Input* input, DepthStream* stream, std::vector<io::TimedPose> poses)
      : command_(command),
        input_(input),
        stream_(stream),
        poses_(std::move(poses)),
        lines_(command.json),
        progress_(input != nullptr ? input->size() : 0),
        options_(on_one_thread(command.options)),
        tracker_(command.track) {}

  void run() {
    const InterruptGuard guard;
    const auto start = std::chrono::steady_clock::now();
    constexpr std::size_t kSlots = 8;  // frames in memory, whatever the length of the sequence
    slots_.resize(kSlots);
    const auto next = [&](std::size_t slot) { return !InterruptGuard::interrupted() && begin(slots_[slot]); };
    const auto decode = [&](std::size_t slot) { load(slots_[slot]); };
    const auto work = [&](std::size_t slot) { follow(slots_[slot]); };
    const auto write = [&](std::size_t slot) { lines_.write(slots_[slot].line); };
    const std::array<PipelineStage, 3> stages{{{decode, true}, {work}, {write}}};
    run_pipeline(command_.options.threads, kSlots, next, stages);
    progress_.clear();
    const bool interrupted = InterruptGuard::interrupted();
    if (!interrupted) {
      if (!stream_error_.empty()) throw Failure(stream_error_);
      if (done_ == 0) throw Failure("no frame could be used");
    }
    lines_.finish();
    if (done_ > 0) summarise(milliseconds_since(start));
    if (interrupted) throw Failure(fmt::format("interrupted after {} frames", done_ + skipped_));
  }

 private:
  bool begin(Slot& slot) {
    slot.number = next_;
    slot.error.clear();
    slot.decode_ms = 0.0;
    if (stream_ != nullptr) {
      if (!read_stream(slot.stream)) return false;
      slot.name = fmt::format("{}", next_);
      slot.timestamp_s = slot.stream.timestamp_s;
    } else {
      if (next_ == input_->size()) return false;
      slot.name = input_->frames[next_].name;
      slot.timestamp_s = input_->frames[next_].timestamp_s;
    }
    ++next_;
    return true;
  }

  /// A stream that breaks off ends it after what came before, as at its end; run() says so.
  bool read_stream(StreamFrame& frame) {
    try {
      return stream_->read(frame);
    } catch (const Failure& failure) {
      stream_error_ = failure.what();
      return false;
    }
  }

  void load(Slot& slot) const {
    if (stream_ != nullptr) return;
    const auto start = std::chrono::steady_clock::now();
    Result<io::Frame> frame = io::load_frame(input_->frames[slot.number]);
    slot.decode_ms = milliseconds_since(start);
    if (frame) {
      slot.frame = *std::move(frame);
    } else {
      slot.error = frame.error().message;
    }
  }

  void follow(Slot& slot) {
    progress_.step(slot.name);
    nlohmann::ordered_json json{{"frame", slot.number}, {"name", slot.name}};
    json["timestamp_s"] = slot.timestamp_s ? nlohmann::ordered_json(*slot.timestamp_s) : nlohmann::ordered_json();
    if (slot.error.empty()) segment_and_track(slot, json);
    if (!slot.error.empty()) {
      if (command_.strict) throw Failure(slot.error);
      progress_.clear();
      log(fmt::format("frame {} is skipped: {}", slot.number, slot.error));
      json["error"] = slot.error;
      ++skipped_;
    }
    slot.line = to_text(json, -1);
  }

  void segment_and_track(Slot& slot, nlohmann::ordered_json& json) {
    const DepthView depth = stream_ != nullptr ? stream_->view(slot.stream) : slot.frame.view();
    const Camera& camera = stream_ != nullptr ? stream_->camera() : slot.frame.camera;
    const auto fails = [&](const Status& status) {
      if (!status) slot.error = fmt::format("{}: {}", slot.name, status.error().message);
      return !status;
    };
    if (fails(fransac::segment(depth, camera, options_, workspace_, segmentation_))) return;
    const bool with_obstacles = command_.obstacles.asked;
    if (with_obstacles && fails(find_obstacles(depth, camera, segmentation_, {}, nullptr, obstacle_workspace_, obstacles_)))
      return;
    std::optional<Eigen::Isometry3d> pose;
    if (!poses_.empty()) {
      if (slot.timestamp_s) pose = io::pose_at(poses_, *slot.timestamp_s);
      if (!pose) {
        slot.error = fmt::format("{}: {} has no pose for its time", slot.name, command_.poses);
        return;
      }
    }
    const auto start = std::chrono::steady_clock::now();
    if (fails(tracker_.update(segmentation_, with_obstacles ? &obstacles_ : nullptr, pose, tracked_))) return;
    const double track_ms = milliseconds_since(start);
    json["pose"] = pose_to_json(tracked_);
    json["planes"] = nlohmann::ordered_json::array();
    for (const TrackedPlane& plane : tracked_.planes) {
      json["planes"].push_back(plane_to_json(plane, segmentation_.planes[static_cast<std::size_t>(plane.label - 1)]));
    }
    if (with_obstacles) {
      json["objects"] = nlohmann::ordered_json::array();
      for (const TrackedObject& object : tracked_.objects) {
        json["objects"].push_back(object_to_json(object, obstacles_.obstacles[static_cast<std::size_t>(object.obstacle - 1)]));
      }
    }
    json["timing_ms"] = {{"decode", slot.decode_ms}, {"segment", segmentation_.timing.total_ms}};
    if (with_obstacles) json["timing_ms"]["obstacles"] = obstacles_.total_ms;
    json["timing_ms"]["track"] = track_ms;
    decode_ms_.push_back(slot.decode_ms);
    work_ms_.push_back(segmentation_.timing.total_ms + (with_obstacles ? obstacles_.total_ms : 0.0) + track_ms);
    ++done_;
  }

  void summarise(double total_ms) const {
    log(fmt::format(
        "{} frames in {:.2f} s, {:.1f} frames a second from end to end; medians of a frame: {:.2f} ms decoding, {:.2f} ms "
        "segmenting and tracking{}",
        done_, 1e-3 * total_ms, 1e3 * static_cast<double>(done_) / total_ms, median(decode_ms_), median(work_ms_),
        skipped_ > 0 ? fmt::format("; {} skipped", skipped_) : ""));
  }

  const TrackCommand& command_;
  const Input* input_;
  DepthStream* stream_;
  std::vector<io::TimedPose> poses_;
  Lines lines_;
  Progress progress_;
  SegmentOptions options_;
  Workspace workspace_;
  Segmentation segmentation_;
  ObstacleWorkspace obstacle_workspace_;
  Obstacles obstacles_;
  Tracker tracker_;
  TrackedFrame tracked_;
  std::vector<Slot> slots_;
  std::string stream_error_;
  std::size_t next_ = 0;
  std::size_t done_ = 0;
  std::size_t skipped_ = 0;
  std::vector<double> decode_ms_;
  std::vector<double> work_ms_;
};

void run_track(const TrackCommand& command) {
  check_options(command.options);
  check_options(command.obstacles.options);
  check_document("--json", command.json);
  check(validate(command.track));
  if (command.options.method != Method::cells && command.options.method != Method::automatic) {
    throw UsageError("--method: only cells gives the planes' covariances, which tracking needs");
  }
  std::vector<io::TimedPose> poses;
  if (!command.poses.empty()) poses = unwrap(io::read_trajectory(command.poses));
  if (command.input == "-") {
    if (command.camera) throw UsageError("--camera: a stream says its camera in its first line");
    DepthStream stream(std::cin);
    return Run(command, nullptr, &stream, std::move(poses)).run();
  }
  const Input input = open_input(command.input, command.camera);
  if (!input.is_folder_of_frames()) throw UsageError(fmt::format("{}: not a folder of frames or a TUM sequence", command.input));
  Run(command, &input, nullptr, std::move(poses)).run();
}

}  // namespace

Command add_track(CLI::App& parent) {
  auto command = std::make_shared<TrackCommand>();
  command->options.method = Method::cells;
  command->options.threads = 0;
  CLI::App* const app = parent.add_subcommand(
      "track", "follow planes and objects through the frames of a moving camera; a line of JSON for each frame");
  app->add_option(
         "INPUT", command->input,
         "folder of frames, TUM RGB-D sequence, or '-': raw frames on standard input, after a line \"fransac-depth 1 WIDTH "
         "HEIGHT uint16|float32 METRES_PER_UNIT FX FY CX CY\", each a 64-bit timestamp and the rows, little-endian")
      ->required();
  add_camera(*app, command->camera);
  app->add_option("--json", command->json, "where the lines go, '-' for standard output")
      ->type_name("FILE")
      ->capture_default_str();
  app->add_option("--poses", command->poses, "camera poses, a TUM trajectory such as groundtruth.txt; else they are estimated")
      ->type_name("FILE");
  app->add_flag("--warm-start", command->warm_start, "look for the last frame's planes first: a little faster");
  app->add_flag("--strict", command->strict, "stop at a frame that cannot be used instead of skipping it");
  add_segment_options(*app, command->options);
  add_obstacle_options(*app, command->obstacles, "follow objects on the support, too");
  return {app, [command] { run_track(*command); }};
}

}  // namespace fransac::cli
