// SPDX-License-Identifier: Apache-2.0
/// The field that bends planes.
#pragma once

#include <cstddef>
#include <span>

#include "calibrate/windows.hpp"
#include "fransac/calibrate/calibrate.hpp"

namespace fransac::calibration {

struct Field {
  Distortion distortion;  ///< Empty: what some frames show does not correct others.
  std::size_t views = 0;  ///< Frames that do not see the same.
  Bend before;
  Bend after;
};

/// Fits the field to planes of images of this size. Planes are in the order of their frames.
Field fit_field(std::span<const PlaneWindows> planes, int width, int height, bool wanted);

}  // namespace fransac::calibration
