// SPDX-License-Identifier: Apache-2.0
/// The pinhole camera behind a depth image.
#pragma once

#include "fransac/core/result.hpp"

namespace fransac {

/// Pinhole intrinsics of a depth image. The camera frame is optical: x right, y down, z forward (ROS REP 103);
/// pixel (u, v) = (0, 0) is the centre of the top left pixel.
/// A pixel with depth z lies at z * ((u - cx) / fx, (v - cy) / fy, 1).
struct Camera {
  int width = 0;                ///< Columns, pixels.
  int height = 0;               ///< Rows, pixels.
  double fx = 0.0;              ///< Focal length along u, pixels.
  double fy = 0.0;              ///< Focal length along v, pixels.
  double cx = 0.0;              ///< Principal point, column, pixels.
  double cy = 0.0;              ///< Principal point, row, pixels.
  double depth_scale = 1000.0;  ///< Raw depth units per metre: metres = raw value / depth_scale.

  bool operator==(const Camera&) const = default;
};

/// Largest image side that the library accepts, pixels.
inline constexpr int kMaxImageSide = 1 << 15;

/// Checks that sizes are 1..kMaxImageSide, focal lengths 0.1 to 1e6 pixels, the principal point within 1e6 pixels of the
/// image's corner, and the scale 1 to 1e6 units per metre: beyond that a file has other units, or numbers of another meaning.
/// The message names the field.
Status validate(const Camera& camera);

}  // namespace fransac
