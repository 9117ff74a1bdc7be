// SPDX-License-Identifier: Apache-2.0
/// The scenes: what stands where, and how the camera moves through it.
#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <string_view>

#include "synth/geometry.hpp"

namespace fransac::synth::detail {

/// Built in a world frame: floor or road at z = 0 unless said otherwise, z up, the camera looking roughly along +y.
struct Stage {
  Scene scene;
  Eigen::Vector3d camera{0.0, 0.0, 1.4};  ///< The middle of its path.
  Eigen::Vector3d target{0.0, 2.0, 0.8};  ///< What it looks at.
  Eigen::Vector3d sway{0.2, 0.2, 0.05};   ///< Half the length of its path to the side, forward and up, metres.
};

using BuildScene = Stage (*)(std::uint64_t seed);

/// Null for an unknown name.
BuildScene find_scene(std::string_view name);

/// To the side, ahead and up, as columns: how the camera in the middle of its path stands, made level.
Eigen::Matrix3d facing(const Stage& stage);
/// A camera that looks from one point at another, upright.
Eigen::Isometry3d looking(const Eigen::Vector3d& from, const Eigen::Vector3d& to);

/// Where the camera is in one frame: a closed, slow path (kFramesPerRound frames) shared by all frames of a seed, with a
/// small tremor of its own in each frame.
Eigen::Isometry3d camera_pose(const Stage& stage, std::uint64_t seed, int frame);

/// What a random stream is for: streams of different purposes, frames and rows never meet.
enum class Purpose : std::uint64_t { scene, path, tremor, noise, dropout, matching, holes, drift, walk };
constexpr std::uint64_t stream_index(Purpose purpose, int frame = 0, int row = 0) {
  return static_cast<std::uint64_t>(purpose) << 56 | static_cast<std::uint64_t>(frame) << 24 | static_cast<std::uint64_t>(row);
}

}  // namespace fransac::synth::detail
