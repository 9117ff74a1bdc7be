// SPDX-License-Identifier: Apache-2.0
#include "fransac/io/trajectory.hpp"

#include <gmock/gmock.h>

#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include "temporary_folder.h"

namespace fransac::io {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector3d;
using fransac::testing::TemporaryFolder;
using std::numbers::pi;
using ::testing::HasSubstr;
using ::testing::StartsWith;

TEST(Trajectory, ReadsLinesCommentsAndBlanks) {
  const auto poses = parse_trajectory(
      "# ground truth trajectory\n#\n\n"
      "2.5 1 2 3 0 0 0 1\n"
      "  1.5\t-1e-1 0.25 -3 0.7071 0 0 0.7071  \r\n"
      "3 0 0 0 0 0 -1 0 # remark",
      "poses.txt");
  ASSERT_TRUE(poses.ok()) << poses.error().message;
  ASSERT_EQ(poses->size(), 3U);
  EXPECT_EQ((*poses)[0].timestamp_s, 1.5);  // sorted
  EXPECT_EQ((*poses)[0].T_world_camera.translation(), Vector3d(-0.1, 0.25, -3.0));
  // A quarter turn about x takes y to z, however few digits there were.
  EXPECT_LT(((*poses)[0].T_world_camera.linear() * Vector3d::UnitY() - Vector3d::UnitZ()).norm(), 1e-12);
  EXPECT_EQ((*poses)[1].timestamp_s, 2.5);
  EXPECT_TRUE((*poses)[1].T_world_camera.linear().isIdentity(0.0));
  EXPECT_LT(((*poses)[2].T_world_camera.linear() * Vector3d::UnitX() + Vector3d::UnitX()).norm(), 1e-12);
}

TEST(Trajectory, NamesFileAndLineOfAFault) {
  const std::string form = "is not \"timestamp tx ty tz qx qy qz qw\"";
  const std::string length = "the quaternion's length is not 1";
  const std::pair<std::string, std::string> faults[] = {
      {"1 0 0 0 0 0 0", form},
      {"1 0 0 0 0 0 0 1 0", form},
      {"1 0 0 0 0 0 0 1x", form},
      {"1,0,0,0,0,0,0,1", form},
      {"x 0 0 0 0 0 0 1", form},
      {"nan 0 0 0 0 0 0 1", form},
      {"1 inf 0 0 0 0 0 1", form},
      {"1 0 1e999 0 0 0 0 1", form},
      {"1 0 0 0 0 # 0 0 1", form},
      {std::string("1 0 0 0 0 0 0 1\0", 16), form},
      {"1 0 0 0 0 0 0 0", length},
      {"1 0 0 0 0 0 0 1.02", length},
      {"1 0 0 0 0.5 0.5 0.5 0.4", length},
      {"1 0 0 0 1e300 0 0 1", length},
  };
  for (const auto& [line, what] : faults) {
    const auto poses = parse_trajectory("# head\n0 0 0 0 0 0 0 1\n" + line + "\n", "poses.txt");
    ASSERT_FALSE(poses.ok()) << line;
    EXPECT_EQ(poses.error().code, ErrorCode::format);
    EXPECT_EQ(poses.error().message, "poses.txt:3: " + what) << line;
  }
}

TEST(Trajectory, WithoutAPoseThereIsNone) {
  for (const char* text : {"", "\n\n", "# only a comment", " \t\r\n#\n"}) {
    const auto poses = parse_trajectory(text, "poses.txt");
    ASSERT_FALSE(poses.ok());
    EXPECT_EQ(poses.error().code, ErrorCode::no_data);
    EXPECT_THAT(poses.error().message, StartsWith("poses.txt: "));
  }
}

TEST(Trajectory, ReadsAFileAndNamesOneThatIsMissing) {
  const TemporaryFolder folder;
  folder.write("poses.txt", "1 0 0 0 0 0 0 1\n");
  const auto poses = read_trajectory(folder / "poses.txt");
  ASSERT_TRUE(poses.ok()) << poses.error().message;
  EXPECT_EQ(poses->size(), 1U);
  const auto missing = read_trajectory(folder / "nowhere.txt");
  ASSERT_FALSE(missing.ok());
  EXPECT_THAT(missing.error().message, HasSubstr("nowhere.txt"));
}

TimedPose pose(double time_s, double x, double turn) {
  TimedPose result;
  result.timestamp_s = time_s;
  result.T_world_camera.translation() = Vector3d(x, 0.0, 0.0);
  result.T_world_camera.linear() = Eigen::AngleAxisd(turn, Vector3d::UnitZ()).toRotationMatrix();
  return result;
}

void expect_pose(const std::optional<Isometry3d>& found, double x, double turn) {
  ASSERT_TRUE(found.has_value());
  EXPECT_NEAR(found->translation().x(), x, 1e-12);
  EXPECT_LT((found->linear() - Eigen::AngleAxisd(turn, Vector3d::UnitZ()).toRotationMatrix()).norm(), 1e-12);
}

TEST(PoseAt, IsBetweenTheTwoNearest) {
  const std::vector<TimedPose> poses{pose(1.0, 0.0, 0.0), pose(1.1, 1.0, 0.4), pose(1.2, 3.0, 0.0)};
  expect_pose(pose_at(poses, 1.0), 0.0, 0.0);
  expect_pose(pose_at(poses, 1.025), 0.25, 0.1);
  expect_pose(pose_at(poses, 1.1), 1.0, 0.4);
  expect_pose(pose_at(poses, 1.15), 2.0, 0.2);
  expect_pose(pose_at(poses, 1.2), 3.0, 0.0);
}

TEST(PoseAt, TurnsTheShortWay) {
  const std::vector<TimedPose> poses{pose(0.0, 0.0, 0.95 * pi), pose(0.1, 0.0, -0.95 * pi)};
  expect_pose(pose_at(poses, 0.05), 0.0, pi);
}

TEST(PoseAt, IsTheNearestBesideAGapAndNothingWithinIt) {
  const std::vector<TimedPose> poses{pose(1.0, 1.0, 0.0), pose(2.0, 2.0, 0.0)};
  expect_pose(pose_at(poses, 0.95), 1.0, 0.0);
  expect_pose(pose_at(poses, 1.05), 1.0, 0.0);
  expect_pose(pose_at(poses, 1.95), 2.0, 0.0);
  expect_pose(pose_at(poses, 2.05), 2.0, 0.0);
  expect_pose(pose_at(poses, 1.5, 1.0), 1.5, 0.0);
  for (const double time : {0.85, 1.15, 1.5, 1.85, 2.15, -1e300, 1e300, std::nan("")}) EXPECT_FALSE(pose_at(poses, time)) << time;
  EXPECT_FALSE(pose_at({}, 1.0));
}

TEST(PoseAt, AGapOfJustTheLongestIsNone) {
  const std::vector<TimedPose> poses{pose(1.0, 1.0, 0.0), pose(2.0, 2.0, 0.0)};
  constexpr double kGap = 0.25;
  expect_pose(pose_at(poses, 0.75, kGap), 1.0, 0.0);
  expect_pose(pose_at(poses, 1.25, kGap), 1.0, 0.0);
  expect_pose(pose_at(poses, 1.75, kGap), 2.0, 0.0);
  expect_pose(pose_at(poses, 2.25, kGap), 2.0, 0.0);
  for (const double beyond : {std::nextafter(0.75, 0.0), std::nextafter(1.25, 2.0), std::nextafter(1.75, 0.0)}) {
    EXPECT_FALSE(pose_at(poses, beyond, kGap)) << beyond;
  }
  expect_pose(pose_at(poses, 1.5, 0.5), 1.5, 0.0);
}

TEST(PoseAt, EqualTimesAreNoDivisionByZero) {
  const std::vector<TimedPose> poses{pose(1.0, 1.0, 0.0), pose(1.0, 2.0, 0.0), pose(1.1, 3.0, 0.0)};
  expect_pose(pose_at(poses, 1.0), 1.0, 0.0);
  expect_pose(pose_at(poses, 1.05), 2.5, 0.0);
}

}  // namespace
}  // namespace fransac::io
