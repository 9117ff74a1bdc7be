// SPDX-License-Identifier: Apache-2.0
/// A plane in Hessian normal form.
#pragma once

#include <Eigen/Core>
#include <optional>

namespace fransac {

/// The points p with normal . p + d = 0; |normal| = 1. Canonical sign: the origin (the camera) is on the positive
/// side, d >= 0; a plane through the origin has its first non-zero normal component positive.
struct Plane {
  Eigen::Vector3d normal = Eigen::Vector3d::UnitZ();  ///< Unit vector.
  double d = 0.0;                                     ///< Metres.

  /// Signed distance in metres; positive on the origin's side.
  [[nodiscard]] double signed_distance(const Eigen::Vector3d& point) const { return normal.dot(point) + d; }
};

/// Scales to unit normal and canonical sign. Nothing when the normal is zero or a coefficient is not finite.
std::optional<Plane> make_plane(const Eigen::Vector3d& normal, double d);

/// The plane through three points; nothing when they are collinear: when the triangle's smallest height is below
/// 1e-4 of its longest side (float coordinates could not tell its normal to better than about a degree) or its longest
/// side is zero.
std::optional<Plane> plane_through(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& c);

/// The same plane seen from another origin: coordinates p' = p - shift.
Plane translated(const Plane& plane, const Eigen::Vector3d& shift);

/// Angle between the two normals as undirected lines, radians in [0, pi/2].
double angle_between(const Plane& a, const Plane& b);

}  // namespace fransac
