// SPDX-License-Identifier: Apache-2.0
// Vector code over sets of cells: which lie on a plane, the moments of a set, how flat blocks of cells are. Raw pointers only.
//
// A set has one bit per cell, in rows of `words` 64-bit words; bits beyond a row's cells are 0.
#pragma once

#include <cstddef>
#include <cstdint>

namespace fransac::kernels {

inline constexpr int kWordBits = 64;
/// Words that hold a row of so many cells.
constexpr std::size_t words_of(std::size_t cells) { return (cells + kWordBits - 1) / kWordBits; }

/// Cells row by row, the first of the next `stride` after that of this one; each array can be read up to 64 values beyond its
/// last cell. What each is says kernels::CellMoments, but u and v have the same origin in all cells.
struct CellArrays {
  const float* n;
  const float* u;
  const float* v;
  const float* q;
  const float* uu;
  const float* uv;
  const float* vv;
  const float* du;
  const float* dv;
  const float* residual;
  std::ptrdiff_t stride;
};

/// q = q0 + du (u - u0) + dv (v - v0).
struct CellSetPlane {
  float u0;
  float v0;
  float q0;
  float du;
  float dv;
};

/// Sums over pixels of 1, u, v, r and their products, where u and v count from a plane's (u0, v0) and r is q less the plane's.
struct CellSetSums {
  float n, u, v, r, uu, uv, vv, ur, vr, rr;
  std::int32_t cells;
};

/// What neighbouring cells of one smooth surface may differ by. Their means: squares of a multiple of the cells' shape, in
/// inverse depth, and of a length in metres. Their slopes, times slope_u and slope_v: the same, and the square of a bend in
/// radians where the slopes are times the focal lengths.
struct CellLinkLimits {
  float jump_noise;
  float jump_m;
  float slope_u;
  float slope_v;
  float bend_noise;
  float bend_m;
  float bend_rad;
};

/// Sums over cells that tell how a set curves and how well its cells agree. Positions x, y are in cells from a plane's (u0, v0).
struct CellSetShape {
  /// Of 1, x, x^2, x^3, x^4, y, x y, x^2 y, x^3 y, y^2, x y^2, x^2 y^2, y^3, x y^3, y^4.
  static constexpr int kPositions = 15;
  /// Of q less the plane's times 1, x, x^2, y, x y, y^2.
  static constexpr int kOffsets = 6;
  float position[kPositions];
  float offset[kOffsets];
  float off;    ///< Of the square of q less the plane's,
  float slope;  ///< of the squares of the slopes less the plane's, over half a cell.
};

/// Blocks of rows x columns cells: the first of them is up and left cells before the one that stands for the block.
struct CellBlock {
  int rows;
  int columns;
  int up;
  int left;
  int least;  ///< Cells that are needed.
};

/// The set of one row's cells whose mean and whose slopes over half a cell are off a plane by no more than sqrt(slack) each.
void find_on_plane(const CellArrays& row, const float* slack, std::size_t cells, const CellSetPlane& plane, std::uint64_t* set);

/// The set of one row's cells from which the surface goes on into the cells `step` further: their means differ by what their mean
/// slopes make, and the slopes are the same, within limits; the larger shape of the two counts.
void find_links(const CellArrays& row, const float* shape, std::size_t cells, std::ptrdiff_t step, const CellLinkLimits& limits,
                std::uint64_t* set);

/// Sums over the cells of a set, `rows` rows of `words` words.
CellSetSums sum_cells(const CellArrays& first, const std::uint64_t* set, std::size_t rows, std::size_t words,
                      const CellSetPlane& plane);

/// The same for the set's shape.
CellSetShape sum_shape(const CellArrays& first, const std::uint64_t* set, std::size_t rows, std::size_t words,
                       const CellSetPlane& plane);

/// Sums over the cells of a set: of sigma^2 and of q^4. `sigma` is the first row's.
struct CellSetErrors {
  float variance;
  float q4;
};
CellSetErrors sum_errors(const CellArrays& first, const float* sigma, const std::uint64_t* set, std::size_t rows,
                         std::size_t words);

/// Where a cell of one row's set is on the plane, as find_on_plane says, and nearer to it than `least`: makes `nearest` the
/// plane's id, and `least` the sum of the squared distances of its mean and of its slopes over half a cell.
void find_nearest(const CellArrays& row, const float* slack, std::size_t cells, const CellSetPlane& plane,
                  const std::uint64_t* set, std::int32_t id, float* least, std::int32_t* nearest);

/// For one row of cells: |value less the mean of those `step` before and behind| over the shape; kNone where one of the three has
/// n < least.
inline constexpr float kNone = 1e30F;
void measure_differences(const float* n, const float* values, const float* shape, std::size_t cells, std::ptrdiff_t step,
                         float least, float* out);

/// How many values are less than a limit.
std::size_t count_less(const float* values, std::size_t count, float limit);

/// For one row of cells: the mean squared residual of the plane through the block of each, as if every cell had all pixels, over
/// the square of its `shape`. kNotFlat where the cell itself or too many others have weight 0, or where the residual is more than
/// most_noise shape^2 + most_m q^4. Weights are 0 or 1.
inline constexpr float kNotFlat = 1e30F;
void measure_blocks(const CellArrays& row, const float* weight, const float* shape, std::size_t cells, const CellBlock& block,
                    float most_noise, float most_m, float* flatness);

/// Sums over pixels on a plane that count for the cells of a run: of 1, z, z column and z^3, where z is the plane's at the cell's
/// centre and columns are pixels from the first cell's centre. `count[i]` pixels are the cell's. Where the plane is near its
/// horizon, with less than `kHorizon` of the cell's own inverse depth q[i], that is taken. Inverse depths count as no less than
/// `least`. Arrays can be read up to 64 values beyond the run.
struct PixelSums {
  float n, z, zu, zzz;
};
inline constexpr float kHorizon = 0.8F;
PixelSums sum_pixels(const std::uint8_t* count, const float* q, std::size_t cells, float on_plane, float du, float least);

namespace ref {
/// The scalar truth, in double; all agree to rounding.
void find_on_plane(const CellArrays& row, const float* slack, std::size_t cells, const CellSetPlane& plane, std::uint64_t* set);
void find_links(const CellArrays& row, const float* shape, std::size_t cells, std::ptrdiff_t step, const CellLinkLimits& limits,
                std::uint64_t* set);
CellSetSums sum_cells(const CellArrays& first, const std::uint64_t* set, std::size_t rows, std::size_t words,
                      const CellSetPlane& plane);
CellSetShape sum_shape(const CellArrays& first, const std::uint64_t* set, std::size_t rows, std::size_t words,
                       const CellSetPlane& plane);
CellSetErrors sum_errors(const CellArrays& first, const float* sigma, const std::uint64_t* set, std::size_t rows,
                         std::size_t words);
void find_nearest(const CellArrays& row, const float* slack, std::size_t cells, const CellSetPlane& plane,
                  const std::uint64_t* set, std::int32_t id, float* least, std::int32_t* nearest);
void measure_differences(const float* n, const float* values, const float* shape, std::size_t cells, std::ptrdiff_t step,
                         float least, float* out);
void measure_blocks(const CellArrays& row, const float* weight, const float* shape, std::size_t cells, const CellBlock& block,
                    float most_noise, float most_m, float* flatness);
std::size_t count_less(const float* values, std::size_t count, float limit);
PixelSums sum_pixels(const std::uint8_t* count, const float* q, std::size_t cells, float on_plane, float du, float least);
}  // namespace ref

}  // namespace fransac::kernels
