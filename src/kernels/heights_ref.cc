// SPDX-License-Identifier: Apache-2.0
// Scalar truth of the height kernels, in double.
#include "kernels/heights.h"

namespace fransac::kernels::ref {
namespace {

template <class Raw>
void find_sides(const Raw* raw, const std::uint8_t* kinds, std::size_t n, float metres_per_unit, const HeightRow& row,
                const HeightLimits& limits, std::uint8_t* sides, const QuadSums& sums) {
  const auto d = [](float value) { return static_cast<double>(value); };
  for (std::size_t u = 0; u < n; ++u) {
    sides[u] = 0;
    if (raw[u] == Raw{0} || kinds[u] != kOffPlane) continue;
    const double z = static_cast<double>(raw[u]) * d(metres_per_unit);
    const double slope = d(row.base) + d(row.step) * static_cast<double>(u);
    const double height = z * slope + d(row.d);
    const double noise = d(limits.constant) + z * z * (d(limits.linear) + z * z * d(limits.quadratic));
    if (!(height * height > noise * slope * slope)) continue;
    if (height > d(limits.least_height)) {
      sides[u] = kAbove;
      ++sums.above[u / kQuad];
      sums.above_z[u / kQuad] += static_cast<float>(z);
    } else if (height < -d(limits.least_drop)) {
      sides[u] = kBelow;
      ++sums.below[u / kQuad];
      sums.below_z[u / kQuad] += static_cast<float>(z);
    }
  }
}

template <class Raw>
constexpr HeightKernels<Raw> kTable{find_sides<Raw>};

}  // namespace

template <>
const HeightKernels<std::uint16_t>& height_kernels() {
  return kTable<std::uint16_t>;
}
template <>
const HeightKernels<float>& height_kernels() {
  return kTable<float>;
}

}  // namespace fransac::kernels::ref
