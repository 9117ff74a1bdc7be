// SPDX-License-Identifier: Apache-2.0
/// Whether a region of cells is a plane of the scene: how its surface turns, how it ends, how improbable it is by chance.
#pragma once

#include <cstdint>
#include <vector>

#include "planes/cells/grid.hpp"
#include "planes/cells/regions.hpp"
#include "planes/cells/spread.hpp"

namespace fransac::cells {

/// Memory of a judge.
struct JudgeBuffers {
  std::vector<std::uint64_t> eroded;
};

class Judge {
 public:
  Judge(const Grid& grid, JudgeBuffers& buffers) : grid_(grid), b_(buffers) {}

  /// What a region shows, whose cells are `set`.
  [[nodiscard]] PlaneEvidence look(const Region& region, const CellSet& set) const;
  /// Whether the surface turns for certain, further than planes seem to.
  [[nodiscard]] static bool is_curved(const PlaneEvidence& a);
  /// The probability that a region is a plane.
  [[nodiscard]] static double confidence(const PlaneEvidence& a);

 private:
  struct Turn {
    double rad = 0.0;
    double sigma = 0.0;
  };
  /// By how much the normal turns from one end of a set to the other, and one sigma of that.
  [[nodiscard]] Turn turn(const Region& region, const kernels::CellSetShape& shape) const;
  [[nodiscard]] double evidence(const Region& region, const kernels::CellSetShape& shape) const;
  /// The share of a set's measured sides that a smooth surface crosses.
  [[nodiscard]] double smooth_border(const CellSet& set) const;
  /// The set without the cells at its border.
  [[nodiscard]] CellSet erode(const CellSet& set) const;

  const Grid& grid_;
  JudgeBuffers& b_;
};

}  // namespace fransac::cells
