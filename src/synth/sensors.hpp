// SPDX-License-Identifier: Apache-2.0
/// What a depth sensor makes of a scene. Formulas and sources stand with the models in sensors.cc.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "fransac/core/camera.hpp"
#include "fransac/core/sensor.hpp"
#include "fransac/synth/synth.hpp"
#include "synth/geometry.hpp"

namespace fransac::synth::detail {

/// What each pixel's ray meets, row by row.
struct Raster {
  std::vector<double> depth_m;  ///< 0 where the ray meets nothing.
  std::vector<int> primitive;   ///< -1 where the ray meets nothing.
  std::vector<int> face;        ///< Scene-wide number.
  std::vector<float> cosine;    ///< Of the angle between ray and surface normal.
};

/// The ray through a pixel, z = 1, so that its parameter is depth.
inline Eigen::Vector3d pixel_ray(const Camera& camera, double u, double v) {
  return {(u - camera.cx) / camera.fx, (v - camera.cy) / camera.fy, 1.0};
}

/// `scene` is in the camera's frame.
Raster rasterise(const Scene& scene, const Camera& camera);

struct Measurement {
  std::vector<double> depth_m;      ///< 0 where nothing was measured.
  std::vector<std::uint8_t> mixed;  ///< 1 where the depth blends several surfaces.
};

/// Noise is a function of seed, frame and pixel.
Measurement measure(Sensor sensor, const Scene& scene, const Camera& camera, const Raster& raster, std::uint64_t seed, int frame);

/// Constants that tests and documentation share.
namespace kinect1 {
inline constexpr double kFocalBaseline =
    580.0 * 0.075;                            ///< f b of the sensor, whatever the camera: nominal values, pixels times metres.
inline constexpr double kBaseline_m = 0.075;  ///< The projector stands this far along +x.
inline constexpr double kStep_px = 0.125;     ///< Disparities are multiples of 1/8 pixel.
inline constexpr double kSigma = kKinectNoise_per_m;
inline constexpr int kWindow_px = 7;        ///< Pixels this near share errors; see measure_kinect1().
inline constexpr double kDrift_px = 0.015;  ///< Part of the disparity's error that changes slowly over the image.
inline constexpr int kDriftWindow_px = 41;  ///< How slowly.
inline constexpr double kNearest_m = 0.5;
inline constexpr double kFarthest_m = 8.0;
}  // namespace kinect1

namespace stereo {
inline constexpr double kBaseline_m = 0.05;  ///< Of a RealSense D435.
inline constexpr double kSigma_px = 0.08;    ///< Sub-pixel error on well textured surfaces (Keselman et al. 2017).
inline constexpr int kWindow_px = 7;         ///< The matching window: errors of nearer pixels are correlated.
inline constexpr double kNearest_m = 0.2;
inline constexpr double kFarthest_m = 10.0;
}  // namespace stereo

namespace tof {
inline constexpr double kModulation_hz = 15e6;  ///< Unambiguous up to c / 2f = 10 m.
inline constexpr double kFarthest_m = 9.5;
inline constexpr double kSigma_m = 1e-3;     ///< See range_sigma().
inline constexpr double kBackground = 0.02;  ///< Ambient light, relative to the signal of a white surface at 1 m.
inline constexpr double kDarkest = 2e-3;     ///< No measurement below this amplitude.
/// Standard deviation of range for an amplitude relative to a white surface seen frontally at 1 m.
double range_sigma(double amplitude);
}  // namespace tof

}  // namespace fransac::synth::detail
