// SPDX-License-Identifier: Apache-2.0
#include "kernels/cells.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "kernels/cells.cc"
#include "hwy/foreach_target.h"  // compiles what follows once per instruction set
// clang-format off
#include "kernels/cells-inl.h"
// clang-format on

#if HWY_ONCE
namespace fransac::kernels {

HWY_EXPORT(Cells16);
HWY_EXPORT(Cells32);

template <>
const CellKernels<std::uint16_t>& cell_kernels(int side) {
  return *HWY_DYNAMIC_DISPATCH(Cells16)(side);
}

template <>
const CellKernels<float>& cell_kernels(int side) {
  return *HWY_DYNAMIC_DISPATCH(Cells32)(side);
}

}  // namespace fransac::kernels
#endif  // HWY_ONCE
