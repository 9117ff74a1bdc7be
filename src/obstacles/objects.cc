// SPDX-License-Identifier: Apache-2.0
#include "obstacles/objects.hpp"

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <numeric>

#include "core/union_find.hpp"
#include "kernels/heights.h"
#include "kernels/labels.h"

namespace fransac::obstacles {
namespace {

/// Focal length of the Kinect v1, for which sizes in pixels below are known: they are angles.
constexpr double kKinectFocal = 525.0;

/// A cell is as large as the distance over which neighbouring pixels of a Kinect err together, 4 to 6 pixels (smaller ones know
/// no more), and as the smallest thing that shall be seen, 6 mm at 0.85 m. Whole quads of the kernel; 16 bits count its pixels.
int cell_side(const Camera& camera) {
  const double quads = 0.5 * (camera.fx + camera.fy) / kKinectFocal;
  constexpr int kMostQuads = 63;
  return static_cast<int>(kernels::kQuad) * std::clamp(static_cast<int>(std::lround(quads)), 1, kMostQuads);
}

/// How far edges of things are off sideways, pixels of a Kinect v1 (Nguyen, Izadi and Lovell, "Modeling Kinect Sensor Noise for
/// Improved 3D Reconstruction and Tracking", 3DIMPVT 2012: 0.8 px at most slants).
constexpr double kLateral_px = 0.8;

void resize(const Camera& camera, int width, int height, std::size_t stride, Sides& sides) {
  CellImage& cells = sides.cells;
  const int side = cell_side(camera);
  cells.side = side;
  cells.columns = (width + side - 1) / side;
  cells.rows = (height + side - 1) / side;
  cells.stride = cells.columns + 2 * CellImage::kBorder;
  const std::size_t size = cells.size();
  sides.stride = stride;
  sides.pixels.resize(stride * at(height));
  sides.seen.assign(size, 0);
  sides.above.assign(size, 0);
  sides.below.assign(size, 0);
  sides.q.assign(size, 0.0F);
  sides.q_below.assign(size, 0.0F);
  sides.any_above.clear();
  sides.any_below.clear();
  sides.ray_x.resize(at(cells.columns));
  sides.ray_y.resize(at(cells.rows));
  const auto middle = [&](int cell) { return (cell + 0.5) * side - 0.5; };
  for (int c = 0; c < cells.columns; ++c) sides.ray_x[at(c)] = (middle(c) - camera.cx) / camera.fx;
  for (int r = 0; r < cells.rows; ++r) sides.ray_y[at(r)] = (middle(r) - camera.cy) / camera.fy;
}

/// Nothing is nearer than a micrometre: powers of inverse depths stay within floats.
constexpr float kMostInverse = 1e6F;

/// Adds the quads of each cell up.
template <class Number>
void add_up(std::size_t per_cell, std::vector<Number>& quads) {
  if (per_cell == 1) return;
  for (std::size_t first = 0; first < quads.size(); first += per_cell) {
    quads[first / per_cell] = std::accumulate(&quads[first], &quads[first] + per_cell, Number{0});
  }
}

/// Takes what was added up over the quads of a row of cells, as mean inverse depths, and lists cells that have any pixels.
void gather(int row, const CellImage& cells, std::vector<std::uint16_t>& quads, std::vector<float>& depths,
            std::vector<std::uint16_t>& counts, std::vector<float>& q, std::vector<Cell>& any) {
  std::uint16_t some = 0;
  for (const std::uint16_t quad : quads) some |= quad;
  if (some == 0) return;
  add_up(at(cells.side) / kernels::kQuad, quads);
  add_up(at(cells.side) / kernels::kQuad, depths);
  const int first = cells.index(row, 0);
  for (int column = 0; column < cells.columns; ++column) {
    const std::uint16_t count = quads[at(column)];
    if (count == 0) continue;
    counts[at(first + column)] = count;
    q[at(first + column)] = std::min(static_cast<float>(count) / depths[at(column)], kMostInverse);
    any.push_back({first + column, row, column});
  }
}

/// Adds a row's kinds to those of other rows.
void add_kinds(const std::vector<std::uint8_t>& row, std::vector<std::uint8_t>& all) {
  const std::uint8_t* const __restrict from = row.data();
  std::uint8_t* const __restrict to = all.data();
  const std::size_t size = row.size();
  for (std::size_t u = 0; u < size; ++u) to[u] |= from[u];
}

/// Cells of which any pixel is on the support.
void mark_seen(const std::vector<std::uint8_t>& kinds, const CellImage& cells, std::vector<std::uint8_t>& quads,
               std::uint8_t* seen) {
  quads.resize(kinds.size() / kernels::kQuad);
  for (std::size_t k = 0; k < quads.size(); ++k) {
    std::uint32_t quad = 0;
    std::memcpy(&quad, &kinds[k * kernels::kQuad], sizeof quad);
    constexpr std::uint32_t kOn = 0x01010101U * kernels::kOnPlane;
    quads[k] = (quad & kOn) != 0 ? 1 : 0;
  }
  add_up(at(cells.side) / kernels::kQuad, quads);
  std::copy_n(quads.begin(), cells.columns, seen);
}

/// Finds how strongly the surface is cut between neighbouring cells.
class Linker {
 public:
  Linker(const Sides& sides, const Camera& camera, Objects& objects)
      : cells_(sides.cells), q_(sides.q.data()), seen_(sides.seen.data()), on_(objects.on.data()), o_(objects) {
    const double lateral = kLateral_px * 0.5 * (camera.fx + camera.fy) / kKinectFocal / cells_.side;  // in cells
    lateral_ = static_cast<float>(lateral * lateral);
  }

