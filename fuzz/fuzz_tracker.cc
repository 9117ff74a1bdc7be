// SPDX-License-Identifier: Apache-2.0
// A few frames of any planes and obstacles: every frame ends in an error, or in ids that no two have, a pose that is one, and
// planes with covariances; a second tracker says the same.
#include <Eigen/Geometry>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <set>
#include <vector>

#include "draw.hpp"
#include "fransac/track/tracker.hpp"
#include "require.hpp"

namespace {

using namespace fransac;
using namespace fransac::fuzz;

constexpr int kSide = 4;  // of the label images, pixels

double draw_size(Bytes& bytes) { return draw_seldom(bytes) ? draw_any(bytes) : draw_number(bytes, 0.0, 5.0); }

Eigen::Isometry3d draw_pose(Bytes& bytes, double turn, double reach) {
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  const Eigen::Vector3d axis = draw_vector(bytes, turn);
  if (axis.norm() > 0.0) pose.linear() = Eigen::AngleAxisd(axis.norm(), axis.normalized()).toRotationMatrix();
  pose.translation() = draw_vector(bytes, reach);
  if (draw_seldom(bytes)) pose.matrix()(bytes.ConsumeIntegralInRange(0, 3), bytes.ConsumeIntegralInRange(0, 3)) = draw_any(bytes);
  return pose;
}

/// A plane as `cells` would give it, or with one number that it would not.
PlaneSegment draw_plane(Bytes& bytes) {
  PlaneSegment segment;
  const Eigen::Vector3d normal = draw_vector(bytes, 1.0);
  segment.plane = make_plane(normal, bytes.ConsumeFloatingPointInRange(-3.0, 3.0)).value_or(Plane{{0.0, 0.0, -1.0}, 2.0});
  const double sigma = draw_number(bytes, 1e-6, 0.1);
  Eigen::Matrix4d covariance = sigma * sigma * Eigen::Matrix4d::Identity();
  const Eigen::Vector3d n = segment.plane.normal;
  covariance.topLeftCorner<3, 3>() -= sigma * sigma * n * n.transpose();
  segment.covariance = covariance;
  segment.centroid = -segment.plane.d * n;
  segment.area_m2 = draw_size(bytes);
  if (draw_seldom(bytes)) segment.plane.normal[bytes.ConsumeIntegralInRange(0, 2)] = draw_any(bytes);
  if (draw_seldom(bytes)) segment.plane.d = draw_any(bytes);
  if (draw_seldom(bytes)) segment.centroid = draw_any_vector(bytes);
  if (draw_seldom(bytes)) {
    segment.covariance(bytes.ConsumeIntegralInRange(0, 3), bytes.ConsumeIntegralInRange(0, 3)) = draw_any(bytes);
  }
  return segment;
}

template <class Label>
void draw_labels(Bytes& bytes, std::vector<Label>& labels, int& width, int& height) {
  width = height = kSide;
  labels.resize(kSide * kSide);
  for (Label& label : labels) label = bytes.ConsumeIntegralInRange<Label>(0, 5);
  if (draw_seldom(bytes)) labels[0] = bytes.ConsumeIntegral<Label>();
  if (draw_seldom(bytes)) width = bytes.ConsumeIntegral<int>();
}

/// Planes of a scene as they are seen from a camera's pose, and a few others.
Segmentation draw_segmentation(Bytes& bytes, const std::vector<PlaneSegment>& scene, const Eigen::Isometry3d& T_world_camera) {
  Segmentation s;
  s.method = draw_seldom(bytes) ? Method::ransac : Method::cells;
  draw_labels(bytes, s.labels, s.width, s.height);
  for (PlaneSegment plane : scene) {
    if (bytes.ConsumeBool()) continue;
    const Eigen::Vector3d normal = T_world_camera.linear().transpose() * plane.plane.normal;
    plane.plane = {normal, plane.plane.d + plane.plane.normal.dot(T_world_camera.translation())};
    plane.centroid = T_world_camera.inverse() * plane.centroid;
    s.planes.push_back(plane);
  }
  if (bytes.ConsumeBool()) s.planes.push_back(draw_plane(bytes));
  for (std::size_t i = 0; i < s.planes.size(); ++i) s.planes[i].id = static_cast<int>(i) + kLabelFirst;
  return s;
}

Obstacles draw_obstacles(Bytes& bytes) {
  Obstacles found;
  draw_labels(bytes, found.labels, found.width, found.height);
  for (int n = bytes.ConsumeIntegralInRange(0, 4); n > 0; --n) {
    Obstacle& o = found.obstacles.emplace_back();
    o.id = static_cast<int>(found.obstacles.size());
    o.kind = static_cast<ObstacleKind>(bytes.ConsumeIntegralInRange(0, 2));
    o.centroid = draw_seldom(bytes) ? draw_any_vector(bytes) : draw_vector(bytes, 3.0);
    o.box.centre = draw_seldom(bytes) ? draw_any_vector(bytes) : draw_vector(bytes, 3.0);
    o.box.size = {draw_size(bytes), draw_size(bytes), draw_size(bytes)};
  }
  if (draw_seldom(bytes)) found.ground.origin = draw_any_vector(bytes);
  return found;
}

template <class Tracked>
void check_ids(const std::vector<Tracked>& all) {
  std::set<int> ids;
  for (const Tracked& one : all) require(one.id > 0 && one.age > 0 && ids.insert(one.id).second);
}

void check(const TrackedFrame& frame, const Segmentation& s, const Obstacles* obstacles, bool posed) {
  require((frame.pose_source == PoseSource::given) == posed);
  require(frame.T_world_camera.matrix().allFinite());
  const Eigen::Matrix3d R = frame.T_world_camera.linear();
  require((R * R.transpose()).isIdentity(1e-6) && R.determinant() > 0.0);
  require(frame.planes.size() == s.planes.size());
  check_ids(frame.planes);
  check_ids(frame.objects);
  for (std::size_t i = 0; i < frame.planes.size(); ++i) {
    const TrackedPlane& plane = frame.planes[i];
    require(plane.label == s.planes[i].id && plane.covariance.allFinite());
    require(std::abs(plane.plane.normal.norm() - 1.0) < 1e-6 && std::isfinite(plane.plane.d));
  }
  for (const TrackedObject& object : frame.objects) {
    require(obstacles != nullptr && object.obstacle >= 1);
    require(static_cast<std::size_t>(object.obstacle) <= obstacles->obstacles.size());
    require(obstacles->obstacles[static_cast<std::size_t>(object.obstacle - 1)].kind != ObstacleKind::drop);
  }
}

void check_same(const TrackedFrame& a, const TrackedFrame& b) {
  require(a.planes.size() == b.planes.size() && a.objects.size() == b.objects.size());
  require(a.T_world_camera.matrix() == b.T_world_camera.matrix() && a.pose_source == b.pose_source);
  for (std::size_t i = 0; i < a.planes.size(); ++i) {
    require(a.planes[i].id == b.planes[i].id && a.planes[i].plane.normal == b.planes[i].plane.normal);
  }
  for (std::size_t i = 0; i < a.objects.size(); ++i) require(a.objects[i].id == b.objects[i].id);
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  Bytes bytes(data, size);
  TrackOptions options;
  draw_options(bytes, [&](const auto& visit) { for_each_track_option(options, visit); });
  Tracker tracker(options);
  Tracker second(options);
  std::vector<PlaneSegment> scene;
  for (int n = bytes.ConsumeIntegralInRange(0, 5); n > 0; --n) scene.push_back(draw_plane(bytes));
  Eigen::Isometry3d T_world_camera = Eigen::Isometry3d::Identity();
  for (int n = bytes.ConsumeIntegralInRange(1, 8); n > 0; --n) {
    T_world_camera = T_world_camera * draw_pose(bytes, 0.03, 0.05);
    const Segmentation segmentation = draw_segmentation(bytes, scene, T_world_camera);
    const bool posed = bytes.ConsumeBool();
    const auto pose = posed ? std::optional(T_world_camera) : std::nullopt;
    const std::optional<Obstacles> drawn = bytes.ConsumeBool() ? std::optional(draw_obstacles(bytes)) : std::nullopt;
    const Obstacles* const obstacles = drawn ? &*drawn : nullptr;
    TrackedFrame frame;
    TrackedFrame again;
    const Status status = tracker.update(segmentation, obstacles, pose, frame);
    require(second.update(segmentation, obstacles, pose, again).ok() == status.ok());
    if (status) {
      require(validate(options).ok());
      check(frame, segmentation, obstacles, posed);
      check_same(frame, again);
    } else {
      require_message(status.error());
      require(frame.planes.empty() && frame.objects.empty());
    }
    if (draw_seldom(bytes)) {
      tracker.reset();
      second.reset();
    }
  }
  return 0;
}
