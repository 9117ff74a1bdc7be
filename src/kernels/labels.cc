// SPDX-License-Identifier: Apache-2.0
#include "kernels/labels.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "kernels/labels.cc"
#include "hwy/foreach_target.h"  // compiles what follows once per instruction set
// clang-format off
#include "kernels/labels-inl.h"
// clang-format on

#if HWY_ONCE
namespace fransac::kernels {

HWY_EXPORT(Relabel);

void relabel(std::uint8_t* labels, std::size_t n, const std::uint8_t* table, int largest) {
  HWY_DYNAMIC_DISPATCH(Relabel)(labels, n, table, largest);
}

}  // namespace fransac::kernels
#endif  // HWY_ONCE
