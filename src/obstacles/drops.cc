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
  for (const Cell& first : sides.any_below) {
    const int start = first.index;
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
    ++drops.count;
  }
  for (const Cell& cell : sides.any_below) {
    std::uint16_t& id = drops.of_cell[at(cell.index)];
    if (id == kNoDrop) id = 0;
    if (id != 0) drops.cells.push_back(cell);
  }
}

template <class Raw>
void label_drops(const DepthRows<Raw>& rows, const Sides& sides, DepthRowBuffer& buffer, Drops& drops,
                 std::vector<PixelSums>& sums, std::vector<std::uint16_t>& labels) {
  if (drops.cells.empty()) return;
  const CellImage& cells = sides.cells;
  const int width = rows.view().width();
  const float metres = rows.view().metres_per_unit();
  for_each_row(sides.any_below, [&](const Cell* begin, const Cell* end) {
    drops.pieces.clear();
    for (const Cell* cell = begin; cell != end; ++cell) {
      std::uint16_t id = drops.of_cell[at(cell->index)];
      // Pixels of cells with few of them go with their neighbours.
      for (const int step : {-1, 1, -cells.stride, cells.stride}) id = id != 0 ? id : drops.of_cell[at(cell->index + step)];
      if (id != 0) drops.pieces.push_back({cell->column * cells.side, id});
    }
    if (drops.pieces.empty()) return;
    for (int v = begin->row * cells.side; v < std::min((begin->row + 1) * cells.side, rows.height()); ++v) {
      const Raw* const raw = rows.row(v, buffer).kept;
      for (const Drops::Piece& piece : drops.pieces) {
        for (int u = piece.first_u; u < std::min(piece.first_u + cells.side, width); ++u) {
          if (sides.pixels[at(v) * sides.stride + at(u)] != kernels::kBelow) continue;
          labels[at(v) * at(width) + at(u)] = piece.id;
          sums[piece.id].add(1, static_cast<float>(raw[u]) * metres, static_cast<float>(u), static_cast<float>(v));
        }
      }
    }
  });
}

template void label_drops(const DepthRows<std::uint16_t>&, const Sides&, DepthRowBuffer&, Drops&, std::vector<PixelSums>&,
                          std::vector<std::uint16_t>&);
template void label_drops(const DepthRows<float>&, const Sides&, DepthRowBuffer&, Drops&, std::vector<PixelSums>&,
                          std::vector<std::uint16_t>&);

}  // namespace fransac::obstacles
