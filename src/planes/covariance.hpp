// SPDX-License-Identifier: Apache-2.0
/// Planes from inverse depth, with what is known of their errors.
#pragma once

#include <Eigen/Core>
#include <optional>

#include "fransac/core/plane.hpp"

namespace fransac {

struct PlaneEstimate {
  Plane plane;                 ///< Canonical.
  Eigen::Matrix4d covariance;  ///< Of (normal, d); the normal's unit length makes it of rank 3 at most.
};

/// On a plane q = 1/z = alpha x + beta y + gamma with x = (u - cx)/fx, y = (v - cy)/fy. The plane of (alpha, beta, gamma) and,
/// to first order, its covariance from theirs. Nothing for (0, 0, 0), the plane at infinity, or what is not finite.
std::optional<PlaneEstimate> plane_from_inverse_depth(const Eigen::Vector3d& parameters, const Eigen::Matrix3d& covariance);

}  // namespace fransac
