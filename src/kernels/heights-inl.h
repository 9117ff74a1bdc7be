// SPDX-License-Identifier: Apache-2.0
// Bodies for vectors of four or eight floats, compiled once per instruction set by heights.cc. See heights.h for what each
// computes. The usual include guard of Highway: this file is read once per target.
#if defined(FRANSAC_KERNELS_HEIGHTS_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef FRANSAC_KERNELS_HEIGHTS_INL_H_
#undef FRANSAC_KERNELS_HEIGHTS_INL_H_
#else
#define FRANSAC_KERNELS_HEIGHTS_INL_H_
#endif

#include <cstring>

#include "hwy/highway.h"
#include "kernels/bits.h"
#include "kernels/heights.h"
#include "kernels/lanes-inl.h"

HWY_BEFORE_NAMESPACE();
namespace fransac::kernels {
namespace HWY_NAMESPACE {
#if HWY_TARGET == HWY_SCALAR

const HeightKernels<std::uint16_t>* Heights16() { return &ref::height_kernels<std::uint16_t>(); }
const HeightKernels<float>* Heights32() { return &ref::height_kernels<float>(); }

#else
namespace heights {
namespace hn = hwy::HWY_NAMESPACE;

using namespace lanes;
static_assert(kHeightGroup == 8);

/// Adds the marked depths of a group, two quads.
HWY_INLINE void Add(const float* HWY_RESTRICT z, std::uint64_t bits, std::uint16_t* HWY_RESTRICT counts,
                    float* HWY_RESTRICT sums) {
  const FloatTag d;
  HWY_ALIGN float marked[kHeightGroup];
  for (std::size_t k = 0; k < kHeightGroup; k += kLanes) {
    hn::Store(hn::IfThenElseZero(FromBits(bits >> k), hn::Load(d, z + k)), d, marked + k);
  }
  for (std::size_t quad = 0; quad < 2; ++quad) {
    const float* const four = marked + quad * kQuad;
    counts[quad] = static_cast<std::uint16_t>(counts[quad] + hwy::PopCount(bits >> (quad * kQuad) & 0xF));
    sums[quad] += four[0] + four[1] + four[2] + four[3];
  }
}

template <class Raw>
void FindSides(const Raw* HWY_RESTRICT raw, const std::uint8_t* HWY_RESTRICT kinds, std::size_t n, float metres_per_unit,
               const HeightRow& row, const HeightLimits& limits, std::uint8_t* HWY_RESTRICT sides, const QuadSums& sums) {
  const FloatTag d;
  constexpr std::uint64_t kEveryByte = 0x0101010101010101U;
  const Float metres = hn::Set(d, metres_per_unit);
  const Float base = hn::Set(d, row.base), step = hn::Set(d, row.step), offset = hn::Set(d, row.d);
  const Float constant = hn::Set(d, limits.constant), linear = hn::Set(d, limits.linear),
              quadratic = hn::Set(d, limits.quadratic);
  const Float least_height = hn::Set(d, limits.least_height), least_drop = hn::Set(d, -limits.least_drop);
  for (std::size_t u = 0; u < n; u += kHeightGroup) {
    std::uint64_t kind = 0;
    std::memcpy(&kind, kinds + u, sizeof kind);
    std::uint64_t out = 0;
    if ((kind & (kEveryByte * kOffPlane)) != 0) {
      HWY_ALIGN float z[kHeightGroup];
      std::uint64_t above = 0;
      std::uint64_t below = 0;
      for (std::size_t k = 0; k < kHeightGroup; k += kLanes) {
        const Float depth = hn::Mul(Load(raw + u + k), metres);
        const Float slope = hn::MulAdd(step, hn::Iota(d, static_cast<float>(u + k)), base);
        const Float height = hn::MulAdd(depth, slope, offset);
        const Float zz = hn::Mul(depth, depth);
        const Float noise = hn::MulAdd(zz, hn::MulAdd(zz, quadratic, linear), constant);
        const Float sigma = hn::Mul(noise, hn::Mul(slope, slope));
        const Mask real = hn::And(hn::Gt(depth, hn::Zero(d)), hn::Gt(hn::Mul(height, height), sigma));
        above |= Bits(hn::And(real, hn::Gt(height, least_height))) << k;
        below |= Bits(hn::And(real, hn::Lt(height, least_drop))) << k;
        hn::Store(depth, d, z + k);
      }
      // One bit per pixel that is off the plane, from the bytes' second bits.
      const std::uint64_t off = ((kind >> 1 & kEveryByte) * 0x0102040810204080U) >> 56;
      above &= off;
      below &= off & ~above;
      out = (kBytesOfBits[above] & (kEveryByte * kAbove)) | (kBytesOfBits[below] & (kEveryByte * kBelow));
      if (above != 0) Add(z, above, sums.above + u / kQuad, sums.above_z + u / kQuad);
      if (below != 0) Add(z, below, sums.below + u / kQuad, sums.below_z + u / kQuad);
    }
    std::memcpy(sides + u, &out, sizeof out);
  }
}

template <class Raw>
constexpr HeightKernels<Raw> kTable{FindSides<Raw>};

}  // namespace heights

const HeightKernels<std::uint16_t>* Heights16() { return &heights::kTable<std::uint16_t>; }
const HeightKernels<float>* Heights32() { return &heights::kTable<float>; }

#endif
}  // namespace HWY_NAMESPACE
}  // namespace fransac::kernels
HWY_AFTER_NAMESPACE();

#endif  // FRANSAC_KERNELS_HEIGHTS_INL_H_
