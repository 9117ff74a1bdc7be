// SPDX-License-Identifier: Apache-2.0
#include "fransac/io/camera_json.hpp"

#include <array>
#include <utility>

#include "fransac/io/file.hpp"
#include "io/guard.h"
#include "io/json.h"
#include "io/text.h"

namespace fransac::io {
namespace {

constexpr std::size_t kMaxCameraBytes = std::size_t{1} << 20;  // seven numbers and whatever else a tool may keep there

Result<Camera> camera_from_json(const Json& object, const std::string& name) {
  Camera camera;
  for (const auto& [field, value] : {std::pair{"width", &camera.width}, std::pair{"height", &camera.height}}) {
    const Result<int> read = whole_field(object, field, field, kMaxImageSide, name);
    if (!read) return read.error();
    *value = *read;
  }
  for (const auto& [field, value] : {std::pair{"fx", &camera.fx}, std::pair{"fy", &camera.fy}, std::pair{"cx", &camera.cx},
                                     std::pair{"cy", &camera.cy}, std::pair{"depth_scale", &camera.depth_scale}}) {
    if (value == &camera.depth_scale && object.find(field) == nullptr) continue;
    const Result<double> read = number_field(object, field, field, name);
    if (!read) return read.error();
    *value = *read;
  }
  if (const Status status = validate(camera); !status) return file_error(ErrorCode::format, name, status.error().message);
  return camera;
}

}  // namespace

Result<Camera> parse_camera_json(std::string_view text, const std::string& name) {
  return guarded(name, [&]() -> Result<Camera> {
    const Result<Json> object = parse_json_object(text, name);
    if (!object) return object.error();
    return camera_from_json(*object, name);
  });
}

Result<Camera> read_camera_json(const std::filesystem::path& file) {
  return guarded(file.native(), [&]() -> Result<Camera> {
    const Result<std::vector<std::byte>> bytes = read_file(file, kMaxCameraBytes);
    if (!bytes) return bytes.error();
    return parse_camera_json(as_text(*bytes), file.string());
  });
}

std::string camera_to_json(const Camera& camera) {
  return Json::object("width", camera.width, "height", camera.height, "fx", camera.fx, "fy", camera.fy, "cx", camera.cx, "cy",
                      camera.cy, "depth_scale", camera.depth_scale)
      .text();
}

std::optional<Camera> tum_camera(std::string_view name) {
  // The benchmark's file-format page, intrinsics of the colour cameras: the depth images are registered to them.
  constexpr std::array<Camera, 3> kCameras{{{640, 480, 517.3, 516.5, 318.6, 255.3, 5000.0},
                                            {640, 480, 520.9, 521.0, 325.1, 249.7, 5000.0},
                                            {640, 480, 535.4, 539.2, 320.1, 247.6, 5000.0}}};
  constexpr std::string_view kLong = "freiburg";
  constexpr std::string_view kShort = "fr";
  std::size_t number = name.find(kLong);
  if (number != std::string_view::npos) {
    number += kLong.size();
  } else if (name.starts_with(kShort)) {
    number = kShort.size();
  } else {
    return std::nullopt;
  }
  const std::string_view digits = name.substr(number, name.find_first_not_of("0123456789", number) - number);
  if (digits.size() != 1 || digits[0] < '1' || digits[0] > '3') return std::nullopt;
  return kCameras[static_cast<std::size_t>(digits[0] - '1')];
}

}  // namespace fransac::io
