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

const CellKernels<std::uint16_t>* Cells16() { return &ref::cell_kernels<std::uint16_t>(); }
const CellKernels<float>* Cells32() { return &ref::cell_kernels<float>(); }

#else
namespace cells {
namespace hn = hwy::HWY_NAMESPACE;

using namespace lanes;  // a cell's row is one vector, or two of four lanes
constexpr std::size_t kSide = kCell;
static_assert(kSide == 8);
constexpr float kCentre = 0.5F * (kCell - 1);
constexpr std::uint64_t kAll = ~std::uint64_t{0};  ///< Every pixel of a cell, as bits.

template <class Raw>
using RawTag = hn::CappedTag<Raw, kCell>;

/// Whether a cell has a measurement everywhere, the common case.
template <class Raw>
HWY_INLINE bool IsFull(const CellRows<Raw>& rows, std::size_t column) {
  const RawTag<Raw> d;
  bool full = true;
  for (std::size_t i = 0; i < kSide; i += hn::Lanes(d)) {
    auto least = hn::LoadU(d, rows.rows[0] + column + i);
    for (std::size_t v = 1; v < kSide; ++v) least = hn::Min(least, hn::LoadU(d, rows.rows[v] + column + i));
    full &= hn::AllFalse(d, hn::Eq(least, hn::Zero(d)));
  }
  return full;
}

/// Bit 8 v + u is set where a cell has a measurement.
template <class Raw>
HWY_INLINE std::uint64_t MeasuredBits(const CellRows<Raw>& rows, std::size_t column) {
  const RawTag<Raw> d;
  std::uint64_t all = 0;
  for (std::size_t v = 0; v < kSide; ++v) {
    for (std::size_t i = 0; i < kSide; i += hn::Lanes(d)) {
      std::uint8_t bits[8];
      hn::StoreMaskBits(d, hn::Ne(hn::LoadU(d, rows.rows[v] + column + i), hn::Zero(d)), bits);
      all |= static_cast<std::uint64_t>(bits[0]) << (kSide * v + i);
    }
  }
  return all;
}

HWY_INLINE Float Row(std::size_t v) { return hn::Set(FloatTag(), static_cast<float>(v)); }

// ---- moments ----

/// Cells side by side, so that sums over lanes and what follows from them are made for all of them at once. Few enough that their
/// values stay in the nearest cache, 15 KiB; with a fifth of them the wait for their sums costs a third more time.
struct alignas(64) Batch {
  static constexpr std::size_t kCells = 40;
  float q[kCells][kSide * kSide];  ///< Inverse depth; 0 where nothing was measured.
  std::uint64_t measured[kCells];
  // Sums over a cell's measurements, columns and rows counted from 0; the first five are whole numbers.
  float n[kCells];
  float u[kCells];
  float v[kCells];
  float uu[kCells];
  float uv[kCells];
  float vv[kCells];
  // Sums over measurements in four parts each; columns and rows from the centre.
  float q_parts[kCells][4];
  float uq_parts[kCells][4];
  float vq_parts[kCells][4];
  float residual_parts[kCells][4];
  // The cell's plane: inverse depth at the centre and slopes.
  float base[kCells];
  float du[kCells];
  float dv[kCells];
};

/// A template for the sake of its branches: only one of them compiles.
template <class D>
HWY_INLINE void StoreParts(D d, const hn::Vec<D>* HWY_RESTRICT row, float* HWY_RESTRICT parts) {
  if constexpr (hn::MaxLanes(D()) == 4) {
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

HWY_INLINE void SetPositions(std::uint64_t measured, std::size_t cell, Batch& batch) {
  batch.measured[cell] = measured;
  std::uint64_t sums = 0;
  std::uint64_t by_row = 0;
  std::uint64_t vv = 0;
  for (std::uint64_t v = 0; v < kSide; ++v) {
    const std::uint64_t row = kSumsOfBits[measured >> (kSide * v) & 0xFF];
    sums += row;
    by_row += v * row;
    vv += v * v * (row & 0xFFFF);
  }
  const auto field = [](std::uint64_t packed, int i) { return static_cast<float>(packed >> (16 * i) & 0xFFFF); };
  batch.n[cell] = field(sums, 0);
  batch.u[cell] = field(sums, 1);
  batch.uu[cell] = field(sums, 2);
  batch.v[cell] = field(by_row, 0);
  batch.uv[cell] = field(by_row, 1);
  batch.vv[cell] = static_cast<float>(vv);
}

/// What SetPositions finds for a full cell.
HWY_INLINE void SetAllPositions(std::size_t cell, Batch& batch) {
  batch.measured[cell] = kAll;
  batch.n[cell] = 64.0F;
  batch.u[cell] = batch.v[cell] = 8.0F * 28.0F;
  batch.uu[cell] = batch.vv[cell] = 8.0F * 140.0F;
  batch.uv[cell] = 28.0F * 28.0F;
}

/// The first pass over a cell. A quotient and its dividend round once each: q is right to 2^-23.
template <bool kFull, class Raw>
HWY_INLINE void SumInverseDepths(const CellRows<Raw>& rows, std::size_t column, float units_per_metre, std::size_t cell,
                                 Batch& batch) {
  const FloatTag d;
  const Float one = hn::Set(d, units_per_metre);
  Float sum[kSide / kLanes];
  Float by_column[kSide / kLanes];
  Float by_row[kSide / kLanes];
  for (std::size_t i = 0; i < kSide / kLanes; ++i) {
    sum[i] = by_row[i] = hn::Zero(d);
    for (std::size_t v = 0; v < kSide; ++v) {
      const Float raw = Load(rows.rows[v] + column + i * kLanes);
      Float q = hn::Div(one, raw);
      if constexpr (!kFull) q = hn::IfThenElseZero(hn::Gt(raw, hn::Zero(d)), q);
      hn::Store(q, d, batch.q[cell] + v * kSide + i * kLanes);
      sum[i] = hn::Add(sum[i], q);
      by_row[i] = hn::MulAdd(q, hn::Set(d, static_cast<float>(v) - kCentre), by_row[i]);
    }
    by_column[i] = hn::Mul(sum[i], hn::Iota(d, static_cast<float>(i * kLanes) - kCentre));
  }
  StoreParts(d, sum, batch.q_parts[cell]);
  StoreParts(d, by_column, batch.uq_parts[cell]);
  StoreParts(d, by_row, batch.vq_parts[cell]);
}

/// The second pass: squared residuals of a cell, which are far smaller than what the sums of the first pass round to.
template <bool kFull>
HWY_INLINE void SumResiduals(std::size_t cell, Batch& batch) {
  const FloatTag d;
  const Float dv = hn::Set(d, batch.dv[cell]);
  Float sum[kSide / kLanes];
  for (std::size_t i = 0; i < kSide / kLanes; ++i) {
    const Float columns = hn::Iota(d, static_cast<float>(i * kLanes) - kCentre);
    const Float base = hn::MulAdd(hn::Set(d, batch.du[cell]), columns, hn::Set(d, batch.base[cell]));
    sum[i] = hn::Zero(d);
    for (std::size_t v = 0; v < kSide; ++v) {
      const Float q = hn::Load(d, batch.q[cell] + v * kSide + i * kLanes);
      Float residual = hn::NegMulAdd(dv, hn::Set(d, static_cast<float>(v) - kCentre), hn::Sub(q, base));
      if constexpr (!kFull) residual = hn::IfThenElseZero(hn::Gt(q, hn::Zero(d)), residual);
      sum[i] = hn::MulAdd(residual, residual, sum[i]);
    }
  }
  StoreParts(d, sum, batch.residual_parts[cell]);
}

/// Everything but the residual, for some cells of a batch.
HWY_INLINE void FitPlanes(std::size_t cell, float least, Batch& batch, const CellMoments& out) {
  const FloatTag d;
  const Float count = hn::Load(d, batch.n + cell);
  const Float n = hn::Max(count, hn::Set(d, 1.0F));
  const Float sum_u = hn::Load(d, batch.u + cell);
  const Float sum_v = hn::Load(d, batch.v + cell);
  const Float per_n = hn::Div(hn::Set(d, 1.0F), n);
  const Float u = hn::MulSub(sum_u, per_n, hn::Set(d, kCentre));
  const Float v = hn::MulSub(sum_v, per_n, hn::Set(d, kCentre));
  // Whole numbers below 2^17 before they are scaled.
  const Float per_nn = hn::Mul(per_n, per_n);
  const Float uu = hn::Mul(hn::MulSub(n, hn::Load(d, batch.uu + cell), hn::Mul(sum_u, sum_u)), per_nn);
  const Float uv = hn::Mul(hn::MulSub(n, hn::Load(d, batch.uv + cell), hn::Mul(sum_u, sum_v)), per_nn);
  const Float vv = hn::Mul(hn::MulSub(n, hn::Load(d, batch.vv + cell), hn::Mul(sum_v, sum_v)), per_nn);
  const Float det = hn::MulSub(uu, vv, hn::Mul(uv, uv));
  const Float q = hn::Mul(SumParts(batch.q_parts + cell), per_n);
  const Mask fits = hn::And(hn::And(hn::Ge(count, hn::Set(d, least)), hn::Gt(det, hn::Set(d, kLeastSpread))),
                            hn::Lt(q, hn::Set(d, kMostInverseDepth)));  // not if that is infinite or NaN either

  const Float uq = hn::MulSub(SumParts(batch.uq_parts + cell), per_n, hn::Mul(u, q));
  const Float vq = hn::MulSub(SumParts(batch.vq_parts + cell), per_n, hn::Mul(v, q));
  const Float per_det = hn::Div(hn::Set(d, 1.0F), hn::Max(det, hn::Set(d, kLeastSpread)));
  const Float du = hn::Mul(hn::MulSub(vv, uq, hn::Mul(uv, vq)), per_det);
  const Float dv = hn::Mul(hn::MulSub(uu, vq, hn::Mul(uv, uq)), per_det);
  hn::Store(hn::NegMulAdd(dv, v, hn::NegMulAdd(du, u, q)), d, batch.base + cell);
  hn::Store(du, d, batch.du + cell);
  hn::Store(dv, d, batch.dv + cell);

  hn::StoreU(hn::IfThenElseZero(fits, count), d, out.n + cell);
  hn::StoreU(hn::IfThenElseZero(fits, u), d, out.u + cell);
  hn::StoreU(hn::IfThenElseZero(fits, v), d, out.v + cell);
  hn::StoreU(hn::IfThenElseZero(fits, q), d, out.q + cell);
  hn::StoreU(hn::IfThenElseZero(fits, uu), d, out.uu + cell);
  hn::StoreU(hn::IfThenElseZero(fits, uv), d, out.uv + cell);
  hn::StoreU(hn::IfThenElseZero(fits, vv), d, out.vv + cell);
  hn::StoreU(hn::IfThenElseZero(fits, du), d, out.du + cell);
  hn::StoreU(hn::IfThenElseZero(fits, dv), d, out.dv + cell);
}

/// Moments of `cells` cells, at most a batch, and the number of their measurements; `out` has room for a batch.
template <class Raw>
std::size_t MomentsOfBatch(const CellRows<Raw>& rows, std::size_t first, std::size_t cells, float units_per_metre, float least,
                           const CellMoments& out) {
  const FloatTag d;
  Batch batch;
  if (cells < Batch::kCells) batch = {};
  std::size_t measured = 0;
  for (std::size_t cell = 0; cell < cells; ++cell) {
    const std::size_t column = (first + cell) * kSide;
    if (IsFull(rows, column)) {
      measured += kSide * kSide;
      SetAllPositions(cell, batch);
      SumInverseDepths<true>(rows, column, units_per_metre, cell, batch);
    } else {
      const std::uint64_t bits = MeasuredBits(rows, column);
      measured += hwy::PopCount(bits);
      SetPositions(bits, cell, batch);
      if (bits == 0) {
        for (auto* parts : {batch.q_parts, batch.uq_parts, batch.vq_parts, batch.residual_parts})
          std::fill_n(parts[cell], 4, 0.0F);
        continue;
      }
      SumInverseDepths<false>(rows, column, units_per_metre, cell, batch);
    }
  }
  for (std::size_t cell = 0; cell < Batch::kCells; cell += kLanes) FitPlanes(cell, least, batch, out);
  for (std::size_t cell = 0; cell < cells; ++cell) {
    if (batch.measured[cell] == kAll) {
      SumResiduals<true>(cell, batch);
    } else if (batch.measured[cell] != 0) {
      SumResiduals<false>(cell, batch);
    }
  }
  for (std::size_t cell = 0; cell < Batch::kCells; cell += kLanes) {
    const Float n = hn::LoadU(d, out.n + cell);
    const Float residual = hn::Div(SumParts(batch.residual_parts + cell), n);
    hn::StoreU(hn::IfThenElse(hn::Gt(n, hn::Zero(d)), residual, hn::Set(d, kNoFit)), d, out.mean_squared_residual + cell);
  }
  return measured;
}

HWY_INLINE CellMoments From(const CellMoments& m, std::size_t cell) {
  return {m.n + cell,  m.u + cell,  m.v + cell,  m.q + cell,  m.uu + cell,
          m.uv + cell, m.vv + cell, m.du + cell, m.dv + cell, m.mean_squared_residual + cell};
}

template <class Raw>
std::size_t Moments(const CellRows<Raw>& rows, std::size_t cells, float metres_per_unit, float least, const CellMoments& out) {
  const float units_per_metre = 1.0F / metres_per_unit;
  std::size_t first = 0;
  std::size_t measured = 0;
  for (; first + Batch::kCells <= cells; first += Batch::kCells) {
    measured += MomentsOfBatch(rows, first, Batch::kCells, units_per_metre, least, From(out, first));
  }
  if (first == cells) return measured;
  constexpr std::size_t kFields = 10;
  float rest[kFields][Batch::kCells];
  measured += MomentsOfBatch(rows, first, cells - first, units_per_metre, least,
                             {rest[0], rest[1], rest[2], rest[3], rest[4], rest[5], rest[6], rest[7], rest[8], rest[9]});
  const CellMoments tail = From(out, first);
  float* const fields[kFields] = {tail.n,  tail.u,  tail.v,  tail.q,  tail.uu,
                                  tail.uv, tail.vv, tail.du, tail.dv, tail.mean_squared_residual};
  for (std::size_t i = 0; i < kFields; ++i) std::copy_n(rest[i], cells - first, fields[i]);
  return measured;
}

// ---- labels ----

/// What belongs to a plane, in raw units: raw (|z q - 1| - tolerance raw) <= floor.
struct Threshold {
  HWY_INLINE Threshold(float tolerance_raw, float floor_raw)
      : tolerance(hn::Set(FloatTag(), tolerance_raw)), floor(hn::Set(FloatTag(), floor_raw)) {}
  HWY_INLINE Mask Admits(Float raw, Float residual) const {
    return hn::Le(hn::Mul(raw, hn::NegMulAdd(tolerance, raw, residual)), floor);
  }
  Float tolerance;
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

/// Finds which measurements of a cell belong to which plane, as bits, and adds up their squared residuals. All planes are held
/// to the same threshold, so that it is enough to ask whether the nearest passes.
template <std::size_t kPlanes, bool kFull, class Raw>
HWY_INLINE void AssignCell(const CellRows<Raw>& rows, std::size_t column, const CellPlane* HWY_RESTRICT planes,
                           std::size_t num_planes, const Threshold& threshold, std::uint64_t* HWY_RESTRICT bits,
                           Float* HWY_RESTRICT squared) {
  const FloatTag d;
  const std::size_t count = kPlanes == 0 ? num_planes : kPlanes;
  for (std::size_t p = 0; p < count; ++p) bits[p] = 0;
  for (std::size_t i = 0; i < kSide; i += kLanes) {
    const Float columns = hn::Add(hn::Set(d, static_cast<float>(column)), hn::Iota(d, static_cast<float>(i)));
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
      Mask inside = threshold.Admits(raw, nearest);
      if constexpr (!kFull) inside = hn::And(inside, hn::Gt(raw, hn::Zero(d)));
      for (std::size_t p = 0; p < count; ++p) {
        Mask own = inside;
        if constexpr (kPlanes == 2) {
          own = p == 1 ? hn::And(inside, nearer) : hn::AndNot(nearer, inside);
        } else if constexpr (kPlanes != 1) {
          own = hn::And(inside, hn::Eq(which, hn::Set(d, static_cast<float>(p))));
        }
        const Float own_residual = hn::IfThenElseZero(own, nearest);
        squared[p] = hn::MulAdd(own_residual, own_residual, squared[p]);
        bits[p] |= Bits(own) << (kSide * v + i);
      }
    }
  }
}

HWY_INLINE void StoreRow(std::uint64_t row, std::uint8_t* HWY_RESTRICT labels) { std::memcpy(labels, &row, sizeof row); }

/// Stores labels of a cell: 0 where nothing was measured, a plane's where its bit is set, else 255. `inverse` is what a plane's
/// label lacks to 255, in every byte.
HWY_INLINE void StoreLabels(std::uint64_t measured, const std::uint64_t* HWY_RESTRICT bits,
                            const std::uint64_t* HWY_RESTRICT inverse, std::size_t num_planes, std::uint8_t* const* labels,
                            std::size_t column) {
  for (std::size_t p = 0; p < num_planes; ++p) {
    if (bits[p] != kAll) continue;  // else the cell lies within the plane, as most do
    for (std::size_t v = 0; v < kSide; ++v) StoreRow(~inverse[p], labels[v] + column);
    return;
  }
  for (std::size_t v = 0; v < kSide; ++v) {
    const auto bytes = [v](std::uint64_t all) { return kBytesOfBits[all >> (kSide * v) & 0xFF]; };
    std::uint64_t row = bytes(measured);
    for (std::size_t p = 0; p < num_planes; ++p) row &= ~(bytes(bits[p]) & inverse[p]);
    StoreRow(row, labels[v] + column);
  }
}

template <std::size_t kPlanes, class Raw>
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
  for (std::size_t cell = first; cell < first + cells; ++cell) {
    const Threshold threshold(tolerance.per_cell[cell] * metres_per_unit, floor);
    const std::size_t column = cell * kSide;
    std::uint64_t bits[kMost];
    if (IsFull(rows, column)) {
      AssignCell<kPlanes, true>(rows, column, planes, count, threshold, bits, squared);
      StoreLabels(kAll, bits, inverse, count, labels, column);
    } else {
      AssignCell<kPlanes, false>(rows, column, planes, count, threshold, bits, squared);
      StoreLabels(MeasuredBits(rows, column), bits, inverse, count, labels, column);
    }
    for (std::size_t p = 0; p < count; ++p) evidence[p].count[cell - first] = static_cast<std::uint8_t>(hwy::PopCount(bits[p]));
  }
  for (std::size_t p = 0; p < count; ++p) evidence[p].squared_residual = hn::GetLane(hn::SumOfLanes(d, squared[p]));
}

template <class Raw>
void Label(const CellRows<Raw>& rows, std::size_t first, std::size_t cells, float metres_per_unit, const CellPlane* planes,
           std::size_t num_planes, const CellTolerance& tolerance, std::uint8_t* const* labels, CellRunEvidence* evidence) {
  const auto run = num_planes == 1   ? LabelRun<1, Raw>
                   : num_planes == 2 ? LabelRun<2, Raw>
                   : num_planes == 3 ? LabelRun<3, Raw>
                                     : LabelRun<0, Raw>;
  run(rows, first, cells, metres_per_unit, planes, num_planes, tolerance, labels, evidence);
}

template <class Raw>
void LabelNone(const CellRows<Raw>& rows, std::size_t first, std::size_t cells, std::uint8_t* const* labels) {
  const RawTag<Raw> d;
  const hn::RebindToSigned<RawTag<Raw> > di;
  const hn::Rebind<std::int8_t, RawTag<Raw> > d8;
  for (std::size_t v = 0; v < kSide; ++v) {
    auto* const row = reinterpret_cast<std::int8_t*>(labels[v]);  // NOLINT: all bits set is 255
    for (std::size_t u = first * kSide; u < (first + cells) * kSide; u += hn::Lanes(d)) {
      const auto measured = hn::Ne(hn::LoadU(d, rows.rows[v] + u), hn::Zero(d));
      hn::StoreU(hn::DemoteTo(d8, hn::BitCast(di, hn::VecFromMask(d, measured))), d8, row + u);
    }
  }
}

template <class Raw>
typename CellKernels<Raw>::Fits FitsOfCell(const CellRows<Raw>& rows, std::size_t cell, float metres_per_unit,
                                           const CellPlane& candidate, const CellTolerance& tolerance) {
  const std::size_t column = cell * kSide;
  const CellPlane plane = InRawUnits(candidate, metres_per_unit);
  const Threshold threshold(tolerance.per_cell[cell] * metres_per_unit, tolerance.floor_m / metres_per_unit);
  std::uint64_t fitting = 0;
  Float squared = hn::Zero(FloatTag());
  AssignCell<1, false>(rows, column, &plane, 1, threshold, &fitting, &squared);
  return {static_cast<std::uint32_t>(hwy::PopCount(fitting)),
          static_cast<std::uint32_t>(hwy::PopCount(MeasuredBits(rows, column)))};
}

template <class Raw>
constexpr CellKernels<Raw> kTable = {Moments<Raw>, Label<Raw>, LabelNone<Raw>, FitsOfCell<Raw>};

}  // namespace cells

const CellKernels<std::uint16_t>* Cells16() { return &cells::kTable<std::uint16_t>; }
const CellKernels<float>* Cells32() { return &cells::kTable<float>; }

#endif
}  // namespace HWY_NAMESPACE
}  // namespace fransac::kernels
HWY_AFTER_NAMESPACE();

#endif  // include guard