  void run() {
    o_.core.assign(cells_.size(), 1);
    o_.links.resize(2 * o_.cells.size());
    Objects::Link* end = o_.links.data();
    for_each_row(o_.cells, [&](const Cell* first, const Cell* last) {
      const int from = first->index;
      const int count = (last - 1)->index - from + 1;
      cut_wholes(from, count, 1, o_.wholes[0]);
      cut_wholes(from, count, cells_.stride, o_.wholes[1]);
      for (const Cell* cell = first; cell != last; ++cell) {
        for (std::size_t k = 0; k < 2; ++k) {
          const int a = cell->index;
          const int step = k == 0 ? 1 : cells_.stride;
          const bool whole = o_.wholes[k].is[at(a - from)] != 0;
          end = whole ? add(a, a + step, o_.wholes[k].cut[at(a - from)], end) : link(a, step, end);
        }
      }
    });
    o_.links.resize(static_cast<std::size_t>(end - o_.links.data()));
  }

 private:
  // One in a hundred links of a smooth surface may be cut by chance: cores do without.
  static constexpr float kValleySigmas = 2.5F;
  static constexpr float kStepSigmas = 3.0F;
  // Of errors that neighbours share: a slope to the left, a slope to the right and the cell between, counted twice, have the
  // variance 1 + 1 + 4; two cells and what a slope foretells, 1 + 1 + 1.
  static constexpr float kValley = 1.0F / (kValleySigmas * 2.449F);
  static constexpr float kStep = 1.0F / (kStepSigmas * 1.732F);
  static constexpr float kOneSided = 1.0F / (kStepSigmas * 2.449F);

  /// Slopes reach over so many cells: beyond the distance over which pixels err together.
  static constexpr int kReach = 2;
  static_assert(kReach < CellImage::kBorder);

  /// Finds where the surface goes on as far as can be on both sides of a link, as it does nearly everywhere, and what cut() is
  /// there: from each of some cells to the next one.
  void cut_wholes(int from, int count, int step, Objects::Wholes& wholes) const {
    wholes.is.resize(at(count));
    wholes.cut.resize(at(count));
    const std::uint8_t* const on = on_ + from;
    std::uint8_t* const __restrict is = wholes.is.data();
    static_assert(kReach == 2);
    for (int i = 0; i < count; ++i) {
      is[i] = on[i - 2 * step] & on[i - step] & on[i] & on[i + step] & on[i + 2 * step] & on[i + 3 * step];
    }
    const float* const a = q_ + from;
    const float* const sigmas = &o_.sigma[at(from)];
    float* const __restrict out = wholes.cut.data();
    const float lateral = lateral_;
    for (int i = 0; i < count; ++i) {
      const float left = (a[i] - a[i - 2 * step]) / 2.0F;
      const float right = (a[i + 3 * step] - a[i + step]) / 2.0F;
      const float slope = std::max(std::abs(left), std::abs(right));
      const float per = 1.0F / std::sqrt(sigmas[i] * sigmas[i] + lateral * slope * slope);
      const float valley = (right - left) * 2.0F * kValley;
      const float jump = std::abs(a[i + step] - a[i] - 0.5F * (left + right)) * kStep;
      out[i] = std::max(valley, jump) * per;
    }
  }

