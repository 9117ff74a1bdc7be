// SPDX-License-Identifier: Apache-2.0
// How often a low box on the floor is found. Usage: bench_low_obstacles [RENDERINGS]; one JSON line per distance, footprint and
// height.
//
// A Kinect v1 0.7 m above the floor, as on a small robot, looks at three boxes beside each other some way off; behind them there
// is a wall. In each rendering the boxes lie a little elsewhere and are turned otherwise. One is found when one obstacle holds at
// least half of its pixels and consists of it by half: the wall and stray noise do not count.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <numbers>
#include <vector>

#include "fransac/obstacles/obstacles.hpp"
#include "fransac/planes/segment.hpp"
#include "synth/builder.hpp"
#include "synth/scenes.hpp"
#include "synth/sensors.hpp"

namespace fransac::bench {
namespace {

using synth::detail::Builder;
using synth::detail::Dice;

constexpr double kEye_m = 0.7;
constexpr double kDistances_m[] = {1.0, 2.0, 3.0};  ///< From the camera to the middle box's base.
constexpr double kFootprints_m[] = {0.20, 0.05};
constexpr double kHighest_m = 0.3;
constexpr double kStep = 1.25;        ///< From one height to the next.
constexpr double kSureShare = 0.995;  ///< Where two heights in a row are found as often, higher ones need no look.
constexpr std::size_t kSureHeights = 2;
constexpr int kBoxes = 3;
constexpr double kApart = 0.35;  ///< From one box to the next, a share of the distance: all are in the picture.
const Camera kCamera{640, 480, 525.0, 525.0, 319.5, 239.5, 1000.0};  ///< Depth in millimetres, as drivers give it.

struct Setting {
  double distance_m = 0.0;
  double footprint_m = 0.0;
  double height_m = 0.0;
};

struct Picture {
  std::vector<std::uint16_t> depth;
  std::vector<std::uint8_t> box;  ///< 0: none.
  std::vector<std::uint8_t> is_floor;
};

/// Solids in the order floor, wall, boxes.
synth::detail::Scene build(const Setting& setting, Dice& dice) {
  Builder b;
  b.fixture();
  b.level({Eigen::Vector2d(-4.0, -1.0), Eigen::Vector2d(4.0, 5.0)}, 0.0, {});
  b.fixture();
  b.upright({-4.0, 5.0}, {4.0, 5.0}, 0.0, 3.0, {});
  const double ahead = setting.distance_m > kEye_m ? std::sqrt(setting.distance_m * setting.distance_m - kEye_m * kEye_m) : 0.0;
  constexpr double kAside = 0.05;  // of the distance, to either side
  for (int i = 0; i < kBoxes; ++i) {
    const double x = setting.distance_m * (kApart * (i - kBoxes / 2) + dice.between(-kAside, kAside));
    const double yaw = dice.between(0.0, std::numbers::pi);
    b.object();
    b.box(synth::detail::standing(x, ahead, 0.0, yaw), {setting.footprint_m, setting.footprint_m, setting.height_m}, {});
  }
  return b.finish();
}

Picture render(const Setting& setting, std::uint64_t seed) {
  Dice dice(seed, synth::detail::stream_index(synth::detail::Purpose::scene));
  synth::detail::Scene scene = build(setting, dice);
  const Eigen::Vector3d box = scene.primitives.back().pose.translation();
  const double above = dice.between(-0.1, 0.1);  // where it looks, so that the boxes are not always in the same rows
  scene.move_to(synth::detail::looking({0.0, 0.0, kEye_m}, {0.0, box.y(), above * setting.distance_m}).inverse());
  const synth::detail::Raster raster = synth::detail::rasterise(scene, kCamera);
  const synth::detail::Measurement measured = synth::detail::measure(synth::Sensor::kinect1, scene, kCamera, raster, seed, 0);
  Picture picture;
  for (std::size_t i = 0; i < raster.primitive.size(); ++i) {
    const double units = std::round(measured.depth_m[i] * kCamera.depth_scale);
    picture.depth.push_back(static_cast<std::uint16_t>(units));
    picture.box.push_back(units > 0.0 && raster.primitive[i] > 1 ? static_cast<std::uint8_t>(raster.primitive[i] - 1) : 0);
    picture.is_floor.push_back(raster.primitive[i] == 0 ? 1 : 0);
  }
  return picture;
}

struct Judgement {
  int found = 0;
  int false_alarms = 0;  ///< Obstacles on the floor, by half or more.
};

Judgement judge(const Picture& picture, const Obstacles& found) {
  using Counts = std::array<std::uint64_t, kBoxes + 1>;
  std::vector<Counts> on_box(found.obstacles.size() + 1);  // by obstacle; 0 is none
  std::vector<std::uint64_t> on_floor(found.obstacles.size() + 1, 0);
  Counts pixels{};
  for (std::size_t i = 0; i < picture.depth.size(); ++i) {
    ++pixels[picture.box[i]];
    ++on_box[found.labels[i]][picture.box[i]];
    on_floor[found.labels[i]] += picture.is_floor[i];
  }
  const auto holds = [&](const Obstacle& obstacle, std::size_t box) {
    const std::uint64_t both = on_box[static_cast<std::size_t>(obstacle.id)][box];
    return obstacle.kind != ObstacleKind::drop && both > 0 && 2 * both >= pixels[box] && 2 * both >= obstacle.pixels;
  };
  Judgement judgement;
  for (std::size_t box = 1; box <= kBoxes; ++box) {
    const auto holds_it = [&](const Obstacle& obstacle) { return holds(obstacle, box); };
    judgement.found += std::any_of(found.obstacles.begin(), found.obstacles.end(), holds_it) ? 1 : 0;
  }
  for (const Obstacle& obstacle : found.obstacles) {
    judgement.false_alarms += 2 * on_floor[static_cast<std::size_t>(obstacle.id)] > obstacle.pixels ? 1 : 0;
  }
  return judgement;
}

/// The share of the boxes that were found. Writes a line.
double measure(const Setting& setting, int renderings) {
  SegmentOptions options;
  options.method = Method::cells;
  Workspace workspace;
  ObstacleWorkspace obstacle_workspace;
  Segmentation planes;
  Obstacles found;
  int detected = 0;
  int false_alarms = 0;
  for (int i = 0; i < renderings; ++i) {
    const Picture picture = render(setting, static_cast<std::uint64_t>(i));
    const DepthView depth = DepthView::from_uint16(picture.depth.data(), kCamera.width, kCamera.height, kCamera.depth_scale);
    if (!segment(depth, kCamera, options, workspace, planes)) continue;
    if (!find_obstacles(depth, kCamera, planes, {}, nullptr, obstacle_workspace, found)) continue;
    const Judgement judgement = judge(picture, found);
    detected += judgement.found;
    false_alarms += judgement.false_alarms;
  }
  std::printf(
      "{\"distance_m\": %g, \"footprint_m\": %g, \"height_m\": %.5f, \"renderings\": %d, \"boxes\": %d, \"detected\": %d, "
      "\"false_alarms\": "
      "%d}\n",
      setting.distance_m, setting.footprint_m, setting.height_m, renderings, kBoxes * renderings, detected, false_alarms);
  std::fflush(stdout);
  return static_cast<double>(detected) / (kBoxes * renderings);
}

/// A little below the height that one pixel tells from the floor: height_sigmas of z (n . r) with n . r = eye / z.
double lowest_m(double distance_m) {
  return 0.8 * ObstacleOptions{}.height_sigmas * synth::detail::kinect1::kSigma * distance_m * kEye_m;
}

void measure_all(int renderings) {
  for (const double footprint : kFootprints_m) {
    for (const double distance : kDistances_m) {
      std::size_t sure = 0;
      for (double height = lowest_m(distance); height <= kHighest_m && sure < kSureHeights; height *= kStep) {
        sure = measure({distance, footprint, height}, renderings) >= kSureShare ? sure + 1 : 0;
      }
    }
  }
}

}  // namespace
}  // namespace fransac::bench

int main(int argc, char** argv) {
  try {
    const int renderings = argc > 1 ? std::atoi(argv[1]) : 100;
    if (argc > 2 || renderings < 1) {
      std::fprintf(stderr, "usage: bench_low_obstacles [RENDERINGS]\n");
      return 2;
    }
    fransac::bench::measure_all(renderings);
    return 0;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "bench_low_obstacles: %s\n", error.what());
    return 1;
  }
}
