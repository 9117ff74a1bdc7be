// SPDX-License-Identifier: Apache-2.0
#include "kernels/rows.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "kernels/rows.cc"
#include "hwy/foreach_target.h"  // compiles what follows once per instruction set
// clang-format off
#include "kernels/rows-inl.h"
// clang-format on

#if HWY_ONCE
namespace fransac::kernels {

HWY_EXPORT(OfferPlane);

void offer_plane(const float* z, std::size_t n, const RowPlane& plane, float* nearest, float* label) {
  HWY_DYNAMIC_DISPATCH(OfferPlane)(z, n, plane, nearest, label);
}

}  // namespace fransac::kernels
#endif  // HWY_ONCE
