// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
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

void leaf_keys(const float* x, const float* y, const float* z, std::size_t n, const Lattice& lattice, std::uint64_t* keys) {
  const auto part = [&lattice](float coordinate, int axis) {
    const double index = static_cast<double>(coordinate) * lattice.per_leaf[axis] + lattice.offset[axis];
    if (!(index >= 0.0 && index < 0x1p31)) return std::uint64_t{0};
    return static_cast<std::uint64_t>(index) << lattice.shift[axis];
  };
  for (std::size_t i = 0; i < n; ++i) keys[i] = part(x[i], 0) | part(y[i], 1) | part(z[i], 2);
}

}  // namespace fransac::kernels::ref
