// SPDX-License-Identifier: Apache-2.0
/// Depth image to point cloud.
#pragma once

#include "fransac/core/camera.hpp"
#include "fransac/core/depth_image.hpp"
#include "fransac/core/point_cloud.hpp"

namespace fransac {

/// p = z * ((u - cx) / fx, (v - cy) / fy, 1) for every measured pixel, in row order. `cloud.source` names the pixel
/// (v * width + u). Pixels without depth give no point at all.
/// Expects a valid view and camera of the same size. Reuses the cloud's memory.
void deproject(const DepthView& depth, const Camera& camera, PointCloud& cloud);

}  // namespace fransac
