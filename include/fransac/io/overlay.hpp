// SPDX-License-Identifier: Apache-2.0
/// Pictures of a segmentation.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>

#include "fransac/core/depth_image.hpp"
#include "fransac/io/image.hpp"

namespace fransac::io {

/// Distinct colours for labels 1, 2, …; the same label always has the same colour. Grey for no plane and no depth.
std::array<std::uint8_t, 3> label_colour(std::uint8_t label);

/// Distances that a picture of depth spans: all but the nearest and the farthest hundredth of the pixels. Zeros when nothing
/// was measured.
struct DepthRange {
  float nearest_m = 0.0F;   ///< Metres.
  float farthest_m = 0.0F;  ///< Metres.
};
/// See DepthRange.
DepthRange depth_range(const DepthView& depth);

/// Planes in colour (blended, with their borders drawn full) over the colour picture when it is given and has the same
/// size, else over the depth image shaded by distance. Pixels without depth are dark. One label per pixel; an empty picture for
/// any other number.
ColourImage overlay(const DepthView& depth, std::span<const std::uint8_t> labels, const ColourImage* background);

/// Writes each plane's number where the plane is widest; where it would not fit into the plane it is left out. One label per
/// pixel of the picture; nothing is written for any other number.
void number_planes(ColourImage& picture, std::span<const std::uint8_t> labels);

}  // namespace fransac::io
