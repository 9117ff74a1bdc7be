// SPDX-License-Identifier: Apache-2.0
/// Pixels whose rays go through the support, as regions.
#pragma once

#include <cstdint>
#include <vector>

#include "fransac/core/camera.hpp"
#include "obstacles/objects.hpp"

namespace fransac::obstacles {

/// Memory of find_drops, and what it found.
struct Drops {
  int count = 0;
  std::vector<std::uint16_t> of_cell;  ///< Per cell: 0, or the drop from 1.
  std::vector<Cell> cells;             ///< Those of drops, in the image's order.
  std::vector<std::int32_t> queue;
  /// Of one row of cells: those with pixels of drops.
  struct Piece {
    int first_u;
    std::uint16_t id;
  };
  std::vector<Piece> pieces;
};
/// Of cells that are below but of no drop, while drops are looked for.
inline constexpr std::uint16_t kNoDrop = 0xFFFF;

/// Groups what is below the support by the sides of cells, across cells in which nothing was measured.
void find_drops(const Sides& sides, const Camera& camera, const ObstacleOptions& options, Drops& drops);

/// Writes what `of_cell` says to each drop's pixels, and adds those up.
template <class Raw>
void label_drops(const DepthRows<Raw>& rows, const Sides& sides, DepthRowBuffer& buffer, Drops& drops,
                 std::vector<PixelSums>& sums, std::vector<std::uint16_t>& labels);

}  // namespace fransac::obstacles
