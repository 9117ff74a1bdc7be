// SPDX-License-Identifier: Apache-2.0
#include "planes/cells/labels.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>

#include "fransac/core/depth_image.hpp"
#include "fransac/core/parallel.hpp"
#include "planes/cells/constants.hpp"

namespace fransac::cells {
namespace {

constexpr const Constants& kC = kConstants;

/// Where a place in pixels is in samples from the image's centre.
Eigen::Vector2d in_samples(double u, double v, const Grid& grid) {
  const double step = grid.sampling.per_pixel();
  return {(u + 0.5) * step - 0.5 - 0.5 * grid.width, (v + 0.5) * step - 0.5 - 0.5 * grid.height};
}

/// A plane as a row of cells sees it that starts with row v of pixels.
kernels::CellPlane cell_plane(const InversePlane& plane, const Grid& grid, int v, std::uint8_t label) {
  const double step = grid.sampling.per_pixel();
  const Eigen::Vector2d first = in_samples(0.0, v, grid);
  return {static_cast<float>(plane.at(first.x(), first.y())), static_cast<float>(plane.du * step),
          static_cast<float>(plane.dv * step), label};
}

/// What pixels may be off: their noise and slow errors, what the sensor bends, and how flat a plane has to be.
float floor_m(const Noise& noise) { return static_cast<float>(std::hypot(kC.bias_far * noise.bias_m, kC.flat_m)); }

/// The grid's cells, each as its `merged` x `merged` parts.
void make_cells(const Grid& grid, const Regions& regions, PixelCells& cells) {
  const int merged = grid.sampling.merged;
  cells.columns = grid.columns * merged;
  cells.rows = grid.rows * merged;
  cells.stride = cells.columns + 2;
  cells.side = grid.sampling.side();
  cells.floor_m = floor_m(grid.noise);
  cells.owner.assign(cells.size(), kNobody);
  cells.tolerance.assign(cells.size() + Grid::kPadding, 0.0F);
  cells.q.assign(cells.size() + Grid::kPadding, 0.0F);
  const auto sigma = static_cast<float>(kC.sigmas * std::hypot(1.0, grid.noise.slow));
  for (int r = 0; r < cells.rows; ++r) {
    const std::size_t from = at(grid.index(r / merged, 0));
    const std::size_t to = at(cells.index(r, 0));
    if (merged == 1) {
      std::copy_n(&regions.owner[from], cells.columns, &cells.owner[to]);
      std::copy_n(&grid.q[from], cells.columns, &cells.q[to]);
      for (std::size_t c = 0; c < at(cells.columns); ++c) cells.tolerance[to + c] = sigma * grid.sigma[from + c];
      continue;
    }
    for (int c = 0; c < cells.columns; ++c) {
      const std::size_t i = from + at(c / merged);
      cells.owner[to + at(c)] = regions.owner[i];
      cells.tolerance[to + at(c)] = sigma * grid.sigma[i];
      cells.q[to + at(c)] = grid.q[i];
    }
  }
}

/// Written so that compilers make vector code of it.
void find_range(const PixelCells& cells, OwnerRange& range) {
  static_assert(kNobody == -1);  // and so less than any region, and more with its sign taken away
  constexpr auto kNoSign = std::int16_t{0x7fff};
  const auto least = [](std::int16_t a, std::int16_t b, std::int16_t c) { return std::min(std::min(a, b), c); };
  const auto greatest = [](std::int16_t a, std::int16_t b, std::int16_t c) { return std::max(std::max(a, b), c); };
  const auto unsign = [](std::int16_t region) { return static_cast<std::int16_t>(region & kNoSign); };
  for (auto* const values : {&range.least_of_row, &range.greatest_of_row, &range.least, &range.greatest})
    values->resize(cells.size());
  const auto stride = at(cells.stride);
  const std::size_t size = cells.size();
  const std::int16_t* const __restrict o = cells.owner.data();
  std::int16_t* const __restrict low = range.least_of_row.data();
  std::int16_t* const __restrict high = range.greatest_of_row.data();
  for (std::size_t i = 1; i < size - 1; ++i) {
    low[i] = least(unsign(o[i - 1]), unsign(o[i]), unsign(o[i + 1]));
    high[i] = greatest(o[i - 1], o[i], o[i + 1]);
  }
  std::int16_t* const __restrict lowest = range.least.data();
  std::int16_t* const __restrict highest = range.greatest.data();
  for (std::size_t i = stride + 1; i < size - stride - 1; ++i) {
    lowest[i] = least(low[i - stride], low[i], low[i + stride]);
    highest[i] = greatest(high[i - stride], high[i], high[i + stride]);
  }
}

/// Lets regions flow into neighbouring cells half of whose pixels they explain: cells at edges and holes, or with thin stripes of
/// quantised depth.
template <class Raw>
class Flood {
 public:
  Flood(const ImageRows<Raw>& image, float metres_per_unit, const Grid& grid, const Regions& regions, LabelPixelBuffers& buffers)
      : image_(image), metres_per_unit_(metres_per_unit), grid_(grid), regions_(regions), b_(buffers), cells_(buffers.cells) {}

