// SPDX-License-Identifier: Apache-2.0
#include "fransac/core/camera.hpp"

#include <cmath>
#include <string>

namespace fransac {
namespace {

Error field_error(const char* field, const char* rule) {
  return {ErrorCode::invalid_argument, std::string("camera field \"") + field + "\" " + rule};
}

bool positive(double value) { return std::isfinite(value) && value > 0.0; }

}  // namespace

Status validate(const Camera& camera) {
  const char* const size_rule = "must be between 1 and 32768 pixels";
  if (camera.width < 1 || camera.width > kMaxImageSide) return field_error("width", size_rule);
  if (camera.height < 1 || camera.height > kMaxImageSide) return field_error("height", size_rule);
  if (!positive(camera.fx)) return field_error("fx", "must be a positive number of pixels");
  if (!positive(camera.fy)) return field_error("fy", "must be a positive number of pixels");
  if (!std::isfinite(camera.cx)) return field_error("cx", "must be a finite number of pixels");
  if (!std::isfinite(camera.cy)) return field_error("cy", "must be a finite number of pixels");
  if (!positive(camera.depth_scale)) return field_error("depth_scale", "must be a positive number of units per metre");
  return {};
}

}  // namespace fransac
