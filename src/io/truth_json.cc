// SPDX-License-Identifier: Apache-2.0
#include "io/truth_json.h"

#include <algorithm>
#include <array>
#include <cstdint>

#include "fransac/core/labels.hpp"
#include "io/json.h"

namespace fransac::io {
namespace {

using nlohmann::json;

Result<Eigen::Vector3d> parse_normal(const json& object, const std::string& label, const std::string& name) {
  const auto found = object.find("normal");
  if (found == object.end()) return field_error(name, label, "is missing");
  const bool three_numbers = found->is_array() && found->size() == 3 &&
                             std::all_of(found->begin(), found->end(), [](const json& value) { return value.is_number(); });
  if (!three_numbers) return field_error(name, label, "must be three numbers");
  return Eigen::Vector3d((*found)[0].get<double>(), (*found)[1].get<double>(), (*found)[2].get<double>());
}

Result<std::pair<int, Plane>> parse_plane(const json& object, const std::string& field, const std::string& name) {
  if (!object.is_object()) return field_error(name, field, "must be an object");
  const Result<int> label = whole_field(object, "label", field + ".label", kMaxPlanes, name);
  if (!label) return label.error();
  if (*label < kLabelFirst || *label > kMaxPlanes) return field_error(name, field + ".label", "must be between 1 and 254");
  const Result<Eigen::Vector3d> normal = parse_normal(object, field + ".normal", name);
  if (!normal) return normal.error();
  const Result<double> d = number_field(object, "d", field + ".d", name);
  if (!d) return d.error();
  const std::optional<Plane> plane = make_plane(*normal, *d);
  if (!plane) return field_error(name, field + ".normal", "is no direction");
  return std::pair{*label, *plane};
}

std::array<std::size_t, 256> count_labels(const DepthImage& depth, const LabelImage& labels) {
  std::array<std::size_t, 256> counts{};
  for (std::size_t i = 0; i < depth.pixels.size(); ++i) {
    if (depth.pixels[i] != 0) ++counts[labels.pixels[i]];
  }
  return counts;
}

}  // namespace

Result<LabelledPlanes> parse_truth_json(std::string_view text, const std::string& name) {
  const Result<json> object = parse_json_object(text, name);
  if (!object) return object.error();
  const auto list = object->find("planes");
  if (list == object->end()) return field_error(name, "planes", "is missing");
  if (!list->is_array()) return field_error(name, "planes", "must be an array");
  LabelledPlanes planes;
  for (std::size_t i = 0; i < list->size(); ++i) {
    const std::string field = "planes[" + std::to_string(i) + "]";
    const Result<std::pair<int, Plane>> plane = parse_plane((*list)[i], field, name);
    if (!plane) return plane.error();
    const auto same_label = [&](const auto& other) { return other.first == plane->first; };
    if (std::any_of(planes.begin(), planes.end(), same_label)) return field_error(name, field + ".label", "appears twice");
    planes.push_back(*plane);
  }
  return planes;
}

std::string truth_to_json(const LabelledPlanes& planes, const DepthImage& depth, const LabelImage* labels) {
  const auto counts = labels != nullptr ? std::optional(count_labels(depth, *labels)) : std::nullopt;
  nlohmann::ordered_json object{{"planes", json::array()}};
  for (const auto& [label, plane] : planes) {
    nlohmann::ordered_json entry{
        {"label", label}, {"normal", {plane.normal.x(), plane.normal.y(), plane.normal.z()}}, {"d", plane.d}};
    if (counts) entry["pixels"] = counts->at(static_cast<std::uint8_t>(label));
    object["planes"].push_back(std::move(entry));
  }
  if (counts) {
    object["nonplane_pixels"] = counts->at(kLabelNoPlane);
    object["ignored_pixels"] = counts->at(0);
    object["valid_pixels"] = std::count_if(depth.pixels.begin(), depth.pixels.end(), [](std::uint16_t raw) { return raw != 0; });
  }
  return to_text(object);
}

}  // namespace fransac::io
