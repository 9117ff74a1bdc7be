// SPDX-License-Identifier: Apache-2.0
/// Connected regions of cells that lie on one plane.
#pragma once

#include <cstdint>
#include <vector>

#include "fransac/core/aligned.hpp"
#include "fransac/core/camera.hpp"
#include "planes/cells/grid.hpp"

namespace fransac::cells {

inline constexpr std::int16_t kNobody = -1;

/// Cells on one plane: a connected region, or several after merging.
struct Region {
  Moments moments;
  PlaneFit fit;
  int cells = 0;
  bool alive = true;
};

struct Regions {
  std::vector<Region> list;
  AlignedVector<std::int16_t> owner;  ///< Per cell of the grid: index into the list, or kNobody.
};

/// Memory of grow_regions.
struct RegionBuffers {
  struct Seed {
    float score;
    std::int32_t cell;
  };
  std::vector<Seed> seeds;
  std::vector<std::int32_t> members;
  AlignedVector<std::int32_t> mark;
  struct Shape;
  std::vector<Shape> shapes;

  RegionBuffers();
  ~RegionBuffers();
};

/// Grows regions from the flattest places and keeps those that are flat and no chance.
void grow_regions(const Grid& grid, const Camera& camera, RegionBuffers& buffers, Regions& regions);

}  // namespace fransac::cells
