// SPDX-License-Identifier: Apache-2.0
// Whatever the bytes: a cloud whose extent fits its points, or an error.
#include <cstdint>
#include <cstdlib>
#include <span>

#include "io/cloud_formats.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const auto cloud = fransac::io::cloud_formats::decode_ply(std::as_bytes(std::span(data, size)), "fuzz");
  if (!cloud) return 0;
  const auto points = static_cast<std::size_t>(cloud->width) * static_cast<std::size_t>(cloud->height);
  if (points != cloud->size()) std::abort();
  return 0;
}
