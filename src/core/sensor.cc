// SPDX-License-Identifier: Apache-2.0
#include "fransac/core/sensor.hpp"

#include <cmath>
#include <string>

#include "core/number_text.hpp"

namespace fransac {
namespace {

Error bad(const SensorParameter& parameter, const std::string& what) {
  return {ErrorCode::invalid_argument, std::string(parameter.name) + ": " + what};
}

Status check(const SensorParameter& parameter, SensorKind kind, double value) {
  if (!parameter.means_something_to(kind)) return bad(parameter, "means nothing to this kind of sensor");
  if (value >= parameter.min && value <= parameter.max) return {};  // false for NaN
  return bad(parameter, "must be between " + number_text(parameter.min) + " and " + number_text(parameter.max) + " " +
                            std::string(parameter.unit) + ", is " + number_text(value));
}

}  // namespace

Status validate(const SensorOptions& options) {
  Status status;
  for_each_parameter(options, [&](const SensorParameter& parameter, const std::optional<double>& value) {
    if (status && value) status = check(parameter, options.kind, *value);
  });
  return status;
}

double DepthNoise::sigma_m(double z_m) const { return std::hypot(constant_m, linear * z_m, quadratic_per_m * z_m * z_m); }

}  // namespace fransac
