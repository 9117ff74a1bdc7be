// SPDX-License-Identifier: Apache-2.0
// Obstacles in exact depth images of solids on a floor. Most segmentations are the true ones, so that what fails is not theirs.
#include "fransac/obstacles/obstacles.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <string>
#include <vector>

#include "cells.hpp"
#include "support.hpp"
#include "synth/builder.hpp"
#include "synth/scenes.hpp"
#include "synth/sensors.hpp"

namespace fransac {
namespace {

using Eigen::AlignedBox2d;
using Eigen::Vector2d;
using Eigen::Vector3d;
using synth::detail::Builder;
using synth::detail::standing;
using testing::kinect;
constexpr double kPi = std::numbers::pi;

std::size_t at(int i) { return static_cast<std::size_t>(i); }

/// What an exact camera sees.
struct Frame {
  Camera camera;
  std::vector<float> metres;
  std::vector<std::uint16_t> units;
  std::vector<std::uint16_t> objects;  ///< The builder's, 0 for fixtures.
  Segmentation planes;                 ///< The true one.

  [[nodiscard]] DepthView view() const { return DepthView::from_float(metres.data(), camera.width, camera.height); }
  [[nodiscard]] DepthView view_of_units() const {
    return DepthView::from_uint16(units.data(), camera.width, camera.height, camera.depth_scale);
  }
  [[nodiscard]] Vector3d point(std::size_t pixel) const {
    const int width = camera.width;
    const Vector3d ray = testing::ray(camera, static_cast<int>(pixel) % width, static_cast<int>(pixel) / width);
    return static_cast<double>(metres[pixel]) * ray;
  }
};

/// The planes of at least 200 pixels, the largest first; the floor is at z = 0.
void add_planes(const synth::detail::Scene& scene, const synth::detail::Raster& raster, const Vector3d& up, double camera_height,
                Frame& frame) {
  constexpr std::size_t kFewest = 200;
  std::map<int, std::size_t> pixels;
  for (const int face : raster.face) {
    if (face >= 0) ++pixels[scene.plane_of_face[at(face)]];
  }
  std::vector<std::pair<std::size_t, int>> order;
  for (const auto& [plane, count] : pixels) {
    if (plane >= 0 && count >= kFewest) order.emplace_back(count, plane);
  }
  std::sort(order.rbegin(), order.rend());
  std::map<int, std::uint8_t> label_of;
  Segmentation& s = frame.planes;
  s.method = Method::cells;
  s.width = frame.camera.width;
  s.height = frame.camera.height;
  s.noise.quadratic_per_m = 1.425e-3;  // a Kinect's, though there is none
  s.up = up;
  s.up_source = UpSource::given;
  s.sensor_position = Vector3d::Zero();
  for (const auto& [count, index] : order) {
    PlaneSegment plane;
    plane.id = static_cast<int>(s.planes.size()) + 1;
    plane.plane = *make_plane(scene.planes[at(index)].normal, scene.planes[at(index)].d);
    plane.inliers = count;
    plane.area_m2 = static_cast<double>(count);
    const double along_up = plane.plane.normal.dot(up);
    const bool is_floor = along_up > 0.999 && std::abs(plane.plane.d - camera_height) < 0.05;  // as orientations have it
    plane.kind = is_floor                    ? PlaneKind::floor
                 : along_up > 0.999          ? PlaneKind::horizontal
                 : std::abs(along_up) < 1e-3 ? PlaneKind::wall
                                             : PlaneKind::other;
    label_of[index] = static_cast<std::uint8_t>(plane.id);
    s.planes.push_back(plane);
  }
  for (std::size_t i = 0; i < raster.face.size(); ++i) {
    if (raster.face[i] < 0) continue;
    const auto found = label_of.find(scene.plane_of_face[at(raster.face[i])]);
    if (found == label_of.end()) continue;
    PlaneSegment& plane = s.planes[found->second - 1U];
    plane.centroid += frame.point(i) / static_cast<double>(plane.inliers);
  }
  s.labels.assign(raster.face.size(), kLabelNoDepth);
  for (std::size_t i = 0; i < raster.face.size(); ++i) {
    if (raster.face[i] < 0) continue;
    const auto found = label_of.find(scene.plane_of_face[at(raster.face[i])]);
    s.labels[i] = found == label_of.end() ? kLabelNoPlane : found->second;
  }
}

Frame see(Builder& builder, const Vector3d& from, const Vector3d& to, const Camera& camera = kinect()) {
  synth::detail::Scene scene = builder.finish();
  const Eigen::Isometry3d camera_in_world = synth::detail::looking(from, to);
  scene.move_to(camera_in_world.inverse());
  const synth::detail::Raster raster = synth::detail::rasterise(scene, camera);
  Frame frame;
  frame.camera = camera;
  frame.metres.assign(raster.depth_m.begin(), raster.depth_m.end());
  for (const double z : raster.depth_m) frame.units.push_back(static_cast<std::uint16_t>(std::lround(z * camera.depth_scale)));
  for (const int primitive : raster.primitive) {
    const auto holds = [&](const auto& object) { return object.first <= primitive && primitive < object.last; };
    const auto object = std::find_if(scene.objects.begin(), scene.objects.end(), holds);
    frame.objects.push_back(object == scene.objects.end() ? std::uint16_t{0} : static_cast<std::uint16_t>(object->id));
  }
  add_planes(scene, raster, camera_in_world.linear().transpose() * Vector3d::UnitZ(), from.z(), frame);
  return frame;
}

/// A metre and a half above the floor, a metre and a half before what it looks at.
const Vector3d kEye(0.0, 0.0, 1.5);
const Vector3d kLookAt(0.0, 1.5, 0.0);

Builder floor_of(double width = 8.0) {
  Builder b;
  b.fixture();
  b.level({Vector2d(-0.5 * width, -0.5 * width), Vector2d(0.5 * width, 0.5 * width)}, 0.0, {});
  return b;
}

/// A point of the world in the ground frame of a camera at kEye that looks along the world's y.
Vector3d on_ground(const Vector3d& world) { return {world.y(), -world.x(), world.z()}; }

/// A cell's width at what stands about `distance` away; of a slanted surface it shows more, here at most twice that.
double cell_m(double distance) { return 4.0 * distance / 525.0; }

Obstacles find(const Frame& frame, const ObstacleOptions& options = {}) {
  Result<Obstacles> found = find_obstacles(frame.view(), frame.camera, frame.planes, options);
  if (found) return *std::move(found);
  ADD_FAILURE() << found.error().message;
  return {};
}

/// What holds of every answer, whatever was measured.
void expect_numbers(const Obstacles& found, const DepthView& depth) {
  ASSERT_EQ(found.labels.size(), depth.size());
  std::vector<std::uint64_t> pixels(found.obstacles.size() + 1, 0);
  for (const std::uint16_t label : found.labels) {
    ASSERT_LT(label, pixels.size());
    ++pixels[label];
  }
  for (std::size_t i = 0; i < found.obstacles.size(); ++i) {
    const Obstacle& o = found.obstacles[i];
    SCOPED_TRACE(::testing::Message() << "obstacle " << i + 1);
    EXPECT_EQ(o.id, static_cast<int>(i) + 1);
    EXPECT_EQ(o.pixels, pixels[i + 1]);
    EXPECT_TRUE(o.centroid.allFinite() && o.box.centre.allFinite() && o.box.size.allFinite());
    EXPECT_TRUE(std::isfinite(o.min_height_m) && std::isfinite(o.max_height_m) && std::isfinite(o.nearest_m));
  }
}

/// And of those of clean pictures.
void expect_sane(const Obstacles& found, const DepthView& depth) {
  expect_numbers(found, depth);
  for (std::size_t i = 0; i < found.obstacles.size(); ++i) {
    const Obstacle& o = found.obstacles[i];
    SCOPED_TRACE(::testing::Message() << "obstacle " << i + 1);
    EXPECT_GT(o.pixels, 0U);
    EXPECT_GE(o.box.size.x(), o.box.size.y());
    EXPECT_GE(o.box.size.minCoeff(), 0.0);
    EXPECT_GT(o.box.yaw_rad, -0.5 * kPi);
    EXPECT_LE(o.box.yaw_rad, 0.5 * kPi);
    EXPECT_LE(o.min_height_m, o.max_height_m);
    EXPECT_NEAR(o.box.size.z(), o.max_height_m - o.min_height_m, 1e-9);
    EXPECT_GT(o.nearest_m, 0.0);
    EXPECT_GE(o.nearest_m, i > 0 ? found.obstacles[i - 1].nearest_m : 0.0);
    if (o.kind == ObstacleKind::drop) {
      EXPECT_LT(o.max_height_m, 0.0);
      EXPECT_FALSE(o.contact);
    }
  }
}

/// What is lower may be noise: four deviations at 2.5 m.
constexpr double kTold_m = 0.03;

/// Which share of an object's pixels, those that noise does not hide, has which label.
double share(const Frame& frame, const Obstacles& found, std::uint16_t object, int label) {
  std::size_t all = 0;
  std::size_t right = 0;
  for (std::size_t i = 0; i < frame.objects.size(); ++i) {
    if (frame.objects[i] != object || found.support_plane.signed_distance(frame.point(i)) < kTold_m) continue;
    ++all;
    if (found.labels[i] == label) ++right;
  }
  return static_cast<double>(right) / static_cast<double>(all);
}

// ---- what stands ----

TEST(Obstacles, ABoxOnTheFloor) {
  const double yaw = 0.5;
  const Vector3d size(0.4, 0.2, 0.3);
  Builder b = floor_of();
  b.object();
  b.box(standing(0.1, 1.4, 0.0, yaw), size, {});
  const Frame frame = see(b, kEye, kLookAt);
  const Obstacles found = find(frame);
  expect_sane(found, frame.view());
  ASSERT_EQ(found.obstacles.size(), 1U);
  EXPECT_EQ(found.support, std::vector<int>{1});
  const Obstacle& box = found.obstacles.front();
  EXPECT_EQ(box.kind, ObstacleKind::object);
  EXPECT_TRUE(box.contact);
  EXPECT_EQ(box.planes.size(), 3U);  // both sides and the top: one object

  const double cell = cell_m(2.0);
  EXPECT_NEAR(box.max_height_m, size.z(), cell);
  EXPECT_LE(box.min_height_m, kTold_m);
  EXPECT_GT(box.min_height_m, 0.0);
  EXPECT_NEAR(box.box.size.x(), size.x(), 2.0 * cell);
  EXPECT_NEAR(box.box.size.y(), size.y(), 2.0 * cell);
  EXPECT_LE((box.box.centre - on_ground({0.1, 1.4, 0.15})).norm(), cell);
  // The length points along (cos, sin) of the yaw in the world: the ground's x is the world's y.
  EXPECT_NEAR(std::cos(2.0 * (box.box.yaw_rad - (yaw - 0.5 * kPi))), 1.0, 0.01);  // within 4 degrees, modulo half a turn

  double nearest = 1e9;
  Vector3d sum = Vector3d::Zero();
  std::size_t pixels = 0;
  for (std::size_t i = 0; i < frame.objects.size(); ++i) {
    if (frame.objects[i] != 1) continue;
    nearest = std::min(nearest, frame.point(i).norm());
    sum += frame.point(i);
    ++pixels;
  }
  EXPECT_NEAR(box.nearest_m, nearest, cell);
  EXPECT_LE((box.centroid - sum / static_cast<double>(pixels)).norm(), 0.01);
  EXPECT_GE(share(frame, found, 1, 1), 0.998);  // but for pixels alone in a cell
  EXPECT_EQ(share(frame, found, 0, 0), 1.0);
}

TEST(Obstacles, GroundFrame) {
  Builder b = floor_of();
  const Obstacles found = find(see(b, kEye, kLookAt));
  EXPECT_TRUE(found.obstacles.empty());
  const GroundFrame& ground = found.ground;
  EXPECT_NEAR(ground.from_camera(Vector3d::Zero()).z(), kEye.z(), 1e-6);
  EXPECT_LE(ground.from_camera(Vector3d::Zero()).head<2>().norm(), 1e-6);
  EXPECT_LE((ground.from_camera(Vector3d(0.0, 0.0, kLookAt.norm() * std::sqrt(2.0))) - Vector3d(1.5, 0.0, 0.0)).norm(), 1e-6);
  EXPECT_LE((ground.to_camera(ground.from_camera({1.0, 2.0, 3.0})) - Vector3d(1.0, 2.0, 3.0)).norm(), 1e-12);
  EXPECT_NEAR(ground.axes.determinant(), 1.0, 1e-12);
  EXPECT_LT(ground.from_camera(Vector3d::UnitX()).y(), 0.0);  // the image's right is on the right: y is to the left
}

TEST(Obstacles, TheGroundFrameOfACameraThatLooksStraightDown) {
  const GroundFrame ground = ground_frame(*make_plane(-Vector3d::UnitZ(), 2.0));
  EXPECT_NEAR(ground.axes.determinant(), 1.0, 1e-12);
  EXPECT_LE((ground.from_camera({0.0, -1.0, 2.0}) - Vector3d(1.0, 0.0, 0.0)).norm(), 1e-12);  // the image's upper edge is ahead
}

TEST(Obstacles, TouchingBoxesOfDifferentHeightAreTwo) {
  Builder b = floor_of();
  b.object();
  b.box(standing(0.0, 1.5, 0.0, 0.0), {0.4, 0.2, 0.4}, {});
  b.object();
  b.box(standing(0.05, 1.3, 0.0, 0.0), {0.4, 0.2, 0.15}, {});  // before it, against its front
  const Frame frame = see(b, kEye, kLookAt);
  const Obstacles found = find(frame);
  expect_sane(found, frame.view());
  ASSERT_EQ(found.obstacles.size(), 2U);
  EXPECT_NEAR(found.obstacles[0].nearest_m, found.obstacles[1].nearest_m, 0.3);
  const int low = found.obstacles[0].max_height_m < 0.3 ? 1 : 2;
  EXPECT_GE(share(frame, found, 1, 3 - low), 0.99);
  EXPECT_GE(share(frame, found, 2, low), 0.96);  // rows at the crease are the higher one's
  EXPECT_NEAR(found.obstacles[at(low - 1)].max_height_m, 0.15, cell_m(2.0));
  EXPECT_NEAR(found.obstacles[at(2 - low)].max_height_m, 0.4, cell_m(2.0));
}

TEST(Obstacles, ABoxOnABoxIsTwo) {
  Builder b = floor_of();
  b.object();
  b.box(standing(0.0, 1.4, 0.0, 0.2), {0.5, 0.4, 0.2}, {});
  b.object();
  b.box(standing(0.0, 1.42, 0.2, -0.3), {0.2, 0.15, 0.2}, {});
  const Frame frame = see(b, kEye, kLookAt);
  const Obstacles found = find(frame);
  ASSERT_EQ(found.obstacles.size(), 2U);
  const int upper = found.obstacles[0].min_height_m > 0.1 ? 1 : 2;
  EXPECT_GE(share(frame, found, 2, upper), 0.95);  // rows at the crease are the lower one's
  EXPECT_GE(share(frame, found, 1, 3 - upper), 0.98);
  EXPECT_FALSE(found.obstacles[at(upper - 1)].contact);
  EXPECT_TRUE(found.obstacles[at(2 - upper)].contact);
}

TEST(Obstacles, AHangingPlateIsAPlaneWithoutContact) {
  Builder b = floor_of();
  b.object();
  b.upright({-0.3, 2.0}, {0.3, 2.0}, 0.3, 0.7, {});
  const Frame frame = see(b, kEye, kLookAt);
  const Obstacles found = find(frame);
  expect_sane(found, frame.view());
  ASSERT_EQ(found.obstacles.size(), 1U);
  const Obstacle& plate = found.obstacles.front();
  EXPECT_EQ(plate.kind, ObstacleKind::plane);
  EXPECT_EQ(plate.planes.size(), 1U);
  EXPECT_FALSE(plate.contact);
  const double cell = cell_m(2.3);
  EXPECT_NEAR(plate.min_height_m, 0.3, cell);
  EXPECT_NEAR(plate.max_height_m, 0.7, cell);
  EXPECT_NEAR(plate.box.size.x(), 0.6, 1.5 * cell);
  EXPECT_LE(plate.box.size.y(), 0.5 * cell);
  EXPECT_NEAR(std::abs(plate.box.yaw_rad), 0.5 * kPi, 0.02);  // across the view
  EXPECT_LE((plate.box.centre - on_ground({0.0, 2.0, 0.5})).norm(), cell);
}

TEST(Obstacles, AWallIsAPlane) {
  Builder b = floor_of(20.0);
  b.fixture();
  b.upright({-3.0, 2.5}, {3.0, 2.5}, 0.0, 2.5, {});
  const Frame frame = see(b, kEye, kLookAt);
  const Obstacles found = find(frame);
  ASSERT_EQ(found.obstacles.size(), 1U);
  const Obstacle& wall = found.obstacles.front();
  EXPECT_EQ(wall.kind, ObstacleKind::plane);
  EXPECT_TRUE(wall.contact);
  ASSERT_EQ(wall.planes.size(), 1U);
  EXPECT_EQ(frame.planes.planes[at(wall.planes.front() - 1)].kind, PlaneKind::wall);
  EXPECT_NEAR(wall.box.centre.x(), 2.5, 0.01);
  EXPECT_LE(wall.box.size.y(), 0.01);
}

TEST(Obstacles, TheTopOfALowBoxIsNoFloor) {
  // Planes within 5 cm of the floor are floors, too: carpets, which carry, but also what one stumbles over.
  for (const double height : {0.004, 0.03, 0.045}) {
    Builder b = floor_of();
    b.object();
    b.box(standing(0.0, 1.4, 0.0, 0.2), {0.4, 0.3, height}, {});
    const Frame frame = see(b, kEye, kLookAt);
    ASSERT_GE(frame.planes.planes.size(), 2U);
    ASSERT_EQ(frame.planes.planes[1].kind, PlaneKind::floor);
    const Obstacles found = find(frame);
    if (height < ObstacleOptions{}.least_height_m) {
      EXPECT_EQ(found.support, (std::vector<int>{1, 2}));
      EXPECT_TRUE(found.obstacles.empty());
      continue;
    }
    EXPECT_EQ(found.support, std::vector<int>{1});
    ASSERT_EQ(found.obstacles.size(), 1U);
    EXPECT_NEAR(found.obstacles.front().max_height_m, height, 0.005);
    EXPECT_TRUE(found.obstacles.front().contact);
  }
}

TEST(Obstacles, NearestFirst) {
  Builder b = floor_of();
  for (const double y : {2.1, 1.2, 1.65}) {
    b.object();
    b.box(standing(1.5 - y, y, 0.0, 0.3), {0.15, 0.15, 0.15}, {});
  }
  const Frame frame = see(b, kEye, kLookAt);
  const Obstacles found = find(frame);
  expect_sane(found, frame.view());
  ASSERT_EQ(found.obstacles.size(), 3U);
  EXPECT_GE(share(frame, found, 2, 1), 0.99);
  EXPECT_GE(share(frame, found, 3, 2), 0.99);
  EXPECT_GE(share(frame, found, 1, 3), 0.99);
}

// ---- what falls away ----

/// A floor with a rectangular hole, deep enough for its bottom to be seen.
Builder floor_with_a_hole(const AlignedBox2d& hole, double depth) {
  Builder b;
  b.fixture();
  const Vector2d low = hole.min();
  const Vector2d high = hole.max();
  b.level({Vector2d(-4, -4), Vector2d(4, low.y())}, 0.0, {});
  b.level({Vector2d(-4, high.y()), Vector2d(4, 4)}, 0.0, {});
  b.level({Vector2d(-4, low.y()), Vector2d(low.x(), high.y())}, 0.0, {});
  b.level({Vector2d(high.x(), low.y()), Vector2d(4, high.y())}, 0.0, {});
  b.fixture();
  b.level(hole, -depth, {});
  b.upright({low.x(), high.y()}, {high.x(), high.y()}, -depth, 0.0, {});
  b.upright({low.x(), low.y()}, {high.x(), low.y()}, -depth, 0.0, {});
  b.upright({low.x(), low.y()}, {low.x(), high.y()}, -depth, 0.0, {});
  b.upright({high.x(), low.y()}, {high.x(), high.y()}, -depth, 0.0, {});
  return b;
}

TEST(Obstacles, AHoleIsADropWithItsOutlineOnTheFloor) {
  const AlignedBox2d hole(Vector2d(-0.2, 1.3), Vector2d(0.3, 1.8));
  Builder b = floor_with_a_hole(hole, 0.25);
  const Frame frame = see(b, kEye, kLookAt);
  const Obstacles found = find(frame);
  expect_sane(found, frame.view());
  ASSERT_EQ(found.obstacles.size(), 1U);
  const Obstacle& drop = found.obstacles.front();
  EXPECT_EQ(drop.kind, ObstacleKind::drop);
  EXPECT_TRUE(drop.planes.empty());
  EXPECT_NEAR(drop.min_height_m, -0.25, 0.01);

  const std::vector<std::vector<Outline>> outlines = drop_outlines(found, frame.camera, {.min_pixels = 64});
  ASSERT_EQ(outlines.size(), 1U);
  ASSERT_EQ(outlines.front().size(), 1U);
  AlignedBox2d seen;
  for (const Vector3d& point : outlines.front().front().outer.points) {
    const Vector3d p = found.ground.from_camera(point);
    EXPECT_NEAR(p.z(), 0.0, 1e-6);
    seen.extend(Vector2d(-p.y(), p.x()));  // in the world
  }
  // On the far side, what is not yet 3 cm down is no drop: the ray that meets the far wall there goes through the floor at
  // h / (h + 3 cm) of its way.
  const double far = hole.max().y() * kEye.z() / (kEye.z() + ObstacleOptions{}.least_drop_m);
  const double pixel = 2.0 * 2.4 / 525.0;  // one and a half, slanted
  EXPECT_NEAR(seen.min().y(), hole.min().y(), pixel);
  EXPECT_NEAR(seen.max().y(), far, pixel);
  EXPECT_NEAR(seen.min().x(), hole.min().x(), 0.02);  // 3 cm down at the sides, too
  EXPECT_NEAR(seen.max().x(), hole.max().x(), 0.02);
}

TEST(Obstacles, AStepDownIsADrop) {
  Builder b;
  b.fixture();
  b.level({Vector2d(-3, -1), Vector2d(3, 1.6)}, 0.0, {});
  b.fixture();
  b.level({Vector2d(-3, 1), Vector2d(3, 5)}, -0.2, {});
  const Frame frame = see(b, kEye, kLookAt);
  const Obstacles found = find(frame);
  expect_sane(found, frame.view());
  ASSERT_EQ(found.obstacles.size(), 1U);
  EXPECT_EQ(found.obstacles.front().kind, ObstacleKind::drop);
  EXPECT_NEAR(found.obstacles.front().min_height_m, -0.2, 0.005);
  EXPECT_NEAR(found.obstacles.front().max_height_m, -0.2, 0.005);
  // Where it is, not where it is seen through the floor: behind the edge's shadow on the lower level.
  EXPECT_NEAR(found.obstacles.front().box.centre.x() - 0.5 * found.obstacles.front().box.size.y(), 1.6 * 1.7 / 1.5, 0.05);
}

TEST(Obstacles, ShallowDropsAreNone) {
  const AlignedBox2d hole(Vector2d(-0.2, 1.3), Vector2d(0.3, 1.8));
  Builder b = floor_with_a_hole(hole, 0.025);
  const Frame frame = see(b, kEye, kLookAt);
  EXPECT_TRUE(find(frame).obstacles.empty());
  EXPECT_EQ(find(frame, {.least_drop_m = 0.02}).obstacles.size(), 1U);
}

/// A wall of fronto-parallel ground 1 m away, with pixels at other depths.
struct Ground {
  explicit Ground(const Camera& camera) : image(camera) {
    const Plane plane = *make_plane(-Vector3d::UnitZ(), 1.0);
    image.draw(plane);
    planes.width = camera.width;
    planes.height = camera.height;
    planes.planes.push_back({.id = 1, .plane = plane});
    planes.labels.assign(image.metres.size(), 1);
  }
  void set(int u, int v, float z) {
    image.at(u, v) = z;
    planes.labels[at(v * image.camera.width + u)] = z > 0.0F ? kLabelNoPlane : kLabelNoDepth;
  }
  void set(int left, int top, int right, int bottom, float z) {
    for (int v = top; v < bottom; ++v) {
      for (int u = left; u < right; ++u) set(u, v, z);
    }
  }
  [[nodiscard]] Obstacles find(const ObstacleOptions& options = {.support = {SupportKind::plane, 1}, .min_size_m = 0.0}) const {
    Result<Obstacles> found = find_obstacles(image.view(), image.camera, planes, options);
    if (found) return *std::move(found);
    ADD_FAILURE() << found.error().message;
    return {};
  }

