// SPDX-License-Identifier: Apache-2.0
#include "fransac/synth/synth.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numbers>

#include "fransac/core/labels.hpp"
#include "synth/builder.hpp"
#include "synth/geometry.hpp"
#include "synth/scenes.hpp"
#include "synth/sensors.hpp"
#include "synth/things.hpp"
#include "synth/walk.hpp"

namespace fransac::synth {
namespace {

using detail::Builder;
using detail::Hit;
using detail::intersect;
using detail::kMiss;
using detail::Scene;
using detail::Shape;
using Eigen::Isometry3d;
using Eigen::Vector3d;
using std::numbers::pi;
using ::testing::HasSubstr;

constexpr std::array kSensors{Sensor::none, Sensor::kinect1, Sensor::stereo, Sensor::tof};
const Camera kSmall{160, 120, 131.25, 131.25, 79.5, 59.5, 5000.0};

std::size_t index(int i) { return static_cast<std::size_t>(i); }

// ---- Rays and solids, closed forms.

void expect_hit(const Hit& hit, double t, int face) {
  EXPECT_NEAR(hit.t, t, 1e-12);
  EXPECT_EQ(hit.face, face);
}

TEST(Intersect, Sphere) {
  const Vector3d r2 = Vector3d::Constant(2.0);
  expect_hit(intersect(Shape::sphere, r2, {-5, 0, 0}, {1, 0, 0}), 3.0, 0);
  expect_hit(intersect(Shape::sphere, r2, {-5, 0, 0}, {0.5, 0, 0}), 6.0, 0);                 // t counts in direction lengths
  expect_hit(intersect(Shape::sphere, r2, {-5, 1, 0}, {1, 0, 0}), 5.0 - std::sqrt(3.0), 0);  // a chord at distance 1
  expect_hit(intersect(Shape::sphere, r2, {0, 0, 0}, {0, 0, 1}), 2.0, 0);                    // from inside: out
  EXPECT_EQ(intersect(Shape::sphere, r2, {-5, 2.001, 0}, {1, 0, 0}).t, kMiss);
  EXPECT_EQ(intersect(Shape::sphere, r2, {5, 0, 0}, {1, 0, 0}).t, kMiss);  // behind
}

TEST(Intersect, Box) {
  const Vector3d half(1, 2, 3);
  expect_hit(intersect(Shape::box, half, {-4, 0, 0}, {1, 0, 0}), 3.0, 0);
  expect_hit(intersect(Shape::box, half, {4, 0.5, 0}, {-1, 0, 0}), 3.0, 1);
  expect_hit(intersect(Shape::box, half, {0, -5, 0}, {0, 1, 0}), 3.0, 2);
  expect_hit(intersect(Shape::box, half, {0, 0, 7}, {0, 0, -2}), 2.0, 5);
  expect_hit(intersect(Shape::box, half, {-2, -2.5, 0}, {1, 1, 0}), 1.0, 0);  // x slab last
  expect_hit(intersect(Shape::box, half, {0, 0, 0}, {0, 1, 0}), 2.0, 3);      // from inside: out
  EXPECT_EQ(intersect(Shape::box, half, {-4, 2.1, 0}, {1, 0, 0}).t, kMiss);
  EXPECT_EQ(intersect(Shape::box, half, {-2, -5.1, 0}, {1, 1, 0}).t, kMiss);  // leaves x before it enters y
  EXPECT_EQ(intersect(Shape::box, half, {4, 0, 0}, {1, 0, 0}).t, kMiss);
}

TEST(Intersect, Cylinder) {
  const Vector3d half(1, 1, 2);
  expect_hit(intersect(Shape::cylinder, half, {-3, 0, 0}, {1, 0, 0}), 2.0, 0);
  expect_hit(intersect(Shape::cylinder, half, {-3, 0.6, 0}, {1, 0, 0}), 3.0 - 0.8, 0);
  expect_hit(intersect(Shape::cylinder, half, {0.5, 0, 5}, {0, 0, -1}), 3.0, 2);
  expect_hit(intersect(Shape::cylinder, half, {0.5, 0, -5}, {0, 0, 1}), 3.0, 1);
  expect_hit(intersect(Shape::cylinder, half, {-2, 0, 4}, {1, 0, -1}), 2.0, 2);    // through the top, at x = 0
  expect_hit(intersect(Shape::cylinder, half, {-2, 0, 2.5}, {1, 0, -1}), 1.0, 0);  // under its rim
  EXPECT_EQ(intersect(Shape::cylinder, half, {-3, 0, 2.1}, {1, 0, 0}).t, kMiss);
  EXPECT_EQ(intersect(Shape::cylinder, half, {1.1, 0, 5}, {0, 0, -1}).t, kMiss);
}

TEST(Intersect, Rectangle) {
  const Vector3d half(1, 2, 0);
  expect_hit(intersect(Shape::rectangle, half, {0.9, -1.9, -3}, {0, 0, 1}), 3.0, 0);
  expect_hit(intersect(Shape::rectangle, half, {-1, 0, 2}, {1, 0, -2}), 1.0, 0);
  EXPECT_EQ(intersect(Shape::rectangle, half, {1.1, 0, -3}, {0, 0, 1}).t, kMiss);
  EXPECT_EQ(intersect(Shape::rectangle, half, {0, 0, -3}, {0, 0, -1}).t, kMiss);
  EXPECT_EQ(intersect(Shape::rectangle, half, {0, 0, -3}, {1, 0, 0}).t, kMiss);
}

// ---- Scenes made by hand.

// A rectangle that faces the camera at depth z, turned about the y axis.
void add_wall(Builder& b, double x, double z, double width, double tilt = 0.0) {
  detail::Material material;
  material.texture = 1.0;
  b.object();
  b.rectangle(Eigen::Translation3d(x, 0.0, z) * Eigen::AngleAxisd(tilt, Vector3d::UnitY()), width, 40.0, material);
}

Scene finish(Builder& b) {
  Scene scene = b.finish();
  scene.move_to(Isometry3d::Identity());
  return scene;
}

TEST(Scene, CoplanarFacesOfOneObjectAreOnePlane) {
  Builder b;
  b.object();
  b.rectangle(Isometry3d(Eigen::Translation3d(-2, 0, 3)), 1, 1, {});
  b.rectangle(Eigen::Translation3d(2, 0, 3) * Eigen::AngleAxisd(pi, Vector3d::UnitX()), 1, 1, {});  // the other way round
  b.rectangle(Isometry3d(Eigen::Translation3d(0, 0, 3.001)), 1, 1, {});
  b.object();
  b.rectangle(Isometry3d(Eigen::Translation3d(0, 2, 3)), 1, 1, {});  // coplanar, but another thing
  const Scene scene = finish(b);
  EXPECT_THAT(scene.plane_of_face, ::testing::ElementsAre(0, 0, 1, 2));
  EXPECT_NEAR(scene.planes[0].d, 3.0, 1e-15);
  EXPECT_NEAR(scene.planes[0].normal.z(), -1.0, 1e-15);
}

TEST(Scene, BoxesAndCylindersHavePlanesAndSpheresHaveNone) {
  Builder b;
  b.object();
  b.box(Isometry3d(Eigen::Translation3d(0, 0, 3)), {1, 2, 1}, {});
  b.cylinder(Isometry3d(Eigen::Translation3d(3, 0, 3.5)), 0.5, 1.5, {});
  b.sphere(Isometry3d(Eigen::Translation3d(-3, 0, 3)), 0.5, {});
  const Scene scene = finish(b);
  EXPECT_THAT(scene.plane_of_face, ::testing::ElementsAre(0, 1, 2, 3, 4, 5, -1, 6, 7, -1));
  EXPECT_TRUE(scene.encloses({0.4, 0.9, 3.1}));
  EXPECT_FALSE(scene.encloses({0.4, 1.1, 3.1}));
  EXPECT_TRUE(scene.encloses({3.4, 0.2, 4.9}));
  EXPECT_FALSE(scene.encloses({3.4, 0.4, 4.9}));
}

struct Statistics {
  std::size_t n = 0;
  double sum = 0.0;
  double squares = 0.0;

