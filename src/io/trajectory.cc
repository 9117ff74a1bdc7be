// SPDX-License-Identifier: Apache-2.0
#include "fransac/io/trajectory.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>

#include "io/guard.h"
#include "io/read_text.h"
#include "io/text.h"

namespace fransac::io {
namespace {

constexpr std::size_t kNumbers = 8;
constexpr std::size_t kMaxTrajectoryBytes = std::size_t{1} << 28;  // three million poses

/// The numbers of a line; nothing when it does not hold just as many.
std::optional<std::array<double, kNumbers>> parse_numbers(std::string_view line) {
  std::array<double, kNumbers> numbers{};
  for (double& number : numbers) {
    line.remove_prefix(std::min(line.find_first_not_of(kBlanks), line.size()));
    const auto [end, error] = std::from_chars(line.data(), line.data() + line.size(), number);
    if (error != std::errc() || !std::isfinite(number)) return std::nullopt;
    line.remove_prefix(static_cast<std::size_t>(end - line.data()));
    if (!line.empty() && kBlanks.find(line.front()) == std::string_view::npos) return std::nullopt;
  }
  if (line.find_first_not_of(kBlanks) != std::string_view::npos) return std::nullopt;
  return numbers;
}

}  // namespace

Result<std::vector<TimedPose>> parse_trajectory(std::string_view text, const std::string& name) {
  return guarded(name, [&]() -> Result<std::vector<TimedPose>> {
    std::vector<TimedPose> poses;
    const Status read = for_each_line(text, [&](std::string_view line, std::size_t number) -> Status {
      const auto fault = [&](const char* what) { return line_error(name, number, what); };
      const auto n = parse_numbers(line);
      if (!n) return fault("is not \"timestamp tx ty tz qx qy qz qw\"");
      const Eigen::Quaterniond q((*n)[7], (*n)[4], (*n)[5], (*n)[6]);
      constexpr double kUnit = 1e-2;  // files are written with four digits
      if (std::abs(q.norm() - 1.0) > kUnit) return fault("the quaternion's length is not 1");
      TimedPose& pose = poses.emplace_back();
      pose.timestamp_s = (*n)[0];
      pose.T_world_camera.linear() = q.normalized().toRotationMatrix();
      pose.T_world_camera.translation() << (*n)[1], (*n)[2], (*n)[3];
      return {};
    });
    if (!read) return read.error();
    if (poses.empty()) return file_error(ErrorCode::no_data, name, "no pose");
    std::stable_sort(poses.begin(), poses.end(),
                     [](const TimedPose& a, const TimedPose& b) { return a.timestamp_s < b.timestamp_s; });
    return poses;
  });
}

Result<std::vector<TimedPose>> read_trajectory(const std::filesystem::path& file) {
  return guarded(file.native(), [&] { return read_text(file, kMaxTrajectoryBytes, &parse_trajectory); });
}

std::optional<Eigen::Isometry3d> pose_at(std::span<const TimedPose> sorted, double time_s, double longest_gap_s) {
  const auto later = std::lower_bound(sorted.begin(), sorted.end(), time_s,
                                      [](const TimedPose& pose, double time) { return pose.timestamp_s < time; });
  const bool has_after = later != sorted.end() && later->timestamp_s - time_s <= longest_gap_s;
  const bool has_before = later != sorted.begin() && time_s - (later - 1)->timestamp_s <= longest_gap_s;
  if (has_after && has_before) {
    const TimedPose& a = *(later - 1);
    const TimedPose& b = *later;
    const double share = (time_s - a.timestamp_s) / (b.timestamp_s - a.timestamp_s);
    Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
    T.linear() = Eigen::Quaterniond(a.T_world_camera.linear())
                     .slerp(share, Eigen::Quaterniond(b.T_world_camera.linear()))
                     .toRotationMatrix();
    T.translation() = (1.0 - share) * a.T_world_camera.translation() + share * b.T_world_camera.translation();
    return T;
  }
  if (has_after) return later->T_world_camera;
  if (has_before) return (later - 1)->T_world_camera;
  return std::nullopt;
}

}  // namespace fransac::io
