// SPDX-License-Identifier: Apache-2.0
#include "fransac/core/camera.hpp"

#include <string>

#include "core/caught.hpp"

namespace fransac {
namespace {

Error field_error(const char* field, const char* rule) {
  return {ErrorCode::invalid_argument, std::string("camera field \"") + field + "\" " + rule};
}

bool within(double value, double min, double max) { return value >= min && value <= max; }  // false for NaN

}  // namespace

Status validate(const Camera& camera) try {
  const char* const size_rule = "must be between 1 and 32768 pixels";
  if (camera.width < 1 || camera.width > kMaxImageSide) return field_error("width", size_rule);
  if (camera.height < 1 || camera.height > kMaxImageSide) return field_error("height", size_rule);
  const char* const focal_rule = "must be between 0.1 and 1e6 pixels";
  if (!within(camera.fx, 0.1, 1e6)) return field_error("fx", focal_rule);
  if (!within(camera.fy, 0.1, 1e6)) return field_error("fy", focal_rule);
  const char* const centre_rule = "must be between -1e6 and 1e6 pixels";
  if (!within(camera.cx, -1e6, 1e6)) return field_error("cx", centre_rule);
  if (!within(camera.cy, -1e6, 1e6)) return field_error("cy", centre_rule);
  if (!within(camera.depth_scale, 1.0, 1e6)) {
    return field_error("depth_scale", "must be between 1 and 1e6 units per metre (metres = value / depth_scale)");
  }
  return {};
} catch (const std::exception& exception) {
  return caught(exception, "camera");
}

}  // namespace fransac
