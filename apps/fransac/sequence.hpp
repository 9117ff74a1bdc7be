// SPDX-License-Identifier: Apache-2.0
/// Frames of a moving camera, followed: read, segmented and tracked, each while others do the rest.
#pragma once

#include <cstddef>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "depth_stream.hpp"
#include "fransac/io/dataset.hpp"
#include "fransac/io/trajectory.hpp"
#include "fransac/obstacles/obstacles.hpp"
#include "fransac/planes/segment.hpp"
#include "fransac/track/tracker.hpp"
#include "options.hpp"
#include "statistics.hpp"

namespace fransac::cli {

/// How frames are followed.
struct FollowRequest {
  SegmentOptions options;  ///< Threads: of all frames that are on their way; each is segmented on one.
  ObstacleRequest obstacles;
  TrackOptions track;
  std::string poses_file;            ///< For messages.
  std::vector<io::TimedPose> poses;  ///< The camera's, sorted by time; empty: they are estimated.
  bool warm_start = false;
  bool strict = false;  ///< A frame that cannot be used is a Failure.
};

/// With a warm start every tenth frame is segmented from cold all the same: to compare the times.
inline constexpr std::size_t kColdEvery = 10;

/// A frame as it is seen while it is followed: nothing of it outlives the call.
struct FollowedFrame {
  std::size_t number = 0;  ///< From 0, skipped frames included.
  std::string_view name{};
  std::optional<double> timestamp_s;
  double decode_ms = 0.0;
  std::string error{};  ///< Not empty: why the frame is skipped; then all that follows is empty.
  DepthView depth{};
  const Segmentation* segmentation = nullptr;
  const Obstacles* obstacles = nullptr;  ///< Null where they were not asked for.
  const TrackedFrame* tracked = nullptr;
  bool warm = false;  ///< Whether the last frame's planes were looked for first.
  double track_ms = 0.0;

  /// From the decoded frame to all ids.
  [[nodiscard]] double work_ms() const {
    return segmentation->timing.total_ms + (obstacles != nullptr ? obstacles->total_ms : 0.0) + track_ms;
  }
};

struct FollowTotals {
  std::size_t skipped = 0;
  double total_ms = 0.0;
  QuantileSketch decode_ms;  ///< Of all frames that were followed, as the next: a stream may never end.
  QuantileSketch work_ms;
  QuantileSketch cold_ms;  ///< Times to segment: of frames from cold, and
  QuantileSketch warm_ms;  ///< of frames with a warm start.

  [[nodiscard]] std::size_t followed() const { return work_ms.count(); }
};

struct FollowHooks {
  /// Sees each frame, in order; what it returns is handed on.
  std::function<std::string(const FollowedFrame&)> describe;
  /// Takes that, in order, while the next frame is followed. May be empty.
  std::function<void(const std::string&)> write{};
  /// Ends the reading when true; what is on its way is finished. May be empty.
  std::function<bool()> stopped{};
};

/// Follows files of frames, or a stream. Logs what is skipped. Throws Failure: where no frame could be used, a stream broke off
/// or, if `strict`, a frame is skipped; not when stopped.
FollowTotals follow_frames(const std::vector<io::FrameFiles>& frames, const FollowRequest& request, const FollowHooks& hooks);
FollowTotals follow_frames(DepthStream& stream, const FollowRequest& request, const FollowHooks& hooks);

/// Whether frames are those of one camera over time: there are several, and all have a time.
bool is_sequence(const std::vector<io::FrameFiles>& frames);

}  // namespace fransac::cli
