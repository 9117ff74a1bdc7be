// SPDX-License-Identifier: Apache-2.0
/// The colour picture of a scene.
#pragma once

#include <cstdint>
#include <vector>

#include "fransac/core/camera.hpp"
#include "synth/geometry.hpp"
#include "synth/sensors.hpp"

namespace fransac::synth::detail {

/// Red, green, blue per pixel: Lambert's law with one lamp and its shadows, light from above as ambient; four samples
/// where neighbouring pixels see different faces or a pattern. `scene` is in the camera's frame.
std::vector<std::uint8_t> paint(const Scene& scene, const Camera& camera, const Raster& raster);

}  // namespace fransac::synth::detail
