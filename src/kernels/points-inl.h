// SPDX-License-Identifier: Apache-2.0
// Width-agnostic bodies, compiled once per instruction set by points.cc. See points.h for what each computes.
// The usual include guard of Highway: this file is read once per target.
#if defined(FRANSAC_KERNELS_POINTS_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef FRANSAC_KERNELS_POINTS_INL_H_
#undef FRANSAC_KERNELS_POINTS_INL_H_
#else
#define FRANSAC_KERNELS_POINTS_INL_H_
#endif

#include <cmath>
#include <limits>

#include "hwy/highway.h"
#include "kernels/block_sums-inl.h"
#include "kernels/points.h"

HWY_BEFORE_NAMESPACE();
namespace fransac::kernels {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

// At most one block per vector, so that n is a whole number of vectors.
using FloatTag = hn::CappedTag<float, kBlock>;
using Float = hn::Vec<FloatTag>;

/// Which points are finite and not where `unmeasured` (x, y, z) says that there is none.
template <class Tag>
HWY_INLINE hn::Mask<Tag> Measured(hn::Vec<Tag> x, hn::Vec<Tag> y, hn::Vec<Tag> z, const float* HWY_RESTRICT unmeasured) {
  const Tag d;
  const auto zero = hn::Zero(d);
  // 0 times infinity or NaN is NaN.
  const auto finite = hn::Eq(hn::Add(hn::Add(hn::Mul(x, zero), hn::Mul(y, zero)), hn::Mul(z, zero)), zero);
  const auto is = [&](hn::Vec<Tag> p, int axis)
                      HWY_ATTR { return hn::Eq(p, hn::Set(d, static_cast<hn::TFromD<Tag>>(unmeasured[axis]))); };
  return hn::AndNot(hn::And(hn::And(is(x, 0), is(y, 1)), is(z, 2)), finite);
}

Bounds BoundsOf(const float* HWY_RESTRICT values, std::size_t n) {
  const FloatTag d;
  const std::size_t lanes = hn::Lanes(d);
  Float min = hn::Set(d, std::numeric_limits<float>::infinity());
  Float max = hn::Set(d, -std::numeric_limits<float>::infinity());
  for (std::size_t i = 0; i < n; i += lanes) {
    const Float v = hn::Load(d, values + i);
    min = hn::IfThenElse(hn::Lt(v, min), v, min);
    max = hn::IfThenElse(hn::Gt(v, max), v, max);
  }
  return {hn::GetLane(hn::MinOfLanes(d, min)), hn::GetLane(hn::MaxOfLanes(d, max))};
}

std::size_t CountMeasured(const float* HWY_RESTRICT x, const float* HWY_RESTRICT y, const float* HWY_RESTRICT z, std::size_t n,
                          const float* HWY_RESTRICT unmeasured) {
  const FloatTag d;
  std::size_t count = 0;
  for (std::size_t i = 0; i < n; i += hn::Lanes(d)) {
    const auto measured = Measured<FloatTag>(hn::Load(d, x + i), hn::Load(d, y + i), hn::Load(d, z + i), unmeasured);
    count += hn::CountTrue(d, measured);
  }
  return count;
}

struct PlaneV {
  explicit PlaneV(const PlaneF& plane)
      : a(hn::Set(FloatTag(), plane.a)),
        b(hn::Set(FloatTag(), plane.b)),
        c(hn::Set(FloatTag(), plane.c)),
        d(hn::Set(FloatTag(), plane.d)) {}
  HWY_INLINE Float Residual(Float x, Float y, Float z) const { return MulThenAdd(a, x, MulThenAdd(b, y, MulThenAdd(c, z, d))); }
  Float a, b, c, d;
};

std::uint32_t CountInliers(const float* HWY_RESTRICT x, const float* HWY_RESTRICT y, const float* HWY_RESTRICT z, std::size_t n,
                           const PlaneF& plane, float threshold) {
  const FloatTag d;
  const hn::RebindToSigned<FloatTag> di;
  const std::size_t lanes = hn::Lanes(d);
  const PlaneV p(plane);
  const Float t = hn::Set(d, threshold);
  auto count = hn::Zero(di);
  for (std::size_t i = 0; i < n; i += lanes) {
    const Float r = p.Residual(hn::Load(d, x + i), hn::Load(d, y + i), hn::Load(d, z + i));
    const auto inlier = hn::Le(hn::Abs(r), t);
    count = hn::Sub(count, hn::VecFromMask(di, hn::RebindMask(di, inlier)));  // a true lane is -1
  }
  return static_cast<std::uint32_t>(hn::GetLane(hn::SumOfLanes(di, count)));
}

Msac MsacOf(const float* HWY_RESTRICT x, const float* HWY_RESTRICT y, const float* HWY_RESTRICT z, std::size_t n,
            const PlaneF& plane, float threshold) {
  const FloatTag d;
  const hn::RebindToSigned<FloatTag> di;
  const PlaneV p(plane);
  const Float t = hn::Set(d, threshold);
  const Float per_t = hn::Set(d, 1.0F / threshold);
  const Float one = hn::Set(d, 1.0F);
  PlaceSums<FloatTag, kBlock> gain;
  auto count = hn::Zero(di);
  for (std::size_t i = 0; i < n; i += kBlock) {
    for (std::size_t part = 0; part < gain.kParts; ++part) {
      const std::size_t at = i + part * hn::MaxLanes(d);
      const Float r = p.Residual(hn::Load(d, x + at), hn::Load(d, y + at), hn::Load(d, z + at));
      const auto inlier = hn::Le(hn::Abs(r), t);
      const Float share = hn::Mul(r, per_t);
      gain.Add(part, hn::IfThenElseZero(inlier, hn::Sub(one, hn::Mul(share, share))));
      count = hn::Sub(count, hn::VecFromMask(di, hn::RebindMask(di, inlier)));
    }
  }
  return {gain.Total(), static_cast<std::uint32_t>(hn::GetLane(hn::SumOfLanes(di, count)))};
}

InlierMoments InlierMomentsOf(const float* HWY_RESTRICT x, const float* HWY_RESTRICT y, const float* HWY_RESTRICT z,
                              std::size_t n, const PlaneF& plane, float threshold) {
  const FloatTag d;
  const hn::RebindToSigned<FloatTag> di;
  const hn::CappedTag<double, kBlock / 2> dd;
  const hn::Rebind<float, decltype(dd)> half;  // as many floats as fit into a vector of doubles
  const PlaneV p(plane);
  const Float t = hn::Set(d, threshold);
  auto count = hn::Zero(di);
  constexpr std::size_t kHalf = kBlock / 2;
  using Sum = PlaceSums<hn::CappedTag<double, kHalf>, kHalf>;
  Sum sx, sy, sz, xx, xy, xz, yy, yz, zz;
  alignas(64) float inliers[3][kBlock];
  for (std::size_t i = 0; i < n; i += kBlock) {
    for (std::size_t at = 0; at < kBlock; at += hn::Lanes(d)) {
      const Float fx = hn::Load(d, x + i + at);
      const Float fy = hn::Load(d, y + i + at);
      const Float fz = hn::Load(d, z + i + at);
      const auto inlier = hn::Le(hn::Abs(p.Residual(fx, fy, fz)), t);
      count = hn::Sub(count, hn::VecFromMask(di, hn::RebindMask(di, inlier)));
      hn::Store(hn::IfThenElseZero(inlier, fx), d, inliers[0] + at);
      hn::Store(hn::IfThenElseZero(inlier, fy), d, inliers[1] + at);
      hn::Store(hn::IfThenElseZero(inlier, fz), d, inliers[2] + at);
    }
    for (std::size_t first = 0; first < kBlock; first += kHalf) {
      for (std::size_t part = 0; part < Sum::kParts; ++part) {
        const std::size_t at = first + part * hn::MaxLanes(dd);
        const auto px = hn::PromoteTo(dd, hn::Load(half, inliers[0] + at));
        const auto py = hn::PromoteTo(dd, hn::Load(half, inliers[1] + at));
        const auto pz = hn::PromoteTo(dd, hn::Load(half, inliers[2] + at));
        sx.Add(part, px);
        sy.Add(part, py);
        sz.Add(part, pz);
        xx.AddExactProduct(part, px, px);  // of floats, in double
        xy.AddExactProduct(part, px, py);
        xz.AddExactProduct(part, px, pz);
        yy.AddExactProduct(part, py, py);
        yz.AddExactProduct(part, py, pz);
        zz.AddExactProduct(part, pz, pz);
      }
    }
  }
  return {static_cast<std::uint32_t>(hn::GetLane(hn::SumOfLanes(di, count))),
          {sx.Total(), sy.Total(), sz.Total(), xx.Total(), xy.Total(), xz.Total(), yy.Total(), yz.Total(), zz.Total()}};
}

void LabelPoints(const float* HWY_RESTRICT x, const float* HWY_RESTRICT y, const float* HWY_RESTRICT z, std::size_t n,
                 const NearestPlane& rule, std::uint8_t* HWY_RESTRICT labels) {
  using Doubles = hn::CappedTag<double, kBlock / 2>;
  const Doubles dd;
  const hn::Rebind<float, Doubles> df;
  const hn::Rebind<std::int32_t, Doubles> di;
  const hn::Rebind<std::uint8_t, Doubles> du8;
  const auto infinity = hn::Set(dd, std::numeric_limits<double>::infinity());
  const auto threshold = hn::Set(dd, rule.threshold);
  const auto no_depth = hn::Set(dd, static_cast<double>(rule.no_depth));
  const auto no_plane = hn::Set(dd, static_cast<double>(rule.no_plane));
  const auto one = hn::Set(dd, 1.0);
  for (std::size_t i = 0; i < n; i += hn::Lanes(dd)) {
    const auto px = hn::PromoteTo(dd, hn::Load(df, x + i));
    const auto py = hn::PromoteTo(dd, hn::Load(df, y + i));
    const auto pz = hn::PromoteTo(dd, hn::Load(df, z + i));
    auto label = no_plane;
    auto nearest = infinity;
    auto own = hn::Set(dd, static_cast<double>(rule.first));
    for (std::size_t k = 0; k < rule.count; ++k) {
      const PlaneD& p = rule.planes[k];
      const auto in_plane = hn::Add(hn::Mul(hn::Set(dd, p.a), px), hn::Mul(hn::Set(dd, p.b), py));
      const auto distance = hn::Abs(hn::Add(in_plane, hn::Add(hn::Mul(hn::Set(dd, p.c), pz), hn::Set(dd, p.d))));
      const auto nearer = hn::And(hn::Le(distance, threshold), hn::Lt(distance, nearest));
      nearest = hn::IfThenElse(nearer, distance, nearest);
      label = hn::IfThenElse(nearer, own, label);
      own = hn::Add(own, one);
    }
    label = hn::IfThenElse(Measured<Doubles>(px, py, pz, rule.unmeasured), label, no_depth);
    hn::StoreU(hn::DemoteTo(du8, hn::DemoteTo(di, label)), du8, labels + i);
  }
}

// A point fills a vector of four: nothing to gain where doubles come in pairs.
#if HWY_ARCH_X86 && HWY_TARGET <= HWY_AVX2  // better targets have smaller numbers
#define FRANSAC_POINT_IS_A_VECTOR 1
#else
#define FRANSAC_POINT_IS_A_VECTOR 0
#endif

#if FRANSAC_POINT_IS_A_VECTOR
/// A lattice along x, y and z at once. Whatever is made of points' leaves takes their indices from here: one that was rounded
/// otherwise would be in another leaf.
class LatticeV {
 public:
  using Point = hn::Vec<hn::FixedTag<double, 4>>;
  using Index = hn::Vec<hn::FixedTag<std::uint32_t, 4>>;
  using Term = hn::Vec<hn::FixedTag<std::uint64_t, 4>>;

