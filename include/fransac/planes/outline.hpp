// SPDX-License-Identifier: Apache-2.0
/// The outlines of segmented planes.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "fransac/core/camera.hpp"
#include "fransac/planes/segment.hpp"

namespace fransac {

struct OutlineOptions {
  double tolerance_px = 1.0;  ///< Largest distance of a left-out corner to the simplified outline.
  int min_pixels = 64;        ///< Smaller parts and smaller holes are left out.
};

/// A closed polygon; the last corner is joined to the first.
struct Ring {
  std::vector<Eigen::Vector2d> pixels;  ///< Corners between pixels: the centre of the top left pixel is (0, 0).
  std::vector<Eigen::Vector3d> points;  ///< The same corners on the plane, metres, in the camera's frame.
};

/// One visible part of a plane.
struct Outline {
  Ring outer;               ///< Anticlockwise seen from the camera.
  std::vector<Ring> holes;  ///< Clockwise.
};

/// The visible parts of the plane with this label, largest first. Empty when the label is none of `segmentation`'s.
std::vector<Outline> outlines(const Segmentation& segmentation, const Camera& camera, int id, const OutlineOptions& options = {});

}  // namespace fransac
