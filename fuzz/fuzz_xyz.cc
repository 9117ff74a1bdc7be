// SPDX-License-Identifier: Apache-2.0
// Whatever the bytes: a cloud whose extent fits its points, within the limits, or an error that names the file.
#include <cstddef>
#include <cstdint>
#include <span>

#include "io/cloud_formats.h"
#include "require.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace fransac::fuzz;
  const fransac::io::ReadLimits limits{1 << 16};
  const auto cloud = fransac::io::cloud_formats::decode_xyz(std::as_bytes(std::span(data, size)), "cloud.xyz", limits);
  if (!cloud) return require_message(cloud.error(), "cloud.xyz:"), 0;
  require(cloud->size() <= limits.max_size && cloud->origin.allFinite());
  require(static_cast<std::size_t>(cloud->width) * static_cast<std::size_t>(cloud->height) == cloud->size());
  return 0;
}
