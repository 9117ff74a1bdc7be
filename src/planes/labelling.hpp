// SPDX-License-Identifier: Apache-2.0
/// From plane equations to a label per pixel or point, and each plane's evidence.
#pragma once

#include "fransac/core/aligned.hpp"
#include "fransac/core/camera.hpp"
#include "fransac/core/depth_image.hpp"
#include "fransac/filter/pass_through.hpp"
#include "fransac/filter/voxel_grid.hpp"
#include "fransac/planes/segment.hpp"

namespace fransac {

/// Which points may carry a plane's label.
struct LabelRule {
  double threshold_m = 0.0;
  const AxisLimits* limits = nullptr;  ///< Null: everywhere.
};

/// Buffers of one image row, padded with zeros (no depth) to whole blocks.
struct RowBuffers {
  AlignedVector<float> depth;
  AlignedVector<float> distance;
  AlignedVector<float> label;

  void resize(int width);
};

/// A pixel or point gets the plane it is nearest to if that is within the threshold (eq. 1; ties: the smaller label),
/// kLabelNoPlane otherwise, kLabelNoDepth without a measurement. segmentation.labels must have the input's size.
/// The image version works on raw depth, |z (n . r) + d| <= t with n . r affine in the column: no XYZ.
void label_image(const DepthView& depth, const Camera& camera, const LabelRule& rule, RowBuffers& row,
                 Segmentation& segmentation);
void label_points(const PointCloud& cloud, const LabelRule& rule, Segmentation& segmentation);

/// The paper's way: `points`, which went into the grid, get the label of their leaf's point.
void label_leaves(const PointCloud& points, const VoxelGrid& grid, double threshold_m, Segmentation& segmentation);

/// Inliers, rms and visible area of each plane from the labels. Images: the area is the sum of the pixels' footprints,
/// z^2 / (fx fy |n . r|). Clouds: the occupied cells of a grid on the plane, whose edge is doubled from `cell_m` until a
/// cell holds four points on average, so that evenly spread points leave few cells empty.
void measure_image(const DepthView& depth, const Camera& camera, RowBuffers& row, Segmentation& segmentation);
void measure_points(const PointCloud& cloud, double cell_m, Segmentation& segmentation);

}  // namespace fransac
