// SPDX-License-Identifier: Apache-2.0
/// From plane equations to a label per pixel or point, and each plane's evidence: inliers, rms and visible area.
#pragma once

#include <cstdint>
#include <vector>

#include "filter/depth_rows.hpp"
#include "fransac/core/aligned.hpp"
#include "fransac/core/camera.hpp"
#include "fransac/core/depth_image.hpp"
#include "fransac/filter/pass_through.hpp"
#include "fransac/filter/voxel_grid.hpp"
#include "fransac/planes/segment.hpp"
#include "kernels/points.h"
#include "planes/image_plane.hpp"
#include "planes/points_on_plane.hpp"

namespace fransac {

/// Which points may carry a plane's label.
struct LabelRule {
  double threshold_m = 0.0;
  const AxisLimits* limits = nullptr;  ///< Null: everywhere.
};

/// Sums over the pixels of a plane.
struct PlaneSums {
  std::uint64_t count = 0;
  double squared_distance = 0.0;
  double cubed_depth = 0.0;  ///< In raw units.

  PlaneSums& operator+=(const PlaneSums& other);
};

/// One task's rows.
struct LabelTask {
  DepthRowBuffer row;
  AlignedVector<std::uint8_t> labels;
  std::vector<kernels::LabelPlane> planes;
  std::vector<PlaneSums> evidence;
};

struct LabelBuffers {
  std::vector<LabelTask> tasks;
  AlignedVector<ImagePlane> planes;
  std::vector<std::uint8_t> leaf_labels;
  // Of clouds:
  std::vector<kernels::PlaneD> planes_of_points;
  std::vector<PlaneFrame> frames;
  std::vector<PointsOnPlane> points;
  std::vector<OccupiedCells> cells;
};

// A pixel or point gets the plane it is nearest to if that is within the threshold (eq. 1; ties: the smaller label),
// kLabelNoPlane otherwise, kLabelNoDepth without a measurement. segmentation.labels must have the input's size.

/// Labels a depth image and measures its planes in one go, straight from raw depth, |z (n . r) + d| <= t with n . r affine in the
/// column: no XYZ. The area is the sum of the pixels' footprints on the plane, z^3 / (fx fy |d|).
void label_image(const DepthView& depth, const Camera& camera, const LabelRule& rule, int threads, LabelBuffers& buffers,
                 Segmentation& segmentation);
/// The paper's way: pixels get the label of their leaf's point. `grid` must have `leaf_of`.
void label_image_by_leaves(const DepthView& depth, const Camera& camera, const VoxelGrid& grid, double threshold_m, int threads,
                           LabelBuffers& buffers, Segmentation& segmentation);

void label_points(const PointCloud& cloud, const LabelRule& rule, int threads, LabelBuffers& buffers, Segmentation& segmentation);
/// The paper's way: `points`, which went into the grid, get the label of their leaf's point.
void label_leaves(const PointCloud& points, const VoxelGrid& grid, double threshold_m, int threads, LabelBuffers& buffers,
                  Segmentation& segmentation);
/// The labels that leaves have; in the buffers.
const std::vector<std::uint8_t>& leaf_labels(const PointCloud& leaves, double threshold_m,
                                             const std::vector<PlaneSegment>& planes, int threads, LabelBuffers& buffers);
/// Leaves out planes that hardly any point is near although leaves are: their points are those of two surfaces, and the plane
/// stands between them. Whether there was one; points are then to be labelled again. The grid may hold a sample of the `points`.
bool remove_phantoms(const VoxelGrid& grid, std::size_t points, double threshold_m, int threads, LabelBuffers& buffers,
                     Segmentation& segmentation);
/// Inliers, rms and visible area from the labels. The area is that of the occupied cells of a grid on the plane, whose edge is
/// doubled from `cell_m` until a cell holds four points on average, so that evenly spread points leave few cells empty; at most
/// the area of the rectangle around them.
void measure_points(const PointCloud& cloud, double cell_m, int threads, LabelBuffers& buffers, Segmentation& segmentation);

}  // namespace fransac
