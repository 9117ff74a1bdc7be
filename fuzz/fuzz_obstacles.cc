// SPDX-License-Identifier: Apache-2.0
// Obstacles of a small depth image and of its points, the ground as a map, and the map as files, with any options: errors, or
// boxes, labels and squares that fit each other and what was seen, the same every time.
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numbers>
#include <optional>
#include <vector>

#include "draw.hpp"
#include "fransac/io/ros_map.hpp"
#include "fransac/obstacles/obstacles.hpp"
#include "fransac/obstacles/occupancy.hpp"
#include "fransac/planes/segment.hpp"
#include "require.hpp"

namespace {

using namespace fransac;
using namespace fransac::fuzz;

void check_box(const UprightBox& box) {
  require(box.centre.allFinite() && box.size.allFinite() && (box.size.array() >= 0.0).all() && box.size.x() >= box.size.y());
  constexpr double kQuarter = std::numbers::pi / 2.0;
  require(box.yaw_rad > -kQuarter - 1e-9 && box.yaw_rad <= kQuarter + 1e-9);
}

void check(const Obstacles& found, const Segmentation& segmentation, bool drops_are_seen) {
  require(found.width == segmentation.width && found.height == segmentation.height);
  require(found.labels.size() == segmentation.labels.size());
  std::vector<std::uint64_t> pixels(found.obstacles.size() + 1);
  for (std::size_t i = 0; i < found.labels.size(); ++i) {
    require(found.labels[i] <= found.obstacles.size());
    require(found.labels[i] == 0 || segmentation.labels[i] != kLabelNoDepth);
    ++pixels[found.labels[i]];
  }
  const auto is_plane = [&](int id) { return id >= kLabelFirst && static_cast<std::size_t>(id) <= segmentation.planes.size(); };
  require(std::all_of(found.support.begin(), found.support.end(), is_plane));
  const bool supported = found.support_reason <= SupportReason::surface;
  require(supported == !found.support.empty());
  require(std::abs(found.support_plane.normal.norm() - 1.0) < 1e-6 && std::isfinite(found.support_plane.d));
  require(found.ground.origin.allFinite() && (found.ground.axes.transpose() * found.ground.axes).isIdentity(1e-6));
  double nearest = 0.0;
  for (std::size_t k = 0; k < found.obstacles.size(); ++k) {
    const Obstacle& o = found.obstacles[k];
    require(o.id == static_cast<int>(k) + 1 && o.pixels == pixels[k + 1] && o.pixels > 0);
    require(o.kind != ObstacleKind::drop || (drops_are_seen && supported));
    require(o.centroid.allFinite() && std::isfinite(o.min_height_m) && o.max_height_m >= o.min_height_m);
    require(o.nearest_m >= nearest && std::all_of(o.planes.begin(), o.planes.end(), is_plane));
    nearest = o.nearest_m;
    check_box(o.box);
  }
}

void check_same(const Obstacles& a, const Obstacles& b) {
  require(a.labels == b.labels && a.support == b.support && a.obstacles.size() == b.obstacles.size());
  for (std::size_t k = 0; k < a.obstacles.size(); ++k) {
    const Obstacle& p = a.obstacles[k];
    const Obstacle& q = b.obstacles[k];
    require(p.kind == q.kind && p.centroid == q.centroid && p.contact == q.contact && p.planes == q.planes);
    require(p.box.centre == q.box.centre && p.box.size == q.box.size && p.nearest_m == q.nearest_m);
  }
}

OccupancyOptions draw_occupancy(Bytes& bytes) {
  OccupancyOptions options;
  const auto draw = [&](double& value, double max) {
    value = draw_seldom(bytes) ? draw_any(bytes) : draw_number(bytes, 0.0, max);
  };
  if (bytes.ConsumeBool()) draw(options.resolution_m, 1.0);
  if (bytes.ConsumeBool()) draw(options.max_range_m, 20.0);
  if (bytes.ConsumeBool()) draw(options.clearance_m, 3.0);
  return options;
}

void check_grid(const DrawnDepth& depth, const Segmentation& segmentation, const Obstacles& found,
                const OccupancyOptions& options) {
  const bool large = options.max_range_m / options.resolution_m > 500.0;  // and slow
  if (large && validate(options)) return;
  const Result<OccupancyGrid> grid = occupancy_grid(depth.view, depth.camera, segmentation, found, options);
  require(grid.ok() == validate(options).ok());
  if (!grid) return require_message(grid.error());
  require(grid->width > 0 && grid->width == grid->height && grid->resolution_m == options.resolution_m);
  require(grid->cells.size() == static_cast<std::size_t>(grid->width) * static_cast<std::size_t>(grid->height));
  for (const std::int8_t cell : grid->cells) {
    require(cell == OccupancyGrid::kUnknown || cell == OccupancyGrid::kFree || cell == OccupancyGrid::kOccupied);
    require(cell != OccupancyGrid::kFree || !found.support.empty());
  }
  const Result<io::RosMap> map = io::encode_ros_map("map", *grid);
  require(map && map->pgm.starts_with("P5\n") && map->pgm.size() > grid->cells.size());
}

ObstacleOptions draw_obstacle_options(Bytes& bytes) {
  ObstacleOptions options;
  draw_options(bytes, [&](const auto& visit) { for_each_obstacle_option(options, visit); });
  DrawOption{bytes}({}, options.support.kind);
  options.support.plane = draw_seldom(bytes) ? bytes.ConsumeIntegral<int>() : bytes.ConsumeIntegralInRange(1, 3);
  return options;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  Bytes bytes(data, size);
  const ObstacleOptions options = draw_obstacle_options(bytes);
  const OccupancyOptions occupancy = draw_occupancy(bytes);
  AxisLimits limits;
  limits.max_m = bytes.ConsumeFloatingPointInRange(0.0, 10.0);
  const AxisLimits* const within = bytes.ConsumeBool() ? &limits : nullptr;
  const SegmentOptions segment_options = draw_segment_options(bytes);
  const DrawnDepth depth = draw_depth(bytes);

  ObstacleWorkspace workspace;
  Obstacles again;
  if (const Result<Segmentation> s = segment(depth.view, depth.camera, segment_options)) {
    const Result<Obstacles> found = find_obstacles(depth.view, depth.camera, *s, options, within);
    for (int frame = 0; frame < 2; ++frame) {
      const Status status = find_obstacles(depth.view, depth.camera, *s, options, within, workspace, again);
      require(status.ok() == found.ok() && found.ok() == validate(options).ok());
      if (found) check_same(*found, again);
    }
    if (found) {
      check(*found, *s, true);
      require(drop_outlines(*found, depth.camera).size() == found->obstacles.size());
      check_grid(depth, *s, *found, occupancy);
    } else {
      require_message(found.error());
      require(again.obstacles.empty() && again.labels.empty());
    }
  }
  const PointCloud cloud = draw_cloud(bytes, depth);
  if (const Result<Segmentation> s = segment(cloud, segment_options)) {
    const Result<Obstacles> found = find_obstacles(cloud, *s, options, within);
    if (!found) {
      require_message(found.error());
      return 0;
    }
    require(validate(options).ok());
    check(*found, *s, false);
    check_same(*found, *find_obstacles(cloud, *s, options, within));
  }
  return 0;
}
