// SPDX-License-Identifier: Apache-2.0
#include "kernels/labels.h"

namespace fransac::kernels::ref {

void relabel(std::uint8_t* labels, std::size_t n, const std::uint8_t* table, int /*largest*/) {
  for (std::size_t i = 0; i < n; ++i) labels[i] = table[labels[i]];
}

}  // namespace fransac::kernels::ref
