// SPDX-License-Identifier: Apache-2.0
// Width-agnostic bodies, compiled once per instruction set by rows.cc. See rows.h for what each computes.
// The usual include guard of Highway: this file is read once per target.
#if defined(FRANSAC_KERNELS_ROWS_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef FRANSAC_KERNELS_ROWS_INL_H_
#undef FRANSAC_KERNELS_ROWS_INL_H_
#else
#define FRANSAC_KERNELS_ROWS_INL_H_
#endif

#include <array>
#include <cstring>

#include "hwy/highway.h"
#include "kernels/bits.h"
#include "kernels/block_sums-inl.h"
#include "kernels/rows.h"

#ifndef FRANSAC_KERNELS_ROWS_TABLE_
#define FRANSAC_KERNELS_ROWS_TABLE_
namespace fransac::kernels {

/// The positions of the bits that are set in a byte, in order.
struct SetBits {
  std::uint8_t positions[8] = {};
  std::uint8_t count = 0;
};

inline constexpr std::array<SetBits, 256> kSetBits = [] {
  std::array<SetBits, 256> table{};
  for (unsigned byte = 0; byte < 256; ++byte) {
    for (std::uint8_t bit = 0; bit < 8; ++bit) {
      if ((byte >> bit & 1U) != 0) table[byte].positions[table[byte].count++] = bit;
    }
  }
  return table;
}();

}  // namespace fransac::kernels
#endif

HWY_BEFORE_NAMESPACE();
namespace fransac::kernels {
namespace HWY_NAMESPACE {
namespace rows {
namespace hn = hwy::HWY_NAMESPACE;

// At most one block per vector, so that n is a whole number of vectors.
using FloatTag = hn::CappedTag<float, kBlock>;
using IntTag = hn::RebindToSigned<FloatTag>;
using Float = hn::Vec<FloatTag>;

using Sum = PlaceSums<FloatTag, kBlock>;

/// Calls body(u, part) for the columns of one vector after the other, which is the part-th of its block.
template <class Body>
HWY_INLINE void ForEachVector(std::size_t n, const Body& body) {
  for (std::size_t u = 0; u < n; u += kBlock) {
    for (std::size_t part = 0; part < Sum::kParts; ++part) body(u + part * hn::MaxLanes(FloatTag()), part);
  }
}

HWY_INLINE Float LoadRaw(const std::uint16_t* HWY_RESTRICT raw) {
  return hn::ConvertTo(FloatTag(), hn::PromoteTo(IntTag(), hn::LoadU(hn::Rebind<std::uint16_t, FloatTag>(), raw)));
}
HWY_INLINE Float LoadRaw(const float* HWY_RESTRICT raw) { return hn::LoadU(FloatTag(), raw); }

/// base + step * u for the columns of one vector after the other.
class Columns {
 public:
  explicit Columns(const Ramp& ramp)
      : base_(hn::Set(FloatTag(), ramp.base)), step_(hn::Set(FloatTag(), ramp.step)), column_(hn::Iota(FloatTag(), 0.0F)) {}
  HWY_INLINE Float Next() {
    const Float value = MulThenAdd(step_, column_, base_);
    column_ = hn::Add(column_, hn::Set(FloatTag(), static_cast<float>(hn::Lanes(FloatTag()))));
    return value;
  }

 private:
  Float base_;
  Float step_;
  Float column_;
};

/// The signed distances of one vector of pixels after the other.
class Distances {
 public:
  explicit Distances(const RowPlane& plane) : product_(plane.ramp), d_(hn::Set(FloatTag(), plane.d)) {}
  HWY_INLINE Float Next(Float raw) { return MulThenAdd(raw, product_.Next(), d_); }

