// SPDX-License-Identifier: Apache-2.0
/// Floor that seems to be above or below its plane because the sensor bends it.
#pragma once

#include <cstdint>
#include <vector>

#include "filter/depth_rows.hpp"
#include "fransac/core/plane.hpp"
#include "fransac/planes/segment.hpp"
#include "obstacles/floor_error.hpp"
#include "obstacles/objects.hpp"

namespace fransac::obstacles {

/// Memory of remove_bent_floor.
struct BentFloor {
  std::vector<std::uint8_t> kind;      ///< Per cell.
  std::vector<float> height;           ///< Per cell: of what is above or below.
  std::vector<float> floor;            ///< Per cell, and one more: height of the floor in it, metres above the plane, and
  std::vector<std::uint8_t> is_floor;  ///< whether there is some; 0 without.
  std::vector<double> most;            ///< Per cell: the highest step above the floor about it that is none.
  std::vector<std::uint8_t> wanted;    ///< Cells whose floor is to be measured, and
  std::vector<std::uint8_t> rows;      ///< rows, borders included, that have some.
  std::vector<std::uint16_t> steps;    ///< From the nearest high cell.
  std::vector<Cell> low;               ///< Cells that may be floor.
  std::vector<std::int32_t> queue;
  std::vector<std::int32_t> group;
  /// Of one row of cells: heights of pixels on the support, added up.
  struct Sum {
    int column;
    std::uint32_t count;
    double height_m;
  };
  std::vector<Sum> sums;
};

/// Takes from `sides` the cells above and below whose height is within the errors of the floor, and that join the floor about
/// them, or whatever joins it, without a step: they are floor.
template <class Raw>
void remove_bent_floor(const DepthRows<Raw>& rows, const Segmentation& segmentation, const std::vector<int>& carriers,
                       const Plane& support, const FloorError& error, double sigmas, DepthRowBuffer& buffer, BentFloor& work,
                       Sides& sides);

}  // namespace fransac::obstacles