  void run(const std::vector<std::uint8_t>& label_of_region) {
    b_.queue.clear();
    bool all = true;  // most often
    for (std::size_t g = 0; g < regions_.list.size(); ++g) all = all && (label_of_region[g] != 0 || !regions_.list[g].alive);
    for (std::int16_t& owner : cells_.owner) {
      if (!all && owner != kNobody && label_of_region[at(owner)] == 0) owner = kNobody;
    }
    const std::int16_t* const o = cells_.owner.data();
    for (int r = 0; r < cells_.rows; ++r) {
      for (int i = cells_.index(r, 0); i < cells_.index(r, cells_.columns); ++i) {
        // Somebody's cell beside one of nobody's, whose number is the only negative one.
        if (o[i] >= 0 && (o[i - 1] | o[i + 1] | o[i - cells_.stride] | o[i + cells_.stride]) < 0) b_.queue.push_back(i);
      }
    }
    for (std::size_t head = 0; head < b_.queue.size(); ++head) spread_from(b_.queue[head]);
  }

 private:
  void spread_from(int i) {
    const std::int16_t owner = cells_.owner[at(i)];
    const InversePlane& plane = regions_.list[at(owner)].fit.plane;
    for (const int step : {1, cells_.stride, -1, -cells_.stride}) {
      const int j = i + step;
      if (cells_.owner[at(j)] != kNobody) continue;
      const int row = j / cells_.stride - 1;
      const int column = j % cells_.stride - 1;
      if (row < 0 || row >= cells_.rows || column < 0 || column >= cells_.columns) continue;
      // A cell that is a plane by itself must be this plane, to half as much again as a member.
      constexpr float kWide = 1.5F * 1.5F;
      const int whole = grid_.index(row / grid_.sampling.merged, column / grid_.sampling.merged);
      if (grid_.usable[at(whole)] != 0 && !grid_.distance(whole, FloatPlane(plane)).within(kWide * grid_.slack[at(whole)]))
        continue;
      const auto fits = kernels::cell_kernels<Raw>(cells_.side)
                            .fits(image_.cells(row), at(column), metres_per_unit_, cell_plane(plane, grid_, row * cells_.side, 0),
                                  {cells_.tolerance.data() + cells_.index(row, 0), cells_.floor_m});
      constexpr double kLeast = 5.0;  // samples
      const double samples = std::pow(kernels::kCell / cells_.side, 2) * fits.fitting;
      if (samples < kLeast || fits.fitting < 0.5 * fits.measured) continue;
      cells_.owner[at(j)] = owner;
      b_.queue.push_back(j);
    }
  }

  const ImageRows<Raw>& image_;
  float metres_per_unit_;
  const Grid& grid_;
  const Regions& regions_;
  LabelPixelBuffers& b_;
  PixelCells& cells_;
};

/// The regions that may own pixels of a cell: those of its neighbours.
struct Candidates {
  std::array<std::int16_t, kernels::kMostCandidates> regions;
  int count = 0;

