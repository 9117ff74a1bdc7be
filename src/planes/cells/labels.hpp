// SPDX-License-Identifier: Apache-2.0
/// Labels of all pixels from regions of cells.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "fransac/core/camera.hpp"
#include "planes/cells/grid.hpp"
#include "planes/cells/image_rows.hpp"
#include "planes/cells/regions.hpp"

namespace fransac::cells {

/// What the pixels of a plane show.
struct PixelEvidence {
  std::uint64_t count = 0;
  double squared_residual = 0.0;                  ///< Sum of (z q - 1)^2.
  double area_m2 = 0.0;                           ///< While summing: the sum of z^3.
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();  ///< Of the pixels' points on the plane, metres; while summing of (u z, v z, z).

  PixelEvidence& operator+=(const PixelEvidence& other);
};

/// The least and the greatest owner among a cell and its eight neighbours.
struct OwnerRange {
  AlignedVector<std::int16_t> least_of_row;  ///< Left and right only.
  AlignedVector<std::int16_t> greatest_of_row;
  AlignedVector<std::int16_t> least;     ///< Nobody does not count; 0x7fff where there is nobody else.
  AlignedVector<std::int16_t> greatest;  ///< kNobody where there are none.
};

/// What kernels take for cells, Sampling::side() pixels long, with a border of nobody's.
struct PixelCells {
  int columns = 0;
  int rows = 0;
  int stride = 0;
  int side = 0;  ///< Pixels.
  float floor_m = 0.0F;
  AlignedVector<std::int16_t> owner;  ///< After flooding; kNobody.
  AlignedVector<float> tolerance;     ///< Of inverse depth, per metre.
  AlignedVector<float> q;             ///< Inverse depth of the grid's cell.

  [[nodiscard]] std::size_t size() const { return static_cast<std::size_t>(stride) * static_cast<std::size_t>(rows + 2); }
  [[nodiscard]] int index(int row, int column) const { return (row + 1) * stride + column + 1; }
};

/// Memory of label_pixels.
struct LabelPixelBuffers {
  PixelCells cells;
  OwnerRange range;
  std::vector<std::int32_t> queue;
  struct Task {
    std::vector<PixelEvidence> planes;
    std::vector<std::uint8_t> rows;
    std::vector<std::uint8_t> counts;
  };
  std::vector<Task> tasks;
  std::vector<PixelEvidence> evidence;  ///< Per region of the list.
};

/// Labels every pixel with its region's label, `label_of_region[region]`, or 255, or 0 where nothing is kept. A region with label
/// 0 gets nothing. `labels` is the whole image.
template <class Raw>
void label_pixels(const ImageRows<Raw>& image, const DepthView& view, const Camera& camera, const Grid& grid,
                  const Regions& regions, const std::vector<std::uint8_t>& label_of_region, int threads,
                  LabelPixelBuffers& buffers, std::uint8_t* labels);

}  // namespace fransac::cells
