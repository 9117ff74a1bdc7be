// SPDX-License-Identifier: Apache-2.0
/// One frame's part of a report.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "../evaluation.hpp"
#include "fransac/io/dataset.hpp"
#include "fransac/io/overlay.hpp"

namespace fransac::cli::report {

struct Picture {
  std::string title;
  std::string note;  ///< May be empty.
  std::string alt;
  std::string uri;
  int width = 0;
  int height = 0;
};

struct Scene {
  std::string name;
  std::vector<Row> rows;  ///< One per method.
  io::DepthRange range;
  std::vector<Picture> views;        ///< Colour, depth, cloud, truth: what there is.
  std::vector<Picture> planes;       ///< One per method.
  std::vector<Picture> differences;  ///< One per method; none without truth.
};

/// Draws a frame and what each method found in it, `width` pixels wide at most. Throws Failure.
Scene draw_scene(const io::FrameFiles& files, const io::Frame& frame, io::Truth truth, std::span<const Row> rows,
                 std::span<const Segmentation> segmentations, int width);

}  // namespace fransac::cli::report
