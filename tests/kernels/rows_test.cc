// SPDX-License-Identifier: Apache-2.0
// The row kernel against its scalar twin, once per instruction set that this machine has.
#include "kernels/rows.h"

#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "fransac/core/aligned.hpp"
#include "hwy/targets.h"
#include "support.hpp"

namespace fransac::kernels {
namespace {

using Floats = AlignedVector<float>;

class RowKernels : public ::testing::TestWithParam<std::int64_t> {
 protected:
  void SetUp() override { hwy::SetSupportedTargetsForTest(GetParam()); }
  void TearDown() override { hwy::SetSupportedTargetsForTest(0); }
};

TEST_P(RowKernels, OfferPlane) {
  RandomStream random = testing::test_random();
  for (const std::size_t n : {std::size_t{0}, kBlock, 3 * kBlock, 40 * kBlock}) {
    Floats z(n);
    Floats nearest(n);
    Floats label(n);
    for (std::size_t u = 0; u < n; ++u) {
      const bool measured = random.uniform() < 0.8;
      z[u] = measured ? static_cast<float>(testing::uniform(random, 0.4, 5.0)) : 0.0F;
      nearest[u] = measured ? 0.05F : 0.0F;
      label[u] = measured ? 255.0F : 0.0F;
    }
    Floats nearest_ref = nearest;
    Floats label_ref = label;
    for (int id = 1; id <= 3; ++id) {
      const RowPlane plane{static_cast<float>(testing::uniform(random, -1.0, 1.0)),
                           static_cast<float>(testing::uniform(random, -1e-3, 1e-3)),
                           static_cast<float>(testing::uniform(random, 0.0, 2.0)), static_cast<float>(id)};
      offer_plane(z.data(), n, plane, nearest.data(), label.data());
      ref::offer_plane(z.data(), n, plane, nearest_ref.data(), label_ref.data());
    }
    for (std::size_t u = 0; u < n; ++u) {
      EXPECT_NEAR(nearest[u], nearest_ref[u], 4e-6F);  // some roundings of values up to 10
      if (label[u] != label_ref[u]) {
        EXPECT_NEAR(nearest[u], nearest_ref[u], 4e-6F) << "a label may differ only where two planes are equally near";
        EXPECT_GT(nearest_ref[u], 0.0F);
      }
      if (z[u] == 0.0F) {
        EXPECT_EQ(label[u], 0.0F);
      }
    }
  }
}

TEST(RowKernel, ClosedForm) {
  Floats z(kBlock, 0.0F);
  Floats nearest(kBlock, 0.0F);
  Floats label(kBlock, 0.0F);
  z[0] = z[1] = z[2] = 2.0F;
  nearest[0] = nearest[1] = nearest[2] = 0.25F;
  label[0] = label[1] = label[2] = 255.0F;
  // n . r = -1 + u / 16: distances |2 (-1 + u / 16) + 2| = u / 8. Ties keep what is there.
  offer_plane(z.data(), kBlock, {-1.0F, 0.0625F, 2.0F, 7.0F}, nearest.data(), label.data());
  EXPECT_EQ(label[0], 7.0F);
  EXPECT_EQ(nearest[0], 0.0F);
  EXPECT_EQ(label[1], 7.0F);
  EXPECT_EQ(nearest[1], 0.125F);
  EXPECT_EQ(label[2], 255.0F);
  EXPECT_EQ(nearest[2], 0.25F);
  EXPECT_EQ(label[3], 0.0F);
}

INSTANTIATE_TEST_SUITE_P(Targets, RowKernels, ::testing::ValuesIn(hwy::SupportedAndGeneratedTargets()),
                         [](const auto& info) { return std::string(hwy::TargetName(info.param)); });

}  // namespace
}  // namespace fransac::kernels
