// SPDX-License-Identifier: Apache-2.0
// Depth images of all formats: any bytes are a whole image of raw units or of metres, within the limits, or an error.
#include <cstddef>
#include <cstdint>
#include <span>

#include "fransac/io/image.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace fransac;
  const io::ReadLimits limits{1 << 16};
  const auto depth = io::decode_depth_image(std::as_bytes(std::span(data, size)), "depth", limits);
  if (!depth) {
    if (!depth.error().message.starts_with("depth: ")) __builtin_trap();
    return 0;
  }
  const bool holds_units = !depth->units.pixels.empty();
  if (holds_units != depth->metres.pixels.empty()) __builtin_trap();
  const std::size_t pixels = holds_units ? depth->units.size() : depth->metres.size();
  if (pixels == 0 || pixels > limits.max_size) __builtin_trap();
  if (pixels != (holds_units ? depth->units.pixels.size() : depth->metres.pixels.size())) __builtin_trap();
  return 0;
}
