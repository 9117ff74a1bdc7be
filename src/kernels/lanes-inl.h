// SPDX-License-Identifier: Apache-2.0
// Vectors of at most eight floats, as kernels on groups of eight pixels or cells use them, and sets of their lanes as bits.
// The usual include guard of Highway: this file is read once per target.
#if defined(FRANSAC_KERNELS_LANES_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef FRANSAC_KERNELS_LANES_INL_H_
#undef FRANSAC_KERNELS_LANES_INL_H_
#else
#define FRANSAC_KERNELS_LANES_INL_H_
#endif

#include <cstddef>
#include <cstdint>

#include "hwy/highway.h"

HWY_BEFORE_NAMESPACE();
namespace fransac::kernels {
namespace HWY_NAMESPACE {
#if HWY_TARGET != HWY_SCALAR
namespace lanes {
namespace hn = hwy::HWY_NAMESPACE;

using FloatTag = hn::CappedTag<float, 8>;
using IntTag = hn::RebindToSigned<FloatTag>;
using Float = hn::Vec<FloatTag>;
using Mask = hn::Mask<FloatTag>;
constexpr std::size_t kLanes = hn::MaxLanes(FloatTag());
static_assert(kLanes == 4 || kLanes == 8);

/// Raw depth as floats.
HWY_INLINE Float Load(const std::uint16_t* HWY_RESTRICT raw) {
  return hn::ConvertTo(FloatTag(), hn::PromoteTo(IntTag(), hn::LoadU(hn::Rebind<std::uint16_t, FloatTag>(), raw)));
}
HWY_INLINE Float Load(const float* HWY_RESTRICT raw) { return hn::LoadU(FloatTag(), raw); }

HWY_INLINE std::uint64_t Bits(Mask mask) {
  std::uint8_t bits[8];
  hn::StoreMaskBits(FloatTag(), mask, bits);
  return bits[0];
}
HWY_INLINE Mask FromBits(std::uint64_t bits) {
  const std::uint8_t bytes[8] = {static_cast<std::uint8_t>(bits & ((1U << kLanes) - 1U))};
  return hn::LoadMaskBits(FloatTag(), bytes);
}

}  // namespace lanes
#endif
}  // namespace HWY_NAMESPACE
}  // namespace fransac::kernels
HWY_AFTER_NAMESPACE();

#endif
