// SPDX-License-Identifier: Apache-2.0
// Trajectories: any text is poses in order of time, each a rotation and a finite place, or an error that names the file.
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <string_view>

#include "fransac/io/trajectory.hpp"

namespace {

bool is_pose(const Eigen::Isometry3d& T) {
  const Eigen::Matrix3d R = T.linear();
  return T.matrix().allFinite() && (R * R.transpose()).isIdentity(1e-9) && R.determinant() > 0.0;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace fransac::io;
  const auto poses = parse_trajectory({reinterpret_cast<const char*>(data), size}, "poses.txt");
  if (!poses) {
    if (!poses.error().message.starts_with("poses.txt:")) __builtin_trap();
    return 0;
  }
  const auto earlier = [](const TimedPose& a, const TimedPose& b) { return a.timestamp_s < b.timestamp_s; };
  if (poses->empty() || !std::is_sorted(poses->begin(), poses->end(), earlier)) __builtin_trap();
  for (std::size_t i = 0; i < poses->size(); ++i) {
    const double time = (*poses)[i].timestamp_s;
    if (!std::isfinite(time) || !is_pose((*poses)[i].T_world_camera)) __builtin_trap();
    if (!pose_at(*poses, time)) __builtin_trap();
    const double next = (*poses)[std::min(i + 1, poses->size() - 1)].timestamp_s;
    const auto between = pose_at(*poses, 0.5 * time + 0.5 * next);
    if (between && !is_pose(*between)) __builtin_trap();
  }
  return 0;
}
