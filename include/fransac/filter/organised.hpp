// SPDX-License-Identifier: Apache-2.0
/// Organised point cloud to depth image: deprojection undone.
#pragma once

#include <vector>

#include "fransac/core/camera.hpp"
#include "fransac/core/depth_image.hpp"
#include "fransac/core/point_cloud.hpp"
#include "fransac/core/result.hpp"

namespace fransac {

/// The depth image that an organised cloud was made from. It owns its pixels.
struct OrganisedDepth {
  Camera camera;              ///< Its size is the cloud's.
  std::vector<float> metres;  ///< z of each point, row by row; 0 where nothing was measured (see PointCloud::measured).
  double rms_px = 0.0;        ///< Root mean square distance of the projected points to their pixels.
  double max_px = 0.0;        ///< The largest one, along a row or a column.

  /// `metres` as an image; valid while this is not changed.
  [[nodiscard]] DepthView view() const { return DepthView::from_float(metres.data(), camera.width, camera.height); }
};

/// Recovers the intrinsics of an organised cloud by least squares, x = z (u - cx) / fx and y = z (v - cy) / fy over all measured
/// points, and its depth image. Point v * width + u of the cloud is pixel (u, v), so labels of the one are labels of the other,
/// and planes are in the same coordinates. Reuses the memory of `out`.
///
/// The cloud must be in the optical frame of the camera that took it (x right, y down, z forward), and every point must project
/// to its own pixel: to within half a pixel of its centre. A cropped image is a camera with another principal point. Lens
/// distortion of more than half a pixel, clouds of laser scanners, parallel projections and clouds that were moved to another
/// frame are refused (unsupported), and so is a cloud with an origin: the camera stands at (0, 0, 0).
Status organised_depth(const PointCloud& cloud, OrganisedDepth& out);

}  // namespace fransac
