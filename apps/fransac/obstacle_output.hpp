// SPDX-License-Identifier: Apache-2.0
/// Obstacles as text, JSON and pictures.
#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>
#include <optional>
#include <span>
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

/// Obstacles in distinct colours, planes pale. `planes`: labels; `things`: a number per pixel that says the colour, 0 on none.
io::ColourImage obstacle_overlay(const DepthView& depth, std::vector<std::uint8_t> planes, std::span<const std::uint16_t> things,
                                 const io::ColourImage* background);
/// The label of the colour that a number from 1 has, for every number the same.
std::uint8_t colour_label(int number);

}  // namespace fransac::cli
