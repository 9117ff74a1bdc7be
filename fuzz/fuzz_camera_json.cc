// SPDX-License-Identifier: Apache-2.0
// camera.json: any text is a valid camera that survives a round trip, or an error with a message.
#include <cstddef>
#include <cstdint>
#include <string_view>

#include "fransac/io/camera_json.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace fransac;
  const auto camera = io::parse_camera_json({reinterpret_cast<const char*>(data), size}, "camera.json");
  if (!camera) {
    if (!camera.error().message.starts_with("camera.json: ")) __builtin_trap();
    return 0;
  }
  if (!validate(*camera)) __builtin_trap();
  const auto again = io::parse_camera_json(io::camera_to_json(*camera), "again");
  if (!again || *again != *camera) __builtin_trap();
  return 0;
}
