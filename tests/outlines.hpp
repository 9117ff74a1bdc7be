// SPDX-License-Identifier: Apache-2.0
/// Label images drawn with characters, and what outlines enclose.
#pragma once

#include <algorithm>
#include <cstdint>
#include <string>
#include <vector>

#include "fransac/planes/outline.hpp"

namespace fransac::testing {

/// Every corner, every part.
inline constexpr OutlineOptions kExact{.tolerance_px = 0.0, .min_pixels = 1};

/// A segmentation whose labels are the digits of the rows; anything else is no plane. All planes face the camera at 2 m.
inline Segmentation label_image(const std::vector<std::string>& rows) {
  Segmentation s;
  s.width = static_cast<int>(rows.front().size());
  s.height = static_cast<int>(rows.size());
  int planes = 0;
  for (const std::string& row : rows) {
    for (const char c : row) {
      const bool digit = c >= '1' && c <= '9';
      s.labels.push_back(digit ? static_cast<std::uint8_t>(c - '0') : kLabelNoPlane);
      if (digit) planes = std::max(planes, c - '0');
    }
  }
  for (int id = 1; id <= planes; ++id) {
    PlaneSegment& segment = s.planes.emplace_back();
    segment.id = id;
    segment.plane = {-Eigen::Vector3d::UnitZ(), 2.0};
  }
  return s;
}

/// By the shoelace formula; negative when anticlockwise as displayed.
inline double area_px(const Ring& ring) {
  double sum = 0.0;
  for (std::size_t i = 0; i < ring.pixels.size(); ++i) {
    const Eigen::Vector2d& a = ring.pixels[i];
    const Eigen::Vector2d& b = ring.pixels[(i + 1) % ring.pixels.size()];
    sum += a.x() * b.y() - b.x() * a.y();
  }
  return 0.5 * sum;
}

}  // namespace fransac::testing
