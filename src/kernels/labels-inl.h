// SPDX-License-Identifier: Apache-2.0
// Width-agnostic body, compiled once per instruction set by labels.cc.
// The usual include guard of Highway: this file is read once per target.
#if defined(FRANSAC_KERNELS_LABELS_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef FRANSAC_KERNELS_LABELS_INL_H_
#undef FRANSAC_KERNELS_LABELS_INL_H_
#else
#define FRANSAC_KERNELS_LABELS_INL_H_
#endif

#include "hwy/highway.h"
#include "kernels/labels.h"

HWY_BEFORE_NAMESPACE();
namespace fransac::kernels {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

/// Looks labels up in pieces of 16 entries, of which a byte shuffle knows all.
void Relabel(std::uint8_t* HWY_RESTRICT labels, std::size_t n, const std::uint8_t* HWY_RESTRICT table, int largest) {
#if HWY_TARGET == HWY_SCALAR
  ref::relabel(labels, n, table, largest);
#else
  const hn::ScalableTag<std::uint8_t> d;
  const std::size_t step = hn::Lanes(d);
  const auto sixteen = hn::Set(d, 16);
  const auto last = hn::Set(d, 255);
  const auto of_last = hn::Set(d, table[255]);
  std::size_t i = 0;
  for (; i + step <= n; i += step) {
    auto index = hn::LoadU(d, labels + i);
    auto out = hn::IfThenElseZero(hn::Eq(index, last), of_last);
    for (int piece = 0; piece <= largest; piece += 16) {
      const auto inside = hn::Lt(index, sixteen);
      const auto entries = hn::LoadDup128(d, table + piece);
      const auto found = hn::TableLookupBytes(entries, hn::And(index, hn::Set(d, 15)));
      out = hn::IfThenElse(inside, found, out);
      index = hn::Sub(index, sixteen);
    }
    hn::StoreU(out, d, labels + i);
  }
  ref::relabel(labels + i, n - i, table, largest);
#endif
}

}  // namespace HWY_NAMESPACE
}  // namespace fransac::kernels
HWY_AFTER_NAMESPACE();

#endif  // FRANSAC_KERNELS_LABELS_INL_H_
