// SPDX-License-Identifier: Apache-2.0
/// One frame's part of a report.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "../evaluation.hpp"
#include "fransac/io/dataset.hpp"
#include "fransac/io/overlay.hpp"
#include "html.hpp"

namespace fransac::cli::report {

/// A plane that a method found.
struct FoundPlane {
  int id = 0;
  std::uint8_t colour = 0;  ///< The label whose colour it has in the pictures.
  PlaneKind kind = PlaneKind::unknown;
  double area_m2 = 0.0;
  double rms_m = 0.0;
  double confidence = 1.0;
  std::uint64_t inliers = 0;
  Plane plane;
};

/// The planes of a method that tells of each what it is.
struct FoundPlanes {
  Method method = Method::cells;
  UpSource up_source = UpSource::none;
  std::vector<FoundPlane> planes;
};

struct Scene {
  std::string name;
  std::vector<Row> rows;  ///< One per method.
  io::DepthRange range;
  std::vector<Picture> views;        ///< Colour, depth, cloud, truth: what there is.
  std::vector<Picture> planes;       ///< One per method.
  std::vector<Picture> differences;  ///< One per method; none without truth.
  std::vector<FoundPlanes> found{};  ///< Of those methods that tell.
};

/// Draws a frame and what each method found in it, `width` pixels wide at most. Throws Failure.
Scene draw_scene(const io::FrameFiles& files, const io::Frame& frame, io::Truth truth, std::span<const Row> rows,
                 std::span<const Segmentation> segmentations, int width);

}  // namespace fransac::cli::report
