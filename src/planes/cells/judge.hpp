// SPDX-License-Identifier: Apache-2.0
/// Whether a region of cells is a plane of the scene: how its surface turns, how it ends, how improbable it is by chance.
#pragma once

#include <array>
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

/// Regions are judged several at once, every eighth by one task.
using JudgeBuffersOfTasks = std::array<JudgeBuffers, 8>;

class Judge {
 public:
  Judge(const Grid& grid, JudgeBuffers& buffers) : grid_(grid), b_(buffers) {}

  /// Whether a region whose cells are `set` may be a plane: neither chance nor curved for certain.
  [[nodiscard]] bool may_be_plane(const Region& region, const CellSet& set) const;
  /// What a region shows, of an image with so many measured samples.
  [[nodiscard]] PlaneEvidence look(const Region& region, const CellSet& set, double measured) const;
  /// The probability that a region is a plane.
  [[nodiscard]] static double confidence(const PlaneEvidence& evidence);

 private:
  struct Turn {
    double rad = 0.0;
    double sigma = 0.0;
  };
  /// By how much the normal turns from one end of a set to the other, and one sigma of that.
  [[nodiscard]] Turn turn(const Region& region, const kernels::CellSetShape& shape) const;
  /// The same without the cells at the border, which are blurred or hold something else, too; where few are left, the whole's.
  [[nodiscard]] Turn core_turn(const Region& region, const CellSet& set, const Turn& whole) const;
  /// Nats.
  [[nodiscard]] double evidence(const Region& region, const kernels::CellSetShape& shape) const;
  /// The share of a set's measured sides that a smooth surface crosses.
  [[nodiscard]] double smooth_border(const CellSet& set) const;
  [[nodiscard]] kernels::CellSetShape shape(const Region& region, const CellSet& set) const;
  /// The set without the cells at its border.
  [[nodiscard]] CellSet erode(const CellSet& set) const;

  const Grid& grid_;
  JudgeBuffers& b_;
};

}  // namespace fransac::cells