 private:
  Columns product_;
  Float d_;
};

/// Counts true lanes.
class Counter {
 public:
  HWY_INLINE Counter() : count_(hn::Zero(IntTag())) {}  // a constructor made by the compiler would miss the instruction set
  template <class Mask>
  HWY_INLINE void Add(Mask mask) {
    count_ = hn::Sub(count_, hn::VecFromMask(IntTag(), hn::RebindMask(IntTag(), mask)));  // a true lane is -1
  }
  [[nodiscard]] HWY_INLINE std::uint32_t Total() const {
    return static_cast<std::uint32_t>(hn::GetLane(hn::SumOfLanes(IntTag(), count_)));
  }

 private:
  hn::Vec<IntTag> count_;
};

template <class Raw>
using RawTag = hn::CappedTag<Raw, kBlock>;

template <class Raw>
void KeepRange(const Raw* HWY_RESTRICT raw, std::size_t n, Raw min, Raw max, Raw* HWY_RESTRICT kept) {
  const RawTag<Raw> d;
  const auto lo = hn::Set(d, min);
  const auto hi = hn::Set(d, max);
  for (std::size_t u = 0; u < n; u += hn::Lanes(d)) {
    const auto value = hn::LoadU(d, raw + u);
    const auto inside = hn::Eq(hn::Min(hn::Max(value, lo), hi), value);
    hn::StoreU(hn::IfThenElseZero(inside, value), d, kept + u);
  }
}

template <class Raw>
std::size_t CountMeasured(const Raw* HWY_RESTRICT raw, std::size_t n) {
  const RawTag<Raw> d;
  std::size_t zeros = 0;
  for (std::size_t u = 0; u < n; u += hn::Lanes(d)) zeros += hn::CountTrue(d, hn::Eq(hn::LoadU(d, raw + u), hn::Zero(d)));
  return n - zeros;
}

template <class Raw>
Raw Largest(const Raw* HWY_RESTRICT raw, std::size_t n) {
  const RawTag<Raw> d;
  auto most = hn::Zero(d);
  for (std::size_t u = 0; u < n; u += hn::Lanes(d)) most = hn::Max(most, hn::LoadU(d, raw + u));
  alignas(64) Raw lanes[kBlock];
  hn::Store(most, d, lanes);
  Raw largest = 0;
  for (std::size_t i = 0; i < hn::Lanes(d); ++i) largest = lanes[i] > largest ? lanes[i] : largest;
  return largest;
}

/// Whether each of eight columns' key differs from that of the column before, as bits.
HWY_INLINE unsigned DiffersFromLeft(const std::uint32_t* HWY_RESTRICT keys) {
  const hn::CappedTag<std::uint32_t, 8> d;
  std::uint8_t bits[8];
  unsigned byte = 0;
  for (std::size_t i = 0; i < 8; i += hn::Lanes(d)) {
    hn::StoreMaskBits(d, hn::Ne(hn::LoadU(d, keys + i), hn::LoadU(d, keys + i - 1)), bits);
    byte |= static_cast<unsigned>(bits[0]) << i;
  }
  return byte;
}

/// Lists the columns at which a run of equal keys or a stretch of kSumColumns columns starts, without a branch on the data.
HWY_INLINE std::size_t ListStarts(const std::uint32_t* HWY_RESTRICT keys, std::size_t n, std::uint32_t* HWY_RESTRICT starts) {
  const hn::CappedTag<std::uint32_t, 8> d;
  const hn::Rebind<std::uint8_t, decltype(d)> d8;
  std::size_t runs = 0;
  for (std::size_t u = 0; u < n; u += 8) {
    const unsigned bits = DiffersFromLeft(keys + u) | static_cast<unsigned>(u % kSumColumns == 0);
    const SetBits& set = kSetBits[bits];
    for (std::size_t i = 0; i < 8; i += hn::Lanes(d)) {
      const auto column = hn::PromoteTo(d, hn::LoadU(d8, set.positions + i));
      hn::StoreU(hn::Add(column, hn::Set(d, static_cast<std::uint32_t>(u))), d, starts + runs + i);
    }
    runs += set.count;
  }
  starts[runs] = static_cast<std::uint32_t>(n);
  return runs;
}

/// Whether a whole block was not measured: a large part of most frames, whose pixels come in regions.
template <class Raw>
HWY_INLINE bool BlockIsEmpty(const Raw* HWY_RESTRICT raw) {
  const RawTag<Raw> d;
  bool empty = true;
  for (std::size_t i = 0; i < kBlock; i += hn::Lanes(d)) empty &= hn::AllTrue(d, hn::Eq(hn::LoadU(d, raw + i), hn::Zero(d)));
  return empty;
}

template <class Raw>
std::size_t LeafRuns(const Raw* HWY_RESTRICT raw, std::size_t n, const LeafRow& row, std::uint32_t* HWY_RESTRICT keys,
                     std::uint32_t* HWY_RESTRICT starts) {
  const FloatTag d;
  const IntTag di;
  const hn::RebindToUnsigned<FloatTag> du;
  const auto per_unit = hn::Set(d, row.per_unit);
  const auto ray_y = hn::Set(d, row.ray_y);
  // A whole number plus 1.5 * 2^23 has it in its lowest bits: cheaper than a conversion, which has to mind overflow.
  const auto to_bits = hn::Set(d, 0x1.8p23F);
  const auto index = [&](Float leaves) HWY_ATTR { return hn::BitCast(di, hn::Add(hn::Floor(leaves), to_bits)); };
  const auto from_bits = [&](int axis) { return static_cast<std::uint32_t>(row.first[axis]) - 0x4B400000U; };
  // Shifts and sums are mod 2^32, so that one constant sets all three indices right.
  const auto offset =
      hn::Set(di, static_cast<std::int32_t>(from_bits(0) + (from_bits(1) << row.shift_y) + (from_bits(2) << row.shift_z)));
  // Locals: a key that is stored might be the row's for all the compiler knows.
  const float* const HWY_RESTRICT ray_x = row.ray_x;
  const int shift_y = row.shift_y;
  const int shift_z = row.shift_z;
  for (std::size_t u = 0; u < n; u += hn::Lanes(d)) {
    if (u % kBlock == 0 && BlockIsEmpty(raw + u)) {
      for (std::size_t i = 0; i < kBlock; i += hn::Lanes(d)) hn::StoreU(hn::Set(du, kNoLeaf), du, keys + u + i);
      u += kBlock - hn::Lanes(d);
      continue;
    }
    const Float value = LoadRaw(raw + u);
    const Float q = hn::Mul(value, per_unit);
    const auto x = index(hn::Mul(q, hn::LoadU(d, ray_x + u)));
    const auto y = index(hn::Mul(q, ray_y));
    const auto z = index(q);
    const auto key = hn::Add(hn::Add(x, offset), hn::Add(hn::ShiftLeftSame(y, shift_y), hn::ShiftLeftSame(z, shift_z)));
    const auto unmeasured = hn::RebindMask(di, hn::Eq(value, hn::Zero(d)));
    hn::StoreU(hn::BitCast(du, hn::IfThenZeroElse(unmeasured, key)), du, keys + u);
  }
  return ListStarts(keys, n, starts);
}

#if HWY_TARGET == HWY_SCALAR
void RunningSums(const std::uint16_t* raw, std::size_t n, std::uint64_t* sums) { ref::running_sums(raw, n, sums); }
#else
/// Four columns at a time, however wide a vector is.
void RunningSums(const std::uint16_t* HWY_RESTRICT raw, std::size_t n, std::uint64_t* HWY_RESTRICT sums) {
  const hn::FixedTag<std::uint32_t, 4> d32;
  const hn::FixedTag<std::uint64_t, 2> d64;
  const hn::Rebind<std::uint16_t, decltype(d32)> d16;
  const auto columns = hn::Set(d32, 4);
  const auto last_column = hn::Set(d32, kSumColumns - 1);
  auto column = hn::Iota(d32, 0);
  auto before = hn::Zero(d64);  // the sum of all columns before, twice
  for (std::size_t u = 0; u < n; u += 4) {
    if (u % kBlock == 0 && BlockIsEmpty(raw + u)) {
      for (std::size_t i = 0; i < kBlock; i += 2) hn::StoreU(before, d64, sums + u + 1 + i);
      column = hn::Add(column, hn::Set(d32, kBlock));
      u += kBlock - 4;
      continue;
    }
    const auto value = hn::PromoteTo(d32, hn::LoadU(d16, raw + u));
    const auto weighted = hn::Mul(value, hn::And(column, last_column));
    const auto pair01 = hn::BitCast(d64, hn::InterleaveLower(d32, value, weighted));
    const auto pair23 = hn::BitCast(d64, hn::InterleaveUpper(d32, value, weighted));
    const auto sum01 = hn::Add(pair01, hn::ShiftLeftLanes<1>(d64, pair01));
    const auto sum23 = hn::Add(hn::Add(pair23, hn::ShiftLeftLanes<1>(d64, pair23)), hn::DupOdd(sum01));
    hn::StoreU(hn::Add(before, sum01), d64, sums + u + 1);
    const auto upto = hn::Add(before, sum23);
    hn::StoreU(upto, d64, sums + u + 3);
    before = hn::DupOdd(upto);
    column = hn::Add(column, columns);
  }
  sums[0] = 0;
}
#endif

template <class Raw>
Msac ScoreRow(const Raw* HWY_RESTRICT raw, std::size_t n, const RowPlane& plane) {
  const FloatTag d;
  const Float one = hn::Set(d, 1.0F);
  Distances distances(plane);
  Counter inliers;
  Sum gain;
  ForEachVector(n, [&](std::size_t u, std::size_t part) HWY_ATTR {
    const Float value = LoadRaw(raw + u);
    const Float distance = distances.Next(value);
    const Float share = hn::Sub(one, hn::Mul(distance, distance));
    const auto inlier = hn::And(hn::Ge(share, hn::Zero(d)), hn::Gt(value, hn::Zero(d)));
    gain.Add(part, hn::IfThenElseZero(inlier, share));
    inliers.Add(inlier);
  });
  return {gain.Total(), inliers.Total()};
}

/// Stores the values where the mask is true, 0 elsewhere.
template <class Mask>
HWY_INLINE void StoreWhere(Mask mask, Float value, float* HWY_RESTRICT out) {
  hn::StoreU(hn::IfThenElseZero(mask, value), FloatTag(), out);
}
template <class Mask>
HWY_INLINE void StoreWhere(Mask mask, Float value, std::uint16_t* HWY_RESTRICT out) {
  const auto whole = hn::ConvertTo(IntTag(), hn::IfThenElseZero(mask, value));  // exact: 16 bits
  hn::StoreU(hn::DemoteTo(hn::Rebind<std::uint16_t, FloatTag>(), whole), hn::Rebind<std::uint16_t, FloatTag>(), out);
}

template <class Raw>
void RemoveRow(const Raw* raw, std::size_t n, const RowPlane& plane, Raw* left) {
  const FloatTag d;
  Distances distances(plane);
  for (std::size_t u = 0; u < n; u += hn::Lanes(d)) {
    const Float value = LoadRaw(raw + u);
    StoreWhere(hn::Gt(hn::Abs(distances.Next(value)), hn::Set(d, 1.0F)), value, left + u);
  }
}

template <class Raw>
RowMoments MomentsRow(const Raw* HWY_RESTRICT raw, std::size_t n, const RowPlane& plane, float threshold, const Ramp& ray) {
  const FloatTag d;
  const Float t = hn::Set(d, threshold);
  Distances distances(plane);
  Columns rays(ray);
  Counter inliers;
  Sum z, zz, za, zza, zzaa;
  ForEachVector(n, [&](std::size_t u, std::size_t part) HWY_ATTR {
    const Float value = LoadRaw(raw + u);
    const auto inlier = hn::And(hn::Le(hn::Abs(distances.Next(value)), t), hn::Gt(value, hn::Zero(d)));
    const Float depth = hn::IfThenElseZero(inlier, value);
    const Float x = hn::Mul(depth, rays.Next());
    inliers.Add(inlier);
    z.Add(part, depth);
    zz.Add(part, hn::Mul(depth, depth));
    za.Add(part, x);
    zza.Add(part, hn::Mul(depth, x));
    zzaa.Add(part, hn::Mul(x, x));
  });
  return {inliers.Total(), z.Total(), zz.Total(), za.Total(), zza.Total(), zzaa.Total()};
}

HWY_INLINE void StoreLabels(hn::Vec<IntTag> labels, std::uint8_t* HWY_RESTRICT out) {
  const hn::Rebind<std::uint8_t, FloatTag> d8;
  hn::StoreU(hn::DemoteTo(d8, labels), d8, out);
}

/// Labels of pixels without a measurement become 0.
template <class Raw>
HWY_INLINE void ClearUnmeasured(const Raw* HWY_RESTRICT raw, std::size_t n, std::uint8_t* HWY_RESTRICT labels) {
  const RawTag<Raw> d;
  const hn::Rebind<std::uint8_t, RawTag<Raw>> d8;
  const hn::RebindToSigned<RawTag<Raw>> di;
  for (std::size_t u = 0; u < n; u += hn::Lanes(d)) {
    const auto measured = hn::VecFromMask(di, hn::RebindMask(di, hn::Gt(hn::LoadU(d, raw + u), hn::Zero(d))));
    const auto bytes = hn::BitCast(d8, hn::DemoteTo(hn::RebindToSigned<decltype(d8)>(), measured));  // -1 stays -1
    hn::StoreU(hn::And(hn::LoadU(d8, labels + u), bytes), d8, labels + u);
  }
}

template <class Raw>
void LabelRow(const Raw* HWY_RESTRICT raw, const Raw* HWY_RESTRICT kept, std::size_t n, const LabelPlane* HWY_RESTRICT planes,
              std::size_t num_planes, float threshold, std::uint8_t* HWY_RESTRICT labels) {
  const FloatTag d;
  const IntTag di;
  Float column = hn::Iota(d, 0.0F);
  for (std::size_t u = 0; u < n; u += hn::Lanes(d)) {
    const Float value = LoadRaw(kept + u);
    Float nearest = hn::Set(d, threshold);
    auto label = hn::Set(di, 255);
    for (std::size_t p = num_planes; p-- > 0;) {  // backwards, so that the first of equally near ones stays
      const RowPlane& plane = planes[p].plane;
      const Float product = MulThenAdd(hn::Set(d, plane.ramp.step), column, hn::Set(d, plane.ramp.base));
      const Float distance = hn::Abs(MulThenAdd(value, product, hn::Set(d, plane.d)));
      const auto nearer = hn::Le(distance, nearest);
      nearest = hn::IfThenElse(nearer, distance, nearest);
      label = hn::IfThenElse(hn::RebindMask(di, nearer), hn::Set(di, planes[p].label), label);
    }
    const auto removed = hn::RebindMask(di, hn::Eq(value, hn::Zero(d)));
    StoreLabels(hn::IfThenElse(removed, hn::Set(di, 255), label), labels + u);
    column = hn::Add(column, hn::Set(d, static_cast<float>(hn::Lanes(d))));
  }
  ClearUnmeasured(raw, n, labels);
}

/// Adds up what pixels of one plane show.
class Evidence {
 public:
  HWY_INLINE Evidence() {}  // NOLINT(modernize-use-equals-default): that one would miss the instruction set
  template <class Mask>
  HWY_INLINE void Add(std::size_t part, Mask mask, Float raw, Float distance) {
    count_.Add(mask);
    const Float own_distance = hn::IfThenElseZero(mask, distance);
    squared_.Add(part, hn::Mul(own_distance, own_distance));
    const Float own_depth = hn::IfThenElseZero(mask, raw);
    cubed_.Add(part, hn::Mul(hn::Mul(own_depth, own_depth), own_depth));
  }
  [[nodiscard]] HWY_INLINE RowEvidence Result() const { return {count_.Total(), squared_.Total(), cubed_.Total()}; }

