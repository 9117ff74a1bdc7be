// SPDX-License-Identifier: Apache-2.0
// Vector code over one row of a depth image, straight from raw depth. Raw pointers only.
//
// A row is `n` raw values: 16-bit units or float metres, 0 where nothing was measured (a float row holds no NaN, infinity or
// negative value). `n` counts whole blocks, a multiple of kBlock; what a row lacks is filled with zeros. Nothing need be aligned.
#pragma once

#include <cstddef>
#include <cstdint>

#include "kernels/points.h"

namespace fransac::kernels {

/// A function of the column: base + step * u.
struct Ramp {
  float base;
  float step;
};

/// A plane as a row sees it: the signed distance of a pixel is raw * (base + step * u) + d, in the unit of d, for n . r is
/// affine in u and z is proportional to the raw value.
struct RowPlane {
  Ramp ramp;
  float d;
};

/// Running sums of a row of 16-bit depth: sums[u] holds, over all columns before u, the sum of raw in its low half and that of
/// raw * (column % kSumColumns) in its high half, both mod 2^32. Differences within kSumColumns aligned columns are exact.
/// Writes n + 1 sums.
void running_sums(const std::uint16_t* raw, std::size_t n, std::uint64_t* sums);
inline constexpr std::uint32_t kSumColumns = 256;

/// How a row falls into leaves. With q = raw * per_unit, the depth in leaves, a pixel lies in the leaf
/// x = floor(q * ray_x[u]) + first[0], y = floor(q * ray_y) + first[1], z = floor(q) + first[2], each in [0, 2^22), and its key
/// is x + (y << shift_y) + (z << shift_z). Without a measurement it is kNoLeaf. Products are rounded, never fused: a pixel on a
/// leaf's border falls on the same side on every machine.
struct LeafRow {
  float per_unit;
  const float* ray_x;  ///< n values.
  float ray_y;
  std::int32_t first[3];
  int shift_y;
  int shift_z;
};
inline constexpr std::uint32_t kNoLeaf = 0;

/// Sums over inliers, with a = ray.base + ray.step * u.
struct RowMoments {
  std::uint32_t count;
  float z, zz, za, zza, zzaa;  ///< Of z, z^2, z a, z^2 a, z^2 a^2 with z in raw units.
};

struct LabelPlane {
  RowPlane plane;
  std::uint8_t label;
};

/// What the pixels of a plane show.
struct RowEvidence {
  std::uint32_t count;
  float squared_distance;
  float cubed_depth;  ///< In raw units. On the plane z |n . r| = |d|, so a pixel's footprint is z^2 / |n . r| = z^3 / |d|.
};

/// The functions for one type of raw value.
template <class Raw>
struct RowKernels {
  /// Copies the values in [min, max]; the others become 0.
  void (*keep_range)(const Raw* raw, std::size_t n, Raw min, Raw max, Raw* kept);
  /// How many values are not 0.
  std::size_t (*count_measured)(const Raw* raw, std::size_t n);
  Raw (*largest)(const Raw* raw, std::size_t n);
  /// Writes n keys, and the columns at which a run of equal keys starts, or a stretch of kSumColumns columns, followed by n.
  /// Returns the number of runs. keys[-1] must be readable; `starts` needs room for n + kBlock columns.
  std::size_t (*leaf_runs)(const Raw* raw, std::size_t n, const LeafRow& row, std::uint32_t* keys, std::uint32_t* starts);
  /// Support of a plane whose unit of distance is the threshold: inliers have |distance| <= 1 and add 1 - distance^2.
  Msac (*score)(const Raw* raw, std::size_t n, const RowPlane& plane);
  /// Copies the pixels that are no inliers of such a plane; the others become 0.
  void (*remove)(const Raw* raw, std::size_t n, const RowPlane& plane, Raw* left);
  /// Moments of the pixels with |distance| <= threshold.
  RowMoments (*moments)(const Raw* raw, std::size_t n, const RowPlane& plane, float threshold, const Ramp& ray);
  /// The label of each pixel: 0 where raw is 0; 255 where only `kept` is 0; else that of the nearest plane within the threshold
  /// (of equally near ones the first), or 255. `kept` may be `raw`.
  void (*label)(const Raw* raw, const Raw* kept, std::size_t n, const LabelPlane* planes, std::size_t num_planes, float threshold,
                std::uint8_t* labels);
  /// The evidence of the pixels that carry the plane's label.
  RowEvidence (*evidence)(const Raw* raw, const std::uint8_t* labels, std::size_t n, const LabelPlane& plane);
  /// `label` and `evidence` at once for a single plane, the common case.
  RowEvidence (*label_one)(const Raw* raw, const Raw* kept, std::size_t n, const LabelPlane& plane, float threshold,
                           std::uint8_t* labels);
};

/// The functions for this machine's best instruction set; Raw is std::uint16_t or float.
template <class Raw>
const RowKernels<Raw>& row_kernels();
template <>
const RowKernels<std::uint16_t>& row_kernels();
template <>
const RowKernels<float>& row_kernels();

namespace ref {
void running_sums(const std::uint16_t* raw, std::size_t n, std::uint64_t* sums);
/// The scalar truth, which every instruction set agrees with exactly: products and sums are rounded one by one, and added up in
/// one order (block_sums.h).
template <class Raw>
const RowKernels<Raw>& row_kernels();
template <>
const RowKernels<std::uint16_t>& row_kernels();
template <>
const RowKernels<float>& row_kernels();
}  // namespace ref

}  // namespace fransac::kernels
