// SPDX-License-Identifier: Apache-2.0
// Arithmetic that gives the same on every target, in the files that are compiled without contraction: products and sums are
// rounded one by one, and added up in one order (block_sums.h). The usual include guard of Highway: this file is read once per
// target.
#if defined(FRANSAC_KERNELS_BLOCK_SUMS_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef FRANSAC_KERNELS_BLOCK_SUMS_INL_H_
#undef FRANSAC_KERNELS_BLOCK_SUMS_INL_H_
#else
#define FRANSAC_KERNELS_BLOCK_SUMS_INL_H_
#endif

#include "hwy/highway.h"
#include "kernels/block_sums.h"

HWY_BEFORE_NAMESPACE();
namespace fransac::kernels {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

/// a b + c with two roundings.
template <class V>
HWY_INLINE V MulThenAdd(V a, V b, V c) {
  return hn::Add(hn::Mul(a, b), c);
}

/// Sums by place in a stretch of `places` values: `kParts` vectors.
template <class Tag, std::size_t places>
class PlaceSums {
 public:
  static constexpr std::size_t kParts = places / hn::MaxLanes(Tag());
  using Vec = hn::Vec<Tag>;

  HWY_INLINE PlaceSums() {
    for (Vec& part : parts_) part = hn::Zero(Tag());
  }
  /// Adds the values of the part-th vector of a stretch.
  HWY_INLINE void Add(std::size_t part, Vec values) { parts_[part] = hn::Add(parts_[part], values); }
  /// Adds products that are exact, so that fusing them changes nothing.
  HWY_INLINE void AddExactProduct(std::size_t part, Vec a, Vec b) { parts_[part] = hn::MulAdd(a, b, parts_[part]); }
  [[nodiscard]] HWY_INLINE hn::TFromD<Tag> Total() const {
    alignas(64) hn::TFromD<Tag> sums[places];
    for (std::size_t part = 0; part < kParts; ++part) hn::Store(parts_[part], Tag(), sums + part * hn::MaxLanes(Tag()));
    return total_of_places<places>(sums);
  }

 private:
  Vec parts_[kParts];
};

}  // namespace HWY_NAMESPACE
}  // namespace fransac::kernels
HWY_AFTER_NAMESPACE();

#endif  // include guard
