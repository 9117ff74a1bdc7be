// SPDX-License-Identifier: Apache-2.0
/// Obstacles as text, JSON and pictures.
#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>
#include <optional>
#include <span>
#include <string>
#include <vector>

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

/// Which planes are the support, why, and what speaks against them; with a column of frames' names or without.
Table support_table(bool frames);
/// A row; `frame` where the table has frames.
void add_support(Table& table, const std::optional<std::string>& frame, const Segmentation& segmentation, const Obstacles& found);

/// What a user must know of the support: that there is none, or a doubt; else empty.
std::string support_warning(const SupportChoice& support, const Segmentation& segmentation, const Obstacles& found);

/// Adds "support" (labels, null without), its kind, the reason and the doubt.
void add_support(nlohmann::ordered_json& json, const Segmentation& segmentation, const Obstacles& found);

nlohmann::ordered_json obstacle_to_json(const Obstacle& obstacle);
nlohmann::ordered_json obstacles_to_json(const Segmentation& segmentation, const Obstacles& found);
/// Adds the outlines of drops, and of the support as free space. `of_planes`: the segmentation's; `of_drops`: drop_outlines().
void add_outlines(nlohmann::ordered_json& json, const Obstacles& found, const std::vector<std::vector<Outline>>& of_planes,
                  const std::vector<std::vector<Outline>>& of_drops);

/// Obstacles in distinct colours, planes pale. `planes`: labels; `things`: a number per pixel that says the colour, 0 on none.
io::ColourImage obstacle_overlay(const DepthView& depth, std::vector<std::uint8_t> planes, std::span<const std::uint16_t> things,
                                 const io::ColourImage* background);
/// The label of the colour that a number from 1 has, for every number the same.
std::uint8_t colour_label(int number);

}  // namespace fransac::cli
