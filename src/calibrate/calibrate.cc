// SPDX-License-Identifier: Apache-2.0
#include "fransac/calibrate/calibrate.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <new>
#include <string>

#include "calibrate/field.hpp"
#include "calibrate/noise.hpp"
#include "calibrate/windows.hpp"
#include "core/caught.hpp"
#include "core/number_text.hpp"
#include "fransac/planes/segment.hpp"

namespace fransac {
namespace {

using calibration::PlaneWindows;

Error bad(const std::string& what) { return {ErrorCode::invalid_argument, what}; }

std::string frame_name(std::size_t i) { return "frame " + std::to_string(i); }

Status check(std::span<const CalibrationFrame> frames) {
  if (frames.empty()) return Error{ErrorCode::no_data, "calibration: there are no frames"};
  const DepthView& first = frames.front().depth;
  for (std::size_t i = 0; i < frames.size(); ++i) {
    const DepthView& depth = frames[i].depth;
    if (Status status = validate(depth); !status) return bad(frame_name(i) + ": " + status.error().message);
    if (depth.width() == first.width() && depth.height() == first.height()) continue;
    return bad(frame_name(i) + ": is " + std::to_string(depth.width()) + " x " + std::to_string(depth.height()) +
               " pixels, the first is " + std::to_string(first.width()) + " x " + std::to_string(first.height()));
  }
  return {};
}

/// The large planes of all frames, found in depth that is corrected, measured in depth that is not.
Status find_planes(std::span<const CalibrationFrame> frames, const CalibrateOptions& options, const Distortion& distortion,
                   std::vector<PlaneWindows>& planes) {
  SegmentOptions how;
  how.method = Method::cells;
  how.min_support = options.min_share;
  how.threads = options.threads;
  how.saturated = options.saturated;
  how.sensor.bias_m = options.max_bend_m;
  how.sensor.distortion = distortion;
  Workspace workspace;
  Segmentation found;
  planes.clear();
  for (std::size_t i = 0; i < frames.size(); ++i) {
    if (Status status = segment(frames[i].depth, frames[i].camera, how, workspace, found); !status) {
      if (status.error().code == ErrorCode::no_data) continue;  // one that saw nothing
      return Error{status.error().code, frame_name(i) + ": " + status.error().message};
    }
    calibration::collect_windows(frames[i].depth, found, i, options.min_share, planes);
  }
  if (!planes.empty()) return {};
  return Error{ErrorCode::no_data, "calibration: no plane covers " + number_text(100.0 * options.min_share) +
                                       " % of a frame; a wall or a floor should fill most of it"};
}

/// What the law of its noise looks like at a depth: that of a triangulating sensor or not.
SensorKind kind_of(const DepthNoise& law, double z) {
  const double all = law.sigma_m(z);
  if (all == 0.0) return SensorKind::none;
  const double quadratic = law.quadratic_per_m * z * z;
  return 2.0 * quadratic * quadratic >= all * all ? SensorKind::structured_light : SensorKind::time_of_flight;
}

std::size_t frames_of(const std::vector<PlaneWindows>& planes) {
  std::size_t count = 0;
  for (std::size_t p = 0; p < planes.size(); ++p) {
    if (p == 0 || planes[p].frame != planes[p - 1].frame) ++count;
  }
  return count;
}

Result<SensorCalibration> calibrate_checked(std::span<const CalibrationFrame> frames, const CalibrateOptions& options) {
  const DepthView& first = frames.front().depth;
  std::vector<PlaneWindows> planes;
  calibration::Field field;
  // Planes that are less bent are found whole: once more with what the first look found.
  for (int round = 0; round < 2; ++round) {
    if (Status status = find_planes(frames, options, field.distortion, planes); !status) return status.error();
    field = calibration::fit_field(planes, first.width(), first.height(), options.distortion);
    if (field.distortion.empty()) break;
  }
  SensorCalibration result;
  result.frames = frames_of(planes);
  result.views = field.views;
  result.planes = planes.size();
  result.before = field.before;
  result.after = field.after;
  result.noise = calibration::noise_by_depth(planes);
  if (result.noise.empty()) {
    return Error{ErrorCode::no_data, "calibration: too few pixels at any one depth to tell their noise"};
  }
  const DepthNoise law = calibration::fit_law(result.noise, options.kind);
  SensorOptions& sensor = result.sensor;
  const double middle = result.noise[result.noise.size() / 2].z_m;
  sensor.kind = options.kind == SensorKind::automatic ? kind_of(law, middle) : options.kind;
  // sensor_model adds the rounding to raw units, which differs from file to file.
  const double rounding =
      first.format() == DepthFormat::uint16 ? static_cast<double>(first.metres_per_unit()) / std::sqrt(12.0) : 0.0;
  sensor.constant_m = std::sqrt(std::max(0.0, law.constant_m * law.constant_m - rounding * rounding));
  sensor.linear = law.linear;
  sensor.quadratic_per_m = law.quadratic_per_m;
  sensor.slow = calibration::slow_share(planes, field.distortion, law);
  sensor.bias_m = field.after.most_m;
  sensor.distortion = field.distortion;
  // What no sensor has is held to what options allow.
  for_each_parameter(sensor, [](const SensorParameter& parameter, std::optional<double>& value) {
    if (value) value = std::clamp(*value, parameter.min, parameter.max);
  });
  return result;
}

}  // namespace

Status validate(const CalibrateOptions& options) try {
  const auto kind = static_cast<int>(options.kind);
  if (kind < 0 || kind >= static_cast<int>(std::size(EnumNames<SensorKind>::values))) {
    return bad("kind: not a value of its enumeration");
  }
  if (!(options.max_bend_m >= 0.0 && options.max_bend_m <= 1.0)) {
    return bad("max-bend: must be between 0 and 1 m, is " + number_text(options.max_bend_m));
  }
  if (!(options.min_share > 0.0 && options.min_share <= 1.0)) {
    return bad("min-share: must be above 0 and at most 1, is " + number_text(options.min_share));
  }
  if (options.saturated < 0 || options.saturated > 65535) {
    return bad("saturated: must be between 0 and 65535, is " + std::to_string(options.saturated));
  }
  if (options.threads < 0 || options.threads > 1024) {
    return bad("threads: must be between 0 and 1024, is " + std::to_string(options.threads));
  }
  return {};
} catch (const std::exception& exception) {
  return caught(exception, "options of the calibration");
}

Result<SensorCalibration> calibrate(std::span<const CalibrationFrame> frames, const CalibrateOptions& options) try {
  if (Status status = validate(options); !status) return status.error();
  if (Status status = check(frames); !status) return status.error();
  return calibrate_checked(frames, options);
} catch (const std::exception& exception) {
  return caught(exception, [&] { return "calibration by " + std::to_string(frames.size()) + " frames"; });
}

}  // namespace fransac
