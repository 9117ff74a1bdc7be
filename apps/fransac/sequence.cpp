// SPDX-License-Identifier: Apache-2.0
#include "sequence.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <iterator>
#include <span>
#include <utility>

#include "doubts.hpp"
#include "errors.hpp"
#include "fransac/core/parallel.hpp"
#include "output.hpp"
#include "progress.hpp"

namespace fransac::cli {
namespace {

double milliseconds_since(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
}

/// One frame on its way.
struct Slot {
  std::size_t number = 0;
  std::string name;
  std::optional<double> timestamp_s;
  io::LoadWorkspace workspace;
  io::Frame frame;     ///< From a file, or
  StreamFrame stream;  ///< from the stream.
  std::string error;   ///< Not empty: the frame is skipped.
  double decode_ms = 0.0;
  std::string text;
};

/// Of a frame's files those that following it needs: what is true is for others to read.
io::FrameFiles without_truth(const io::FrameFiles& files) {
  io::FrameFiles measured = files;
  measured.labels = measured.objects = measured.regions = measured.truth = std::nullopt;
  return measured;
}

/// Where frames come from: files, or a stream.
class Source {
 public:
  explicit Source(const std::vector<io::FrameFiles>& files) {
    std::transform(files.begin(), files.end(), std::back_inserter(files_), without_truth);
  }
  explicit Source(DepthStream& stream) : stream_(&stream) {}

  /// 0 for a stream.
  [[nodiscard]] std::size_t size() const { return files_.size(); }
  /// Why the stream broke off.
  [[nodiscard]] const std::string& error() const { return error_; }

  bool begin(Slot& slot) {
    slot.number = next_;
    slot.error.clear();
    slot.decode_ms = 0.0;
    if (stream_ != nullptr) {
      if (!read_stream(slot.stream)) return false;
      slot.name = fmt::format("{}", next_);
      slot.timestamp_s = slot.stream.timestamp_s;
    } else {
      if (next_ == files_.size()) return false;
      slot.name = files_[next_].name;
      slot.timestamp_s = files_[next_].timestamp_s;
    }
    ++next_;
    return true;
  }

  void load(Slot& slot) const {
    if (stream_ != nullptr) return;
    const auto start = std::chrono::steady_clock::now();
    const Status status = io::load_frame(files_[slot.number], std::nullopt, slot.workspace, slot.frame);
    slot.decode_ms = milliseconds_since(start);
    if (!status) slot.error = status.error().message;
  }

  [[nodiscard]] DepthView view(const Slot& slot) const {
    return stream_ != nullptr ? stream_->view(slot.stream) : slot.frame.view();
  }
  void look_at(const Slot& slot, Doubts& doubts, Progress& progress) const {
    if (stream_ != nullptr) return doubts.look_at("standard input", stream_->camera(), stream_->view(slot.stream), progress);
    doubts.look_at(files_[slot.number], slot.frame, progress);
  }
  [[nodiscard]] const Camera& camera(const Slot& slot) const {
    return stream_ != nullptr ? stream_->camera() : slot.frame.camera;
  }

 private:
  /// A stream that breaks off ends it after what came before, as at its end.
  bool read_stream(StreamFrame& frame) {
    try {
      return stream_->read(frame);
    } catch (const Failure& failure) {
      error_ = failure.what();
      return false;
    }
  }

  std::vector<io::FrameFiles> files_;
  DepthStream* stream_ = nullptr;
  std::string error_;
  std::size_t next_ = 0;
};

/// The frames themselves keep the cores busy.
SegmentOptions on_one_thread(SegmentOptions options) {
  options.threads = 1;
  return options;
}

class Follower {
 public:
  Follower(Source source, const FollowRequest& request, const FollowHooks& hooks)
      : source_(std::move(source)),
        request_(request),
        hooks_(hooks),
        progress_(source_.size()),
        options_(on_one_thread(request.options)),
        tracker_(request.track) {}

