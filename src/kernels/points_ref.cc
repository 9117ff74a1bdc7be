// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

#include "kernels/points.h"

namespace fransac::kernels::ref {
namespace {

float residual(const PlaneF& p, float x, float y, float z) { return p.a * x + (p.b * y + (p.c * z + p.d)); }

std::uint32_t leaf_index(float coordinate, const Lattice& lattice, int axis) {
  const double place = static_cast<double>(coordinate) * lattice.per_leaf[axis] + lattice.offset[axis];
  return place > 0.0 && place < 0x1p31 ? static_cast<std::uint32_t>(place) : 0;
}

bool is_measured(float x, float y, float z, const float* unmeasured) {
  if (!(std::isfinite(x) && std::isfinite(y) && std::isfinite(z))) return false;
  return !(x == unmeasured[0] && y == unmeasured[1] && z == unmeasured[2]);
}

std::uint64_t leaf_sum(float coordinate, const Lattice& lattice, int axis) {
  const double rounder = lattice.rounder[axis];
  return std::bit_cast<std::uint64_t>(static_cast<double>(coordinate) + rounder) - std::bit_cast<std::uint64_t>(rounder);
}

}  // namespace

Bounds bounds(const float* values, std::size_t n) {
  Bounds b{std::numeric_limits<float>::infinity(), -std::numeric_limits<float>::infinity()};
  for (std::size_t i = 0; i < n; ++i) {
    if (values[i] < b.min) b.min = values[i];
    if (values[i] > b.max) b.max = values[i];
  }
  return b;
}

std::size_t count_measured(const float* x, const float* y, const float* z, std::size_t n, const float* unmeasured) {
  std::size_t count = 0;
  for (std::size_t i = 0; i < n; ++i) count += static_cast<std::size_t>(is_measured(x[i], y[i], z[i], unmeasured));
  return count;
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

void label_points(const float* x, const float* y, const float* z, std::size_t n, const NearestPlane& rule, std::uint8_t* labels) {
  for (std::size_t i = 0; i < n; ++i) {
    labels[i] = rule.no_depth;
    if (!is_measured(x[i], y[i], z[i], rule.unmeasured)) continue;
    labels[i] = rule.no_plane;
    double nearest = std::numeric_limits<double>::infinity();
    for (std::size_t k = 0; k < rule.count; ++k) {
      const PlaneD& p = rule.planes[k];
      const double by_x = p.a * static_cast<double>(x[i]);
      const double by_y = p.b * static_cast<double>(y[i]);
      const double by_z = p.c * static_cast<double>(z[i]);
      const double distance = std::abs((by_x + by_y) + (by_z + p.d));
      if (!(distance <= rule.threshold && distance < nearest)) continue;
      nearest = distance;
      labels[i] = static_cast<std::uint8_t>(rule.first + k);
    }
  }
}

std::size_t leaf_runs(const float* points, std::size_t stride, std::size_t n, const Lattice& lattice, LeafRun* runs) {
  std::uint64_t sum[3] = {0, 0, 0};
  std::size_t count = 0;
  for (std::size_t i = 0; i < n; ++i) {
    const float* const point = points + i * stride;
    std::uint32_t index[3];
    for (int axis = 0; axis < 3; ++axis) {
      index[axis] = leaf_index(point[axis], lattice, axis);
      sum[axis] += leaf_sum(point[axis], lattice, axis);
    }
    if (i == 0 || !std::equal(index, index + 3, runs[count - 1].index)) {
      runs[count++] = {{}, {index[0], index[1], index[2], 0}};
    }
    std::copy(sum, sum + 3, runs[count - 1].sum);
    runs[count - 1].sum[3] = i + 1;
  }
  return count;
}

void leaf_terms(const float* points, std::size_t stride, std::size_t n, const Lattice& lattice, LeafTerm* terms,
                std::uint64_t* keys) {
  for (std::size_t i = 0; i < n; ++i) {
    const float* const point = points + i * stride;
    std::uint32_t index[3];
    for (int axis = 0; axis < 3; ++axis) {
      index[axis] = leaf_index(point[axis], lattice, axis);
      terms[i].sum[axis] = leaf_sum(point[axis], lattice, axis);
    }
    terms[i].sum[3] = 1;
    keys[i] = key_of(index, lattice);
  }
}

void leaf_buckets(const float* points, std::size_t stride, std::size_t n, const Lattice& lattice, std::uint8_t* buckets) {
  for (std::size_t i = 0; i < n; ++i) {
    const float* const point = points + i * stride;
    std::uint32_t index[3];
    for (int axis = 0; axis < 3; ++axis) index[axis] = leaf_index(point[axis], lattice, axis);
    buckets[i] = bucket_of(index);
  }
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