  void set(const AlignedVector<std::int16_t>& owner, const OwnerRange& range, int i, int stride) {
    count = 0;
    const std::int16_t greatest = range.greatest[at(i)];
    if (greatest == kNobody) return;
    if (greatest == range.least[at(i)]) {
      regions[at(count++)] = greatest;
      return;
    }
    std::int16_t last = kNobody;                       // neighbours are mostly the same
    for (const int y : {i, i - stride, i + stride}) {  // the cell's own row first: of equally near planes the first wins
      for (const int x : {y, y - 1, y + 1}) {
        const std::int16_t region = owner[at(x)];
        if (region == kNobody || region == last) continue;
        last = region;
        if (!has(region)) regions[at(count++)] = region;
      }
    }
  }
  /// Whether they are a cell's as well, seen at a glance: true of most.
  [[nodiscard]] bool are_all(const OwnerRange& range, int i) const {
    const std::int16_t greatest = range.greatest[at(i)];
    return count == 0 ? greatest == kNobody : count == 1 && greatest == regions[0] && range.least[at(i)] == greatest;
  }
  [[nodiscard]] bool has(std::int16_t region) const {
    for (int k = 0; k < count; ++k) {
      if (regions[at(k)] == region) return true;
    }
    return false;
  }
  bool operator==(const Candidates& other) const {
    if (count != other.count) return false;
    for (int k = 0; k < count; ++k) {
      if (regions[at(k)] != other.regions[at(k)]) return false;
    }
    return true;
  }
};

/// Labels one row of cells after the other.
template <class Raw>
class RowLabeller {
 public:
  RowLabeller(const ImageRows<Raw>& image, const DepthView& view, const Grid& grid, const Regions& regions,
              const std::vector<std::uint8_t>& label_of_region, const PixelCells& cells, const OwnerRange& range)
      : image_(image),
        view_(view),
        grid_(grid),
        regions_(regions),
        label_of_region_(label_of_region),
        cells_(cells),
        range_(range) {}

  void run(int row, LabelPixelBuffers::Task& task, std::uint8_t* labels) const {
    const auto width = at(view_.width());
    const auto side = at(cells_.side);
    const std::size_t room = at(cells_.columns) * side;
    const bool whole = room == width;
    task.rows.resize(room * side);
    std::array<std::uint8_t*, kernels::kCell> out{};
    for (std::size_t k = 0; k < side; ++k) {
      const std::size_t v = at(row) * side + k;
      out[k] = whole && v < at(view_.height()) ? labels + v * width : task.rows.data() + k * room;
    }
    label_cells(row, task, out.data());
    if (whole) return;
    for (std::size_t k = 0; k < side && at(row) * side + k < at(view_.height()); ++k) {
      std::memcpy(labels + (at(row) * side + k) * width, out[k], width);
    }
  }

 private:
  void label_cells(int row, LabelPixelBuffers::Task& task, std::uint8_t* const* out) const {
    const kernels::CellRows<Raw> pixels = image_.cells(row);
    std::array<Candidates, 2> candidates;
    std::size_t now = 0;
    candidates[now].set(cells_.owner, range_, cells_.index(row, 0), cells_.stride);
    for (int first = 0, end = 1; first < cells_.columns; first = end++) {
      Candidates& next = candidates[1 - now];
      for (; end < cells_.columns; ++end) {
        if (candidates[now].are_all(range_, cells_.index(row, end))) continue;
        next.set(cells_.owner, range_, cells_.index(row, end), cells_.stride);
        if (!(next == candidates[now])) break;
      }
      label(pixels, row, first, end, candidates[now], task, out);
      now = 1 - now;
    }
  }

  void label(const kernels::CellRows<Raw>& pixels, int row, int first, int end, const Candidates& candidates,
             LabelPixelBuffers::Task& task, std::uint8_t* const* out) const {
    const auto& kernel = kernels::cell_kernels<Raw>(cells_.side);
    const std::size_t cells = at(end - first);
    if (candidates.count == 0) return kernel.label_none(pixels, at(first), cells, out);
    std::array<kernels::CellPlane, kernels::kMostCandidates> planes;          // NOLINT(*-member-init): the first `count` are set
    std::array<kernels::CellRunEvidence, kernels::kMostCandidates> evidence;  // NOLINT(*-member-init)
    task.counts.resize(kernels::kMostCandidates * at(cells_.columns) + Grid::kPadding);
    for (int k = 0; k < candidates.count; ++k) {
      const std::int16_t region = candidates.regions[at(k)];
      planes[at(k)] = cell_plane(regions_.list[at(region)].fit.plane, grid_, row * cells_.side, label_of_region_[at(region)]);
      evidence[at(k)].count = task.counts.data() + at(k) * cells;
    }
    kernel.label(pixels, at(first), cells, view_.metres_per_unit(), planes.data(), at(candidates.count),
                 {cells_.tolerance.data() + cells_.index(row, 0), cells_.floor_m}, out, evidence.data());
    for (int k = 0; k < candidates.count; ++k) {
      const std::int16_t region = candidates.regions[at(k)];
      add(regions_.list[at(region)].fit.plane, row, at(first), evidence[at(k)], cells, task.planes[at(region)]);
    }
  }

