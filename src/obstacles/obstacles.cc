// SPDX-License-Identifier: Apache-2.0
#include "fransac/obstacles/obstacles.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>
#include <numeric>
#include <string>
#include <utility>

#include "core/caught.hpp"
#include "fransac/core/true_object.hpp"
#include "obstacles/bent_floor.hpp"
#include "obstacles/drops.hpp"
#include "obstacles/floor_error.hpp"
#include "obstacles/footprint.hpp"
#include "obstacles/objects.hpp"
#include "obstacles/support.hpp"
#include "planes/range_check.hpp"

namespace fransac {

struct ObstacleWorkspace::Impl {
  CorrectedDepth corrected;
  DepthRowBuffer row;
  obstacles::Sides sides;
  obstacles::BentFloor bent;
  obstacles::Objects objects;
  obstacles::Drops drops;
  /// Of an object or drop, from its cells.
  struct Extent {
    obstacles::Footprint footprint;
    double low = std::numeric_limits<double>::infinity();
    double high = -std::numeric_limits<double>::infinity();
    double nearest = std::numeric_limits<double>::infinity();
    bool contact = false;
  };
  std::vector<Extent> extents;             ///< Objects by number, then drops; 0 unused.
  std::vector<std::uint16_t> order;        ///< Numbers, nearest first.
  std::vector<std::uint16_t> ids;          ///< By number.
  std::vector<obstacles::PixelSums> sums;  ///< By id.
};

ObstacleWorkspace::ObstacleWorkspace() : impl_(std::make_unique<Impl>()) {}
ObstacleWorkspace::~ObstacleWorkspace() = default;
ObstacleWorkspace::ObstacleWorkspace(ObstacleWorkspace&&) noexcept = default;
ObstacleWorkspace& ObstacleWorkspace::operator=(ObstacleWorkspace&&) noexcept = default;

GroundFrame ground_frame(const Plane& support, const Eigen::Vector3d& sensor) {
  GroundFrame frame;
  const Eigen::Vector3d& up = support.normal;
  frame.origin = sensor - support.signed_distance(sensor) * up;
  const Eigen::Vector3d ahead = ahead_of_camera(up);
  frame.axes << ahead, up.cross(ahead), up;
  return frame;
}

namespace {

using Impl = ObstacleWorkspace::Impl;

/// A Kinect's, where the method that found the planes knows no noise.
DepthNoise noise_of(const Segmentation& segmentation) {
  if (segmentation.noise != DepthNoise{}) return segmentation.noise;
  return {.quadratic_per_m = kKinectNoise_per_m};
}

class Describer {
 public:
  Describer(const Camera& camera, const Segmentation& segmentation, const ObstacleOptions& options, Impl& work, Obstacles& result)
      : camera_(camera),
        segmentation_(segmentation),
        options_(options),
        w_(work),
        r_(result),
        cell_per_z_(work.sides.cells.side / std::min(camera.fx, camera.fy)) {}

  /// Where everything is, from the cells.
  void measure() {
    w_.extents.assign(at(w_.objects.count + w_.drops.count) + 1, {});
    for (const obstacles::Cell& cell : w_.objects.cells) {
      const std::uint16_t number = w_.objects.of_cell[at(cell.index)];
      if (number == 0) continue;
      const float q = w_.sides.q[at(cell.index)];
      add(cell, q, w_.objects.sigma[at(cell.index)] / (q * q), w_.extents[number]);
    }
    for (const obstacles::Cell& cell : w_.drops.cells) {
      const std::size_t number = at(w_.objects.count) + w_.drops.of_cell[at(cell.index)];
      add(cell, w_.sides.q_below[at(cell.index)], 0.0F, w_.extents[number]);
    }
    // Nearest first.
    w_.order.resize(w_.extents.size() - 1);
    std::iota(w_.order.begin(), w_.order.end(), std::uint16_t{1});
    std::sort(w_.order.begin(), w_.order.end(), [&](std::uint16_t a, std::uint16_t b) {
      return w_.extents[a].nearest < w_.extents[b].nearest || (w_.extents[a].nearest == w_.extents[b].nearest && a < b);
    });
    w_.ids.assign(w_.extents.size(), 0);
    for (std::size_t i = 0; i < w_.order.size(); ++i) w_.ids[w_.order[i]] = static_cast<std::uint16_t>(i + 1);
    for (const obstacles::Cell& cell : w_.objects.cells) {
      w_.objects.of_cell[at(cell.index)] = w_.ids[w_.objects.of_cell[at(cell.index)]];
    }
    for (const obstacles::Cell& cell : w_.drops.cells) {
      w_.drops.of_cell[at(cell.index)] = w_.ids[at(w_.objects.count) + w_.drops.of_cell[at(cell.index)]];
    }
  }

