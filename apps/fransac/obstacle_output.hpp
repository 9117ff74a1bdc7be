// SPDX-License-Identifier: Apache-2.0
/// Obstacles as text, JSON and pictures.
#pragma once

#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "fransac/core/camera.hpp"
#include "fransac/core/depth_image.hpp"
#include "fransac/io/image.hpp"
#include "fransac/obstacles/obstacles.hpp"
#include "fransac/planes/outline.hpp"
#include "fransac/planes/segment.hpp"
#include "output.hpp"

namespace fransac::cli {

/// With a column of frames' names or without; of an image's pixels or a cloud's points.
Table obstacle_table(bool frames, bool cloud = false);
/// A row per obstacle; `frame` where the table has frames.
void add_obstacles(Table& table, const std::optional<std::string>& frame, const Obstacles& found);

/// Why there is no support.
std::string no_support_text(const SupportChoice& support, const Segmentation& segmentation);

nlohmann::ordered_json obstacle_to_json(const Obstacle& obstacle);
nlohmann::ordered_json obstacles_to_json(const Obstacles& found);
/// Adds the outlines of drops, and of the support as free space. `of_planes`: the segmentation's.
void add_outlines(nlohmann::ordered_json& json, const Obstacles& found, const std::vector<std::vector<Outline>>& of_planes,
                  const Camera& camera);

/// Obstacles in distinct colours, planes pale.
io::ColourImage obstacle_overlay(const DepthView& depth, const Segmentation& segmentation, const Obstacles& found,
                                 const io::ColourImage* background);

}  // namespace fransac::cli
