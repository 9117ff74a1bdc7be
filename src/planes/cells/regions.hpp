// SPDX-License-Identifier: Apache-2.0
/// Connected regions of cells that lie on one plane.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <span>
#include <vector>

#include "fransac/core/aligned.hpp"
#include "fransac/core/camera.hpp"
#include "fransac/planes/segment.hpp"
#include "planes/cells/grid.hpp"
#include "planes/cells/spread.hpp"

namespace fransac::cells {

inline constexpr std::int16_t kNobody = -1;

/// Cells on one plane: a connected region, or several after merging.
struct Region {
  Moments moments;
  PlaneFit fit;
  int cells = 0;
  double variance = 0.0;  ///< Sum over cells of Grid::sigma^2.
  double q4 = 0.0;        ///< Sum over cells of q^4.
  PlaneEvidence evidence;
  double confidence = 1.0;
  bool alive = true;

  /// Makes the sums that are not moments, over the region's cells.
  void sum_errors(const Grid& grid, const CellSet& set) {
    const int first = grid.index(set.top, 0);
    const kernels::CellSetErrors sums =
        kernels::sum_errors(grid.arrays(first), grid.sigma.data() + first, set.bits, set.rows(), grid.words);
    variance = static_cast<double>(sums.variance);
    q4 = static_cast<double>(sums.q4);
  }
  /// One sigma of a pixel, root mean square over the cells.
  [[nodiscard]] double sigma() const { return std::sqrt(variance / std::max(cells, 1)); }
};

struct JudgeBuffers;

struct Regions {
  std::vector<Region> list;
  AlignedVector<std::int16_t> owner;  ///< Per cell of the grid: index into the list, or kNobody.
};

/// Memory of grow_regions.
struct RegionBuffers {
  SpreadBuffers spread;
  AlignedVector<float> weight;        ///< 1 for usable cells that no flood has taken, else 0.
  AlignedVector<std::uint8_t> tried;  ///< Cells that grew to no plane: they need not be seeds again.
  AlignedVector<float> flatness;      ///< Of the block about each cell.
  std::vector<std::int32_t> candidates;
  std::vector<std::int32_t> first;  ///< Where the seeds of a rank start.
  std::vector<std::int32_t> seeds;  ///< Cells, the flattest first.
};

/// A plane that is looked for first, and a pixel where it should be seen.
struct ExpectedPlane {
  InversePlane plane;
  double u;  ///< From the image's centre.
  double v;
};

/// Grows regions from what is expected, then from the flattest places. Keeps those that may be planes, or pieces of one.
void grow_regions(const Grid& grid, std::span<const ExpectedPlane> expected, int threads, RegionBuffers& buffers,
                  JudgeBuffers& judge, Regions& regions);

}  // namespace fransac::cells
