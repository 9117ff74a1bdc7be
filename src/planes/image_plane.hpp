// SPDX-License-Identifier: Apache-2.0
/// A plane as the rows of a depth image see it.
#pragma once

#include "fransac/core/camera.hpp"
#include "fransac/core/plane.hpp"
#include "kernels/rows.h"

namespace fransac {

/// The signed distance of a pixel with raw depth d is d m (n . r) + plane.d, where m is metres per raw unit and
/// n . r = n_x (u - cx) / fx + n_y (v - cy) / fy + n_z: a ramp in u, whose base is affine in v.
class ImagePlane {
 public:
  /// Distances in multiples of `unit_m`.
  ImagePlane(const Plane& plane, const Camera& camera, float metres_per_unit, double unit_m = 1.0) : plane_d_(plane.d / unit_m) {
    const double scale = static_cast<double>(metres_per_unit) / unit_m;
    step_u_ = plane.normal.x() / camera.fx * scale;
    step_v_ = plane.normal.y() / camera.fy * scale;
    base_ = plane.normal.z() * scale - step_u_ * camera.cx - step_v_ * camera.cy;
  }

  [[nodiscard]] kernels::RowPlane row(int v) const {
    return {{static_cast<float>(base_ + step_v_ * v), static_cast<float>(step_u_)}, static_cast<float>(plane_d_)};
  }

 private:
  double base_;
  double step_u_;
  double step_v_;
  double plane_d_;
};

}  // namespace fransac
