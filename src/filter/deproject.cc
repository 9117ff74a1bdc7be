// SPDX-License-Identifier: Apache-2.0
#include "fransac/filter/deproject.hpp"

namespace fransac {
namespace {

/// Appends the measured pixels of row v to the cloud from index k on; returns the index after the last.
/// Every pixel is written and only a measured one advances: no branch to mispredict at each hole.
template <class ReadDepth>
std::size_t deproject_row(const ReadDepth& depth_at, int v, const Camera& camera, std::size_t k, PointCloud& cloud) {
  const auto cx = static_cast<float>(camera.cx);
  const auto per_fx = static_cast<float>(1.0 / camera.fx);
  const auto ray_y = static_cast<float>((v - camera.cy) / camera.fy);
  const std::uint32_t first = static_cast<std::uint32_t>(v) * static_cast<std::uint32_t>(camera.width);
  float* const x = cloud.x();
  float* const y = cloud.y();
  float* const z = cloud.z();
  std::uint32_t* const source = cloud.source.data();
  for (int u = 0; u < camera.width; ++u) {
    const float depth = depth_at(u);
    x[k] = depth * ((static_cast<float>(u) - cx) * per_fx);
    y[k] = depth * ray_y;
    z[k] = depth;
    source[k] = first + static_cast<std::uint32_t>(u);
    k += static_cast<std::size_t>(depth > 0.0F);
  }
  return k;
}

}  // namespace

void deproject(const DepthView& depth, const Camera& camera, PointCloud& cloud) {
  cloud.origin.setZero();
  cloud.source.resize(depth.size());
  cloud.resize_uninitialised(depth.size());
  std::size_t k = 0;
  for (int v = 0; v < depth.height(); ++v) {
    if (depth.format() == DepthFormat::uint16) {
      const std::uint16_t* const row = depth.row_uint16(v);
      const float metres_per_unit = depth.metres_per_unit();
      k = deproject_row([=](int u) { return static_cast<float>(row[u]) * metres_per_unit; }, v, camera, k, cloud);
    } else {
      const float* const row = depth.row_float(v);
      const auto measured = [](float z) { return z > 0.0F && z <= kMaxDepth_m; };
      k = deproject_row([=](int u) { return measured(row[u]) ? row[u] : 0.0F; }, v, camera, k, cloud);
    }
  }
  cloud.source.resize(k);
  cloud.resize_uninitialised(k);
  cloud.width = static_cast<int>(k);
  cloud.height = 1;
}

}  // namespace fransac
