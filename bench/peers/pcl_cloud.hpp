// SPDX-License-Identifier: Apache-2.0
/// Frames as PCL's users have them.
#pragma once

#include <pcl/point_cloud.h>
#include <pcl/point_types.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "peer.hpp"

namespace fransac::bench {

using PclCloud = ::pcl::PointCloud<::pcl::PointXYZ>;

/// A cloud of the measured points alone (PCL then need not look for NaN) and the pixel of each.
struct PclPoints {
  PclCloud::Ptr cloud{new PclCloud};
  std::vector<std::uint32_t> pixels;

  [[nodiscard]] std::size_t size() const { return cloud->size(); }

  void read(const Frame& frame) {
    frame.depth == nullptr ? copy(frame) : deproject(frame);
    cloud->width = static_cast<std::uint32_t>(cloud->size());
    cloud->height = 1;
    cloud->is_dense = true;
  }

 private:
  void deproject(const Frame& frame) {
    const std::size_t measured = frame.size() - static_cast<std::size_t>(std::count(frame.depth, frame.depth + frame.size(), 0));
    cloud->points.resize(measured + 1);  // every pixel is written, and overwritten unless it was measured
    pixels.resize(measured + 1);
    const auto scale = static_cast<float>(1.0 / frame.depth_scale);
    const auto inverse_fx = static_cast<float>(1.0 / frame.fx);
    const auto inverse_fy = static_cast<float>(1.0 / frame.fy);
    const auto cx = static_cast<float>(frame.cx);
    const auto cy = static_cast<float>(frame.cy);
    ::pcl::PointXYZ* const points = cloud->points.data();
    std::uint32_t* const pixel_of = pixels.data();
    std::size_t n = 0;
    std::uint32_t pixel = 0;
    for (int v = 0; v < frame.height; ++v) {
      const float ray_y = (static_cast<float>(v) - cy) * inverse_fy;
      for (int u = 0; u < frame.width; ++u, ++pixel) {
        const float z = static_cast<float>(frame.depth[pixel]) * scale;
        points[n].x = (static_cast<float>(u) - cx) * inverse_fx * z;
        points[n].y = ray_y * z;
        points[n].z = z;
        pixel_of[n] = pixel;
        n += frame.depth[pixel] != 0 ? 1 : 0;
      }
    }
    cloud->points.resize(measured);
    pixels.resize(measured);
  }

  void copy(const Frame& frame) {
    cloud->points.resize(frame.size());
    pixels.resize(frame.size());
    for (std::size_t i = 0; i < frame.size(); ++i) {
      cloud->points[i] = ::pcl::PointXYZ(frame.points[3 * i], frame.points[3 * i + 1], frame.points[3 * i + 2]);
      pixels[i] = static_cast<std::uint32_t>(i);
    }
  }
};

}  // namespace fransac::bench
