// SPDX-License-Identifier: Apache-2.0
#include "sequence.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>

#include "../obstacle_output.hpp"
#include "fransac/core/labels.hpp"
#include "fransac/io/overlay.hpp"
#include "pictures.hpp"

namespace fransac::cli::report {
namespace {

/// Labels with each plane's replaced by the one whose colour its id has.
std::vector<std::uint8_t> labels_by_id(const FollowedFrame& frame) {
  std::array<std::uint8_t, 256> shown{};
  shown[kLabelNoPlane] = kLabelNoPlane;
  for (const TrackedPlane& plane : frame.tracked->planes) shown[static_cast<std::size_t>(plane.label)] = colour_label(plane.id);
  std::vector<std::uint8_t> labels = frame.segmentation->labels;
  for (std::uint8_t& label : labels) label = shown[label];
  return labels;
}

/// A number per pixel that has the colour of its object's id; 0 on drops, which have none.
std::vector<std::uint16_t> objects_by_id(const FollowedFrame& frame) {
  std::vector<std::uint16_t> shown(frame.obstacles->obstacles.size() + 1, 0);
  for (const TrackedObject& object : frame.tracked->objects) {
    shown[static_cast<std::size_t>(object.obstacle)] = colour_label(object.id);
  }
  std::vector<std::uint16_t> numbers = frame.obstacles->labels;
  for (std::uint16_t& number : numbers) number = shown[number];
  return numbers;
}

/// Poses, until all are known and can be seen from above.
class Poses {
 public:
  void add(const FollowedFrame& frame, bool with_view) {
    const Eigen::Isometry3d& pose = frame.tracked->T_world_camera;
    if (with_view) views_.push_back(positions_.size());
    positions_.emplace_back(pose.translation());
    ahead_.emplace_back(pose.linear().col(2));
    if (frame.segmentation->up) up_ += pose.linear() * *frame.segmentation->up;
    guessed_ += frame.tracked->pose_source == PoseSource::guessed ? 1U : 0U;
    if (positions_.size() == 1) {
      level_ = -pose.linear().col(1);
      top_ = -pose.linear().col(1);
    }
  }

  [[nodiscard]] CameraPath path() const {
    CameraPath path;
    path.guessed = guessed_;
    path.up_is_known = up_.norm() > 0.0;
    const Eigen::Vector3d up = (path.up_is_known ? up_ : level_).normalized();
    const auto flat = [&](const Eigen::Vector3d& v) -> Eigen::Vector3d { return v - up * up.dot(v); };
    // A camera that looks straight down has its image's upper border ahead.
    constexpr double kSteep = 0.1;
    Eigen::Vector3d forward = flat(ahead_.front());
    if (forward.norm() < kSteep) forward = flat(top_);
    forward.normalize();
    const Eigen::Vector3d right = forward.cross(up);
    const auto seen = [&](const Eigen::Vector3d& v) { return Dot{right.dot(v), forward.dot(v)}; };
    for (const std::size_t i : evenly_chosen(positions_.size(), kMostPathPoints)) {
      path.points.push_back(seen(positions_[i] - positions_.front()));
    }
    for (const std::size_t i : views_) path.views.push_back({seen(positions_[i] - positions_.front()), seen(flat(ahead_[i]))});
    return path;
  }

 private:
  std::vector<Eigen::Vector3d> positions_;
  std::vector<Eigen::Vector3d> ahead_;
  std::vector<std::size_t> views_;
  Eigen::Vector3d up_ = Eigen::Vector3d::Zero();
  Eigen::Vector3d level_ = Eigen::Vector3d::UnitZ();
  Eigen::Vector3d top_ = Eigen::Vector3d::UnitZ();
  std::size_t guessed_ = 0;
};

class Watcher {
 public:
  Watcher(SequenceReport& report, int width)
      : report_(report), width_(width), chosen_(evenly_chosen(report.frames, kMostThumbnails)) {}

