// SPDX-License-Identifier: Apache-2.0
// Guards the accuracy of `cells` on rendered frames, where there are no real ones: rendered.csv beside this file, written and
// compared as the tables of accuracy_test.cc are. The frames have what real cameras add to depth - bent planes, holes, coarse
// steps, clutter - so that each stage of the method is needed.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numbers>
#include <ostream>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "cells.hpp"
#include "fransac/core/labels.hpp"
#include "fransac/core/random.hpp"
#include "fransac/eval/metrics.hpp"
#include "fransac/planes/segment.hpp"
#include "fransac/synth/synth.hpp"
#include "regression/table.hpp"

namespace fransac {
namespace {

using testing::TableRow;
using testing::TableRows;

/// Instruction sets, compilers and optimisation move no number by more than half of this.
constexpr double kTolerance = 0.002;

constexpr double kDegrees = 180.0 / std::numbers::pi;

constexpr std::array<std::string_view, 15> kColumns = {
    "found",     "f1",     "instance_f1_50", "instance_f1_75", "weighted_iou",       "plane_pixel_f1", "on_planes", "angle_deg",
    "sigma_deg", "rms_mm", "confidence",     "constant_mm",    "quadratic_mm_per_m", "slow",           "bias_mm"};

/// What is rendered, and what a camera makes of it beyond its noise.
struct Rendering {
  std::string_view name;  ///< Of the table's row, with the sensor.
  synth::SynthOptions synth;
  double bend = 0.0;    ///< By which share depth at the corners is too long; less by the square of the distance from the middle.
  double holes = 0.0;   ///< Share of the pixels without a measurement, in blotches.
  double step_m = 0.0;  ///< Depth comes in multiples of this; 0: of the unit.
  double fill_m = 0.0;  ///< What the rightmost fifth of the image holds throughout; 0: what was measured there.
};

void PrintTo(const Rendering& rendering, std::ostream* out) { *out << rendering.name; }

synth::SynthOptions scene(std::string name, synth::Sensor sensor, std::uint64_t seed, int width = 640) {
  synth::SynthOptions options{.scene = std::move(name), .sensor = sensor, .seed = seed};
  options.camera = synth::resized(options.camera, width, width * 3 / 4);
  return options;
}

std::vector<Rendering> renderings() {
  using enum synth::Sensor;
  return {
      {"office-bent", scene("office", kinect1, 1), 0.01, 0.1, 0.0},
      {"office", scene("office", stereo, 2), 0.005, 0.0, 0.0},
      {"office-coarse", scene("office", tof, 3, 320), 0.0, 0.1, 0.004},
      {"office-exact", scene("office", none, 4, 320), 0.0, 0.0, 0.001},
      {"desk-coarse", scene("desk", kinect1, 5), 0.0, 0.2, 0.005},
      {"desk-bent", scene("desk", tof, 6), 0.01, 0.0, 0.0},
      {"stairs-holes", scene("stairs", stereo, 13), 0.0, 0.2, 0.0},
      {"boxes-bent", scene("boxes", kinect1, 8), 0.01, 0.0, 0.0},
      {"boxes-coarse", scene("boxes", none, 9, 320), 0.002, 0.1, 0.003},
      {"hall-holes", scene("hall", kinect1, 10), 0.0, 0.1, 0.0},
      {"hall-far", scene("hall", stereo, 3), 0.0, 0.0, 0.0},
      {"desk-filled", scene("desk", kinect1, 14), 0.0, 0.0, 0.0, 3.0},
      {"curved", scene("curved", tof, 11, 320), 0.0, 0.0, 0.0},
      {"corridor-large", scene("corridor", stereo, 12, 1280), 0.01, 0.1, 0.0},
  };
}

/// Depth as the camera hands it out. Where nothing is measured, nothing is judged.
void wear(const Rendering& rendering, synth::SynthFrame& frame) {
  const Camera& camera = frame.camera;
  constexpr int kBlotch_px = 12;
  const int columns = camera.width / kBlotch_px + 1;
  std::vector<double> lost(static_cast<std::size_t>(columns) * static_cast<std::size_t>(camera.height / kBlotch_px + 1));
  RandomStream random(rendering.synth.seed, 3);
  for (double& value : lost) value = random.uniform();
  const double half_diagonal = 0.5 * std::hypot(camera.width, camera.height);
  const double unit_m = 1.0 / camera.depth_scale;
  const double step_m = std::max(rendering.step_m, unit_m);
  std::size_t i = 0;
  for (int v = 0; v < camera.height; ++v) {
    for (int u = 0; u < camera.width; ++u, ++i) {
      if (frame.depth[i] == 0 && rendering.fill_m == 0.0) continue;
      const double from_middle = std::hypot(u - camera.cx, v - camera.cy) / half_diagonal;
      const double bent_m = frame.depth[i] * unit_m * (1.0 + rendering.bend * from_middle * from_middle);
      const double raw = std::round(std::round(bent_m / step_m) * step_m / unit_m);
      if (rendering.fill_m > 0.0 && 5 * u >= 4 * camera.width) {
        frame.depth[i] = static_cast<std::uint16_t>(std::round(rendering.fill_m / unit_m));
        frame.labels[i] = kLabelNoDepth;
        continue;
      }
      const bool hole = lost[static_cast<std::size_t>(v / kBlotch_px * columns + u / kBlotch_px)] < rendering.holes;
      frame.depth[i] = hole || raw > 65534.0 ? std::uint16_t{0} : static_cast<std::uint16_t>(raw);
      if (frame.depth[i] == 0) frame.labels[i] = kLabelNoDepth;
    }
  }
}

/// Mean angle between the planes that were found and the true ones that most of their pixels are on, degrees.
double mean_angle_deg(const synth::SynthFrame& frame, const Segmentation& s) {
  double sum = 0.0;
  double planes = 0.0;
  for (const PlaneSegment& found : s.planes) {
    std::array<std::uint64_t, 256> pixels{};
    for (std::size_t i = 0; i < s.labels.size(); ++i) pixels[frame.labels[i]] += s.labels[i] == found.id ? 1U : 0U;
    for (const auto& [label, plane] : frame.true_planes) {
      if (2 * pixels[static_cast<std::size_t>(label)] <= found.inliers) continue;
      sum += eval::plane_error(plane, found.plane).angle_rad * kDegrees;
      planes += 1.0;
    }
  }
  return planes > 0.0 ? sum / planes : 0.0;
}

TableRow measure(const Rendering& rendering) {
  TableRow row(kColumns.size(), testing::kEmpty);
  auto frame = synth::render(rendering.synth);
  if (!frame) {
    ADD_FAILURE() << frame.error().message;
    return row;
  }
  wear(rendering, *frame);
  const Segmentation s = testing::cells(testing::view_of(*frame), frame->camera);
  testing::expect_sane(s, testing::view_of(*frame));
  const auto dominant = eval::dominant_plane(frame->labels, s.labels);
  const auto metrics = eval::instance_metrics(frame->labels, s.labels);
  if (!dominant || !metrics) {
    ADD_FAILURE() << rendering.name;
    return row;
  }
  const auto planes = static_cast<double>(s.planes.size());
  double on_planes = 0.0;
  double sigma_rad = 0.0;
  double rms_m = 0.0;
  double confidence = 0.0;
  for (const PlaneSegment& plane : s.planes) {
    on_planes += static_cast<double>(plane.inliers) / static_cast<double>(s.labels.size());
    sigma_rad += std::sqrt(plane.covariance.topLeftCorner<3, 3>().trace()) / planes;
    rms_m += plane.rms_m / planes;
    confidence += plane.confidence / planes;
  }
  const double slow = (s.slow_noise.constant_m + s.slow_noise.quadratic_per_m) / (s.noise.constant_m + s.noise.quadratic_per_m);
  row = {planes,
         dominant->f1(),
         metrics->at50.f1,
         metrics->at75.f1,
         metrics->weighted_iou,
         metrics->plane_pixel_f1,
         on_planes,
         mean_angle_deg(*frame, s),
         sigma_rad * kDegrees,
         1e3 * rms_m,
         confidence,
         1e3 * s.noise.constant_m,
         1e3 * s.noise.quadratic_per_m,
         slow,
         1e3 * s.bias_m};
  return row;
}

class CellsRendered : public ::testing::TestWithParam<Rendering> {};

TEST_P(CellsRendered, KeepsItsNumbers) {
  const Rendering& rendering = GetParam();
  const std::string name(rendering.name);
  const testing::VersionedTable table(FRANSAC_RENDERED_CSV, "frame,sensor", {kColumns.begin(), kColumns.end()});
  table.compare(name, {{name + ',' + std::string(enum_name(rendering.synth.sensor)), measure(rendering)}}, kTolerance,
                kTolerance);
}

std::string name_of(const ::testing::TestParamInfo<Rendering>& test) {
  std::string name(test.param.name);
  std::replace(name.begin(), name.end(), '-', '_');
  return name + '_' + std::string(enum_name(test.param.synth.sensor));
}
INSTANTIATE_TEST_SUITE_P(Frames, CellsRendered, ::testing::ValuesIn(renderings()), name_of);

}  // namespace
}  // namespace fransac
