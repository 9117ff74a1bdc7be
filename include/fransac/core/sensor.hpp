// SPDX-License-Identifier: Apache-2.0
/// How precisely a depth camera measures.
#pragma once

#include <optional>
#include <string_view>

#include "fransac/core/camera.hpp"
#include "fransac/core/distortion.hpp"
#include "fransac/core/enum_names.hpp"
#include "fransac/core/result.hpp"

namespace fransac {

/// How a sensor measures depth.
enum class SensorKind {
  automatic,         ///< Noise estimated from the frame itself.
  structured_light,  ///< Kinect v1, Xtion, PrimeSense: sigma_z grows with z^2.
  stereo,            ///< Passive or active stereo, RealSense: sigma_z = z^2 * disparity error / (f b).
  time_of_flight,    ///< Kinect v2, Azure Kinect, phones: constant, plus a share of the distance.
  none,              ///< Exact or rendered depth: the step of the raw unit only.
};

template <>
struct EnumNames<SensorKind> {
  static constexpr std::string_view values[] = {"auto", "structured-light", "stereo", "tof", "none"};
};

/// What a user knows of the sensor. What is unset follows from the kind.
struct SensorOptions {
  SensorKind kind = SensorKind::automatic;     ///< How it measures.
  std::optional<double> baseline_m{};          ///< Structured light and stereo: between projector or cameras.
  std::optional<double> disparity_error_px{};  ///< Structured light and stereo: one sigma of the disparity.
  // The law of the pixel noise, DepthNoise; any but `automatic`. Each replaces that term of the kind's own law.
  std::optional<double> constant_m{};       ///< Part of sigma_z that does not depend on the distance, metres.
  std::optional<double> linear{};           ///< Part of sigma_z per metre of distance.
  std::optional<double> quadratic_per_m{};  ///< Part of sigma_z per squared metre of distance, instead of what baseline and
                                            ///< disparity error make.
  std::optional<double> slow{};             ///< Any: SensorModel::slow.
  std::optional<double> bias_m{};           ///< Any: SensorModel::bias_m.
  Distortion distortion{};                  ///< Depth images are corrected by it before anything is looked for; point clouds are
                                            ///< not.
};

/// What a user can say of a sensor in one number.
struct SensorParameter {
  std::string_view name{};     ///< In words joined by "-".
  std::string_view unit{};     ///< "m", "px", "m per m", "m per m^2" or "share".
  std::string_view help{};     ///< A few words.
  double min = 0.0;            ///< Smallest valid number.
  double max = 0.0;            ///< Largest valid number.
  bool triangulation = false;  ///< Means something to structured light and stereo.
  bool named = false;          ///< Means something to every kind but `automatic`.
  bool any = false;            ///< Means something to every kind.

  /// Whether a sensor of this kind has such a number.
  [[nodiscard]] constexpr bool means_something_to(SensorKind kind) const {
    const bool triangulates = kind == SensorKind::structured_light || kind == SensorKind::stereo;
    return any || (triangulation && triangulates) || (named && kind != SensorKind::automatic);
  }
};

/// Calls visit(parameter, value&…) for every number of one or more sensors; the one list of their names, units and ranges.
template <class Visitor, class... Options>
void for_each_parameter_of(Visitor&& visit, Options&... o) {
  visit(SensorParameter{.name = "baseline",
                        .unit = "m",
                        .help = "between projector and camera, or between two cameras",
                        .min = 0.001,
                        .max = 10.0,
                        .triangulation = true},
        o.baseline_m...);
  visit(
      SensorParameter{
          .name = "disparity-error", .unit = "px", .help = "one sigma of the disparity", .max = 10.0, .triangulation = true},
      o.disparity_error_px...);
  visit(
      SensorParameter{
          .name = "constant", .unit = "m", .help = "part of one sigma of the depth at any distance", .max = 1.0, .named = true},
      o.constant_m...);
  visit(SensorParameter{.name = "linear",
                        .unit = "m per m",
                        .help = "part of one sigma of the depth per metre of distance",
                        .max = 1.0,
                        .named = true},
        o.linear...);
  visit(SensorParameter{.name = "quadratic",
                        .unit = "m per m^2",
                        .help = "part of one sigma of the depth per squared metre of distance",
                        .max = 1.0,
                        .named = true},
        o.quadratic_per_m...);
  visit(SensorParameter{.name = "slow",
                        .unit = "share",
                        .help = "one sigma of what pixels near each other share, of that of a pixel",
                        .max = 10.0,
                        .any = true},
        o.slow...);
  visit(
      SensorParameter{.name = "bias", .unit = "m", .help = "by how much planes may be bent or shifted", .max = 1.0, .any = true},
      o.bias_m...);
}

/// Calls visit(parameter, value&) for every number of a sensor.
template <class Options, class Visitor>
void for_each_parameter(Options& o, Visitor&& visit) {
  for_each_parameter_of(visit, o);
}

/// Checks every range, the distortion, and that no number is given that means nothing to the kind. The message names the
/// parameter.
Status validate(const SensorOptions& options);

/// Of a Kinect v1, sigma_z = kKinectNoise_per_m z^2: Khoshelham & Elberink, "Accuracy and resolution of Kinect depth data for
/// indoor mapping applications", Sensors 12(2), 2012.
inline constexpr double kKinectNoise_per_m = 1.425e-3;

/// One standard deviation of a depth z: sigma_z(z)^2 = constant^2 + (linear z)^2 + (quadratic z^2)^2.
struct DepthNoise {
  double constant_m = 0.0;       ///< Metres, at any distance.
  double linear = 0.0;           ///< Metres per metre of distance.
  double quadratic_per_m = 0.0;  ///< Metres per square metre of distance.

  [[nodiscard]] double sigma_m(double z_m) const;  ///< One standard deviation of a depth of z metres, metres.
  bool operator==(const DepthNoise&) const = default;
};

/// What `cells` believes of a sensor: three errors that have nothing to do with each other.
struct SensorModel {
  SensorKind kind = SensorKind::automatic;  ///< How it measures.
  DepthNoise noise;                         ///< Pixel noise, independent from pixel to pixel. `automatic`: the largest believed.
  double slow = 0.0;    ///< Slow noise: one sigma of what pixels near each other share, over tens of pixels, as a share of the
                        ///< pixel noise.
  double bias_m = 0.0;  ///< Bias: by how much a plane may be bent or shifted over the image, smoothly and the same in every
                        ///< frame, metres.

  /// One standard deviation of the slow noise at each depth.
  [[nodiscard]] DepthNoise slow_noise() const {
    return {slow * noise.constant_m, slow * noise.linear, slow * noise.quadratic_per_m};
  }

  bool operator==(const SensorModel&) const = default;
};

/// The model of a sensor behind `camera`, whose raw unit is `metres_per_unit` (its rounding counts as noise; 0 to 1, 0 for depth
/// in floats). invalid_argument where a number is out of range or means nothing to this kind; the message names it.
Result<SensorModel> sensor_model(const SensorOptions& options, const Camera& camera, double metres_per_unit);

}  // namespace fransac
