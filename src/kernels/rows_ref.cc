// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>

#include "kernels/block_sums.h"
#include "kernels/rows.h"

namespace fransac::kernels::ref {
namespace {

template <class Raw>
void keep_range(const Raw* raw, std::size_t n, Raw min, Raw max, Raw* kept) {
  for (std::size_t u = 0; u < n; ++u) kept[u] = raw[u] >= min && raw[u] <= max ? raw[u] : Raw{0};
}

template <class Raw>
std::size_t count_measured(const Raw* raw, std::size_t n) {
  return n - static_cast<std::size_t>(std::count(raw, raw + n, Raw{0}));
}

template <class Raw>
Raw largest(const Raw* raw, std::size_t n) {
  return n == 0 ? Raw{0} : *std::max_element(raw, raw + n);
}

template <class Raw>
std::size_t leaf_runs(const Raw* raw, std::size_t n, const LeafRow& row, std::uint32_t* keys, std::uint32_t* starts) {
  const auto index = [&](float leaves, int axis) {
    return static_cast<std::uint32_t>(static_cast<std::int32_t>(std::floor(leaves)) + row.first[axis]);
  };
  std::size_t runs = 0;
  for (std::size_t u = 0; u < n; ++u) {
    const float q = static_cast<float>(raw[u]) * row.per_unit;
    const float right = q * row.ray_x[u];
    const float down = q * row.ray_y;
    const std::uint32_t x = index(right, 0);
    const std::uint32_t y = index(down, 1);
    const std::uint32_t z = index(q, 2);
    keys[u] = raw[u] == Raw{0} ? kNoLeaf : x + (y << row.shift_y) + (z << row.shift_z);
    if (u % kSumColumns == 0 || keys[u] != keys[u - 1]) starts[runs++] = static_cast<std::uint32_t>(u);
  }
  starts[runs] = static_cast<std::uint32_t>(n);
  return runs;
}

using Sum = BlockSum<float, kBlock>;

float value_at(const Ramp& ramp, std::size_t u) { return ramp.base + ramp.step * static_cast<float>(u); }

template <class Raw>
float distance(const Raw* raw, std::size_t u, const RowPlane& plane) {
  return static_cast<float>(raw[u]) * value_at(plane.ramp, u) + plane.d;
}

template <class Raw>
Msac score(const Raw* raw, std::size_t n, const RowPlane& plane) {
  Sum gain;
  std::uint32_t inliers = 0;
  for (std::size_t u = 0; u < n; ++u) {
    const float r = distance(raw, u, plane);
    if (raw[u] == Raw{0} || std::abs(r) > 1.0F) continue;
    gain.add(u, 1.0F - r * r);
    ++inliers;
  }
  return {gain.total(), inliers};
}

template <class Raw>
void remove(const Raw* raw, std::size_t n, const RowPlane& plane, Raw* left) {
  for (std::size_t u = 0; u < n; ++u) left[u] = std::abs(distance(raw, u, plane)) > 1.0F ? raw[u] : Raw{0};
}

template <class Raw>
RowMoments moments(const Raw* raw, std::size_t n, const RowPlane& plane, float threshold, const Ramp& ray) {
  std::uint32_t count = 0;
  Sum sum_z;
  Sum sum_zz;
  Sum sum_za;
  Sum sum_zza;
  Sum sum_zzaa;
  for (std::size_t u = 0; u < n; ++u) {
    if (raw[u] == Raw{0} || std::abs(distance(raw, u, plane)) > threshold) continue;
    const auto z = static_cast<float>(raw[u]);
    const float x = z * value_at(ray, u);
    ++count;
    sum_z.add(u, z);
    sum_zz.add(u, z * z);
    sum_za.add(u, x);
    sum_zza.add(u, z * x);
    sum_zzaa.add(u, x * x);
  }
  return {count, sum_z.total(), sum_zz.total(), sum_za.total(), sum_zza.total(), sum_zzaa.total()};
}

template <class Raw>
void label(const Raw* raw, const Raw* kept, std::size_t n, const LabelPlane* planes, std::size_t num_planes, float threshold,
           std::uint8_t* labels) {
  for (std::size_t u = 0; u < n; ++u) {
    labels[u] = raw[u] == Raw{0} ? 0 : 255;
    if (kept[u] == Raw{0}) continue;
    float nearest = threshold;
    for (std::size_t p = num_planes; p-- > 0;) {
      const float d = std::abs(distance(raw, u, planes[p].plane));
      if (d > nearest) continue;
      nearest = d;
      labels[u] = planes[p].label;
    }
  }
}

template <class Raw>
RowEvidence evidence(const Raw* raw, const std::uint8_t* labels, std::size_t n, const LabelPlane& plane) {
  std::uint32_t count = 0;
  Sum squared_distance;
  Sum cubed_depth;
  for (std::size_t u = 0; u < n; ++u) {
    if (labels[u] != plane.label) continue;
    const auto z = static_cast<float>(raw[u]);
    const float r = distance(raw, u, plane.plane);
    ++count;
    squared_distance.add(u, r * r);
    cubed_depth.add(u, z * z * z);
  }
  return {count, squared_distance.total(), cubed_depth.total()};
}

template <class Raw>
RowEvidence label_one(const Raw* raw, const Raw* kept, std::size_t n, const LabelPlane& plane, float threshold,
                      std::uint8_t* labels) {
  label(raw, kept, n, &plane, 1, threshold, labels);
  return evidence(raw, labels, n, plane);
}

template <class Raw>
constexpr RowKernels<Raw> kTable = {keep_range<Raw>, count_measured<Raw>, largest<Raw>, leaf_runs<Raw>, score<Raw>,
                                    remove<Raw>,     moments<Raw>,        label<Raw>,   evidence<Raw>,  label_one<Raw>};

}  // namespace

void running_sums(const std::uint16_t* raw, std::size_t n, std::uint64_t* sums) {
  std::uint64_t low = 0;
  std::uint64_t high = 0;
  for (std::size_t u = 0; u <= n; ++u) {
    sums[u] = (low & 0xFFFFFFFF) | high << 32;
    if (u == n) break;
    low += raw[u];
    high += raw[u] * (u % kSumColumns);
  }
}

template <>
const RowKernels<std::uint16_t>& row_kernels() {
  return kTable<std::uint16_t>;
}

template <>
const RowKernels<float>& row_kernels() {
  return kTable<float>;
}

}  // namespace fransac::kernels::ref
