// SPDX-License-Identifier: Apache-2.0
#include "fransac/planes/orientation.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <limits>
#include <numbers>
#include <vector>

#include "support.hpp"

namespace fransac {
namespace {

using ::testing::ElementsAre;

constexpr double kDegree = std::numbers::pi / 180.0;

/// How a camera is held. Directions of the room are (right, up, ahead) of a level camera at the same place.
struct Pose {
  double pitch_deg = 0.0;  ///< Down is positive.
  double roll_deg = 0.0;

  [[nodiscard]] Eigen::Vector3d up() const {
    const double pitch = pitch_deg * kDegree;
    const double roll = roll_deg * kDegree;
    return {std::sin(roll) * std::cos(pitch), -std::cos(roll) * std::cos(pitch), -std::sin(pitch)};
  }
  [[nodiscard]] Eigen::Vector3d in_camera(const Eigen::Vector3d& room) const {
    const Eigen::Vector3d u = up();
    const Eigen::Vector3d ahead = (Eigen::Vector3d::UnitZ() - u * u.z()).normalized();
    return room.x() * ahead.cross(u) + room.y() * u + room.z() * ahead;
  }
};

/// A plane with a normal of the room, d_m away from the camera.
PlaneSegment segment(const Pose& pose, const Eigen::Vector3d& room_normal, double d_m, double area_m2) {
  PlaneSegment s;
  s.plane = {pose.in_camera(room_normal.normalized()), d_m};
  s.area_m2 = area_m2;
  return s;
}

PlaneSegment floor_of(const Pose& pose, double height_m, double area_m2) { return segment(pose, {0, 1, 0}, height_m, area_m2); }
PlaneSegment wall_of(const Pose& pose, double yaw_deg, double area_m2) {
  return segment(pose, {std::sin(yaw_deg * kDegree), 0.0, -std::cos(yaw_deg * kDegree)}, 2.0, area_m2);
}
PlaneSegment ceiling_of(const Pose& pose, double height_m, double area_m2) {
  return segment(pose, {0, -1, 0}, height_m, area_m2);
}

double degrees_between(const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
  return std::atan2(a.cross(b).norm(), a.dot(b)) / kDegree;
}

/// Degrees between the estimate and the truth; infinite when there is none.
double error_deg(const Pose& pose, const std::vector<PlaneSegment>& planes) {
  const auto up = estimate_up(planes);
  if (!up) return std::numeric_limits<double>::infinity();
  EXPECT_NEAR(up->norm(), 1.0, 1e-12);
  return degrees_between(*up, pose.up());
}

TEST(EstimateUp, AFloorAloneIsLevel) {
  for (int pitch = -20; pitch <= 65; pitch += 5) {
    for (const double roll : {-10.0, 0.0, 10.0}) {
      const Pose pose{static_cast<double>(pitch), roll};
      EXPECT_LT(error_deg(pose, {floor_of(pose, 1.4, 3.0)}), 1e-6) << pitch << ", " << roll;
    }
  }
}

TEST(EstimateUp, ACeilingAloneIsLevelToo) {
  for (int pitch = -35; pitch <= 0; pitch += 5) {
    const Pose pose{static_cast<double>(pitch), 0.0};
    EXPECT_LT(error_deg(pose, {ceiling_of(pose, 1.0, 3.0)}), 1e-6) << pitch;
  }
}

TEST(EstimateUp, NothingWithoutEvidence) {
  const Pose pose{10.0, 3.0};
  EXPECT_FALSE(estimate_up({}).has_value());
  // Walls of one direction say nothing of the way the camera turns about their normal.
  for (const double yaw : {-90.0, -45.0, 0.0, 30.0, 90.0}) {
    EXPECT_FALSE(estimate_up(std::vector{wall_of(pose, yaw, 4.0)}).has_value()) << yaw;
    EXPECT_FALSE(estimate_up(std::vector{wall_of(pose, yaw, 4.0), wall_of(pose, yaw + 180.0, 3.0)}).has_value()) << yaw;
  }
  // A plane seen at 75 degrees down, or a wall seen at 15 degrees up?
  const Pose down{75.0, 0.0};
  EXPECT_FALSE(estimate_up(std::vector{floor_of(down, 1.4, 3.0)}).has_value());
  // Two planes of a size that are level for cameras held 30 degrees apart.
  const Pose other{40.0, 0.0};
  EXPECT_FALSE(estimate_up(std::vector{floor_of(pose, 1.0, 3.0), floor_of(other, 1.0, 3.0)}).has_value());
}

TEST(EstimateUp, TwoWallsAreEnough) {
  for (int pitch = -20; pitch <= 30; pitch += 10) {
    const Pose pose{static_cast<double>(pitch), 4.0};
    EXPECT_LT(error_deg(pose, {wall_of(pose, 30.0, 4.0), wall_of(pose, -60.0, 2.0)}), 1e-6) << pitch;
  }
}

TEST(EstimateUp, RoomsWithTiltedThingsInThem) {
  RandomStream random = testing::test_random();
  constexpr int kRooms = 300;
  int found = 0;
  for (int i = 0; i < kRooms; ++i) {
    const Pose pose{testing::uniform(random, -10.0, 50.0), 6.0 * random.normal()};
    const double yaw = testing::uniform(random, 0.0, 90.0);
    std::vector<PlaneSegment> planes{
        floor_of(pose, 1.4, testing::uniform(random, 1.0, 6.0)), wall_of(pose, yaw, testing::uniform(random, 1.0, 6.0)),
        wall_of(pose, yaw - 90.0, testing::uniform(random, 0.0, 3.0)), floor_of(pose, 0.7, testing::uniform(random, 0.0, 2.0))};
    for (PlaneSegment& s : planes) {  // a degree or two of error
      s.plane.normal = (s.plane.normal + 0.02 * testing::uniform_point(random, -1.0, 1.0)).normalized();
    }
    for (int thing = 0; thing < 4; ++thing) {
      planes.push_back(segment(pose, testing::unit_vector(random), 1.0, testing::uniform(random, 0.0, 0.4)));
    }
    const double error = error_deg(pose, planes);
    if (error == std::numeric_limits<double>::infinity()) continue;
    ++found;
    EXPECT_LT(error, 5.0) << i << ": pitch " << pose.pitch_deg << ", roll " << pose.roll_deg;
  }
  EXPECT_GE(found, kRooms * 95 / 100);
}

TEST(EstimateUp, DoesNotDependOnTheOrderOrUnitOfAreas) {
  const Pose pose{25.0, -5.0};
  std::vector<PlaneSegment> planes{floor_of(pose, 1.4, 3.0), wall_of(pose, 20.0, 5.0), segment(pose, {0.4, 0.7, -0.6}, 1.0, 0.5),
                                   wall_of(pose, -70.0, 1.0)};
  const auto up = estimate_up(planes);
  ASSERT_TRUE(up.has_value());
  std::reverse(planes.begin(), planes.end());
  for (PlaneSegment& s : planes) s.area_m2 *= 100.0;
  EXPECT_LT((*estimate_up(planes) - *up).norm(), 1e-9);
}

TEST(EstimateUp, MeaninglessPlanesDoNotCount) {
  constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
  const Pose pose{25.0, 0.0};
  std::vector<PlaneSegment> planes{floor_of(pose, 1.4, 3.0),
                                   wall_of(pose, 0.0, kNaN),
                                   wall_of(pose, 10.0, 0.0),
                                   wall_of(pose, 20.0, -1.0),
                                   wall_of(pose, 30.0, std::numeric_limits<double>::infinity()),
                                   floor_of(pose, 1.0, 1.0)};
  planes.back().plane.normal.x() = kNaN;
  EXPECT_LT(error_deg(pose, planes), 1e-6);
  planes.erase(planes.begin());
  EXPECT_FALSE(estimate_up(planes).has_value());
}

std::vector<PlaneKind> kinds(const Eigen::Vector3d& up, std::vector<PlaneSegment> planes) {
  classify(up, planes);
  std::vector<PlaneKind> result;
  for (const PlaneSegment& s : planes) result.push_back(s.kind);
  return result;
}

TEST(Classify, ARoom) {
  const Pose pose{30.0, 5.0};
  EXPECT_THAT(
      kinds(pose.up(), {floor_of(pose, 1.4, 3.0), floor_of(pose, 0.7, 2.0), wall_of(pose, 20.0, 5.0), ceiling_of(pose, 1.1, 2.0),
                        ceiling_of(pose, 0.6, 1.0), segment(pose, {0.0, 1.0, 1.0}, 1.0, 1.0)}),
      ElementsAre(PlaneKind::floor, PlaneKind::horizontal, PlaneKind::wall, PlaneKind::ceiling, PlaneKind::horizontal,
                  PlaneKind::other));
}

TEST(Classify, TenDegreesAreTheLimit) {
  const Pose pose{20.0, 0.0};
  const auto tilted = [&](double degrees) {
    return segment(pose, {std::sin(degrees * kDegree), std::cos(degrees * kDegree), 0.0}, 1.0, 1.0);
  };
  EXPECT_THAT(kinds(pose.up(), {tilted(9.9)}), ElementsAre(PlaneKind::floor));
  EXPECT_THAT(kinds(pose.up(), {tilted(10.1)}), ElementsAre(PlaneKind::other));
  EXPECT_THAT(kinds(pose.up(), {tilted(79.9)}), ElementsAre(PlaneKind::other));
  EXPECT_THAT(kinds(pose.up(), {tilted(80.1)}), ElementsAre(PlaneKind::wall));
  EXPECT_THAT(kinds(pose.up(), {tilted(99.9)}), ElementsAre(PlaneKind::wall));
  EXPECT_THAT(kinds(pose.up(), {tilted(170.1)}), ElementsAre(PlaneKind::ceiling));
}

TEST(Classify, PiecesOfAFloorAndStepsOfAStair) {
  const Pose pose{30.0, 0.0};
  EXPECT_THAT(kinds(pose.up(), {floor_of(pose, 1.40, 3.0), floor_of(pose, 1.37, 1.0), floor_of(pose, 1.25, 1.0)}),
              ElementsAre(PlaneKind::floor, PlaneKind::floor, PlaneKind::horizontal));
}

TEST(Classify, AReflectionIsNotTheFloor) {
  const Pose pose{30.0, 0.0};
  EXPECT_THAT(kinds(pose.up(), {floor_of(pose, 1.4, 3.0), floor_of(pose, 2.5, 0.2)}),
              ElementsAre(PlaneKind::floor, PlaneKind::horizontal));
}

TEST(Classify, ATableIsNoFloorWhenSomethingIsSeenBelow) {
  const Pose pose{40.0, 0.0};
  PlaneSegment table = floor_of(pose, 0.6, 1.0);
  PlaneSegment cabinet = wall_of(pose, 0.0, 0.5);
  table.centroid = pose.in_camera({0.0, -0.6, 1.0});
  cabinet.centroid = pose.in_camera({0.0, -0.8, 1.5});
  EXPECT_THAT(kinds(pose.up(), {table, cabinet}), ElementsAre(PlaneKind::horizontal, PlaneKind::wall));
  cabinet.centroid = pose.in_camera({0.0, -0.5, 1.5});
  EXPECT_THAT(kinds(pose.up(), {table, cabinet}), ElementsAre(PlaneKind::floor, PlaneKind::wall));
}

TEST(Classify, APlaneSeenEdgeOnIsNoFloor) {
  const Pose pose{10.0, 0.0};
  EXPECT_THAT(kinds(pose.up(), {floor_of(pose, 0.04, 1.0)}), ElementsAre(PlaneKind::horizontal));
  EXPECT_THAT(kinds(pose.up(), {floor_of(pose, 0.08, 1.0)}), ElementsAre(PlaneKind::floor));
}

}  // namespace
}  // namespace fransac
