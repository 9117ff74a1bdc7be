// SPDX-License-Identifier: Apache-2.0
#include "fransac/calibrate/calibrate.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <string>
#include <vector>

#include "calibrate/noise.hpp"
#include "fransac/filter/correct.hpp"
#include "fransac/synth/synth.hpp"
#include "support.hpp"

namespace fransac {
namespace {

using ::testing::HasSubstr;

/// Frames of one camera that own their pixels.
struct Recording {
  std::vector<std::vector<std::uint16_t>> depth;
  std::vector<Camera> cameras;

  [[nodiscard]] std::vector<CalibrationFrame> frames() const {
    std::vector<CalibrationFrame> views;
    for (std::size_t i = 0; i < depth.size(); ++i) {
      const Camera& c = cameras[i];
      views.push_back({DepthView::from_uint16(depth[i].data(), c.width, c.height, c.depth_scale), c});
    }
    return views;
  }
};

/// Rendered rooms, bent: what is measured is q + error(x, y, q), in whole raw units.
template <class ErrorOf>
Recording rooms(synth::Sensor sensor, int seeds, ErrorOf&& error_of) {
  Recording recording;
  for (int seed = 0; seed < seeds; ++seed) {
    for (const char* scene : {"empty_room", "corridor", "hall"}) {
      auto frame = synth::render({.scene = scene, .sensor = sensor, .seed = static_cast<std::uint64_t>(seed)});
      EXPECT_TRUE(frame);
      const Camera& camera = frame->camera;
      for (int v = 0; v < camera.height; ++v) {
        for (int u = 0; u < camera.width; ++u) {
          std::uint16_t& raw = frame->depth[static_cast<std::size_t>(v * camera.width + u)];
          if (raw == 0) continue;
          const double q = camera.depth_scale / raw;
          const double x = (2.0 * u + 1.0) / camera.width - 1.0;
          const double y = (2.0 * v + 1.0) / camera.height - 1.0;
          raw = static_cast<std::uint16_t>(std::lround(std::min(65534.0, camera.depth_scale / (q + error_of(x, y, q)))));
        }
      }
      recording.depth.push_back(std::move(frame->depth));
      recording.cameras.push_back(camera);
    }
  }
  return recording;
}

/// Root mean square of a function over the image, without its affine part, and of its difference from another.
template <class Truth, class Found>
std::pair<double, double> compare(Truth&& truth, Found&& found) {
  constexpr int kSteps = 41;
  Eigen::Matrix<double, Eigen::Dynamic, 3> affine(kSteps * kSteps, 3);
  Eigen::VectorXd expected(kSteps * kSteps);
  Eigen::VectorXd measured(kSteps * kSteps);
  for (int i = 0; i < kSteps * kSteps; ++i) {
    const double x = 2.0 * (i % kSteps) / (kSteps - 1) - 1.0;
    const double y = 2.0 * (i / kSteps) / (kSteps - 1) - 1.0;
    affine.row(i) << 1.0, x, y;
    expected[i] = truth(x, y);
    measured[i] = found(x, y);
  }
  const auto without_affine = [&](const Eigen::VectorXd& f) -> Eigen::VectorXd {
    return f - affine * affine.householderQr().solve(f);
  };
  const double scale = 1.0 / kSteps;
  return {scale * without_affine(expected).norm(), scale * without_affine(expected - measured).norm()};
}

/// Of a lens: r^2 and r^4 terms, with 0.0025 per metre in the corners, which is 10 mm at 2 m.
double lens(double x, double y) {
  const double r2 = (x * x + 0.5625 * y * y) / 1.5625;
  return 0.0025 * (1.6 * r2 - 0.6 * r2 * r2);
}

TEST(Calibrate, RecoversADistortionThatIsKnown) {
  for (const synth::Sensor sensor : {synth::Sensor::kinect1, synth::Sensor::tof}) {
    const Recording recording = rooms(sensor, 4, [](double x, double y, double) { return lens(x, y); });
    const auto found = calibrate(recording.frames());
    ASSERT_TRUE(found) << found.error().message;
    ASSERT_FALSE(found->sensor.distortion.empty());
    // In inverse depth at 2 m, where amplitudes are meant.
    const auto correction = [&](double x, double y) { return -correction_at(found->sensor.distortion, x, y, 0.5); };
    const auto [all, left] = compare(lens, correction);
    EXPECT_GT(all, 3e-4);
    EXPECT_LT(left, 0.2 * all) << enum_name(sensor);
    // What is left is the rendered sensor's own slow noise.
    EXPECT_LT(found->after.rms_m, 0.7 * found->before.rms_m) << enum_name(sensor);
  }
}

/// A wall that fills the image, from several distances and angles, with a Kinect's pixel noise.
template <class ErrorOf>
Recording walls(ErrorOf&& error_of) {
  const Camera camera{320, 240, 262.5, 262.5, 159.5, 119.5, 5000.0};
  Recording recording;
  RandomStream random = testing::test_random();
  for (const double distance : {1.0, 1.3, 1.7, 2.2, 2.8}) {
    for (const double angle : {-0.35, 0.1, 0.4}) {
      const Plane wall{Eigen::Vector3d(std::sin(angle), 0.3 * std::sin(2.0 * angle), -std::cos(angle)).normalized(), distance};
      std::vector<std::uint16_t> units;
      for (int v = 0; v < camera.height; ++v) {
        for (int u = 0; u < camera.width; ++u) {
          const double q = 1.0 / testing::depth_on(wall, camera, u, v);
          const double x = (2.0 * u + 1.0) / camera.width - 1.0;
          const double y = (2.0 * v + 1.0) / camera.height - 1.0;
          const double measured = q + error_of(x, y, q) + kKinectNoise_per_m * random.normal();
          units.push_back(static_cast<std::uint16_t>(std::lround(std::min(65534.0, camera.depth_scale / measured))));
        }
      }
      recording.depth.push_back(std::move(units));
      recording.cameras.push_back(camera);
    }
  }
  return recording;
}

TEST(Calibrate, RecoversADistortionThatGrowsWithInverseDepth) {
  const auto bent = [](double x, double y, double q) { return 2.0 * q * lens(x, y); };
  const Recording recording = walls(bent);
  const auto found = calibrate(recording.frames());
  ASSERT_TRUE(found) << found.error().message;
  ASSERT_FALSE(found->sensor.distortion.empty());
  EXPECT_EQ(found->frames, recording.depth.size());
  for (const double q : {0.4, 0.9}) {
    const auto correction = [&](double x, double y) { return -correction_at(found->sensor.distortion, x, y, q); };
    const auto [all, left] = compare([&](double x, double y) { return bent(x, y, q); }, correction);
    EXPECT_LT(left, 0.2 * all) << q;
  }
  EXPECT_LT(found->after.rms_m, 0.3 * found->before.rms_m);
  EXPECT_NEAR(*found->sensor.quadratic_per_m, kKinectNoise_per_m, 0.1 * kKinectNoise_per_m);
  EXPECT_LT(*found->sensor.slow, 0.1) << "pixels are independent";
}

TEST(Calibrate, FindsNothingWhereNothingIsBent) {
  const Recording recording = rooms(synth::Sensor::kinect1, 2, [](double, double, double) { return 0.0; });
  const auto found = calibrate(recording.frames());
  ASSERT_TRUE(found) << found.error().message;
  const auto correction = [&](double x, double y) { return correction_at(found->sensor.distortion, x, y, 0.5); };
  const auto [all, left] = compare([](double, double) { return 0.0; }, correction);
  EXPECT_EQ(all, 0.0);
  EXPECT_LT(left, 2e-4) << "less than a millimetre at 2 m";
  EXPECT_LE(found->after.rms_m, found->before.rms_m);
}

TEST(Calibrate, TellsTheNoiseOfAKinect) {
  const Recording recording = rooms(synth::Sensor::kinect1, 2, [](double, double, double) { return 0.0; });
  const auto found = calibrate(recording.frames(), {.distortion = false});
  ASSERT_TRUE(found) << found.error().message;
  EXPECT_TRUE(found->sensor.distortion.empty());
  EXPECT_EQ(found->sensor.kind, SensorKind::structured_light);
  const auto model = sensor_model(found->sensor, recording.cameras.front(), 1.0 / recording.cameras.front().depth_scale);
  ASSERT_TRUE(model) << model.error().message;
  for (const NoiseAtDepth& bin : found->noise) {
    EXPECT_NEAR(model->noise.sigma_m(bin.z_m), bin.sigma_m, 0.35 * bin.sigma_m) << bin.z_m << " m";
  }
  EXPECT_GT(model->slow, 0.2);
  EXPECT_LT(model->slow, 2.0);
}

TEST(Calibrate, LawsAreFoundAgain) {
  const DepthNoise laws[] = {{.constant_m = 0.002},
                             {.linear = 0.003},
                             {.quadratic_per_m = 0.0014},
                             {.constant_m = 0.001, .linear = 0.0015},
                             {.constant_m = 0.002, .quadratic_per_m = 0.001}};
  for (const DepthNoise& law : laws) {
    std::vector<NoiseAtDepth> noise;
    for (double z = 0.5; z < 5.0; z *= 1.15) noise.push_back({z, law.sigma_m(z), 100});
    const DepthNoise found = calibration::fit_law(noise, SensorKind::automatic);
    EXPECT_NEAR(found.constant_m, law.constant_m, 1e-5);
    EXPECT_NEAR(found.linear, law.linear, 1e-5);
    EXPECT_NEAR(found.quadratic_per_m, law.quadratic_per_m, 1e-5);
  }
}

TEST(Calibrate, AtOneDepthOneTermSaysItAll) {
  const std::vector<NoiseAtDepth> noise{{1.0, 0.002, 50}, {1.15, 0.0026, 50}};
  const DepthNoise triangulating = calibration::fit_law(noise, SensorKind::stereo);
  EXPECT_EQ(triangulating.constant_m, 0.0);
  EXPECT_EQ(triangulating.linear, 0.0);
  EXPECT_NEAR(triangulating.quadratic_per_m, 0.002, 1e-4);
  const DepthNoise tof = calibration::fit_law(noise, SensorKind::time_of_flight);
  EXPECT_EQ(tof.quadratic_per_m, 0.0);
  EXPECT_NEAR(tof.linear, 0.0021, 1e-4);
}

TEST(Calibrate, WhatCannotBeUsedIsNamed) {
  EXPECT_EQ(calibrate({}).error().code, ErrorCode::no_data);
  const Recording recording = rooms(synth::Sensor::none, 1, [](double, double, double) { return 0.0; });
  std::vector<CalibrationFrame> frames = recording.frames();
  frames[1].depth = DepthView::from_uint16(recording.depth[1].data(), 320, 240, 5000.0);
  EXPECT_THAT(calibrate(frames).error().message, HasSubstr("frame 1: is 320 x 240"));
  frames = recording.frames();
  frames[2].camera.fx = 0.0;
  EXPECT_THAT(calibrate(frames).error().message, HasSubstr("frame 2: "));
  const std::vector<std::uint16_t> blank(recording.depth[0].size(), 0);
  const Camera& camera = recording.cameras[0];
  const CalibrationFrame nothing{DepthView::from_uint16(blank.data(), camera.width, camera.height, 5000.0), camera};
  EXPECT_EQ(calibrate(std::vector{nothing, nothing}).error().code, ErrorCode::no_data);
  const auto message = [&](const CalibrateOptions& options) { return calibrate(recording.frames(), options).error().message; };
  EXPECT_THAT(message({.kind = static_cast<SensorKind>(7)}), HasSubstr("kind: "));
  EXPECT_THAT(message({.max_bend_m = std::nan("")}), HasSubstr("max-bend: "));
  EXPECT_THAT(message({.min_share = 0.0}), HasSubstr("min-share: "));
  EXPECT_THAT(message({.saturated = 70000}), HasSubstr("saturated: "));
  EXPECT_THAT(message({.threads = -1}), HasSubstr("threads: "));
}

TEST(Calibrate, ThreadsChangeNothing) {
  const Recording recording = rooms(synth::Sensor::kinect1, 1, [](double x, double y, double) { return lens(x, y); });
  const auto one = calibrate(recording.frames(), {.threads = 1});
  const auto two = calibrate(recording.frames(), {.threads = 2});
  ASSERT_TRUE(one && two);
  EXPECT_EQ(one->sensor.distortion, two->sensor.distortion);
  EXPECT_EQ(one->sensor.slow, two->sensor.slow);
}

Distortion some_distortion() {
  Distortion distortion{.width = 80, .height = 60};
  for (std::size_t i = 0; i < distortion.gain.size(); ++i) {
    distortion.offset_per_m[i] = 0.004 * std::sin(1.0 + static_cast<double>(i));
    distortion.gain[i] = 0.003 * std::cos(2.0 + static_cast<double>(i));
  }
  return distortion;
}

TEST(Correct, AddsToInverseDepthWhatTheTermsSay) {
  const Distortion distortion = some_distortion();
  std::vector<float> metres(80 * 60);
  for (std::size_t i = 0; i < metres.size(); ++i) metres[i] = 0.5F + 0.001F * static_cast<float>(i);
  CorrectedDepth corrected;
  ASSERT_TRUE(correct(DepthView::from_float(metres.data(), 80, 60), distortion, 0, corrected));
  std::vector<std::uint16_t> units(metres.size());
  for (std::size_t i = 0; i < units.size(); ++i) units[i] = static_cast<std::uint16_t>(std::lround(10000.0F * metres[i]));
  CorrectedDepth in_units;
  ASSERT_TRUE(correct(DepthView::from_uint16(units.data(), 80, 60, 10000.0), distortion, 65535, in_units));
  for (int v = 0; v < 60; ++v) {
    for (int u = 0; u < 80; ++u) {
      const double q = 1.0 / static_cast<double>(metres[static_cast<std::size_t>(v * 80 + u)]);
      const double expected = 1.0 / (q + correction_at(distortion, (2 * u + 1) / 80.0 - 1.0, (2 * v + 1) / 60.0 - 1.0, q));
      ASSERT_NEAR(corrected.view.metres(u, v), expected, 1e-5) << u << ' ' << v;
      ASSERT_NEAR(in_units.view.metres(u, v), expected, 1.1e-4) << u << ' ' << v;
    }
  }
}

TEST(Correct, TermsAreTheProductsOfLegendrePolynomials) {
  const auto terms = distortion_terms(0.3, -0.7);
  EXPECT_NEAR(terms[0], 0.5 * (3.0 * 0.49 - 1.0), 1e-15);         // P2(y)
  EXPECT_NEAR(terms[1], 0.3 * -0.7, 1e-15);                       // P1(x) P1(y)
  EXPECT_NEAR(terms[2], 0.5 * (3.0 * 0.09 - 1.0), 1e-15);         // P2(x)
  EXPECT_NEAR(terms[6], 0.5 * (5.0 * 0.027 - 3.0 * 0.3), 1e-15);  // P3(x)
  EXPECT_NEAR(distortion_terms(1.0, 1.0).back(), 1.0, 1e-15);     // P6(1)
}

TEST(Correct, WhatIsNoMeasurementStays) {
  std::vector<std::uint16_t> units(80 * 60, 65535);
  units[7] = 0;
  units[8] = 65534;
  CorrectedDepth corrected;
  Distortion distortion{.width = 80, .height = 60};
  distortion.gain[2] = -0.2;
  ASSERT_TRUE(correct(DepthView::from_uint16(units.data(), 80, 60, 1000.0), distortion, 65535, corrected));
  EXPECT_EQ(corrected.units[0], 65535);
  EXPECT_EQ(corrected.units[7], 0);
  EXPECT_EQ(corrected.units[8], 65534) << "cannot become what means no measurement";
  ASSERT_TRUE(correct(DepthView::from_uint16(units.data(), 80, 60, 1000.0), distortion, 0, corrected));
  EXPECT_NE(corrected.units[40], 65535) << "is a measurement now, too far in the middle of a row";
  std::vector<float> metres{0.0F, -1.0F, std::nanf(""), std::numeric_limits<float>::infinity(), 2.0F, 2.0F, 2.0F, 2.0F};
  distortion.width = 4;
  distortion.height = 2;
  ASSERT_TRUE(correct(DepthView::from_float(metres.data(), 4, 2), distortion, 65535, corrected));
  EXPECT_EQ(corrected.metres[0], 0.0F);
  EXPECT_EQ(corrected.metres[1], -1.0F);
  EXPECT_TRUE(std::isnan(corrected.metres[2]));
  EXPECT_TRUE(std::isinf(corrected.metres[3]));
  EXPECT_NE(corrected.metres[4], 2.0F);
}

TEST(Correct, WhatIsMeasuredStaysMeasured) {
  Distortion distortion{.width = 4, .height = 2};
  std::vector<float> metres(8, kMaxDepth_m);
  std::fill_n(metres.begin(), 4, std::numeric_limits<float>::denorm_min());
  for (const double sign : {1.0, -1.0}) {
    distortion.gain[0] = distortion.gain[2] = 0.8 * sign;
    CorrectedDepth corrected;
    ASSERT_TRUE(correct(DepthView::from_float(metres.data(), 4, 2), distortion, 0, corrected));
    for (int u = 0; u < 4; ++u) {
      EXPECT_GT(corrected.view.metres(u, 0), 0.0F) << u;
      EXPECT_GT(corrected.view.metres(u, 1), 0.0F) << u;
    }
    const std::vector<std::uint16_t> units(8, 2);
    ASSERT_TRUE(correct(DepthView::from_uint16(units.data(), 4, 2, 1000.0), distortion, 1, corrected));
    for (const std::uint16_t corrected_units : corrected.units) EXPECT_GT(corrected_units, 1);
  }
}

TEST(Correct, NoPixelMovesByMoreThanAFactorOfTwo) {
  std::vector<float> metres(80 * 60, 5.0F);
  for (const double size : {-1.0, 1.0}) {
    Distortion distortion{.width = 80, .height = 60};
    distortion.offset_per_m.fill(size);
    distortion.gain.fill(size);
    CorrectedDepth corrected;
    ASSERT_TRUE(correct(DepthView::from_float(metres.data(), 80, 60), distortion, 0, corrected));
    for (const float z : corrected.metres) ASSERT_TRUE(z >= 2.5F && z <= 10.0F) << z;
  }
}

TEST(Correct, ImagesOfAnotherSizeShowTheSameFieldOfView) {
  const Distortion distortion = some_distortion();
  const auto corner = [&](int width, int height) {
    const std::vector<float> metres(static_cast<std::size_t>(width * height), 2.0F);
    CorrectedDepth corrected;
    EXPECT_TRUE(correct(DepthView::from_float(metres.data(), width, height), distortion, 0, corrected));
    return corrected.view.metres(0, 0);
  };
  EXPECT_NEAR(corner(640, 480), corner(320, 240), 2e-3);
  EXPECT_NE(corner(640, 480), 2.0F);
  CorrectedDepth corrected;
  const std::vector<float> metres(64 * 64, 2.0F);
  const Status refused = correct(DepthView::from_float(metres.data(), 64, 64), distortion, 0, corrected);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, ErrorCode::invalid_argument);
  EXPECT_THAT(refused.error().message, HasSubstr("80 x 60"));
  EXPECT_THAT(refused.error().message, HasSubstr("64 x 64"));
}

TEST(Correct, AbsurdDistortionsAreRefusedAndNamed) {
  const auto message = [](const Distortion& distortion) {
    SegmentOptions options;
    options.sensor.distortion = distortion;
    const std::vector<std::uint16_t> units(80 * 60, 1000);
    const auto found = segment(DepthView::from_uint16(units.data(), 80, 60, 1000.0), testing::small_camera(), options);
    return found ? std::string() : found.error().message;
  };
  Distortion distortion = some_distortion();
  EXPECT_EQ(message(distortion), "");
  distortion.gain[3] = std::nan("");
  EXPECT_THAT(message(distortion), HasSubstr("distortion gain: number 3"));
  distortion = some_distortion();
  distortion.offset_per_m[24] = 1.5;
  EXPECT_THAT(message(distortion), HasSubstr("distortion offset_per_m: number 24"));
  distortion = some_distortion();
  distortion.width = -1;
  EXPECT_THAT(message(distortion), HasSubstr("distortion width"));
  distortion.width = 0;
  EXPECT_THAT(message(distortion), HasSubstr("distortion width")) << "has coefficients but no size";
}

/// The root mean square distance of a bent wall's pixels to the plane that is found in it.
TEST(Correct, SegmentCorrectsBeforeItLooks) {
  const Camera camera{80, 60, 70.0, 70.0, 39.5, 29.5, 10000.0};
  Distortion distortion{.width = 80, .height = 60};
  distortion.offset_per_m[2] = 0.01;  // of P2(x): 20 to 40 mm at 2 m
  std::vector<std::uint16_t> units(80 * 60);
  for (int i = 0; i < 80 * 60; ++i) {
    const double x = (2 * (i % 80) + 1) / 80.0 - 1.0;
    const double q = 0.5 - correction_at(distortion, x, 0.0, 0.5);
    units[static_cast<std::size_t>(i)] = static_cast<std::uint16_t>(std::lround(10000.0 / q));
  }
  const DepthView depth = DepthView::from_uint16(units.data(), 80, 60, 10000.0);
  for (const Method method : {Method::cells, Method::ransac}) {
    SegmentOptions options;
    options.method = method;
    options.ransac.threshold_m = 0.002;
    options.sensor.distortion = distortion;
    const auto found = segment(depth, camera, options);
    ASSERT_TRUE(found) << found.error().message;
    ASSERT_EQ(found->planes.size(), 1U) << enum_name(method);
    EXPECT_EQ(found->planes[0].inliers, 80U * 60U) << enum_name(method);
    EXPECT_NEAR(found->planes[0].plane.d, 2.0, 1e-3);
    EXPECT_LT(found->planes[0].rms_m, 1e-4) << enum_name(method);
    EXPECT_EQ(found->distortion, distortion);
    options.sensor.distortion = {};
    const auto bent = segment(depth, camera, options);
    ASSERT_TRUE(bent);
    EXPECT_TRUE(bent->planes.empty() || bent->planes[0].inliers < 80U * 60U || bent->planes[0].rms_m > 5e-3);
    EXPECT_TRUE(bent->distortion.empty());
  }
}

}  // namespace
}  // namespace fransac
