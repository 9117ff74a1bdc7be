// SPDX-License-Identifier: Apache-2.0
/// What obstacles of depth images and of clouds have in common: what they stand on, and what planes they show.
#pragma once

#include <cstdint>
#include <vector>

#include "core/index.hpp"
#include "fransac/core/result.hpp"
#include "fransac/filter/correct.hpp"
#include "fransac/obstacles/obstacles.hpp"
#include "obstacles/footprint.hpp"

namespace fransac::obstacles {

/// More would be noise.
inline constexpr int kMostObjects = 4095;

/// That the view, the camera and the segmentation are of one image.
Status check_sizes(const DepthView& depth, const Camera& camera, const Segmentation& segmentation);

/// The depth image as the segmentation's planes are in: corrected, in `buffer`, where that was.
Status as_segmented(const DepthView& depth, const Segmentation& segmentation, CorrectedDepth& buffer, DepthView& view);

/// Fills the result's support, the reason and the doubt; the support's first plane is the one that counts.
void choose_support(const Segmentation& segmentation, const ObstacleOptions& options, const DepthNoise& noise, Obstacles& result);

/// Tells an obstacle's planes, and whether it is one. `on_plane`: how many of its pixels or points have each label.
void name_planes(const std::uint32_t* on_plane, const Segmentation& segmentation, Obstacle& obstacle);

/// Sets an obstacle's box from what it covers and its heights.
void set_box(const Footprint& footprint, Obstacle& obstacle);

}  // namespace fransac::obstacles
