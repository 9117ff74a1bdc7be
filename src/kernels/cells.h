// SPDX-License-Identifier: Apache-2.0
// Vector code over one row of cells of a depth image: `side` rows of pixels. Raw pointers only.
//
// Rows of pixels are as in rows.h: `cells * side` raw values and what is missing to a multiple of 8, 0 where nothing was
// measured. A cell is `side` x `side` pixels, 8, 4 or 2, and always kCell x kCell samples: of larger pixels each is several. A
// pixel's inverse depth is q = 1 / (raw * metres_per_unit), per metre.
#pragma once

#include <cstddef>
#include <cstdint>

#include "kernels/rows.h"

namespace fransac::kernels {

inline constexpr int kCell = 8;
static_assert(kBlock % kCell == 0);

/// The pixel rows of one row of cells, the first `side`; rows below the image are rows of zeros.
template <class Raw>
struct CellRows {
  const Raw* rows[kCell];
};

/// What the pixels of each cell measured; one value per cell. Columns and rows count from the cell's centre, samples, each pixel
/// at its own centre; a measurement is as many samples as its pixel. Cells with fewer than `least` measurements, or whose
/// measurements lie on a line or average kMostInverseDepth, have n = 0 and mean_squared_residual = kNoFit; their other values are
/// 0.
struct CellMoments {
  float* n;   ///< Measurements, samples.
  float* u;   ///< Mean column.
  float* v;   ///< Mean row.
  float* q;   ///< Mean inverse depth.
  float* uu;  ///< Mean squares and products about the means.
  float* uv;
  float* vv;
  float* du;  ///< Least-squares slopes of q.
  float* dv;
  float* mean_squared_residual;  ///< Of q about that plane, over n.
};
inline constexpr float kNoFit = 1e30F;
/// Measurements whose positions have a smaller determinant of their second moments, samples^4, lie on a line: one row of kCell
/// samples with a single one in the next has 0.55.
inline constexpr float kLeastSpread = 0.5F;
/// No depth that a sensor gives, but one that a file may hold. Squares of 64 times that still stay below kNoFit.
inline constexpr float kMostInverseDepth = 1e13F;

/// A plane in inverse depth: q = base + du * column + dv * row, with the row of cells' first pixel as (0, 0).
struct CellPlane {
  float base;
  float du;
  float dv;
  std::uint8_t label;
};

/// A measurement with depth z belongs to a plane whose inverse depth there is q when |z q - 1| z <= tolerance * z^2 + floor_m:
/// the noise of inverse depth, and metres.
struct CellTolerance {
  const float* per_cell;  ///< Of inverse depth, per metre; one for each cell of the image's row. Whole vectors are read.
  float floor_m;
};

/// What one plane got of a run of cells.
struct CellRunEvidence {
  std::uint8_t* count;     ///< Pixels, one value per cell of the run.
  float squared_residual;  ///< Sum of (z q - 1)^2 over them; the distance to the plane is |d| times that.
};

/// Most planes that compete for a cell: those of its 3 x 3 neighbours.
inline constexpr std::size_t kMostCandidates = 9;

template <class Raw>
struct CellKernels {
  /// Moments and planes of `cells` cells; how many pixels are measured, those of cells without a plane too.
  std::size_t (*moments)(const CellRows<Raw>& rows, std::size_t cells, float metres_per_unit, float least,
                         const CellMoments& out);
  /// Labels the cells [first, first + cells), which have the same candidates, 1 to kMostCandidates: 0 where nothing was measured,
  /// the label of the plane with the smallest |z q - 1| it belongs to (of equal ones the first), or 255. `labels` are the image's
  /// rows of labels, each with room for whole cells. `evidence` has one entry per candidate; counts start at `first`.
  void (*label)(const CellRows<Raw>& rows, std::size_t first, std::size_t cells, float metres_per_unit, const CellPlane* planes,
                std::size_t num_planes, const CellTolerance& tolerance, std::uint8_t* const* labels, CellRunEvidence* evidence);
  /// The same without a candidate: 0 or 255.
  void (*label_none)(const CellRows<Raw>& rows, std::size_t first, std::size_t cells, std::uint8_t* const* labels);
  /// How many measurements of one cell belong to a plane, and how many there are.
  struct Fits {
    std::uint32_t fitting;
    std::uint32_t measured;
  };
  Fits (*fits)(const CellRows<Raw>& rows, std::size_t cell, float metres_per_unit, const CellPlane& plane,
               const CellTolerance& tolerance);
};

/// The functions for this machine's best instruction set; Raw is std::uint16_t or float, `side` 8, 4 or 2.
template <class Raw>
const CellKernels<Raw>& cell_kernels(int side);
template <>
const CellKernels<std::uint16_t>& cell_kernels(int side);
template <>
const CellKernels<float>& cell_kernels(int side);

namespace ref {
/// The scalar truth; all agree to rounding.
template <class Raw>
const CellKernels<Raw>& cell_kernels(int side);
template <>
const CellKernels<std::uint16_t>& cell_kernels(int side);
template <>
const CellKernels<float>& cell_kernels(int side);
}  // namespace ref

}  // namespace fransac::kernels
