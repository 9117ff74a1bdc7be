// SPDX-License-Identifier: Apache-2.0
#include "synth/things.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>

namespace fransac::synth::detail {
namespace {

using Eigen::Vector3d;

// How far a solid reaches from its centre along a unit vector: its support function.
double reach(const Primitive& primitive, const Vector3d& direction) {
  const Vector3d d = primitive.pose.linear().transpose() * direction;
  const Vector3d& half = primitive.half;
  switch (primitive.shape) {
    case Shape::sphere: return half.x();
    case Shape::cylinder: return half.x() * d.head<2>().norm() + half.z() * std::abs(d.z());
    case Shape::rectangle:
    case Shape::box: return half.dot(d.cwiseAbs());
  }
  return 0.0;
}

// A solid's x axis made level; where it is more upright than level, its y axis.
Vector3d level_edge(const Primitive& primitive, const Vector3d& up) {
  constexpr double kUpright = 0.7;
  const Vector3d x = primitive.pose.linear().col(0);
  const Vector3d y = primitive.pose.linear().col(1);
  const Vector3d edge = std::abs(x.dot(up)) < kUpright ? x : y;
  return (edge - edge.dot(up) * up).normalized();
}

OrientedBox box_of(const Scene& scene, const Object& object) {
  OrientedBox box;
  box.up = scene.up;
  box.along = level_edge(scene.primitives[static_cast<std::size_t>(object.first)], scene.up);
  const std::array<Vector3d, 3> axes{box.along, box.up.cross(box.along), box.up};
  for (int axis = 0; axis < 3; ++axis) {
    const Vector3d& direction = axes[static_cast<std::size_t>(axis)];
    double low = std::numeric_limits<double>::infinity();
    double high = -low;
    for (int i = object.first; i < object.last; ++i) {
      const Primitive& primitive = scene.primitives[static_cast<std::size_t>(i)];
      const double middle = direction.dot(primitive.pose.translation());
      const double half = reach(primitive, direction);
      low = std::min(low, middle - half);
      high = std::max(high, middle + half);
    }
    box.size[axis] = high - low;
    box.centre += 0.5 * (low + high) * direction;
  }
  return box;
}

// The plane that a ray meets first on what has no id, if it is level.
std::optional<Plane> support_under(const Scene& scene, const Vector3d& origin) {
  constexpr double kLevel = 1e-9;  // 1 - cosine: built level
  double nearest = kMiss;
  int plane = -1;
  for (const Object& object : scene.objects) {
    for (int i = object.first; object.id == 0 && i < object.last; ++i) {
      const Primitive& primitive = scene.primitives[static_cast<std::size_t>(i)];
      const Eigen::Isometry3d to_solid = primitive.pose.inverse();
      const Hit hit = intersect(primitive.shape, primitive.half, to_solid * origin, to_solid.linear() * -scene.up);
      if (hit.t >= nearest) continue;
      nearest = hit.t;
      const int face = primitive.first_face + hit.face;
      plane = scene.plane_of_face[static_cast<std::size_t>(face)];
    }
  }
  if (plane < 0) return std::nullopt;
  const Plane& found = scene.planes[static_cast<std::size_t>(plane)];
  return std::abs(found.normal.dot(scene.up)) > 1.0 - kLevel ? std::optional(found) : std::nullopt;
}

}  // namespace

std::vector<TrueObject> things_of(const Scene& scene) {
  constexpr double kLift_m = 1e-4;  // a ray that starts on the support itself might miss it
  std::vector<TrueObject> things;
  for (const Object& object : scene.objects) {
    if (object.id == 0) continue;
    TrueObject thing;
    thing.id = object.id;
    thing.box = box_of(scene, object);
    const Vector3d bottom = thing.box.centre - 0.5 * thing.box.size.z() * scene.up;
    thing.support = support_under(scene, bottom + kLift_m * scene.up);
    if (thing.support) {
      const double upwards = thing.support->normal.dot(scene.up) > 0.0 ? 1.0 : -1.0;
      thing.lowest_m = upwards * thing.support->signed_distance(bottom);
      thing.highest_m = thing.lowest_m + thing.box.size.z();
    }
    things.push_back(thing);
  }
  return things;
}

}  // namespace fransac::synth::detail
