// SPDX-License-Identifier: Apache-2.0
#include "kernels/cell_sets.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "kernels/cell_sets.cc"
#include "hwy/foreach_target.h"  // compiles what follows once per instruction set
// clang-format off
#include "kernels/cell_sets-inl.h"
// clang-format on

#if HWY_ONCE
namespace fransac::kernels {

HWY_EXPORT(FindOnPlane);
HWY_EXPORT(FindLinks);
HWY_EXPORT(SumCells);
HWY_EXPORT(SumShape);
HWY_EXPORT(SumErrors);
HWY_EXPORT(FindNearest);
HWY_EXPORT(MeasureDifferences);
HWY_EXPORT(CountLess);
HWY_EXPORT(MeasureBlocks);
HWY_EXPORT(SumPixels);

void find_on_plane(const CellArrays& row, const float* slack, std::size_t cells, const CellSetPlane& plane, std::uint64_t* set) {
  HWY_DYNAMIC_DISPATCH(FindOnPlane)(row, slack, cells, plane, set);
}

void find_links(const CellArrays& row, const float* shape, std::size_t cells, std::ptrdiff_t step, const CellLinkLimits& limits,
                std::uint64_t* set) {
  HWY_DYNAMIC_DISPATCH(FindLinks)(row, shape, cells, step, limits, set);
}

CellSetSums sum_cells(const CellArrays& first, const std::uint64_t* set, std::size_t rows, std::size_t words,
                      const CellSetPlane& plane) {
  return HWY_DYNAMIC_DISPATCH(SumCells)(first, set, rows, words, plane);
}

CellSetShape sum_shape(const CellArrays& first, const std::uint64_t* set, std::size_t rows, std::size_t words,
                       const CellSetPlane& plane) {
  return HWY_DYNAMIC_DISPATCH(SumShape)(first, set, rows, words, plane);
}

CellSetErrors sum_errors(const CellArrays& first, const float* sigma, const std::uint64_t* set, std::size_t rows,
                         std::size_t words) {
  return HWY_DYNAMIC_DISPATCH(SumErrors)(first, sigma, set, rows, words);
}

void find_nearest(const CellArrays& row, const float* slack, std::size_t cells, const CellSetPlane& plane,
                  const std::uint64_t* set, std::int32_t id, float* least, std::int32_t* nearest) {
  HWY_DYNAMIC_DISPATCH(FindNearest)(row, slack, cells, plane, set, id, least, nearest);
}

void measure_differences(const float* n, const float* values, const float* shape, std::size_t cells, std::ptrdiff_t step,
                         float least, float* out) {
  HWY_DYNAMIC_DISPATCH(MeasureDifferences)(n, values, shape, cells, step, least, out);
}

std::size_t count_less(const float* values, std::size_t count, float limit) {
  return HWY_DYNAMIC_DISPATCH(CountLess)(values, count, limit);
}

void measure_blocks(const CellArrays& row, const float* weight, const float* shape, std::size_t cells, const CellBlock& block,
                    float most_noise, float most_m, float* flatness) {
  HWY_DYNAMIC_DISPATCH(MeasureBlocks)(row, weight, shape, cells, block, most_noise, most_m, flatness);
}

PixelSums sum_pixels(const std::uint8_t* count, const float* q, std::size_t cells, float on_plane, float du, float least) {
  return HWY_DYNAMIC_DISPATCH(SumPixels)(count, q, cells, on_plane, du, least);
}

}  // namespace fransac::kernels
#endif  // HWY_ONCE
