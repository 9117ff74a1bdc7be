// SPDX-License-Identifier: Apache-2.0
#include <cmath>

#include "kernels/rows.h"

namespace fransac::kernels::ref {

void offer_plane(const float* z, std::size_t n, const RowPlane& plane, float* nearest, float* label) {
  for (std::size_t u = 0; u < n; ++u) {
    const float distance = std::abs(z[u] * (plane.base + plane.step * static_cast<float>(u)) + plane.d);
    if (!(distance < nearest[u])) continue;
    nearest[u] = distance;
    label[u] = plane.label;
  }
}

}  // namespace fransac::kernels::ref