  void describe() {
    r_.obstacles.resize(w_.order.size());
    for (std::size_t i = 0; i < w_.order.size(); ++i) {
      const auto id = static_cast<int>(i + 1);
      const bool drop = w_.order[i] > w_.objects.count;
      const Impl::Extent& extent = w_.extents[w_.order[i]];
      Obstacle& obstacle = r_.obstacles[i];
      obstacle.id = id;
      const obstacles::PixelSums& sums = w_.sums[at(id)];
      obstacle.pixels = sums.count;
      obstacle.centroid = centroid(sums);
      obstacle.min_height_m = extent.low;
      obstacle.max_height_m = extent.high;
      obstacle.nearest_m = extent.nearest;
      obstacle.contact = !drop && !r_.support.empty() && extent.contact;
      obstacles::set_box(extent.footprint, obstacle);
      if (drop) {
        obstacle.kind = ObstacleKind::drop;
        obstacle.planes.clear();
      } else {
        obstacles::name_planes(&w_.objects.on_plane[at(id) * (segmentation_.planes.size() + 1)], segmentation_, obstacle);
      }
    }
  }

 private:
  void add(const obstacles::Cell& cell, float q, float sigma_m, Impl::Extent& extent) const {
    const Eigen::Vector3d ray(w_.sides.ray_x[at(cell.column)], w_.sides.ray_y[at(cell.row)], 1.0);
    const double z = 1.0 / static_cast<double>(q);
    const Eigen::Vector3d point = r_.ground.from_camera(z * ray);
    extent.footprint.add(point.head<2>());
    extent.low = std::min(extent.low, point.z());
    extent.high = std::max(extent.high, point.z());
    if (z < extent.nearest) extent.nearest = std::min(extent.nearest, z * ray.norm());
    if (extent.contact) return;
    // A cell that stands on the support is half a cell above it, and what is noise there.
    const double reach = z * cell_per_z_ + options_.least_height_m +
                         options_.height_sigmas * static_cast<double>(sigma_m) * std::abs(r_.support_plane.normal.dot(ray));
    extent.contact = point.z() <= reach;
  }

  [[nodiscard]] Eigen::Vector3d centroid(const obstacles::PixelSums& sums) const {
    if (sums.count == 0) return Eigen::Vector3d::Zero();
    const auto n = static_cast<double>(sums.count);
    return {(sums.zu - sums.z * camera_.cx) / camera_.fx / n, (sums.zv - sums.z * camera_.cy) / camera_.fy / n, sums.z / n};
  }

