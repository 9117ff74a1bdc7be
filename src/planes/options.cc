// SPDX-License-Identifier: Apache-2.0
#include "fransac/planes/options.hpp"

#include <string>

#include "core/caught.hpp"
#include "core/number_text.hpp"
#include "planes/methods.hpp"
#include "planes/range_check.hpp"

namespace fransac {
namespace {

/// "cells"; "fransac, voxel-ransac"
std::string names_of(UsedBy users) {
  std::string names;
  for (const Method method : {Method::cells, Method::fransac, Method::voxel_ransac, Method::rransac, Method::ransac}) {
    if (uses(method, users)) names += (names.empty() ? "" : ", ") + std::string(enum_name(method));
  }
  return names;
}

/// Refuses what was chosen but means nothing to the method.
Status check_uses(const SegmentOptions& options) {
  static const SegmentOptions kDefaults;
  Status status;
  const auto check = [&](const OptionInfo& info, const auto& value, const auto& by_default) {
    if (!status || value == by_default || uses(options.method, info, options)) return;
    status =
        Error{ErrorCode::invalid_argument, RangeCheck::full_name(info) + ": means nothing to method " +
                                               std::string(enum_name(options.method)) + ", only to " + names_of(info.used_by)};
  };
  for_each_option_of(check, options, kDefaults);
  return status;
}

}  // namespace

const AxisLimits* limits_of(const SegmentOptions& options, Method method, bool depth_image) {
  const bool chosen = options.pass_through.limits != AxisLimits{};
  // A cloud's axes mean nothing by themselves.
  const bool by_method = parts_of(method).pass_through && depth_image;
  return options.pass_through.use.value_or(chosen || by_method) ? &options.pass_through.limits : nullptr;
}

bool uses(Method method, const OptionInfo& info, const SegmentOptions& options) {
  const bool of_sensor = info.name == "sensor" || info.parameter_of == "sensor-param";
  return uses(method, info.used_by) || (of_sensor && !options.sensor.distortion.empty());
}

SegmentOptions used_by(const SegmentOptions& options, Method method) {
  SegmentOptions used = options;
  const SegmentOptions defaults;
  const auto reset = [&](const OptionInfo& info, auto& value, const auto& by_default) {
    if (!uses(method, info, options)) value = by_default;
  };
  for_each_option_of(reset, used, defaults);
  return used;
}

Status validate(const SegmentOptions& options) try {
  RangeCheck check;
  for_each_option(options, check);
  if (!check.status) return check.status;
  const AxisLimits& limits = options.pass_through.limits;
  if (!(limits.min_m < limits.max_m)) {
    return Error{ErrorCode::invalid_argument, "pass-through-min: must be below pass-through-max (" + number_text(limits.max_m) +
                                                  " m), is " + number_text(limits.min_m)};
  }
  if (Status status = validate(options.sensor); !status)
    return Error{status.error().code, "sensor-param " + status.error().message};
  return check_uses(options);
} catch (const std::exception& exception) {
  return caught(exception, "options");
}

}  // namespace fransac