  /// How many cells the surface goes on from a cell.
  [[nodiscard]] int reach(int cell, int step) const {
    return on_[cell + step] == 0 ? 0 : on_[cell + kReach * step] == 0 ? 1 : kReach;
  }

  /// A cell that shows neither the surface nor the support: the surface may go on behind it.
  [[nodiscard]] bool is_gap(int cell) const { return on_[cell] == 0 && seen_[cell] == 0 && !cells_.in_border(cell); }

  /// Writes a link of neighbours and returns the end of what is written.
  Objects::Link* add(int a, int b, float cut, Objects::Link* end) const {
    if (cut >= 1.0F) o_.core[at(a)] = o_.core[at(b)] = 0;
    *end = {a, b, cut};
    return end + 1;
  }

  /// Likewise the link from a cell to the next one, if there is one.
  Objects::Link* link(int a, int step, Objects::Link* end) const {
    int b = a + step;
    if (on_[b] != 0) return add(a, b, cut_between(a, b, step), end);
    if (!is_gap(b)) return end;
    b += step;
    if (on_[b] == 0) return end;
    const float cut = cut_across(a, b, step);
    if (cut >= 1.0F) return end;
    *end = {a, b, cut};
    return end + 1;
  }

  /// One sigma of the differences, for a surface with a slope per cell.
  [[nodiscard]] float per_sigma(int a, float slope) const {
    const float sigma = o_.sigma[at(a)];
    return 1.0F / std::sqrt(sigma * sigma + lateral_ * slope * slope);
  }

  [[nodiscard]] float cut_between(int a, int b, int step) const {
    const int before = reach(a, -step);
    const int after = reach(b, step);
    if (before > 0 && after > 0) return cut(a, b, step, before, after, 1.0F);
    const float slope = before > 0 ? slope_before(a, step, before) : after > 0 ? slope_after(b, step, after) : 0.0F;
    return std::abs(q_[b] - q_[a] - slope) * per_sigma(a, slope) * kOneSided;
  }

  [[nodiscard]] float cut_across(int a, int b, int step) const {
    const int before = reach(a, -step);
    const int after = reach(b, step);
    return before > 0 && after > 0 ? cut(a, b, step, before, after, 2.0F) : std::numeric_limits<float>::infinity();
  }

  /// Inverse depth per cell, over one or two of them.
  [[nodiscard]] float slope_before(int a, int step, int before) const {
    return before == kReach ? (q_[a] - q_[a - kReach * step]) / kReach : q_[a] - q_[a - step];
  }
  [[nodiscard]] float slope_after(int b, int step, int after) const {
    return after == kReach ? (q_[b + kReach * step] - q_[b]) / kReach : q_[b + step] - q_[b];
  }

  /// Two neighbours `gap` cells apart with slopes on both sides: a valley, where both are nearer than the other's slope
  /// foretells, or a step.
  [[nodiscard]] float cut(int a, int b, int step, int before, int after, float gap) const {
    const float left = slope_before(a, step, before);
    const float right = slope_after(b, step, after);
    const float per = per_sigma(a, std::max(std::abs(left), std::abs(right)));
    const float valley = (right - left) * static_cast<float>(std::min(before, after)) * kValley;
    const float jump = std::abs(q_[b] - q_[a] - 0.5F * gap * (left + right)) * kStep / (0.5F + 0.5F * gap);
    return std::max(valley, jump) * per;
  }

  const CellImage& cells_;
  const float* q_;
  const std::uint8_t* seen_;
  const std::uint8_t* on_;
  Objects& o_;
  float lateral_ = 0.0F;
};

/// Groups cells: cores first, the rest by the strength of what cuts it off.
class Grouper {
 public:
  Grouper(const Sides& sides, const Camera& camera, const ObstacleOptions& options, Objects& objects)
      : s_(sides),
        options_(options),
        o_(objects),
        cells_per_m2_(static_cast<float>(camera.fx * camera.fy / (sides.cells.side * sides.cells.side))) {}