  testing::FloatImage image;
  Segmentation planes;
};

/// Flying pixels at an edge make two cells of 4 x 4 pixels; three are a drop.
TEST(Obstacles, ADropHasThreeCells) {
  for (const int cells : {1, 2, 3}) {
    SCOPED_TRACE(cells);
    Ground along(kinect(160, 120));
    along.set(80, 60, 80 + 4 * cells, 64, 2.0F);
    EXPECT_EQ(along.find().obstacles.size(), cells < 3 ? 0U : 1U);
    Ground down(kinect(160, 120));
    down.set(80, 60, 84, 60 + 4 * cells, 2.0F);
    EXPECT_EQ(down.find().obstacles.size(), cells < 3 ? 0U : 1U);
  }
}

/// A line of one cell without measurements, as the projector's shadow leaves, does not part a drop; two do.
TEST(Obstacles, ADropGoesOnBehindABlindCell) {
  for (const int blind : {1, 2}) {
    SCOPED_TRACE(blind);
    Ground ground(kinect(160, 120));
    ground.set(40, 40, 80, 80, 2.0F);
    ground.set(80, 40, 80 + 4 * blind, 80, 0.0F);
    ground.set(80 + 4 * blind, 40, 120, 80, 2.0F);
    EXPECT_EQ(ground.find().obstacles.size(), static_cast<std::size_t>(blind));
  }
}

// ---- the support ----

/// A table with a box on it, on a floor.
Frame table_with_a_box() {
  Builder b = floor_of();
  b.fixture();
  b.box(standing(0.0, 1.4, 0.65, 0.0), {0.9, 0.6, 0.05}, {});
  b.object();
  b.box(standing(0.0, 1.4, 0.7, 0.4), {0.2, 0.15, 0.1}, {});
  return see(b, {0.0, 0.0, 1.5}, {0.0, 1.5, 0.5});
}

int label_of(const Frame& frame, PlaneKind kind) {
  for (const PlaneSegment& plane : frame.planes.planes) {
    if (plane.kind == kind) return plane.id;
  }
  return 0;
}

TEST(Obstacles, TheFloorCarriesUnlessATableIsChosen) {
  const Frame frame = table_with_a_box();
  for (const SupportKind kind : {SupportKind::automatic, SupportKind::floor}) {
    const Obstacles found = find(frame, {.support = {kind, 0}});
    expect_sane(found, frame.view());
    EXPECT_EQ(found.support, std::vector<int>{label_of(frame, PlaneKind::floor)});
    ASSERT_EQ(found.obstacles.size(), 2U);  // the table and the box
    for (const Obstacle& obstacle : found.obstacles) EXPECT_FALSE(obstacle.contact);
  }
}

TEST(Obstacles, ATableCarriesWhenItIsChosen) {
  const Frame frame = table_with_a_box();
  const int table = label_of(frame, PlaneKind::horizontal);
  for (const SupportChoice& choice : {SupportChoice{SupportKind::table, 0}, SupportChoice{SupportKind::plane, table}}) {
    const Obstacles found = find(frame, {.support = choice});
    expect_sane(found, frame.view());
    EXPECT_EQ(found.support, std::vector<int>{table});
    ASSERT_FALSE(found.obstacles.empty());
    const auto is_object = [](const Obstacle& o) { return o.kind != ObstacleKind::drop; };
    const auto box = std::find_if(found.obstacles.begin(), found.obstacles.end(), is_object);
    ASSERT_NE(box, found.obstacles.end());
    EXPECT_EQ(std::count_if(found.obstacles.begin(), found.obstacles.end(), is_object), 1);
    EXPECT_TRUE(box->contact);
    EXPECT_NEAR(box->max_height_m, 0.1, cell_m(1.6));
    EXPECT_GE(share(frame, found, 1, box->id), 0.99);
    // What lies beyond the table's edges is a drop.
    EXPECT_GE(found.obstacles.size(), 2U);
  }
}

/// Without a support all that is measured, but for specks, is an obstacle that touches nothing.
void expect_all_obstacles(const Frame& frame, const Obstacles& found, SupportReason reason) {
  EXPECT_EQ(enum_name(found.support_reason), enum_name(reason));
  EXPECT_TRUE(found.support.empty());
  ASSERT_FALSE(found.obstacles.empty());
  for (const Obstacle& obstacle : found.obstacles) {
    EXPECT_NE(obstacle.kind, ObstacleKind::drop);
    EXPECT_FALSE(obstacle.contact);
    EXPECT_GT(obstacle.min_height_m, 0.0);
  }
  const auto measured = std::count_if(frame.metres.begin(), frame.metres.end(), [](float z) { return z > 0.0F; });
  const auto free =
      std::count(found.labels.begin(), found.labels.end(), 0) - std::count(frame.metres.begin(), frame.metres.end(), 0.0F);
  EXPECT_LT(static_cast<double>(free), 0.01 * static_cast<double>(measured));
}

TEST(Obstacles, WithoutASupportAllIsAnObstacle) {
  Frame frame = table_with_a_box();
  expect_all_obstacles(frame, find(frame, {.support = {SupportKind::plane, 100}}), SupportReason::no_such_plane);
  Frame walls = frame;
  for (PlaneSegment& plane : walls.planes.planes) plane.kind = PlaneKind::wall;
  expect_all_obstacles(walls, find(walls), SupportReason::no_level_plane);
  expect_all_obstacles(walls, find(walls, {.support = {SupportKind::table, 0}}), SupportReason::no_level_plane);
  expect_all_obstacles(walls, find(walls, {.support = {SupportKind::floor, 0}}), SupportReason::no_floor);
  frame.planes.up.reset();
  EXPECT_EQ(find(frame).support_reason, SupportReason::floor);  // kinds that are known by other means count
  for (PlaneSegment& plane : frame.planes.planes) plane.kind = PlaneKind::unknown;
  for (const SupportKind kind : {SupportKind::automatic, SupportKind::floor, SupportKind::table}) {
    expect_all_obstacles(frame, find(frame, {.support = {kind, 0}}), SupportReason::up_unknown);
  }
  frame.planes.planes.clear();
  std::fill(frame.planes.labels.begin(), frame.planes.labels.end(), kLabelNoPlane);
  expect_all_obstacles(frame, find(frame), SupportReason::no_planes);
}

TEST(Obstacles, AWallThatFillsTheViewIsAnObstacle) {
  Frame frame;
  frame.camera = kinect();
  frame.metres.assign(at(frame.camera.width * frame.camera.height), 0.5F);
  SegmentOptions level;
  level.up = -Vector3d::UnitY();
  const auto planes = segment(frame.view(), frame.camera, level);
  ASSERT_TRUE(planes.ok());
  frame.planes = *planes;
  const Obstacles found = find(frame);
  expect_all_obstacles(frame, found, SupportReason::no_level_plane);
  ASSERT_EQ(found.obstacles.size(), 1U);
  EXPECT_EQ(found.obstacles[0].kind, ObstacleKind::plane);
  EXPECT_NEAR(found.obstacles[0].nearest_m, 0.5, 1e-3);
  EXPECT_NEAR(found.ground.axes.col(2).y(), -1.0, 1e-12);
}

TEST(Obstacles, ASupportIsLevelToWithinItsError) {
  Frame frame = table_with_a_box();
  Segmentation& s = frame.planes;
  const int floor = label_of(frame, PlaneKind::floor);
  const auto reason = [&](double degrees, double sigma_degrees) {
    const Vector3d normal = s.planes[at(floor - 1)].plane.normal;
    s.up = Eigen::AngleAxisd(degrees * kPi / 180.0, normal.unitOrthogonal()) * normal;
    s.up_source = UpSource::estimated;
    s.up_sigma_rad = sigma_degrees * kPi / 180.0;
    return find(frame, {.support = {SupportKind::floor, 0}});
  };
  EXPECT_EQ(reason(4.9, 0.1).support_doubt, SupportDoubt::none);
  EXPECT_EQ(reason(5.1, 0.1).support_doubt, SupportDoubt::tilted);
  EXPECT_EQ(reason(5.3, 0.1).support_reason, SupportReason::no_floor);
  EXPECT_EQ(reason(5.3, 1.0).support_reason, SupportReason::floor);
  EXPECT_EQ(reason(7.1, 1.0).support_reason, SupportReason::no_floor);
  EXPECT_EQ(reason(2.0, 3.1).support_doubt, SupportDoubt::up_uncertain);
  EXPECT_EQ(reason(2.0, 2.9).support_doubt, SupportDoubt::none);
  EXPECT_EQ(reason(10.1, 20.0).support_reason, SupportReason::no_floor);
  s.up_source = UpSource::given;
  EXPECT_EQ(find(frame, {.support = {SupportKind::plane, floor}}).support_doubt, SupportDoubt::tilted);
  s.up.reset();
  for (PlaneSegment& plane : s.planes) plane.kind = PlaneKind::unknown;
  EXPECT_EQ(find(frame, {.support = {SupportKind::plane, floor}}).support_doubt, SupportDoubt::up_unknown);
}

/// Planes that are seen from 1.5 m above the lowest floor, with an image of no pixels.
struct Levels {
  Levels() {
    s.up = -Vector3d::UnitY();
    s.up_source = UpSource::given;
    s.sensor_position = Vector3d::Zero();
    s.width = kinect().width;
    s.height = kinect().height;
    s.labels.assign(at(s.width * s.height), kLabelNoDepth);
  }
  void add(PlaneKind kind, double height_m, double area_m2, double confidence = 1.0) {
    const double below = 1.5 - height_m;
    const Plane plane = below > 0.0 ? Plane{-Vector3d::UnitY(), below} : Plane{Vector3d::UnitY(), -below};
    s.planes.push_back({.id = static_cast<int>(s.planes.size()) + 1,
                        .plane = plane,
                        .centroid = {0.0, below, 2.0},
                        .kind = kind,
                        .confidence = confidence,
                        .area_m2 = area_m2});
  }
  [[nodiscard]] Obstacles choose(SupportKind kind) const {
    const std::vector<float> nothing(s.labels.size(), 0.0F);
    return *find_obstacles(DepthView::from_float(nothing.data(), s.width, s.height), kinect(), s, {.support = {kind, 0}});
  }
  Segmentation s;
};

TEST(Obstacles, ATableIsWhatThingsStandOn) {
  Levels on_a_table;  // the table fills the view and is the lowest; boxes and books stand on it
  on_a_table.add(PlaneKind::horizontal, 0.3, 0.1);
  on_a_table.add(PlaneKind::floor, 0.0, 0.6);
  on_a_table.add(PlaneKind::horizontal, 0.03, 0.4);
  EXPECT_EQ(on_a_table.choose(SupportKind::table).support, std::vector<int>{2});
  EXPECT_EQ(on_a_table.choose(SupportKind::automatic).support_reason, SupportReason::floor);

  Levels room;  // the larger shelf is above the table, and a speck is the lowest at a table's height
  room.add(PlaneKind::floor, 0.0, 3.0);
  room.add(PlaneKind::horizontal, 1.2, 1.0);
  room.add(PlaneKind::horizontal, 0.7, 0.8);
  room.add(PlaneKind::horizontal, 0.72, 2.0, 0.3);  // little confidence
  room.add(PlaneKind::horizontal, 0.45, 0.2);
  room.add(PlaneKind::horizontal, 0.2, 2.5);  // a step
  room.add(PlaneKind::horizontal, 2.0, 3.0);  // seen from below
  EXPECT_EQ(room.choose(SupportKind::table).support, std::vector<int>{3});
  EXPECT_EQ(room.choose(SupportKind::table).support_reason, SupportReason::surface);
  EXPECT_EQ(room.choose(SupportKind::automatic).support, std::vector<int>{1});

  Levels no_floor;  // something is seen below the table
  no_floor.add(PlaneKind::horizontal, 0.9, 0.1);
  no_floor.add(PlaneKind::horizontal, 0.7, 0.8);
  EXPECT_EQ(no_floor.choose(SupportKind::table).support, std::vector<int>{2});
  EXPECT_EQ(no_floor.choose(SupportKind::table).support_doubt, SupportDoubt::none);
  EXPECT_EQ(no_floor.choose(SupportKind::automatic).support, std::vector<int>{2});
  EXPECT_EQ(no_floor.choose(SupportKind::automatic).support_doubt, SupportDoubt::something_lower);
  EXPECT_EQ(no_floor.choose(SupportKind::floor).support_reason, SupportReason::no_floor);
}

TEST(Obstacles, NothingIsLeftOfTheLastCall) {
  const Frame frame = table_with_a_box();
  Frame empty = frame;
  empty.planes.planes.clear();
  ObstacleWorkspace workspace;
  Obstacles found;
  ASSERT_TRUE(find_obstacles(frame.view(), frame.camera, frame.planes, {}, nullptr, workspace, found));
  EXPECT_FALSE(found.obstacles.empty());
  ASSERT_TRUE(find_obstacles(empty.view(), empty.camera, empty.planes, {}, nullptr, workspace, found));
  const Obstacles fresh = find(empty);
  EXPECT_TRUE(found.support.empty());
  EXPECT_EQ(found.support_reason, fresh.support_reason);
  EXPECT_EQ(found.obstacles.size(), fresh.obstacles.size());
  EXPECT_EQ(found.labels, fresh.labels);
  EXPECT_EQ(found.support_plane.d, fresh.support_plane.d);
  EXPECT_EQ(found.ground.origin, fresh.ground.origin);
  EXPECT_EQ(found.ground.axes, fresh.ground.axes);
}

// ---- inputs ----

TEST(Obstacles, FloatsAndUnitsAgree) {
  const Frame frame = table_with_a_box();
  const Obstacles metres = find(frame);
  const auto units = find_obstacles(frame.view_of_units(), frame.camera, frame.planes);
  ASSERT_TRUE(units);
  ASSERT_EQ(units->obstacles.size(), metres.obstacles.size());
  std::size_t different = 0;
  for (std::size_t i = 0; i < metres.labels.size(); ++i) different += metres.labels[i] != units->labels[i] ? 1U : 0U;
  EXPECT_LE(different, metres.labels.size() / 1000);
  for (std::size_t i = 0; i < metres.obstacles.size(); ++i) {
    EXPECT_LE((metres.obstacles[i].box.size - units->obstacles[i].box.size).norm(), 0.01);
    EXPECT_LE((metres.obstacles[i].centroid - units->obstacles[i].centroid).norm(), 0.002);
  }
}

TEST(Obstacles, ANonMultipleOfACellIsAsWide) {
  for (const int width : {640, 637, 634, 633, 629, 625}) {
    Camera camera = kinect();
    camera.width = width;
    camera.height = 480 - (640 - width);
    Builder b = floor_of();
    b.object();
    b.box(standing(0.55, 1.5, 0.0, 0.0), {0.4, 0.3, 0.3}, {});
    const Frame frame = see(b, kEye, kLookAt, camera);
    const Obstacles found = find(frame);
    expect_sane(found, frame.view());
    ASSERT_EQ(found.obstacles.size(), 1U) << width;
    EXPECT_GE(share(frame, found, 1, 1), 0.998) << width;
  }
}

TEST(Obstacles, RowsWithGaps) {
  const Frame frame = table_with_a_box();
  const auto width = at(frame.camera.width);
  const std::size_t stride = width + 13;
  std::vector<float> wide(stride * at(frame.camera.height), 0.001F);
  for (std::size_t v = 0; v < at(frame.camera.height); ++v) {
    std::copy_n(frame.metres.begin() + static_cast<std::ptrdiff_t>(v * width), width,
                wide.begin() + static_cast<std::ptrdiff_t>(v * stride));
  }
  const auto view = DepthView::from_float(wide.data(), frame.camera.width, frame.camera.height,
                                          static_cast<std::ptrdiff_t>(stride * sizeof(float)));
  const auto found = find_obstacles(view, frame.camera, frame.planes);
  ASSERT_TRUE(found);
  EXPECT_EQ(found->labels, find(frame).labels);
}

TEST(Obstacles, ImagesOfAnySize) {
  // A plane across the image that carries, and everything nearer.
  for (int height = 1; height <= 9; ++height) {
    for (int width = 1; width <= 17; ++width) {
      testing::FloatImage image(testing::small_camera(width, height));
      const Plane plane = *make_plane({0.1, -0.2, -1.0}, 2.0);
      image.draw(plane);
      for (std::size_t i = 0; i < image.metres.size(); i += 2) image.metres[i] *= 0.5F;
      Segmentation planes;
      planes.width = width;
      planes.height = height;
      planes.planes.push_back({.id = 1, .plane = plane});
      planes.labels.assign(image.metres.size(), kLabelNoPlane);
      for (std::size_t i = 1; i < image.metres.size(); i += 2) planes.labels[i] = 1;
      const auto found = find_obstacles(image.view(), image.camera, planes);
      ASSERT_TRUE(found);
      expect_sane(*found, image.view());
      std::fill(image.metres.begin(), image.metres.end(), 0.0F);
      std::fill(planes.labels.begin(), planes.labels.end(), kLabelNoDepth);
      const auto blind = find_obstacles(image.view(), image.camera, planes);
      ASSERT_TRUE(blind);
      EXPECT_TRUE(blind->obstacles.empty());
    }
  }
}

TEST(Obstacles, WhatIsOutsideTheLimitsIsNone) {
  Builder b = floor_of();
  b.object();
  b.box(standing(-0.3, 1.2, 0.0, 0.0), {0.2, 0.2, 0.2}, {});
  b.object();
  b.box(standing(0.4, 2.4, 0.0, 0.0), {0.2, 0.2, 0.2}, {});
  const Frame frame = see(b, kEye, kLookAt);
  ASSERT_EQ(find(frame).obstacles.size(), 2U);
  const AxisLimits limits{Axis::z, 0.0, 2.2};
  for (const DepthView& view : {frame.view(), frame.view_of_units()}) {
    const auto found = find_obstacles(view, frame.camera, frame.planes, {}, &limits);
    ASSERT_TRUE(found);
    expect_sane(*found, view);
    ASSERT_EQ(found->obstacles.size(), 1U);
    EXPECT_GE(share(frame, *found, 1, 1), 0.998);
    EXPECT_EQ(share(frame, *found, 2, 0), 1.0);
  }
  const AxisLimits right{Axis::x, 0.0, 9.0};
  const auto found = find_obstacles(frame.view(), frame.camera, frame.planes, {}, &right);
  ASSERT_TRUE(found);
  ASSERT_EQ(found->obstacles.size(), 1U);
  EXPECT_GE(share(frame, *found, 2, 1), 0.998);
}

TEST(Obstacles, HolesInTheDepthDoNotCut) {
  Builder b = floor_of();
  b.object();
  b.box(standing(0.0, 1.4, 0.0, 0.0), {0.6, 0.3, 0.3}, {});
  Frame frame = see(b, kEye, kLookAt);
  for (int v = 0; v < 480; ++v) {
    for (int u = 320; u < 324; ++u) {  // a cell's width
      frame.metres[at(v * 640 + u)] = 0.0F;
      frame.planes.labels[at(v * 640 + u)] = kLabelNoDepth;
    }
  }
  const Obstacles found = find(frame);
  EXPECT_EQ(found.obstacles.size(), 1U);
}

TEST(Obstacles, SmallThingsAreLeftOut) {
  Builder b = floor_of();
  b.object();
  b.box(standing(-0.3, 1.4, 0.0, 0.0), {0.06, 0.06, 0.06}, {});
  b.object();
  b.box(standing(0.3, 1.4, 0.0, 0.0), {0.3, 0.3, 0.3}, {});
  const Frame frame = see(b, kEye, kLookAt);
  EXPECT_EQ(find(frame).obstacles.size(), 2U);
  EXPECT_EQ(find(frame, {.min_size_m = 0.15}).obstacles.size(), 1U);
  EXPECT_EQ(find(frame, {.least_height_m = 0.1}).obstacles.size(), 1U);
}

TEST(Obstacles, TheWholeWayFromDepth) {
  const Frame frame = table_with_a_box();
  SegmentOptions options = testing::cells_options();
  const Segmentation planes = testing::cells(frame.view_of_units(), frame.camera, options);
  const auto found = find_obstacles(frame.view_of_units(), frame.camera, planes);
  ASSERT_TRUE(found);
  expect_sane(*found, frame.view_of_units());
  EXPECT_EQ(found->obstacles.size(), 2U);
  options.threads = 2;
  options.seed = 77;
  const auto again =
      find_obstacles(frame.view_of_units(), frame.camera, testing::cells(frame.view_of_units(), frame.camera, options));
  ASSERT_TRUE(again);
  EXPECT_EQ(found->labels, again->labels);
}

/// A plane that carries, and on it whatever `depth(random)` says, in runs.
template <class Depth>
Obstacles find_in_noise(RandomStream& random, const Camera& camera, const DepthNoise& noise, const Depth& depth) {
  testing::FloatImage image(camera);
  const Plane plane = *make_plane({0.0, -0.5, -1.0}, 1.5);
  image.draw(plane);
  Segmentation planes;
  planes.method = Method::cells;
  planes.width = camera.width;
  planes.height = camera.height;
  planes.noise = noise;
  planes.planes.push_back({.id = 1, .plane = plane});
  planes.labels.assign(image.metres.size(), 1);
  for (std::size_t i = 0; i < image.metres.size();) {
    const std::size_t end = std::min<std::size_t>(i + 1 + random.below(20), image.metres.size());
    const bool on_plane = random.below(3) == 0;
    for (; i < end; ++i) {
      if (on_plane) continue;
      image.metres[i] = depth(random);
      planes.labels[i] = static_cast<std::uint8_t>(random.below(2) == 0 ? kLabelNoPlane : random.below(256));
    }
  }
  auto found = find_obstacles(image.view(), camera, planes, {.min_size_m = 0.0, .touching_size_m = 0.0});
  if (!found) {
    ADD_FAILURE() << found.error().message;
    return {};
  }
  expect_numbers(*found, image.view());
  return *std::move(found);
}

TEST(Obstacles, AnyDepthIsSurvived) {
  RandomStream random = testing::test_random();
  const float special[] = {
      0.0F, -1.0F, 1e-45F, 1e-39F, 1e-30F, 1e-19F, 1e-10F, 1e5F, 3e38F, std::nanf(""), std::numeric_limits<float>::infinity()};
  const DepthNoise noises[] = {{}, {.constant_m = 0.01, .linear = 0.002}, {.quadratic_per_m = 1e-3}, {.constant_m = 1e-30}};
  for (int i = 0; i < 40; ++i) {
    for (const DepthNoise& noise : noises) {
      find_in_noise(random, testing::small_camera(81, 63), noise, [&](RandomStream& r) {
        if (r.below(2) == 0) return special[r.below(std::size(special))];
        return static_cast<float>(std::pow(10.0, testing::uniform(r, -3.0, 2.0)));
      });
    }
  }
}

TEST(Obstacles, LongFocalLengths) {
  RandomStream random = testing::test_random();
  for (const double focal : {0.1, 5e3, 3.4e4, 1e5, 1e6}) {
    Camera camera = testing::small_camera(700, 600);
    camera.fx = camera.fy = focal;
    find_in_noise(random, camera, {.quadratic_per_m = 1e-3},
                  [](RandomStream& r) { return static_cast<float>(testing::uniform(r, 0.9, 1.1)); });
  }
}

TEST(Obstacles, MoreThanCanBeCounted) {
  // Specks of 8 x 8 pixels in cells of 4 x 4, every 12 pixels: 13 thousand of them, above or below.
  Camera camera = kinect();
  camera.width = 1600;
  camera.height = 1200;
  for (const float speck : {0.5F, 2.0F}) {
    testing::FloatImage image(camera);
    const Plane plane = *make_plane(-Vector3d::UnitZ(), 1.0);
    image.draw(plane);
    Segmentation planes;
    planes.width = camera.width;
    planes.height = camera.height;
    planes.planes.push_back({.id = 1, .plane = plane});
    planes.labels.assign(image.metres.size(), 1);
    for (int v = 0; v < camera.height; ++v) {
      for (int u = 0; u < camera.width; ++u) {
        if (u % 12 >= 8 || v % 12 >= 8) continue;
        if (speck > 1.0F && u % 12 >= 4 && v < 100) continue;  // the first are too small for drops
        image.at(u, v) = speck;
        planes.labels[at(v * camera.width + u)] = kLabelNoPlane;
      }
    }
    const auto found = find_obstacles(image.view(), camera, planes, {.support = {SupportKind::plane, 1}, .min_size_m = 0.0});
    ASSERT_TRUE(found);
    EXPECT_EQ(found->obstacles.size(), 4095U);
    expect_sane(*found, image.view());
  }
}

TEST(Obstacles, BadArguments) {
  const Frame frame = table_with_a_box();
  const auto message = [&](const ObstacleOptions& options) {
    const auto found = find_obstacles(frame.view(), frame.camera, frame.planes, options);
    EXPECT_TRUE(found || found.error().code == ErrorCode::invalid_argument);
    return found ? std::string() : found.error().message;
  };
  using ::testing::HasSubstr;
  const double nan = std::nan("");
  const double inf = std::numeric_limits<double>::infinity();
  EXPECT_THAT(message({.height_sigmas = 0.0}), HasSubstr("height-sigmas"));
  EXPECT_THAT(message({.height_sigmas = 101.0}), HasSubstr("height-sigmas"));
  for (const double bad : {-1e-9, nan, inf}) {
    EXPECT_THAT(message({.least_height_m = bad}), HasSubstr("least-height"));
    EXPECT_THAT(message({.least_drop_m = bad}), HasSubstr("least-drop"));
    EXPECT_THAT(message({.min_size_m = bad}), HasSubstr("min-size"));
    EXPECT_THAT(message({.touching_size_m = bad}), HasSubstr("touching-size"));
  }
  for (const int label : {0, -1, 255}) {
    EXPECT_THAT(message({.support = {SupportKind::plane, label}}), HasSubstr("support"));
  }
  EXPECT_EQ(message({.least_height_m = 0.0, .least_drop_m = 0.0, .min_size_m = 0.0, .touching_size_m = 0.0}), "");
  EXPECT_EQ(
      message(
          {.height_sigmas = 100.0, .least_height_m = 1e30, .least_drop_m = 1e30, .min_size_m = 1e30, .touching_size_m = 1e30}),
      "");

  Camera other = frame.camera;
  --other.width;
  EXPECT_FALSE(find_obstacles(frame.view(), other, frame.planes));
  Segmentation small = frame.planes;
  small.labels.pop_back();
  EXPECT_FALSE(find_obstacles(frame.view(), frame.camera, small));
  small = frame.planes;
  --small.height;
  EXPECT_FALSE(find_obstacles(frame.view(), frame.camera, small));
}

}  // namespace
}  // namespace fransac
