// SPDX-License-Identifier: Apache-2.0
#include "io/truth_json.h"

#include <algorithm>
#include <array>
#include <cstdint>

#include "fransac/core/labels.hpp"
#include "io/json.h"

namespace fransac::io {
namespace {

Result<Eigen::Vector3d> parse_normal(const Json& object, const std::string& label, const std::string& name) {
  const Json* const found = object.find("normal");
  if (found == nullptr) return field_error(name, label, "is missing");
  const Json::Array* const numbers = found->elements();
  const bool three_numbers = numbers != nullptr && numbers->size() == 3 &&
                             std::all_of(numbers->begin(), numbers->end(), [](const Json& value) { return value.number(); });
  if (!three_numbers) return field_error(name, label, "must be three numbers");
  return Eigen::Vector3d(*(*numbers)[0].number(), *(*numbers)[1].number(), *(*numbers)[2].number());
}

Result<std::pair<int, Plane>> parse_plane(const Json& object, const std::string& field, const std::string& name) {
  if (object.fields() == nullptr) return field_error(name, field, "must be an object");
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

Json vector_json(const Eigen::Vector3d& v) { return Json::array(v.x(), v.y(), v.z()); }

Json plane_json(const Plane& plane) { return Json::object("normal", vector_json(plane.normal), "d", plane.d); }

Json pose_json(const Eigen::Isometry3d& pose) {
  const Eigen::Quaterniond q(pose.linear());
  return Json::object("translation", vector_json(pose.translation()), "quaternion", Json::array(q.x(), q.y(), q.z(), q.w()));
}

Json box_json(const OrientedBox& box) {
  return Json::object("centre", vector_json(box.centre), "size", vector_json(box.size), "along", vector_json(box.along), "up",
                      vector_json(box.up), "yaw_rad", box.yaw_rad());
}

Json object_json(const TrueObject& object, const FrameToWrite& frame) {
  Json entry = Json::object("id", object.id);
  if (frame.objects) {
    entry.add("pixels", std::count(frame.objects->pixels.begin(), frame.objects->pixels.end(), object.id));
  }
  entry.add("box", box_json(object.box));
  entry.add("support", object.support ? plane_json(*object.support) : Json());
  entry.add("height_range_m", object.support ? Json::array(object.lowest_m, object.highest_m) : Json());
  return entry;
}

}  // namespace

Result<TruthJson> parse_truth_json(std::string_view text, const std::string& name) {
  const Result<Json> object = parse_json_object(text, name);
  if (!object) return object.error();
  const Json* const found = object->find("planes");
  if (found == nullptr) return field_error(name, "planes", "is missing");
  const Json::Array* const list = found->elements();
  if (list == nullptr) return field_error(name, "planes", "must be an array");
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
  const Json* const floor = object->find("floor");
  if (floor == nullptr) return truth;
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
  Json object = Json::object("labels_hold_for", frame.label_scope == LabelScope::sequence ? "sequence" : "frame");
  if (frame.T_world_camera) object.add("pose", pose_json(*frame.T_world_camera));
  if (frame.floor) object.add("floor", *frame.floor == 0 ? Json() : Json(*frame.floor));
  Json planes = Json::array();
  for (const auto& [label, plane] : frame.true_planes) {
    Json entry = Json::object("label", label, "normal", vector_json(plane.normal), "d", plane.d);
    if (counts) entry.add("pixels", counts->at(static_cast<std::uint8_t>(label)));
    planes.add(std::move(entry));
  }
  object.add("planes", std::move(planes));
  if (counts) {
    object.add("nonplane_pixels", counts->at(kLabelNoPlane));
    object.add("ignored_pixels", counts->at(0));
    object.add("valid_pixels",
               std::count_if(frame.depth.pixels.begin(), frame.depth.pixels.end(), [](auto raw) { return raw != 0; }));
  }
  Json objects = Json::array();
  for (const TrueObject& thing : frame.true_objects) objects.add(object_json(thing, frame));
  if (frame.objects || !frame.true_objects.empty()) object.add("objects", std::move(objects));
  return object.text();
}

}  // namespace fransac::io