  void run() {
    o_.parent.resize(s_.cells.size());
    o_.size.resize(s_.cells.size());
    o_.seed.assign(s_.cells.size(), 0);
    for (const Cell& cell : o_.cells) {
      o_.parent[at(cell.index)] = cell.index;
      o_.size[at(cell.index)] = 0;
    }
    join_cores();
    join_rest();
    number();
  }

 private:
  int root(int cell) { return root_of(o_.parent.data(), std::int32_t{cell}); }

  /// Cells that show so much of a surface at a cell's distance: at least three, flying pixels make two.
  [[nodiscard]] float cells_of(int cell, double size_m) const {
    const float q = s_.q[at(cell)];
    return std::max(3.0F, static_cast<float>(size_m * size_m) * cells_per_m2_ * q * q);
  }

  /// Makes every cell's parent its root. Parents come before their children.
  void flatten() {
    std::int32_t* const parent = o_.parent.data();
    for (const Cell& cell : o_.cells) parent[cell.index] = parent[parent[cell.index]];
  }

  /// Cells without any cut are cores; those that hang together and are large enough are objects of their own.
  void join_cores() {
    for (const Objects::Link& link : o_.links) {
      if ((o_.core[at(link.a)] & o_.core[at(link.b)]) == 0 || o_.parent[at(link.a)] == o_.parent[at(link.b)]) continue;
      join_roots(o_.parent.data(), root(link.a), root(link.b));
    }
    flatten();
    for (const Cell& cell : o_.cells) ++o_.size[at(o_.parent[at(cell.index)])];
    for (const Cell& cell : o_.cells) {
      const std::size_t i = at(cell.index);
      if (o_.parent[i] != cell.index || o_.core[i] == 0) continue;
      o_.seed[i] = static_cast<float>(o_.size[i]) >= cells_of(cell.index, options_.touching_size_m) ? 1 : 0;
    }
  }

  /// A watershed: the weakest cut first, and never two objects.
  void join_rest() {
    keep_open_links();
    sort_links();
    for (const Objects::Link& link : o_.order) {
      const auto [low, high] = std::minmax({root(link.a), root(link.b)});
      if (low == high || (o_.seed[at(low)] != 0 && o_.seed[at(high)] != 0)) continue;
      const auto smaller = static_cast<float>(std::min(o_.size[at(low)], o_.size[at(high)]));
      if (link.cut >= kTooStrong && smaller >= cells_of(low, options_.touching_size_m)) continue;
      join_roots(o_.parent.data(), low, high);
      o_.size[at(low)] += o_.size[at(high)];
      o_.seed[at(low)] |= o_.seed[at(high)];
    }
    flatten();
  }

  /// Leaves out links within a core and between two objects: they change nothing.
  void keep_open_links() {
    const std::int32_t* const parent = o_.parent.data();
    const std::uint8_t* const seed = o_.seed.data();
    const auto is_settled = [&](const Objects::Link& link) {
      const std::int32_t a = parent[link.a];
      const std::int32_t b = parent[link.b];
      return a == b || (seed[a] & seed[b]) != 0;
    };
    o_.links.erase(std::remove_if(o_.links.begin(), o_.links.end(), is_settled), o_.links.end());
  }

  /// A counting sort in steps of a sixteenth; of equal ones the first in the image comes first.
  void sort_links() {
    constexpr float kSteps = 16.0F;
    constexpr std::size_t kBins = 130;
    const auto bin = [](float cut) {
      return static_cast<std::size_t>(static_cast<int>(std::clamp((cut + 1.0F) * kSteps, 0.0F, kBins - 2.0F)));
    };
    std::array<std::uint32_t, kBins> first{};
    for (const Objects::Link& link : o_.links) ++first[bin(link.cut) + 1];
    std::partial_sum(first.begin(), first.end(), first.begin());
    o_.order.resize(o_.links.size());
    for (const Objects::Link& link : o_.links) o_.order[first[bin(link.cut)]++] = link;
  }

  void number() {
    o_.count = 0;
    o_.of_cell.assign(s_.cells.size(), 0);
    for (const Cell& cell : o_.cells) {
      const std::size_t i = at(cell.index);
      if (o_.parent[i] != cell.index || static_cast<float>(o_.size[i]) < cells_of(cell.index, options_.min_size_m)) continue;
      if (o_.count == kMostObjects) break;
      o_.of_cell[i] = static_cast<std::uint16_t>(++o_.count);
    }
    // A root is the first of its cells in the image: it is not written over before the others have read it.
    for (const Cell& cell : o_.cells) o_.of_cell[at(cell.index)] = o_.of_cell[at(o_.parent[at(cell.index)])];
  }

