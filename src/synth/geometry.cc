// SPDX-License-Identifier: Apache-2.0
#include "synth/geometry.hpp"

#include <algorithm>
#include <cmath>

namespace fransac::synth::detail {
namespace {

using Eigen::Vector3d;

// A hit this close to a ray's end, as a share of its length, is the surface that the ray ends on.
constexpr double kSelfHit = 1e-6;

// Faces whose normals and offsets agree to this (metres, radians) were built as one plane.
constexpr double kSamePlane = 1e-9;

Hit hit_rectangle(const Vector3d& half, const Vector3d& o, const Vector3d& d) {
  if (d.z() == 0.0) return {};
  const double t = -o.z() / d.z();
  if (!(t > 0.0)) return {};
  const bool inside = std::abs(o.x() + t * d.x()) <= half.x() && std::abs(o.y() + t * d.y()) <= half.y();
  return inside ? Hit{t, -1, 0} : Hit{};
}

// The slab method (Kay & Kajiya 1986).
Hit hit_box(const Vector3d& half, const Vector3d& o, const Vector3d& d) {
  double enter = -kMiss;
  double leave = kMiss;
  int enter_face = 0;
  int leave_face = 0;
  for (int axis = 0; axis < 3; ++axis) {
    if (d[axis] == 0.0) {
      if (std::abs(o[axis]) > half[axis]) return {};
      continue;
    }
    const double inverse = 1.0 / d[axis];
    const int far_side = inverse > 0.0 ? 1 : 0;
    const double near = (-std::copysign(half[axis], inverse) - o[axis]) * inverse;
    const double far = (std::copysign(half[axis], inverse) - o[axis]) * inverse;
    if (near > enter) {
      enter = near;
      enter_face = 2 * axis + 1 - far_side;
    }
    if (far < leave) {
      leave = far;
      leave_face = 2 * axis + far_side;
    }
    if (enter > leave) return {};
  }
  if (enter > 0.0) return {enter, -1, enter_face};
  if (leave > 0.0) return {leave, -1, leave_face};
  return {};
}

struct Interval {
  double enter = kMiss;
  double leave = -kMiss;
};

// The solutions of a t^2 - 2 b t + c = 0.
Interval solve(double a, double b, double c) {
  const double discriminant = b * b - a * c;
  if (discriminant < 0.0) return {};
  const double root = std::sqrt(discriminant);
  return {(b - root) / a, (b + root) / a};
}

Hit hit_sphere(double radius, const Vector3d& o, const Vector3d& d) {
  const Interval ball = solve(d.squaredNorm(), -o.dot(d), o.squaredNorm() - radius * radius);
  if (ball.enter > ball.leave) return {};
  const double t = ball.enter > 0.0 ? ball.enter : ball.leave;
  return t > 0.0 ? Hit{t, -1, 0} : Hit{};
}

Hit hit_cylinder(double radius, double half_height, const Vector3d& o, const Vector3d& d) {
  Interval round{-kMiss, kMiss};
  const double a = d.x() * d.x() + d.y() * d.y();
  const double c = o.x() * o.x() + o.y() * o.y() - radius * radius;
  if (a > 0.0) {
    round = solve(a, -(o.x() * d.x() + o.y() * d.y()), c);
  } else if (c > 0.0) {
    return {};
  }
  Interval slab{-kMiss, kMiss};
  if (d.z() != 0.0) {
    const double bottom = (-half_height - o.z()) / d.z();
    const double top = (half_height - o.z()) / d.z();
    slab = {std::min(bottom, top), std::max(bottom, top)};
  } else if (std::abs(o.z()) > half_height) {
    return {};
  }
  const double enter = std::max(round.enter, slab.enter);
  const double leave = std::min(round.leave, slab.leave);
  if (enter > leave) return {};
  const int first_cap = d.z() > 0.0 ? 1 : 2;
  if (enter > 0.0) return {enter, -1, slab.enter > round.enter ? first_cap : 0};
  if (leave > 0.0) return {leave, -1, slab.leave < round.leave ? 3 - first_cap : 0};
  return {};
}

bool encloses(const Primitive& primitive, const Vector3d& point) {
  const Vector3d p = primitive.pose.inverse() * point;
  const Vector3d& h = primitive.half;
  switch (primitive.shape) {
    case Shape::rectangle: return false;
    case Shape::box: return (p.array().abs() <= h.array()).all();
    case Shape::cylinder: return p.head<2>().squaredNorm() <= h.x() * h.x() && std::abs(p.z()) <= h.z();
    case Shape::sphere: return p.squaredNorm() <= h.x() * h.x();
  }
  return false;
}

double bounding_radius(const Primitive& primitive) {
  switch (primitive.shape) {
    case Shape::cylinder: return std::hypot(primitive.half.x(), primitive.half.z());
    case Shape::sphere: return primitive.half.x();
    default: return primitive.half.norm();
  }
}

// The plane's index in planes[first..]; appended when it is new.
int index_of(std::vector<Plane>& planes, std::size_t first, const Plane& plane) {
  for (std::size_t i = first; i < planes.size(); ++i) {
    if ((planes[i].normal - plane.normal).norm() < kSamePlane && std::abs(planes[i].d - plane.d) < kSamePlane) {
      return static_cast<int>(i);
    }
  }
  planes.push_back(plane);
  return static_cast<int>(planes.size()) - 1;
}

}  // namespace

Hit intersect(Shape shape, const Vector3d& half, const Vector3d& origin, const Vector3d& direction) {
  switch (shape) {
    case Shape::rectangle: return hit_rectangle(half, origin, direction);
    case Shape::box: return hit_box(half, origin, direction);
    case Shape::cylinder: return hit_cylinder(half.x(), half.z(), origin, direction);
    case Shape::sphere: return hit_sphere(half.x(), origin, direction);
  }
  return {};
}

int face_count(Shape shape) {
  switch (shape) {
    case Shape::box: return 6;
    case Shape::cylinder: return 3;
    default: return 1;
  }
}

std::optional<FacePlane> face_plane(Shape shape, const Vector3d& half, int face) {
  switch (shape) {
    case Shape::rectangle: return FacePlane{Vector3d::UnitZ(), 0.0};
    case Shape::box: {
      const int axis = face / 2;
      return FacePlane{Vector3d::Unit(axis) * (face % 2 == 1 ? 1.0 : -1.0), half[axis]};
    }
    case Shape::cylinder:
      if (face == 0) return std::nullopt;
      return FacePlane{Vector3d::UnitZ() * (face == 2 ? 1.0 : -1.0), half.z()};
    case Shape::sphere: return std::nullopt;
  }
  return std::nullopt;
}

Vector3d surface_normal(const Primitive& primitive, int face, const Vector3d& point) {
  if (const auto plane = face_plane(primitive.shape, primitive.half, face)) return primitive.pose.linear() * plane->normal;
  Vector3d radial = primitive.pose.inverse() * point;
  if (primitive.shape == Shape::cylinder) radial.z() = 0.0;
  return primitive.pose.linear() * radial.normalized();
}

void Scene::move_to(const Eigen::Isometry3d& transform) {
  for (Primitive& primitive : primitives) primitive.pose = transform * primitive.pose;
  lamp = transform * lamp;
  up = transform.linear() * up;
  planes.clear();
  plane_of_face.clear();
  for (const Object& object : objects) {
    const std::size_t first_plane = planes.size();
    for (int i = object.first; i < object.last; ++i) {
      Primitive& primitive = primitives[static_cast<std::size_t>(i)];
      primitive.first_face = static_cast<int>(plane_of_face.size());
      for (int face = 0; face < face_count(primitive.shape); ++face) {
        const auto local = face_plane(primitive.shape, primitive.half, face);
        int index = -1;
        if (local) {
          const Vector3d normal = primitive.pose.linear() * local->normal;
          const double d = -normal.dot(primitive.pose.translation()) - local->distance;
          if (const auto plane = make_plane(normal, d)) index = index_of(planes, first_plane, *plane);
        }
        plane_of_face.push_back(index);
      }
    }
  }
}

bool Scene::encloses(const Vector3d& point) const {
  return std::any_of(primitives.begin(), primitives.end(), [&](const Primitive& p) { return detail::encloses(p, point); });
}

RayCaster::Ball RayCaster::ball_at(const Vector3d& centre, double radius) {
  return {centre.x(), centre.y(), centre.z(), radius, centre.squaredNorm() - radius * radius};
}

RayCaster::RayCaster(const Scene& scene, const Vector3d& origin) : scene_(scene), origin_(origin) {
  locals_.reserve(scene.primitives.size());
  for (const Primitive& primitive : scene.primitives) {
    const Eigen::Matrix3d rotation = primitive.pose.linear().transpose();
    const Vector3d centre = primitive.pose.translation() - origin;
    locals_.push_back({rotation, -(rotation * centre), ball_at(centre, bounding_radius(primitive))});
  }
  for (const Object& object : scene.objects) {
    Eigen::AlignedBox3d bounds;
    for (int i = object.first; i < object.last; ++i)
      bounds.extend(scene.primitives[static_cast<std::size_t>(i)].pose.translation());
    double radius = 0.0;
    for (int i = object.first; i < object.last; ++i) {
      const Primitive& primitive = scene.primitives[static_cast<std::size_t>(i)];
      radius = std::max(radius, (primitive.pose.translation() - bounds.center()).norm() + bounding_radius(primitive));
    }
    balls_.push_back(ball_at(bounds.center() - origin, radius));
  }
}

Hit RayCaster::cast(const Vector3d& direction, double t_max) const {
  const double direction_squared = direction.squaredNorm();
  Hit nearest{t_max, -1, 0};
  for (std::size_t o = 0; o < balls_.size(); ++o) {
    if (balls_[o].missed(direction, direction_squared, nearest.t)) continue;
    for (int i = scene_.objects[o].first; i < scene_.objects[o].last; ++i) {
      const Local& local = locals_[static_cast<std::size_t>(i)];
      if (local.ball.missed(direction, direction_squared, nearest.t)) continue;
      const Primitive& primitive = scene_.primitives[static_cast<std::size_t>(i)];
      const Hit hit = intersect(primitive.shape, primitive.half, local.origin, local.rotation * direction);
      if (hit.t < nearest.t) nearest = {hit.t, i, hit.face};
    }
  }
  return nearest.primitive >= 0 ? nearest : Hit{};
}

bool RayCaster::blocked(const Vector3d& point) const { return cast(point - origin_, 1.0 - kSelfHit).primitive >= 0; }

}  // namespace fransac::synth::detail
