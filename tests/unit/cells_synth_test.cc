// SPDX-License-Identifier: Apache-2.0
// The method `cells` on rendered scenes under each sensor's errors.
#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <cmath>
#include <numbers>
#include <utility>
#include <vector>

#include "cells.hpp"
#include "fransac/eval/metrics.hpp"
#include "fransac/planes/segment.hpp"
#include "fransac/synth/synth.hpp"
#include "support.hpp"

namespace fransac {
namespace {

using testing::cells;
using testing::cells_options;
using testing::expect_sane;
using testing::view_of;

constexpr synth::Sensor kSensors[] = {synth::Sensor::none, synth::Sensor::kinect1, synth::Sensor::stereo, synth::Sensor::tof};
constexpr SensorKind kKinds[] = {SensorKind::none, SensorKind::structured_light, SensorKind::stereo, SensorKind::time_of_flight};

synth::SynthFrame rendered(const synth::SynthOptions& options) {
  auto frame = synth::render(options);
  if (frame) return *std::move(frame);
  ADD_FAILURE() << frame.error().message;
  return {};
}

struct TruePlane {
  const PlaneSegment* found;
  const Plane* plane;
};

/// The planes that were found, each with the true one that most of its judged pixels are on; those with fewer than half of their
/// pixels there are left out.
std::vector<TruePlane> pairs_of(const synth::SynthFrame& frame, const Segmentation& s) {
  std::vector<TruePlane> pairs;
  for (const PlaneSegment& found : s.planes) {
    std::array<std::uint64_t, 256> pixels{};
    for (std::size_t i = 0; i < s.labels.size(); ++i) pixels[frame.labels[i]] += s.labels[i] == found.id ? 1U : 0U;
    for (const auto& [label, plane] : frame.true_planes) {
      if (2 * pixels[static_cast<std::size_t>(label)] > found.inliers) pairs.push_back({&found, &plane});
    }
  }
  return pairs;
}

TEST(CellsSynth, EverySensorsPlanesAreFound) {
  for (std::size_t k = 0; k < std::size(kSensors); ++k) {
    for (const SensorKind kind : {SensorKind::automatic, kKinds[k]}) {
      SCOPED_TRACE(::testing::Message() << "sensor " << k << " seen as " << enum_name(kind));
      const synth::SynthFrame frame = rendered({.scene = "empty_room", .sensor = kSensors[k], .seed = 1});
      SegmentOptions options = cells_options();
      options.sensor.kind = kind;
      const Segmentation s = cells(view_of(frame), frame.camera, options);
      expect_sane(s, view_of(frame));
      const auto metrics = eval::instance_metrics(frame.labels, s.labels);
      ASSERT_TRUE(metrics);
      // Beyond 4 m this stereo camera's depth is not known to 5 cm, and cells makes no plane of it: two of the walls.
      const bool stereo = kSensors[k] == synth::Sensor::stereo;
      EXPECT_GE(metrics->at75.f1, stereo ? 0.7 : 0.9);
      EXPECT_GE(metrics->weighted_iou, stereo ? 0.8 : 0.95);
      const std::vector<TruePlane> pairs = pairs_of(frame, s);
      EXPECT_FALSE(pairs.empty());
      for (const TruePlane& pair : pairs) {
        EXPECT_LT(eval::plane_error(*pair.plane, pair.found->plane).angle_rad, std::numbers::pi / 180.0) << pair.found->id;
      }
    }
  }
}

/// There should be none. Strips along large cylinders are left, which bend less than the sensor could (docs/algorithms.md,
/// "Curved surfaces"): a guard against more of them.
TEST(CellsSynth, CurvedThingsGiveFewPlanes) {
  for (const synth::Sensor sensor : kSensors) {
    for (std::uint64_t seed = 0; seed < 2; ++seed) {
      SCOPED_TRACE(::testing::Message() << "sensor " << static_cast<int>(sensor) << ", seed " << seed);
      const synth::SynthFrame frame = rendered({.scene = "curved", .sensor = sensor, .seed = seed});
      const Segmentation s = cells(view_of(frame), frame.camera);
      expect_sane(s, view_of(frame));
      EXPECT_LE(s.planes.size(), 8U);
    }
  }
}

/// Errors are at most thrice what the covariance says, in the mean of their squares.
TEST(CellsSynth, CovarianceIsNotOverconfident) {
  std::vector<double> squares;
  for (std::uint64_t seed = 0; seed < 8; ++seed) {
    const synth::SynthFrame frame =
        rendered({.scene = "empty_room", .seed = seed, .camera = {320, 240, 262.5, 262.5, 159.5, 119.5, 5000.0}});
    const Segmentation s = cells(view_of(frame), frame.camera);
    for (const TruePlane& pair : pairs_of(frame, s)) {
      Eigen::Vector4d error;
      error << pair.found->plane.normal - pair.plane->normal, pair.found->plane.d - pair.plane->d;
      const Eigen::SelfAdjointEigenSolver<Eigen::Matrix4d> axes(pair.found->covariance);
      for (int i = 1; i < 4; ++i) {
        const double along = axes.eigenvectors().col(i).dot(error);
        squares.push_back(along * along / axes.eigenvalues()[i]);
      }
    }
  }
  ASSERT_GE(squares.size(), 24U);
  double mean = 0.0;
  for (const double square : squares) mean += square / static_cast<double>(squares.size());
  EXPECT_LT(std::sqrt(mean), 3.0);
}

TEST(CellsSynth, ThreadsDoNotChangeTheAnswer) {
  const synth::SynthFrame frame = rendered({.scene = "office"});
  for (const auto& [width, height] : {std::pair{640, 480}, {1920, 1080}}) {
    Camera camera = frame.camera;
    camera.width = width;
    camera.height = height;
    // The same picture over and over.
    std::vector<std::uint16_t> pixels;
    for (int v = 0; v < height; ++v) {
      for (int u = 0; u < width; ++u) pixels.push_back(frame.depth[static_cast<std::size_t>(v % 480 * 640 + u % 640)]);
    }
    const DepthView depth = DepthView::from_uint16(pixels.data(), width, height, camera.depth_scale);
    SegmentOptions options = cells_options();
    const Segmentation serial = cells(depth, camera, options);
    EXPECT_GE(serial.planes.size(), 2U);
    for (const int threads : {2, 5}) {
      SCOPED_TRACE(::testing::Message() << width << " x " << height << ", " << threads << " threads");
      options.threads = threads;
      testing::expect_same(serial, cells(depth, camera, options));
    }
  }
}

TEST(CellsSynth, AWorkspaceRemembersNothing) {
  const synth::SynthFrame first = rendered({.scene = "office"});
  const synth::SynthFrame small = rendered({.scene = "desk", .camera = {201, 149, 164.0, 164.0, 99.5, 74.5, 5000.0}});
  const synth::SynthFrame last = rendered({.scene = "stairs", .sensor = synth::Sensor::tof});
  Workspace workspace;
  Segmentation reused;
  SegmentOptions options = cells_options();
  options.cells.residuals = true;
  for (const synth::SynthFrame* frame : {&first, &small, &last, &first}) {
    ASSERT_TRUE(segment(view_of(*frame), frame->camera, options, workspace, reused));
    testing::expect_same(reused, cells(view_of(*frame), frame->camera, options));
    // And another type of image in between.
    const DepthView exact = DepthView::from_float(frame->exact_depth_m.data(), frame->camera.width, frame->camera.height);
    ASSERT_TRUE(segment(exact, frame->camera, cells_options(), workspace, reused));
    testing::expect_same(reused, cells(exact, frame->camera));
    EXPECT_TRUE(reused.residuals_m.empty());
  }
}

}  // namespace
}  // namespace fransac