  /// Behind such a cut a piece as large as an object stays alone even without a core.
  static constexpr float kTooStrong = 3.0F;

  const Sides& s_;
  const ObstacleOptions& options_;
  Objects& o_;
  float cells_per_m2_;
};

class PixelLabeller {
 public:
  PixelLabeller(const Sides& sides, const Objects& objects) : s_(sides), o_(objects), cells_(sides.cells) {}

  /// Whether all pixels of a cell are of the cell's object: no neighbour is of another.
  [[nodiscard]] bool is_single(int cell) const {
    const std::uint16_t* const here = &o_.of_cell[at(cell)];
    const auto is_other = [own = *here](std::uint16_t next) { return (next != 0) & (next != own); };
    return *here != 0 &&
           !(is_other(here[-cells_.stride]) | is_other(here[-1]) | is_other(here[1]) | is_other(here[cells_.stride]));
  }

  /// What the cell's pixels may be on.
  [[nodiscard]] Choice choose(const Cell& cell) const {
    Choice choice;
    const std::uint16_t own = o_.of_cell[at(cell.index)];
    choice.first_u = cell.column * cells_.side;
    choice.otherwise = own;
    choice.most = std::numeric_limits<float>::infinity();
    if (own != 0) add(cell, 0.0F, choice);
    constexpr float kNear = 10.0F;  // sigmas; of pixels in cells that have too few
    const auto add_next = [&](const Cell& next) {
      const std::uint16_t other = o_.of_cell[at(next.index)];
      if (other == 0 || other == own) return;
      add(next, own != 0 ? o_.sigma[at(next.index)] : 0.0F, choice);
      if (own == 0) choice.most = kNear * o_.sigma[at(next.index)];
    };
    add_next({cell.index - cells_.stride, cell.row - 1, cell.column});
    add_next({cell.index - 1, cell.row, cell.column - 1});
    add_next({cell.index + 1, cell.row, cell.column + 1});
    add_next({cell.index + cells_.stride, cell.row + 1, cell.column});
    return choice;
  }

 private:
  void add(const Cell& cell, float handicap, Choice& choice) const {
    const std::uint16_t object = o_.of_cell[at(cell.index)];
    const auto side = static_cast<float>(cells_.side);
    const auto slope = [&](int step) {
      const bool before = o_.of_cell[at(cell.index - step)] == object;
      const bool after = o_.of_cell[at(cell.index + step)] == object;
      const float first = s_.q[at(before ? cell.index - step : cell.index)];
      const float last = s_.q[at(after ? cell.index + step : cell.index)];
      return before || after ? (last - first) / (before && after ? 2.0F * side : side) : 0.0F;
    };
    choice.surfaces[at(choice.count++)] = {.object = object,
                                           .handicap = handicap,
                                           .q = s_.q[at(cell.index)],
                                           .du = slope(1),
                                           .dv = slope(cells_.stride),
                                           .u = (static_cast<float>(cell.column) + 0.5F) * side - 0.5F,
                                           .v = (static_cast<float>(cell.row) + 0.5F) * side - 0.5F};
  }

  const Sides& s_;
  const Objects& o_;
  const CellImage& cells_;
};

/// Four pixels.
using Quad = Eigen::Array4f;
static_assert(kernels::kQuad == 4);

/// What each of four pixels from (u, v) is on, by their inverse depths.
class Nearest {
 public:
  Nearest(const Choice& choice, int u, int v, const Quad& q) : choice_(choice), least_(Quad::Constant(choice.most)) {
    const Quad columns = static_cast<float>(u) + Quad(0.0F, 1.0F, 2.0F, 3.0F);
    for (int i = 0; i < choice.count; ++i) {
      const Surface& s = choice.surfaces[at(i)];
      distances_[at(i)] = (s.q + s.du * (columns - s.u) + s.dv * (static_cast<float>(v) - s.v) - q).abs() + s.handicap;
      least_ = least_.min(distances_[at(i)]);
    }
  }

  [[nodiscard]] std::uint16_t object(Eigen::Index pixel) const {
    for (int i = 0; i < choice_.count; ++i) {
      if (distances_[at(i)][pixel] == least_[pixel]) return choice_.surfaces[at(i)].object;
    }
    return choice_.otherwise;
  }

