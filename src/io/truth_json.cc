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
using nlohmann::ordered_json;

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
  const Result<int> label = label_field(object, "label", field + ".label", name);
  if (!label) return label.error();
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

ordered_json vector_json(const Eigen::Vector3d& v) { return {v.x(), v.y(), v.z()}; }

ordered_json plane_json(const Plane& plane) { return {{"normal", vector_json(plane.normal)}, {"d", plane.d}}; }

ordered_json pose_json(const Eigen::Isometry3d& pose) {
  const Eigen::Quaterniond q(pose.linear());
  return {{"translation", vector_json(pose.translation())}, {"quaternion", {q.x(), q.y(), q.z(), q.w()}}};
}

ordered_json object_json(const TrueObject& object, const FrameToWrite& frame) {
  ordered_json entry{{"id", object.id}};
  if (frame.objects) entry["pixels"] = std::count(frame.objects->pixels.begin(), frame.objects->pixels.end(), object.id);
  entry["box"] = {{"centre", vector_json(object.box.centre)},
                  {"size", vector_json(object.box.size)},
                  {"along", vector_json(object.box.along)},
                  {"up", vector_json(object.box.up)},
                  {"yaw_rad", object.box.yaw_rad()}};
  entry["support"] = object.support ? plane_json(*object.support) : ordered_json();
  entry["height_range_m"] = object.support ? ordered_json{object.lowest_m, object.highest_m} : ordered_json();
  return entry;
}

}  // namespace

Result<TruthJson> parse_truth_json(std::string_view text, const std::string& name) {
  const Result<json> object = parse_json_object(text, name);
  if (!object) return object.error();
  const auto list = object->find("planes");
  if (list == object->end()) return field_error(name, "planes", "is missing");
  if (!list->is_array()) return field_error(name, "planes", "must be an array");
  TruthJson truth;
  LabelledPlanes& planes = truth.planes;
  for (std::size_t i = 0; i < list->size(); ++i) {
    const std::string field = "planes[" + std::to_string(i) + "]";
    const Result<std::pair<int, Plane>> plane = parse_plane((*list)[i], field, name);
    if (!plane) return plane.error();
    const auto same_label = [&](const auto& other) { return other.first == plane->first; };
    if (std::any_of(planes.begin(), planes.end(), same_label)) return field_error(name, field + ".label", "appears twice");
    planes.push_back(*plane);
  }
  const auto floor = object->find("floor");
  if (floor == object->end()) return truth;
  if (floor->is_null()) {
    truth.floor = kLabelNoDepth;
    return truth;
  }
  const Result<int> label = label_field(*object, "floor", "floor", name);
  if (!label) return label.error();
  truth.floor = *label;
  return truth;
}

std::string truth_to_json(const FrameToWrite& frame) {
  const auto counts = frame.labels ? std::optional(count_labels(frame.depth, *frame.labels)) : std::nullopt;
  ordered_json object{{"labels_hold_for", frame.label_scope == LabelScope::sequence ? "sequence" : "frame"}};
  if (frame.T_world_camera) object["pose"] = pose_json(*frame.T_world_camera);
  if (frame.floor) object["floor"] = *frame.floor == 0 ? ordered_json() : ordered_json(*frame.floor);
  object["planes"] = json::array();
  for (const auto& [label, plane] : frame.true_planes) {
    ordered_json entry{{"label", label}};
    entry.update(plane_json(plane));
    if (counts) entry["pixels"] = counts->at(static_cast<std::uint8_t>(label));
    object["planes"].push_back(std::move(entry));
  }
  if (counts) {
    object["nonplane_pixels"] = counts->at(kLabelNoPlane);
    object["ignored_pixels"] = counts->at(0);
    object["valid_pixels"] =
        std::count_if(frame.depth.pixels.begin(), frame.depth.pixels.end(), [](auto raw) { return raw != 0; });
  }
  if (frame.objects) object["objects"] = json::array();
  for (const TrueObject& thing : frame.true_objects) object["objects"].push_back(object_json(thing, frame));
  return to_text(object);
}

}  // namespace fransac::io
