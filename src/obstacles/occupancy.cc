// SPDX-License-Identifier: Apache-2.0
#include "fransac/obstacles/occupancy.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <new>
#include <string>

#include "core/caught.hpp"
#include "filter/depth_rows.hpp"
#include "obstacles/support.hpp"

namespace fransac {
namespace {

double squares_ahead(const OccupancyOptions& options) { return std::ceil(options.max_range_m / options.resolution_m); }

/// Marks the squares that pixels see.
class Marker {
 public:
  Marker(const Camera& camera, const Segmentation& segmentation, const Obstacles& obstacles, const OccupancyOptions& options,
         OccupancyGrid& grid)
      : camera_(camera), segmentation_(segmentation), obstacles_(obstacles), options_(options), grid_(grid) {
    for (const int label : obstacles.support) {
      if (label >= kLabelFirst && label <= kMaxPlanes) carries_[static_cast<std::size_t>(label)] = true;
    }
  }

  template <class Raw>
  void run(const DepthRows<Raw>& rows) {
    DepthRowBuffer buffer;
    const Eigen::Matrix3d to_ground = obstacles_.ground.axes.transpose();
    for (int v = 0; v < rows.height(); ++v) {
      const Raw* const raw = rows.row(v, buffer).kept;
      for (int u = 0; u < camera_.width; ++u) {
        const auto z = static_cast<double>(static_cast<float>(raw[u]) * rows.view().metres_per_unit());
        if (!(z > 0.0)) continue;
        const Eigen::Vector3d ray((u - camera_.cx) / camera_.fx, (v - camera_.cy) / camera_.fy, 1.0);
        add(static_cast<std::size_t>(v) * rows.width() + static_cast<std::size_t>(u), z, to_ground * ray);
      }
    }
  }

 private:
  /// A pixel at depth z; `ray` in the ground's directions. The camera is above the ground's origin, at height d.
  void add(std::size_t pixel, double z, const Eigen::Vector3d& ray) {
    const std::uint16_t id = obstacles_.labels[pixel];
    const double camera_height = obstacles_.support_plane.d;
    if (id == 0 || id > obstacles_.obstacles.size()) {
      if (carries_[segmentation_.labels[pixel]]) mark(z * ray.head<2>(), OccupancyGrid::kFree);
    } else if (obstacles_.obstacles[id - std::size_t{1}].kind == ObstacleKind::drop) {
      if (ray.z() < 0.0) mark(camera_height / -ray.z() * ray.head<2>(), OccupancyGrid::kOccupied);
    } else if (z * ray.z() + camera_height <= options_.clearance_m) {
      mark(z * ray.head<2>(), OccupancyGrid::kOccupied);
    }
  }

  void mark(const Eigen::Vector2d& place, std::int8_t value) {
    if (!(place.squaredNorm() <= options_.max_range_m * options_.max_range_m)) return;
    const auto index = [&](double coordinate) {
      const double i = std::floor(coordinate / options_.resolution_m) + 0.5 * grid_.width;
      return static_cast<std::size_t>(std::clamp(i, 0.0, grid_.width - 1.0));  // the range's end may round beyond it
    };
    std::int8_t& cell = grid_.cells[index(place.y()) * static_cast<std::size_t>(grid_.width) + index(place.x())];
    static_assert(OccupancyGrid::kUnknown < OccupancyGrid::kFree && OccupancyGrid::kFree < OccupancyGrid::kOccupied);
    cell = std::max(cell, value);
  }

  const Camera& camera_;
  const Segmentation& segmentation_;
  const Obstacles& obstacles_;
  const OccupancyOptions& options_;
  OccupancyGrid& grid_;
  std::array<bool, 256> carries_{};  ///< By label.
};

Status check_obstacles(const DepthView& depth, const Obstacles& obstacles) {
  if (obstacles.width == depth.width() && obstacles.height == depth.height() && obstacles.labels.size() == depth.size())
    return {};
  return Error{ErrorCode::invalid_argument, "the obstacles' size is not the depth image's"};
}

}  // namespace

Status validate(const OccupancyOptions& options) try {
  const auto refuse = [](const char* what) { return Error{ErrorCode::invalid_argument, what}; };
  if (!(options.resolution_m > 0.0) || !std::isfinite(options.resolution_m)) return refuse("resolution is out of range");
  if (!(options.max_range_m > 0.0) || !std::isfinite(options.max_range_m)) return refuse("max-range is out of range");
  if (!(options.clearance_m > 0.0)) return refuse("clearance is out of range");
  const double side = 2.0 * squares_ahead(options);
  if (!(side * side <= kMaxSquares)) {
    return refuse("resolution: so small that the squares within max-range are more than 64 million; take a larger one");
  }
  return {};
} catch (const std::exception& exception) {
  return caught(exception, "options of the occupancy grid");
}

Result<OccupancyGrid> occupancy_grid(const DepthView& depth, const Camera& camera, const Segmentation& segmentation,
                                     const Obstacles& obstacles, const OccupancyOptions& options) try {
  if (Status status = validate(options); !status) return status.error();
  if (Status status = obstacles::check_sizes(depth, camera, segmentation); !status) return status.error();
  OccupancyGrid grid;
  grid.resolution_m = options.resolution_m;
  if (obstacles.labels.empty()) return grid;  // nothing was looked for
  if (Status status = check_obstacles(depth, obstacles); !status) return status.error();
  const double ahead = squares_ahead(options);
  grid.width = grid.height = 2 * static_cast<int>(ahead);
  grid.origin_m.setConstant(-ahead * options.resolution_m);
  grid.cells.assign(static_cast<std::size_t>(grid.width) * static_cast<std::size_t>(grid.height), OccupancyGrid::kUnknown);
  Marker marker(camera, segmentation, obstacles, options, grid);
  CorrectedDepth corrected;
  DepthView view;
  if (Status status = obstacles::as_segmented(depth, segmentation, corrected, view); !status) return status.error();
  with_raw_type(depth.format(), [&](auto raw) { marker.run(DepthRows<decltype(raw)>(view, camera, nullptr)); });
  return grid;
} catch (const std::exception& exception) {
  return caught(exception, "occupancy grid (resolution, max-range)");
}

}  // namespace fransac
