// SPDX-License-Identifier: Apache-2.0
// Segmentation as a whole with each instruction set against the scalar one. The paper's methods are the same. In `cells` rounding
// can decide whether a cell belongs to a region, and with it whether a small plane is one; of the pixels all but a few hundredths
// must not care, and no large plane.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <map>
#include <string>
#include <utility>

#include "cells.hpp"
#include "fransac/filter/deproject.hpp"
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

/// The share of the image that two answers put on different planes, with the planes paired by the pixels they have in common.
double disagreement(const Segmentation& a, const Segmentation& b) {
  std::map<std::pair<int, int>, std::size_t> common;
  for (std::size_t i = 0; i < a.labels.size(); ++i) ++common[{a.labels[i], b.labels[i]}];
  std::map<int, std::size_t> most;
  for (const auto& [labels, pixels] : common) {
    const bool both = labels.first < kLabelNoPlane && labels.second < kLabelNoPlane;
    if (both || labels.first == labels.second) most[labels.first] = std::max(most[labels.first], pixels);
  }
  std::size_t agreed = 0;
  for (const auto& [label, pixels] : most) agreed += pixels;
  return 1.0 - static_cast<double>(agreed) / static_cast<double>(a.labels.size());
}

void expect_alike(const Segmentation& a, const Segmentation& b) {
  ASSERT_EQ(a.labels.size(), b.labels.size());
  constexpr double kLarge = 0.05;  // of the image: as much as one small plane
  EXPECT_LE(disagreement(a, b), kLarge);
  for (const PlaneSegment& plane : a.planes) {
    if (static_cast<double>(plane.inliers) < kLarge * static_cast<double>(a.labels.size())) continue;
    const auto is_same = [&](const PlaneSegment& other) {
      return angle_between(plane.plane, other.plane) < 1e-3 && std::abs(plane.plane.d - other.plane.d) < 2e-3;
    };
    EXPECT_TRUE(std::any_of(b.planes.begin(), b.planes.end(), is_same))
        << "plane " << plane.id << " of " << plane.inliers << " pixels";
  }
}

TEST_P(CellsTargets, AgreeOnRenderedFrames) {
  constexpr Camera kCamera{321, 243, 262.5, 262.5, 160.0, 121.0, 5000.0};
  for (const char* const scene : {"empty_room", "desk", "stairs", "boxes"}) {
    for (const synth::Sensor sensor : {synth::Sensor::kinect1, synth::Sensor::tof}) {
      SCOPED_TRACE(::testing::Message() << scene << ", sensor " << static_cast<int>(sensor));
      const auto frame = synth::render({.scene = scene, .sensor = sensor, .camera = kCamera});
      ASSERT_TRUE(frame);
      const DepthView units = testing::view_of(*frame);
      expect_alike(with_target(GetParam(), units, kCamera), with_target(HWY_SCALAR, units, kCamera));
      const DepthView metres = DepthView::from_float(frame->exact_depth_m.data(), kCamera.width, kCamera.height);
      expect_alike(with_target(GetParam(), metres, kCamera), with_target(HWY_SCALAR, metres, kCamera));
    }
  }
}

void expect_same(const Segmentation& a, const Segmentation& b) {
  EXPECT_TRUE(a.labels == b.labels);
  EXPECT_EQ(a.iterations, b.iterations);
  ASSERT_EQ(a.planes.size(), b.planes.size());
  for (std::size_t i = 0; i < a.planes.size(); ++i) {
    EXPECT_EQ(a.planes[i].plane.normal, b.planes[i].plane.normal);
    EXPECT_EQ(a.planes[i].plane.d, b.planes[i].plane.d);
    EXPECT_EQ(a.planes[i].inliers, b.planes[i].inliers);
    EXPECT_EQ(a.planes[i].area_m2, b.planes[i].area_m2);
    EXPECT_EQ(a.planes[i].rms_m, b.planes[i].rms_m);
  }
}

// Planes taken off one by one: a point more or less on the first, and all others would be found elsewhere.
TEST_P(CellsTargets, ThePapersMethodsGiveTheSameToTheLastBit) {
  constexpr Camera kCamera{321, 243, 262.5, 262.5, 160.0, 121.0, 5000.0};
  for (const char* const scene : {"empty_room", "desk", "boxes"}) {
    const auto frame = synth::render({.scene = scene, .sensor = synth::Sensor::kinect1, .camera = kCamera});
    ASSERT_TRUE(frame);
    const DepthView units = testing::view_of(*frame);
    const DepthView metres = DepthView::from_float(frame->exact_depth_m.data(), kCamera.width, kCamera.height);
    PointCloud cloud;
    deproject(units, kCamera, cloud);
    for (const Method method : {Method::ransac, Method::rransac, Method::voxel_ransac, Method::fransac}) {
      SCOPED_TRACE(::testing::Message() << scene << ", " << enum_name(method));
      SegmentOptions options;
      options.method = method;
      options.max_planes = 0;
      const auto all_with = [&](std::int64_t target) {
        hwy::SetSupportedTargetsForTest(target);
        return std::array{segment(units, kCamera, options), segment(metres, kCamera, options), segment(cloud, options)};
      };
      const auto found = all_with(GetParam());
      const auto expected = all_with(HWY_SCALAR);
      for (std::size_t i = 0; i < found.size(); ++i) {
        ASSERT_TRUE(found[i]);
        ASSERT_TRUE(expected[i]);
        expect_same(*found[i], *expected[i]);
      }
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Targets, CellsTargets, ::testing::ValuesIn(kernels::targets()),
                         [](const ::testing::TestParamInfo<std::int64_t>& target) {
                           return std::string(hwy::TargetName(target.param));
                         });

}  // namespace
}  // namespace fransac
