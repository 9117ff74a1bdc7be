// SPDX-License-Identifier: Apache-2.0
#include "kernels/rows.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "kernels/rows.cc"
#include "hwy/foreach_target.h"  // compiles what follows once per instruction set
// clang-format off
#include "kernels/rows-inl.h"
// clang-format on

#if HWY_ONCE
namespace fransac::kernels {

HWY_EXPORT(RunningSums);
HWY_EXPORT(Rows16);
HWY_EXPORT(Rows32);

void running_sums(const std::uint16_t* raw, std::size_t n, std::uint64_t* sums) {
  HWY_DYNAMIC_DISPATCH(RunningSums)(raw, n, sums);
}

template <>
const RowKernels<std::uint16_t>& row_kernels() {
  return *HWY_DYNAMIC_DISPATCH(Rows16)();
}

template <>
const RowKernels<float>& row_kernels() {
  return *HWY_DYNAMIC_DISPATCH(Rows32)();
}

}  // namespace fransac::kernels
#endif  // HWY_ONCE
