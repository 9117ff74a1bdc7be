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

/// Makes cells of regions that are no longer alive nobody's.
void release_cells(Regions& regions);

/// Memory of grow_regions.
struct RegionBuffers {
  AlignedVector<Moments> moments;    ///< Of usable cells; each is asked for several times.
  AlignedVector<std::uint8_t> free;  ///< Usable cells of no region.
  AlignedVector<std::uint8_t> full;  ///< Centres of blocks of 3 x 3 such cells,
  AlignedVector<float> residual;     ///< and the mean squared residual of the plane through them.
  std::vector<std::uint16_t> rank;   ///< Of each seed, by flatness.
  std::vector<std::int32_t> first;   ///< Where the seeds of a rank start.
  std::vector<std::int32_t> seeds;   ///< Cells, the flattest first.
  std::vector<std::int32_t> members;
  AlignedVector<std::int32_t> mark;
  struct Shape;
  std::vector<Shape> shapes;

  RegionBuffers();
  ~RegionBuffers();
};

/// Grows regions from the flattest places.
void grow_regions(const Grid& grid, RegionBuffers& buffers, Regions& regions);

/// Keeps the regions that are no chance and no pieces of curved surfaces.
void judge_regions(const Grid& grid, const Camera& camera, RegionBuffers& buffers, Regions& regions);

/// Which cells have the same owner as all their eight neighbours.
struct UniformBuffers {
  AlignedVector<std::uint8_t> row;  ///< Left and right.
  AlignedVector<std::uint8_t> uniform;
};
void find_uniform(const Grid& grid, const AlignedVector<std::int16_t>& owner, UniformBuffers& buffers);

}  // namespace fransac::cells
