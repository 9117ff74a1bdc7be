// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

#include "kernels/points.h"

namespace fransac::kernels::ref {
namespace {

float residual(const PlaneF& p, float x, float y, float z) { return p.a * x + (p.b * y + (p.c * z + p.d)); }

}  // namespace

Bounds bounds(const float* values, std::size_t n) {
  Bounds b{std::numeric_limits<float>::infinity(), -std::numeric_limits<float>::infinity()};
  for (std::size_t i = 0; i < n; ++i) {
    if (values[i] < b.min) b.min = values[i];
    if (values[i] > b.max) b.max = values[i];
  }
  return b;
}

std::uint32_t count_inliers(const float* x, const float* y, const float* z, std::size_t n, const PlaneF& plane, float threshold) {
  std::uint32_t count = 0;
  for (std::size_t i = 0; i < n; ++i)
    count += static_cast<std::uint32_t>(std::abs(residual(plane, x[i], y[i], z[i])) <= threshold);
  return count;
}

Msac msac(const float* x, const float* y, const float* z, std::size_t n, const PlaneF& plane, float threshold) {
  Msac result{0.0F, 0};
  const float per_threshold = 1.0F / threshold;
  for (std::size_t i = 0; i < n; ++i) {
    const float r = residual(plane, x[i], y[i], z[i]);
    if (!(std::abs(r) <= threshold)) continue;
    const float share = r * per_threshold;
    result.gain += 1.0F - share * share;
    ++result.inliers;
  }
  return result;
}

InlierMoments inlier_moments(const float* x, const float* y, const float* z, std::size_t n, const PlaneF& plane,
                             float threshold) {
  InlierMoments m{};
  for (std::size_t i = 0; i < n; ++i) {
    if (!(std::abs(residual(plane, x[i], y[i], z[i])) <= threshold)) continue;
    const double px = static_cast<double>(x[i]);
    const double py = static_cast<double>(y[i]);
    const double pz = static_cast<double>(z[i]);
    const double terms[9] = {px, py, pz, px * px, px * py, px * pz, py * py, py * pz, pz * pz};
    for (int k = 0; k < 9; ++k) m.sums[k] += terms[k];
    ++m.count;
  }
  return m;
}

std::size_t leaf_runs(const float* points, std::size_t stride, std::size_t n, const Lattice& lattice, LeafRun* runs) {
  std::uint64_t sum[3] = {0, 0, 0};
  std::size_t count = 0;
  for (std::size_t i = 0; i < n; ++i) {
    const float* const point = points + i * stride;
    std::uint32_t index[3];
    for (int axis = 0; axis < 3; ++axis) {
      const double coordinate = static_cast<double>(point[axis]);
      const double place = coordinate * lattice.per_leaf[axis] + lattice.offset[axis];
      index[axis] = place > 0.0 && place < 0x1p31 ? static_cast<std::uint32_t>(place) : 0;
      sum[axis] +=
          std::bit_cast<std::uint64_t>(coordinate + lattice.rounder[axis]) - std::bit_cast<std::uint64_t>(lattice.rounder[axis]);
    }
    if (i == 0 || !std::equal(index, index + 3, runs[count - 1].index)) {
      runs[count++] = {{}, {index[0], index[1], index[2], 0}};
    }
    std::copy(sum, sum + 3, runs[count - 1].sum);
    runs[count - 1].sum[3] = i + 1;
  }
  return count;
}

Box box(const float* points, std::size_t stride, std::size_t n) {
  constexpr float kInfinity = std::numeric_limits<float>::infinity();
  Box b{{kInfinity, kInfinity, kInfinity}, {-kInfinity, -kInfinity, -kInfinity}, true};
  for (std::size_t i = 0; i < n; ++i) {
    const float* const point = points + i * stride;
    if (!(std::isfinite(point[0]) && std::isfinite(point[1]) && std::isfinite(point[2]))) {
      b.finite = false;
      continue;
    }
    for (int axis = 0; axis < 3; ++axis) {
      b.min[axis] = std::min(b.min[axis], point[axis]);
      b.max[axis] = std::max(b.max[axis], point[axis]);
    }
  }
  return b;
}

}  // namespace fransac::kernels::ref
