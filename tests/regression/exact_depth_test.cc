// SPDX-License-Identifier: Apache-2.0
// Depth without noise, in steps: a floor and a wall are found at any pitch and roll of the camera, whatever the sensor is said to
// be. Rounding is equal along rows where the camera does not roll, so it must not pass for the absence of noise.
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numbers>
#include <ostream>
#include <sstream>
#include <string>
#include <string_view>
#include <vector>

#include "fransac/planes/segment.hpp"
#include "instance_score.hpp"
#include "support.hpp"

namespace fransac::testing {
namespace {

constexpr double kHeight_m = 1.2;   // of the camera above the floor
constexpr double kWall_m = 3.0;     // ahead, horizontally
constexpr double kMinShare = 0.02;  // of the pixels: what is seen of a plane that must be found
constexpr double kMinIou = 0.9;
constexpr double kMaxFalseShare = 0.005;

struct View {
  double pitch_deg = 0.0;  ///< Downwards.
  double roll_deg = 0.0;
};

/// How depth is stored.
struct Storage {
  std::string_view name;
  double depth_scale = 1000.0;
  double step_m = 0.001;
};

void PrintTo(const Storage& storage, std::ostream* out) { *out << storage.name; }

struct Scene {
  Camera camera;
  std::vector<std::uint16_t> depth;
  std::vector<std::uint8_t> truth;  ///< 1 the floor, 2 the wall.
  std::array<double, 2> share{};    ///< Of them.
};

Camera camera_of(int width, const Storage& storage) {
  const int height = width * 3 / 4;
  const double f = 525.0 * width / 640.0;
  return {width, height, f, f, 0.5 * (width - 1), 0.5 * (height - 1), storage.depth_scale};
}

Scene floor_and_wall(const View& view, const Storage& storage, int width) {
  const auto radians = [](double degrees) { return degrees * std::numbers::pi / 180.0; };
  // From the camera's frame (x right, y down) into one with level axes.
  const Eigen::Matrix3d level = (Eigen::AngleAxisd(-radians(view.pitch_deg), Eigen::Vector3d::UnitX()) *
                                 Eigen::AngleAxisd(radians(view.roll_deg), Eigen::Vector3d::UnitZ()))
                                    .toRotationMatrix();
  Scene scene;
  scene.camera = camera_of(width, storage);
  for (int v = 0; v < scene.camera.height; ++v) {
    for (int u = 0; u < scene.camera.width; ++u) {
      const Eigen::Vector3d direction = level * ray(scene.camera, u, v);
      const double floor = direction.y() > 0.0 ? kHeight_m / direction.y() : HUGE_VAL;
      const double wall = direction.z() > 0.0 ? kWall_m / direction.z() : HUGE_VAL;
      const double z = std::min(floor, wall);
      const double raw = std::round(std::round(z / storage.step_m) * storage.step_m * storage.depth_scale);
      const bool seen = raw < 65535.0;
      scene.depth.push_back(seen ? static_cast<std::uint16_t>(raw) : std::uint16_t{0});
      scene.truth.push_back(seen ? static_cast<std::uint8_t>(floor < wall ? 1 : 2) : std::uint8_t{0});
      if (seen) scene.share[floor < wall ? 0 : 1] += 1.0 / (static_cast<double>(width) * scene.camera.height);
    }
  }
  return scene;
}

/// What is wrong with the answer; empty where nothing is.
std::string complaint(const Scene& scene, const std::vector<std::uint8_t>& labels) {
  const auto pixels = static_cast<double>(labels.size());
  std::array<std::array<double, 256>, 3> both{};
  std::array<double, 256> predicted{};
  for (std::size_t i = 0; i < labels.size(); ++i) {
    if (scene.truth[i] == 0) continue;
    both[scene.truth[i]][labels[i]] += 1.0 / pixels;
    predicted[labels[i]] += 1.0 / pixels;
  }
  std::ostringstream text;
  std::array<std::size_t, 2> own{};
  for (const std::size_t t : {1U, 2U}) {
    if (scene.share[t - 1] < kMinShare) continue;
    double best = 0.0;
    for (std::size_t p = kLabelFirst; p < kLabelNoPlane; ++p) {
      if (predicted[p] <= 0.0) continue;
      const double iou = both[t][p] / (scene.share[t - 1] + predicted[p] - both[t][p]);
      if (iou > best) {
        best = iou;
        own[t - 1] = p;
      }
    }
    if (best < kMinIou) text << (t == 1 ? " floor IoU " : " wall IoU ") << best << " of " << scene.share[t - 1];
  }
  for (std::size_t p = kLabelFirst; p < kLabelNoPlane; ++p) {
    // A plane that must not be found for being small may be found.
    const bool small = both[1][p] + both[2][p] > 0.0 && scene.share[both[1][p] > both[2][p] ? 0 : 1] < kMinShare;
    if (p != own[0] && p != own[1] && !small && predicted[p] > kMaxFalseShare) text << " a further plane of " << predicted[p];
  }
  return text.str();
}

class ExactDepth : public ::testing::TestWithParam<Storage> {};

TEST_P(ExactDepth, FloorAndWallAtAnyPitchAndRoll) {
  const Storage& storage = GetParam();
  Workspace workspace;
  Segmentation found;
  int cases = 0;
  int wrong = 0;
  std::ostringstream first;
  for (const int width : {640, 320}) {
    for (const double pitch : {0.0, 10.0, 20.0, 30.0, 40.0, 50.0, 60.0}) {
      for (const double roll : {-20.0, -9.0, 0.0, 3.0, 20.0}) {
        const Scene scene = floor_and_wall({pitch, roll}, storage, width);
        const DepthView view =
            DepthView::from_uint16(scene.depth.data(), scene.camera.width, scene.camera.height, storage.depth_scale);
        for (const SensorKind kind : {SensorKind::automatic, SensorKind::none, SensorKind::time_of_flight, SensorKind::stereo}) {
          SegmentOptions options;
          options.method = Method::cells;
          options.sensor.kind = kind;
          const Status status = segment(view, scene.camera, options, workspace, found);
          ASSERT_TRUE(status) << status.error().message;
          ++cases;
          const std::string text = complaint(scene, found.labels);
          if (text.empty()) continue;
          if (++wrong <= 10) {
            first << "\n  " << width << " columns, pitch " << pitch << ", roll " << roll << ", sensor " << enum_name(kind) << ':'
                  << text;
          }
        }
      }
    }
  }
  // A floor that is 6 % of the frame and seen at a grazing angle is missed in one case: 320 columns, level, taken for stereo.
  EXPECT_LE(wrong, 1) << "of " << cases << " cases; the first:" << first.str();
}

INSTANTIATE_TEST_SUITE_P(Steps, ExactDepth,
                         ::testing::Values(Storage{"MillimetreUnits", 1000.0, 0.001},
                                           Storage{"TenthsOfMillimetres", 10000.0, 0.0001},
                                           Storage{"MillimetreSteps", 5000.0, 0.001},
                                           Storage{"FiveMillimetreSteps", 1000.0, 0.005},
                                           Storage{"FiveMillimetreUnits", 200.0, 0.005}),
                         [](const auto& test) { return std::string(test.param.name); });

}  // namespace
}  // namespace fransac::testing
