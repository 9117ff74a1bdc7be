// SPDX-License-Identifier: Apache-2.0
/// Merging of regions that the noise cannot tell apart, and of only those.
#pragma once

#include <cstdint>
#include <vector>

#include "planes/cells/grid.hpp"
#include "planes/cells/judge.hpp"
#include "planes/cells/regions.hpp"

namespace fransac::cells {

/// Memory of merge_regions.
struct MergeBuffers {
  /// How two regions meet.
  struct Border {
    int length = 0;         ///< Pairs of cells.
    int smooth = 0;         ///< of them with a smooth surface across.
    double jump = 0.0;      ///< Sum of what inverse depth jumps by, from the region with the lower rank to the other.
    double variance = 0.0;  ///< Sum of their pixels' variance, and
    double q4 = 0.0;        ///< of q^4.
  };
  struct Pair {
    std::int32_t a;
    std::int32_t b;
    Border border;
    float rise;  ///< Mean squared residual that merging would add to the smaller one; kApart where they stay apart.
  };
  std::vector<std::int16_t> alive;    ///< Index into Regions::list.
  std::vector<std::int16_t> rank;     ///< Index into `alive`.
  std::vector<Pair> pairs;            ///< a < b, row by row of the upper triangle.
  std::vector<std::int16_t> nearest;  ///< Per region: of higher rank, the one whose merging costs least.
  std::vector<std::int16_t> target;
};

/// Merges, the most alike first. Merged regions are no longer alive; owners and fits are those of the union.
void merge_regions(const Grid& grid, MergeBuffers& buffers, Regions& regions);

/// Memory of reassign_borders.
struct ReassignBuffers {
  std::vector<std::uint64_t> sets;  ///< Per region rows x words: its cells. All zero outside `rows`.
  struct Rows {
    int top;
    int bottom;
  };
  std::vector<Rows> rows;         ///< Per region.
  std::size_t words_of_set = 0;   ///< Of each of the sets.
  std::size_t words_of_row = 0;
  /// Of one row of cells.
  struct Task {
    std::vector<std::uint64_t> around;  ///< A region's cells and what is next to them.
    AlignedVector<float> least;
    AlignedVector<std::int32_t> nearest;
  };
  std::vector<Task> tasks;
};

/// Gives cells to the plane they fit best among those of their 3 x 3, and fits again, twice.
void reassign_borders(const Grid& grid, int threads, ReassignBuffers& buffers, Regions& regions);

/// Says how certain each region is, whose cells reassign_borders has left in its buffers, and drops those with less than
/// `min_confidence`.
void judge_regions(const Grid& grid, double min_confidence, int threads, const ReassignBuffers& reassigned,
                   JudgeBuffersOfTasks& buffers, Regions& regions);

}  // namespace fransac::cells
