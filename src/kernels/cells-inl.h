// SPDX-License-Identifier: Apache-2.0
// Bodies for vectors of four or eight floats, compiled once per instruction set by cells.cc. See cells.h for what each computes.
// The usual include guard of Highway: this file is read once per target.
#if defined(FRANSAC_KERNELS_CELLS_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef FRANSAC_KERNELS_CELLS_INL_H_
#undef FRANSAC_KERNELS_CELLS_INL_H_
#else
#define FRANSAC_KERNELS_CELLS_INL_H_
#endif

#include <algorithm>
#include <array>
#include <cstring>
#include <type_traits>

#include "hwy/highway.h"
#include "kernels/bits.h"
#include "kernels/cells.h"
#include "kernels/lanes-inl.h"

#ifndef FRANSAC_KERNELS_CELLS_TABLE_
#define FRANSAC_KERNELS_CELLS_TABLE_
namespace fransac::kernels {

inline constexpr std::uint64_t kEveryByte = 0x0101010101010101U;

/// Over the bits that are set in a byte: their number, and from bit 16 on the sum of their positions, from bit 32 on that of the
/// positions' squares. Sums of a cell's rows, also with the row as a weight, stay below 2^16 each.
inline constexpr std::array<std::uint64_t, 256> kSumsOfBits = [] {
  std::array<std::uint64_t, 256> table{};
  for (unsigned bits = 0; bits < 256; ++bits) {
    for (std::uint64_t bit = 0; bit < 8; ++bit) {
      if ((bits >> bit & 1U) != 0) table[bits] += 1 + (bit << 16) + (bit * bit << 32);
    }
  }
  return table;
}();

}  // namespace fransac::kernels
#endif

