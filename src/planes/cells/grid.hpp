// SPDX-License-Identifier: Apache-2.0
/// A depth image as cells of inverse depth. On a plane q = 1/z is affine in the pixel, so a cell's least-squares fit is a plane
/// hypothesis of its own, and its moments add up with those of other cells (docs/algorithms.md, "Cells").
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "core/index.hpp"
#include "filter/depth_rows.hpp"
#include "fransac/core/aligned.hpp"
#include "fransac/core/camera.hpp"
#include "fransac/core/sensor.hpp"
#include "kernels/cell_sets.h"
#include "kernels/cells.h"
#include "planes/cells/image_rows.hpp"

namespace fransac::cells {

/// q = du * u + dv * v + base, per metre; u and v count samples from the image's centre.
struct InversePlane {
  double du = 0.0;
  double dv = 0.0;
  double base = 0.0;

  [[nodiscard]] double at(double u, double v) const { return du * u + dv * v + base; }
};

/// The same for tests of many cells.
struct FloatPlane {
  float du;
  float dv;
  float base;

  explicit FloatPlane(const InversePlane& plane)
      : du(static_cast<float>(plane.du)), dv(static_cast<float>(plane.dv)), base(static_cast<float>(plane.base)) {}
};

/// Sums over pixels of 1, u, v, q and their products.
struct Moments {
  double n = 0.0;
  double u = 0.0;
  double v = 0.0;
  double q = 0.0;
  double uu = 0.0;
  double uv = 0.0;
  double vv = 0.0;
  double uq = 0.0;
  double vq = 0.0;
  double qq = 0.0;

  Moments& operator+=(const Moments& o) {
    n += o.n;
    u += o.u;
    v += o.v;
    q += o.q;
    uu += o.uu;
    uv += o.uv;
    vv += o.vv;
    uq += o.uq;
    vq += o.vq;
    qq += o.qq;
    return *this;
  }
};

/// The least-squares plane of moments.
struct PlaneFit {
  InversePlane plane;
  double u = 0.0;  ///< Means.
  double v = 0.0;
  double q = 0.0;
  double uu = 0.0;  ///< Mean squares and products about the means.
  double uv = 0.0;
  double vv = 0.0;
  double mean_squared_residual = 0.0;
};
/// Nothing when the pixels lie on a line.
std::optional<PlaneFit> fit(const Moments& moments);

/// The frame's three errors. Pixel noise is each cell's own, Grid::sigma; the others are shares of it, and a length.
struct Noise {
  DepthNoise pixel;        ///< One sigma of a pixel by depth, over the frame.
  double shown = 0.0;      ///< A cell's mean and slopes (times half a cell) differ from its neighbours' by this share, as seen.
  double cell = 0.0;       ///< The same, as it is believed: no less than what errors make that all rows of a cell share.
  double slow = 0.0;       ///< Slow noise: what many cells share, as a share of the pixel noise.
  double shared = 0.0;     ///< Variance of slow noise over that of a pixel, less what independent errors would show as well.
  double slope_rad = 0.0;  ///< A cell's direction differs from its neighbours' by this, over the frame, radians.
  double near_m = 0.0;     ///< What of it is seen between neighbouring cells, and the step of depth, metres.
  double bias_m = 0.0;     ///< How far a plane may be bent or shifted, metres.
};

/// Cells are 8 x 8 samples and see about the same angle whatever the image's size: a sample is a pixel of a Kinect's image, one
/// of `parts` x `parts` equal parts of a larger pixel, or `merged` x `merged` smaller ones. One of the two is 1.
struct Sampling {
  int parts = 1;  ///< 1, 2 or 4.
  int merged = 1;

  /// Samples in the length of a pixel.
  [[nodiscard]] double per_pixel() const { return static_cast<double>(parts) / merged; }
  /// Pixels in the length of what kernels take for a cell: of merged ones, a part of it.
  [[nodiscard]] int side() const { return kernels::kCell / parts; }
  bool operator==(const Sampling&) const = default;
};
Sampling sampling_of(const Camera& camera);
/// Cells half as long, where depth is so precise that those know their direction well, too.
std::optional<Sampling> finer_sampling(const Noise& noise, const Sampling& sampling);

/// All arrays have a border of one cell without measurements, so that every cell has neighbours.
class Grid {
 public:
  Sampling sampling;
  Camera camera;    ///< Of the samples; without a size, which need not be whole.
  int columns = 0;  ///< Without the border.
  int rows = 0;
  int stride = 0;
  double width = 0.0;  ///< Of the image, samples.
  double height = 0.0;