  void add(double x) {
    ++n;
    sum += x;
    squares += x * x;
  }
  [[nodiscard]] double mean() const { return sum / static_cast<double>(n); }
  [[nodiscard]] double deviation() const { return std::sqrt(squares / static_cast<double>(n) - mean() * mean()); }
};

const Camera kNoiseCamera{320, 240, 262.5, 262.5, 159.5, 119.5, 5000.0};

// Errors are shared: of their variance 60 % within 7x7 pixels, 6 % within 41x41. So 76,800 pixels are worth about 1,570 and 46
// independent ones, and ten frames give the deviation to sqrt((0.60^2 / 1570 + 0.06^2 / 46) / 20) = 0.4 %, the mean to
// sqrt((0.60 / 1570 + 0.06 / 46) / 10) = 1.3 % of sigma: tolerances are five of them (the second order of 1/z is below 0.6 %
// of sigma up to 4 m). The wall is turned by 10 degrees so that all phases of the disparity lattice take part.
constexpr int kNoiseFrames = 10;
constexpr double kTurn = 10.0 * pi / 180.0;

TEST(Kinect1, NoiseFollowsKhoshelhamAndElberink) {
  for (const double z : {1.0, 2.0, 4.0}) {
    Builder b;
    add_wall(b, 0.0, z, 40.0, kTurn);
    const Scene scene = finish(b);
    const auto raster = detail::rasterise(scene, kNoiseCamera);
    Statistics noise;
    for (int frame = 0; frame < kNoiseFrames; ++frame) {
      const auto measured = detail::measure(Sensor::kinect1, scene, kNoiseCamera, raster, 7, frame);
      for (std::size_t i = 0; i < measured.depth_m.size(); ++i) {
        ASSERT_GT(measured.depth_m[i], 0.0);
        const double exact = raster.depth_m[i];
        noise.add((measured.depth_m[i] - exact) / (1.425e-3 * exact * exact));
      }
    }
    EXPECT_NEAR(noise.deviation(), 1.0, 0.02) << z << " m";
    EXPECT_NEAR(noise.mean(), 0.0, 0.065) << z << " m";
  }
}

// In steps of the disparity the error is a Gaussian field, of variance w within a window of 7 and g within one of 41, and the
// error of rounding, a sawtooth of it. The sawtooth's Fourier series gives the covariance of two rounding errors, over all phases
// of the lattice, where the values differ by a Gaussian of variance D: sum over k of exp(-2 pi^2 k^2 D) / (2 pi^2 k^2). (Down a
// column of this wall the exact values do not differ.)
TEST(Kinect1, NeighboursShareTheirErrors) {
  constexpr double kStep_px = 0.125;
  const double g = std::pow(0.015 / kStep_px, 2);
  const double total = std::pow(1.425e-3 * 580.0 * 0.075 / kStep_px, 2);
  const double w = total - 1.0 / 12.0 - g;
  const auto expected = [&](int lag) {
    const double covariance = w * std::max(0.0, 1.0 - lag / 7.0) + g * (1.0 - lag / 41.0);
    const double difference = 2.0 * (w + g - covariance);
    double rounding = 0.0;
    for (int k = 1; k <= 100; ++k) rounding += std::exp(-2.0 * pi * pi * k * k * difference) / (2.0 * pi * pi * k * k);
    return (covariance + rounding) / total;
  };
  EXPECT_NEAR(expected(0), 1.0, 0.005);  // the sum over 1 / k^2, cut off

  Builder b;
  add_wall(b, 0.0, 2.0, 40.0, kTurn);
  const Scene scene = finish(b);
  const auto raster = detail::rasterise(scene, kNoiseCamera);
  std::map<int, double> products;
  std::map<int, double> squares;
  for (int frame = 0; frame < kNoiseFrames; ++frame) {
    const auto measured = detail::measure(Sensor::kinect1, scene, kNoiseCamera, raster, 7, frame);
    std::vector<double> error;
    for (std::size_t i = 0; i < raster.depth_m.size(); ++i) error.push_back(1.0 / measured.depth_m[i] - 1.0 / raster.depth_m[i]);
    for (const int lag : {1, 2, 4, 8}) {
      const std::size_t down = index(lag * kNoiseCamera.width);
      for (std::size_t i = down; i < error.size(); ++i) {
        products[lag] += error[i] * error[i - down];
        squares[lag] += 0.5 * (error[i] * error[i] + error[i - down] * error[i - down]);
      }
    }
  }
  // 0.66, 0.49, 0.32, 0.05, each to about 1 % by the count of independent windows above.
  for (const auto& [lag, sum] : products) EXPECT_NEAR(sum / squares[lag], expected(lag), 0.04) << "lag " << lag;
}

TEST(Kinect1, DisparitiesAreMultiplesOfAnEighthOfAPixel) {
  SynthOptions options;
  options.scene = "office";
  options.camera = kSmall;
  const auto frame = render(options);
  ASSERT_TRUE(frame.ok());
  for (const std::uint16_t raw : frame->depth) {
    if (raw == 0) continue;
    const double z = raw / 5000.0;
    const double steps = 580.0 * 0.075 / z / 0.125;
    const double rounding = 0.5 / 5000.0 * steps / z;  // of raw depth, in steps
    EXPECT_NEAR(steps, std::round(steps), rounding * 1.001);
  }
}

// An edge at z1 before a wall at z2 hides f b (1/z1 - 1/z2) pixels of it from a projector at +b: to the left of the object.
TEST(Kinect1, ProjectorsShadowFallsToTheLeft) {
  Builder b;
  add_wall(b, 0.0, 1.0, 0.4);
  add_wall(b, 0.0, 2.0, 40.0);
  const Scene scene = finish(b);
  const auto raster = detail::rasterise(scene, kNoiseCamera);
  const auto measured = detail::measure(Sensor::kinect1, scene, kNoiseCamera, raster, 0, 0);
  const std::size_t row = index(120 * kNoiseCamera.width);
  int left = 0;
  int right = 0;
  for (int u = 0; u < kNoiseCamera.width; ++u) {
    if (measured.depth_m[row + index(u)] != 0.0) continue;
    EXPECT_NEAR(raster.depth_m[row + index(u)], 2.0, 1e-12);
    (u < 160 ? left : right) += 1;
  }
  EXPECT_NEAR(left, 262.5 * 0.075 * (1.0 - 0.5), 1.0);
  EXPECT_EQ(right, 0);
}

TEST(Kinect1, MeasuresNothingOutOfRangeOrAtGrazingAngles) {
  const auto valid_pixels = [](double z, double tilt) {
    Builder b;
    add_wall(b, 0.0, z, 80.0, tilt);
    const Scene scene = finish(b);
    const Camera narrow{32, 32, 2000.0, 2000.0, 15.5, 15.5, 5000.0};
    const auto measured = detail::measure(Sensor::kinect1, scene, narrow, detail::rasterise(scene, narrow), 0, 0);
    return std::count_if(measured.depth_m.begin(), measured.depth_m.end(), [](double d) { return d > 0.0; });
  };
  EXPECT_EQ(valid_pixels(0.45, 0.0), 0);
  EXPECT_EQ(valid_pixels(2.0, 0.0), 32 * 32);
  EXPECT_EQ(valid_pixels(8.5, 0.0), 0);
  EXPECT_EQ(valid_pixels(2.0, 70.0 * pi / 180.0), 32 * 32);
  EXPECT_EQ(valid_pixels(2.0, 87.0 * pi / 180.0), 0);
}

// Errors within a window are common: 76,800 pixels are worth about 76,800 / 49 independent ones, the deviation's standard
// error is 1.8 %. Correlation over one column: 1 - 1/7. To the left of column f b / z the right eye sees nothing.
TEST(Stereo, DisparityErrorIsSmoothAndLeftBorderIsBlind) {
  Builder b;
  add_wall(b, 0.0, 1.0, 40.0);
  const Scene scene = finish(b);
  const auto raster = detail::rasterise(scene, kNoiseCamera);
  const auto measured = detail::measure(Sensor::stereo, scene, kNoiseCamera, raster, 3, 0);
  const double disparity = 262.5 * 0.05;
  Statistics error;
  double neighbours = 0.0;
  for (int v = 0; v < kNoiseCamera.height; ++v) {
    double previous = 0.0;
    for (int u = 0; u < kNoiseCamera.width; ++u) {
      const double z = measured.depth_m[index(v * kNoiseCamera.width + u)];
      if (u < disparity) {
        EXPECT_EQ(z, 0.0);
        continue;
      }
      ASSERT_GT(z, 0.0);
      const double e = (disparity / z - disparity) / 0.08;
      error.add(e);
      neighbours += e * previous;
      previous = e;
    }
  }
  EXPECT_NEAR(error.deviation(), 1.0, 0.09);
  EXPECT_NEAR(neighbours / error.squares, 1.0 - 1.0 / 7.0, 0.02);
}

TEST(TimeOfFlight, NoiseFollowsAmplitude) {
  for (const double z : {1.0, 2.0, 4.0}) {
    Builder b;
    add_wall(b, 0.0, z, 80.0);
    const Scene scene = finish(b);
    const auto raster = detail::rasterise(scene, kNoiseCamera);
    const auto measured = detail::measure(Sensor::tof, scene, kNoiseCamera, raster, 5, 0);
    Statistics noise;
    for (int v = 1; v + 1 < kNoiseCamera.height; ++v) {
      for (int u = 1; u + 1 < kNoiseCamera.width; ++u) {
        const std::size_t i = index(v * kNoiseCamera.width + u);
        const double length = detail::pixel_ray(kNoiseCamera, u, v).norm();
        const double range = z * length;
        const double amplitude = 0.7 * (1.0 / length) / (range * range);  // albedo, cosine, distance
        EXPECT_EQ(measured.mixed[i], 0);
        noise.add((measured.depth_m[i] - z) * length / (1e-3 * std::sqrt(amplitude + 0.02) / amplitude));
      }
    }
    EXPECT_NEAR(noise.deviation(), 1.0, 0.02) << z << " m";
  }
}

TEST(TimeOfFlight, PixelsAtAnEdgeFlyAndSaySo) {
  Builder b;
  add_wall(b, 0.0, 1.0, 0.4);
  add_wall(b, 0.0, 3.0, 80.0);
  const Scene scene = finish(b);
  const auto raster = detail::rasterise(scene, kNoiseCamera);
  const auto measured = detail::measure(Sensor::tof, scene, kNoiseCamera, raster, 0, 0);
  const std::size_t row = index(120 * kNoiseCamera.width);
  const int edge = 107;  // the first column on the near wall: 159.5 - 262.5 * 0.2 = 107.0
  ASSERT_EQ(raster.depth_m[row + index(edge)], 1.0);
  ASSERT_EQ(raster.depth_m[row + index(edge - 1)], 3.0);
  const double flying = measured.depth_m[row + index(edge - 1)];
  EXPECT_GT(flying, 1.0);
  EXPECT_LT(flying, 2.9);
  EXPECT_EQ(measured.mixed[row + index(edge - 1)], 1);
  EXPECT_EQ(measured.mixed[row + index(edge - 3)], 0);
  EXPECT_NEAR(measured.depth_m[row + index(edge - 3)], 3.0, 0.05);
  EXPECT_EQ(measured.mixed[row + index(edge + 2)], 0);
  EXPECT_NEAR(measured.depth_m[row + index(edge + 2)], 1.0, 0.01);
}

// ---- Rendered scenes.

// What a scene has at least: planes, and valid pixels (percent) by sensor.
const std::map<std::string_view, std::size_t> kLeastPlanes{{"empty_room", 3}, {"desk", 3}, {"stairs", 5},
                                                           {"corridor", 4},   {"kerb", 3}, {"office", 6},
                                                           {"boxes", 5},      {"hall", 5}, {"curved", 0}};
const std::map<Sensor, double> kLeastValid{
    {Sensor::none, 95.0}, {Sensor::kinect1, 70.0}, {Sensor::stereo, 70.0}, {Sensor::tof, 75.0}};

Vector3d point(const SynthFrame& frame, std::size_t pixel) {
  const auto width = index(frame.camera.width);
  return static_cast<double>(frame.exact_depth_m[pixel]) *
         detail::pixel_ray(frame.camera, static_cast<double>(pixel % width), static_cast<double>(pixel / width));
}

void expect_exact_truth(const SynthFrame& frame) {
  std::map<int, Plane> planes;
  for (const auto& [label, plane] : frame.true_planes) {
    EXPECT_EQ(label, static_cast<int>(planes.size()) + 1);  // 1, 2, 3 … in order
    EXPECT_NEAR(plane.normal.norm(), 1.0, 1e-12);
    EXPECT_GE(plane.d, 0.0);
    planes.emplace(label, plane);
  }
  std::map<int, double> square_metres;
  for (std::size_t i = 0; i < frame.labels.size(); ++i) {
    const int label = frame.labels[i];
    if (frame.depth[i] == 0) {
      ASSERT_EQ(label, kLabelNoDepth);
    }
    if (label == kLabelNoDepth || label == kLabelNoPlane) continue;
    ASSERT_TRUE(planes.contains(label)) << label;
    ASSERT_NEAR(planes.at(label).signed_distance(point(frame, i)), 0.0, 1e-6);
    const double z = static_cast<double>(frame.exact_depth_m[i]);
    square_metres[label] += z * z * z / (planes.at(label).d * frame.camera.fx * frame.camera.fy);
  }
  ASSERT_EQ(square_metres.size(), planes.size());
  for (std::size_t label = 1; label < planes.size(); ++label) {
    EXPECT_GE(square_metres[static_cast<int>(label)] * (1.0 + 1e-5), square_metres[static_cast<int>(label) + 1]);
  }
}

TEST(Render, TruthIsExactInEveryScene) {
  for (const std::string_view scene : scene_names()) {
    for (const Sensor sensor : kSensors) {
      for (const std::uint64_t seed : {11U, 12U}) {
        SCOPED_TRACE(std::string(scene) + ", sensor " + std::to_string(static_cast<int>(sensor)) + ", seed " +
                     std::to_string(seed));
        const auto frame = render({.scene = std::string(scene), .sensor = sensor, .seed = seed, .frame = 60, .camera = kSmall});
        ASSERT_TRUE(frame.ok()) << frame.error().message;
        EXPECT_EQ(frame->colour.size(), 3 * frame->depth.size());
        EXPECT_GE(frame->true_planes.size(), kLeastPlanes.at(scene));
        const auto invalid = std::count(frame->depth.begin(), frame->depth.end(), 0);
        EXPECT_GE(100.0 * (1.0 - static_cast<double>(invalid) / static_cast<double>(frame->depth.size())),
                  kLeastValid.at(sensor));
        expect_exact_truth(*frame);
      }
    }
  }
}

TEST(Render, CurvedHasNoPlaneForAnySeed) {
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    const auto frame = render({.scene = "curved", .sensor = Sensor::none, .seed = seed, .camera = kSmall});
    ASSERT_TRUE(frame.ok());
    EXPECT_TRUE(frame->true_planes.empty());
    for (std::size_t i = 0; i < frame->labels.size(); ++i) {
      ASSERT_EQ(frame->labels[i], frame->depth[i] == 0 ? kLabelNoDepth : kLabelNoPlane) << "seed " << seed;
    }
  }
}

// Planes of the same direction and the steps between them, in metres, of the larger planes of a scene.
bool has_step(const SynthFrame& frame, double least, double most) {
  for (const auto& [label, plane] : frame.true_planes) {
    for (const auto& [other_label, other] : frame.true_planes) {
      const double step = plane.d - other.d;
      if (plane.normal.dot(other.normal) > 1.0 - 1e-9 && step >= least && step <= most) return true;
    }
  }
  return false;
}

TEST(Render, BoxesHaveALowLidAndHallsHaveDoorsSetBack) {
  for (std::uint64_t seed = 0; seed < 10; ++seed) {
    const auto boxes = render({.scene = "boxes", .sensor = Sensor::none, .seed = seed, .camera = kSmall});
    const auto hall = render({.scene = "hall", .sensor = Sensor::none, .seed = seed, .camera = kSmall});
    ASSERT_TRUE(boxes.ok() && hall.ok());
    EXPECT_TRUE(has_step(*boxes, 0.02 - 1e-9, 0.04 + 1e-9)) << "seed " << seed;
    EXPECT_TRUE(has_step(*hall, 0.05, 0.12)) << "seed " << seed;
    const auto farthest = *std::max_element(hall->exact_depth_m.begin(), hall->exact_depth_m.end());
    EXPECT_GT(farthest, 8.0F) << "seed " << seed;
  }
}

TEST(Render, ExactSensorOnlyRounds) {
  const auto frame = render({.scene = "desk", .sensor = Sensor::none, .seed = 2, .camera = kSmall});
  ASSERT_TRUE(frame.ok());
  for (std::size_t i = 0; i < frame->depth.size(); ++i) {
    EXPECT_NEAR(frame->depth[i] / 5000.0, static_cast<double>(frame->exact_depth_m[i]), 0.5 / 5000.0 + 1e-6);
  }
}

TEST(Render, DepthThatDoesNotFitIsNoMeasurement) {
  Camera camera = kSmall;
  camera.depth_scale = 30000.0;  // up to 2.18 m
  const auto frame = render({.scene = "empty_room", .sensor = Sensor::none, .seed = 0, .camera = camera});
  ASSERT_TRUE(frame.ok());
  for (std::size_t i = 0; i < frame->depth.size(); ++i) {
    const double exact = static_cast<double>(frame->exact_depth_m[i]);
    if (exact > 65536.0 / 30000.0) {
      EXPECT_EQ(frame->depth[i], 0);
    }
  }
}

TEST(Render, SameOptionsSameBytes) {
  for (const Sensor sensor : kSensors) {
    const SynthOptions options{.scene = "office", .sensor = sensor, .seed = 5, .frame = 3, .camera = kSmall};
    const auto once = render(options);
    const auto twice = render(options);
    ASSERT_TRUE(once.ok() && twice.ok());
    EXPECT_EQ(once->depth, twice->depth);
    EXPECT_EQ(once->exact_depth_m, twice->exact_depth_m);
    EXPECT_EQ(once->labels, twice->labels);
    EXPECT_EQ(once->colour, twice->colour);
    SynthOptions other = options;
    other.seed = 6;
    EXPECT_NE(render(other)->depth, once->depth);
    other = options;
    other.frame = 4;
    EXPECT_NE(render(other)->depth, once->depth);
  }
}

TEST(Render, SensorChangesTheMeasurementOnly) {
  SynthOptions options{.scene = "desk", .sensor = Sensor::none, .seed = 9, .camera = kSmall};
  const auto exact = render(options);
  options.sensor = Sensor::kinect1;
  const auto kinect = render(options);
  ASSERT_TRUE(exact.ok() && kinect.ok());
  EXPECT_EQ(exact->exact_depth_m, kinect->exact_depth_m);
  EXPECT_EQ(exact->colour, kinect->colour);
}

TEST(Render, CameraMovesSlowlyAndStaysOutOfThings) {
  for (const std::string_view name : scene_names()) {
    for (std::uint64_t seed = 0; seed < 30; ++seed) {
      const detail::Stage stage = detail::find_scene(name)(seed);
      for (int frame = 0; frame < 240; frame += 40) {
        const Vector3d camera = detail::camera_pose(stage, seed, frame).translation();
        const Vector3d next = detail::camera_pose(stage, seed, frame + 1).translation();
        EXPECT_LT((next - camera).norm(), 0.03) << name << " seed " << seed << " frame " << frame;
        EXPECT_FALSE(stage.scene.encloses(camera)) << name << " seed " << seed << " frame " << frame;
        const detail::RayCaster caster(stage.scene, camera);
        for (const double sign : {-1.0, 1.0}) {
          for (int axis = 0; axis < 3; ++axis) {  // nothing within 15 cm
            EXPECT_FALSE(caster.blocked(camera + 0.15 * sign * Vector3d::Unit(axis)))
                << name << " seed " << seed << " frame " << frame;
          }
        }
      }
    }
  }
}

// ---- Objects.

TEST(Things, BoxesAreTightAndStandOnWhatHasNoId) {
  Builder b;
  b.fixture();
  b.box(detail::standing(0.0, 0.0, 0.0, 0.0), {4.0, 4.0, 0.7}, {});  // a table top at 0.7
  b.object();
  b.box(detail::standing(0.5, 0.2, 0.7, 0.4), {0.3, 0.2, 0.1}, {});
  b.object();  // upon the first
  b.cylinder(detail::standing(0.5, 0.2, 0.8, 1.0), 0.05, 0.12, {});
  b.object();
  b.sphere(detail::standing(-0.5, 0.2, 0.75, 0.0), 0.1, {});  // 5 cm above the table
  b.object();                                                 // beside the table: nothing below
  b.box(detail::standing(9.0, 0.0, 0.0, 0.0), {1.0, 1.0, 1.0}, {});
  b.object();  // in an L
  b.box(detail::standing(-1.0, -1.0, 0.7, 0.0), {0.4, 0.1, 0.3}, {});
  b.box(detail::standing(-0.9, -0.8, 0.7, 0.0), {0.1, 0.3, 0.1}, {});
  Scene scene = b.finish();
  const Isometry3d camera = Eigen::Translation3d(0.3, -2.0, 1.9) * Eigen::AngleAxisd(0.3, Vector3d(1, 2, 3).normalized());
  scene.move_to(camera.inverse());
  const auto things = detail::things_of(scene);
  ASSERT_EQ(things.size(), 5U);
  const auto expect_thing = [&](int id, const Vector3d& world_centre, const Vector3d& size, double lowest, double highest) {
    const TrueObject& thing = things[index(id - 1)];
    EXPECT_EQ(thing.id, id);
    EXPECT_NEAR((camera * thing.box.centre - world_centre).norm(), 0.0, 1e-12) << id;
    EXPECT_NEAR((thing.box.size - size).norm(), 0.0, 1e-12) << id;
    EXPECT_NEAR((camera.linear() * thing.box.up - Vector3d::UnitZ()).norm(), 0.0, 1e-12);
    EXPECT_NEAR(thing.box.up.dot(thing.box.along), 0.0, 1e-12);
    EXPECT_NEAR(thing.lowest_m, lowest, 1e-12) << id;
    EXPECT_NEAR(thing.highest_m, highest, 1e-12) << id;
  };
  expect_thing(1, {0.5, 0.2, 0.75}, {0.3, 0.2, 0.1}, 0.0, 0.1);
  expect_thing(2, {0.5, 0.2, 0.86}, {0.1, 0.1, 0.12}, 0.1, 0.22);
  expect_thing(3, {-0.5, 0.2, 0.85}, {0.2, 0.2, 0.2}, 0.05, 0.25);
  expect_thing(4, {9.0, 0.0, 0.5}, {1.0, 1.0, 1.0}, 0.0, 0.0);
  expect_thing(5, {-1.0, -0.85, 0.85}, {0.4, 0.4, 0.3}, 0.0, 0.3);
  EXPECT_FALSE(things[3].support);
  for (const std::size_t i : {0U, 1U, 2U, 4U}) {
    ASSERT_TRUE(things[i].support);
    EXPECT_NEAR(things[i].support->signed_distance(camera.inverse() * Vector3d(7.0, 8.0, 0.7)), 0.0, 1e-12);
  }
  // Two boxes of one support differ in yaw as in the world.
  EXPECT_NEAR(things[0].box.yaw_rad() - things[4].box.yaw_rad(), 0.4, 1e-12);
}

TEST(OrientedBox, YawCountsFromAheadOfTheCamera) {
  OrientedBox box;                              // up is -y of the camera
  EXPECT_NEAR(box.yaw_rad(), 0.5 * pi, 1e-15);  // across the view
  const auto turned = [&](double angle) {
    box.along = Eigen::AngleAxisd(angle, box.up) * Vector3d::UnitZ();
    return box.yaw_rad();
  };
  EXPECT_NEAR(turned(0.3), 0.3, 1e-15);
  EXPECT_NEAR(turned(-1.5), -1.5, 1e-15);
  EXPECT_NEAR(turned(2.0), 2.0 - pi, 1e-15);  // half a turn on
  box.up = -Vector3d::UnitZ();                // straight down: the image's upper edge is ahead
  box.along = -Vector3d::UnitY();
  EXPECT_EQ(box.yaw_rad(), 0.0);
}

// What each pixel sees of an object lies in the object's box, and only what is seen is listed.
TEST(Render, ObjectsLieInTheirBoxes) {
  for (const std::string_view scene : scene_names()) {
    for (const std::uint64_t seed : {1U, 2U, 3U}) {
      const auto frame = render({.scene = std::string(scene), .sensor = Sensor::none, .seed = seed, .camera = kSmall});
      ASSERT_TRUE(frame.ok());
      SCOPED_TRACE(std::string(scene) + ", seed " + std::to_string(seed));
      std::map<int, TrueObject> objects;
      for (const TrueObject& object : frame->true_objects) objects[object.id] = object;
      std::map<int, int> pixels;
      for (std::size_t i = 0; i < frame->objects.size(); ++i) {
        const int id = frame->objects[i];
        if (id == 0) continue;
        ASSERT_NE(frame->depth[i], 0);
        ASSERT_TRUE(objects.contains(id));
        ++pixels[id];
        const OrientedBox& box = objects[id].box;
        const Vector3d p = point(*frame, i) - box.centre;
        const Vector3d in_box(box.along.dot(p), box.up.cross(box.along).dot(p), box.up.dot(p));
        ASSERT_TRUE((in_box.cwiseAbs().array() <= (0.5 * box.size).array() + 1e-5).all()) << id << ": " << in_box.transpose();
      }
      EXPECT_EQ(pixels.size(), objects.size());
      for (const auto& [id, object] : objects) {
        EXPECT_GE(object.lowest_m, -1e-9);
        EXPECT_EQ(object.support.has_value(), scene != "curved");
      }
      if (scene == "desk" || scene == "office" || scene == "boxes" || scene == "curved") {
        EXPECT_GE(objects.size(), 3U);
      }
      if (scene == "empty_room") {
        EXPECT_TRUE(objects.empty());
      }
    }
  }
}

TEST(Render, ObjectsOfADeskStandOnIt) {
  const auto frame = render({.scene = "desk", .sensor = Sensor::none, .seed = 4, .camera = kSmall});
  ASSERT_TRUE(frame.ok());
  EXPECT_GE(frame->true_objects.size(), 4U);
  for (const TrueObject& object : frame->true_objects) EXPECT_NEAR(object.lowest_m, 0.0, 1e-9) << object.id;
  for (std::size_t i = 0; i < frame->labels.size(); ++i) {  // the largest plane, table or wall, is no object
    if (frame->labels[i] == kLabelFirst) {
      ASSERT_EQ(frame->objects[i], 0);
    }
  }
}

TEST(Render, PilesOfBoxesAreOneAboveTheOther) {
  const auto frame = render({.scene = "boxes", .sensor = Sensor::none, .seed = 1, .camera = kSmall});
  ASSERT_TRUE(frame.ok());
  const auto stacked = std::count_if(frame->true_objects.begin(), frame->true_objects.end(),
                                     [](const TrueObject& object) { return object.lowest_m > 0.01; });
  EXPECT_GE(stacked, 2);  // the tray's upper part and what is on the lowest box
}

// ---- A camera that is carried through a scene.

TEST(Walk, StepsAreThoseOfAHandAndKeepOutOfThings) {
  for (const std::string_view name : scene_names()) {
    for (std::uint64_t seed = 0; seed < 10; ++seed) {
      SCOPED_TRACE(std::string(name) + " seed " + std::to_string(seed));
      const detail::Stage stage = detail::find_scene(name)(seed);
      const detail::Walk walk(stage, seed);
      Statistics moved;
      Statistics turned;
      double bend = 0.0;  // from step to step
      Isometry3d last = walk.pose(0);
      Vector3d last_step = walk.pose(1).translation() - last.translation();
      for (int frame = 1; frame <= 400; ++frame) {
        const Isometry3d pose = walk.pose(frame);
        const Vector3d step = pose.translation() - last.translation();
        moved.add(step.norm());
        const double angle = Eigen::AngleAxisd(last.linear().transpose() * pose.linear()).angle();
        turned.add(angle);
        EXPECT_LT(step.norm(), 0.033);
        EXPECT_LT(angle, 1.1 * pi / 180.0);
        bend = std::max(bend, (step - last_step).norm());
        EXPECT_FALSE(stage.scene.encloses(pose.translation()));
        last_step = step;
        last = pose;
      }
      EXPECT_LT(bend, 0.007);
      EXPECT_GT(moved.mean(), 0.007);
      EXPECT_GT(turned.mean(), 0.3 * pi / 180.0);
    }
  }
}

SynthOptions walk_options(std::string_view scene, std::uint64_t seed, int frame) {
  return {.scene = std::string(scene),
          .sensor = Sensor::none,
          .seed = seed,
          .frame = frame,
          .motion = Motion::walk,
          .camera = kSmall};
}

// A plane of the world, carried into each frame by its pose, has that frame's coefficients.
TEST(Walk, LabelsAndObjectsAreTheSameInAllFrames) {
  for (const std::string_view scene : scene_names()) {
    SCOPED_TRACE(scene);
    std::map<int, Plane> world_planes;
    std::map<int, Vector3d> world_sizes;
    std::map<int, Vector3d> world_centres;
    for (int number = 0; number < 120; number += 20) {
      const auto frame = render(walk_options(scene, 21, number));
      ASSERT_TRUE(frame.ok());
      const Isometry3d& pose = frame->T_world_camera;
      std::map<int, std::size_t> pixels;
      for (const std::uint8_t label : frame->labels) ++pixels[label];
      for (const auto& [label, plane] : frame->true_planes) {
        EXPECT_GT(pixels[label], 0U);
        // n . (R^T (x - t)) + d = 0
        const Vector3d normal = pose.linear() * plane.normal;
        const Plane in_world = *make_plane(normal, plane.d - normal.dot(pose.translation()));
        const auto [known, is_new] = world_planes.emplace(label, in_world);
        const double sign = known->second.normal.dot(in_world.normal) < 0.0 ? -1.0 : 1.0;
        EXPECT_NEAR((known->second.normal - sign * in_world.normal).norm(), 0.0, 1e-6) << label;
        EXPECT_NEAR(known->second.d, sign * in_world.d, 1e-6) << label;
      }
      for (const auto& [label, count] : pixels) {
        if (label == kLabelNoDepth || label == kLabelNoPlane) continue;
        EXPECT_TRUE(std::any_of(frame->true_planes.begin(), frame->true_planes.end(),
                                [label = label](const auto& entry) { return entry.first == label; }));
      }
      for (std::size_t i = 0; i < frame->labels.size(); ++i) {
        const int label = frame->labels[i];
        if (label == kLabelNoDepth || label == kLabelNoPlane) continue;
        ASSERT_NEAR(world_planes.at(label).signed_distance(pose * point(*frame, i)), 0.0, 1e-6);
      }
      for (const TrueObject& object : frame->true_objects) {
        const Vector3d centre = pose * object.box.centre;
        EXPECT_NEAR((world_centres.emplace(object.id, centre).first->second - centre).norm(), 0.0, 1e-9) << object.id;
        EXPECT_NEAR((world_sizes.emplace(object.id, object.box.size).first->second - object.box.size).norm(), 0.0, 1e-9);
      }
    }
    EXPECT_GE(world_planes.size(), kLeastPlanes.at(scene));
  }
}

TEST(Walk, SameOptionsSameBytesAndAnotherSeedAnotherWalk) {
  const auto once = render(walk_options("office", 5, 17));
  const auto twice = render(walk_options("office", 5, 17));
  ASSERT_TRUE(once.ok() && twice.ok());
  EXPECT_EQ(once->depth, twice->depth);
  EXPECT_EQ(once->labels, twice->labels);
  EXPECT_EQ(once->objects, twice->objects);
  EXPECT_EQ(once->T_world_camera.matrix(), twice->T_world_camera.matrix());
  EXPECT_NE(render(walk_options("office", 6, 17))->T_world_camera.matrix(), once->T_world_camera.matrix());
  EXPECT_NE(render(walk_options("office", 5, 18))->depth, once->depth);
}

// Things and planes go out of sight behind others, or out of the picture, and come back.
TEST(Walk, ThingsComeBackAfterShortAbsences) {
  int back = 0;
  for (const std::string_view scene : {"office", "boxes"}) {
    std::map<int, int> last_seen;
    for (int number = 0; number < 150; number += 3) {
      SynthOptions options = walk_options(scene, 2, number);
      options.sensor = Sensor::none;
      options.camera = resized(kSmall, 80, 60);
      const auto frame = render(options);
      ASSERT_TRUE(frame.ok());
      for (const TrueObject& object : frame->true_objects) {
        const auto [known, is_new] = last_seen.emplace(object.id, number);
        if (!is_new && number - known->second > 3) ++back;
        known->second = number;
      }
    }
  }
  EXPECT_GE(back, 5);
}

TEST(Render, ErrorsNameTheCulprit) {
  const auto message = [](const SynthOptions& options) {
    const auto frame = render(options);
    if (frame.ok()) return std::string("no error");
    EXPECT_EQ(frame.error().code, ErrorCode::invalid_argument);
    return frame.error().message;
  };
  const std::string unknown = message({.scene = "moon"});
  EXPECT_THAT(unknown, HasSubstr("moon"));
  EXPECT_THAT(message({.scene = "mo\non"}), HasSubstr("'mo\\x0aon'"));
  EXPECT_LT(message({.scene = std::string(100000, 'm')}).size(), 2000U);
  for (const std::string_view name : scene_names()) EXPECT_THAT(unknown, HasSubstr(std::string(name)));
  EXPECT_THAT(message({.frame = -1}), HasSubstr("frame"));
  SynthOptions options;
  options.camera.fx = 0.0;
  EXPECT_THAT(message(options), HasSubstr("fx"));
  options.camera = SynthOptions{}.camera;
  options.camera.width = options.camera.height = 32768;
  EXPECT_THAT(message(options), HasSubstr("pixels"));
  EXPECT_THAT(message({.sensor = static_cast<Sensor>(17)}), HasSubstr("sensor"));
  EXPECT_THAT(message({.motion = static_cast<Motion>(17)}), HasSubstr("motion"));
}

TEST(Render, AnyCameraWorks) {
  for (const Camera& camera : {Camera{1, 1, 1.0, 1.0, 0.0, 0.0, 1000.0}, Camera{3, 200, 0.1, 1e6, 1e4, -1e4, 1.0},
                               Camera{200, 3, 50.0, 60.0, 0.0, 0.0, 1e6}}) {
    for (const Sensor sensor : kSensors) {
      for (const Motion motion : {Motion::sway, Motion::walk}) {
        const auto frame = render({.scene = "office", .sensor = sensor, .motion = motion, .camera = camera});
        ASSERT_TRUE(frame.ok());
        EXPECT_EQ(frame->labels.size(), index(camera.width * camera.height));
        EXPECT_EQ(frame->objects.size(), frame->labels.size());
      }
    }
  }
}

}  // namespace
}  // namespace fransac::synth
