// SPDX-License-Identifier: Apache-2.0
#include "planes/covariance.hpp"

namespace fransac {

std::optional<PlaneEstimate> plane_from_inverse_depth(const Eigen::Vector3d& parameters, const Eigen::Matrix3d& covariance) {
  // n . p + d = 0 with p = (x, y, 1)/q: parameters = -n/d, and the camera is on the positive side.
  const std::optional<Plane> plane = make_plane(-parameters, 1.0);
  if (!plane || !covariance.allFinite()) return std::nullopt;
  const Eigen::Vector3d& n = plane->normal;
  const double d = plane->d;
  Eigen::Matrix<double, 4, 3> jacobian;
  jacobian.topRows<3>() = -d * (Eigen::Matrix3d::Identity() - n * n.transpose());
  jacobian.bottomRows<1>() = d * d * n.transpose();
  return PlaneEstimate{*plane, jacobian * covariance * jacobian.transpose()};
}

}  // namespace fransac
