// SPDX-License-Identifier: Apache-2.0
// `cells` as a whole with each instruction set against the scalar one: the same planes, and labels that differ by no more than
// rounding can make them (testing::expect_same_to_rounding says how that is judged).
#include <gtest/gtest.h>

#include <cstdint>
#include <string>

#include "cells.hpp"
#include "hwy/targets.h"
#include "kernels/targets.hpp"

namespace fransac {
namespace {

class CellsTargets : public ::testing::TestWithParam<std::int64_t> {
 protected:
  void TearDown() override { hwy::SetSupportedTargetsForTest(0); }
};

Segmentation with_target(std::int64_t target, const DepthView& depth, const Camera& camera) {
  hwy::SetSupportedTargetsForTest(target);
  return testing::cells(depth, camera);
}

TEST_P(CellsTargets, AgreeOnRenderedFrames) {
  constexpr Camera kCamera{321, 243, 262.5, 262.5, 160.0, 121.0, 5000.0};
  for (const char* const scene : {"empty_room", "desk", "stairs", "boxes"}) {
    for (const synth::Sensor sensor : {synth::Sensor::kinect1, synth::Sensor::tof}) {
      SCOPED_TRACE(::testing::Message() << scene << ", sensor " << static_cast<int>(sensor));
      const auto frame = synth::render({.scene = scene, .sensor = sensor, .camera = kCamera});
      ASSERT_TRUE(frame);
      const DepthView units = testing::view_of(*frame);
      testing::expect_same_to_rounding(with_target(GetParam(), units, kCamera), with_target(HWY_SCALAR, units, kCamera));
      const DepthView metres = DepthView::from_float(frame->exact_depth_m.data(), kCamera.width, kCamera.height);
      testing::expect_same_to_rounding(with_target(GetParam(), metres, kCamera), with_target(HWY_SCALAR, metres, kCamera));
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Targets, CellsTargets, ::testing::ValuesIn(kernels::targets()),
                         [](const ::testing::TestParamInfo<std::int64_t>& target) { return std::string(hwy::TargetName(target.param)); });

}  // namespace
}  // namespace fransac
