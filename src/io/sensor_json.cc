// SPDX-License-Identifier: Apache-2.0
#include "fransac/io/sensor_json.hpp"

#include <algorithm>
#include <iterator>
#include <optional>
#include <utility>

#include "fransac/core/camera.hpp"
#include "io/guard.h"
#include "io/json.h"
#include "io/read_text.h"
#include "io/text.h"

namespace fransac::io {
namespace {

constexpr std::size_t kMaxSensorBytes = std::size_t{1} << 20;  // some sixty numbers and what they come from
constexpr const char* kType = "fransac-sensor";
constexpr int kVersion = 1;

/// The value of an optional field; null: it is missing or null.
const Json* find(const Json& object, const char* field) {
  const Json* const found = object.find(field);
  return found == nullptr || found->is_null() ? nullptr : found;
}

Result<std::string> word(const Json& object, const char* field, const std::string& name) {
  const Json* const found = object.find(field);
  if (found == nullptr) return field_error(name, field, "is missing");
  if (found->string() == nullptr) return field_error(name, field, std::string("must be a string, not ") + found->type_name());
  return *found->string();
}

Status read_number(const Json& object, const char* field, const std::string& label, const std::string& name,
                   std::optional<double>& value) {
  if (find(object, field) == nullptr) return {};
  const Result<double> read = number_field(object, field, label, name);
  if (!read) return read.error();
  value = *read;
  return {};
}

Status read_terms(const Json& object, const char* field, const std::string& name, std::array<double, kDistortionTerms>& terms) {
  const std::string label = std::string("distortion.") + field;
  const Json* const found = object.find(field);
  if (found == nullptr) return field_error(name, label, "is missing");
  const Json::Array* const numbers = found->elements();
  if (numbers == nullptr || numbers->size() != terms.size()) {
    return field_error(name, label, "must be a list of " + std::to_string(terms.size()) + " numbers");
  }
  for (std::size_t i = 0; i < terms.size(); ++i) {
    const std::optional<double> number = (*numbers)[i].number();
    if (!number) return field_error(name, label, std::string("holds what is no number: ") + (*numbers)[i].type_name());
    terms[i] = *number;
  }
  return {};
}

Status read_distortion(const Json& object, const std::string& name, Distortion& distortion) {
  const Json* const found = find(object, "distortion");
  if (found == nullptr) return {};
  if (found->fields() == nullptr)
    return field_error(name, "distortion", std::string("must be an object, not ") + found->type_name());
  for (const auto& [field, value] : {std::pair{"width", &distortion.width}, std::pair{"height", &distortion.height}}) {
    const Result<int> read = whole_field(*found, field, std::string("distortion.") + field, kMaxImageSide, name);
    if (!read) return read.error();
    if (*read < 1) return field_error(name, std::string("distortion.") + field, "must be at least 1");
    *value = *read;
  }
  if (Status status = read_terms(*found, "offset_per_m", name, distortion.offset_per_m); !status) return status;
  return read_terms(*found, "gain", name, distortion.gain);
}

Result<SensorOptions> sensor_from_json(const Json& object, const std::string& name) {
  const Result<std::string> type = word(object, "type", name);
  if (!type) return type.error();
  if (*type != kType) return field_error(name, "type", std::string("must be \"") + kType + "\"");
  const Result<int> version = whole_field(object, "version", "version", kVersion, name);
  if (!version) return version.error();
  if (*version != kVersion) return field_error(name, "version", "must be " + std::to_string(kVersion));
  const Result<std::string> kind = word(object, "kind", name);
  if (!kind) return kind.error();
  SensorOptions sensor;
  const auto& kinds = EnumNames<SensorKind>::values;
  const auto* const known = std::find(std::begin(kinds), std::end(kinds), *kind);
  if (known == std::end(kinds))
    return field_error(name, "kind", "must be a kind of sensor: auto, structured-light, stereo, tof, none");
  sensor.kind = static_cast<SensorKind>(known - std::begin(kinds));
  if (const Json* const noise = find(object, "noise")) {
    if (noise->fields() == nullptr)
      return field_error(name, "noise", std::string("must be an object, not ") + noise->type_name());
    for (const auto& [field, value] : {std::pair{"constant_m", &sensor.constant_m}, std::pair{"linear", &sensor.linear},
                                       std::pair{"quadratic_per_m", &sensor.quadratic_per_m}}) {
      if (Status status = read_number(*noise, field, std::string("noise.") + field, name, *value); !status) return status.error();
    }
  }
  if (Status status = read_number(object, "slow", "slow", name, sensor.slow); !status) return status.error();
  if (Status status = read_number(object, "bias_m", "bias_m", name, sensor.bias_m); !status) return status.error();
  if (Status status = read_distortion(object, name, sensor.distortion); !status) return status.error();
  if (Status status = validate(sensor); !status) return file_error(ErrorCode::format, name, status.error().message);
  return sensor;
}

}  // namespace

Result<SensorOptions> parse_sensor_json(std::string_view text, const std::string& name) {
  return guarded(name, [&]() -> Result<SensorOptions> {
    const Result<Json> object = parse_json_object(text, name);
    if (!object) return object.error();
    return sensor_from_json(*object, name);
  });
}

Result<SensorOptions> read_sensor_json(const std::filesystem::path& file) {
  return guarded(file.native(), [&] { return read_text(file, kMaxSensorBytes, &parse_sensor_json); });
}

std::string sensor_to_json(const SensorOptions& sensor, std::span<const std::pair<std::string_view, double>> evidence) {
  const Distortion& distortion = sensor.distortion;
  Json json = Json::object(
      "type", kType, "version", kVersion, "kind", std::string(enum_name(sensor.kind)), "noise",
      Json::object("constant_m", sensor.constant_m, "linear", sensor.linear, "quadratic_per_m", sensor.quadratic_per_m), "slow",
      sensor.slow, "bias_m", sensor.bias_m);
  const auto array = [](const auto& terms) { return Json::Array(terms.begin(), terms.end()); };
  json.add("distortion", distortion.empty() ? Json()
                                            : Json::object("width", distortion.width, "height", distortion.height, "offset_per_m",
                                                           array(distortion.offset_per_m), "gain", array(distortion.gain)));
  if (!evidence.empty()) {
    Json numbers = Json::object();
    for (const auto& [name, value] : evidence) numbers.add(std::string(name), value);
    json.add("evidence", std::move(numbers));
  }
  return json.text();
}

}  // namespace fransac::io
