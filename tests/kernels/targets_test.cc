// SPDX-License-Identifier: Apache-2.0
// The environment variable that names the instruction set. ctest runs this, and the tests of segmentation, with each. A program
// of its own: Highway's list of what a machine has, which the kernels' tests ask for, undoes the choice.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <string_view>

#include "fransac/planes/segment.hpp"
#include "support.hpp"

namespace fransac {
namespace {

TEST(InstructionSet, IsTheOneThatTheEnvironmentNames) {
  EXPECT_FALSE(instruction_set().empty());
  const char* const wanted = std::getenv("FRANSAC_TARGET");
  if (wanted == nullptr || instruction_set() == wanted) return;
  testing::FloatImage image(testing::small_camera());
  image.draw(Plane{Eigen::Vector3d(0.0, 0.0, -1.0), 2.0});
  const Result<Segmentation> refused = segment(image.view(), image.camera);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, ErrorCode::unsupported);
  EXPECT_THAT(refused.error().message, ::testing::StartsWith("FRANSAC_TARGET: "));
  if (std::string_view(wanted) == "SSE4711") return;  // nobody has it
#ifdef __x86_64__
  ASSERT_STRNE(wanted, "SCALAR") << "every such machine has it, but got " << instruction_set();
#endif
  GTEST_SKIP() << "no " << wanted << " here";
}

}  // namespace
}  // namespace fransac
