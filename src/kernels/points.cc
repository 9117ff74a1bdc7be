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
HWY_EXPORT(CountMeasured);
HWY_EXPORT(CountInliers);
HWY_EXPORT(MsacOf);
HWY_EXPORT(InlierMomentsOf);
HWY_EXPORT(LeafRuns);
HWY_EXPORT(LabelPoints);
HWY_EXPORT(LeafTerms);
HWY_EXPORT(LeafBuckets);
HWY_EXPORT(BoxOf);

Bounds bounds(const float* values, std::size_t n) { return HWY_DYNAMIC_DISPATCH(BoundsOf)(values, n); }

std::size_t count_measured(const float* x, const float* y, const float* z, std::size_t n, const float* unmeasured) {
  return HWY_DYNAMIC_DISPATCH(CountMeasured)(x, y, z, n, unmeasured);
}

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

std::size_t leaf_runs(const float* points, std::size_t stride, std::size_t n, const Lattice& lattice, LeafRun* runs) {
  return HWY_DYNAMIC_DISPATCH(LeafRuns)(points, stride, n, lattice, runs);
}

void label_points(const float* x, const float* y, const float* z, std::size_t n, const NearestPlane& rule, std::uint8_t* labels) {
  HWY_DYNAMIC_DISPATCH(LabelPoints)(x, y, z, n, rule, labels);
}

void leaf_terms(const float* points, std::size_t stride, std::size_t n, const Lattice& lattice, LeafTerm* terms,
                std::uint64_t* keys) {
  HWY_DYNAMIC_DISPATCH(LeafTerms)(points, stride, n, lattice, terms, keys);
}

void leaf_buckets(const float* points, std::size_t stride, std::size_t n, const Lattice& lattice, std::uint8_t* buckets) {
  HWY_DYNAMIC_DISPATCH(LeafBuckets)(points, stride, n, lattice, buckets);
}

Box box(const float* points, std::size_t stride, std::size_t n) { return HWY_DYNAMIC_DISPATCH(BoxOf)(points, stride, n); }

}  // namespace fransac::kernels
#endif  // HWY_ONCE