 private:
  const Choice& choice_;
  std::array<Quad, 5> distances_;
  Quad least_;
};

/// Writes to each pixel above the support its column's object, and 0 to the others.
void write_labels(const std::uint8_t* __restrict sides, const std::uint16_t* __restrict objects, std::size_t width,
                  std::uint16_t* __restrict labels) {
  for (std::size_t u = 0; u < width; ++u) {
    labels[u] = static_cast<std::uint16_t>(objects[u] & (sides[u] == kernels::kAbove ? 0xFFFFU : 0U));
  }
}

}  // namespace

template <class Raw>
void find_sides(const DepthRows<Raw>& rows, const Segmentation& segmentation, const std::vector<int>& carriers,
                const Plane& support, const DepthNoise& noise, const ObstacleOptions& options, DepthRowBuffer& buffer,
                Sides& sides) {
  const Camera& camera = rows.camera();
  const std::size_t width = rows.width();
  const std::size_t stride = rows.padded_width();
  resize(camera, static_cast<int>(width), rows.height(), stride, sides);
  const auto square = [&](double x) { return static_cast<float>(options.height_sigmas * options.height_sigmas * x * x); };
  const kernels::HeightLimits limits{square(noise.constant_m), square(noise.linear), square(noise.quadratic_per_m),
                                     static_cast<float>(options.least_height_m), static_cast<float>(options.least_drop_m)};
  std::array<std::uint8_t, 256> table{};
  std::fill(table.begin() + 1, table.end(), kernels::kOffPlane);
  for (const int label : carriers) table[at(label)] = kernels::kOnPlane;
  const int planes = static_cast<int>(segmentation.planes.size());
  const double step = support.normal.x() / camera.fx;
  // Whole cells, beyond the last column of pixels.
  const auto side = at(sides.cells.side);
  const std::size_t columns = (stride + side - 1) / side * side;
  sides.kinds.assign(columns, 0);
  for (int r = 0; r < sides.cells.rows; ++r) {
    sides.all_kinds.assign(columns, 0);
    for (auto& quads : sides.quads) quads.assign(columns / kernels::kQuad, 0);
    for (auto& depths : sides.depths) depths.assign(columns / kernels::kQuad, 0.0F);
    const kernels::QuadSums sums{sides.quads[0].data(), sides.depths[0].data(), sides.quads[1].data(), sides.depths[1].data()};
    for (int v = r * sides.cells.side; v < std::min((r + 1) * sides.cells.side, rows.height()); ++v) {
      std::copy_n(segmentation.labels.data() + at(v) * width, width, sides.kinds.data());
      kernels::relabel(sides.kinds.data(), width, table.data(), planes);
      const double base = support.normal.z() + support.normal.y() * (v - camera.cy) / camera.fy - step * camera.cx;
      kernels::height_kernels<Raw>().find_sides(
          rows.row(v, buffer).kept, sides.kinds.data(), stride, rows.view().metres_per_unit(),
          {static_cast<float>(base), static_cast<float>(step), static_cast<float>(support.d)}, limits,
          &sides.pixels[at(v) * stride], sums);
      add_kinds(sides.kinds, sides.all_kinds);
    }
    mark_seen(sides.all_kinds, sides.cells, sides.seen_quads, &sides.seen[at(sides.cells.index(r, 0))]);
    gather(r, sides.cells, sides.quads[0], sides.depths[0], sides.above, sides.q, sides.any_above);
    gather(r, sides.cells, sides.quads[1], sides.depths[1], sides.below, sides.q_below, sides.any_below);
  }
}

void find_objects(const Sides& sides, const Camera& camera, const DepthNoise& noise, const ObstacleOptions& options,
                  Objects& objects) {
  const CellImage& cells = sides.cells;
  const int least = least_pixels(cells.side);
  objects.cells.clear();
  objects.on.assign(cells.size(), 0);
  objects.sigma.resize(cells.size());
  // Of inverse depth: sigma_z q^2, with the squares of the parts of sigma_z added up.
  const auto square = [](double x) { return static_cast<float>(x * x); };
  const float constant = square(noise.constant_m);
  const float linear = square(noise.linear);
  const float quadratic = square(noise.quadratic_per_m);
  for (const Cell& cell : sides.any_above) {
    if (sides.above[at(cell.index)] < least) continue;
    objects.cells.push_back(cell);
    objects.on[at(cell.index)] = 1;
    const float qq = sides.q[at(cell.index)] * sides.q[at(cell.index)];
    constexpr float kRounding = 0x1p-22F;  // of a sum of floats, relative; depth is not known better
    objects.sigma[at(cell.index)] = std::sqrt(std::max(quadratic + qq * (linear + qq * constant), kRounding * kRounding * qq));
  }
  Linker(sides, camera, objects).run();
  Grouper(sides, camera, options, objects).run();
}

namespace {

/// Labels rows of cells.
template <class Raw>
class RowLabeller {
 public:
  RowLabeller(const DepthRows<Raw>& rows, const Segmentation& segmentation, const Sides& sides, DepthRowBuffer& buffer,
              Objects& objects, std::vector<PixelSums>& sums, std::vector<std::uint16_t>& labels)
      : rows_(rows),
        plane_labels_(segmentation.labels.data()),
        planes_(segmentation.planes.size()),
        s_(sides),
        cells_(sides.cells),
        buffer_(buffer),
        o_(objects),
        sums_(sums),
        labels_(labels),
        labeller_(sides, objects) {
    o_.singles.resize(at(cells_.columns) * at(cells_.side));
  }

