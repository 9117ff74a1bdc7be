// SPDX-License-Identifier: Apache-2.0
#include "fransac/core/sensor.hpp"

#include <cmath>
#include <string>

#include "core/caught.hpp"
#include "core/number_text.hpp"

namespace fransac {
namespace {

/// Khoshelham & Elberink, "Accuracy and resolution of Kinect depth data for indoor mapping applications", Sensors 12(2), 2012:
/// the random error is half a step of the disparity, sigma_z = 1.425e-3 z^2. With the nominal baseline of 7.5 cm and the steps of
/// 1/8 px that makes a focal length of 585 px (586 px as they calibrated it), which is the sensor's own whatever the camera's:
/// depth registered to colour has other intrinsics but the same noise.
namespace structured_light {
constexpr double kBaseline_m = 0.075;
constexpr double kDisparityError_px = 0.5 / 8.0;
constexpr double kFocalLength_px = kDisparityError_px / (kKinectNoise_per_m * kBaseline_m);
constexpr double kSlow = 1.0;     // cells of 8 x 8 pixels that are eight apart: docs/algorithms.md, "Noise from the frame"
constexpr double kBias_m = 0.01;  // uncorrected lenses bend planes by 1 to 2 cm at the borders, over most of the image less
}  // namespace structured_light

/// Keselman, Woodfill, Grunnet-Jepsen & Bhowmik, "Intel RealSense stereoscopic depth cameras", CVPR workshops 2017: the error of
/// the disparity does not depend on the distance, dz = z^2 / (f b) dd. Its size, for well textured surfaces, and the baseline are
/// those of a D435.
namespace stereo {
constexpr double kBaseline_m = 0.05;
constexpr double kDisparityError_px = 0.08;
constexpr double kSlow = 1.5;  // windows of matching are wider than a structured light's
constexpr double kBias_m = 0.005;
}  // namespace stereo

/// About 2 mm at 1 m and 6 mm at 4 m, as on a bright wall. Azure Kinect's makers promise at most 17 mm (and a systematic error
/// below 11 mm + 0.1 % of the distance, most of it common to a whole surface), which Tölgyessy, Dekan, Chovanec & Hubinský,
/// "Evaluation of the Azure Kinect and its comparison to Kinect v1 and Kinect v2", Sensors 21(2), 2021, confirm.
namespace time_of_flight {
constexpr double kConstant_m = 0.001;
constexpr double kLinear = 0.0015;
constexpr double kSlow = 0.5;  // every pixel measures for itself; what is shared comes from filters and from stray light
constexpr double kBias_m = 0.005;
}  // namespace time_of_flight

Error bad(std::string_view name, const std::string& what) {
  return {ErrorCode::invalid_argument, std::string(name) + ": " + what};
}

std::string range_text(double min, double max, std::string_view unit, double value) {
  return "must be between " + number_text(min) + " and " + number_text(max) + " " + std::string(unit) + ", is " +
         number_text(value);
}

Status check(const SensorParameter& parameter, SensorKind kind, double value) {
  if (!parameter.means_something_to(kind)) return bad(parameter.name, "means nothing to this kind of sensor");
  if (value >= parameter.min && value <= parameter.max) return {};  // false for NaN
  return bad(parameter.name, range_text(parameter.min, parameter.max, parameter.unit, value));
}

/// What is taken for granted of a kind of sensor. Without the rounding to raw units.
SensorModel usual_model(const SensorOptions& o, const Camera& camera) {
  const auto triangulating = [&](double focal_length_px, double baseline_m, double error_px, double slow, double bias_m) {
    const double quadratic = o.disparity_error_px.value_or(error_px) / (focal_length_px * o.baseline_m.value_or(baseline_m));
    return SensorModel{o.kind, {.quadratic_per_m = quadratic}, slow, bias_m};
  };
  switch (o.kind) {
    case SensorKind::automatic:  // no sensor in use is believed to be noisier
    case SensorKind::structured_light: {
      using namespace structured_light;
      return triangulating(kFocalLength_px, kBaseline_m, kDisparityError_px, kSlow, kBias_m);
    }
    case SensorKind::stereo: {
      using namespace stereo;
      return triangulating(camera.fx, kBaseline_m, kDisparityError_px, kSlow, kBias_m);
    }
    case SensorKind::time_of_flight: {
      using namespace time_of_flight;
      return {o.kind, {.constant_m = kConstant_m, .linear = kLinear}, kSlow, kBias_m};
    }
    case SensorKind::none: break;
  }
  return {o.kind, {}, 0.0, 0.0};
}

SensorModel model_of(const SensorOptions& o, const Camera& camera) {
  SensorModel model = usual_model(o, camera);
  model.noise.constant_m = o.constant_m.value_or(model.noise.constant_m);
  model.noise.linear = o.linear.value_or(model.noise.linear);
  model.noise.quadratic_per_m = o.quadratic_per_m.value_or(model.noise.quadratic_per_m);
  model.slow = o.slow.value_or(model.slow);
  model.bias_m = o.bias_m.value_or(model.bias_m);
  return model;
}

}  // namespace

double DepthNoise::sigma_m(double z_m) const { return std::hypot(constant_m, linear * z_m, quadratic_per_m * z_m * z_m); }

Status validate(const SensorOptions& options) try {
  Status status;
  for_each_parameter(options, [&](const SensorParameter& parameter, const std::optional<double>& value) {
    if (status && value) status = check(parameter, options.kind, *value);
  });
  return status ? validate(options.distortion) : status;
} catch (const std::exception& exception) {
  return caught(exception, "sensor");
}

Result<SensorModel> sensor_model(const SensorOptions& options, const Camera& camera, double metres_per_unit) try {
  if (Status status = validate(options); !status) return status.error();
  if (Status status = validate(camera); !status) return status.error();
  if (!(metres_per_unit >= 0.0 && metres_per_unit <= 1.0)) {
    return bad("metres_per_unit", range_text(0.0, 1.0, "m", metres_per_unit));
  }
  SensorModel model = model_of(options, camera);
  // Uniform over one unit.
  model.noise.constant_m = std::hypot(model.noise.constant_m, metres_per_unit / std::sqrt(12.0));
  return model;
} catch (const std::exception& exception) {
  return caught(exception, "sensor");
}

}  // namespace fransac
