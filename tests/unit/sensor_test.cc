// SPDX-License-Identifier: Apache-2.0
#include "fransac/core/sensor.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <set>
#include <string>

#include "fransac/planes/options.hpp"
#include "support.hpp"

namespace fransac {
namespace {

using ::testing::HasSubstr;

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr double kInf = std::numeric_limits<double>::infinity();

SensorModel model_of(const SensorOptions& options, const Camera& camera, double metres_per_unit = 0.0) {
  const Result<SensorModel> model = sensor_model(options, camera, metres_per_unit);
  EXPECT_TRUE(model) << (model ? "" : model.error().message);
  return model ? *model : SensorModel{};
}

TEST(Sensor, StructuredLightIsThatOfKhoshelhamAndElberinkWhateverTheCamera) {
  for (const double fx : {260.0, 525.0, 580.0}) {
    Camera camera = testing::small_camera();
    camera.fx = fx;
    const SensorModel model = model_of({.kind = SensorKind::structured_light}, camera);
    EXPECT_EQ(model.kind, SensorKind::structured_light);
    for (const double z : {0.5, 1.0, 2.0, 5.0}) EXPECT_NEAR(model.noise.sigma_m(z), 1.425e-3 * z * z, 1e-12);
    EXPECT_EQ(model.slow, 1.0);
    EXPECT_EQ(model.bias_m, 0.01);
  }
}

TEST(Sensor, StructuredLightScalesWithDisparityErrorAndBaseline) {
  const SensorModel model =
      model_of({.kind = SensorKind::structured_light, .baseline_m = 0.15, .disparity_error_px = 0.25}, testing::small_camera());
  EXPECT_NEAR(model.noise.quadratic_per_m, 1.425e-3 * (0.25 / 0.0625) * (0.075 / 0.15), 1e-12);
}

TEST(Sensor, StereoIsDisparityErrorOverFocalLengthTimesBaseline) {
  Camera camera = testing::small_camera();
  camera.fx = 640.0;
  EXPECT_NEAR(model_of({.kind = SensorKind::stereo}, camera).noise.sigma_m(2.0), 4.0 * 0.08 / (640.0 * 0.05), 1e-12);
  const SensorModel own = model_of({.kind = SensorKind::stereo, .baseline_m = 0.12, .disparity_error_px = 0.2}, camera);
  EXPECT_NEAR(own.noise.sigma_m(3.0), 9.0 * 0.2 / (640.0 * 0.12), 1e-12);
  EXPECT_EQ(own.noise.constant_m, 0.0);
  EXPECT_EQ(own.noise.linear, 0.0);
}

TEST(Sensor, TimeOfFlightIsConstantAndAShareOfTheDistance) {
  const SensorModel usual = model_of({.kind = SensorKind::time_of_flight}, testing::small_camera());
  for (const double z : {1.0, 4.0}) EXPECT_NEAR(usual.noise.sigma_m(z), std::hypot(0.001, 0.0015 * z), 1e-12);
  const SensorModel own = model_of({.kind = SensorKind::time_of_flight, .constant_m = 0.003, .linear = 0.004, .bias_m = 0.02},
                                   testing::small_camera());
  EXPECT_NEAR(own.noise.sigma_m(1.0), 0.005, 1e-12);
  EXPECT_EQ(own.noise.quadratic_per_m, 0.0);
  EXPECT_EQ(own.bias_m, 0.02);
}

TEST(Sensor, ALawThatIsGivenReplacesTheKindsOwnTermByTerm) {
  const Camera camera = testing::small_camera();
  for (const SensorKind kind : {SensorKind::structured_light, SensorKind::stereo, SensorKind::time_of_flight, SensorKind::none}) {
    const SensorModel own = model_of(
        {.kind = kind, .constant_m = 0.003, .linear = 0.002, .quadratic_per_m = 0.001, .slow = 0.5, .bias_m = 0.004}, camera);
    const DepthNoise law{.constant_m = 0.003, .linear = 0.002, .quadratic_per_m = 0.001};
    EXPECT_EQ(own, (SensorModel{kind, law, 0.5, 0.004})) << enum_name(kind);
    const SensorModel usual = model_of({.kind = kind}, camera);
    const SensorModel one = model_of({.kind = kind, .linear = 0.002}, camera);
    EXPECT_EQ(one.noise.constant_m, usual.noise.constant_m);
    EXPECT_EQ(one.noise.linear, 0.002);
    EXPECT_EQ(one.noise.quadratic_per_m, usual.noise.quadratic_per_m);
  }
  const SensorModel both = model_of({.kind = SensorKind::stereo, .disparity_error_px = 0.3, .quadratic_per_m = 0.001}, camera);
  EXPECT_EQ(both.noise.quadratic_per_m, 0.001) << "the law itself goes before what baseline and disparity make";
}

TEST(Sensor, SlowNoiseIsAShareOfThePixelNoiseAtEveryDepth) {
  const SensorModel model = model_of({.kind = SensorKind::time_of_flight, .slow = 0.25}, testing::small_camera(), 0.001);
  for (const double z : {0.3, 2.0, 9.0}) EXPECT_NEAR(model.slow_noise().sigma_m(z), 0.25 * model.noise.sigma_m(z), 1e-15);
  EXPECT_EQ(model_of({.slow = 2.0}, testing::small_camera()).slow, 2.0) << "known of a sensor that is not";
  EXPECT_EQ(model_of({.kind = SensorKind::none}, testing::small_camera()).slow_noise(), DepthNoise{});
}

TEST(Sensor, NoneIsTheRoundingToRawUnitsAlone) {
  const SensorModel exact = model_of({.kind = SensorKind::none}, testing::small_camera());
  EXPECT_EQ(exact.noise, DepthNoise{});
  EXPECT_EQ(exact.bias_m, 0.0);
  // Uniform over a step s has a variance of s^2 / 12.
  for (const double z : {0.0, 1.0, 8.0}) {
    EXPECT_NEAR(model_of({.kind = SensorKind::none}, testing::small_camera(), 0.001).noise.sigma_m(z), 1e-3 / std::sqrt(12.0),
                1e-15);
  }
}

TEST(Sensor, RoundingAddsToTheVariance) {
  const double step = 0.06;
  for (const SensorKind kind :
       {SensorKind::automatic, SensorKind::structured_light, SensorKind::stereo, SensorKind::time_of_flight}) {
    const double without = model_of({.kind = kind}, testing::small_camera()).noise.sigma_m(2.0);
    const double with = model_of({.kind = kind}, testing::small_camera(), step).noise.sigma_m(2.0);
    EXPECT_NEAR(with * with, without * without + step * step / 12.0, 1e-15);
  }
}

TEST(Sensor, AutomaticBelievesNoMoreThanStructuredLight) {
  const Camera camera = testing::small_camera();
  const SensorModel automatic = model_of({}, camera, 0.001);
  EXPECT_EQ(automatic.kind, SensorKind::automatic);
  EXPECT_EQ(automatic.noise, model_of({.kind = SensorKind::structured_light}, camera, 0.001).noise);
  EXPECT_EQ(model_of({.bias_m = 0.002}, camera).bias_m, 0.002);
}

TEST(Sensor, BadNumbersAreNamed) {
  struct BadCase {
    const char* what;
    SensorOptions options;
  };
  const BadCase cases[] = {
      {"baseline", {.kind = SensorKind::stereo, .baseline_m = 0.0}},
      {"baseline", {.kind = SensorKind::stereo, .baseline_m = 11.0}},
      {"baseline", {.kind = SensorKind::structured_light, .baseline_m = kNaN}},
      {"disparity-error", {.kind = SensorKind::stereo, .disparity_error_px = -0.1}},
      {"disparity-error", {.kind = SensorKind::stereo, .disparity_error_px = kInf}},
      {"constant", {.kind = SensorKind::time_of_flight, .constant_m = 2.0}},
      {"linear", {.kind = SensorKind::time_of_flight, .linear = -1e-3}},
      {"bias", {.kind = SensorKind::none, .bias_m = kNaN}},
      // What means nothing to the kind.
      {"baseline", {.kind = SensorKind::time_of_flight, .baseline_m = 0.05}},
      {"disparity-error", {.kind = SensorKind::none, .disparity_error_px = 0.1}},
      {"constant", {.constant_m = 0.001}},
      {"linear", {.linear = 0.001}},
      {"quadratic", {.quadratic_per_m = 0.001}},
      {"quadratic", {.kind = SensorKind::stereo, .quadratic_per_m = 1.5}},
      {"slow", {.slow = -0.1}},
      {"slow", {.kind = SensorKind::none, .slow = 11.0}},
      {"slow", {.slow = kNaN}},
      {"baseline", {.kind = SensorKind::automatic, .baseline_m = 0.05}},
  };
  for (const BadCase& bad : cases) {
    const auto model = sensor_model(bad.options, testing::small_camera(), 0.001);
    ASSERT_FALSE(model) << bad.what;
    EXPECT_EQ(model.error().code, ErrorCode::invalid_argument);
    EXPECT_THAT(model.error().message, HasSubstr(std::string(bad.what) + ": "));
  }
  for (const double unit : {-0.001, 1.5, kNaN}) {
    const auto model = sensor_model({}, testing::small_camera(), unit);
    ASSERT_FALSE(model);
    EXPECT_THAT(model.error().message, HasSubstr("metres_per_unit"));
  }
  Camera camera = testing::small_camera();
  camera.fx = 0.0;
  ASSERT_FALSE(sensor_model({.kind = SensorKind::stereo}, camera, 0.001));
  EXPECT_THAT(sensor_model({.kind = SensorKind::stereo}, camera, 0.001).error().message, HasSubstr("fx"));
}

TEST(Sensor, EveryNumberIsListedOnce) {
  SensorOptions options;
  std::set<std::string_view> names;
  std::set<const void*> values;
  for_each_parameter(options, [&](const SensorParameter& parameter, std::optional<double>& value) {
    names.insert(parameter.name);
    values.insert(&value);
    EXPECT_LT(parameter.min, parameter.max);
  });
  EXPECT_EQ(names,
            (std::set<std::string_view>{"baseline", "disparity-error", "constant", "linear", "quadratic", "slow", "bias"}));
  EXPECT_EQ(values.size(), 7U);
}

}  // namespace
}  // namespace fransac
