// SPDX-License-Identifier: Apache-2.0
/// The instruction sets that kernels are tested with.
#pragma once

#include <cstdint>
#include <vector>

#include "hwy/targets.h"

namespace fransac::kernels {

/// Those that were compiled and that this machine has.
inline std::vector<std::int64_t> targets() {
  std::vector<std::int64_t> list;
  for (std::int64_t rest = hwy::SupportedTargets() & HWY_TARGETS; rest != 0; rest &= rest - 1) list.push_back(rest & -rest);
  return list;
}

}  // namespace fransac::kernels