  void see(const FollowedFrame& frame) {
    if (!frame.error.empty()) {
      if (report_.errors.size() < kMostErrors) report_.errors.push_back(frame.error);
      return;
    }
    report_.usable.push_back(frame.number);
    report_.work_ms.push_back(frame.work_ms());
    for (const TrackedPlane& tracked : frame.tracked->planes) {
      const PlaneSegment& plane = frame.segmentation->planes[static_cast<std::size_t>(tracked.label - 1)];
      note(report_.planes[tracked.id], frame.number, enum_name(plane.kind), plane.area_m2);
    }
    for (const TrackedObject& tracked : frame.tracked->objects) {
      const Obstacle& obstacle = frame.obstacles->obstacles[static_cast<std::size_t>(tracked.obstacle - 1)];
      Seen& seen = report_.objects[tracked.id];
      note(seen, frame.number, enum_name(obstacle.kind), static_cast<double>(obstacle.pixels));
      seen.box += obstacle.box.size;
    }
    const bool drawn = next_ < chosen_.size() && frame.number >= chosen_[next_];  // or the next one after those skipped
    if (drawn) draw(frame);
    while (next_ < chosen_.size() && chosen_[next_] <= frame.number) ++next_;
    poses_.add(frame, drawn);
  }

  void finish() { report_.path = poses_.path(); }

 private:
  void note(Seen& seen, std::size_t frame, std::string_view kind, double weight) {
    const auto column = static_cast<std::uint32_t>(report_.column_of(frame));
    if (seen.frames == 0) seen.first = frame;
    if (seen.spans.empty() || seen.spans.back().first != column) seen.spans.emplace_back(column, 0);
    ++seen.spans.back().second;
    ++seen.frames;
    ++seen.kinds[kind];
    seen.last = frame;
    seen.weight += weight;
  }

  void draw(const FollowedFrame& frame) {
    if (!start_s_) start_s_ = frame.timestamp_s;
    const std::string title = fmt::format("frame {}", frame.number);
    const std::string time = frame.timestamp_s ? fmt::format("{:.2f} s", *frame.timestamp_s - *start_s_) : "";
    const std::vector<std::uint8_t> labels = labels_by_id(frame);
    report_.plane_pictures.push_back(
        picture(title, "Planes of " + title, time, io::overlay(frame.depth, labels, nullptr), width_));
    if (frame.obstacles == nullptr) return;
    report_.object_pictures.push_back(picture(title, "Objects of " + title, time,
                                              obstacle_overlay(frame.depth, labels, objects_by_id(frame), nullptr), width_));
  }

  SequenceReport& report_;
  int width_;
  std::vector<std::size_t> chosen_;
  std::size_t next_ = 0;
  std::optional<double> start_s_;
  Poses poses_;
};

}  // namespace

std::vector<std::size_t> evenly_chosen(std::size_t count, std::size_t wanted) {
  const std::size_t chosen = std::min(count, wanted);
  std::vector<std::size_t> places;
  for (std::size_t i = 0; i < chosen; ++i) places.push_back(chosen == 1 ? 0 : i * (count - 1) / (chosen - 1));
  return places;
}

std::string_view Seen::kind() const {
  const auto fewer = [](const auto& a, const auto& b) { return a.second < b.second; };
  const auto most = std::max_element(kinds.begin(), kinds.end(), fewer);
  return most == kinds.end() ? std::string_view() : most->first;
}

std::size_t SequenceReport::frames_in(std::size_t column) const {
  const auto begin = [&](std::size_t c) { return (c * frames + columns() - 1) / columns(); };
  return begin(column + 1) - begin(column);
}

SequenceReport watch_sequence(const std::string& name, const std::vector<io::FrameFiles>& frames, const FollowRequest& request,
                              int width) {
  SequenceReport report;
  report.name = name;
  report.frames = frames.size();
  report.with_objects = request.obstacles.asked;
  if (frames.front().timestamp_s && frames.back().timestamp_s) {
    report.duration_s = *frames.back().timestamp_s - *frames.front().timestamp_s;
  }
  Watcher watcher(report, width);
  const auto see = [&](const FollowedFrame& frame) {
    watcher.see(frame);
    return std::string();
  };
  report.totals = follow_frames(frames, request, {.describe = see});
  watcher.finish();
  return report;
}

}  // namespace fransac::cli::report
