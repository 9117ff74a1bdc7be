// SPDX-License-Identifier: Apache-2.0
// Vector code over points. Raw pointers only. Where x, y and z are arrays of their own, `n` counts whole blocks: a multiple of
// kBlock values whose tail is NaN; a NaN takes part in nothing; arrays are aligned to 64 bytes. leaf_runs and box take points
// side by side, any number at any address; of all but the last the float after z may be read, too, and is ignored. Every function
// has a scalar twin in namespace `ref` that says what it computes; the two agree to rounding.
#pragma once

#include <cstddef>
#include <cstdint>

namespace fransac::kernels {

inline constexpr std::size_t kBlock = 16;

struct Bounds {
  float min;
  float max;
};
/// Smallest and largest value; (+inf, -inf) when there is none.
Bounds bounds(const float* values, std::size_t n);

/// a x + b y + c z + d; |(a, b, c)| = 1.
struct PlaneF {
  float a, b, c, d;
};

/// How many points lie within the threshold.
std::uint32_t count_inliers(const float* x, const float* y, const float* z, std::size_t n, const PlaneF& plane, float threshold);

struct Msac {
  float gain;  ///< Sum over the inliers of 1 - (r / threshold)^2.
  std::uint32_t inliers;
};
/// Accumulated in float: call with at most some thousands of points at a time.
Msac msac(const float* x, const float* y, const float* z, std::size_t n, const PlaneF& plane, float threshold);

/// Sums over the inliers, in double: x, y, z, xx, xy, xz, yy, yz, zz.
struct InlierMoments {
  std::uint64_t count;
  double sums[9];
};
InlierMoments inlier_moments(const float* x, const float* y, const float* z, std::size_t n, const PlaneF& plane, float threshold);

/// Where a point lies in a grid: along each axis the index is trunc(coordinate * per_leaf + offset), which must lie in
/// [0, 2^31). Coordinates are added up as whole numbers: bits(coordinate + rounder) - bits(rounder) of doubles, which is the
/// coordinate in units of the rounder's last bit.
struct Lattice {
  double per_leaf[4];  ///< The fourth of each is zero: it fills a vector.
  double offset[4];
  double rounder[4];
};

/// Neighbours with the same index.
struct alignas(64) LeafRun {
  std::uint64_t sum[4];    ///< Of x, y and z of all points up to the run's last, and how many these are.
  std::uint32_t index[4];  ///< Along x, y and z; 0.
};
/// Runs of n finite points, whose x, y and z are side by side, `stride` floats from one point to the next. There must be room
/// for n runs; returns their number.
std::size_t leaf_runs(const float* points, std::size_t stride, std::size_t n, const Lattice& lattice, LeafRun* runs);

/// Smallest and largest x, y and z of those points of such an array that are finite; (+inf, -inf) where there is none.
struct Box {
  float min[3];
  float max[3];
  bool finite;  ///< Whether all points are.
};
Box box(const float* points, std::size_t stride, std::size_t n);

namespace ref {
std::size_t leaf_runs(const float* points, std::size_t stride, std::size_t n, const Lattice& lattice, LeafRun* runs);
Box box(const float* points, std::size_t stride, std::size_t n);
Bounds bounds(const float* values, std::size_t n);
std::uint32_t count_inliers(const float* x, const float* y, const float* z, std::size_t n, const PlaneF& plane, float threshold);
Msac msac(const float* x, const float* y, const float* z, std::size_t n, const PlaneF& plane, float threshold);
InlierMoments inlier_moments(const float* x, const float* y, const float* z, std::size_t n, const PlaneF& plane, float threshold);
}  // namespace ref

}  // namespace fransac::kernels
