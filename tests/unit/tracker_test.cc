// SPDX-License-Identifier: Apache-2.0
#include "fransac/track/tracker.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <numbers>
#include <string>
#include <utility>

#include "fransac/core/labels.hpp"
#include "fransac/synth/synth.hpp"

namespace fransac {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector3d;
using ::testing::HasSubstr;

std::size_t at(int i) { return static_cast<std::size_t>(i); }
double radians(double degrees) { return degrees * std::numbers::pi / 180.0; }

// ---- Exact planes, made by hand.

/// A plane n . p + d = 0 of the world and the middle of the part of it that is seen.
struct WorldPlane {
  Vector3d normal;
  double d;
  Vector3d middle;
};

/// Through a point; `normal` need not be of length 1.
WorldPlane through(const Vector3d& middle, const Vector3d& normal) {
  return {normal.normalized(), -normal.normalized().dot(middle), middle};
}

const WorldPlane kFloor = through({0.0, 1.0, 2.5}, {0.0, -1.0, 0.1});
const WorldPlane kWall = through({0.2, 0.0, 3.5}, {0.2, 0.0, -1.0});
const WorldPlane kSide = through({1.5, 0.1, 2.5}, {-1.0, 0.1, -0.2});

/// Of (normal, d) of a plane whose normal is known to `angle` and that is known to `offset` at `middle`.
Eigen::Matrix4d covariance_of(const Plane& plane, const Vector3d& middle, double angle, double offset) {
  const Eigen::Matrix3d across = Eigen::Matrix3d::Identity() - plane.normal * plane.normal.transpose();
  Eigen::Matrix4d result;
  result.topLeftCorner<3, 3>() = across * angle * angle;
  result.topRightCorner<3, 1>() = -across * middle * angle * angle;
  result.bottomLeftCorner<1, 3>() = result.topRightCorner<3, 1>().transpose();
  result(3, 3) = offset * offset + middle.dot(across * middle) * angle * angle;
  return result;
}

Plane in_camera(const WorldPlane& plane, const Isometry3d& T) {
  return *make_plane(T.linear().transpose() * plane.normal, plane.d + plane.normal.dot(T.translation()));
}

/// What a camera at T would make of the planes, each seen in a strip of its own, always the same: `strips[i]`, default i.
Segmentation seen_from(const Isometry3d& T, const std::vector<WorldPlane>& planes, std::vector<int> strips = {},
                       double angle = 1e-6, double offset = 1e-6) {
  constexpr int kStrip = 10;
  constexpr int kStrips = 8;
  Segmentation result;
  result.method = Method::cells;
  result.width = kStrip * kStrips;
  result.height = 20;
  result.labels.assign(at(result.width * result.height), kLabelNoPlane);
  for (std::size_t i = 0; i < planes.size(); ++i) {
    PlaneSegment& plane = result.planes.emplace_back();
    plane.id = static_cast<int>(i) + 1;
    plane.plane = in_camera(planes[i], T);
    plane.centroid = T.inverse() * planes[i].middle;
    plane.covariance = covariance_of(plane.plane, plane.centroid, angle, offset);
    plane.area_m2 = 1.0;
    const int strip = strips.empty() ? static_cast<int>(i) : strips[i];
    for (int v = 0; v < result.height; ++v) {
      for (int u = 0; u < kStrip; ++u)
        result.labels[at(v * result.width + strip * kStrip + u)] = static_cast<std::uint8_t>(i + 1);
    }
  }
  return result;
}

/// A camera that moves by about 1 cm and 0.5 degree a frame, not evenly; at the origin in frame 0.
Isometry3d walk(int frame) {
  const double s = frame;
  Isometry3d T = Isometry3d::Identity();
  T.linear() = (Eigen::AngleAxisd(radians(0.4) * s, Vector3d(0.2, 1.0, -0.1).normalized()) *
                Eigen::AngleAxisd(radians(2.0) * std::sin(0.2 * s), Vector3d::UnitX()))
                   .toRotationMatrix();
  T.translation() << 0.008 * s, 0.02 * std::sin(0.3 * s), 0.006 * s;
  return T;
}

double angle_between(const Isometry3d& a, const Isometry3d& b) {
  return Eigen::AngleAxisd(a.linear().transpose() * b.linear()).angle();
}

std::vector<int> ids_of(const TrackedFrame& frame) {
  std::vector<int> ids;
  for (const TrackedPlane& plane : frame.planes) ids.push_back(plane.id);
  return ids;
}

/// update() that must work.
TrackedFrame followed(Tracker& tracker, const Segmentation& segmentation, const std::optional<Isometry3d>& pose = std::nullopt) {
  TrackedFrame frame;
  const Status status = tracker.update(segmentation, nullptr, pose, frame);
  EXPECT_TRUE(status.ok()) << status.error().message;
  return frame;
}

TEST(Tracker, ThreeDirectionsTellThePoseAndKeepTheirIds) {
  Tracker tracker;
  for (int i = 0; i < 40; ++i) {
    const Isometry3d T = walk(i);
    const TrackedFrame frame = followed(tracker, seen_from(T, {kFloor, kWall, kSide}));
    EXPECT_EQ(frame.pose_source, PoseSource::estimated);
    ASSERT_LT((frame.T_world_camera.translation() - T.translation()).norm(), 1e-6) << i;
    ASSERT_LT(angle_between(frame.T_world_camera, T), 1e-6) << i;
    ASSERT_EQ(ids_of(frame), (std::vector{1, 2, 3})) << i;
    for (const TrackedPlane& plane : frame.planes) {
      const Plane truth = in_camera(std::array{kFloor, kWall, kSide}[at(plane.label - 1)], T);
      EXPECT_EQ(plane.age, i + 1);
      EXPECT_LT((plane.plane.normal - truth.normal).norm(), 1e-6);
      EXPECT_NEAR(plane.plane.d, truth.d, 1e-6);
    }
  }
}

TEST(Tracker, WhatNoPlaneFixesIsGuessedAndTheRestEstimated) {
  // A lone wall says how far it is and how the camera turns about two axes; along the wall the camera is taken to move on.
  const WorldPlane wall = through({0.0, 0.0, 3.0}, {0.0, 0.0, -1.0});
  Tracker tracker;
  Isometry3d T = Isometry3d::Identity();
  for (int i = 0; i < 10; ++i) {
    T.translation() = Vector3d(0.0, 0.0, 0.012 * i);
    const TrackedFrame frame = followed(tracker, seen_from(T, {wall}));
    EXPECT_NEAR(frame.T_world_camera.translation().z(), 0.012 * i, 1e-6);
    EXPECT_LT(frame.T_world_camera.translation().head<2>().norm(), 1e-6);
  }
}

TEST(Tracker, ErrorsOfAPlaneThatIsSeenAgainAverageOut) {
  TrackOptions options;
  options.drift_deg = 0.0;
  options.drift_m = 0.0;
  Tracker tracker(options);
  const Isometry3d T = walk(3);
  const Segmentation segmentation = seen_from(T, {kFloor}, {}, 2e-3, 3e-3);
  const Eigen::Matrix4d once = segmentation.planes[0].covariance;
  for (int i = 1; i <= 20; ++i) {
    const TrackedFrame frame = followed(tracker, segmentation, T);
    const TrackedPlane& plane = frame.planes.at(0);
    const Eigen::Matrix4d difference = plane.covariance * i - once;
    EXPECT_LT(difference.norm(), 1e-6 * once.norm()) << i;
    EXPECT_LT((plane.covariance.leftCols<3>() * plane.plane.normal).norm(), 1e-9 * once.norm()) << "rank 3";
    EXPECT_EQ(plane.age, i);
  }
}

TEST(Tracker, WithDriftTheCovarianceSettles) {
  Tracker tracker;
  const Segmentation segmentation = seen_from(Isometry3d::Identity(), {kFloor}, {}, 2e-3, 3e-3);
  double before = segmentation.planes[0].covariance.trace();
  for (int i = 0; i < 300; ++i) {
    const double now = followed(tracker, segmentation, Isometry3d::Identity()).planes.at(0).covariance.trace();
    EXPECT_LE(now, before * (1.0 + 1e-9));
    before = now;
  }
  EXPECT_GT(before, 1e-3 * segmentation.planes[0].covariance.trace());  // old frames are forgotten in time
}

TEST(Tracker, DriftIsWhatIsLeftInTheEnd) {
  // Of a value that drifts by q a frame and is measured to r, q much smaller, the variance settles at q r.
  TrackOptions options;
  options.drift_deg = 0.0;
  options.drift_m = 1e-4;
  Tracker tracker(options);
  const WorldPlane wall = through({0.0, 0.0, 2.0}, {0.0, 0.0, -1.0});
  const Segmentation segmentation = seen_from(Isometry3d::Identity(), {wall}, {}, 1e-9, 2e-3);
  double variance = 0.0;
  for (int i = 0; i < 300; ++i) variance = followed(tracker, segmentation, Isometry3d::Identity()).planes.at(0).covariance(3, 3);
  EXPECT_NEAR(variance, 1e-4 * 2e-3, 0.1 * 1e-4 * 2e-3);
}

TEST(Tracker, APlaneMayBeOffByItsOwnError) {
  // 4 degrees are four times what an exact pose leaves open; the frame says that it knows the normal to 2.
  const WorldPlane wall = through({0.0, 0.0, 2.0}, {0.0, 0.0, -1.0});
  const WorldPlane turned = through({0.0, 0.0, 2.0}, {std::sin(radians(4.0)), 0.0, -std::cos(radians(4.0))});
  for (const double known_deg : {2.0, 0.1}) {
    Tracker tracker;
    followed(tracker, seen_from(Isometry3d::Identity(), {wall}, {0}), Isometry3d::Identity());
    const Segmentation second = seen_from(Isometry3d::Identity(), {turned}, {1}, radians(known_deg), 1e-3);
    EXPECT_EQ(ids_of(followed(tracker, second, Isometry3d::Identity())), std::vector{known_deg > 1.0 ? 1 : 2}) << known_deg;
  }
}

TEST(Tracker, AThingThatMovedHardlyPullsTheCamera) {
  // A door beside three walls, 3 cm nearer in the second frame. Least squares would put the camera half the way.
  const WorldPlane door = through({-0.6, 0.0, 3.2}, {0.2, 0.0, -1.0});
  const WorldPlane moved = through(door.middle + 0.03 * door.normal, door.normal);
  Tracker tracker;
  const std::vector<int> strips{0, 1, 2, 3};
  for (int i = 0; i < 3; ++i) {
    followed(tracker, seen_from(Isometry3d::Identity(), {kFloor, kWall, kSide, door}, strips, 1e-3, 1e-3));
  }
  const TrackedFrame frame =
      followed(tracker, seen_from(Isometry3d::Identity(), {kFloor, kWall, kSide, moved}, strips, 1e-3, 1e-3));
  EXPECT_EQ(ids_of(frame), (std::vector{1, 2, 3, 4}));
  EXPECT_LT(frame.T_world_camera.translation().norm(), 0.006);
}

TEST(Tracker, WhatContradictsManyFramesCountsForLess) {
  TrackOptions options;
  options.drift_deg = 0.0;
  options.drift_m = 0.0;
  Tracker tracker(options);
  const WorldPlane wall = through({0.0, 0.0, 2.0}, {0.0, 0.0, -1.0});
  const WorldPlane off = through({0.0, 0.0, 2.025}, {0.0, 0.0, -1.0});
  const Isometry3d T = Isometry3d::Identity();
  for (int i = 0; i < 20; ++i) followed(tracker, seen_from(T, {wall}, {}, 1e-3, 3e-3), T);
  const TrackedFrame frame = followed(tracker, seen_from(T, {off}, {}, 1e-3, 3e-3), T);
  EXPECT_EQ(ids_of(frame), std::vector{1});
  // A mean of 21 frames would move by 25 mm / 21.
  EXPECT_GT(frame.planes.at(0).plane.d, 2.0);
  EXPECT_LT(frame.planes.at(0).plane.d, 2.0 + 0.6 * 0.025 / 21);
}

TEST(Tracker, ExactPlanesWithoutDriftStayFinite) {
  TrackOptions options;
  options.drift_deg = 0.0;
  options.drift_m = 0.0;
  Tracker tracker(options);
  for (int i = 0; i < 5; ++i) {
    const TrackedFrame frame = followed(tracker, seen_from(walk(i), {kFloor, kWall, kSide}, {}, 0.0, 0.0));
    for (const TrackedPlane& plane : frame.planes) EXPECT_TRUE(plane.covariance.allFinite() && plane.plane.normal.allFinite());
    EXPECT_EQ(ids_of(frame), (std::vector{1, 2, 3}));
  }
}

TEST(Tracker, APlaneWhoseTurnIsHardlyKnownDoesNotSwing) {
  // Seen to a tenth of a millimetre, but 5 mm nearer when another part of it is seen, 1 cm beside: the plane through both parts
  // would be turned by 27 degrees. Neither frame saw such a plane.
  const WorldPlane first = through({0.0, 0.0, 2.0}, {0.0, 0.0, -1.0});
  const WorldPlane second = through({0.01, 0.0, 1.995}, {0.0, 0.0, -1.0});
  Tracker tracker;
  const Isometry3d T = Isometry3d::Identity();
  followed(tracker, seen_from(T, {first}, {}, 0.2, 1e-4), T);
  const TrackedPlane plane = followed(tracker, seen_from(T, {second}, {}, 0.2, 1e-4), T).planes.at(0);
  EXPECT_EQ(plane.id, 1);
  EXPECT_GT(plane.plane.normal.dot(first.normal), 1.0 - 1e-9);
  EXPECT_GT(plane.plane.d, 1.995);
  EXPECT_LT(plane.plane.d, 2.0);
}

TEST(Tracker, AnIdComesBackAfterAShortAbsenceOnly) {
  for (const int absent : {1, 5, 6}) {
    TrackOptions options;
    options.longest_gap = 5;
    Tracker tracker(options);
    int i = 0;
    for (; i < 4; ++i) EXPECT_EQ(ids_of(followed(tracker, seen_from(walk(i), {kFloor, kWall, kSide}))), (std::vector{1, 2, 3}));
    for (; i < 4 + absent; ++i) EXPECT_EQ(ids_of(followed(tracker, seen_from(walk(i), {kFloor, kSide}))), (std::vector{1, 3}));
    const TrackedFrame frame = followed(tracker, seen_from(walk(i), {kFloor, kWall, kSide}));
    EXPECT_EQ(ids_of(frame), (std::vector{1, absent <= 5 ? 2 : 4, 3})) << absent << " frames";
    EXPECT_EQ(frame.planes.at(1).age, absent <= 5 ? 5 : 1);
  }
}

/// However briefly it was seen, an object is remembered for the longest gap.
TEST(Tracker, AnObjectComesBackAfterAShortAbsenceOnly) {
  const Segmentation planes = seen_from(Isometry3d::Identity(), {kFloor, kWall, kSide});
  Obstacles nothing;
  nothing.width = planes.width;
  nothing.height = planes.height;
  nothing.labels.assign(planes.labels.size(), 0);
  Obstacles thing = nothing;
  std::fill_n(thing.labels.begin(), 40, std::uint16_t{1});
  Obstacle& obstacle = thing.obstacles.emplace_back();
  obstacle.id = 1;
  obstacle.pixels = 40;
  obstacle.box.centre = {2.0, 0.0, 0.1};
  obstacle.box.size = {0.2, 0.2, 0.2};
  for (const int seen : {1, 3}) {
    for (const int absent : {1, 5, 6}) {
      SCOPED_TRACE(::testing::Message() << seen << " frames, then absent for " << absent);
      TrackOptions options;
      options.longest_gap = 5;
      Tracker tracker(options);
      TrackedFrame frame;
      for (int i = 0; i < seen; ++i) ASSERT_TRUE(tracker.update(planes, &thing, std::nullopt, frame));
      ASSERT_EQ(frame.objects.size(), 1U);
      EXPECT_EQ(frame.objects[0].age, seen);
      for (int i = 0; i < absent; ++i) ASSERT_TRUE(tracker.update(planes, &nothing, std::nullopt, frame));
      EXPECT_TRUE(frame.objects.empty());
      ASSERT_TRUE(tracker.update(planes, &thing, std::nullopt, frame));
      ASSERT_EQ(frame.objects.size(), 1U);
      EXPECT_EQ(frame.objects[0].id, absent <= 5 ? 1 : 2);
      EXPECT_EQ(frame.objects[0].age, absent <= 5 ? seen + 1 : 1);
    }
  }
}

TEST(Tracker, ParallelPlanesAStepApartStayTwo) {
  const WorldPlane low = through({-0.4, 1.0, 2.0}, {0.0, -1.0, 0.0});
  const WorldPlane high = through({0.4, 0.97, 2.0}, {0.0, -1.0, 0.0});
  Tracker tracker;
  for (int i = 0; i < 30; ++i) {
    EXPECT_EQ(ids_of(followed(tracker, seen_from(walk(i), {low, high, kWall, kSide}))), (std::vector{1, 2, 3, 4})) << i;
  }
}

TEST(Tracker, TheOrderOfASegmentationDoesNotMatter) {
  Tracker tracker;
  followed(tracker, seen_from(walk(0), {kFloor, kWall, kSide}, {0, 1, 2}));
  const TrackedFrame frame = followed(tracker, seen_from(walk(1), {kSide, kFloor, kWall}, {2, 0, 1}));
  EXPECT_EQ(ids_of(frame), (std::vector{3, 1, 2}));
  for (std::size_t i = 0; i < 3; ++i) EXPECT_EQ(frame.planes[i].label, static_cast<int>(i) + 1);
}

TEST(Tracker, ThePlaneThatTheCameraGoesThroughStaysOne) {
  // Its measured normal, which points to the camera, is the opposite one from then on.
  const WorldPlane shelf = through({0.0, 0.05, 1.5}, {0.0, -1.0, 0.0});
  Tracker tracker;
  for (int i = 0; i <= 10; ++i) {
    Isometry3d T = Isometry3d::Identity();
    T.translation() = Vector3d(0.0, 0.01 * i, 0.0);
    const TrackedFrame frame = followed(tracker, seen_from(T, {shelf, kWall, kSide}));
    EXPECT_EQ(ids_of(frame), (std::vector{1, 2, 3})) << i;
    EXPECT_LT((frame.T_world_camera.translation() - T.translation()).norm(), 1e-6) << i;
    const Plane& plane = frame.planes.at(0).plane;
    const Plane truth = in_camera(shelf, T);
    EXPECT_GE(plane.d, 0.0);
    EXPECT_NEAR(plane.d, truth.d, 1e-6);
    EXPECT_NEAR(std::abs(plane.normal.dot(truth.normal)), 1.0, 1e-9);
    if (truth.d > 1e-5) {
      EXPECT_GT(plane.normal.dot(truth.normal), 0.0);
    }
  }
}

TEST(Tracker, GivenPosesAreTaken) {
  Isometry3d start = Isometry3d::Identity();
  start.translate(Vector3d(10.0, -20.0, 3.0)).rotate(Eigen::AngleAxisd(2.0, Vector3d::UnitZ()));
  Tracker tracker;
  for (int i = 0; i < 10; ++i) {
    // Jumps that no guess would follow.
    Isometry3d T = start * walk(i);
    T.translate(Vector3d(i % 2 == 0 ? 0.5 : -0.5, 0.0, 0.0));
    std::vector<WorldPlane> planes;
    for (const WorldPlane& plane : {kFloor, kWall, kSide}) {
      planes.push_back(through(start * plane.middle, start.linear() * plane.normal));
    }
    const TrackedFrame frame = followed(tracker, seen_from(T, planes), T);
    EXPECT_EQ(frame.pose_source, PoseSource::given);
    EXPECT_LT((frame.T_world_camera.matrix() - T.matrix()).norm(), 1e-12);
    EXPECT_EQ(ids_of(frame), (std::vector{1, 2, 3})) << i;
  }
}

TEST(Tracker, WithoutPlanesTheCameraMovesOn) {
  Tracker tracker;
  TrackedFrame frame = followed(tracker, seen_from(Isometry3d::Identity(), {}));
  EXPECT_TRUE(frame.planes.empty());
  EXPECT_TRUE(frame.T_world_camera.isApprox(Isometry3d::Identity()));
  frame = followed(tracker, seen_from(Isometry3d::Identity(), {}));
  EXPECT_EQ(frame.pose_source, PoseSource::guessed);

  tracker.reset();
  Isometry3d T = Isometry3d::Identity();
  for (int i = 0; i < 3; ++i) {
    T.translation() = Vector3d(0.01 * i, 0.0, 0.015 * i);
    frame = followed(tracker, seen_from(T, {kFloor, kWall, kSide}));
    EXPECT_EQ(frame.pose_source, PoseSource::estimated);
  }
  frame = followed(tracker, seen_from(T, {}));
  EXPECT_EQ(frame.pose_source, PoseSource::guessed);
  EXPECT_LT((frame.T_world_camera.translation() - Vector3d(0.03, 0.0, 0.045)).norm(), 1e-6);
}

TEST(Tracker, ResetForgetsAll) {
  Tracker tracker;
  for (int i = 0; i < 3; ++i) followed(tracker, seen_from(walk(i), {kFloor, kWall}));
  tracker.reset();
  const TrackedFrame frame = followed(tracker, seen_from(walk(7), {kWall, kSide}));
  EXPECT_EQ(ids_of(frame), (std::vector{1, 2}));
  EXPECT_TRUE(frame.T_world_camera.isApprox(Isometry3d::Identity()));
}

TEST(Tracker, RefusesOptionsOutOfRangeByName) {
  std::size_t options = 0;
  TrackOptions counted;
  for_each_track_option(counted, [&](const OptionInfo& /*info*/, auto& /*value*/) { ++options; });
  ASSERT_GE(options, 7U);
  for (std::size_t wrong = 0; wrong < options; ++wrong) {
    TrackOptions bad;
    std::string name;
    std::size_t i = 0;
    for_each_track_option(bad, [&](const OptionInfo& info, auto& value) {
      if (i++ != wrong) return;
      name = info.name;
      value = -1;
    });
    for (const bool nan : {false, true}) {
      if (nan) bad.gate_sigmas = std::numeric_limits<double>::quiet_NaN();
      const Status status = validate(bad);
      ASSERT_FALSE(status.ok());
      EXPECT_EQ(status.error().code, ErrorCode::invalid_argument);
      if (!nan) {
        EXPECT_THAT(status.error().message, HasSubstr(name));
      }
    }
    TrackedFrame frame;
    EXPECT_FALSE(Tracker(bad).update(seen_from(walk(0), {kFloor}), nullptr, std::nullopt, frame).ok());
  }
  EXPECT_TRUE(validate(TrackOptions{}).ok());
}

TEST(Tracker, RefusesWhatItCannotFollow) {
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  const auto code_of = [](const Segmentation& segmentation, const std::optional<Isometry3d>& pose = std::nullopt) {
    TrackedFrame frame;
    const Status status = Tracker().update(segmentation, nullptr, pose, frame);
    EXPECT_FALSE(status.ok());
    EXPECT_TRUE(frame.planes.empty());
    return status.ok() ? ErrorCode::io : status.error().code;
  };
  const Segmentation good = seen_from(walk(0), {kFloor});
  Segmentation bad = good;
  bad.method = Method::fransac;
  EXPECT_EQ(code_of(bad), ErrorCode::unsupported);
  bad = good;
  bad.planes[0].plane.d = kNan;
  EXPECT_EQ(code_of(bad), ErrorCode::invalid_argument);
  bad = good;
  bad.planes[0].covariance(1, 1) = std::numeric_limits<double>::infinity();
  EXPECT_EQ(code_of(bad), ErrorCode::invalid_argument);
  bad = good;
  bad.labels.clear();
  EXPECT_EQ(code_of(bad), ErrorCode::invalid_argument);
  Isometry3d T = Isometry3d::Identity();
  T.translation().x() = kNan;
  EXPECT_EQ(code_of(good, T), ErrorCode::invalid_argument);
  T = Isometry3d::Identity();
  T.linear() *= 2.0;
  EXPECT_EQ(code_of(good, T), ErrorCode::invalid_argument);
  bad = good;
  bad.planes[0].plane.normal *= 2.0;
  EXPECT_EQ(code_of(bad), ErrorCode::invalid_argument);
  bad = good;
  bad.planes[0].area_m2 = -1.0;
  EXPECT_EQ(code_of(bad), ErrorCode::invalid_argument);
}

TEST(Tracker, RefusesObstaclesThatItCannotFollow) {
  const Segmentation good = seen_from(walk(0), {kFloor});
  Obstacles obstacles;
  obstacles.obstacles.resize(1);
  const auto follows = [&] {
    TrackedFrame frame;
    return Tracker().update(good, &obstacles, std::nullopt, frame).ok();
  };
  EXPECT_FALSE(follows()) << "its id is 0";
  obstacles.obstacles[0].id = 1;
  EXPECT_TRUE(follows());
  obstacles.obstacles[0].box.size.y() = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(follows());
}

TEST(Tracker, StartsAnewAfterNumbersThatAreTooLarge) {
  const Segmentation frame_seen = seen_from(walk(0), {kFloor});
  Tracker tracker;
  TrackedFrame frame;
  ASSERT_TRUE(tracker.update(frame_seen, nullptr, std::nullopt, frame).ok());
  const int id = frame.planes.at(0).id;
  Isometry3d far = Isometry3d::Identity();
  far.translation().setConstant(1e200);
  const Status status = tracker.update(frame_seen, nullptr, far, frame);
  ASSERT_FALSE(status.ok());
  EXPECT_EQ(status.error().code, ErrorCode::invalid_argument);
  EXPECT_TRUE(frame.planes.empty());
  ASSERT_TRUE(tracker.update(frame_seen, nullptr, std::nullopt, frame).ok());
  EXPECT_GT(frame.planes.at(0).id, id);
  EXPECT_TRUE(frame.T_world_camera.matrix().isIdentity());
}

// ---- Rendered walks.

struct Score {
  int plane_frames = 0;
  int switches = 0;
  int pairs = 0;
  double measured = 0.0;  ///< Squared angles, summed.
  double smoothed = 0.0;
};

/// The label that covers each true plane by half, both together being 1.
std::map<int, int> matches(const std::vector<std::uint8_t>& truth, const std::vector<std::uint8_t>& labels) {
  std::map<std::pair<int, int>, double> both;
  std::map<int, double> of_truth;
  std::map<int, double> of_label;
  for (std::size_t p = 0; p < truth.size(); ++p) {
    if (truth[p] == kLabelNoDepth) continue;
    ++of_truth[truth[p]];
    ++of_label[labels[p]];
    ++both[{truth[p], labels[p]}];
  }
  std::map<int, int> result;
  for (const auto& [pair, pixels] : both) {
    if (pair.first == kLabelNoPlane || pair.second == kLabelNoPlane || pair.second == kLabelNoDepth) continue;
    if (pixels >= 0.5 * (of_truth[pair.first] + of_label[pair.second] - pixels)) result[pair.first] = pair.second;
  }
  return result;
}

double squared_angle(const Vector3d& a, const Vector3d& b) { return std::pow(std::atan2(a.cross(b).norm(), a.dot(b)), 2); }

/// Adds up ids that change from frame to frame, and by how much planes turn that do not move.
void follow_walk(const char* scene, Score& score) {
  synth::SynthOptions options;
  options.scene = scene;
  options.motion = synth::Motion::walk;
  options.camera = synth::resized(options.camera, 320, 240);
  Tracker tracker;
  Workspace workspace;
  Segmentation segmentation;
  std::map<int, int> id_of_truth;
  std::map<int, std::pair<Vector3d, Vector3d>> before;
  for (options.frame = 0; options.frame < 12; ++options.frame) {
    const auto rendered = synth::render(options);
    ASSERT_TRUE(rendered.ok());
    const DepthView view =
        DepthView::from_uint16(rendered->depth.data(), options.camera.width, options.camera.height, options.camera.depth_scale);
    ASSERT_TRUE(segment(view, rendered->camera, {}, workspace, segmentation).ok());
    const TrackedFrame frame = followed(tracker, segmentation);
    for (const auto& [truth, label] : matches(rendered->labels, segmentation.labels)) {
      const int id = frame.planes[at(label - 1)].id;
      ++score.plane_frames;
      const auto known = id_of_truth.find(truth);
      if (known != id_of_truth.end() && known->second != id) ++score.switches;
      id_of_truth[truth] = id;
    }
    std::map<int, std::pair<Vector3d, Vector3d>> now;
    const Eigen::Matrix3d R = rendered->T_world_camera.linear();
    for (const TrackedPlane& plane : frame.planes) {
      now[plane.id] = {R * segmentation.planes[at(plane.label - 1)].plane.normal, R * plane.plane.normal};
      const auto known = before.find(plane.id);
      if (known == before.end()) continue;
      ++score.pairs;
      score.measured += squared_angle(known->second.first, now[plane.id].first);
      score.smoothed += squared_angle(known->second.second, now[plane.id].second);
    }
    before = std::move(now);
  }
}

TEST(Tracker, KeepsIdsAndCalmsPlanesOnRenderedWalks) {
  Score score;
  // All that have planes: one scene alone is too little for a share of 1 %.
  for (const char* scene : {"empty_room", "desk", "stairs", "corridor", "kerb", "office", "boxes", "hall"}) {
    follow_walk(scene, score);
  }
  ASSERT_GT(score.plane_frames, 500);
  ASSERT_GT(score.pairs, 450);
  EXPECT_LE(score.switches, 0.01 * score.plane_frames);
  EXPECT_LE(std::sqrt(score.smoothed), 0.5 * std::sqrt(score.measured));
}

}  // namespace
}  // namespace fransac