  AlignedVector<float> n, u, v, q, uu, uv, vv, du, dv, residual;  ///< As kernels::CellMoments; u, v from the image's centre.
  AlignedVector<float> sigma;                                     ///< Pixel noise of this cell: one sigma of q, per metre.
  AlignedVector<float> slack;                                     ///< Square of what a member of a region may be off, per metre.
  AlignedVector<std::uint8_t> usable;
  AlignedVector<std::uint8_t> measured;
  // Sets of cells without the border: a bit each, rows of `words` words.
  std::size_t words = 0;
  std::vector<std::uint64_t> usable_set;
  std::vector<std::uint64_t> measured_set;  ///< Cells with a plane, usable or not.
  /// Usable cells that something joins to the next on the right, and to the one below.
  struct Links {
    std::vector<std::uint64_t> right;
    std::vector<std::uint64_t> down;
  };
  Links links;   ///< No jump and no bend: one plane, as far as two cells can tell.
  Links smooth;  ///< No jump and a slight bend: one surface.
  Noise noise;

  /// Kernels read whole vectors; arrays are that much longer than size().
  static constexpr std::size_t kPadding = 64;
  [[nodiscard]] std::size_t size() const { return static_cast<std::size_t>(stride) * static_cast<std::size_t>(rows + 2); }
  [[nodiscard]] int index(int row, int column) const { return (row + 1) * stride + column + 1; }
  [[nodiscard]] int step(int direction) const {
    return direction == 0 ? 1 : direction == 1 ? stride : direction == 2 ? -1 : -stride;
  }

  /// Whether a smooth surface goes on from a cell to the next on the right (0) or below (1).
  [[nodiscard]] bool is_smooth(int row, int column, int direction) const {
    const std::uint64_t* const set = direction == 0 ? smooth.right.data() : smooth.down.data();
    return (set[static_cast<std::size_t>(row) * words + static_cast<std::size_t>(column / kernels::kWordBits)] >>
                (column % kernels::kWordBits) &
            1U) != 0;
  }
  /// For kernels: the arrays from a cell on.
  [[nodiscard]] kernels::CellArrays arrays(int cell) const {
    return {n.data() + cell,
            u.data() + cell,
            v.data() + cell,
            q.data() + cell,
            uu.data() + cell,
            uv.data() + cell,
            vv.data() + cell,
            du.data() + cell,
            dv.data() + cell,
            residual.data() + cell,
            stride};
  }

  /// (alpha, beta, gamma) of q = alpha x + beta y + gamma, x and y on the camera's image plane at z = 1: for a plane n . p + d =
  /// 0 that is -n / d.
  [[nodiscard]] Eigen::Vector3d parameters(const InversePlane& plane) const {
    return {plane.du * camera.fx, plane.dv * camera.fy, plane.at(camera.cx - 0.5 * width, camera.cy - 0.5 * height)};
  }

  /// How far a cell is from a plane: its mean, and its slopes over half a cell, squared.
  struct Distance {
    float mean;
    float slope;

    [[nodiscard]] bool within(float squared_slack) const { return mean <= squared_slack && slope <= squared_slack; }
  };
  [[nodiscard]] Distance distance(int cell, const FloatPlane& plane) const {
    const auto i = static_cast<std::size_t>(cell);
    const float off = q[i] - (plane.du * u[i] + plane.dv * v[i] + plane.base);
    const float a = kHalfCell * (du[i] - plane.du);
    const float b = kHalfCell * (dv[i] - plane.dv);
    return {off * off, a * a + b * b};
  }
  static constexpr float kHalfCell = 0.5F * kernels::kCell;
};

/// Calls visit(row) for every row of cells, several at once.
template <class Visitor>
void for_each_row(int threads, const Grid& grid, const Visitor& visit) {
  parallel_for(threads, cell_row_tasks(grid.rows), [&](std::size_t task) { for_each_cell_row(task, grid.rows, visit); });
}

/// Memory of measure_cells.
struct GridBuffers {
  AlignedVector<float> sample;   ///< Some are kernels::kNone.
  AlignedVector<float> telling;  ///< Per cell: measurements of those that tell something of noise, else 0.
  AlignedVector<float> centred;  ///< Per cell: inverse depth at its centre.
  AlignedVector<float> least_residual;
  struct Task {
    std::size_t measured;        ///< Pixels of a row of cells.
    AlignedVector<float> parts;  ///< Moments of the cells of 8 x 8 pixels that are merged.
  };
  std::vector<Task> tasks;  ///< Per row of cells.
};

/// Fills the grid: cells, noise, usable cells, links. Returns how many pixels were measured.
template <class Raw>
std::size_t measure_cells(const ImageRows<Raw>& image, const DepthView& view, const Camera& camera, const SensorModel& sensor,
                          const SensorOptions& given, int threads, GridBuffers& buffers, Grid& grid);

}  // namespace fransac::cells
