// SPDX-License-Identifier: Apache-2.0
// What a program of somebody else's does with the library: find the wall in a depth frame.
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <vector>

#include "fransac/fransac.hpp"

int main() {
  const fransac::Camera camera{.width = 64, .height = 48, .fx = 52.5, .fy = 52.5, .cx = 31.5, .cy = 23.5};
  const std::vector<std::uint16_t> pixels(64 * 48, 1500);  // millimetres
  const auto depth = fransac::DepthView::from_uint16(pixels.data(), camera.width, camera.height, camera.depth_scale);

  const auto found = fransac::segment(depth, camera);
  if (!found) return std::fprintf(stderr, "%s\n", found.error().message.c_str()), 1;
  if (found->planes.size() != 1) return std::fprintf(stderr, "%zu planes\n", found->planes.size()), 1;
  const fransac::PlaneSegment& wall = found->planes[0];
  std::printf("one plane, %.3f m away, %llu pixels\n", wall.plane.d, static_cast<unsigned long long>(wall.inliers));
  return std::abs(wall.plane.d - 1.5) < 1e-6 && wall.inliers == pixels.size() ? 0 : 1;
}
