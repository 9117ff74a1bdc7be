// SPDX-License-Identifier: Apache-2.0
/// Depth images of lenses with distortion: from rays by table to an ideal pinhole and back.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "fransac/core/camera.hpp"
#include "fransac/core/depth_image.hpp"
#include "fransac/core/result.hpp"

namespace fransac {

/// Where each pixel looks: the point (x, y, 1) of its ray in the optical frame (x right, y down, z forward). A pixel of depth z
/// measures the point z (x, y, 1). Not finite: the pixel has no ray.
struct RayTable {
  int width = 0;         ///< Columns, pixels.
  int height = 0;        ///< Rows, pixels.
  std::vector<float> x;  ///< width * height values, row by row.
  std::vector<float> y;  ///< Likewise.
};

/// Which pixel of the one image is which of the other. Depends on lens and camera only: made once, used for every frame.
struct RayMap {
  static constexpr std::uint32_t kNone = 0xFFFFFFFF;  ///< No pixel.

  Camera ideal;                         ///< The pinhole.
  int width = 0;                        ///< Of the original image.
  int height = 0;                       ///< Of the original image.
  std::vector<std::uint32_t> original;  ///< Of each ideal pixel: the original pixel whose ray is nearest to its own; kNone: none.
  std::vector<std::uint32_t> projected;  ///< Of each original pixel: the ideal pixel that its ray meets; kNone: none.
};

/// `ideal` is the pinhole to work with: commonly the lens's own focal lengths without the distortion terms, and an image large
/// enough for the rays at the borders. Between rays of neighbouring pixels the map has no holes, however far apart the ideal
/// camera has them (up to 16 of its pixels; beyond that the table has a step there). invalid_argument names what is wrong with
/// the table or the camera.
Result<RayMap> ray_map(const RayTable& rays, const Camera& ideal);

/// The depth that the ideal pinhole sees, in metres, 0 where nothing was measured: z of the pixel with the nearest ray. So no
/// depth is invented, and points move sideways by half a pixel at most. Reuses the memory of `metres`.
Status undistort(const DepthView& depth, const RayMap& map, std::vector<float>& metres);

/// Labels of the ideal image on the original pixels: kLabelNoDepth where `depth`, the original image, has none, kLabelNoPlane
/// where the ideal image does not see the pixel's ray or holds no depth there. `labels` has a value per original pixel.
Status labels_to_original(const DepthView& depth, const RayMap& map, std::span<const std::uint8_t> ideal_labels,
                          std::span<std::uint8_t> labels);

}  // namespace fransac
