// SPDX-License-Identifier: Apache-2.0
/// What `fransac segment` finds in one frame or cloud: all that is asked for, finished, for writers that compute nothing.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "fransac/io/image.hpp"
#include "fransac/planes/outline.hpp"
#include "request.hpp"

namespace fransac::cli {

struct SegmentResult {
  std::string name;                  ///< Of the frame or cloud, for messages.
  std::optional<std::string> frame;  ///< Its name in a folder of frames.
  Content content;                   ///< As it was read.
  Segmentation segmentation;
  std::optional<Obstacles> obstacles;               ///< As the next ones: empty where not asked for.
  std::vector<std::vector<Outline>> outlines;       ///< Of each plane.
  std::vector<std::vector<Outline>> drop_outlines;  ///< Of each obstacle; empty unless it is a drop.
  std::optional<OccupancyGrid> grid;
  std::optional<io::ColourImage> overlay;
  std::optional<PointCloud> points;  ///< Of a depth image, corrected as the segmentation was.

  [[nodiscard]] const PointCloud* cloud() const { return std::get_if<PointCloud>(&content); }
  [[nodiscard]] const io::Frame& image() const { return std::get<io::Frame>(content); }
};

/// Finds frame after frame in the same memory.
class Segmenter {
 public:
  Segmenter(const SegmentRequest& request, const Input& input) : request_(request), input_(input) {}

  /// The result stays as it is until the next call. Throws Failure or UsageError. Doubts are said while `progress` is shown.
  const SegmentResult& find(std::size_t i, Progress& progress);

 private:
  Status find_obstacles_in_content();
  void outline();
  io::ColourImage draw_overlay(std::size_t i) const;
  [[nodiscard]] PointCloud points_of_image() const;

  const SegmentRequest& request_;
  const Input& input_;
  Doubts doubts_;
  Workspace workspace_;
  ObstacleWorkspace obstacle_workspace_;
  SegmentResult result_;
};

}  // namespace fransac::cli
