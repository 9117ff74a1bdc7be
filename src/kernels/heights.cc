// SPDX-License-Identifier: Apache-2.0
#include "kernels/heights.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "kernels/heights.cc"
#include "hwy/foreach_target.h"  // compiles what follows once per instruction set
// clang-format off
#include "kernels/heights-inl.h"
// clang-format on

#if HWY_ONCE
namespace fransac::kernels {

HWY_EXPORT(Heights16);
HWY_EXPORT(Heights32);

template <>
const HeightKernels<std::uint16_t>& height_kernels() {
  return *HWY_DYNAMIC_DISPATCH(Heights16)();
}

template <>
const HeightKernels<float>& height_kernels() {
  return *HWY_DYNAMIC_DISPATCH(Heights32)();
}

}  // namespace fransac::kernels
#endif  // HWY_ONCE
