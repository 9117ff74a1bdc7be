// SPDX-License-Identifier: Apache-2.0
// The environment variable that names the instruction set. ctest runs this, and the tests of segmentation, with each.
#include "hwy/targets.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <string>
#include <string_view>
#include <vector>

#include "fransac/planes/segment.hpp"

namespace fransac {
namespace {

/// Names of those that were compiled, whether the machine has them or not.
std::vector<std::string> compiled_targets() {
  std::vector<std::string> names;
  for (std::int64_t rest = HWY_TARGETS; rest != 0; rest &= rest - 1) names.emplace_back(hwy::TargetName(rest & -rest));
  return names;
}

TEST(InstructionSet, IsTheOneThatTheEnvironmentNames) {
  const char* const wanted = std::getenv("FRANSAC_TARGET");
  const std::vector<std::string> names = compiled_targets();
  EXPECT_NE(std::find(names.begin(), names.end(), instruction_set()), names.end()) << instruction_set();
  if (wanted == nullptr) return;
  if (instruction_set() != wanted) {
    // Ignored only where the machine or the build lacks it: the choice is then the best there is.
    EXPECT_EQ(instruction_set(), hwy::TargetName(hwy::SupportedTargets() & -hwy::SupportedTargets())) << "asked for " << wanted;
    for (std::int64_t rest = hwy::SupportedTargets() & HWY_TARGETS; rest != 0; rest &= rest - 1) {
      EXPECT_STRNE(hwy::TargetName(rest & -rest), wanted);
    }
    GTEST_SKIP() << "no " << wanted << " here";
  }
}

}  // namespace
}  // namespace fransac
