// SPDX-License-Identifier: Apache-2.0
/// What `fransac segment` is asked for.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <filesystem>
#include <initializer_list>
#include <optional>
#include <string>

#include "../inputs.hpp"
#include "../options.hpp"
#include "fransac/obstacles/occupancy.hpp"

namespace fransac::cli {

/// A kind of output and what the user called it: a file, or a folder with one file per frame.
struct Output {
  const char* option;
  const char* extension;                        ///< Of the files in a folder.
  std::initializer_list<const char*> accepted;  ///< What a single file's name may end in; empty: anything.
  std::string path{};                           ///< Empty: not asked for.

  [[nodiscard]] bool asked() const { return !path.empty(); }
  [[nodiscard]] bool to_stdout() const { return path == "-"; }
  /// Of the i-th frame.
  [[nodiscard]] std::filesystem::path file(const Input& input, std::size_t i) const {
    return input.is_folder_of_frames() ? std::filesystem::path(path) / (input.frames[i].name + extension)
                                       : std::filesystem::path(path);
  }
};

struct SegmentRequest {
  static constexpr auto kPicture = {".png"};
  static constexpr auto kCloud = {".pcd", ".ply"};

  std::string input;
  InputOptions inputs;
  std::optional<double> metres_per_unit;  ///< Of a cloud's coordinates.
  Output labels{"--labels", ".png", kPicture};
  Output json{"--json", ".json", {}};
  Output overlay{"--overlay", ".png", kPicture};
  Output cloud{"--cloud", ".ply", kCloud};
  Output obstacle_labels{"--obstacle-labels", ".png", kPicture};
  Output grid{"--grid-out", "", {}};  ///< A name without the endings of its two files.
  bool outlines = false;
  SegmentOptions options;
  ObstacleRequest obstacles;
  OccupancyOptions occupancy;

  [[nodiscard]] std::array<const Output*, 6> outputs() const {
    return {&labels, &obstacle_labels, &overlay, &cloud, &grid, &json};
  }
  [[nodiscard]] bool asks_for_output() const {
    const auto all = outputs();
    return std::any_of(all.begin(), all.end(), [](const Output* output) { return output->asked(); });
  }
};

}  // namespace fransac::cli
