// SPDX-License-Identifier: Apache-2.0
/// Camera poses over time.
#pragma once

#include <Eigen/Geometry>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "fransac/core/result.hpp"

namespace fransac::io {

/// Where the camera was at a time.
struct TimedPose {
  double timestamp_s = 0.0;                                          ///< Seconds, of any clock.
  Eigen::Isometry3d T_world_camera = Eigen::Isometry3d::Identity();  ///< p_world = T_world_camera * p_camera, metres.
};

/// Reads lines "timestamp tx ty tz qx qy qz qw" (TUM RGB-D's groundtruth.txt: metres, unit quaternion, camera to world); '#'
/// starts a comment. Sorted by time. Errors name the file and the line.
Result<std::vector<TimedPose>> read_trajectory(const std::filesystem::path& file);
/// The same from memory; `name` stands for the file in messages.
Result<std::vector<TimedPose>> parse_trajectory(std::string_view text, const std::string& name);

/// The pose at a time, between the two nearest by interpolation; nothing more than `longest_gap_s` from a known one.
std::optional<Eigen::Isometry3d> pose_at(std::span<const TimedPose> sorted, double time_s, double longest_gap_s = 0.1);

}  // namespace fransac::io
