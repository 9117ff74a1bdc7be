// SPDX-License-Identifier: Apache-2.0
/// Pictures of a frame: depth, cloud, differences from the truth.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "fransac/core/camera.hpp"
#include "fransac/core/depth_image.hpp"
#include "fransac/io/image.hpp"
#include "fransac/io/overlay.hpp"
#include "html.hpp"

namespace fransac::cli::report {

/// Colours of difference_picture. Missed and false are orange and blue of Okabe and Ito, "Color Universal Design" (2008).
inline constexpr Colour kHitColour{206, 206, 206};   ///< On the plane, and found.
inline constexpr Colour kRestColour{92, 92, 92};     ///< Not on it, and not taken for it.
inline constexpr Colour kMissedColour{230, 159, 0};  ///< On the plane, not found.
inline constexpr Colour kFalseColour{0, 114, 178};   ///< Not on it, taken for it.
inline constexpr Colour kNothingColour{16, 16, 20};  ///< No depth, or not judged; as io::overlay has it.

/// The colour of a depth: 0 nearest, 1 farthest.
Colour depth_colour(double share);
io::ColourImage depth_picture(const DepthView& depth, const io::DepthRange& range);

/// The deprojected points seen from beside and above the camera, in the colours of their labels; `width` pixels wide.
/// Empty where nothing was measured.
io::ColourImage cloud_picture(const DepthView& depth, const Camera& camera, std::span<const std::uint8_t> labels, int width);

/// Where the first judged plane of the prediction and label 1 of the truth differ.
io::ColourImage difference_picture(std::span<const std::uint8_t> truth, std::span<const std::uint8_t> predicted, int width);

/// The predicted labels, each renamed to the true plane that most of it lies on (every true plane once, the larger plane
/// first), else to a label the truth does not have: the same colour then means the same plane.
std::vector<std::uint8_t> named_like(std::span<const std::uint8_t> truth, std::span<const std::uint8_t> predicted);

/// A picture for a page, `width` pixels wide at most. Throws Failure.
Picture picture(const std::string& title, const std::string& alt, const std::string& note, io::ColourImage image, int width);

/// Box-filtered down to `width`; pictures that are no wider stay as they are.
io::ColourImage shrunk(io::ColourImage image, int width);

}  // namespace fransac::cli::report