  /// A row of cells, of which these have pixels above.
  void run(const Cell* begin, const Cell* end) {
    const int first_v = begin->row * cells_.side;
    end_v_ = std::min(first_v + cells_.side, rows_.height());
    std::fill(o_.singles.begin(), o_.singles.end(), std::uint16_t{0});
    o_.choices.clear();
    for (const Cell* cell = begin; cell != end; ++cell) {
      if (s_.above[at(cell->index)] == 0) continue;  // bent floor
      if (labeller_.is_single(cell->index)) {
        add_single(*cell);
      } else if (const Choice choice = labeller_.choose(*cell); choice.count > 0) {
        o_.choices.push_back(choice);
      }
    }
    for (int v = first_v; v < end_v_; ++v) {
      write_labels(side(0, v), o_.singles.data(), rows_.width(), &labels_[pixel(0, v)]);
      if (o_.choices.empty()) continue;
      const Raw* const raw = rows_.row(v, buffer_).kept;
      for (const Choice& choice : o_.choices) label_mixed(choice, v, raw);
    }
  }

 private:
  [[nodiscard]] const std::uint8_t* side(int u, int v) const { return &s_.pixels[at(v) * s_.stride + at(u)]; }
  [[nodiscard]] std::size_t pixel(int u, int v) const { return at(v) * rows_.width() + at(u); }
  std::uint32_t* counts(std::uint16_t object) { return &o_.on_plane[object * (planes_ + 1)]; }
  [[nodiscard]] std::size_t plane(std::uint8_t label) const { return label <= planes_ ? label : 0; }

  void add_single(const Cell& cell) {
    const std::uint16_t object = o_.of_cell[at(cell.index)];
    const int first_u = cell.column * cells_.side;
    const int first_v = cell.row * cells_.side;
    std::fill_n(o_.singles.begin() + first_u, cells_.side, object);
    const auto middle = [&](int first) { return static_cast<float>(first) + 0.5F * static_cast<float>(cells_.side - 1); };
    sums_[object].add(s_.above[at(cell.index)], 1.0F / s_.q[at(cell.index)], middle(first_u), middle(first_v));
    const std::uint8_t* sides = side(first_u, first_v);
    const std::uint8_t* labels = plane_labels_ + pixel(first_u, first_v);
    std::uint32_t* const on_plane = counts(object);
    if (s_.above[at(cell.index)] == cells_.side * cells_.side && is_uniform(labels)) {
      on_plane[plane(*labels)] += s_.above[at(cell.index)];
      return;
    }
    const int columns = std::min(cells_.side, static_cast<int>(rows_.width()) - first_u);
    for (int v = first_v; v < end_v_; ++v, sides += s_.stride, labels += rows_.width()) {
      for (int k = 0; k < columns; ++k) {
        if (sides[k] == kernels::kAbove) ++on_plane[plane(labels[k])];
      }
    }
  }