HWY_BEFORE_NAMESPACE();
namespace fransac::kernels {
namespace HWY_NAMESPACE {
#if HWY_TARGET == HWY_SCALAR

const CellKernels<std::uint16_t>* Cells16(int side) { return &ref::cell_kernels<std::uint16_t>(side); }
const CellKernels<float>* Cells32(int side) { return &ref::cell_kernels<float>(side); }

#else
namespace cells {
namespace hn = hwy::HWY_NAMESPACE;

using namespace lanes;  // a cell's row is one vector, or two of four lanes
/// Pixels side by side that are looked at together: one cell of 8 x 8, two of 4 x 4 or four of 2 x 2.
constexpr std::size_t kStrip = 8;
static_assert(kCell == kStrip);
template <std::size_t kSide>
constexpr std::size_t kCellsOfStrip = kStrip / kSide;
/// Every pixel of a strip, or of a cell that is its first, as bits: row v, column u is bit 8 v + u.
template <std::size_t kSide>
constexpr std::uint64_t kAll = ~std::uint64_t{0} >> (8 * (kStrip - kSide));
template <std::size_t kSide>
constexpr std::uint64_t kAllOfCell = kAll<kSide>&(kEveryByte*((1U << kSide) - 1U));
/// Samples in the length of a pixel.
template <std::size_t kSide>
constexpr float kSamples = static_cast<float>(kCell) / kSide;
template <std::size_t kSide>
constexpr float kCentre = 0.5F * (kSide - 1);

template <class Raw>
using RawTag = hn::CappedTag<Raw, kStrip>;

/// Whether a strip has a measurement everywhere, the common case.
template <std::size_t kSide, class Raw>
HWY_INLINE bool IsFull(const CellRows<Raw>& rows, std::size_t column) {
  const RawTag<Raw> d;
  bool full = true;
  for (std::size_t i = 0; i < kStrip; i += hn::Lanes(d)) {
    auto least = hn::LoadU(d, rows.rows[0] + column + i);
    for (std::size_t v = 1; v < kSide; ++v) least = hn::Min(least, hn::LoadU(d, rows.rows[v] + column + i));
    full &= hn::AllFalse(d, hn::Eq(least, hn::Zero(d)));
  }
  return full;
}

/// A strip's pixels with a measurement.
template <std::size_t kSide, class Raw>
HWY_INLINE std::uint64_t MeasuredBits(const CellRows<Raw>& rows, std::size_t column) {
  const RawTag<Raw> d;
  std::uint64_t all = 0;
  for (std::size_t v = 0; v < kSide; ++v) {
    for (std::size_t i = 0; i < kStrip; i += hn::Lanes(d)) {
      std::uint8_t bits[8];
      hn::StoreMaskBits(d, hn::Ne(hn::LoadU(d, rows.rows[v] + column + i), hn::Zero(d)), bits);
      all |= static_cast<std::uint64_t>(bits[0]) << (kStrip * v + i);
    }
  }
  return all;
}

HWY_INLINE Float Row(std::size_t v) { return hn::Set(FloatTag(), static_cast<float>(v)); }

/// Of the lanes from `i` on of a strip, each one's column in its cell.
template <std::size_t kSide>
HWY_INLINE Float ColumnInCell(std::size_t i) {
  if constexpr (kSide == kStrip) return hn::Iota(FloatTag(), static_cast<float>(i));
  const IntTag d;
  const auto columns = hn::And(hn::Iota(d, static_cast<std::int32_t>(i)), hn::Set(d, static_cast<std::int32_t>(kSide - 1)));
  return hn::ConvertTo(FloatTag(), columns);
}

/// The same for values of the strip's cells, one each. Reads a vector of them.
template <std::size_t kSide>
HWY_INLINE Float OfCell(const float* HWY_RESTRICT values, std::size_t i) {
  const FloatTag d;
  if constexpr (kSide == kStrip) {
    return hn::Set(d, *values);
  } else {
    const IntTag di;
    constexpr int kShift = kSide == 4 ? 2 : 1;
    const auto indices = hn::ShiftRight<kShift>(hn::Iota(di, static_cast<std::int32_t>(i)));
    return hn::TableLookupLanes(hn::LoadU(d, values), hn::IndicesFromVec(d, indices));
  }
}

// ---- moments ----

/// Cells side by side, so that sums over lanes and what follows from them are made for all of them at once. Few enough that their
/// values stay in the nearest cache, 15 KiB; with a fifth of them the wait for their sums costs a third more time.
template <std::size_t kSide>
struct alignas(64) Batch {
  static constexpr std::size_t kCells = 40;
  static constexpr std::size_t kStrips = kCells / kCellsOfStrip<kSide>;
  static constexpr std::size_t kParts = kSide < 4 ? kSide : 4;
  float q[kStrips][kSide * kStrip];  ///< Inverse depth, per raw unit, as all below; 0 where nothing was measured.
  std::uint64_t measured[kStrips];
  // Sums over a cell's measurements, columns and rows counted from 0; the first five are whole numbers.
  alignas(64) float n[kCells];
  float u[kCells];
  float v[kCells];
  float uu[kCells];
  float uv[kCells];
  float vv[kCells];
  // Sums over measurements in some parts each; columns and rows from the centre.
  float q_parts[kCells][kParts];
  float uq_parts[kCells][kParts];
  float vq_parts[kCells][kParts];
  float residual_parts[kCells][kParts];
  // The cell's plane: inverse depth at the centre and slopes.
  float base[kCells];
  float du[kCells];
  float dv[kCells + kLanes];  // whole vectors are read
};

/// A strip's sums as parts of its cells'. A template for the sake of its branches: only one of them compiles.
template <std::size_t kSide, class D>
HWY_INLINE void StoreParts(D d, const hn::Vec<D>* HWY_RESTRICT row, float* HWY_RESTRICT parts) {
  if constexpr (kSide < kStrip) {
    for (std::size_t i = 0; i < kStrip; i += kLanes) hn::StoreU(row[i / kLanes], d, parts + i);
  } else if constexpr (hn::MaxLanes(D()) == 4) {
    hn::Store(hn::Add(row[0], row[1]), d, parts);
  } else {
    const hn::Half<D> half;
    hn::Store(hn::Add(hn::LowerHalf(half, row[0]), hn::UpperHalf(half, row[0])), half, parts);
  }
}

/// The sums of some cells' parts.
HWY_INLINE Float SumParts(const float (*HWY_RESTRICT parts)[4]) {
  const FloatTag d;
  Float a, b, c, e;
  hn::LoadInterleaved4(d, parts[0], a, b, c, e);
  return hn::Add(hn::Add(a, b), hn::Add(c, e));
}
HWY_INLINE Float SumParts(const float (*HWY_RESTRICT parts)[2]) {
  const FloatTag d;
  Float a, b;
  hn::LoadInterleaved2(d, parts[0], a, b);
  return hn::Add(a, b);
}

template <std::size_t kSide>
HWY_INLINE void SetPositions(std::uint64_t measured, std::size_t strip, Batch<kSide>& batch) {
  batch.measured[strip] = measured;
  for (std::size_t k = 0; k < kCellsOfStrip<kSide>; ++k) {
    const std::uint64_t of_cell = measured >> (kSide * k) & kAllOfCell<kSide>;
    std::uint64_t sums = 0;
    std::uint64_t by_row = 0;
    std::uint64_t vv = 0;
    for (std::uint64_t v = 0; v < kSide; ++v) {
      const std::uint64_t row = kSumsOfBits[of_cell >> (kStrip * v) & 0xFF];
      sums += row;
      by_row += v * row;
      vv += v * v * (row & 0xFFFF);
    }
    const auto field = [](std::uint64_t packed, int i) { return static_cast<float>(packed >> (16 * i) & 0xFFFF); };
    const std::size_t cell = strip * kCellsOfStrip<kSide> + k;
    batch.n[cell] = field(sums, 0);
    batch.u[cell] = field(sums, 1);
    batch.uu[cell] = field(sums, 2);
    batch.v[cell] = field(by_row, 0);
    batch.uv[cell] = field(by_row, 1);
    batch.vv[cell] = static_cast<float>(vv);
  }
}

/// What SetPositions finds for a full strip.
template <std::size_t kSide>
HWY_INLINE void SetAllPositions(std::size_t strip, Batch<kSide>& batch) {
  constexpr float kN = kSide;
  constexpr float kSum = kN * (kN - 1.0F) / 2.0F;
  constexpr float kSquares = kSum * (2.0F * kN - 1.0F) / 3.0F;
  batch.measured[strip] = kAll<kSide>;
  for (std::size_t k = 0; k < kCellsOfStrip<kSide>; ++k) {
    const std::size_t cell = strip * kCellsOfStrip<kSide> + k;
    batch.n[cell] = kN * kN;
    batch.u[cell] = batch.v[cell] = kN * kSum;
    batch.uu[cell] = batch.vv[cell] = kN * kSquares;
    batch.uv[cell] = kSum * kSum;
  }
}

/// 1 / raw. Of integers by an estimate and a step of Newton's method, which takes a third of a division's time on x86, where the
/// estimate has 12 bits and more: right to 2^-22.
template <class Raw>
HWY_INLINE Float Inverse(Float raw) {
#if HWY_ARCH_X86
  if constexpr (!std::is_same_v<Raw, float>) {
    const Float about = hn::ApproximateReciprocal(raw);
    return hn::Mul(about, hn::NegMulAdd(raw, about, hn::Set(FloatTag(), 2.0F)));
  }
#endif
  return hn::Div(hn::Set(FloatTag(), 1.0F), raw);
}

/// The first pass over a strip.
template <bool kFull, std::size_t kSide, class Raw>
HWY_INLINE void SumInverseDepths(const CellRows<Raw>& rows, std::size_t column, std::size_t strip, Batch<kSide>& batch) {
  const FloatTag d;
  Float sum[kStrip / kLanes];
  Float by_column[kStrip / kLanes];
  Float by_row[kStrip / kLanes];
  for (std::size_t i = 0; i < kStrip / kLanes; ++i) {
    sum[i] = by_row[i] = hn::Zero(d);
    for (std::size_t v = 0; v < kSide; ++v) {
      const Float raw = Load(rows.rows[v] + column + i * kLanes);
      Float q = Inverse<Raw>(raw);
      if constexpr (!kFull) q = hn::IfThenElseZero(hn::Gt(raw, hn::Zero(d)), q);
      hn::Store(q, d, batch.q[strip] + v * kStrip + i * kLanes);
      sum[i] = hn::Add(sum[i], q);
      by_row[i] = hn::MulAdd(q, hn::Set(d, static_cast<float>(v) - kCentre<kSide>), by_row[i]);
    }
    by_column[i] = hn::Mul(sum[i], hn::Sub(ColumnInCell<kSide>(i * kLanes), hn::Set(d, kCentre<kSide>)));
  }
  const std::size_t cell = strip * kCellsOfStrip<kSide>;
  StoreParts<kSide>(d, sum, batch.q_parts[cell]);
  StoreParts<kSide>(d, by_column, batch.uq_parts[cell]);
  StoreParts<kSide>(d, by_row, batch.vq_parts[cell]);
}

/// The second pass: squared residuals of a strip, which are far smaller than what the sums of the first pass round to.
template <bool kFull, std::size_t kSide>
HWY_INLINE void SumResiduals(std::size_t strip, Batch<kSide>& batch) {
  const FloatTag d;
  const std::size_t cell = strip * kCellsOfStrip<kSide>;
  Float sum[kStrip / kLanes];
  for (std::size_t i = 0; i < kStrip / kLanes; ++i) {
    const Float dv = OfCell<kSide>(batch.dv + cell, i * kLanes);
    const Float columns = hn::Sub(ColumnInCell<kSide>(i * kLanes), hn::Set(d, kCentre<kSide>));
    const Float base =
        hn::MulAdd(OfCell<kSide>(batch.du + cell, i * kLanes), columns, OfCell<kSide>(batch.base + cell, i * kLanes));
    sum[i] = hn::Zero(d);
    for (std::size_t v = 0; v < kSide; ++v) {
      const Float q = hn::Load(d, batch.q[strip] + v * kStrip + i * kLanes);
      Float residual = hn::NegMulAdd(dv, hn::Set(d, static_cast<float>(v) - kCentre<kSide>), hn::Sub(q, base));
      if constexpr (!kFull) residual = hn::IfThenElseZero(hn::Gt(q, hn::Zero(d)), residual);
      sum[i] = hn::MulAdd(residual, residual, sum[i]);
    }
  }
  StoreParts<kSide>(d, sum, batch.residual_parts[cell]);
}

/// Everything but the residual, for some cells of a batch.
template <std::size_t kSide>
HWY_INLINE void FitPlanes(std::size_t cell, float least, float units_per_metre, Batch<kSide>& batch, const CellMoments& out) {
  const FloatTag d;
  const Float per_metre = hn::Set(d, units_per_metre);
  const Float count = hn::Load(d, batch.n + cell);
  const Float n = hn::Max(count, hn::Set(d, 1.0F));
  const Float sum_u = hn::Load(d, batch.u + cell);
  const Float sum_v = hn::Load(d, batch.v + cell);
  const Float per_n = hn::Div(hn::Set(d, 1.0F), n);
  const Float u = hn::MulSub(sum_u, per_n, hn::Set(d, kCentre<kSide>));
  const Float v = hn::MulSub(sum_v, per_n, hn::Set(d, kCentre<kSide>));
  // Whole numbers below 2^17 before they are scaled.
  const Float per_nn = hn::Mul(per_n, per_n);
  const Float uu = hn::Mul(hn::MulSub(n, hn::Load(d, batch.uu + cell), hn::Mul(sum_u, sum_u)), per_nn);
  const Float uv = hn::Mul(hn::MulSub(n, hn::Load(d, batch.uv + cell), hn::Mul(sum_u, sum_v)), per_nn);
  const Float vv = hn::Mul(hn::MulSub(n, hn::Load(d, batch.vv + cell), hn::Mul(sum_v, sum_v)), per_nn);
  const Float det = hn::MulSub(uu, vv, hn::Mul(uv, uv));
  const Float q = hn::Mul(SumParts(batch.q_parts + cell), per_n);
  constexpr float kSquaredSamples = kSamples<kSide> * kSamples<kSide>;
  const Float least_spread = hn::Set(d, kLeastSpread / (kSquaredSamples * kSquaredSamples));
  const Float samples = hn::Set(d, kSamples<kSide>);
  const Float squared = hn::Set(d, kSquaredSamples);
  const Mask fits = hn::And(hn::And(hn::Ge(hn::Mul(count, squared), hn::Set(d, least)), hn::Gt(det, least_spread)),
                            hn::Lt(hn::Mul(q, per_metre), hn::Set(d, kMostInverseDepth)));  // not if infinite or NaN either

  const Float uq = hn::MulSub(SumParts(batch.uq_parts + cell), per_n, hn::Mul(u, q));
  const Float vq = hn::MulSub(SumParts(batch.vq_parts + cell), per_n, hn::Mul(v, q));
  const Float per_det = hn::Div(hn::Set(d, 1.0F), hn::Max(det, least_spread));
  const Float du = hn::Mul(hn::MulSub(vv, uq, hn::Mul(uv, vq)), per_det);
  const Float dv = hn::Mul(hn::MulSub(uu, vq, hn::Mul(uv, uq)), per_det);
  hn::Store(hn::NegMulAdd(dv, v, hn::NegMulAdd(du, u, q)), d, batch.base + cell);
  hn::Store(du, d, batch.du + cell);
  hn::Store(dv, d, batch.dv + cell);

  const Float slope = hn::Mul(per_metre, hn::Set(d, 1.0F / kSamples<kSide>));
  const auto store = [&](Float value, float* to) HWY_ATTR { hn::StoreU(hn::IfThenElseZero(fits, value), d, to + cell); };
  store(hn::Mul(count, squared), out.n);
  store(hn::Mul(u, samples), out.u);
  store(hn::Mul(v, samples), out.v);
  store(hn::Mul(q, per_metre), out.q);
  store(hn::Mul(uu, squared), out.uu);
  store(hn::Mul(uv, squared), out.uv);
  store(hn::Mul(vv, squared), out.vv);
  store(hn::Mul(du, slope), out.du);
  store(hn::Mul(dv, slope), out.dv);
}

/// Moments of `cells` cells, at most a batch, and the number of their measurements; `out` has room for a batch.
template <std::size_t kSide, class Raw>
std::size_t MomentsOfBatch(const CellRows<Raw>& rows, std::size_t first, std::size_t cells, float units_per_metre, float least,
                           const CellMoments& out) {
  using Cells = Batch<kSide>;
  const FloatTag d;
  Cells batch;
  if (cells < Cells::kCells) batch = {};
  const std::size_t strips = (cells + kCellsOfStrip<kSide> - 1) / kCellsOfStrip<kSide>;
  std::size_t measured = 0;
  for (std::size_t strip = 0; strip < strips; ++strip) {
    const std::size_t column = first * kSide + strip * kStrip;
    if (IsFull<kSide>(rows, column)) {
      measured += kSide * kStrip;
      SetAllPositions<kSide>(strip, batch);
      SumInverseDepths<true, kSide>(rows, column, strip, batch);
    } else {
      const std::uint64_t bits = MeasuredBits<kSide>(rows, column);
      measured += hwy::PopCount(bits);
      SetPositions<kSide>(bits, strip, batch);
      if (bits == 0) {
        for (auto* parts : {batch.q_parts, batch.uq_parts, batch.vq_parts, batch.residual_parts})
          std::fill_n(parts[strip * kCellsOfStrip<kSide>], kCellsOfStrip<kSide> * Cells::kParts, 0.0F);
        continue;
      }
      SumInverseDepths<false, kSide>(rows, column, strip, batch);
    }
  }
  for (std::size_t cell = 0; cell < Cells::kCells; cell += kLanes) FitPlanes<kSide>(cell, least, units_per_metre, batch, out);
  for (std::size_t strip = 0; strip < strips; ++strip) {
    if (batch.measured[strip] == kAll<kSide>) {
      SumResiduals<true, kSide>(strip, batch);
    } else if (batch.measured[strip] != 0) {
      SumResiduals<false, kSide>(strip, batch);
    }
  }
  const Float factor = hn::Set(d, units_per_metre * units_per_metre * kSamples<kSide> * kSamples<kSide>);
  for (std::size_t cell = 0; cell < Cells::kCells; cell += kLanes) {
    const Float n = hn::LoadU(d, out.n + cell);
    const Float residual = hn::Div(hn::Mul(SumParts(batch.residual_parts + cell), factor), n);
    hn::StoreU(hn::IfThenElse(hn::Gt(n, hn::Zero(d)), residual, hn::Set(d, kNoFit)), d, out.mean_squared_residual + cell);
  }
  return measured;
}

HWY_INLINE CellMoments From(const CellMoments& m, std::size_t cell) {
  return {m.n + cell,  m.u + cell,  m.v + cell,  m.q + cell,  m.uu + cell,
          m.uv + cell, m.vv + cell, m.du + cell, m.dv + cell, m.mean_squared_residual + cell};
}

template <std::size_t kSide, class Raw>
std::size_t Moments(const CellRows<Raw>& rows, std::size_t cells, float metres_per_unit, float least, const CellMoments& out) {
  constexpr std::size_t kCells = Batch<kSide>::kCells;
  const float units_per_metre = 1.0F / metres_per_unit;
  std::size_t first = 0;
  std::size_t measured = 0;
  for (; first + kCells <= cells; first += kCells) {
    measured += MomentsOfBatch<kSide>(rows, first, kCells, units_per_metre, least, From(out, first));
  }
  if (first == cells) return measured;
  constexpr std::size_t kFields = 10;
  float rest[kFields][kCells];
  measured += MomentsOfBatch<kSide>(rows, first, cells - first, units_per_metre, least,
                                    {rest[0], rest[1], rest[2], rest[3], rest[4], rest[5], rest[6], rest[7], rest[8], rest[9]});
  const CellMoments tail = From(out, first);
  float* const fields[kFields] = {tail.n,  tail.u,  tail.v,  tail.q,  tail.uu,
                                  tail.uv, tail.vv, tail.du, tail.dv, tail.mean_squared_residual};
  for (std::size_t i = 0; i < kFields; ++i) std::copy_n(rest[i], cells - first, fields[i]);
  return measured;
}

// ---- labels ----

/// What belongs to a plane, in raw units: raw (|z q - 1| - tolerance raw) <= floor.
template <std::size_t kSide>
struct Threshold {
  /// Of a strip, whose first cell's tolerance is *tolerance_m.
  HWY_INLINE Threshold(const float* tolerance_m, float metres_per_unit, float floor_raw) : floor(hn::Set(FloatTag(), floor_raw)) {
    const Float unit = hn::Set(FloatTag(), metres_per_unit);
    for (std::size_t i = 0; i < kStrip; i += kLanes) tolerance[i / kLanes] = hn::Mul(OfCell<kSide>(tolerance_m, i), unit);
  }
  HWY_INLINE Mask Admits(Float raw, Float residual, std::size_t i) const {
    return hn::Le(hn::Mul(raw, hn::NegMulAdd(tolerance[i / kLanes], raw, residual)), floor);
  }
  Float tolerance[kStrip / kLanes];
  Float floor;
};

HWY_INLINE CellPlane InRawUnits(const CellPlane& plane, float metres_per_unit) {
  return {plane.base * metres_per_unit, plane.du * metres_per_unit, plane.dv * metres_per_unit, plane.label};
}

/// Inverse depth in a cell's first row.
HWY_INLINE Float FirstRow(const CellPlane& plane, Float columns) {
  return hn::MulAdd(hn::Set(FloatTag(), plane.du), columns, hn::Set(FloatTag(), plane.base));
}

/// |z q - 1| in row v of a cell.
HWY_INLINE Float Residual(Float raw, Float first_row, const CellPlane& plane, std::size_t v) {
  const Float q = hn::MulAdd(hn::Set(FloatTag(), plane.dv), Row(v), first_row);
  return hn::Abs(hn::MulSub(raw, q, hn::Set(FloatTag(), 1.0F)));
}

/// Finds which measurements of a strip belong to which plane, as bits, and adds up their squared residuals. All planes are held
/// to the same threshold, so that it is enough to ask whether the nearest passes. Unless kFull, pixels without a measurement and
/// those outside [begin, end) belong to none.
template <std::size_t kPlanes, bool kFull, std::size_t kSide, class Raw>
HWY_INLINE void AssignStrip(const CellRows<Raw>& rows, std::size_t column, std::size_t begin, std::size_t end,
                            const CellPlane* HWY_RESTRICT planes, std::size_t num_planes, const Threshold<kSide>& threshold,
                            std::uint64_t* HWY_RESTRICT bits, Float* HWY_RESTRICT squared) {
  const FloatTag d;
  const std::size_t count = kPlanes == 0 ? num_planes : kPlanes;
  for (std::size_t p = 0; p < count; ++p) bits[p] = 0;
  for (std::size_t i = 0; i < kStrip; i += kLanes) {
    const Float in_strip = hn::Iota(d, static_cast<float>(i));
    const Float columns = hn::Add(hn::Set(d, static_cast<float>(column)), in_strip);
    const Mask wanted = hn::And(hn::Ge(in_strip, Row(begin)), hn::Lt(in_strip, Row(end)));
    Float first_row[kPlanes == 0 ? kMostCandidates : kPlanes];
    for (std::size_t p = 0; p < count; ++p) first_row[p] = FirstRow(planes[p], columns);
    for (std::size_t v = 0; v < kSide; ++v) {
      const Float raw = Load(rows.rows[v] + column + i);
      Float nearest = Residual(raw, first_row[0], planes[0], v);
      Float which = hn::Zero(d);
      Mask nearer{};
      for (std::size_t p = 1; p < count; ++p) {
        const Float residual = Residual(raw, first_row[p], planes[p], v);
        nearer = hn::Lt(residual, nearest);
        if constexpr (kPlanes != 2) which = hn::IfThenElse(nearer, hn::Set(d, static_cast<float>(p)), which);
        nearest = hn::Min(nearest, residual);
      }
      Mask inside = threshold.Admits(raw, nearest, i);
      if constexpr (!kFull) inside = hn::And(inside, hn::Gt(raw, hn::Zero(d)));
      if constexpr (!kFull && kSide < kStrip) inside = hn::And(inside, wanted);
      for (std::size_t p = 0; p < count; ++p) {
        Mask own = inside;
        if constexpr (kPlanes == 2) {
          own = p == 1 ? hn::And(inside, nearer) : hn::AndNot(nearer, inside);
        } else if constexpr (kPlanes != 1) {
          own = hn::And(inside, hn::Eq(which, hn::Set(d, static_cast<float>(p))));
        }
        const Float own_residual = hn::IfThenElseZero(own, nearest);
        squared[p] = hn::MulAdd(own_residual, own_residual, squared[p]);
        bits[p] |= Bits(own) << (kStrip * v + i);
      }
    }
  }
}

/// Stores labels of a strip's pixels [begin, end): 0 where nothing was measured, a plane's where its bit is set, else 255.
/// `inverse` is what a plane's label lacks to 255, in every byte.
template <std::size_t kSide>
HWY_INLINE void StoreLabels(std::uint64_t measured, const std::uint64_t* HWY_RESTRICT bits,
                            const std::uint64_t* HWY_RESTRICT inverse, std::size_t num_planes, std::uint8_t* const* labels,
                            std::size_t column, std::size_t begin, std::size_t end) {
  const auto store = [&](std::uint64_t row, std::size_t v) {
    if (end - begin == kStrip) {
      std::memcpy(labels[v] + column, &row, sizeof row);
    } else {
      for (std::size_t u = begin; u < end; ++u) labels[v][column + u] = static_cast<std::uint8_t>(row >> (8 * u));
    }
  };
  for (std::size_t p = 0; p < num_planes; ++p) {
    if (bits[p] != kAll<kSide>) continue;  // else the strip lies within the plane, as most do
    for (std::size_t v = 0; v < kSide; ++v) store(~inverse[p], v);
    return;
  }
  for (std::size_t v = 0; v < kSide; ++v) {
    const auto bytes = [v](std::uint64_t all) { return kBytesOfBits[all >> (kStrip * v) & 0xFF]; };
    std::uint64_t row = bytes(measured);
    for (std::size_t p = 0; p < num_planes; ++p) row &= ~(bytes(bits[p]) & inverse[p]);
    store(row, v);
  }
}

template <std::size_t kPlanes, std::size_t kSide, class Raw>
HWY_NOINLINE void LabelRun(const CellRows<Raw>& rows, std::size_t first, std::size_t cells, float metres_per_unit,
                           const CellPlane* HWY_RESTRICT candidates, std::size_t num_planes, const CellTolerance& tolerance,
                           std::uint8_t* const* labels, CellRunEvidence* HWY_RESTRICT evidence) {
  const FloatTag d;
  constexpr std::size_t kMost = kPlanes == 0 ? kMostCandidates : kPlanes;
  const std::size_t count = kPlanes == 0 ? num_planes : kPlanes;
  CellPlane planes[kMost];
  std::uint64_t inverse[kMost];
  Float squared[kMost];
  for (std::size_t p = 0; p < count; ++p) {
    planes[p] = InRawUnits(candidates[p], metres_per_unit);
    inverse[p] = kEveryByte * static_cast<std::uint64_t>(255U - planes[p].label);
    squared[p] = hn::Zero(d);
  }
  const float floor = tolerance.floor_m / metres_per_unit;
  constexpr std::size_t kCells = kCellsOfStrip<kSide>;
  for (std::size_t strip = first / kCells; strip * kCells < first + cells; ++strip) {
    const std::size_t from = kCells == 1 ? strip : std::max(first, strip * kCells);
    const std::size_t to = kCells == 1 ? strip + 1 : std::min(first + cells, (strip + 1) * kCells);
    const std::size_t begin = (from - strip * kCells) * kSide;
    const std::size_t end = (to - strip * kCells) * kSide;
    const Threshold<kSide> threshold(tolerance.per_cell + strip * kCells, metres_per_unit, floor);
    const std::size_t column = strip * kStrip;
    std::uint64_t bits[kMost];
    if (to - from == kCells && IsFull<kSide>(rows, column)) {
      AssignStrip<kPlanes, true>(rows, column, begin, end, planes, count, threshold, bits, squared);
      StoreLabels<kSide>(kAll<kSide>, bits, inverse, count, labels, column, begin, end);
    } else {
      AssignStrip<kPlanes, false>(rows, column, begin, end, planes, count, threshold, bits, squared);
      StoreLabels<kSide>(MeasuredBits<kSide>(rows, column), bits, inverse, count, labels, column, begin, end);
    }
    for (std::size_t p = 0; p < count; ++p) {
      for (std::size_t cell = from; cell < to; ++cell) {
        const std::uint64_t own = bits[p] >> ((cell - strip * kCells) * kSide) & kAllOfCell<kSide>;
        evidence[p].count[cell - first] = static_cast<std::uint8_t>(hwy::PopCount(own));
      }
    }
  }
  for (std::size_t p = 0; p < count; ++p) evidence[p].squared_residual = hn::GetLane(hn::SumOfLanes(d, squared[p]));
}

template <std::size_t kSide, class Raw>
void Label(const CellRows<Raw>& rows, std::size_t first, std::size_t cells, float metres_per_unit, const CellPlane* planes,
           std::size_t num_planes, const CellTolerance& tolerance, std::uint8_t* const* labels, CellRunEvidence* evidence) {
  const auto run = num_planes == 1   ? LabelRun<1, kSide, Raw>
                   : num_planes == 2 ? LabelRun<2, kSide, Raw>
                   : num_planes == 3 ? LabelRun<3, kSide, Raw>
                                     : LabelRun<0, kSide, Raw>;
  run(rows, first, cells, metres_per_unit, planes, num_planes, tolerance, labels, evidence);
}

template <std::size_t kSide, class Raw>
void LabelNone(const CellRows<Raw>& rows, std::size_t first, std::size_t cells, std::uint8_t* const* labels) {
  const RawTag<Raw> d;
  const hn::RebindToSigned<RawTag<Raw> > di;
  const hn::Rebind<std::int8_t, RawTag<Raw> > d8;
  const std::size_t end = (first + cells) * kSide;
  for (std::size_t v = 0; v < kSide; ++v) {
    auto* const row = reinterpret_cast<std::int8_t*>(labels[v]);  // NOLINT: all bits set is 255
    std::size_t u = first * kSide;
    for (; u + hn::Lanes(d) <= end; u += hn::Lanes(d)) {
      const auto measured = hn::Ne(hn::LoadU(d, rows.rows[v] + u), hn::Zero(d));
      hn::StoreU(hn::DemoteTo(d8, hn::BitCast(di, hn::VecFromMask(d, measured))), d8, row + u);
    }
    for (; u < end; ++u) row[u] = static_cast<std::int8_t>(-static_cast<int>(rows.rows[v][u] != Raw{0}));
  }
}

template <std::size_t kSide, class Raw>
typename CellKernels<Raw>::Fits FitsOfCell(const CellRows<Raw>& rows, std::size_t cell, float metres_per_unit,
                                           const CellPlane& candidate, const CellTolerance& tolerance) {
  const std::size_t strip = cell / kCellsOfStrip<kSide>;
  const std::size_t column = strip * kStrip;
  const std::size_t begin = cell * kSide - column;
  const CellPlane plane = InRawUnits(candidate, metres_per_unit);
  const Threshold<kSide> threshold(tolerance.per_cell + strip * kCellsOfStrip<kSide>, metres_per_unit,
                                   tolerance.floor_m / metres_per_unit);
  std::uint64_t fitting = 0;
  Float squared[1] = {hn::Zero(FloatTag())};
  AssignStrip<1, false>(rows, column, begin, begin + kSide, &plane, 1, threshold, &fitting, squared);
  const std::uint64_t measured = MeasuredBits<kSide>(rows, column) >> begin & kAllOfCell<kSide>;
  return {static_cast<std::uint32_t>(hwy::PopCount(fitting)), static_cast<std::uint32_t>(hwy::PopCount(measured))};
}

template <std::size_t kSide, class Raw>
constexpr CellKernels<Raw> kTable = {Moments<kSide, Raw>, Label<kSide, Raw>, LabelNone<kSide, Raw>, FitsOfCell<kSide, Raw>};

template <class Raw>
HWY_INLINE const CellKernels<Raw>* TableOf(int side) {
  return side == 8 ? &kTable<8, Raw> : side == 4 ? &kTable<4, Raw> : &kTable<2, Raw>;
}

}  // namespace cells

const CellKernels<std::uint16_t>* Cells16(int side) { return cells::TableOf<std::uint16_t>(side); }
const CellKernels<float>* Cells32(int side) { return cells::TableOf<float>(side); }

#endif
}  // namespace HWY_NAMESPACE
}  // namespace fransac::kernels
HWY_AFTER_NAMESPACE();

#endif  // include guard