  FollowTotals run() {
    const auto start = std::chrono::steady_clock::now();
    constexpr std::size_t kSlots = 8;  // frames in memory, whatever the length of the sequence
    std::vector<Slot> slots(kSlots);
    const auto is_stopped = [&] { return hooks_.stopped && hooks_.stopped(); };
    const auto next = [&](std::size_t slot) { return !is_stopped() && source_.begin(slots[slot]); };
    const auto decode = [&](std::size_t slot) { source_.load(slots[slot]); };
    const auto work = [&](std::size_t slot) { follow(slots[slot]); };
    const auto write = [&](std::size_t slot) {
      if (hooks_.write) hooks_.write(slots[slot].text);
    };
    const std::array<PipelineStage, 3> stages{{{decode, true}, {work}, {write}}};
    run_pipeline(request_.options.threads, kSlots, next, stages);
    progress_.clear();
    const bool stopped = is_stopped();  // a stream can have broken off because of it
    if (!stopped && !source_.error().empty()) throw Failure(source_.error());
    if (!stopped && totals_.followed() == 0) throw Failure("no frame could be used");
    totals_.total_ms = milliseconds_since(start);
    return totals_;
  }

 private:
  void follow(Slot& slot) {
    progress_.step(slot.name);
    FollowedFrame frame{slot.number, slot.name, slot.timestamp_s, slot.decode_ms};
    if (slot.error.empty()) {
      if (const Status status = segment_and_track(slot, frame); !status) {
        slot.error = fmt::format("{}: {}", slot.name, status.error().message);
      }
    }
    if (slot.error.empty()) {
      count(frame);
    } else {
      skip(slot);
      frame = {.number = slot.number, .name = slot.name, .timestamp_s = slot.timestamp_s, .error = slot.error};
    }
    slot.text = hooks_.describe(frame);
  }

  void skip(const Slot& slot) {
    if (request_.strict) throw Failure(slot.error);
    progress_.clear();
    log(fmt::format("frame {} is skipped: {}", slot.number, slot.error));
    ++totals_.skipped;
  }

  void count(const FollowedFrame& frame) {
    totals_.decode_ms.add(frame.decode_ms);
    totals_.work_ms.add(frame.work_ms());
    (frame.warm ? totals_.warm_ms : totals_.cold_ms).add(frame.segmentation->timing.total_ms);
  }

  Status segment_and_track(const Slot& slot, FollowedFrame& frame) {
    frame.depth = source_.view(slot);
    source_.look_at(slot, doubts_, progress_);
    const Camera& camera = source_.camera(slot);
    if (request_.warm_start) {
      frame.warm = totals_.followed() % kColdEvery != 0;
      workspace_.expect(frame.warm ? std::span<const PlaneSegment>(segmentation_.planes) : std::span<const PlaneSegment>());
    }
    if (Status status = fransac::segment(frame.depth, camera, options_, workspace_, segmentation_); !status) return status;
    frame.segmentation = &segmentation_;
    if (request_.obstacles.asked) {
      const AxisLimits* const limits = limits_of(options_, segmentation_.method, true);
      if (Status status = find_obstacles(frame.depth, camera, segmentation_, request_.obstacles.options, limits,
                                         obstacle_workspace_, obstacles_);
          !status) {
        return status;
      }
      frame.obstacles = &obstacles_;
    }
    std::optional<Eigen::Isometry3d> pose;
    if (!request_.poses.empty()) {
      if (slot.timestamp_s) pose = io::pose_at(request_.poses, *slot.timestamp_s);
      if (!pose) return Error{ErrorCode::no_data, request_.poses_file + " has no pose for its time"};
    }
    const auto start = std::chrono::steady_clock::now();
    if (Status status = tracker_.update(segmentation_, frame.obstacles, pose, tracked_); !status) return status;
    frame.track_ms = milliseconds_since(start);
    frame.tracked = &tracked_;
    return {};
  }

  Source source_;
  const FollowRequest& request_;
  const FollowHooks& hooks_;
  Progress progress_;
  Doubts doubts_;
  SegmentOptions options_;
  Workspace workspace_;
  Segmentation segmentation_;
  ObstacleWorkspace obstacle_workspace_;
  Obstacles obstacles_;
  Tracker tracker_;
  TrackedFrame tracked_;
  FollowTotals totals_;
};

}  // namespace

FollowTotals follow_frames(const std::vector<io::FrameFiles>& frames, const FollowRequest& request, const FollowHooks& hooks) {
  return Follower(Source(frames), request, hooks).run();
}

FollowTotals follow_frames(DepthStream& stream, const FollowRequest& request, const FollowHooks& hooks) {
  return Follower(Source(stream), request, hooks).run();
}

bool is_sequence(const std::vector<io::FrameFiles>& frames) {
  return frames.size() > 1 && std::all_of(frames.begin(), frames.end(), [](const auto& frame) { return frame.timestamp_s; });
}

}  // namespace fransac::cli
