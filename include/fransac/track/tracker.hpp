// SPDX-License-Identifier: Apache-2.0
/// Planes and objects that keep their ids from frame to frame of a moving camera.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <limits>
#include <memory>
#include <optional>
#include <string_view>
#include <vector>

#include "fransac/core/plane.hpp"
#include "fransac/core/result.hpp"
#include "fransac/obstacles/obstacles.hpp"
#include "fransac/planes/options.hpp"
#include "fransac/planes/segment.hpp"

namespace fransac {

/// What a camera does between two frames, and what planes do. Defaults are those of a camera in somebody's hand at 30 Hz.
struct TrackOptions {
  double rotation_deg = 1.5;    ///< One sigma of how far the camera turns otherwise than in the frame before.
  double translation_m = 0.02;  ///< One sigma of how far it moves otherwise.
  double gate_sigmas = 3.0;     ///< A plane is the one of the frame before when it is off by no more than this.
  int longest_gap = 30;         ///< Frames that something may be out of sight and come back under its id.
  double drift_deg = 0.02;  ///< One sigma, a frame, of how a known plane seems to turn: errors that come and go with the view.
  double drift_m = 0.0005;  ///< The same for its distance.
  double object_reach_m = 0.10;  ///< How far an object's centre may jump, for what is seen of it changes.
};

/// Calls visit(info, value&) for every option.
template <class Options, class Visitor>
void for_each_track_option(Options& o, Visitor&& visit) {
  constexpr double kInf = std::numeric_limits<double>::infinity();
  visit(OptionInfo{"track-rotation", "deg", "one sigma of how the camera's turning changes between frames", 0, 180, true},
        o.rotation_deg);
  visit(OptionInfo{"track-translation", "m", "one sigma of how the camera's motion changes between frames", 0, kInf, true, true},
        o.translation_m);
  visit(OptionInfo{"track-gate", "sigmas", "largest difference of a plane to the one of the frame before", 0, kInf, true, true},
        o.gate_sigmas);
  visit(OptionInfo{"track-gap", "frames", "longest absence after which an id comes back", 0, 1e6}, o.longest_gap);
  visit(OptionInfo{"track-drift-angle", "deg", "one sigma of a plane's apparent turning per frame", 0, 180}, o.drift_deg);
  visit(OptionInfo{"track-drift-offset", "m", "one sigma of a plane's apparent motion per frame", 0, kInf, false, true},
        o.drift_m);
  visit(OptionInfo{"track-object-reach", "m", "farthest that an object's middle may seem to jump", 0, kInf, true, true},
        o.object_reach_m);
}
/// Checks every range. The message names the option.
Status validate(const TrackOptions& options);

/// A plane of a frame, under the id that it keeps.
struct TrackedPlane {
  int id = 0;     ///< For as long as it is tracked, from 1; no two have the same.
  int label = 0;  ///< Of the frame's segmentation.
  Plane plane;    ///< Smoothed, in this frame's camera frame.
  Eigen::Matrix<double, 4, 4, Eigen::DontAlign> covariance = Eigen::Matrix4d::Zero();  ///< Of (normal, d), rank 3.
  int age = 1;  ///< Frames in which it was seen, this one included.
};

/// An obstacle of a frame, under the id that it keeps.
struct TrackedObject {
  int id = 0;        ///< As a plane's, counted by itself.
  int obstacle = 0;  ///< Its id in the frame's Obstacles.
  int age = 1;       ///< Frames in which it was seen, this one included.
};

/// Where a pose comes from.
enum class PoseSource {
  given,      ///< By the caller.
  estimated,  ///< From the planes.
  guessed,    ///< No plane was recognised: as if the camera had moved on.
};
template <>
struct EnumNames<PoseSource> {
  static constexpr std::string_view values[] = {"given", "estimated", "guessed"};
};

/// What is known after a frame.
struct TrackedFrame {
  /// From the camera's frame to the first frame's, or to that of the poses given. Directions that no plane fixes are guessed.
  Eigen::Isometry3d T_world_camera = Eigen::Isometry3d::Identity();
  PoseSource pose_source = PoseSource::estimated;  ///< Where T_world_camera is from.
  std::vector<TrackedPlane> planes;                ///< In the order of the segmentation.
  std::vector<TrackedObject> objects;              ///< In the order of the obstacles; drops are left out.
};

/// Feed it frames in order. Planes need a covariance: the method `cells`. Not for concurrent use. docs/algorithms.md, "Tracking",
/// derives the steps.
class Tracker {
 public:
  /// Knows nothing yet. Options are checked by update().
  explicit Tracker(const TrackOptions& options = {});
  ~Tracker();
  Tracker(Tracker&&) noexcept;
  Tracker& operator=(Tracker&&) noexcept;

  /// `obstacles` null: planes only. `T_world_camera`: the camera's pose where it is known; known in one frame, it should be in
  /// all. Errors: invalid_argument (options, a pose that is no rotation and translation, a plane or box that is not finite),
  /// unsupported (a method without covariances), out_of_memory (the tracker then starts anew, as after reset(), but with new ids;
  /// so it does where numbers are too large or too small to work with, invalid_argument).
  Status update(const Segmentation& segmentation, const Obstacles* obstacles,
                const std::optional<Eigen::Isometry3d>& T_world_camera, TrackedFrame& frame);

  /// Forgets everything but the options.
  void reset();

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace fransac
