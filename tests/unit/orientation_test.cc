// SPDX-License-Identifier: Apache-2.0
#include "fransac/planes/orientation.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numbers>
#include <optional>
#include <vector>

#include "support.hpp"

namespace fransac {
namespace {

using ::testing::ElementsAre;

constexpr double kDegree = std::numbers::pi / 180.0;

double squared(double x) { return x * x; }

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
  EXPECT_NEAR(up->direction.norm(), 1.0, 1e-12);
  EXPECT_GT(up->sigma_rad, 0.0);
  return degrees_between(up->direction, pose.up());
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
    const Pose pose{static_cast<double>(pitch), 0.0};
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
  EXPECT_LT((estimate_up(planes)->direction - up->direction).norm(), 1e-9);
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

/// One sigma of an angle of the normal, in degrees, about both directions across it.
PlaneSegment with_error(PlaneSegment s, double degrees) {
  const Eigen::Vector3d& n = s.plane.normal;
  s.covariance.topLeftCorner<3, 3>() = 0.5 * squared(degrees * kDegree) * (Eigen::Matrix3d::Identity() - n * n.transpose());
  return s;
}

TEST(EstimateUp, TellsItsError) {
  const Pose pose{25.0, 0.0};
  const auto sigma_deg = [](const std::vector<PlaneSegment>& planes) { return estimate_up(planes)->sigma_rad / kDegree; };
  const double alone = sigma_deg({floor_of(pose, 1.4, 3.0)});
  EXPECT_NEAR(alone, 1.0, 1e-6);  // what things are built to
  EXPECT_NEAR(sigma_deg({with_error(floor_of(pose, 1.4, 3.0), 2.0)}), std::sqrt(5.0), 1e-6);
  EXPECT_NEAR(sigma_deg({floor_of(pose, 1.4, 3.0), floor_of(pose, 0.7, 3.0)}), alone / std::sqrt(2.0), 1e-6);
  // The sine of the walls' angle is what holds up about the direction between them.
  EXPECT_NEAR(sigma_deg({wall_of(pose, 45.0, 3.0), wall_of(pose, -45.0, 3.0)}), alone, 1e-6);
  EXPECT_FALSE(estimate_up(std::vector{with_error(floor_of(pose, 1.4, 3.0), 5.0)}).has_value());
}

TEST(EstimateUp, IsNotTurnedByPlanesThatAreLargeButUncertainOrInclined) {
  // As in a hall: a chessboard that leans, and a wall far away whose normal is off by its error.
  const auto plane = [](const Eigen::Vector3d& normal, double d, double area_m2, double confidence, double error_deg) {
    PlaneSegment s;
    s.plane = {normal.normalized(), d};
    s.area_m2 = area_m2;
    s.confidence = confidence;
    return with_error(s, error_deg);
  };
  const Eigen::Vector3d floor(-0.0008, -0.9909, -0.1345);
  const std::vector<PlaneSegment> planes{
      plane({0.5969, -0.0749, -0.7988}, 0.99, 1.03, 0.97, 0.15), plane(floor, 0.59, 0.76, 0.96, 0.15),
      plane({-0.6155, 0.0976, -0.7821}, 0.74, 0.50, 0.93, 0.22), plane({0.7735, 0.0692, -0.6300}, 0.86, 0.13, 0.97, 0.99),
      plane({0.5158, -0.0253, -0.8563}, 7.90, 5.41, 0.89, 5.38)};
  const auto up = estimate_up(planes);
  ASSERT_TRUE(up.has_value());
  EXPECT_LT(degrees_between(up->direction, floor), 2.0);
}

TEST(EstimateUp, OfAnImageThatIsTurnedByAQuarter) {
  for (const double pitch : {5.0, 20.0, 40.0}) {
    const Pose pose{pitch, 3.0};
    std::vector<PlaneSegment> planes{floor_of(pose, 1.4, 3.0), wall_of(pose, 20.0, 0.3)};
    for (const double turn : {-1.0, 1.0}) {
      const Eigen::AngleAxisd turned(turn * std::numbers::pi / 2.0, Eigen::Vector3d::UnitZ());
      std::vector<PlaneSegment> of_portrait = planes;
      for (PlaneSegment& s : of_portrait) s.plane.normal = turned * s.plane.normal;
      const auto up = estimate_up(of_portrait, true);
      ASSERT_TRUE(up.has_value()) << pitch;
      EXPECT_LT(degrees_between(up->direction, turned * pose.up()), 1e-6);
      classify(up->direction, of_portrait);
      EXPECT_EQ(of_portrait[0].kind, PlaneKind::floor);
    }
    const auto upright = estimate_up(planes, true);  // the image was turned back
    ASSERT_TRUE(upright.has_value());
    EXPECT_LT(degrees_between(upright->direction, pose.up()), 1e-6);
  }
}

/// However weak the evidence, the mirror image of a room has the mirror image of its up: a camera turned to one side is as likely
/// as one turned to the other.
TEST(EstimateUp, OfAMirrorImage) {
  const Eigen::AngleAxisd turn(0.5 * std::numbers::pi, Eigen::Vector3d::UnitZ());
  const auto mirrored = [](const Eigen::Vector3d& v) { return Eigen::Vector3d(-v.x(), v.y(), v.z()); };
  int told = 0;
  int open = 0;
  for (int pitch = -60; pitch <= 60; pitch += 5) {
    for (const double wall : {0.0, 0.3, 1.0, 2.0, 4.0, 8.0}) {
      SCOPED_TRACE(::testing::Message() << pitch << " degrees, wall of " << wall);
      const Pose pose{static_cast<double>(pitch), 4.0};
      std::vector<PlaneSegment> planes{floor_of(pose, 1.4, 1.0), wall_of(pose, 25.0, wall)};
      for (PlaneSegment& s : planes) s.plane.normal = turn * s.plane.normal;
      const auto up = estimate_up(planes, true);
      for (PlaneSegment& s : planes) s.plane.normal = mirrored(s.plane.normal);
      const auto up_in_mirror = estimate_up(planes, true);
      ASSERT_EQ(up.has_value(), up_in_mirror.has_value());
      ++(up ? told : open);
      if (!up) continue;
      EXPECT_LT(degrees_between(up->direction, mirrored(up_in_mirror->direction)), 1e-6);
    }
  }
  EXPECT_GT(told, 20);
  EXPECT_GT(open, 5);
}

TEST(Up, IsOfUnitLengthHoweverLongItIsGiven) {
  const Camera camera{64, 48, 50.0, 50.0, 31.5, 23.5};
  const std::vector<std::uint16_t> wall(64 * 48, 2000);
  const DepthView depth = DepthView::from_uint16(wall.data(), 64, 48, 1000.0);
  for (const double length : {5e-324, 1e-200, 1.0, 1e200, 1.7e308}) {
    SegmentOptions options;
    options.up = Eigen::Vector3d(length, -length, 0.0);
    const auto found = segment(depth, camera, options);
    ASSERT_TRUE(found) << found.error().message;
    EXPECT_NEAR((*found->up - Eigen::Vector3d(std::sqrt(0.5), -std::sqrt(0.5), 0.0)).norm(), 0.0, 1e-12) << length;
  }
}

TEST(EstimateUp, LittleConfidenceCountsLittle) {
  const Pose pose{10.0, 0.0};
  const Pose other{40.0, 0.0};
  std::vector<PlaneSegment> planes{floor_of(pose, 1.4, 1.0), floor_of(other, 1.4, 1.0)};
  EXPECT_FALSE(estimate_up(planes).has_value());
  planes[1].confidence = 0.2;
  EXPECT_LT(error_deg(pose, planes), 1e-6);
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

TEST(Classify, FromWhereTheSensorIs) {
  // In coordinates whose origin lies on the floor: a plane through the origin faces either way, one above it seems a ceiling.
  const Eigen::Vector3d up = Eigen::Vector3d::UnitZ();
  const auto level = [&](double height_m) {
    PlaneSegment s;
    s.plane = *make_plane(up, -height_m);
    s.area_m2 = 2.0;
    return s;
  };
  std::vector<PlaneSegment> planes{level(0.01), level(0.7), level(2.5)};
  classify(up, planes, {0.0, 0.0, 1.5});
  EXPECT_EQ(planes[0].kind, PlaneKind::floor);
  EXPECT_EQ(planes[1].kind, PlaneKind::horizontal);
  EXPECT_EQ(planes[2].kind, PlaneKind::ceiling);
}

/// A cloud of pieces of planes, as laser scanners see them.
class Building {
 public:
  explicit Building(const Eigen::Vector3d& origin) : origin_(origin), far_(origin.norm() > 1000.0) {}

  /// `low` and `high` are opposite corners; 3 mm of noise along `axis`, across which it lies.
  void add(const Eigen::Vector3d& low, const Eigen::Vector3d& high, int axis, int points = 12000) {
    for (int i = 0; i < points; ++i) {
      Eigen::Vector3d p;
      for (int k = 0; k < 3; ++k) p[k] = low[k] < high[k] ? testing::uniform(random_, low[k], high[k]) : low[k];
      p[axis] += 0.003 * random_.normal();
      points_.push_back(far_ ? p : p + origin_);
    }
  }
  void add_floor() { add({0, 0, 0}, {3, 3, 0}, 2, 30000); }
  void add_table() { add({2, 2, 0.7}, {2.8, 2.8, 0.7}, 2, 6000); }

  /// The kinds of the planes, by height above the building's floor in decimetres.
  [[nodiscard]] std::map<int, PlaneKind> kinds(const std::optional<Eigen::Vector3d>& sensor = {}, int max_planes = 0) const {
    SegmentOptions options;
    options.max_planes = max_planes;
    options.up = Eigen::Vector3d(0, 0, 2);
    if (sensor) options.sensor_position = *sensor + origin_;
    const PointCloud cloud = testing::cloud_of(points_, far_ ? origin_ : Eigen::Vector3d(Eigen::Vector3d::Zero()));
    const auto found = segment(cloud, options);
    EXPECT_TRUE(found.ok());
    std::map<int, PlaneKind> kinds;
    for (const PlaneSegment& s : found->planes) {
      if (s.kind == PlaneKind::wall) continue;
      kinds[static_cast<int>(std::lround(10.0 * (s.centroid - origin_).z()))] = s.kind;
    }
    return kinds;
  }

 private:
  Eigen::Vector3d origin_;
  bool far_;  ///< Too far for floats.
  RandomStream random_ = testing::test_random();
  std::vector<Eigen::Vector3d> points_;
};

// base_link on the floor, a map's origin above or below it, UTM.
const std::vector<Eigen::Vector3d> kOrigins{{0, 0, 0},    {0, 0, 0.3}, {-7, 2, 20},
                                            {1, 1, -0.3}, {5, 5, -40}, {456789, 5432100, 312}};

using Kinds = std::map<int, PlaneKind>;

TEST(ClassifyClouds, AFloorIsAFloorWhereverTheOriginIs) {
  for (const Eigen::Vector3d& origin : kOrigins) {
    SCOPED_TRACE(origin.transpose());
    Building room(origin);
    room.add_floor();
    EXPECT_EQ(room.kinds(), (Kinds{{0, PlaneKind::floor}}));
    room.add_table();
    EXPECT_EQ(room.kinds(), (Kinds{{0, PlaneKind::floor}, {7, PlaneKind::horizontal}}));
    EXPECT_EQ(room.kinds(Eigen::Vector3d(1, 1, 1.5)), (Kinds{{0, PlaneKind::floor}, {7, PlaneKind::horizontal}}));
    room.add({0, 0, 0}, {3, 0, 2.4}, 1);
    room.add({0, 0, 2.4}, {3, 3, 2.4}, 2, 20000);
    const Kinds all{{0, PlaneKind::floor}, {7, PlaneKind::horizontal}, {24, PlaneKind::ceiling}};
    EXPECT_EQ(room.kinds(), all);
    EXPECT_EQ(room.kinds(Eigen::Vector3d(1, 1, 1.5)), all);
  }
}

TEST(ClassifyClouds, WhatLiesAboveAndBelowTells) {
  for (const Eigen::Vector3d& origin : kOrigins) {
    SCOPED_TRACE(origin.transpose());
    Building from_below(origin);  // one plane is asked for: a ceiling with what hangs from it, and walls
    from_below.add({0, 0, 2.4}, {3, 3, 2.4}, 2, 30000);
    from_below.add({0, 0, 0.2}, {3, 0, 2.4}, 1, 9000);
    EXPECT_EQ(from_below.kinds({}, 1), (Kinds{{24, PlaneKind::ceiling}}));
    Building table(origin);  // one plane is asked for: a table, on whose floor things are
    table.add({0, 0, 0.7}, {2, 2, 0.7}, 2, 20000);
    table.add({0, 0, 0}, {2, 2, 0}, 2, 8000);
    EXPECT_EQ(table.kinds({}, 1), (Kinds{{7, PlaneKind::horizontal}}));
  }
}

TEST(ClassifyClouds, ACloudCarriesItsSensorsPosition) {
  // A lone level plane, seen from below.
  RandomStream random = testing::test_random();
  std::vector<Eigen::Vector3d> points;
  for (int i = 0; i < 5000; ++i) points.emplace_back(testing::uniform(random, 0, 2), testing::uniform(random, 0, 2), 5.0);
  PointCloud cloud = testing::cloud_of(points);
  SegmentOptions options;
  options.up = Eigen::Vector3d::UnitZ();
  EXPECT_EQ(segment(cloud, options)->planes[0].kind, PlaneKind::floor);
  EXPECT_FALSE(segment(cloud, options)->sensor_position.has_value());
  cloud.sensor_position = Eigen::Vector3d(0, 0, 4.0);
  EXPECT_EQ(segment(cloud, options)->planes[0].kind, PlaneKind::ceiling);
  EXPECT_EQ(segment(cloud, options)->sensor_position, cloud.sensor_position);
  SegmentOptions named = options;
  named.sensor_position = Eigen::Vector3d(0, 0, 6.0);
  EXPECT_EQ(segment(cloud, named)->planes[0].kind, PlaneKind::floor);
}

TEST(Classify, APlaneSeenEdgeOnIsNoFloor) {
  const Pose pose{10.0, 0.0};
  EXPECT_THAT(kinds(pose.up(), {floor_of(pose, 0.04, 1.0)}), ElementsAre(PlaneKind::horizontal));
  EXPECT_THAT(kinds(pose.up(), {floor_of(pose, 0.08, 1.0)}), ElementsAre(PlaneKind::floor));
}

}  // namespace
}  // namespace fransac
