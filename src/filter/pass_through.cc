// SPDX-License-Identifier: Apache-2.0
#include "fransac/filter/pass_through.hpp"

#include <cmath>
#include <limits>
#include <numeric>

#include "kernels/points.h"

namespace fransac {
namespace {

/// Moves the points for which keep(i) holds to the front, in order.
template <class Keep>
void compact(PointCloud& cloud, const Keep& keep) {
  if (cloud.source.empty()) {
    cloud.source.resize(cloud.size());
    std::iota(cloud.source.begin(), cloud.source.end(), 0U);
  }
  float* const x = cloud.x();
  float* const y = cloud.y();
  float* const z = cloud.z();
  std::uint32_t* const source = cloud.source.data();
  std::size_t k = 0;
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const bool kept = keep(i);
    x[k] = x[i];
    y[k] = y[i];
    z[k] = z[i];
    source[k] = source[i];
    k += static_cast<std::size_t>(kept);
  }
  cloud.source.resize(k);
  cloud.resize_uninitialised(k);
  cloud.width = static_cast<int>(k);
  cloud.height = 1;
}

/// Whether all three coordinates are finite, without a branch: 0 times infinity or NaN is NaN.
struct FiniteTest {
  explicit FiniteTest(const PointCloud& cloud) : x(cloud.x()), y(cloud.y()), z(cloud.z()) {}
  bool operator()(std::size_t i) const { return x[i] * 0.0F + y[i] * 0.0F + z[i] * 0.0F == 0.0F; }
  const float* x;
  const float* y;
  const float* z;
};

}  // namespace

LocalLimits::LocalLimits(const AxisLimits& limits, double origin_m) : outside(limits.outside) {
  constexpr float kInf = std::numeric_limits<float>::infinity();
  const double exact_min = limits.min_m - origin_m;
  const double exact_max = limits.max_m - origin_m;
  min = static_cast<float>(exact_min);
  if (static_cast<double>(min) < exact_min) min = std::nextafter(min, kInf);
  max = static_cast<float>(exact_max);
  if (static_cast<double>(max) > exact_max) max = std::nextafter(max, -kInf);
}

void pass_through(const AxisLimits& limits, PointCloud& cloud) {
  const auto axis = static_cast<Eigen::Index>(limits.axis);
  const LocalLimits local(limits, cloud.origin[axis]);
  const float* const coordinate = axis == 0 ? cloud.x() : axis == 1 ? cloud.y() : cloud.z();
  compact(cloud, [=, finite = FiniteTest(cloud)](std::size_t i) {
    // No short circuit: the branch would cost more than the second test.
    return (static_cast<int>(local.keeps(coordinate[i])) & static_cast<int>(finite(i))) != 0;
  });
}

std::size_t count_measured(const PointCloud& cloud) {
  const Eigen::Vector3f zero = (-cloud.origin).cast<float>();
  return kernels::count_measured(cloud.x(), cloud.y(), cloud.z(), cloud.padded_size(), zero.data());
}

void remove_unmeasured(PointCloud& cloud) {
  compact(cloud, [&cloud](std::size_t i) { return cloud.measured(i); });
}

}  // namespace fransac