  const Camera& camera_;
  const Segmentation& segmentation_;
  const ObstacleOptions& options_;
  Impl& w_;
  Obstacles& r_;
  double cell_per_z_;  ///< Size of a cell at depth 1, metres.
};

/// All pixels of a sliver can be nearer to its neighbours' surfaces: it is none then.
void remove_empty(Obstacles& result) {
  const auto is_empty = [](const Obstacle& obstacle) { return obstacle.pixels == 0; };
  if (std::none_of(result.obstacles.begin(), result.obstacles.end(), is_empty)) return;  // nearly always
  std::erase_if(result.obstacles, is_empty);
  std::vector<std::uint16_t> new_ids(std::numeric_limits<std::uint16_t>::max() + std::size_t{1});
  for (std::size_t i = 0; i < result.obstacles.size(); ++i) {
    int& id = result.obstacles[i].id;
    new_ids[at(std::exchange(id, static_cast<int>(i + 1)))] = static_cast<std::uint16_t>(i + 1);
  }
  for (std::uint16_t& label : result.labels) label = new_ids[label];
}

/// All but the labels, every one of which is written.
void clear(Obstacles& result) {
  result.obstacles.clear();
  result.support.clear();
  result.support_reason = SupportReason::no_planes;
  result.support_doubt = SupportDoubt::none;
  result.ground = {};
  result.support_plane = {};
}

/// The plane at right angles to `up` that all pixels are above, by more than what is no obstacle.
template <class Raw>
Plane plane_below_all(const DepthRows<Raw>& rows, const Eigen::Vector3d& up, const DepthNoise& noise,
                      const ObstacleOptions& options, DepthRowBuffer& buffer) {
  constexpr double kRounding_m = 1e-3;  // heights are floats
  const Camera& camera = rows.camera();
  double d = 0.0;
  for (int v = 0; v < rows.height(); ++v) {
    const Raw* const raw = rows.row(v, buffer).kept;
    for (int u = 0; u < camera.width; ++u) {
      const auto z = static_cast<double>(static_cast<float>(raw[u]) * rows.view().metres_per_unit());
      if (!(z > 0.0)) continue;
      const double slant = up.dot(Eigen::Vector3d((u - camera.cx) / camera.fx, (v - camera.cy) / camera.fy, 1.0));
      const double least = std::max(options.least_height_m, options.height_sigmas * noise.sigma_m(z) * std::abs(slant));
      d = std::max(d, least - z * slant);
    }
  }
  return {up, d + kRounding_m};
}

template <class Raw>
void find(const DepthView& depth, const Camera& camera, const Segmentation& segmentation, const ObstacleOptions& options,
          const AxisLimits* limits, Impl& w, Obstacles& result) {
  const DepthRows<Raw> rows(depth, camera, limits);
  const DepthNoise noise = noise_of(segmentation);
  const bool none = result.support.empty();
  result.support_plane = none ? plane_below_all(rows, segmentation.up.value_or(-Eigen::Vector3d::UnitY()), noise, options, w.row)
                              : segmentation.planes[at(result.support.front() - 1)].plane;
  result.ground = ground_frame(result.support_plane);
  obstacles::find_sides(rows, segmentation, result.support, result.support_plane, noise, options, w.row, w.sides);
  if (!none) {
    const obstacles::FloorError error(segmentation, segmentation.planes[at(result.support.front() - 1)], noise,
                                      options.height_sigmas);
    obstacles::remove_bent_floor(rows, segmentation, result.support, result.support_plane, error, options.height_sigmas, w.row,
                                 w.bent, w.sides);
  }
  obstacles::find_objects(w.sides, camera, noise, options, w.objects);
  obstacles::find_drops(w.sides, camera, options, w.drops);
  Describer describer(camera, segmentation, options, w, result);
  describer.measure();
  w.sums.assign(w.order.size() + 1, {});
  obstacles::label_objects(rows, segmentation, w.sides, w.row, w.objects, w.sums, result.labels);
  obstacles::label_drops(rows, w.sides, w.row, w.drops, w.sums, result.labels);
  describer.describe();
  remove_empty(result);
}

}  // namespace

Status validate(const ObstacleOptions& options) try {
  RangeCheck check;
  for_each_obstacle_option(options, check);
  if (!check.status) return check.status;
  const SupportChoice& support = options.support;
  if (support.kind == SupportKind::plane && (support.plane < kLabelFirst || support.plane > kMaxPlanes)) {
    return Error{ErrorCode::invalid_argument, "support: " + std::to_string(support.plane) + " is no plane's label"};
  }
  return {};
} catch (const std::exception& exception) {
  return caught(exception, "options of obstacles");
}

Status find_obstacles(const DepthView& depth, const Camera& camera, const Segmentation& segmentation,
                      const ObstacleOptions& options, const AxisLimits* limits, ObstacleWorkspace& workspace,
                      Obstacles& result) try {
  const auto fail = [&](Status status) {
    clear(result);
    result.labels.clear();
    return status;
  };
  const auto start = std::chrono::steady_clock::now();
  clear(result);
  if (Status status = validate(options); !status) return fail(std::move(status));
  if (Status status = obstacles::check_sizes(depth, camera, segmentation); !status) return fail(std::move(status));
  result.width = depth.width();
  result.height = depth.height();
  obstacles::choose_support(segmentation, options, noise_of(segmentation), result);
  DepthView view;
  if (Status status = obstacles::as_segmented(depth, segmentation, workspace.impl().corrected, view); !status) {
    return fail(std::move(status));
  }
  result.labels.resize(depth.size());
  with_raw_type(depth.format(),
                [&](auto raw) { find<decltype(raw)>(view, camera, segmentation, options, limits, workspace.impl(), result); });
  result.total_ms = std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
  return {};
} catch (const std::exception& exception) {
  clear(result);
  result.labels.clear();
  workspace.impl() = Impl{};  // some buffers are of this frame, some of the one before
  return caught(exception, [&] {
    return "obstacles of " + std::to_string(depth.width()) + " x " + std::to_string(depth.height()) + " pixels";
  });
}

Result<Obstacles> find_obstacles(const DepthView& depth, const Camera& camera, const Segmentation& segmentation,
                                 const ObstacleOptions& options, const AxisLimits* limits) try {
  ObstacleWorkspace workspace;
  Obstacles result;
  if (Status status = find_obstacles(depth, camera, segmentation, options, limits, workspace, result); !status)
    return status.error();
  return result;
} catch (const std::exception& exception) {
  return caught(exception, "obstacles");
}

std::vector<std::vector<Outline>> drop_outlines(const Obstacles& obstacles, const Camera& camera, const OutlineOptions& options) {
  // As a segmentation whose planes are all the support.
  Segmentation drops;
  drops.width = obstacles.width;
  drops.height = obstacles.height;
  std::vector<std::uint8_t> label_of(obstacles.obstacles.size() + 1, kLabelNoPlane);
  std::vector<std::size_t> whose;
  for (const Obstacle& obstacle : obstacles.obstacles) {
    if (obstacle.kind != ObstacleKind::drop || whose.size() == at(kMaxPlanes)) continue;
    whose.push_back(at(obstacle.id - 1));
    label_of[at(obstacle.id)] = static_cast<std::uint8_t>(whose.size());
    drops.planes.push_back({.id = static_cast<int>(whose.size()), .plane = obstacles.support_plane});
  }
  std::vector<std::vector<Outline>> result(obstacles.obstacles.size());
  if (whose.empty()) return result;
  drops.labels.resize(obstacles.labels.size());
  std::transform(obstacles.labels.begin(), obstacles.labels.end(), drops.labels.begin(),
                 [&](std::uint16_t id) { return label_of[id]; });
  std::vector<std::vector<Outline>> found = outlines(drops, camera, options);
  for (std::size_t i = 0; i < whose.size(); ++i) result[whose[i]] = std::move(found[i]);
  return result;
}

}  // namespace fransac