  /// Whether all pixels of a whole cell have one label.
  [[nodiscard]] bool is_uniform(const std::uint8_t* labels) const {
    const std::uint32_t first = 0x01010101U * *labels;
    std::uint32_t others = 0;
    const std::size_t width = rows_.width();
    for (int u = 0; u < cells_.side; u += static_cast<int>(kernels::kQuad)) {
      const std::uint8_t* quads = labels + u;
      for (int v = 0; v < cells_.side; v += 4, quads += 4 * width) {  // sides of cells are multiples of four
        others |= (quad(quads) ^ first) | (quad(quads + width) ^ first) | (quad(quads + 2 * width) ^ first) |
                  (quad(quads + 3 * width) ^ first);
      }
    }
    return others == 0;
  }
  [[nodiscard]] static std::uint32_t quad(const std::uint8_t* bytes) {
    std::uint32_t four = 0;
    std::memcpy(&four, bytes, sizeof four);
    return four;
  }

  void label_mixed(const Choice& choice, int v, const Raw* raw) {
    const int end = std::min(choice.first_u + cells_.side, static_cast<int>(rows_.width()));
    const float metres = rows_.view().metres_per_unit();
    for (int first = choice.first_u; first < end; first += static_cast<int>(kernels::kQuad)) {
      const std::uint8_t* const sides = side(first, v);
      if ((quad(sides) & (0x01010101U * kernels::kAbove)) == 0) continue;
      const std::uint8_t* const planes = plane_labels_ + pixel(first, v);
      std::uint16_t* const out = &labels_[pixel(first, v)];
      const Quad z = Quad(raw[first], raw[first + 1], raw[first + 2], raw[first + 3]) * metres;
      const Nearest nearest(choice, first, v, 1.0F / z);
      for (int k = 0; k < static_cast<int>(kernels::kQuad); ++k) {
        if (sides[k] != kernels::kAbove) continue;
        const std::uint16_t object = nearest.object(k);
        out[k] = object;
        ++counts(object)[plane(planes[k])];
        sums_[object].add(1, z[k], static_cast<float>(first + k), static_cast<float>(v));
      }
    }
  }

  const DepthRows<Raw>& rows_;
  const std::uint8_t* plane_labels_;
  std::size_t planes_;
  const Sides& s_;
  const CellImage& cells_;
  DepthRowBuffer& buffer_;
  Objects& o_;
  std::vector<PixelSums>& sums_;
  std::vector<std::uint16_t>& labels_;
  PixelLabeller labeller_;
  int end_v_ = 0;  ///< Of the row of cells.
};

}  // namespace

template <class Raw>
void label_objects(const DepthRows<Raw>& rows, const Segmentation& segmentation, const Sides& sides, DepthRowBuffer& buffer,
                   Objects& objects, std::vector<PixelSums>& sums, std::vector<std::uint16_t>& labels) {
  objects.on_plane.assign(sums.size() * (segmentation.planes.size() + 1), 0);
  RowLabeller<Raw> labeller(rows, segmentation, sides, buffer, objects, sums, labels);
  const std::size_t row_of_cells = rows.width() * at(sides.cells.side);
  auto written = labels.begin();
  for_each_row(sides.any_above, [&](const Cell* begin, const Cell* end) {
    const auto first = labels.begin() + static_cast<std::ptrdiff_t>(at(begin->row) * row_of_cells);
    std::fill(written, first, std::uint16_t{0});
    labeller.run(begin, end);
    written = labels.begin() + static_cast<std::ptrdiff_t>(std::min(at(begin->row + 1) * row_of_cells, labels.size()));
  });
  std::fill(written, labels.end(), std::uint16_t{0});
}

template void find_sides(const DepthRows<std::uint16_t>&, const Segmentation&, const std::vector<int>&, const Plane&,
                         const DepthNoise&, const ObstacleOptions&, DepthRowBuffer&, Sides&);
template void find_sides(const DepthRows<float>&, const Segmentation&, const std::vector<int>&, const Plane&, const DepthNoise&,
                         const ObstacleOptions&, DepthRowBuffer&, Sides&);
template void label_objects(const DepthRows<std::uint16_t>&, const Segmentation&, const Sides&, DepthRowBuffer&, Objects&,
                            std::vector<PixelSums>&, std::vector<std::uint16_t>&);
template void label_objects(const DepthRows<float>&, const Segmentation&, const Sides&, DepthRowBuffer&, Objects&,
                            std::vector<PixelSums>&, std::vector<std::uint16_t>&);

}  // namespace fransac::obstacles
