// SPDX-License-Identifier: Apache-2.0
// Bodies for vectors of four or eight floats, compiled once per instruction set by cell_sets.cc. See cell_sets.h for what each
// computes.
// The usual include guard of Highway: this file is read once per target.
#if defined(FRANSAC_KERNELS_CELL_SETS_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef FRANSAC_KERNELS_CELL_SETS_INL_H_
#undef FRANSAC_KERNELS_CELL_SETS_INL_H_
#else
#define FRANSAC_KERNELS_CELL_SETS_INL_H_
#endif

#include <algorithm>

#include "hwy/highway.h"
#include "kernels/cell_sets.h"
#include "kernels/cells.h"
#include "kernels/lanes-inl.h"

HWY_BEFORE_NAMESPACE();
namespace fransac::kernels {
namespace HWY_NAMESPACE {
#if HWY_TARGET == HWY_SCALAR

void FindOnPlane(const CellArrays& row, const float* slack, std::size_t cells, const CellSetPlane& plane, std::uint64_t* set) {
  ref::find_on_plane(row, slack, cells, plane, set);
}
void FindLinks(const CellArrays& row, const float* shape, std::size_t cells, std::ptrdiff_t step, const CellLinkLimits& limits,
               std::uint64_t* set) {
  ref::find_links(row, shape, cells, step, limits, set);
}
CellSetSums SumCells(const CellArrays& first, const std::uint64_t* set, std::size_t rows, std::size_t words,
                     const CellSetPlane& plane) {
  return ref::sum_cells(first, set, rows, words, plane);
}
CellSetShape SumShape(const CellArrays& first, const std::uint64_t* set, std::size_t rows, std::size_t words,
                      const CellSetPlane& plane) {
  return ref::sum_shape(first, set, rows, words, plane);
}
CellSetErrors SumErrors(const CellArrays& first, const float* sigma, const std::uint64_t* set, std::size_t rows,
                        std::size_t words) {
  return ref::sum_errors(first, sigma, set, rows, words);
}
void FindNearest(const CellArrays& row, const float* slack, std::size_t cells, const CellSetPlane& plane,
                 const std::uint64_t* set, std::int32_t id, float* least, std::int32_t* nearest) {
  ref::find_nearest(row, slack, cells, plane, set, id, least, nearest);
}
void MeasureDifferences(const float* n, const float* values, const float* shape, std::size_t cells, std::ptrdiff_t step,
                        float least, float* out) {
  ref::measure_differences(n, values, shape, cells, step, least, out);
}
std::size_t CountLess(const float* values, std::size_t count, float limit) { return ref::count_less(values, count, limit); }
void MeasureBlocks(const CellArrays& row, const float* weight, const float* shape, std::size_t cells, const CellBlock& block,
                   float most_noise, float most_m, float* flatness) {
  ref::measure_blocks(row, weight, shape, cells, block, most_noise, most_m, flatness);
}
PixelSums SumPixels(const std::uint8_t* count, const float* q, std::size_t cells, float on_plane, float du, float least) {
  return ref::sum_pixels(count, q, cells, on_plane, du, least);
}

#else
namespace cell_sets {
namespace hn = hwy::HWY_NAMESPACE;

using namespace lanes;

HWY_INLINE Float Set(float value) { return hn::Set(FloatTag(), value); }
HWY_INLINE Float Get(const float* HWY_RESTRICT values, std::ptrdiff_t i) { return hn::LoadU(FloatTag(), values + i); }

struct PlaneVectors {
  Float u0, v0, q0, du, dv;
};
HWY_INLINE PlaneVectors Vectors(const CellSetPlane& plane) {
  return {Set(plane.u0), Set(plane.v0), Set(plane.q0), Set(plane.du), Set(plane.dv)};
}
HWY_INLINE Float Offset(const CellArrays& cells, std::ptrdiff_t i, Float x, Float y, const PlaneVectors& p) {
  return hn::NegMulAdd(p.dv, y, hn::NegMulAdd(p.du, x, hn::Sub(Get(cells.q, i), p.q0)));
}

/// Squared distances of means, and of slopes over half a cell.
struct Distance {
  Float mean, slope;
};
HWY_INLINE Distance DistanceOf(const CellArrays& cells, std::ptrdiff_t i, const PlaneVectors& p) {
  const Float off = Offset(cells, i, hn::Sub(Get(cells.u, i), p.u0), hn::Sub(Get(cells.v, i), p.v0), p);
  const Float half = Set(0.5F * kCell);
  const Float a = hn::Mul(half, hn::Sub(Get(cells.du, i), p.du));
  const Float b = hn::Mul(half, hn::Sub(Get(cells.dv, i), p.dv));
  return {hn::Mul(off, off), hn::MulAdd(a, a, hn::Mul(b, b))};
}

/// Calls visit(first cell, mask) for the cells of a set, some at a time.
template <class Visitor>
HWY_INLINE void ForEach(const std::uint64_t* HWY_RESTRICT set, std::size_t rows, std::size_t words, std::ptrdiff_t stride,
                        const Visitor& visit) {
  for (std::size_t row = 0; row < rows; ++row) {
    for (std::size_t w = 0; w < words; ++w) {
      std::uint64_t word = set[row * words + w];
      std::ptrdiff_t i = static_cast<std::ptrdiff_t>(row) * stride + static_cast<std::ptrdiff_t>(w * kWordBits);
      for (; word != 0; word >>= kLanes, i += kLanes) {
        const std::uint64_t bits = word & ((1U << kLanes) - 1U);
        if (bits != 0) visit(i, FromBits(bits));
      }
    }
  }
}

HWY_INLINE float Sum(Float values) { return hn::GetLane(hn::SumOfLanes(FloatTag(), values)); }

struct Sums {
  Float n, u, v, r, uu, uv, vv, ur, vr, rr;
};
HWY_INLINE Sums NoSums() {
  const Float zero = Set(0.0F);
  return {zero, zero, zero, zero, zero, zero, zero, zero, zero, zero};
}

/// Adds what the cells from `i` on have, those of the mask.
HWY_INLINE void AddCells(const CellArrays& cells, std::ptrdiff_t i, Mask mask, const PlaneVectors& p, Sums& sums) {
  const Float n = hn::IfThenElseZero(mask, Get(cells.n, i));
  // What is not in the set may be anything, NaN too.
  const Float x = hn::IfThenElseZero(mask, hn::Sub(Get(cells.u, i), p.u0));
  const Float y = hn::IfThenElseZero(mask, hn::Sub(Get(cells.v, i), p.v0));
  const Float off = hn::IfThenElseZero(mask, Offset(cells, i, x, y, p));
  const Float a = hn::IfThenElseZero(mask, hn::Sub(Get(cells.du, i), p.du));
  const Float b = hn::IfThenElseZero(mask, hn::Sub(Get(cells.dv, i), p.dv));
  const Float xx = hn::IfThenElseZero(mask, Get(cells.uu, i));
  const Float xy = hn::IfThenElseZero(mask, Get(cells.uv, i));
  const Float yy = hn::IfThenElseZero(mask, Get(cells.vv, i));
  const Float xr = hn::MulAdd(xx, a, hn::Mul(xy, b));
  const Float yr = hn::MulAdd(xy, a, hn::Mul(yy, b));
  const Float inside = hn::MulAdd(a, xr, hn::MulAdd(b, yr, hn::IfThenElseZero(mask, Get(cells.residual, i))));
  sums.n = hn::Add(sums.n, n);
  sums.u = hn::MulAdd(n, x, sums.u);
  sums.v = hn::MulAdd(n, y, sums.v);
  sums.r = hn::MulAdd(n, off, sums.r);
  sums.uu = hn::MulAdd(n, hn::MulAdd(x, x, xx), sums.uu);
  sums.uv = hn::MulAdd(n, hn::MulAdd(x, y, xy), sums.uv);
  sums.vv = hn::MulAdd(n, hn::MulAdd(y, y, yy), sums.vv);
  sums.ur = hn::MulAdd(n, hn::MulAdd(x, off, xr), sums.ur);
  sums.vr = hn::MulAdd(n, hn::MulAdd(y, off, yr), sums.vr);
  sums.rr = hn::MulAdd(n, hn::MulAdd(off, off, inside), sums.rr);
}

/// The same for blocks of full cells: `i` of each is the cell that stands for it.
HWY_INLINE void AddToBlocks(const CellArrays& cells, const float* weight, std::ptrdiff_t i, std::ptrdiff_t j, float x, float y,
                            Sums& sums) {
  constexpr float kSpread = (kCell * kCell - 1.0F) / 12.0F;  // mean square of a cell's columns about their mean
  const Float n = Get(weight, j);
  const Mask has = hn::Gt(n, Set(0.0F));
  const Float du = Get(cells.du, i);
  const Float dv = Get(cells.dv, i);
  const Float off =
      hn::IfThenElseZero(has, hn::NegMulAdd(dv, Set(y), hn::NegMulAdd(du, Set(x), hn::Sub(Get(cells.q, j), Get(cells.q, i)))));
  const Float a = hn::IfThenElseZero(has, hn::Sub(Get(cells.du, j), du));
  const Float b = hn::IfThenElseZero(has, hn::Sub(Get(cells.dv, j), dv));
  const Float inside = hn::MulAdd(Set(kSpread), hn::MulAdd(a, a, hn::Mul(b, b)), hn::IfThenElseZero(has, Get(cells.residual, j)));
  sums.n = hn::Add(sums.n, n);
  sums.u = hn::MulAdd(n, Set(x), sums.u);
  sums.v = hn::MulAdd(n, Set(y), sums.v);
  sums.r = hn::Add(off, sums.r);
  sums.uu = hn::MulAdd(n, Set(kSpread + x * x), sums.uu);
  sums.uv = hn::MulAdd(n, Set(x * y), sums.uv);
  sums.vv = hn::MulAdd(n, Set(kSpread + y * y), sums.vv);
  sums.ur = hn::MulAdd(Set(x), off, hn::MulAdd(Set(kSpread), a, sums.ur));
  sums.vr = hn::MulAdd(Set(y), off, hn::MulAdd(Set(kSpread), b, sums.vr));
  sums.rr = hn::Add(sums.rr, hn::MulAdd(off, off, inside));
}

/// The mean squared residual of the plane through each block.
HWY_INLINE Float Residual(const Sums& s) {
  const Float per_n = hn::Div(Set(1.0F), hn::Max(s.n, Set(1.0F)));
  const Float u = hn::Mul(s.u, per_n);
  const Float v = hn::Mul(s.v, per_n);
  const Float r = hn::Mul(s.r, per_n);
  const Float uu = hn::NegMulAdd(u, s.u, s.uu);
  const Float uv = hn::NegMulAdd(u, s.v, s.uv);
  const Float vv = hn::NegMulAdd(v, s.v, s.vv);
  const Float ur = hn::NegMulAdd(u, s.r, s.ur);
  const Float vr = hn::NegMulAdd(v, s.r, s.vr);
  const Float rr = hn::NegMulAdd(r, s.r, s.rr);
  const Float det = hn::NegMulAdd(uv, uv, hn::Mul(uu, vv));
  const Float by_u = hn::NegMulAdd(uv, vr, hn::Mul(vv, ur));
  const Float by_v = hn::NegMulAdd(uv, ur, hn::Mul(uu, vr));
  const Float explained = hn::Div(hn::MulAdd(by_u, ur, hn::Mul(by_v, vr)), det);
  return hn::Mul(hn::Max(hn::Sub(rr, explained), Set(0.0F)), per_n);
}

/// Stores values for a row's cells from `first` on, none beyond its end.
HWY_INLINE void StoreRow(Float values, std::size_t first, std::size_t cells, float* HWY_RESTRICT row) {
  const FloatTag d;
  if (first + kLanes <= cells) {
    hn::StoreU(values, d, row + first);
    return;
  }
  float rest[kLanes];
  hn::StoreU(values, d, rest);
  std::copy_n(rest, cells - first, row + first);
}

/// The set of the cells for which test(first of some) says so.
template <class Test>
HWY_INLINE void MakeSet(std::size_t cells, std::uint64_t* HWY_RESTRICT set, const Test& test) {
  for (std::size_t first = 0; first < cells; first += kWordBits) {
    std::uint64_t word = 0;
    const std::size_t end = std::min<std::size_t>(kWordBits, cells - first);
    for (std::size_t k = 0; k < end; k += kLanes) word |= Bits(test(static_cast<std::ptrdiff_t>(first + k))) << k;
    if (end < kWordBits) word &= (std::uint64_t{1} << end) - 1;
    set[first / kWordBits] = word;
  }
}

}  // namespace cell_sets

void FindOnPlane(const CellArrays& row, const float* HWY_RESTRICT slack, std::size_t cells, const CellSetPlane& plane,
                 std::uint64_t* HWY_RESTRICT set) {
  using namespace cell_sets;
  const PlaneVectors p = Vectors(plane);
  MakeSet(cells, set, [&](std::ptrdiff_t i) HWY_ATTR {
    const Distance far = DistanceOf(row, i, p);
    return hn::Le(hn::Max(far.mean, far.slope), Get(slack, i));
  });
}

void FindLinks(const CellArrays& row, const float* shape, std::size_t cells, std::ptrdiff_t step, const CellLinkLimits& limits,
               std::uint64_t* HWY_RESTRICT set) {
  using namespace cell_sets;
  const Float half = Set(0.5F);
  const Float slope_u = Set(limits.slope_u), slope_v = Set(limits.slope_v);
  const Float jump_noise = Set(limits.jump_noise), jump_m = Set(limits.jump_m);
  const Float bend_noise = Set(limits.bend_noise), bend_m = Set(limits.bend_m), bend_rad = Set(limits.bend_rad);
  MakeSet(cells, set, [&](std::ptrdiff_t i) HWY_ATTR {
    const std::ptrdiff_t j = i + step;
    const auto difference = [&](const float* values) HWY_ATTR { return hn::Sub(Get(values, j), Get(values, i)); };
    const auto mean = [&](const float* values) HWY_ATTR { return hn::Mul(half, hn::Add(Get(values, j), Get(values, i))); };
    const Float jump =
        hn::NegMulAdd(mean(row.dv), difference(row.v), hn::NegMulAdd(mean(row.du), difference(row.u), difference(row.q)));
    const Float a = hn::Mul(slope_u, difference(row.du));
    const Float b = hn::Mul(slope_v, difference(row.dv));
    const Float larger = hn::Max(Get(shape, i), Get(shape, j));
    const Float noise = hn::Mul(larger, larger);
    const Float q = mean(row.q);
    const Float squared = hn::Mul(q, q);
    const Float fourth = hn::Mul(squared, squared);
    const Mask level = hn::Le(hn::Mul(jump, jump), hn::MulAdd(jump_noise, noise, hn::Mul(jump_m, fourth)));
    const Float most = hn::MulAdd(bend_noise, noise, hn::MulAdd(bend_m, fourth, hn::Mul(bend_rad, squared)));
    const Mask straight = hn::Le(hn::MulAdd(a, a, hn::Mul(b, b)), most);
    return hn::And(level, straight);
  });
}

CellSetSums SumCells(const CellArrays& first, const std::uint64_t* HWY_RESTRICT set, std::size_t rows, std::size_t words,
                     const CellSetPlane& plane) {
  using namespace cell_sets;
  const PlaneVectors p = Vectors(plane);
  Sums sums = NoSums();
  std::size_t cells = 0;
  for (std::size_t i = 0; i < rows * words; ++i) cells += hwy::PopCount(set[i]);
  ForEach(set, rows, words, first.stride, [&](std::ptrdiff_t i, Mask mask) HWY_ATTR { AddCells(first, i, mask, p, sums); });
  return {Sum(sums.n),
          Sum(sums.u),
          Sum(sums.v),
          Sum(sums.r),
          Sum(sums.uu),
          Sum(sums.uv),
          Sum(sums.vv),
          Sum(sums.ur),
          Sum(sums.vr),
          Sum(sums.rr),
          static_cast<std::int32_t>(cells)};
}

CellSetShape SumShape(const CellArrays& first, const std::uint64_t* HWY_RESTRICT set, std::size_t rows, std::size_t words,
                      const CellSetPlane& plane) {
  using namespace cell_sets;
  const PlaneVectors p = Vectors(plane);
  const Float per_cell = Set(1.0F / kCell);
  Float position[CellSetShape::kPositions];
  Float offset[CellSetShape::kOffsets];
  for (Float& sum : position) sum = Set(0.0F);
  for (Float& sum : offset) sum = Set(0.0F);
  Float off = Set(0.0F);
  Float slope = Set(0.0F);
  ForEach(set, rows, words, first.stride, [&](std::ptrdiff_t i, Mask mask) HWY_ATTR {
    const Float u = hn::IfThenElseZero(mask, hn::Sub(Get(first.u, i), p.u0));
    const Float v = hn::IfThenElseZero(mask, hn::Sub(Get(first.v, i), p.v0));
    const Float r = hn::IfThenElseZero(mask, Offset(first, i, u, v, p));
    const Float x = hn::Mul(u, per_cell);
    const Float y = hn::Mul(v, per_cell);
    // The powers of y, each times one in the set and nothing elsewhere, times those of x.
    int at = 0;
    int offset_at = 0;
    Float power = hn::IfThenElseZero(mask, Set(1.0F));
    Float of_offset = r;
    for (int b = 0; b <= 4; ++b) {
      Float product = power;
      Float offset_product = of_offset;
      for (int a = 0; a + b <= 4; ++a) {
        position[at] = hn::Add(position[at], product);
        ++at;
        product = hn::Mul(product, x);
        if (a + b > 2) continue;
        offset[offset_at] = hn::Add(offset[offset_at], offset_product);
        ++offset_at;
        offset_product = hn::Mul(offset_product, x);
      }
      power = hn::Mul(power, y);
      of_offset = hn::Mul(of_offset, y);
    }
    off = hn::MulAdd(r, r, off);
    slope = hn::Add(slope, hn::IfThenElseZero(mask, DistanceOf(first, i, p).slope));
  });
  CellSetShape shape;
  for (int k = 0; k < CellSetShape::kPositions; ++k) shape.position[k] = Sum(position[k]);
  for (int k = 0; k < CellSetShape::kOffsets; ++k) shape.offset[k] = Sum(offset[k]);
  shape.off = Sum(off);
  shape.slope = Sum(slope);
  return shape;
}

CellSetErrors SumErrors(const CellArrays& first, const float* HWY_RESTRICT sigma, const std::uint64_t* HWY_RESTRICT set,
                        std::size_t rows, std::size_t words) {
  using namespace cell_sets;
  Float variance = Set(0.0F);
  Float q4 = Set(0.0F);
  ForEach(set, rows, words, first.stride, [&](std::ptrdiff_t i, Mask mask) HWY_ATTR {
    const Float s = hn::IfThenElseZero(mask, Get(sigma, i));
    const Float q = hn::IfThenElseZero(mask, Get(first.q, i));
    const Float qq = hn::Mul(q, q);
    variance = hn::MulAdd(s, s, variance);
    q4 = hn::MulAdd(qq, qq, q4);
  });
  return {Sum(variance), Sum(q4)};
}

void FindNearest(const CellArrays& row, const float* HWY_RESTRICT slack, std::size_t cells, const CellSetPlane& plane,
                 const std::uint64_t* HWY_RESTRICT set, std::int32_t id, float* HWY_RESTRICT least,
                 std::int32_t* HWY_RESTRICT nearest) {
  using namespace cell_sets;
  const FloatTag d;
  const hn::RebindToSigned<FloatTag> di;
  const PlaneVectors p = Vectors(plane);
  const auto ids = hn::Set(di, id);
  ForEach(set, 1, words_of(cells), 0, [&](std::ptrdiff_t i, Mask mask) HWY_ATTR {
    const Distance far = DistanceOf(row, i, p);
    const Float sum = hn::Add(far.mean, far.slope);
    const Float before = Get(least, i);
    const Mask on = hn::And(mask, hn::Le(hn::Max(far.mean, far.slope), Get(slack, i)));
    const Mask nearer = hn::And(on, hn::Lt(sum, before));
    hn::StoreU(hn::IfThenElse(nearer, sum, before), d, least + i);
    hn::StoreU(hn::IfThenElse(hn::RebindMask(di, nearer), ids, hn::LoadU(di, nearest + i)), di, nearest + i);
  });
}

void MeasureDifferences(const float* n, const float* values, const float* shape, std::size_t cells, std::ptrdiff_t step,
                        float least, float* HWY_RESTRICT out) {
  using namespace cell_sets;
  for (std::size_t k = 0; k < cells; k += kLanes) {
    const auto i = static_cast<std::ptrdiff_t>(k);
    const Float mean = hn::Mul(Set(0.5F), hn::Add(Get(values, i - step), Get(values, i + step)));
    const Float difference = hn::Div(hn::Abs(hn::Sub(Get(values, i), mean)), Get(shape, i));
    const Float fewest = hn::Min(Get(n, i), hn::Min(Get(n, i - step), Get(n, i + step)));
    const Float result = hn::IfThenElse(hn::Ge(fewest, Set(least)), difference, Set(kNone));
    StoreRow(result, k, cells, out);
  }
}

std::size_t CountLess(const float* HWY_RESTRICT values, std::size_t count, float limit) {
  using namespace cell_sets;
  const FloatTag d;
  const hn::RebindToSigned<FloatTag> di;
  const Float most = Set(limit);
  auto less = hn::Zero(di);  // -1 of each that is
  std::size_t i = 0;
  for (; i + kLanes <= count; i += kLanes) {
    less = hn::Add(less, hn::BitCast(di, hn::VecFromMask(d, hn::Lt(hn::LoadU(d, values + i), most))));
  }
  auto total = static_cast<std::size_t>(-hn::GetLane(hn::SumOfLanes(di, less)));
  for (; i < count; ++i) total += static_cast<std::size_t>(values[i] < limit);
  return total;
}

void MeasureBlocks(const CellArrays& row, const float* weight, const float* shape, std::size_t cells, const CellBlock& block,
                   float most_noise, float most_m, float* HWY_RESTRICT flatness) {
  using namespace cell_sets;
  const FloatTag d;
  for (std::size_t k = 0; k < cells; k += kLanes) {
    const auto i = static_cast<std::ptrdiff_t>(k);
    const Mask has = hn::Gt(Get(weight, i), hn::Zero(d));
    Float result = Set(kNotFlat);
    if (!hn::AllFalse(d, has)) {
      Sums sums = NoSums();
      for (int y = -block.up; y < block.rows - block.up; ++y) {
        for (int x = -block.left; x < block.columns - block.left; ++x) {
          AddToBlocks(row, weight, i, i + y * row.stride + x, static_cast<float>(x * kCell), static_cast<float>(y * kCell), sums);
        }
      }
      const Float s = hn::Mul(Get(shape, i), Get(shape, i));
      const Float q = hn::Mul(Get(row.q, i), Get(row.q, i));
      const Float residual = Residual(sums);
      const Float most = hn::MulAdd(Set(most_noise), s, hn::Mul(Set(most_m), hn::Mul(q, q)));
      const Mask enough = hn::And(has, hn::Ge(sums.n, Set(static_cast<float>(block.least))));
      result = hn::IfThenElse(hn::And(enough, hn::Le(residual, most)), hn::Div(residual, s), result);
    }
    StoreRow(result, k, cells, flatness);
  }
}

PixelSums SumPixels(const std::uint8_t* HWY_RESTRICT count, const float* HWY_RESTRICT q, std::size_t cells, float on_plane,
                    float du, float least) {
  using namespace cell_sets;
  const FloatTag d;
  const hn::Rebind<std::uint8_t, FloatTag> d8;
  const hn::Rebind<std::int32_t, FloatTag> d32;
  Float n = hn::Zero(d), z = n, zu = n, zzz = n;
  for (std::size_t i = 0; i < cells; i += kLanes) {
    const Float index = hn::Iota(d, static_cast<float>(i));
    const Float u = hn::Mul(index, Set(kCell));
    const Mask inside = hn::Lt(index, Set(static_cast<float>(cells)));
    const Float own = hn::IfThenElseZero(inside, hn::LoadU(d, q + i));
    const Float expected = hn::MulAdd(Set(du), u, Set(on_plane));
    const Float on = hn::IfThenElse(hn::Lt(expected, hn::Mul(Set(kHorizon), own)), own, expected);
    const Float depth = hn::Div(Set(1.0F), hn::Max(on, Set(least)));
    const Float pixels = hn::IfThenElseZero(inside, hn::ConvertTo(d, hn::PromoteTo(d32, hn::LoadU(d8, count + i))));
    const Float weighted = hn::Mul(pixels, depth);
    n = hn::Add(n, pixels);
    z = hn::Add(z, weighted);
    zu = hn::MulAdd(weighted, u, zu);
    zzz = hn::MulAdd(weighted, hn::Mul(depth, depth), zzz);
  }
  return {Sum(n), Sum(z), Sum(zu), Sum(zzz)};
}

#endif
}  // namespace HWY_NAMESPACE
}  // namespace fransac::kernels
HWY_AFTER_NAMESPACE();

#endif  // FRANSAC_KERNELS_CELL_SETS_INL_H_