  /// A cell's centre stands for its pixels: it is as good as their own places for sums over many of them. What depends on the
  /// plane and the camera alone is left to in_metres().
  void add(const InversePlane& plane, int row, std::size_t first, const kernels::CellRunEvidence& evidence, std::size_t cells,
           PixelEvidence& sum) const {
    sum.squared_residual += static_cast<double>(evidence.squared_residual);
    const double side = cells_.side;
    const double u = static_cast<double>(first) * side + 0.5 * (side - 1.0);
    const double v = row * side + 0.5 * (side - 1.0);
    const Eigen::Vector2d sample = in_samples(u, v, grid_);
    const double per_column = side / kernels::kCell;  // the kernel's cells are kCell columns
    const kernels::PixelSums pixels =
        kernels::sum_pixels(evidence.count, &cells_.q[at(cells_.index(row, static_cast<int>(first)))], cells,
                            static_cast<float>(plane.at(sample.x(), sample.y())),
                            static_cast<float>(plane.du * grid_.sampling.per_pixel() * per_column), 1.0F / kMaxDepth_m);
    sum.count += static_cast<std::uint64_t>(pixels.n);
    const auto z = static_cast<double>(pixels.z);
    sum.area_m2 += static_cast<double>(pixels.zzz);
    sum.sum += Eigen::Vector3d(static_cast<double>(pixels.zu) * per_column + z * u, z * v, z);
  }

  const ImageRows<Raw>& image_;
  const DepthView& view_;
  const Grid& grid_;
  const Regions& regions_;
  const std::vector<std::uint8_t>& label_of_region_;
  const PixelCells& cells_;
  const OwnerRange& range_;
};

/// From sums of z^3 and of (u z, v z, z) to square metres and points.
void in_metres(const InversePlane& plane, const Grid& grid, const Camera& camera, PixelEvidence& sum) {
  const Eigen::Vector3d n = grid.parameters(plane);  // over the distance
  sum.area_m2 *= std::sqrt(n.x() * n.x() + n.y() * n.y() + n.z() * n.z()) / (camera.fx * camera.fy);
  sum.sum[0] = (sum.sum[0] - camera.cx * sum.sum[2]) / camera.fx;
  sum.sum[1] = (sum.sum[1] - camera.cy * sum.sum[2]) / camera.fy;
}

}  // namespace

PixelEvidence& PixelEvidence::operator+=(const PixelEvidence& other) {
  count += other.count;
  squared_residual += other.squared_residual;
  area_m2 += other.area_m2;
  sum += other.sum;
  return *this;
}

template <class Raw>
void label_pixels(const ImageRows<Raw>& image, const DepthView& view, const Camera& camera, const Grid& grid,
                  const Regions& regions, const std::vector<std::uint8_t>& label_of_region, int threads,
                  LabelPixelBuffers& buffers, std::uint8_t* labels) {
  make_cells(grid, regions, buffers.cells);
  Flood<Raw>(image, view.metres_per_unit(), grid, regions, buffers).run(label_of_region);
  find_range(buffers.cells, buffers.range);
  const RowLabeller<Raw> labeller(image, view, grid, regions, label_of_region, buffers.cells, buffers.range);
  const std::size_t tasks = cell_row_tasks(buffers.cells.rows);
  constexpr std::size_t kUsualRegions = 256;  // more than nearly any frame has
  buffers.tasks.resize(std::max(buffers.tasks.size(), tasks));
  parallel_for(threads, tasks, [&](std::size_t i) {
    LabelPixelBuffers::Task& task = buffers.tasks[i];
    task.planes.reserve(kUsualRegions);
    task.planes.assign(regions.list.size(), {});
    for_each_cell_row(i, buffers.cells.rows, [&](int row) { labeller.run(row, task, labels); });
  });
  buffers.evidence.assign(regions.list.size(), {});
  for (std::size_t i = 0; i < tasks; ++i) {
    for (std::size_t g = 0; g < regions.list.size(); ++g) buffers.evidence[g] += buffers.tasks[i].planes[g];
  }
  for (std::size_t g = 0; g < regions.list.size(); ++g) {
    in_metres(regions.list[g].fit.plane, grid, camera, buffers.evidence[g]);
  }
}

template void label_pixels(const ImageRows<std::uint16_t>&, const DepthView&, const Camera&, const Grid&, const Regions&,
                           const std::vector<std::uint8_t>&, int, LabelPixelBuffers&, std::uint8_t*);
template void label_pixels(const ImageRows<float>&, const DepthView&, const Camera&, const Grid&, const Regions&,
                           const std::vector<std::uint8_t>&, int, LabelPixelBuffers&, std::uint8_t*);

}  // namespace fransac::cells
