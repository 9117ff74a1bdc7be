// SPDX-License-Identifier: Apache-2.0
/// One point per occupied leaf of a regular grid.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <memory>

#include "fransac/core/aligned.hpp"
#include "fransac/core/camera.hpp"
#include "fransac/core/depth_image.hpp"
#include "fransac/core/point_cloud.hpp"
#include "fransac/core/result.hpp"
#include "fransac/filter/pass_through.hpp"

namespace fransac {

/// Which point stands for a leaf.
enum class LeafPoint {
  centroid,  ///< The mean of the leaf's points.
  centre,    ///< The middle of the leaf's cube.
};

/// The result of a voxel grid, and the memory it is made in. Leaves are numbered in the order in which the input first enters
/// them. Not for concurrent use.
struct VoxelGrid {
  VoxelGrid();  ///< Empty.
  ~VoxelGrid();
  VoxelGrid(VoxelGrid&&) noexcept;
  VoxelGrid& operator=(VoxelGrid&&) noexcept;

  PointCloud leaves;                         ///< One point per occupied leaf; `source` is empty.
  AlignedVector<std::uint32_t> point_count;  ///< For each leaf the number of its input points.
  AlignedVector<std::uint32_t> leaf_of;      ///< For each input point or pixel its leaf or kNoLeaf; empty if not asked for.
  std::uint64_t points = 0;                  ///< Input points that lie in a leaf.
  std::uint64_t measured = 0;                ///< Those, and the pixels that limits took away.

  static constexpr std::uint32_t kNoLeaf = 0xFFFFFFFF;  ///< In leaf_of: in no leaf.

  /// floor(p / leaf_size) along each axis.
  using Index = Eigen::Matrix<std::int64_t, 3, 1>;
  /// Of the cloud's bounding box; zero for depth images.
  Index smallest = Index::Zero();
  Index largest = Index::Zero();  ///< Likewise.

  /// The leaf with this index, kNoLeaf where it holds no point. For grids of clouds; in those of depth images there is none.
  [[nodiscard]] std::uint32_t leaf_at(const Index& index) const;
  /// Where a finite point, in the cloud's local coordinates, lies in the lattice of the last grid of a cloud. Within the bounding
  /// box it is rounded as the cloud's own points were: leaf_at(index_at(p)) is the leaf of every input point p.
  [[nodiscard]] Index index_at(const Eigen::Vector3f& local_point) const;

  struct Scratch;
  std::unique_ptr<Scratch> scratch;  ///< Kept between calls; not part of the result.
};

/// Sorts the cloud's points (all finite) into cubes with an edge of `leaf_size_m` metres whose lattice contains the
/// origin of the input's coordinates: leaf index = floor(p / leaf_size), as in PCL. Keys are 64-bit and relative to the
/// cloud's smallest corner.
/// Fails with invalid_argument where leaf_size_m is not positive, or so small that keys of 63 bits (31 per axis) cannot tell
/// the cloud's leaves apart.
/// Reuses the grid's memory. `threads`: 0 all cores; never changes the answer.
Status voxel_grid(const PointCloud& cloud, double leaf_size_m, LeafPoint leaf_point, VoxelGrid& grid, int threads = 1);

/// How the voxel grid of points is made.
struct PointsGridOptions {
  Eigen::Vector3d leaf_size_m = Eigen::Vector3d::Constant(0.02);  ///< Edges of a leaf along x, y and z.
  LeafPoint leaf_point = LeafPoint::centroid;                     ///< The point that stands for it.
  bool leaf_of = false;                                           ///< Whether to fill VoxelGrid::leaf_of, which takes time.
  int threads = 1;                                                ///< 0: all cores. Never changes the answer.
};

/// The same with boxes whose edges along x, y and z have any lengths, and with leaf_of only where it is asked for.
Status voxel_grid(const PointCloud& cloud, const PointsGridOptions& options, VoxelGrid& grid);

/// The same as of the cloud of those points that are finite, several times faster than by way of one: points are read where they
/// are. The others are in no leaf. Errors: also a view without data or with a stride below 3 (invalid_argument).
Status voxel_grid(const PointsView& points, const PointsGridOptions& options, VoxelGrid& grid);

/// How the voxel grid of a depth image is made.
struct DepthGridOptions {
  double leaf_size_m = 0.02;                   ///< Edge of a leaf.
  LeafPoint leaf_point = LeafPoint::centroid;  ///< The point that stands for it.
  const AxisLimits* limits = nullptr;          ///< Pass-through; null: every measured pixel.
  bool leaf_of = false;                        ///< Whether to fill VoxelGrid::leaf_of (one per pixel), which takes time.
  int threads = 1;                             ///< 0: all cores. Never changes the answer.
};

/// Deprojection, pass-through and voxel grid of a depth image in one: the same leaves as those of the deprojected cloud (but for
/// pixels within float rounding of a leaf's border), several times faster because it follows the image's rows, where
/// neighbours mostly share a leaf.
/// Sums are exact and only centroids are rounded: 16-bit depth is added up in whole numbers; float depth as multiples of 2^-24 of
/// the largest depth (2^-21 for images of more than 2^18 pixels, and so on: the sum of all pixels fits into 40 bits).
/// A lattice too fine for keys of 28 bits, or an image of 2^24 pixels or more, goes by way of the cloud.
/// Expects a valid view and camera of the same size. Fails as above.
Status voxel_grid(const DepthView& depth, const Camera& camera, const DepthGridOptions& options, VoxelGrid& grid);

}  // namespace fransac
