// SPDX-License-Identifier: Apache-2.0
// Vector code over one row of a depth image and of its labels: which pixels are above a plane and which below. Raw pointers only.
#pragma once

#include <cstddef>
#include <cstdint>

#include "kernels/rows.h"

namespace fransac::kernels {

/// Pixels are looked at in groups of so many, and added up in quads of four; kBlock is whole groups.
inline constexpr std::size_t kHeightGroup = 8;
static_assert(kBlock % kHeightGroup == 0);
inline constexpr std::size_t kQuad = 4;

/// The signed distance to a plane of the pixel in column u with depth z: z (base + step u) + d, metres.
struct HeightRow {
  float base;
  float step;
  float d;
};

/// A pixel is above when its height is more than `least_height`, below when less than -least_drop, and either only when the
/// square of it is more than (constant + linear z^2 + quadratic z^4) (base + step u)^2.
struct HeightLimits {
  float constant;
  float linear;
  float quadratic;
  float least_height;
  float least_drop;
};

inline constexpr std::uint8_t kOnPlane = 1;   ///< Of a pixel, in `kinds`: never above or below.
inline constexpr std::uint8_t kOffPlane = 2;  ///< It may be. Anything else is 0.
inline constexpr std::uint8_t kAbove = 1;     ///< Of a pixel, in `sides`.
inline constexpr std::uint8_t kBelow = 2;

/// Sums over the pixels of each quad are added to these.
struct QuadSums {
  std::uint16_t* above;  ///< How many, and
  float* above_z;        ///< their depths, metres.
  std::uint16_t* below;
  float* below_z;
};

template <class Raw>
struct HeightKernels {
  /// `n` pixels, whole groups.
  void (*find_sides)(const Raw* raw, const std::uint8_t* kinds, std::size_t n, float metres_per_unit, const HeightRow& row,
                     const HeightLimits& limits, std::uint8_t* sides, const QuadSums& sums);
};

template <class Raw>
const HeightKernels<Raw>& height_kernels();
template <>
const HeightKernels<std::uint16_t>& height_kernels();
template <>
const HeightKernels<float>& height_kernels();

namespace ref {
/// The scalar truth; the same to rounding.
template <class Raw>
const HeightKernels<Raw>& height_kernels();
template <>
const HeightKernels<std::uint16_t>& height_kernels();
template <>
const HeightKernels<float>& height_kernels();
}  // namespace ref

}  // namespace fransac::kernels
