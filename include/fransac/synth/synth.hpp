// SPDX-License-Identifier: Apache-2.0
/// Rendered scenes with exact truth.
#pragma once

#include <Eigen/Geometry>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "fransac/core/camera.hpp"
#include "fransac/core/enum_names.hpp"
#include "fransac/core/plane.hpp"
#include "fransac/core/result.hpp"
#include "fransac/core/true_object.hpp"

namespace fransac::synth {

/// How depth is measured.
enum class Sensor {
  none,     ///< Exact depth.
  kinect1,  ///< Structured light: disparity quantisation, Khoshelham & Elberink 2012, shadow of the projector, grazing angles.
  stereo,  ///< Passive or active stereo: sigma_z = z^2 / (f b) * sigma_d, with sub-pixel error correlated over a matching window.
  tof,     ///< Time of flight: sigma grows with distance and with darkness; mixed ("flying") pixels at edges.
};

/// How the camera moves from frame to frame.
enum class Motion {
  sway,  ///< About 1 cm and a tremor of its own in each frame: views of one scene. Labels are ranked in each frame.
  walk,  ///< Carried on a smooth round through what the scene leaves free, 1 to 3 cm and 0.3 to 1 degree a frame. A label is the
         ///< same plane in all frames: 1 is the plane of which the round sees most square metres.
};

/// Which frame to render.
struct SynthOptions {
  std::string scene = "desk";       ///< One of scene_names().
  Sensor sensor = Sensor::kinect1;  ///< How depth is measured.
  std::uint64_t seed = 0;           ///< Another seed, another room: sizes, furniture, colours, the camera's place.
  int frame = 0;                    ///< Frames of one seed show the same scene from a moving camera.
  Motion motion = Motion::sway;     ///< How the camera moves from frame to frame.
  Camera camera{640, 480, 525.0, 525.0, 319.5, 239.5, 5000.0};  ///< A Kinect v1.
};

/// Truth is about what pixels measured. A planar face, or several coplanar ones of one thing (the floor left and right of a
/// table), is a plane with a label if at least kMinPlaneShare of the image are pixels whose kCoreWindow_px x kCoreWindow_px
/// neighbourhood sees that plane alone. Smaller faces and strips too narrow for that are planes, but nobody can judge them: 0.
/// Round things are 255. 0, too, where a time-of-flight pixel mixes surfaces by more than its noise.
inline constexpr double kMinPlaneShare = 0.002;
/// See kMinPlaneShare. Pixels.
inline constexpr int kCoreWindow_px = 5;

/// Largest frame that render() accepts, pixels.
inline constexpr std::size_t kMaxPixels = std::size_t{1} << 24;

/// Frames of a walk in a second: the time of frame i is i / kFrameRate_hz.
inline constexpr double kFrameRate_hz = 30.0;

/// The same field of view on another number of pixels.
Camera resized(Camera camera, int width, int height);

/// A rendered frame and its truth.
struct SynthFrame {
  Camera camera;                       ///< As asked for.
  std::vector<std::uint16_t> depth;    ///< Raw units; 0 where nothing was measured or the value would not fit.
  std::vector<float> exact_depth_m;    ///< Noise-free z, metres; 0 where the ray hits nothing.
  std::vector<std::uint8_t> labels;    ///< Frames format: 0 no depth or not to be judged, 1 dominant plane (most square metres
                                       ///< visible), 2 … the others, 255 on no plane.
  std::vector<std::uint16_t> objects;  ///< Which free-standing thing each pixel sees, the same numbers in all frames of a seed;
                                       ///< 0 the room, what things stand on (tables with their legs, stairs), or no depth.
  std::vector<std::uint8_t> colour;    ///< A shaded picture, 3 channels.
  std::vector<std::pair<int, Plane>> true_planes;  ///< Exact coefficients per label, in the camera's frame.
  std::vector<TrueObject> true_objects;            ///< The objects that are seen, whole, in the camera's frame; by id.
  Eigen::Isometry3d T_world_camera;                ///< p_world = T_world_camera * p_camera; the world's z is up.
};

/// "empty_room", "desk", "stairs", "corridor", "kerb", "office", "boxes" (steps of 2 to 4 cm on a desk), "hall" (a far floor,
/// walls at several depths), "curved" (no plane at all).
std::span<const std::string_view> scene_names();

/// Renders one frame: same options, same bytes. invalid_argument for an unknown scene, a bad or too large camera or a
/// negative frame number.
Result<SynthFrame> render(const SynthOptions& options);

}  // namespace fransac::synth

namespace fransac {

template <>
struct EnumNames<synth::Sensor> {
  static constexpr std::string_view values[] = {"none", "kinect1", "stereo", "tof"};
};
template <>
struct EnumNames<synth::Motion> {
  static constexpr std::string_view values[] = {"sway", "walk"};
};

}  // namespace fransac
