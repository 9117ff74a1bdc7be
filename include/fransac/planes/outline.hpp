// SPDX-License-Identifier: Apache-2.0
/// The outlines of segmented planes.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "fransac/core/camera.hpp"
#include "fransac/planes/segment.hpp"

namespace fransac {

/// How much of an outline is kept.
struct OutlineOptions {
  double tolerance_px = 1.0;  ///< Largest distance of a left-out corner to the simplified outline; 0: all corners stay.
  int min_pixels = 64;        ///< Smaller parts and smaller holes are left out.
};

/// A closed polygon of at least three corners; the last one is joined to the first. A ring can touch itself where pixels meet
/// at a corner only; simplified, it can cross itself or others by as much as the tolerance.
struct Ring {
  std::vector<Eigen::Vector2d> pixels;  ///< Corners between pixels: the centre of the top left pixel is (0, 0).
  std::vector<Eigen::Vector3d> points;  ///< Where the corners' rays meet the plane, metres, in the camera's frame. A ray that
                                        ///< passes within a pixel of the plane's horizon, or beyond it, gets the depth of one a
                                        ///< pixel before the horizon, and at most kMaxDepth_m: it then ends off the plane.
};

/// One visible part of a plane: pixels that hang together by their sides. Its area in pixels is that of the outer ring less
/// the holes' (exactly, with tolerance_px = 0 and min_pixels = 1).
struct Outline {
  /// Anticlockwise in the image as it is displayed, v pointing down, and so seen from the camera: the plane is on the left of
  /// who walks along; sum(u_i v_i+1 - u_i+1 v_i) < 0. In space right-handed about the plane's normal.
  Ring outer;
  std::vector<Ring> holes;  ///< The other way round, so the plane is on the left again.
};

/// The visible parts of every plane, those with most pixels first: the i-th element is of segmentation.planes[i]. The time is
/// linear in the pixels, for all planes together, but for simplification, which adds the logarithm of a ring's length.
/// All are empty where the camera is not valid or not of the size of the label image.
std::vector<std::vector<Outline>> outlines(const Segmentation& segmentation, const Camera& camera,
                                           const OutlineOptions& options = {});

/// The same of one plane. Empty when the label is none of `segmentation`'s.
std::vector<Outline> outlines(const Segmentation& segmentation, const Camera& camera, int id, const OutlineOptions& options = {});

}  // namespace fransac
