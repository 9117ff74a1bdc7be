// SPDX-License-Identifier: Apache-2.0
// The optional components, linked and called: a depth image goes through a file, and so does a cloud.
#include <cstdio>
#include <filesystem>

#include "fransac/io/cloud_file.hpp"
#include "fransac/io/image.hpp"

int main() {
  namespace io = fransac::io;
  const std::filesystem::path folder = std::filesystem::current_path();

  const io::DepthImage image{2, 1, 1, {1000, 0}};
  if (const auto written = io::write_png(folder / "depth.png", image); !written.ok()) {
    return std::fprintf(stderr, "%s\n", written.error().message.c_str()), 1;
  }
  const auto depth = io::read_depth_png(folder / "depth.png");
  if (!depth || depth->pixels != image.pixels) return std::fprintf(stderr, "the depth image changed\n"), 1;

  fransac::PointCloud cloud;
  cloud.resize(1);
  cloud.set(0, {1.0F, 2.0F, 3.0F});
  if (const auto written = io::write_cloud(folder / "cloud.pcd", cloud, {}); !written.ok()) {
    return std::fprintf(stderr, "%s\n", written.error().message.c_str()), 1;
  }
  const auto points = io::read_cloud(folder / "cloud.pcd");
  if (!points || points->size() != 1 || points->point(0) != Eigen::Vector3d(1, 2, 3)) {
    return std::fprintf(stderr, "the cloud changed\n"), 1;
  }
  return 0;
}
