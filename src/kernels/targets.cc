// SPDX-License-Identifier: Apache-2.0
#include "kernels/targets.h"

#include <cstdlib>
#include <string_view>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "kernels/targets.cc"
#include "hwy/foreach_target.h"  // compiles what follows once per instruction set
// clang-format off
#include "hwy/highway.h"
// clang-format on

HWY_BEFORE_NAMESPACE();
namespace fransac::kernels {
namespace HWY_NAMESPACE {

const char* name_of_target() { return hwy::TargetName(HWY_TARGET); }

}  // namespace HWY_NAMESPACE
}  // namespace fransac::kernels
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace fransac::kernels {
namespace {

HWY_EXPORT(name_of_target);

/// Leaves only the instruction set that FRANSAC_TARGET names, where this machine has it. Tests run segmentation with each.
bool obey_environment() {
  const char* const wanted = std::getenv("FRANSAC_TARGET");
  if (wanted == nullptr) return false;
  for (std::int64_t rest = hwy::SupportedTargets() & HWY_TARGETS; rest != 0; rest &= rest - 1) {
    const std::int64_t target = rest & -rest;
    if (std::string_view(hwy::TargetName(target)) != wanted) continue;
    hwy::DisableTargets(~target);
    return true;
  }
  return false;
}

// Before any kernel is called: the first call fixes the choice.
[[maybe_unused]] const bool kObeyed = obey_environment();

}  // namespace

const char* target_name() { return HWY_DYNAMIC_DISPATCH(name_of_target)(); }

}  // namespace fransac::kernels
#endif  // HWY_ONCE
