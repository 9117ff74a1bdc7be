// SPDX-License-Identifier: Apache-2.0
#include "synth/sensors.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <numbers>

#include "fransac/core/random.hpp"
#include "synth/scenes.hpp"

namespace fransac::synth::detail {
namespace {

using Eigen::Vector3d;

std::size_t index(int i) { return static_cast<std::size_t>(i); }
std::size_t pixel_count(const Camera& camera) { return index(camera.width) * index(camera.height); }

struct Shot {
  const Scene& scene;
  const Camera& camera;
  const Raster& raster;
  std::uint64_t seed;
  int frame;

  [[nodiscard]] RandomStream stream(Purpose purpose, int row) const { return {seed, stream_index(purpose, frame, row)}; }
  [[nodiscard]] const Material& material(std::size_t i) const { return scene.primitives[index(raster.primitive[i])].material; }
};

// Calls body(u, v, pixel) for every pixel whose ray meets something between two depths.
template <class Body>
void for_each_hit(const Shot& shot, double nearest, double farthest, Body body) {
  for (int v = 0; v < shot.camera.height; ++v) {
    for (int u = 0; u < shot.camera.width; ++u) {
      const std::size_t i = index(v) * index(shot.camera.width) + index(u);
      const double z = shot.raster.depth_m[i];
      if (z > 0.0 && z >= nearest && z <= farthest) body(u, v, i);
    }
  }
}

// Standard normal noise, one value per pixel, correlated as the mean over a window x window neighbourhood is: the mean of
// w^2 independent values times w has variance 1, and two pixels (du, dv) apart have correlation (1 - |du|/w)(1 - |dv|/w).
std::vector<float> window_noise(const Shot& shot, Purpose purpose, int window) {
  const int width = shot.camera.width;
  const int height = shot.camera.height;
  std::vector<float> field(pixel_count(shot.camera), 0.0F);
  std::vector<float> row(index(width));
  std::vector<double> white(index(width + window - 1));
  for (int y = 0; y < height + window - 1; ++y) {
    RandomStream stream = shot.stream(purpose, y);
    for (double& value : white) value = stream.normal();
    for (int u = 0; u < width; ++u) {
      double sum = 0.0;
      for (int k = 0; k < window; ++k) sum += white[index(u + k)];
      row[index(u)] = static_cast<float>(sum / window);
    }
    for (int v = std::max(0, y - window + 1); v <= std::min(y, height - 1); ++v) {
      for (int u = 0; u < width; ++u) field[index(v) * index(width) + index(u)] += row[index(u)];
    }
  }
  return field;
}

double normal_cdf(double x) { return 0.5 * std::erfc(-x / std::numbers::sqrt2); }

constexpr int kHoleWindow_px = 11;  // holes come in blotches, not as single pixels

double grey(const Vector3d& colour) { return 0.299 * colour.x() + 0.587 * colour.y() + 0.114 * colour.z(); }

// Structured light, Kinect v1 (Khoshelham & Elberink, "Accuracy and resolution of Kinect depth data for indoor mapping
// applications", Sensors 12(2), 2012). Disparity d = f b / z is measured in steps of 1/8 pixel, so depth lies on
// z = f b / d. The paper's random error, sigma_z = 1.425e-3 z^2 (half a step), is what a plane fit sees, rounding
// included: rounding to a step s contributes s^2 / 12, Gaussian noise before it the rest.
// That noise is common to pixels that share a matching window: 9x9 or 9x7 pixels (Konolige & Mihelich, "Technical description of
// Kinect calibration", ROS wiki). In real frames the residuals of small patches of planes correlate as the mean over 7x7
// independent values does, plus a part of 0.015 px that fades over some 40 pixels (docs/algorithms.md has what was measured).
// A point that the projector, 7.5 cm to the camera's right, does not see has no depth; so do surfaces at grazing angles, on
// which noise rises steeply (Nguyen, Izadi & Lovell, "Modeling Kinect sensor noise for improved 3D reconstruction and
// tracking", 2012): from 75 degrees on more and more, beyond 85 all; the two angles are our choice.
Measurement measure_kinect1(const Shot& shot) {
  constexpr double kSigma_px = kinect1::kSigma * kinect1::kFocalBaseline;
  const double sigma_px =
      std::sqrt(kSigma_px * kSigma_px - kinect1::kStep_px * kinect1::kStep_px / 12.0 - kinect1::kDrift_px * kinect1::kDrift_px);
  constexpr double kGrazing = 75.0;
  constexpr double kBlind = 85.0;

  Measurement result{std::vector<double>(pixel_count(shot.camera)), {}};
  const std::vector<float> holes = window_noise(shot, Purpose::holes, kHoleWindow_px);
  const std::vector<float> noise = window_noise(shot, Purpose::noise, kinect1::kWindow_px);
  const std::vector<float> drift = window_noise(shot, Purpose::drift, kinect1::kDriftWindow_px);
  const RayCaster projector(shot.scene, {kinect1::kBaseline_m, 0.0, 0.0});
  for_each_hit(shot, kinect1::kNearest_m, kinect1::kFarthest_m, [&](int u, int v, std::size_t i) {
    const double angle = std::acos(std::min(1.0, static_cast<double>(shot.raster.cosine[i]))) * 180.0 / std::numbers::pi;
    if (angle > kGrazing && normal_cdf(static_cast<double>(holes[i])) < (angle - kGrazing) / (kBlind - kGrazing)) return;
    const double z = shot.raster.depth_m[i];
    if (projector.blocked(z * pixel_ray(shot.camera, u, v))) return;
    const double error_px = sigma_px * static_cast<double>(noise[i]) + kinect1::kDrift_px * static_cast<double>(drift[i]);
    const double disparity = kinect1::kFocalBaseline / z + error_px;
    const double measured = kinect1::kFocalBaseline / (kinect1::kStep_px * std::round(disparity / kinect1::kStep_px));
    if (measured >= kinect1::kNearest_m && measured <= kinect1::kFarthest_m) result.depth_m[i] = measured;
  });
  return result;
}

// Stereo with the camera as the left eye, in the manner of a RealSense D435 (Keselman et al., "Intel RealSense stereoscopic
// depth cameras", CVPR workshops 2017): d = f b / z, sigma_z = z^2 / (f b) sigma_d, the disparity's error being common to
// pixels that share a matching window. No depth where the right eye does not see the point (hidden, or to the left of
// its image) and where the matcher finds too little texture: of a surface with texture t, a share (1 - t)^2, in blotches.
Measurement measure_stereo(const Shot& shot) {
  const double focal_baseline = shot.camera.fx * stereo::kBaseline_m;
  Measurement result{std::vector<double>(pixel_count(shot.camera)), {}};
  const std::vector<float> error = window_noise(shot, Purpose::matching, stereo::kWindow_px);
  const std::vector<float> holes = window_noise(shot, Purpose::holes, kHoleWindow_px);
  const RayCaster right_eye(shot.scene, {stereo::kBaseline_m, 0.0, 0.0});
  for_each_hit(shot, stereo::kNearest_m, stereo::kFarthest_m, [&](int u, int v, std::size_t i) {
    const double z = shot.raster.depth_m[i];
    const double disparity = focal_baseline / z;
    if (u - disparity < 0.0) return;
    const double blank = 1.0 - shot.material(i).texture;
    if (normal_cdf(static_cast<double>(holes[i])) < blank * blank) return;
    if (right_eye.blocked(z * pixel_ray(shot.camera, u, v))) return;
    const double seen = disparity + stereo::kSigma_px * static_cast<double>(error[i]);
    if (seen <= 0.0) return;
    const double measured = focal_baseline / seen;
    if (measured >= stereo::kNearest_m && measured <= stereo::kFarthest_m) result.depth_m[i] = measured;
  });
  return result;
}

// Continuous-wave time of flight (Hansard, Lee, Choi & Horaud, "Time-of-Flight Cameras", 2012, chapter 1). A pixel sums
// the phasors A exp(i 4 pi f R / c) of what its optics blur together, A = albedo cos(incidence) / R^2; the phase of the sum
// is its range: at edges that lies between the surfaces, a "flying" pixel. Blur: the binomial weights (1 2 1)/4 of the 3 x 3
// neighbours. Noise in range falls with amplitude as in range_sigma(). No measurement beyond the range limit or in the dark.
Measurement measure_tof(const Shot& shot) {
  constexpr double kSpeedOfLight = 299792458.0;
  constexpr double kPhasePerMetre = 4.0 * std::numbers::pi * tof::kModulation_hz / kSpeedOfLight;
  constexpr std::array<double, 3> kBlur{0.25, 0.5, 0.25};
  const int width = shot.camera.width;
  const int height = shot.camera.height;
  const auto ray_length = [&](int u, int v) { return pixel_ray(shot.camera, u, v).norm(); };

  std::vector<std::complex<double>> phasors(pixel_count(shot.camera));
  for_each_hit(shot, 0.0, kMiss, [&](int u, int v, std::size_t i) {
    const double range = shot.raster.depth_m[i] * ray_length(u, v);
    const double amplitude = grey(shot.material(i).colour) * static_cast<double>(shot.raster.cosine[i]) / (range * range);
    phasors[i] = std::polar(amplitude, kPhasePerMetre * range);
  });
  Measurement result{std::vector<double>(phasors.size()), std::vector<std::uint8_t>(phasors.size())};
  RandomStream stream = shot.stream(Purpose::noise, 0);
  int row = 0;
  for_each_hit(shot, 0.0, kMiss, [&](int u, int v, std::size_t i) {
    if (row != v) {
      stream = shot.stream(Purpose::noise, v);
      row = v;
    }
    const double noise = stream.normal();
    const double exact = shot.raster.depth_m[i] * ray_length(u, v);
    if (exact > tof::kFarthest_m) return;
    std::complex<double> sum;
    for (int dv = -1; dv <= 1; ++dv) {
      for (int du = -1; du <= 1; ++du) {
        const std::size_t n = index(std::clamp(v + dv, 0, height - 1)) * index(width) + index(std::clamp(u + du, 0, width - 1));
        sum += kBlur[index(du + 1)] * kBlur[index(dv + 1)] * phasors[n];
      }
    }
    const double amplitude = std::abs(sum);
    if (amplitude < tof::kDarkest) return;
    // The phase relative to the ray's own surface does not wrap around.
    const double shift = std::arg(sum * std::polar(1.0, -kPhasePerMetre * exact)) / kPhasePerMetre;
    const double sigma = tof::range_sigma(amplitude);
    result.mixed[i] = std::abs(shift) > sigma ? 1 : 0;
    result.depth_m[i] = std::max(0.0, exact + shift + sigma * noise) / ray_length(u, v);
  });
  return result;
}

}  // namespace

// sigma_R = k sqrt(B + A) / A: shot noise of signal and background light against the signal (Lange & Seitz, "Solid-state
// time-of-flight range camera", IEEE J. Quantum Electronics 37(3), 2001). k and the background are set for about 1 mm at
// 1 m and 6 mm at 4 m on a bright wall.
double tof::range_sigma(double amplitude) { return kSigma_m * std::sqrt(amplitude + kBackground) / amplitude; }

Raster rasterise(const Scene& scene, const Camera& camera) {
  const std::size_t n = pixel_count(camera);
  Raster raster{std::vector<double>(n), std::vector<int>(n, -1), std::vector<int>(n, -1), std::vector<float>(n)};
  const RayCaster eye(scene, Vector3d::Zero());
  std::size_t i = 0;
  for (int v = 0; v < camera.height; ++v) {
    for (int u = 0; u < camera.width; ++u, ++i) {
      const Vector3d ray = pixel_ray(camera, u, v);
      const Hit hit = eye.cast(ray);
      if (hit.primitive < 0) continue;
      const Primitive& primitive = scene.primitives[index(hit.primitive)];
      raster.depth_m[i] = hit.t;
      raster.primitive[i] = hit.primitive;
      raster.face[i] = primitive.first_face + hit.face;
      raster.cosine[i] = static_cast<float>(std::abs(surface_normal(primitive, hit.face, hit.t * ray).dot(ray)) / ray.norm());
    }
  }
  return raster;
}

Measurement measure(Sensor sensor, const Scene& scene, const Camera& camera, const Raster& raster, std::uint64_t seed,
                    int frame) {
  const Shot shot{scene, camera, raster, seed, frame};
  switch (sensor) {
    case Sensor::none: return {raster.depth_m, {}};
    case Sensor::kinect1: return measure_kinect1(shot);
    case Sensor::stereo: return measure_stereo(shot);
    case Sensor::tof: return measure_tof(shot);
  }
  return {};
}

}  // namespace fransac::synth::detail
