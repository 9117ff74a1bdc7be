// SPDX-License-Identifier: Apache-2.0
#include "obstacle_output.hpp"

#include <fmt/format.h>

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numbers>

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

/// "floor", "horizontal" …; empty without a support.
std::string kind_of_support(const Segmentation& segmentation, const Obstacles& found) {
  if (found.support.empty()) return {};
  return std::string(enum_name(segmentation.planes[static_cast<std::size_t>(found.support.front() - kLabelFirst)].kind));
}

std::string why(const Obstacles& found) {
  const std::string advice = found.support_reason == SupportReason::up_unknown ? ": try --up" : "";
  return std::string(reason_text(found.support_reason)) + advice;
}

/// Empty without a doubt.
std::string doubt_text(const Segmentation& segmentation, const Obstacles& found) {
  constexpr double kDegrees = 180.0 / std::numbers::pi;
  switch (found.support_doubt) {
    case SupportDoubt::none: return {};
    case SupportDoubt::up_unknown: return "nothing tells what is up";
    case SupportDoubt::tilted: {
      const double cosine =
          std::min(1.0, std::abs(found.support_plane.normal.dot(segmentation.up.value_or(Eigen::Vector3d::Zero()))));
      return fmt::format("it is {:.1f} degrees from level", kDegrees * std::acos(cosine));
    }
    case SupportDoubt::up_uncertain:
      return fmt::format("up is known to {:.1f} degrees only: try --up", kDegrees * segmentation.up_sigma_rad);
    case SupportDoubt::something_lower: return "something is seen below it, and no floor";
  }
  return {};
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

Table support_table(bool frames) {
  std::vector<std::string> headings{"<support", "<kind", "<why", "<doubt"};
  if (frames) headings.insert(headings.begin(), "<frame");
  return Table(std::move(headings));
}

void add_support(Table& table, const std::optional<std::string>& frame, const Segmentation& segmentation,
                 const Obstacles& found) {
  std::vector<std::string> cells{found.support.empty() ? "none" : fmt::format("{}", fmt::join(found.support, " ")),
                                 kind_of_support(segmentation, found), why(found), doubt_text(segmentation, found)};
  if (frame) cells.insert(cells.begin(), *frame);
  table.add(std::move(cells));
}

std::string support_warning(const SupportChoice& support, const Segmentation& segmentation, const Obstacles& found) {
  const std::string choice = fmt::format("(--support {})", support_text(support));
  if (found.support.empty()) {
    return fmt::format("no support for obstacles {}: {}; all that is seen is an obstacle", choice, why(found));
  }
  const std::string doubt = doubt_text(segmentation, found);
  if (doubt.empty()) return {};
  return fmt::format("the support of obstacles {} is plane {}, kind {}, in doubt: {}", choice, found.support.front(),
                     kind_of_support(segmentation, found), doubt);
}

void add_support(nlohmann::ordered_json& json, const Segmentation& segmentation, const Obstacles& found) {
  const bool none = found.support.empty();
  const bool doubtful = found.support_doubt != SupportDoubt::none;
  json["support"] = none ? nlohmann::ordered_json() : nlohmann::ordered_json(found.support);
  json["support_kind"] = none ? nlohmann::ordered_json() : nlohmann::ordered_json(kind_of_support(segmentation, found));
  json["support_reason"] = enum_name(found.support_reason);
  json["support_doubt"] = doubtful ? nlohmann::ordered_json(enum_name(found.support_doubt)) : nlohmann::ordered_json();
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

nlohmann::ordered_json obstacles_to_json(const Segmentation& segmentation, const Obstacles& found) {
  nlohmann::ordered_json objects = nlohmann::ordered_json::array();
  for (const Obstacle& obstacle : found.obstacles) objects.push_back(obstacle_to_json(obstacle));
  nlohmann::ordered_json json;
  add_support(json, segmentation, found);
  json["ground"] = ground_to_json(found.ground);
  json["total_ms"] = found.total_ms;
  json["objects"] = std::move(objects);
  return json;
}

void add_outlines(nlohmann::ordered_json& json, const Obstacles& found, const std::vector<std::vector<Outline>>& of_planes,
                  const std::vector<std::vector<Outline>>& of_drops) {
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
