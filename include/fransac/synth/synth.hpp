// SPDX-License-Identifier: Apache-2.0
/// Rendered scenes with exact truth.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "fransac/core/camera.hpp"
#include "fransac/core/plane.hpp"
#include "fransac/core/result.hpp"

namespace fransac::synth {

/// How depth is measured.
enum class Sensor {
  none,     ///< Exact depth.
  kinect1,  ///< Structured light: disparity quantisation, Khoshelham & Elberink 2012, shadow of the projector, grazing angles.
  stereo,   ///< Passive or active stereo: sigma_z = z^2 / (f b) * sigma_d, with sub-pixel error correlated over a matching window.
  tof,      ///< Time of flight: sigma grows with distance and with darkness; mixed ("flying") pixels at edges.
};

struct SynthOptions {
  std::string scene = "desk";          ///< One of scene_names().
  Sensor sensor = Sensor::kinect1;
  std::uint64_t seed = 0;
  int frame = 0;                       ///< Frames of one seed see the same kind of scene from moving viewpoints with varying objects.
  Camera camera{640, 480, 525.0, 525.0, 319.5, 239.5, 5000.0};
};

struct SynthFrame {
  Camera camera;
  std::vector<std::uint16_t> depth;         ///< Raw units; 0 where nothing was measured.
  std::vector<float> exact_depth_m;         ///< Noise-free z, metres; 0 where the ray hits nothing.
  std::vector<std::uint8_t> labels;         ///< Frames format: 0 no depth, 1 dominant plane (most square metres visible), 2 … the others, 255 on no plane.
  std::vector<std::uint8_t> colour;         ///< A shaded picture, 3 channels.
  std::vector<std::pair<int, Plane>> true_planes;  ///< Exact coefficients per label.
};

/// "empty_room", "desk", "stairs", "corridor", "kerb", "office".
std::span<const std::string_view> scene_names();

/// Renders one frame. invalid_argument for an unknown scene, a bad camera or a negative frame number.
Result<SynthFrame> render(const SynthOptions& options);

}  // namespace fransac::synth
