// SPDX-License-Identifier: Apache-2.0
// Width-agnostic bodies, compiled once per instruction set by rows.cc. See rows.h for what each computes.
// The usual include guard of Highway: this file is read once per target.
#if defined(FRANSAC_KERNELS_ROWS_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef FRANSAC_KERNELS_ROWS_INL_H_
#undef FRANSAC_KERNELS_ROWS_INL_H_
#else
#define FRANSAC_KERNELS_ROWS_INL_H_
#endif

#include "hwy/highway.h"
#include "kernels/rows.h"

HWY_BEFORE_NAMESPACE();
namespace fransac::kernels {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

void OfferPlane(const float* HWY_RESTRICT z, std::size_t n, const RowPlane& plane, float* HWY_RESTRICT nearest,
                float* HWY_RESTRICT label) {
  const hn::CappedTag<float, kBlock> d;  // at most one block per vector, so that n is a whole number of vectors
  const auto base = hn::Set(d, plane.base);
  const auto step = hn::Set(d, plane.step);
  const auto offset = hn::Set(d, plane.d);
  const auto own = hn::Set(d, plane.label);
  const auto lanes = hn::Set(d, static_cast<float>(hn::Lanes(d)));
  auto column = hn::Iota(d, 0.0F);
  for (std::size_t u = 0; u < n; u += hn::Lanes(d)) {
    const auto product = hn::MulAdd(step, column, base);
    const auto distance = hn::Abs(hn::MulAdd(hn::Load(d, z + u), product, offset));
    const auto old = hn::Load(d, nearest + u);
    const auto nearer = hn::Lt(distance, old);
    hn::Store(hn::IfThenElse(nearer, distance, old), d, nearest + u);
    hn::Store(hn::IfThenElse(nearer, own, hn::Load(d, label + u)), d, label + u);
    column = hn::Add(column, lanes);
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace fransac::kernels
HWY_AFTER_NAMESPACE();

#endif  // include guard
