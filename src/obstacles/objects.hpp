// SPDX-License-Identifier: Apache-2.0
/// Pixels above a plane as objects: cut where the surface is concave or jumps, grouped by a watershed. docs/algorithms.md,
/// "Obstacles", derives the steps.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "filter/depth_rows.hpp"
#include "fransac/core/camera.hpp"
#include "fransac/core/plane.hpp"
#include "fransac/core/sensor.hpp"
#include "fransac/obstacles/obstacles.hpp"
#include "obstacles/support.hpp"

namespace fransac::obstacles {

/// An image of small square cells, with a border of empty ones.
struct CellImage {
  int side = 4;  ///< Of a cell, pixels.
  int columns = 0;
  int rows = 0;
  int stride = 0;

  static constexpr int kBorder = 3;
  [[nodiscard]] int index(int row, int column) const { return (row + kBorder) * stride + column + kBorder; }
  [[nodiscard]] int row(int cell) const { return cell / stride - kBorder; }
  [[nodiscard]] int column(int cell) const { return cell % stride - kBorder; }
  [[nodiscard]] bool in_border(int cell) const {
    const int r = row(cell);
    const int c = column(cell);
    return r < 0 || r >= rows || c < 0 || c >= columns;
  }
  [[nodiscard]] std::size_t size() const {
    return static_cast<std::size_t>(stride) * static_cast<std::size_t>(rows + 2 * kBorder);
  }
};

/// A cell, and where it is.
struct Cell {
  std::int32_t index;
  std::int32_t row;
  std::int32_t column;
};

/// Calls function(begin, end) for each row of cells that has any of a list in the image's order.
template <class Function>
void for_each_row(const std::vector<Cell>& cells, Function&& function) {
  const Cell* const end = cells.data() + cells.size();
  for (const Cell* first = cells.data(); first != end;) {
    const Cell* last = first + 1;
    while (last != end && last->row == first->row) ++last;
    function(first, last);
    first = last;
  }
}

/// The scene against its support.
struct Sides {
  CellImage cells;
  std::vector<double> ray_x;  ///< Through the middles of columns and of rows of cells, at depth 1.
  std::vector<double> ray_y;
  std::size_t stride = 0;            ///< Of `pixels`: whole groups of a kernel.
  std::vector<std::uint8_t> pixels;  ///< kernels::kAbove, kBelow, or 0.
  std::vector<std::uint8_t> seen;    ///< Per cell: 0, or any of its pixels is on the support.
  // Per cell: how many of its pixels are where, and their mean inverse depth; 0 without any.
  std::vector<std::uint16_t> above;
  std::vector<std::uint16_t> below;
  std::vector<float> q;         ///< Of those above.
  std::vector<float> q_below;   ///< Of those below.
  std::vector<Cell> any_above;  ///< Cells with pixels above, and
  std::vector<Cell> any_below;  ///< below, in the image's order.
  // Of one row of cells, as the kernel wants them.
  std::vector<std::uint8_t> kinds;
  std::vector<std::uint8_t> all_kinds;
  std::vector<std::uint8_t> seen_quads;
  std::vector<std::uint16_t> quads[2];
  std::vector<float> depths[2];
};

/// Least pixels that make a cell count: a quarter. What has fewer gets its label from its neighbours.
inline int least_pixels(int side) { return side * side / 4; }

/// A surface of an object at a cell, continued over the cells beside it: inverse depth by column and row of pixels.
struct Surface {
  std::uint16_t object = 0;
  float handicap = 0.0F;
  float q = 0.0F;
  float du = 0.0F;
  float dv = 0.0F;
  float u = 0.0F;  ///< Where it is q.
  float v = 0.0F;
};

/// What each pixel of a cell may be on.
struct Choice {
  int first_u = 0;              ///< Of the cell, pixels.
  std::uint16_t otherwise = 0;  ///< Of a pixel that is near none, and
  float most = 0.0F;            ///< how far from one it may be.
  std::array<Surface, 5> surfaces;
  int count = 0;
};

/// Sums over an object's pixels.
struct PixelSums {
  std::uint64_t count = 0;
  double z = 0.0;
  double zu = 0.0;
  double zv = 0.0;

  /// Some pixels about one place.
  void add(std::uint32_t pixels, float depth, float u, float v) {
    const double sum = static_cast<double>(depth) * pixels;
    count += pixels;
    z += sum;
    zu += sum * static_cast<double>(u);
    zv += sum * static_cast<double>(v);
  }
};

/// Memory of find_objects, and what it found.
struct Objects {
  int count = 0;
  std::vector<std::uint16_t> of_cell;   ///< Per cell: 0, or the object from 1.
  std::vector<Cell> cells;              ///< Those with enough pixels above, in the image's order.
  std::vector<std::uint32_t> on_plane;  ///< Per id and label of a plane, 0 for none: pixels.

  struct Link {
    std::int32_t a;
    std::int32_t b;
    float cut;  ///< How concave or how high a step, in units of what is cut.
  };
  /// Of one row of cells: links with a surface all around, and how strongly they are cut.
  struct Wholes {
    std::vector<std::uint8_t> is;
    std::vector<float> cut;
  };
  Wholes wholes[2];  ///< To the next column and to the next row.
  std::vector<Link> links;
  std::vector<Link> order;  ///< Those between parts, the weakest first.
  std::vector<std::uint8_t> on;
  std::vector<std::uint8_t> core;
  std::vector<std::uint8_t> seed;
  std::vector<float> sigma;  ///< Of inverse depth, per cell.
  std::vector<std::int32_t> parent;
  std::vector<std::int32_t> size;
  // Of one row of cells: the objects of cells that have one only, per column of pixels, and the other cells.
  std::vector<std::uint16_t> singles;
  std::vector<Choice> choices;
};

/// Tells on which side of the support every pixel is. `carriers` are the labels of the planes that carry.
template <class Raw>
void find_sides(const DepthRows<Raw>& rows, const Segmentation& segmentation, const std::vector<int>& carriers,
                const Plane& support, const DepthNoise& noise, const ObstacleOptions& options, DepthRowBuffer& buffer,
                Sides& sides);

/// Groups what is above.
void find_objects(const Sides& sides, const Camera& camera, const DepthNoise& noise, const ObstacleOptions& options,
                  Objects& objects);

/// Writes what `of_cell` says, an id of an obstacle, to each object's pixels and 0 to all others, and adds those up. `sums` has
/// an element per id.
template <class Raw>
void label_objects(const DepthRows<Raw>& rows, const Segmentation& segmentation, const Sides& sides, DepthRowBuffer& buffer,
                   Objects& objects, std::vector<PixelSums>& sums, std::vector<std::uint16_t>& labels);

}  // namespace fransac::obstacles