 private:
  Counter count_;
  Sum squared_;
  Sum cubed_;
};

template <class Raw>
RowEvidence EvidenceRow(const Raw* HWY_RESTRICT raw, const std::uint8_t* HWY_RESTRICT labels, std::size_t n,
                        const LabelPlane& plane) {
  const FloatTag d;
  const IntTag di;
  const hn::Rebind<std::uint8_t, FloatTag> d8;
  const auto own = hn::Set(di, plane.label);
  Distances distances(plane.plane);
  Evidence evidence;
  ForEachVector(n, [&](std::size_t u, std::size_t part) HWY_ATTR {
    const Float value = LoadRaw(raw + u);
    const auto label = hn::PromoteTo(di, hn::LoadU(d8, labels + u));
    evidence.Add(part, hn::RebindMask(d, hn::Eq(label, own)), value, distances.Next(value));
  });
  return evidence.Result();
}

/// Stores `label` where the mask is true and 255 elsewhere.
template <class Mask>
HWY_INLINE void StoreLabelOr255(Mask mask, std::uint8_t label, std::uint8_t* HWY_RESTRICT out) {
  const FloatTag d;
  const std::uint64_t difference = 0x0101010101010101U * static_cast<std::uint64_t>(255U - label);
  std::uint8_t bits[8];
  hn::StoreMaskBits(d, mask, bits);
  for (std::size_t i = 0; i < hn::Lanes(d); i += 8) {
    const std::uint64_t labels = ~(kBytesOfBits[bits[i / 8]] & difference);
    std::memcpy(out + i, &labels, HWY_MIN(hn::Lanes(d), 8));
  }
}

template <class Raw>
RowEvidence LabelRowOne(const Raw* HWY_RESTRICT raw, const Raw* HWY_RESTRICT kept, std::size_t n, const LabelPlane& plane,
                        float threshold, std::uint8_t* HWY_RESTRICT labels) {
  const FloatTag d;
  const Float t = hn::Set(d, threshold);
  const std::uint8_t label = plane.label;
  Distances distances(plane.plane);
  Evidence evidence;
  ForEachVector(n, [&](std::size_t u, std::size_t part) HWY_ATTR {
    const Float value = LoadRaw(kept + u);
    const Float distance = distances.Next(value);
    const auto inlier = hn::And(hn::Le(hn::Abs(distance), t), hn::Gt(value, hn::Zero(d)));
    StoreLabelOr255(inlier, label, labels + u);
    evidence.Add(part, inlier, value, distance);
  });
  ClearUnmeasured(raw, n, labels);
  return evidence.Result();
}

template <class Raw>
constexpr RowKernels<Raw> kTable = {KeepRange<Raw>, CountMeasured<Raw>, Largest<Raw>,  LeafRuns<Raw>,    ScoreRow<Raw>,
                                    RemoveRow<Raw>, MomentsRow<Raw>,    LabelRow<Raw>, EvidenceRow<Raw>, LabelRowOne<Raw>};

}  // namespace rows

void RunningSums(const std::uint16_t* raw, std::size_t n, std::uint64_t* sums) { rows::RunningSums(raw, n, sums); }
const RowKernels<std::uint16_t>* Rows16() { return &rows::kTable<std::uint16_t>; }
const RowKernels<float>* Rows32() { return &rows::kTable<float>; }

}  // namespace HWY_NAMESPACE
}  // namespace fransac::kernels
HWY_AFTER_NAMESPACE();

#endif  // include guard