  explicit HWY_INLINE LatticeV(const Lattice& lattice)
      : per_leaf_(hn::LoadU(kDoubles, lattice.per_leaf)),
        offset_(hn::LoadU(kDoubles, lattice.offset)),
        rounder_(hn::LoadU(kDoubles, lattice.rounder)) {
    alignas(32) constexpr std::uint64_t kCount[4] = {0, 0, 0, 1};
    zero_ = hn::Sub(hn::BitCast(kWholes, rounder_), hn::Load(kWholes, kCount));
  }
  /// The three floats at `point` and 0.
  static HWY_INLINE Point LoadPoint(const float* HWY_RESTRICT point) {
    return hn::PromoteTo(kDoubles, hn::MaskedLoad(hn::FirstN(kFloats, 3), kFloats, point));
  }
  /// The same where a fourth float can be read: a whole load takes less.
  static HWY_INLINE Point LoadPointOfFour(const float* HWY_RESTRICT point) {
    return hn::PromoteTo(kDoubles, hn::IfThenElseZero(hn::FirstN(kFloats, 3), hn::LoadU(kFloats, point)));
  }
  [[nodiscard]] HWY_INLINE Index IndexOf(Point point) const {
    return hn::BitCast(kIndices, hn::DemoteTo(kSigned, MulThenAdd(point, per_leaf_, offset_)));
  }
  /// What is added up: x, y and z in whole numbers, and 1.
  [[nodiscard]] HWY_INLINE Term TermOf(Point point) const {
    return hn::Sub(hn::BitCast(kWholes, hn::Add(point, rounder_)), zero_);
  }

