// SPDX-License-Identifier: Apache-2.0
#include "obstacles/drops.hpp"

#include <algorithm>

#include "kernels/heights.h"

namespace fransac::obstacles {
namespace {

/// A quarter of the pixels make a cell, as for objects.
bool is_below(const Sides& sides, int cell) { return 4 * sides.below[at(cell)] >= sides.cells.side * sides.cells.side; }

/// Nothing was measured in it.
bool is_blind(const Sides& sides, int cell) {
  return sides.seen[at(cell)] == 0 && sides.above[at(cell)] == 0 && sides.below[at(cell)] == 0 && !sides.cells.in_border(cell);
}

}  // namespace

void find_drops(const Sides& sides, const Camera& camera, const ObstacleOptions& options, Drops& drops) {
  const CellImage& cells = sides.cells;
  drops.count = 0;
  drops.of_cell.assign(cells.size(), 0);
  drops.cells.clear();
  if (sides.any_below.empty()) return;
  const double cells_per_m2 = camera.fx * camera.fy / (cells.side * cells.side);
  for (int r = 0; r < cells.rows; ++r) {
    for (int start = cells.index(r, 0); start < cells.index(r, cells.columns); ++start) {
      if (drops.count == kMostObjects || drops.of_cell[at(start)] != 0 || !is_below(sides, start)) continue;
      const auto id = static_cast<std::uint16_t>(drops.count + 1);
      drops.queue.assign(1, start);
      drops.of_cell[at(start)] = id;
      double area_m2 = 0.0;
      for (std::size_t head = 0; head < drops.queue.size(); ++head) {
        const int cell = drops.queue[head];
        const auto q = static_cast<double>(sides.q_below[at(cell)]);
        area_m2 += 1.0 / (cells_per_m2 * q * q);
        for (const int step : {1, cells.stride, -1, -cells.stride}) {
          int next = cell + step;
          if (is_blind(sides, next)) next += step;
          if (drops.of_cell[at(next)] != 0 || !is_below(sides, next)) continue;
          drops.of_cell[at(next)] = id;
          drops.queue.push_back(next);
        }
      }
      constexpr std::size_t kFewest = 3;  // flying pixels make two
      if (drops.queue.size() < kFewest || area_m2 < options.min_size_m * options.min_size_m) {
        for (const std::int32_t cell : drops.queue) drops.of_cell[at(cell)] = kNoDrop;
        continue;
      }
      drops.cells.insert(drops.cells.end(), drops.queue.begin(), drops.queue.end());
      ++drops.count;
    }
  }
  std::replace(drops.of_cell.begin(), drops.of_cell.end(), kNoDrop, std::uint16_t{0});
}

template <class Raw>
void label_drops(const DepthRows<Raw>& rows, const Sides& sides, DepthRowBuffer& buffer, const Drops& drops,
                 std::vector<PixelSums>& sums, std::vector<std::uint16_t>& labels) {
  const CellImage& cells = sides.cells;
  const int width = rows.view().width();
  const float metres = rows.view().metres_per_unit();
  for (int v = 0; v < rows.height() && !drops.cells.empty(); ++v) {
    const Raw* const raw = rows.row(v, buffer).kept;
    const int first = cells.index(v / cells.side, 0);
    for (int u = 0; u < width; ++u) {
      const std::size_t pixel = at(v) * at(width) + at(u);
      if (sides.pixels[at(v) * sides.stride + at(u)] != kernels::kBelow) continue;
      const int cell = first + u / cells.side;
      std::uint16_t id = drops.of_cell[at(cell)];
      // Pixels of cells with few of them go with their neighbours.
      for (const int step : {-1, 1, -cells.stride, cells.stride}) id = id != 0 ? id : drops.of_cell[at(cell + step)];
      if (id == 0) continue;
      labels[pixel] = id;
      sums[id].add(1, static_cast<float>(raw[u]) * metres, static_cast<float>(u), static_cast<float>(v));
    }
  }
}

template void label_drops(const DepthRows<std::uint16_t>&, const Sides&, DepthRowBuffer&, const Drops&, std::vector<PixelSums>&,
                          std::vector<std::uint16_t>&);
template void label_drops(const DepthRows<float>&, const Sides&, DepthRowBuffer&, const Drops&, std::vector<PixelSums>&,
                          std::vector<std::uint16_t>&);

}  // namespace fransac::obstacles
