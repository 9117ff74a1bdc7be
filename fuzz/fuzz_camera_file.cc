// SPDX-License-Identifier: Apache-2.0
// Files of cameras, JSON and YAML: any text is a valid camera that survives a round trip as camera.json, or an error with a
// message.
#include <cstddef>
#include <cstdint>
#include <string_view>

#include "fransac/io/camera_file.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace fransac;
  const auto file = io::parse_camera_file({reinterpret_cast<const char*>(data), size}, "camera");
  if (!file) {
    if (!file.error().message.starts_with("camera:")) __builtin_trap();
    return 0;
  }
  if (!validate(file->camera)) __builtin_trap();
  const auto again = io::parse_camera_file(io::camera_to_json(file->camera), "again");
  if (!again || again->camera != file->camera || again->lens) __builtin_trap();
  return 0;
}
