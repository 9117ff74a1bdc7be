// SPDX-License-Identifier: Apache-2.0
/// Windows of pixels that lie on one plane: what a calibration looks at.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "fransac/core/depth_image.hpp"
#include "fransac/planes/segment.hpp"

namespace fransac::calibration {

/// A square window's pixels about the plane through them.
struct Window {
  double x = 0.0;         ///< Mean place, -1 to 1 from border to border of the image.
  double y = 0.0;         ///< Likewise.
  double q = 0.0;         ///< Mean inverse depth, per metre.
  double variance = 0.0;  ///< Of inverse depth about a local plane, per square metre.
  int count = 0;          ///< Pixels.
  int row = 0;            ///< Of windows.
  int column = 0;         ///< Likewise.
};

/// A plane of a frame as windows, by rows and columns.
struct PlaneWindows {
  std::size_t frame = 0;
  std::vector<Window> windows;
  std::vector<std::int32_t> at;  ///< Which of `windows` is at row * columns + column; -1: none.
  int rows = 0;
  int columns = 0;

  /// The window at a place; null where there is none.
  [[nodiscard]] const Window* find(int row, int column) const {
    if (row < 0 || column < 0 || row >= rows || column >= columns) return nullptr;
    const std::int32_t i =
        at[static_cast<std::size_t>(row) * static_cast<std::size_t>(columns) + static_cast<std::size_t>(column)];
    return i < 0 ? nullptr : &windows[static_cast<std::size_t>(i)];
  }
};

/// Edge of a window, pixels: some eighty in a row, so that images of any size are looked at alike.
int window_side(int width);

/// Appends the planes of a frame with `min_share` of its windows or more. `depth` is as the sensor gave it, whatever was
/// segmented.
void collect_windows(const DepthView& depth, const Segmentation& found, std::size_t frame, double min_share,
                     std::vector<PlaneWindows>& planes);

}  // namespace fransac::calibration
