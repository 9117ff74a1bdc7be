// SPDX-License-Identifier: Apache-2.0
/// The path of a camera that is carried through a scene.
#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <vector>

#include "synth/scenes.hpp"

namespace fransac::synth::detail {

/// What a frame of a walk moves and turns by, and how much its way bends, where the three take equal shares of it: the camera
/// moves farther where it turns less. Its pace changes by a quarter. A choice, to lie within what Motion::walk promises.
namespace walk {
inline constexpr double kStep_m = 0.015;
inline constexpr double kTurn_rad = 0.008;
inline constexpr double kBend_rad = 0.09;
inline constexpr double kPace = 0.25;
}  // namespace walk

/// A smooth closed path about the middle of the stage, as wide as the scene leaves it free, looking at what the stage looks at
/// and about it. All frames of a seed share it.
class Walk {
 public:
  Walk(const Stage& stage, std::uint64_t seed);

  /// The camera in the world.
  [[nodiscard]] Eigen::Isometry3d pose(int frame) const;
  /// The camera at one of `count` places spread over the round.
  [[nodiscard]] Eigen::Isometry3d view(int i, int count) const;

 private:
  [[nodiscard]] Eigen::Isometry3d at(double angle) const;
  [[nodiscard]] Eigen::Isometry3d after(double frames) const;
  [[nodiscard]] bool is_free(const Scene& scene) const;
  void measure();

  Eigen::Vector3d middle_;
  Eigen::Vector3d target_;
  Eigen::Vector3d reach_;   // half the path's length aside, ahead and up
  Eigen::Matrix3d facing_;  // columns aside, ahead, up
  double direction_ = 1.0;
  double start_, bob_, glance_, nod_, roll_, pace_;  // phases
  std::vector<double> frames_;                       // at equal angles from 0 on: frames passed
};

}  // namespace fransac::synth::detail
