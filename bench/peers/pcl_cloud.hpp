// SPDX-License-Identifier: Apache-2.0
/// Frames as PCL's users have them.
#pragma once

#include <pcl/point_cloud.h>
#include <pcl/point_types.h>

#include <cstddef>
#include <vector>

#include "peer.hpp"

namespace fransac::bench {

using PclCloud = pcl::PointCloud<pcl::PointXYZ>;

/// A cloud of the measured points alone (PCL then need not look for NaN) and the pixel of each.
struct PclPoints {
  PclCloud::Ptr cloud{new PclCloud};
  std::vector<std::size_t> pixels;

  [[nodiscard]] std::size_t size() const { return cloud->size(); }

  void read(const Frame& frame) {
    frame.depth == nullptr ? copy(frame) : deproject(frame);
    cloud->width = static_cast<std::uint32_t>(cloud->size());
    cloud->height = 1;
    cloud->is_dense = true;
  }

 private:
  void deproject(const Frame& frame) {
    cloud->points.resize(frame.size());
    pixels.resize(frame.size());
    const auto scale = static_cast<float>(1.0 / frame.depth_scale);
    const auto inverse_fx = static_cast<float>(1.0 / frame.fx);
    const auto inverse_fy = static_cast<float>(1.0 / frame.fy);
    const auto cx = static_cast<float>(frame.cx);
    const auto cy = static_cast<float>(frame.cy);
    std::size_t n = 0;
    std::size_t pixel = 0;
    for (int v = 0; v < frame.height; ++v) {
      for (int u = 0; u < frame.width; ++u, ++pixel) {
        if (frame.depth[pixel] == 0) continue;
        const float z = static_cast<float>(frame.depth[pixel]) * scale;
        pcl::PointXYZ& point = cloud->points[n];
        point.x = (static_cast<float>(u) - cx) * inverse_fx * z;
        point.y = (static_cast<float>(v) - cy) * inverse_fy * z;
        point.z = z;
        pixels[n++] = pixel;
      }
    }
    cloud->points.resize(n);
    pixels.resize(n);
  }

  void copy(const Frame& frame) {
    cloud->points.resize(frame.size());
    pixels.resize(frame.size());
    for (std::size_t i = 0; i < frame.size(); ++i) {
      cloud->points[i] = pcl::PointXYZ(frame.points[3 * i], frame.points[3 * i + 1], frame.points[3 * i + 2]);
      pixels[i] = i;
    }
  }
};

}  // namespace fransac::bench
