// SPDX-License-Identifier: Apache-2.0
#include "fransac/core/plane.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace fransac {
namespace {

// Smallest height over longest side of a triangle whose plane is trusted; see plane_through().
constexpr double kMinTriangleHeight = 1e-4;

}  // namespace

std::optional<Plane> make_plane(const Eigen::Vector3d& normal, double d) {
  if (!normal.allFinite()) return std::nullopt;
  const double length = normal.stableNorm();  // squares neither overflow nor vanish
  Plane plane{normal / length, d / length};
  if (!(length > 0.0) || !std::isfinite(plane.d)) return std::nullopt;
  bool flip = plane.d < 0.0;
  if (plane.d == 0.0) {
    const auto first = std::find_if(plane.normal.begin(), plane.normal.end(), [](double c) { return c != 0.0; });
    flip = *first < 0.0;
  }
  if (flip) plane = {-plane.normal, -plane.d};
  plane.d += 0.0;  // -0 becomes +0
  return plane;
}

std::optional<Plane> plane_through(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& c) {
  const Eigen::Vector3d ab = b - a;
  const Eigen::Vector3d ac = c - a;
  const Eigen::Vector3d normal = ab.cross(ac);  // its length is the longest side times the smallest height
  const double longest_squared = std::max({ab.squaredNorm(), ac.squaredNorm(), (c - b).squaredNorm()});
  if (!(normal.norm() > kMinTriangleHeight * longest_squared)) return std::nullopt;
  return make_plane(normal, -normal.dot(a));
}

Plane translated(const Plane& plane, const Eigen::Vector3d& shift) {
  return make_plane(plane.normal, plane.d + plane.normal.dot(shift)).value_or(plane);
}

double angle_between(const Plane& a, const Plane& b) {
  return std::atan2(a.normal.cross(b.normal).norm(), std::abs(a.normal.dot(b.normal)));
}

}  // namespace fransac
