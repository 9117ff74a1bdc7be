// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>

#include <array>
#include <string>
#include <utility>

#include "fransac/io/file.hpp"
#include "fransac/io/sensor_json.hpp"
#include "temporary_folder.h"

namespace fransac::io {
namespace {

using fransac::testing::TemporaryFolder;
using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::StartsWith;

SensorOptions some_sensor() {
  SensorOptions sensor{.kind = SensorKind::structured_light,
                       .constant_m = 0.1 + 0.2,
                       .linear = 0.0,
                       .quadratic_per_m = 1.0 / 700.0,
                       .slow = 0.75,
                       .bias_m = 0.004};
  sensor.distortion.width = 640;
  sensor.distortion.height = 480;
  for (std::size_t i = 0; i < sensor.distortion.gain.size(); ++i) {
    sensor.distortion.offset_per_m[i] = 0.01 / (1.0 + static_cast<double>(i));
    sensor.distortion.gain[i] = -0.003 * static_cast<double>(i) / 7.0;
  }
  return sensor;
}

bool same(const SensorOptions& a, const SensorOptions& b) {
  return a.kind == b.kind && a.baseline_m == b.baseline_m && a.disparity_error_px == b.disparity_error_px &&
         a.constant_m == b.constant_m && a.linear == b.linear && a.quadratic_per_m == b.quadratic_per_m && a.slow == b.slow &&
         a.bias_m == b.bias_m && a.distortion == b.distortion;
}

TEST(SensorJson, RoundTripIsExact) {
  for (const SensorOptions& sensor :
       {some_sensor(), SensorOptions{}, SensorOptions{.kind = SensorKind::none, .slow = 0.0}, SensorOptions{.bias_m = 0.01}}) {
    const auto read = parse_sensor_json(sensor_to_json(sensor), "sensor.json");
    ASSERT_TRUE(read) << read.error().message;
    EXPECT_TRUE(same(*read, sensor)) << sensor_to_json(sensor);
  }
}

TEST(SensorJson, EvidenceIsKeptForPeopleAndIgnored) {
  const std::array evidence{std::pair{std::string_view("frames"), 12.0}, std::pair{std::string_view("bend_rms_after_m"), 0.002}};
  const std::string text = sensor_to_json(some_sensor(), evidence);
  EXPECT_THAT(text, AllOf(HasSubstr("\"frames\": 12.0"), HasSubstr("\"bend_rms_after_m\": 0.002")));
  const auto read = parse_sensor_json(text, "sensor.json");
  ASSERT_TRUE(read) << read.error().message;
  EXPECT_TRUE(same(*read, some_sensor()));
}

TEST(SensorJson, WhatIsMissingFollowsFromTheKind) {
  const auto read = parse_sensor_json(R"({"type": "fransac-sensor", "version": 1, "kind": "tof", "model": {"of": 3}})", "s");
  ASSERT_TRUE(read) << read.error().message;
  EXPECT_TRUE(same(*read, {.kind = SensorKind::time_of_flight}));
}

TEST(SensorJson, ReadsAFile) {
  const TemporaryFolder folder;
  const std::filesystem::path file = folder.path() / "sensor.json";
  ASSERT_TRUE(write_file(file, sensor_to_json(some_sensor())));
  const auto read = read_sensor_json(file);
  ASSERT_TRUE(read) << read.error().message;
  EXPECT_TRUE(same(*read, some_sensor()));
  EXPECT_EQ(read_sensor_json(folder.path() / "missing.json").error().code, ErrorCode::io);
}

/// Text with `from` replaced by `to`.
std::string altered(std::string text, const std::string& from, const std::string& to) {
  const std::size_t at = text.find(from);
  return at == std::string::npos ? "no " + from : text.replace(at, from.size(), to);
}

TEST(SensorJson, HostileFilesAreErrorsThatNameFileAndField) {
  const std::string text = sensor_to_json(some_sensor());
  const std::string first = "\"offset_per_m\": [\n   0.01,";
  const std::pair<std::string, const char*> cases[] = {
      {"", "not valid JSON"},
      {text.substr(0, text.size() / 2), "not valid JSON"},
      {"[1]", "is not a JSON object"},
      {"{}", "\"type\" is missing"},
      {altered(text, "\"fransac-sensor\"", "7"), "\"type\" must be a string, not number"},
      {altered(text, "fransac-sensor", "camera"), "\"type\" must be \"fransac-sensor\""},
      {altered(text, "\"version\": 1", "\"version\": 2"), "\"version\" must be 1"},
      {altered(text, "\"version\": 1", "\"version\": \"1\""), "\"version\" must be a number, not string"},
      {altered(text, "\"version\": 1", "\"version\": 1e300"), "\"version\" must be 1"},
      {altered(text, "\"version\": 1,", ""), "\"version\" is missing"},
      {altered(text, "structured-light", "lidar"), "\"kind\" must be a kind of sensor"},
      {altered(text, "\"slow\": 0.75", "\"slow\": [0.75]"), "\"slow\" must be a number, not array"},
      {altered(text, "\"slow\": 0.75", "\"slow\": -1"), "slow: must be between 0 and 10"},
      {altered(text, "\"slow\": 0.75", "\"slow\": 1e999"), "\"slow\" holds a number that is out of range"},
      {altered(text, "\"slow\": 0.75", "\"slow\": NaN"), "not valid JSON in line"},
      {altered(text, "\"bias_m\": 0.004", "\"bias_m\": 4"), "bias: must be between 0 and 1 m"},
      {altered(text, "\"constant_m\": 0.3", "\"constant_m\": \"0.3\", \"c\": 0.3"), "\"noise.constant_m\" must be a number"},
      {altered(text, "\"constant_m\": 0.3", "\"constant_m\": 90.3"), "constant: must be between 0 and 1 m"},
      {altered(text, "\"noise\": {", "\"noise\": 3, \"other\": {"), "\"noise\" must be an object, not number"},
      {altered(text, "\"distortion\": {", "\"distortion\": [], \"other\": {"), "\"distortion\" must be an object, not array"},
      {altered(text, "\"width\": 640", "\"width\": 1e18"), "distortion width: must be between 1 and 32768 pixels"},
      {altered(text, "\"width\": 640", "\"width\": 0"), "\"distortion.width\" must be at least 1"},
      {altered(text, "\"width\": 640", "\"width\": 3.5"), "\"distortion.width\" must be a whole number"},
      {altered(text, "\"height\": 480", "\"height\": null"), "\"distortion.height\" must be a number, not null"},
      {altered(text, first, "\"offset_per_m\": ["), "\"distortion.offset_per_m\" must be a list of 25 numbers"},
      {altered(text, first, "\"offset_per_m\": [\n   \"0.01\","), "\"distortion.offset_per_m\" holds what is no number: string"},
      {altered(text, first, "\"offset_per_m\": [\n   7,"), "distortion offset_per_m: number 0 must be between -1 and 1"},
      {altered(text, "\"gain\"", "\"gian\""), "\"distortion.gain\" is missing"},
      {altered(text, "\"slow\": 0.75", "\"kind\": \"tof\""), "\"kind\" appears twice"},
  };
  for (const auto& [hostile, message] : cases) {
    const auto read = parse_sensor_json(hostile, "folder/sensor.json");
    ASSERT_FALSE(read) << hostile;
    EXPECT_EQ(read.error().code, ErrorCode::format);
    EXPECT_THAT(read.error().message, AllOf(StartsWith("folder/sensor.json: "), HasSubstr(message)));
  }
}

}  // namespace
}  // namespace fransac::io
