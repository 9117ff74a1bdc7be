// SPDX-License-Identifier: Apache-2.0
/// What tests of the method `cells` share.
#pragma once

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <vector>

#include "fransac/core/labels.hpp"
#include "fransac/planes/segment.hpp"
#include "fransac/synth/synth.hpp"
#include "support.hpp"

namespace fransac::testing {

/// A Kinect's field of view at another size.
inline Camera kinect(int width = 640, int height = 480) {
  const double f = 525.0 * width / 640.0;
  return {.width = width,
          .height = height,
          .fx = f,
          .fy = f,
          .cx = 0.5 * (width - 1),
          .cy = 0.5 * (height - 1),
          .depth_scale = 5000.0};
}

inline SegmentOptions cells_options() {
  SegmentOptions options;
  options.method = Method::cells;
  return options;
}

/// No plane where there is an error, too, which fails the test.
inline Segmentation cells(const DepthView& depth, const Camera& camera, const SegmentOptions& options = cells_options()) {
  Result<Segmentation> result = segment(depth, camera, options);
  if (result) return *std::move(result);
  ADD_FAILURE() << result.error().message;
  return {};
}

inline DepthView view_of(const synth::SynthFrame& frame) {
  return DepthView::from_uint16(frame.depth.data(), frame.camera.width, frame.camera.height, frame.camera.depth_scale);
}

/// What holds of every answer: labels of planes that there are, 0 just where nothing was measured, as many pixels as inliers,
/// numbers that mean something.
inline void expect_sane(const Segmentation& s, const DepthView& depth) {
  ASSERT_EQ(s.width, depth.width());
  ASSERT_EQ(s.height, depth.height());
  ASSERT_EQ(s.labels.size(), depth.size());
  std::array<std::uint64_t, 256> pixels{};
  std::size_t i = 0;
  std::size_t wrong_zeros = 0;
  for (int v = 0; v < depth.height(); ++v) {
    for (int u = 0; u < depth.width(); ++u, ++i) {
      ++pixels[s.labels[i]];
      if ((s.labels[i] == kLabelNoDepth) != (depth.metres(u, v) == 0.0F)) ++wrong_zeros;
    }
  }
  EXPECT_EQ(wrong_zeros, 0U);
  for (std::size_t label = s.planes.size() + 1; label < kLabelNoPlane; ++label) EXPECT_EQ(pixels[label], 0U) << label;
  for (std::size_t k = 0; k < s.planes.size(); ++k) {
    const PlaneSegment& p = s.planes[k];
    SCOPED_TRACE(::testing::Message() << "plane " << k + 1);
    EXPECT_EQ(p.id, static_cast<int>(k) + 1);
    EXPECT_EQ(p.inliers, pixels[k + 1]);
    EXPECT_GT(p.inliers, 0U);
    EXPECT_NEAR(p.plane.normal.norm(), 1.0, 1e-9);
    EXPECT_TRUE(std::isfinite(p.plane.d) && p.plane.d >= 0.0) << p.plane.d;
    EXPECT_TRUE(std::isfinite(p.rms_m) && p.rms_m >= 0.0) << p.rms_m;
    EXPECT_TRUE(std::isfinite(p.area_m2) && p.area_m2 > 0.0) << p.area_m2;
    EXPECT_TRUE(p.centroid.allFinite()) << p.centroid.transpose();
    EXPECT_TRUE(p.covariance.allFinite());
    if (!p.covariance.allFinite()) continue;
    const Eigen::Vector4d spread = Eigen::SelfAdjointEigenSolver<Eigen::Matrix4d>(p.covariance).eigenvalues();
    EXPECT_GE(spread[0], -1e-9 * spread[3]);
    EXPECT_GT(spread[3], 0.0);
  }
}

/// The share of the pixels whose labels differ.
inline double difference(const Segmentation& a, const Segmentation& b) {
  if (a.labels.size() != b.labels.size() || a.labels.empty()) return 1.0;
  std::size_t different = 0;
  for (std::size_t i = 0; i < a.labels.size(); ++i) different += a.labels[i] != b.labels[i] ? 1U : 0U;
  return static_cast<double>(different) / static_cast<double>(a.labels.size());
}

/// Equal but for rounding: the same planes to `tolerance` (of normals; of offsets in metres), and labels that differ in at most
/// one pixel of a thousand, those that lie halfway between two planes or at the limit of one.
inline void expect_same_to_rounding(const Segmentation& a, const Segmentation& b, double tolerance = 1e-4) {
  ASSERT_EQ(a.planes.size(), b.planes.size());
  for (std::size_t i = 0; i < a.planes.size(); ++i) {
    EXPECT_LE((a.planes[i].plane.normal - b.planes[i].plane.normal).norm(), tolerance) << "plane " << i + 1;
    EXPECT_NEAR(a.planes[i].plane.d, b.planes[i].plane.d, tolerance) << "plane " << i + 1;
  }
  EXPECT_LE(difference(a, b), 1e-3);
}

}  // namespace fransac::testing
