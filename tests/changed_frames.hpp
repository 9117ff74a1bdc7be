// SPDX-License-Identifier: Apache-2.0
/// Frames changed in ways that must not matter: another resolution, other units, holes, values that are no measurements.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "fransac/core/camera.hpp"
#include "fransac/core/depth_image.hpp"

namespace fransac::testing {

/// A changed copy of a frame and of its truth. A pixel that lost its measurement, or whose depth is no longer its surface's, has
/// truth 0 (not to be judged); what is judged is the rest.
struct ChangedFrame {
  std::string kind;                   ///< What was changed, in words: one of changes().
  Camera camera;                      ///< Of the changed image.
  std::vector<std::uint16_t> depth;   ///< Raw units of `camera`; 0 is no measurement.
  std::vector<std::uint8_t> labels;   ///< Truth as in the frames format: 0 not to be judged, 255 on no plane.
  std::vector<float> metres;          ///< Empty, or depth in floats, which then stands for `depth`.
  std::vector<std::uint32_t> source;  ///< The pixel of the unchanged image (v * width + u) that each pixel shows.

  /// `metres` where there are any, else `depth`. Valid while this is not changed.
  [[nodiscard]] DepthView view() const;
};

/// Which family a change belongs to.
enum class ChangeFamily {
  missing,    ///< Pixels without a measurement.
  saturated,  ///< A region at the largest raw value, 65535.
  constant,   ///< A region, or all that is far, at one valid value.
  enlarged,   ///< More pixels than were measured.
  fewer,      ///< Fewer pixels.
  values,     ///< Other steps and units of the same depth.
  mirrored,   ///< Left and right swapped.
  combined,   ///< Two of these.
};

/// One way of changing a frame.
struct Change {
  std::string kind;     ///< Its name, for example "missing 25 %".
  ChangeFamily family;  ///< See ChangeFamily.
  int enlargement = 1;  ///< Sides of the changed image by those of the original; 1 where they are not longer.
  int step = 1;         ///< Every how many-th pixel of a row and of a column is kept.
};

/// All changes, in the order of changed_frames().
std::span<const Change> changes();

/// What a change makes of a frame. `depth` and `labels` are camera.width * camera.height values, row by row. An empty copy (no
/// pixels) where the change means nothing to the frame: a constant that its unit cannot hold, a unit that it has already, an
/// image that would be larger than 4096 x 3072.
ChangedFrame changed_frame(const Change& change, const Camera& camera, std::span<const std::uint16_t> depth,
                           std::span<const std::uint8_t> labels);

/// The copies of all changes, without the empty ones. Of a frame of 640 x 480 they take about 120 MB; changed_frame() makes one
/// at a time.
std::vector<ChangedFrame> changed_frames(const Camera& camera, std::span<const std::uint16_t> depth,
                                         std::span<const std::uint8_t> labels);

/// The frame itself, as a copy whose kind is "unchanged".
ChangedFrame unchanged_frame(const Camera& camera, std::span<const std::uint16_t> depth, std::span<const std::uint8_t> labels);

}  // namespace fransac::testing