 private:
  static constexpr hn::FixedTag<float, 4> kFloats{};
  static constexpr hn::FixedTag<double, 4> kDoubles{};
  static constexpr hn::FixedTag<std::int32_t, 4> kSigned{};
  static constexpr hn::FixedTag<std::uint32_t, 4> kIndices{};
  static constexpr hn::FixedTag<std::uint64_t, 4> kWholes{};

  Point per_leaf_;
  Point offset_;
  Point rounder_;
  Term zero_;
};
#endif

std::size_t LeafRuns(const float* HWY_RESTRICT points, std::size_t stride, std::size_t n, const Lattice& lattice,
                     LeafRun* HWY_RESTRICT runs) {
#if FRANSAC_POINT_IS_A_VECTOR
  const hn::FixedTag<std::uint32_t, 4> du;
  const hn::FixedTag<std::uint64_t, 4> du64;
  const LatticeV v(lattice);
  auto sum = hn::Zero(du64);
  auto previous = hn::Set(du, ~std::uint32_t{0});
  std::size_t count = 0;
  const auto add = [&](LatticeV::Point point) HWY_ATTR {
    const auto index = v.IndexOf(point);
    sum = hn::Add(sum, v.TermOf(point));
    // Where a run ends cannot be predicted, so it is no branch.
    count += static_cast<std::size_t>(hn::CountTrue(du, hn::Eq(index, previous)) < 4);
    previous = index;
    LeafRun& run = runs[count - 1];
    hn::Store(sum, du64, run.sum);
    hn::Store(index, du, run.index);
  };
  const std::size_t whole = stride >= 4 && n > 0 ? n - 1 : 0;  // of the last point the fourth float need not be there
  for (std::size_t i = 0; i < whole; ++i) add(v.LoadPointOfFour(points + i * stride));
  for (std::size_t i = whole; i < n; ++i) add(v.LoadPoint(points + i * stride));
  return count;
#else
  return ref::leaf_runs(points, stride, n, lattice, runs);
#endif
}

void LeafTerms(const float* HWY_RESTRICT points, std::size_t stride, std::size_t n, const Lattice& lattice,
               LeafTerm* HWY_RESTRICT terms, std::uint64_t* HWY_RESTRICT keys) {
#if FRANSAC_POINT_IS_A_VECTOR
  const hn::FixedTag<std::uint64_t, 4> du64;
  const LatticeV v(lattice);
  const auto shift = hn::LoadU(du64, lattice.shift);
  for (std::size_t i = 0; i < n; ++i) {
    const auto point = v.LoadPoint(points + i * stride);
    hn::Store(v.TermOf(point), du64, terms[i].sum);
    keys[i] = hn::GetLane(hn::SumOfLanes(du64, hn::Shl(hn::PromoteTo(du64, v.IndexOf(point)), shift)));
  }
#else
  ref::leaf_terms(points, stride, n, lattice, terms, keys);
#endif
}

void LeafBuckets(const float* HWY_RESTRICT points, std::size_t stride, std::size_t n, const Lattice& lattice,
                 std::uint8_t* HWY_RESTRICT buckets) {
#if FRANSAC_POINT_IS_A_VECTOR
  const hn::FixedTag<std::uint32_t, 4> du;
  const LatticeV v(lattice);
  alignas(16) constexpr std::uint32_t kFactors[4] = {kBucketFactors[0], kBucketFactors[1], kBucketFactors[2], 0};
  const auto factors = hn::Load(du, kFactors);
  for (std::size_t i = 0; i < n; ++i) {
    const auto products = hn::Mul(hn::ShiftRight<kCubeBits>(v.IndexOf(v.LoadPoint(points + i * stride))), factors);
    buckets[i] = static_cast<std::uint8_t>(hn::GetLane(hn::SumOfLanes(du, products)) >> 24);
  }
#else
  ref::leaf_buckets(points, stride, n, lattice, buckets);
#endif
}

Box BoxOf(const float* HWY_RESTRICT points, std::size_t stride, std::size_t n) {
#if FRANSAC_POINT_IS_A_VECTOR
  const hn::FixedTag<float, 4> df;
  const hn::FixedTag<float, 8> df2;
  const auto xyz = hn::FirstN(df, 3);
  std::size_t i = 0;
  auto min2 = hn::Set(df2, std::numeric_limits<float>::infinity());
  auto max2 = hn::Set(df2, -std::numeric_limits<float>::infinity());
  auto differences2 = hn::Zero(df2);  // of numbers and themselves: bits of a NaN unless all are finite
  if (stride == 4) {                  // two at once; of the last point the fourth float need not be there
    for (; i + 2 < n; i += 2) {
      const auto both = hn::LoadU(df2, points + i * stride);
      min2 = hn::Min(min2, both);
      max2 = hn::Max(max2, both);
      differences2 = hn::Or(differences2, hn::Sub(both, both));
    }
  }
  auto min = hn::Min(hn::LowerHalf(df, min2), hn::UpperHalf(df, min2));
  auto max = hn::Max(hn::LowerHalf(df, max2), hn::UpperHalf(df, max2));
  auto differences = hn::IfThenElseZero(xyz, hn::Or(hn::LowerHalf(df, differences2), hn::UpperHalf(df, differences2)));
  for (; i < n; ++i) {
    const auto point = hn::MaskedLoad(xyz, df, points + i * stride);
    min = hn::Min(min, point);
    max = hn::Max(max, point);
    differences = hn::Or(differences, hn::Sub(point, point));
  }
  const bool finite = hn::AllTrue(df, hn::Eq(differences, hn::Zero(df)));
  if (!finite) {  // anew, without those that are not
    min = hn::Set(df, std::numeric_limits<float>::infinity());
    max = hn::Set(df, -std::numeric_limits<float>::infinity());
    for (i = 0; i < n; ++i) {
      const auto point = hn::MaskedLoad(xyz, df, points + i * stride);
      if (!hn::AllTrue(df, hn::Eq(hn::Sub(point, point), hn::Zero(df)))) continue;
      min = hn::Min(min, point);
      max = hn::Max(max, point);
    }
  }
  alignas(16) float ends[2][4];
  hn::Store(min, df, ends[0]);
  hn::Store(max, df, ends[1]);
  return {{ends[0][0], ends[0][1], ends[0][2]}, {ends[1][0], ends[1][1], ends[1][2]}, finite};
#else
  return ref::box(points, stride, n);
#endif
}
#undef FRANSAC_POINT_IS_A_VECTOR

}  // namespace HWY_NAMESPACE
}  // namespace fransac::kernels
HWY_AFTER_NAMESPACE();

#endif  // include guard
