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

/// How many points are measurements: finite, and not where `unmeasured` (x, y, z) says that there is none.
std::size_t count_measured(const float* x, const float* y, const float* z, std::size_t n, const float* unmeasured);

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

/// The same in double.
struct PlaneD {
  double a, b, c, d;
};
/// What points are labelled by.
struct NearestPlane {
  const PlaneD* planes;
  std::size_t count;                       ///< Of planes, at most 254.
  double threshold;                        ///< On a plane are points that are no farther from it.
  float unmeasured[3];                     ///< Where points lie that are none.
  std::uint8_t no_depth, no_plane, first;  ///< Labels: of what is no measurement, of what is on no plane, and of the first plane.
};
/// Of each point the label of the plane that is nearest to it, of equals the first. Sums are rounded alike for every instruction
/// set, so that all give the same labels.
void label_points(const float* x, const float* y, const float* z, std::size_t n, const NearestPlane& rule, std::uint8_t* labels);

/// Where a point lies in a grid: along each axis the index is trunc(coordinate * per_leaf + offset), which must lie in
/// [0, 2^31). Coordinates are added up as whole numbers: bits(coordinate + rounder) - bits(rounder) of doubles, which is the
/// coordinate in units of the rounder's last bit.
struct Lattice {
  double per_leaf[4];  ///< The fourth of each is zero: it fills a vector.
  double offset[4];
  double rounder[4];
  std::uint64_t shift[4] = {};  ///< Keys are the indices, shifted to the left by these: below 2^63.
};

/// Neighbours with the same index.
struct alignas(64) LeafRun {
  std::uint64_t sum[4];    ///< Of x, y and z of all points up to the run's last, and how many these are.
  std::uint32_t index[4];  ///< Along x, y and z; 0.
};
/// Runs of n finite points, whose x, y and z are side by side, `stride` floats from one point to the next. There must be room
/// for n runs; returns their number.
std::size_t leaf_runs(const float* points, std::size_t stride, std::size_t n, const Lattice& lattice, LeafRun* runs);

/// The same of each point on its own: x, y, z and 1 to add up, and the key of its leaf.
struct alignas(32) LeafTerm {
  std::uint64_t sum[4];
};
void leaf_terms(const float* points, std::size_t stride, std::size_t n, const Lattice& lattice, LeafTerm* terms,
                std::uint64_t* keys);

/// Whole cubes of 16 x 16 x 16 leaves fall into one of 256 buckets each, by chance: that of each of the same points.
void leaf_buckets(const float* points, std::size_t stride, std::size_t n, const Lattice& lattice, std::uint8_t* buckets);

/// Smallest and largest x, y and z of those points of such an array that are finite; (+inf, -inf) where there is none.
struct Box {
  float min[3];
  float max[3];
  bool finite;  ///< Whether all points are.
};
Box box(const float* points, std::size_t stride, std::size_t n);

/// The bucket of the cubes that a leaf's index is in: the top bits of a sum of products with odd numbers of no pattern (Knuth,
/// TAOCP 3, 6.4).
inline constexpr int kCubeBits = 4;
inline constexpr std::uint32_t kBucketFactors[3] = {0x9E3779B1U, 0x85EBCA77U, 0xC2B2AE3DU};
inline std::uint64_t key_of(const std::uint32_t* index, const Lattice& lattice) {
  return std::uint64_t{index[0]} << lattice.shift[0] | std::uint64_t{index[1]} << lattice.shift[1] |
         std::uint64_t{index[2]} << lattice.shift[2];
}
inline std::uint8_t bucket_of(const std::uint32_t* index) {
  std::uint32_t sum = 0;
  for (int axis = 0; axis < 3; ++axis) sum += (index[axis] >> kCubeBits) * kBucketFactors[axis];
  return static_cast<std::uint8_t>(sum >> 24);
}

namespace ref {
std::size_t leaf_runs(const float* points, std::size_t stride, std::size_t n, const Lattice& lattice, LeafRun* runs);
void leaf_terms(const float* points, std::size_t stride, std::size_t n, const Lattice& lattice, LeafTerm* terms,
                std::uint64_t* keys);
void leaf_buckets(const float* points, std::size_t stride, std::size_t n, const Lattice& lattice, std::uint8_t* buckets);
void label_points(const float* x, const float* y, const float* z, std::size_t n, const NearestPlane& rule, std::uint8_t* labels);
Box box(const float* points, std::size_t stride, std::size_t n);
std::size_t count_measured(const float* x, const float* y, const float* z, std::size_t n, const float* unmeasured);
Bounds bounds(const float* values, std::size_t n);
std::uint32_t count_inliers(const float* x, const float* y, const float* z, std::size_t n, const PlaneF& plane, float threshold);
Msac msac(const float* x, const float* y, const float* z, std::size_t n, const PlaneF& plane, float threshold);
InlierMoments inlier_moments(const float* x, const float* y, const float* z, std::size_t n, const PlaneF& plane, float threshold);
}  // namespace ref

}  // namespace fransac::kernels
