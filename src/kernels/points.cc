// SPDX-License-Identifier: Apache-2.0
#include "kernels/points.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "kernels/points.cc"
#include "hwy/foreach_target.h"  // compiles what follows once per instruction set
// clang-format off
#include "kernels/points-inl.h"
// clang-format on

#if HWY_ONCE
namespace fransac::kernels {

HWY_EXPORT(BoundsOf);
HWY_EXPORT(CountInliers);
HWY_EXPORT(MsacOf);
HWY_EXPORT(InlierMomentsOf);
HWY_EXPORT(LeafKeys);

Bounds bounds(const float* values, std::size_t n) { return HWY_DYNAMIC_DISPATCH(BoundsOf)(values, n); }

std::uint32_t count_inliers(const float* x, const float* y, const float* z, std::size_t n, const PlaneF& plane, float threshold) {
  return HWY_DYNAMIC_DISPATCH(CountInliers)(x, y, z, n, plane, threshold);
}

Msac msac(const float* x, const float* y, const float* z, std::size_t n, const PlaneF& plane, float threshold) {
  return HWY_DYNAMIC_DISPATCH(MsacOf)(x, y, z, n, plane, threshold);
}

InlierMoments inlier_moments(const float* x, const float* y, const float* z, std::size_t n, const PlaneF& plane,
                             float threshold) {
  return HWY_DYNAMIC_DISPATCH(InlierMomentsOf)(x, y, z, n, plane, threshold);
}

void leaf_keys(const float* x, const float* y, const float* z, std::size_t n, const Lattice& lattice, std::uint64_t* keys) {
  HWY_DYNAMIC_DISPATCH(LeafKeys)(x, y, z, n, lattice, keys);
}

}  // namespace fransac::kernels
#endif  // HWY_ONCE
