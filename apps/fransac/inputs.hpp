// SPDX-License-Identifier: Apache-2.0
/// What commands work on: depth frames or a point cloud.
#pragma once

#include <string>
#include <variant>
#include <vector>

#include "doubts.hpp"
#include "fransac/core/point_cloud.hpp"
#include "fransac/io/dataset.hpp"
#include "fransac/planes/segment.hpp"
#include "options.hpp"
#include "progress.hpp"

namespace fransac::cli {

/// An input as it was named, with its frames found but not loaded.
struct Input {
  std::string name;
  io::InputKind kind = io::InputKind::depth_image;
  std::vector<io::FrameFiles> frames;  ///< Empty for a cloud.
  io::ReadLimits limits{};
  double metres_per_unit = 1.0;  ///< Of a cloud's coordinates.

  [[nodiscard]] bool is_cloud() const { return io::is_cloud(kind); }
  /// Whether it is the kind of input that holds many frames, however many these are.
  [[nodiscard]] bool is_folder_of_frames() const { return kind == io::InputKind::dataset || kind == io::InputKind::tum_sequence; }
  [[nodiscard]] std::size_t size() const { return is_cloud() ? 1 : frames.size(); }
  /// Names the i-th frame, or the cloud, in messages and results.
  [[nodiscard]] std::string name_of(std::size_t i) const { return is_folder_of_frames() ? frames[i].depth.string() : name; }
};

using Content = std::variant<io::Frame, PointCloud>;

/// Notes the input's files in `options`. Throws Failure, as the other functions here; UsageError for a camera with a cloud.
Input open_input(const std::string& name, InputOptions& options);
/// The same of the frames of an input that is no cloud.
io::Dataset open_frames(const std::string& name, InputOptions& options);
/// Doubts are said while `progress` is shown.
Content load(const Input& input, std::size_t i, Doubts& doubts, Progress& progress);
/// Segments in the workspace's memory; `name` is the input's name for messages.
void segment(const std::string& name, const Content& content, const SegmentOptions& options, Workspace& workspace,
             Segmentation& segmentation);

}  // namespace fransac::cli
