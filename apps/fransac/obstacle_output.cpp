// SPDX-License-Identifier: Apache-2.0
#include "obstacle_output.hpp"

#include <fmt/format.h>

#include <cstddef>
#include <cstdint>

#include "fransac/core/labels.hpp"
#include "fransac/io/overlay.hpp"
#include "geometry_json.hpp"
#include "options.hpp"

namespace fransac::cli {
namespace {

nlohmann::ordered_json box_to_json(const UprightBox& box) {
  return {{"centre", vector_to_json(box.centre)}, {"size", vector_to_json(box.size)}, {"yaw_rad", box.yaw_rad}};
}

/// The x, y and z axes.
nlohmann::ordered_json ground_to_json(const GroundFrame& ground) {
  return {{"origin", vector_to_json(ground.origin)}, {"axes", matrix_to_json(ground.axes.transpose())}};
}

}  // namespace

Table obstacle_table(bool frames, bool cloud) {
  std::vector<std::string> headings{"obstacle",    "<kind",     cloud ? "points" : "pixels",
                                    "nearest [m]", "ahead [m]", "left [m]",
                                    "length [m]",  "width [m]", "low [m]",
                                    "high [m]",    "<contact",  "<planes"};
  if (frames) headings.insert(headings.begin(), "<frame");
  return Table(std::move(headings));
}

void add_obstacles(Table& table, const std::optional<std::string>& frame, const Obstacles& found) {
  const auto metres = [](double value) { return fmt::format("{:.3f}", value); };
  for (const Obstacle& obstacle : found.obstacles) {
    std::vector<std::string> cells{fmt::format("{}", obstacle.id),     std::string(enum_name(obstacle.kind)),
                                   fmt::format("{}", obstacle.pixels), metres(obstacle.nearest_m),
                                   metres(obstacle.box.centre.x()),    metres(obstacle.box.centre.y()),
                                   metres(obstacle.box.size.x()),      metres(obstacle.box.size.y()),
                                   metres(obstacle.min_height_m),      metres(obstacle.max_height_m),
                                   obstacle.contact ? "yes" : "no",    fmt::format("{}", fmt::join(obstacle.planes, " "))};
    if (frame) cells.insert(cells.begin(), *frame);
    table.add(std::move(cells));
  }
}

std::string no_support_text(const SupportChoice& support, const Segmentation& segmentation) {
  const std::size_t planes = segmentation.planes.size();
  std::string why = fmt::format("planes found: {}", planes);
  if (planes > 0 && support.kind == SupportKind::floor) why = "no plane is a floor";
  if (planes > 0 && support.kind == SupportKind::table) why = "no plane is horizontal other than floor and ceiling";
  if (planes > 0 && support.kind != SupportKind::plane && !segmentation.up) why += ", for nothing tells what is up: try --up";
  return fmt::format("no support for obstacles (--support {}): {}", support_text(support), why);
}

nlohmann::ordered_json obstacle_to_json(const Obstacle& obstacle) {
  return {{"id", obstacle.id},
          {"kind", enum_name(obstacle.kind)},
          {"pixels", obstacle.pixels},
          {"centroid", vector_to_json(obstacle.centroid)},
          {"box", box_to_json(obstacle.box)},
          {"min_height_m", obstacle.min_height_m},
          {"max_height_m", obstacle.max_height_m},
          {"nearest_m", obstacle.nearest_m},
          {"contact", obstacle.contact},
          {"planes", obstacle.planes}};
}

nlohmann::ordered_json obstacles_to_json(const Obstacles& found) {
  nlohmann::ordered_json objects = nlohmann::ordered_json::array();
  for (const Obstacle& obstacle : found.obstacles) objects.push_back(obstacle_to_json(obstacle));
  nlohmann::ordered_json json;
  json["support"] = found.support;
  json["ground"] = found.support.empty() ? nullptr : ground_to_json(found.ground);
  json["total_ms"] = found.total_ms;
  json["objects"] = std::move(objects);
  return json;
}

void add_outlines(nlohmann::ordered_json& json, const Obstacles& found, const std::vector<std::vector<Outline>>& of_planes,
                  const Camera& camera) {
  const std::vector<std::vector<Outline>> of_drops = drop_outlines(found, camera);
  for (std::size_t i = 0; i < found.obstacles.size(); ++i) {
    if (found.obstacles[i].kind == ObstacleKind::drop) json["objects"][i]["outlines"] = outlines_to_json(of_drops[i]);
  }
  std::vector<Outline> free_space;
  for (const int plane : found.support) {
    const std::vector<Outline>& parts = of_planes[static_cast<std::size_t>(plane - kLabelFirst)];
    free_space.insert(free_space.end(), parts.begin(), parts.end());
  }
  json["free_space"] = outlines_to_json(free_space);
}

std::uint8_t colour_label(int number) { return static_cast<std::uint8_t>(kLabelFirst + (number - 1) % kMaxPlanes); }

io::ColourImage obstacle_overlay(const DepthView& depth, std::vector<std::uint8_t> planes, std::span<const std::uint16_t> things,
                                 const io::ColourImage* background) {
  std::vector<std::uint8_t> labels(planes.size(), kLabelNoPlane);
  for (std::size_t i = 0; i < planes.size(); ++i) {
    if (things[i] == 0) continue;
    planes[i] = kLabelNoPlane;
    labels[i] = colour_label(things[i]);
  }
  // What is on no plane, as the planes are for the second call, becomes pale.
  const io::ColourImage pale = io::overlay(depth, planes, background);
  return io::overlay(depth, labels, &pale);
}

}  // namespace fransac::cli
