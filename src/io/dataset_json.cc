// SPDX-License-Identifier: Apache-2.0
#include "io/dataset_json.h"

#include <algorithm>
#include <array>
#include <utility>

#include "io/json.h"

namespace fransac::io {
namespace {

constexpr std::array<std::pair<Truth, const char*>, 3> kTruthNames{
    {{Truth::none, "none"}, {Truth::dominant, "dominant"}, {Truth::planes, "planes"}}};

Result<std::string> string_field(const Json& object, const char* field, const char* otherwise, const std::string& name) {
  const Json* const found = object.find(field);
  if (found == nullptr) return std::string(otherwise);
  if (found->string() == nullptr) return field_error(name, field, std::string("must be a string, not ") + found->type_name());
  return *found->string();
}

}  // namespace

Result<DatasetJson> parse_dataset_json(std::string_view text, const std::string& name) {
  const Result<Json> object = parse_json_object(text, name);
  if (!object) return object.error();
  const Result<std::string> truth = string_field(*object, "truth", "none", name);
  if (!truth) return truth.error();
  Result<std::string> sensor = string_field(*object, "sensor", "", name);
  if (!sensor) return sensor.error();
  const auto* const known =
      std::find_if(kTruthNames.begin(), kTruthNames.end(), [&](const auto& entry) { return entry.second == *truth; });
  if (known == kTruthNames.end()) return field_error(name, "truth", R"(must be "none", "dominant" or "planes")");
  DatasetJson json{known->first, *std::move(sensor), {}};
  if (object->find("floor") != nullptr) {
    const Result<int> floor = label_field(*object, "floor", "floor", name);
    if (!floor) return floor.error();
    json.floor = *floor;
  }
  return json;
}

std::string dataset_to_json(const DatasetJson& dataset) {
  const auto* const known =
      std::find_if(kTruthNames.begin(), kTruthNames.end(), [&](const auto& entry) { return entry.first == dataset.truth; });
  Json object = Json::object("truth", known->second);
  if (!dataset.sensor.empty()) object.add("sensor", dataset.sensor);
  if (dataset.floor) object.add("floor", *dataset.floor);
  return object.text();
}

}  // namespace fransac::io
