// SPDX-License-Identifier: Apache-2.0
/// Depth images without their camera's smooth distortion.
#pragma once

#include <cstdint>

#include "fransac/core/aligned.hpp"
#include "fransac/core/depth_image.hpp"
#include "fransac/core/distortion.hpp"
#include "fransac/core/result.hpp"

namespace fransac {

/// Memory of a corrected depth image, kept from one frame to the next.
struct CorrectedDepth {
  AlignedVector<std::uint16_t> units;  ///< Of a uint16 image.
  AlignedVector<float> metres;         ///< Of a float32 image.
  DepthView view;                      ///< The corrected image, of the original's format and scale, in this memory.
};

/// Makes a copy of a uint16 image in which the raw value `saturated` is 0, no measurement, if the image holds it: whether it
/// does. 0 as `saturated`, and float32 images: never.
bool without_saturated(const DepthView& depth, int saturated, CorrectedDepth& result);

/// Corrects every measured pixel: z becomes z / (1 + b + a z), the inverse of q + a + b q; no pixel by more than a factor of 2.
/// What is no measurement stays as it is, and so does the raw value `saturated` of uint16 depth (0: there is none). uint16 depth
/// is rounded to whole units again. invalid_argument: the distortion, or its shape (check_shape). `depth` must be valid.
Status correct(const DepthView& depth, const Distortion& distortion, int saturated, CorrectedDepth& result);

}  // namespace fransac
