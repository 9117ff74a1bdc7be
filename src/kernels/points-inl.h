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
#include "kernels/points.h"

HWY_BEFORE_NAMESPACE();
namespace fransac::kernels {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

// At most one block per vector, so that n is a whole number of vectors.
using FloatTag = hn::CappedTag<float, kBlock>;
using Float = hn::Vec<FloatTag>;

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

struct PlaneV {
  explicit PlaneV(const PlaneF& plane)
      : a(hn::Set(FloatTag(), plane.a)),
        b(hn::Set(FloatTag(), plane.b)),
        c(hn::Set(FloatTag(), plane.c)),
        d(hn::Set(FloatTag(), plane.d)) {}
  HWY_INLINE Float Residual(Float x, Float y, Float z) const { return hn::MulAdd(a, x, hn::MulAdd(b, y, hn::MulAdd(c, z, d))); }
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
  const std::size_t lanes = hn::Lanes(d);
  const PlaneV p(plane);
  const Float t = hn::Set(d, threshold);
  const Float per_t = hn::Set(d, 1.0F / threshold);
  const Float one = hn::Set(d, 1.0F);
  Float gain = hn::Zero(d);
  auto count = hn::Zero(di);
  for (std::size_t i = 0; i < n; i += lanes) {
    const Float r = p.Residual(hn::Load(d, x + i), hn::Load(d, y + i), hn::Load(d, z + i));
    const auto inlier = hn::Le(hn::Abs(r), t);
    const Float share = hn::Mul(r, per_t);
    gain = hn::Add(gain, hn::IfThenElseZero(inlier, hn::NegMulAdd(share, share, one)));
    count = hn::Sub(count, hn::VecFromMask(di, hn::RebindMask(di, inlier)));
  }
  return {hn::GetLane(hn::SumOfLanes(d, gain)), static_cast<std::uint32_t>(hn::GetLane(hn::SumOfLanes(di, count)))};
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
  auto sx = hn::Zero(dd), sy = hn::Zero(dd), sz = hn::Zero(dd);
  auto xx = hn::Zero(dd), xy = hn::Zero(dd), xz = hn::Zero(dd), yy = hn::Zero(dd), yz = hn::Zero(dd), zz = hn::Zero(dd);
  alignas(64) float inliers[3][kBlock];
  for (std::size_t i = 0; i < n; i += hn::Lanes(d)) {
    const Float fx = hn::Load(d, x + i);
    const Float fy = hn::Load(d, y + i);
    const Float fz = hn::Load(d, z + i);
    const auto inlier = hn::Le(hn::Abs(p.Residual(fx, fy, fz)), t);
    count = hn::Sub(count, hn::VecFromMask(di, hn::RebindMask(di, inlier)));
    hn::Store(hn::IfThenElseZero(inlier, fx), d, inliers[0]);
    hn::Store(hn::IfThenElseZero(inlier, fy), d, inliers[1]);
    hn::Store(hn::IfThenElseZero(inlier, fz), d, inliers[2]);
    for (std::size_t k = 0; k < hn::Lanes(d); k += hn::Lanes(dd)) {
      const auto px = hn::PromoteTo(dd, hn::Load(half, inliers[0] + k));
      const auto py = hn::PromoteTo(dd, hn::Load(half, inliers[1] + k));
      const auto pz = hn::PromoteTo(dd, hn::Load(half, inliers[2] + k));
      sx = hn::Add(sx, px);
      sy = hn::Add(sy, py);
      sz = hn::Add(sz, pz);
      xx = hn::MulAdd(px, px, xx);
      xy = hn::MulAdd(px, py, xy);
      xz = hn::MulAdd(px, pz, xz);
      yy = hn::MulAdd(py, py, yy);
      yz = hn::MulAdd(py, pz, yz);
      zz = hn::MulAdd(pz, pz, zz);
    }
  }
  const auto sum = [&](auto v) { return hn::GetLane(hn::SumOfLanes(dd, v)); };
  const auto inlier_count = static_cast<std::uint32_t>(hn::GetLane(hn::SumOfLanes(di, count)));
  return {inlier_count, {sum(sx), sum(sy), sum(sz), sum(xx), sum(xy), sum(xz), sum(yy), sum(yz), sum(zz)}};
}

void LeafKeys(const float* HWY_RESTRICT x, const float* HWY_RESTRICT y, const float* HWY_RESTRICT z, std::size_t n,
              const Lattice& lattice, std::uint64_t* HWY_RESTRICT keys) {
  const hn::CappedTag<double, kBlock / 2> dd;
  const hn::Rebind<float, decltype(dd)> df;
  const hn::Rebind<std::int32_t, decltype(dd)> d32;
  const hn::Rebind<std::int64_t, decltype(dd)> d64;
  const hn::Rebind<std::uint64_t, decltype(dd)> du64;
  const auto part = [&](const float* HWY_RESTRICT coordinate, int axis) HWY_ATTR {
    const auto value = hn::PromoteTo(dd, hn::Load(df, coordinate));
    const auto index =
        hn::DemoteTo(d32, hn::MulAdd(value, hn::Set(dd, lattice.per_leaf[axis]), hn::Set(dd, lattice.offset[axis])));
    return hn::ShiftLeftSame(hn::BitCast(du64, hn::PromoteTo(d64, index)), lattice.shift[axis]);
  };
  for (std::size_t i = 0; i < n; i += hn::Lanes(dd)) {
    hn::StoreU(hn::Or(part(x + i, 0), hn::Or(part(y + i, 1), part(z + i, 2))), du64, keys + i);
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace fransac::kernels
HWY_AFTER_NAMESPACE();

#endif  // include guard
