// SPDX-License-Identifier: Apache-2.0
#include "planes/labelling.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numeric>
#include <optional>
#include <unordered_set>

#include "kernels/rows.h"

namespace fransac {
namespace {

/// A quantity that is affine along an image row: base + step * u.
struct Ramp {
  float base;
  float step;
  [[nodiscard]] float at(int u) const { return base + step * static_cast<float>(u); }
};

/// n . r along row v, r = ((u - cx) / fx, (v - cy) / fy, 1).
Ramp ray_product(const Eigen::Vector3d& n, const Camera& camera, int v) {
  const double base = n.x() * (-camera.cx / camera.fx) + n.y() * ((v - camera.cy) / camera.fy) + n.z();
  return {static_cast<float>(base), static_cast<float>(n.x() / camera.fx)};
}

void read_row(const DepthView& depth, int v, float* z) {
  if (depth.format() == DepthFormat::uint16) {
    const std::uint16_t* const raw = depth.row_uint16(v);
    const float metres_per_unit = depth.metres_per_unit();
    for (int u = 0; u < depth.width(); ++u) z[u] = static_cast<float>(raw[u]) * metres_per_unit;
  } else {
    for (int u = 0; u < depth.width(); ++u) z[u] = depth.metres(u, v);
  }
}

// Labels of a row are kept as floats until it is done; see kernels/rows.h.
constexpr auto kNoDepth = static_cast<float>(kLabelNoDepth);
constexpr auto kNoPlane = static_cast<float>(kLabelNoPlane);

/// Takes the label off pixels that the limits do not keep.
void apply_limits(const AxisLimits& limits, const Camera& camera, int v, const float* __restrict z, float* __restrict label) {
  const Ramp coordinate = ray_product(Eigen::Vector3d::Unit(static_cast<Eigen::Index>(limits.axis)), camera, v);
  const LocalLimits local(limits);
  const float removed_inside = local.outside ? kNoPlane : kNoDepth;  // larger than every plane's label, or smaller
  const float removed_outside = local.outside ? kNoDepth : kNoPlane;
  for (int u = 0; u < camera.width; ++u) {
    const float c = z[u] * coordinate.at(u);
    const float at_least = c < local.min ? removed_outside : c > local.max ? removed_outside : removed_inside;
    const float old_label = label[u];
    label[u] = z[u] > 0.0F ? std::max(old_label, at_least) : old_label;
  }
}

/// The label of a point by its distances to the planes.
std::uint8_t nearest_plane(const Eigen::Vector3d& point, const std::vector<PlaneSegment>& planes, double threshold_m) {
  std::uint8_t label = kLabelNoPlane;
  double nearest = std::numeric_limits<double>::infinity();
  for (const PlaneSegment& segment : planes) {
    const double distance = std::abs(segment.plane.signed_distance(point));
    if (distance <= threshold_m && distance < nearest) {
      nearest = distance;
      label = static_cast<std::uint8_t>(segment.id);
    }
  }
  return label;
}

bool is_plane(std::uint8_t label) { return label != kLabelNoDepth && label != kLabelNoPlane; }

/// Sums over the pixels of a plane.
struct Evidence {
  std::uint64_t count = 0;
  double squared_distance = 0.0;
  double footprint = 0.0;  ///< Times the area of a pixel at 1 m.

  Evidence& operator+=(const Evidence& other) {
    count += other.count;
    squared_distance += other.squared_distance;
    footprint += other.footprint;
    return *this;
  }
};

/// Evidence of the pixels [first, end) of a row, which all lie on one plane.
Evidence run_evidence(const float* z, int first, int end, const Ramp& n_r, float d) {
  // A ray never counts as more grazing than this (0.6 degrees): the footprint would be noise.
  constexpr float kMinRayProduct = 0.01F;
  // Independent partial sums let the compiler use vectors; it may not reorder a sum of floats by itself.
  constexpr int kLanes = 8;
  std::array<float, kLanes> squared_distance{};
  std::array<float, kLanes> footprint{};
  const auto add = [&](int u, int lane) {
    const float product = n_r.at(u);
    const float distance = z[u] * product + d;
    squared_distance[static_cast<std::size_t>(lane)] += distance * distance;
    footprint[static_cast<std::size_t>(lane)] += z[u] * z[u] / std::max(std::abs(product), kMinRayProduct);
  };
  int u = first;
  for (; u + kLanes <= end; u += kLanes) {
    for (int lane = 0; lane < kLanes; ++lane) add(u + lane, lane);
  }
  for (; u < end; ++u) add(u, 0);
  const auto total = [](const std::array<float, kLanes>& lanes) {
    return static_cast<double>(std::accumulate(lanes.begin(), lanes.end(), 0.0F));
  };
  return {static_cast<std::uint64_t>(end - first), total(squared_distance), total(footprint)};
}

/// Area covered by the points, as occupied square cells on the plane.
double occupied_area(const std::vector<Eigen::Vector2d>& points, double cell_m) {
  constexpr double kPointsPerCell = 4.0;  // evenly spread points then leave e^-4 = 2 % of the cells empty
  constexpr int kMaxDoublings = 40;
  double extent = 0.0;
  for (const Eigen::Vector2d& p : points) extent = std::max(extent, p.cwiseAbs().maxCoeff());
  if (extent == 0.0) return 0.0;
  cell_m = std::clamp(cell_m, 0x1p-31 * extent, extent);  // indices fit into 32 bits
  std::unordered_set<std::uint64_t> cells;
  for (int doubling = 0; doubling < kMaxDoublings; ++doubling, cell_m *= 2.0) {
    cells.clear();
    for (const Eigen::Vector2d& p : points) {
      const auto index = [&](double c) {
        return static_cast<std::uint64_t>(static_cast<std::int64_t>(std::floor(c / cell_m))) & 0xFFFFFFFFU;
      };
      cells.insert(index(p.x()) << 32 | index(p.y()));
    }
    if (kPointsPerCell * static_cast<double>(cells.size()) <= static_cast<double>(points.size()) || cells.size() <= 1) break;
  }
  return static_cast<double>(cells.size()) * cell_m * cell_m;
}

}  // namespace

void RowBuffers::resize(int width) {
  const std::size_t padded = (static_cast<std::size_t>(width) + kernels::kBlock - 1) / kernels::kBlock * kernels::kBlock;
  for (auto* buffer : {&depth, &distance, &label}) buffer->assign(padded, 0.0F);
}

void label_image(const DepthView& depth, const Camera& camera, const LabelRule& rule, RowBuffers& row,
                 Segmentation& segmentation) {
  const int width = depth.width();
  row.resize(width);
  float* const z = row.depth.data();
  float* const nearest = row.distance.data();
  float* const label = row.label.data();
  const auto padded = static_cast<int>(row.depth.size());
  const float beyond = std::nextafter(static_cast<float>(rule.threshold_m), std::numeric_limits<float>::infinity());
  for (int v = 0; v < depth.height(); ++v) {
    read_row(depth, v, z);
    for (int u = 0; u < padded; ++u) {
      const bool measured = z[u] > 0.0F;
      nearest[u] = measured ? beyond : 0.0F;  // nothing is nearer than 0
      label[u] = measured ? kNoPlane : kNoDepth;
    }
    for (const PlaneSegment& segment : segmentation.planes) {
      const Ramp n_r = ray_product(segment.plane.normal, camera, v);
      kernels::offer_plane(z, row.depth.size(),
                           {n_r.base, n_r.step, static_cast<float>(segment.plane.d), static_cast<float>(segment.id)}, nearest,
                           label);
    }
    if (rule.limits != nullptr) apply_limits(*rule.limits, camera, v, z, label);
    std::uint8_t* const labels = &segmentation.labels[static_cast<std::size_t>(v) * static_cast<std::size_t>(width)];
    for (int u = 0; u < width; ++u) labels[u] = static_cast<std::uint8_t>(static_cast<int>(label[u]));
  }
}

void label_points(const PointCloud& cloud, const LabelRule& rule, Segmentation& segmentation) {
  const auto axis = static_cast<Eigen::Index>(rule.limits != nullptr ? rule.limits->axis : Axis::z);
  const std::array<const float*, 3> coordinates{cloud.x(), cloud.y(), cloud.z()};
  const float* const limited = coordinates[static_cast<std::size_t>(axis)];
  const std::optional<LocalLimits> limits =
      rule.limits != nullptr ? std::optional<LocalLimits>(std::in_place, *rule.limits, cloud.origin[axis]) : std::nullopt;
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    std::uint8_t& label = segmentation.labels[i];
    if (!cloud.measured(i)) {
      label = kLabelNoDepth;
      continue;
    }
    const bool kept = !limits || limits->keeps(limited[i]);
    label = kept ? nearest_plane(cloud.point(i), segmentation.planes, rule.threshold_m) : kLabelNoPlane;
  }
}

void label_leaves(const PointCloud& points, const VoxelGrid& grid, double threshold_m, Segmentation& segmentation) {
  std::vector<std::uint8_t> label_of_leaf(grid.leaves.size());
  for (std::size_t leaf = 0; leaf < label_of_leaf.size(); ++leaf) {
    label_of_leaf[leaf] = nearest_plane(grid.leaves.point(leaf), segmentation.planes, threshold_m);
  }
  for (std::size_t i = 0; i < points.size(); ++i) segmentation.labels[points.source_of(i)] = label_of_leaf[grid.leaf_of[i]];
}

void measure_image(const DepthView& depth, const Camera& camera, RowBuffers& row, Segmentation& segmentation) {
  std::array<Evidence, 256> sums{};
  const int width = depth.width();
  row.resize(width);
  for (int v = 0; v < depth.height(); ++v) {
    const std::uint8_t* const labels = &segmentation.labels[static_cast<std::size_t>(v) * static_cast<std::size_t>(width)];
    read_row(depth, v, row.depth.data());
    for (int u = 0; u < width;) {
      const std::uint8_t label = labels[u];
      const int first = u;
      while (u < width && labels[u] == label) ++u;
      if (!is_plane(label)) continue;
      const Plane& plane = segmentation.planes[label - kLabelFirst].plane;
      sums[label] += run_evidence(row.depth.data(), first, u, ray_product(plane.normal, camera, v), static_cast<float>(plane.d));
    }
  }
  const double pixel_area = 1.0 / (camera.fx * camera.fy);
  for (PlaneSegment& segment : segmentation.planes) {
    const Evidence& s = sums[static_cast<std::size_t>(segment.id)];
    segment.inliers = s.count;
    segment.rms_m = s.count > 0 ? std::sqrt(s.squared_distance / static_cast<double>(s.count)) : 0.0;
    segment.area_m2 = s.footprint * pixel_area;
  }
}

void measure_points(const PointCloud& cloud, double cell_m, Segmentation& segmentation) {
  std::vector<Eigen::Vector2d> on_plane;
  for (PlaneSegment& segment : segmentation.planes) {
    const Eigen::Vector3d& n = segment.plane.normal;
    const Eigen::Vector3d e1 = n.unitOrthogonal();
    const Eigen::Vector3d e2 = n.cross(e1);
    on_plane.clear();
    double squared_distance = 0.0;
    for (std::size_t i = 0; i < cloud.size(); ++i) {
      if (segmentation.labels[i] != segment.id) continue;
      const Eigen::Vector3d local = cloud.local(i);
      on_plane.emplace_back(e1.dot(local), e2.dot(local));
      const double distance = segment.plane.signed_distance(cloud.point(i));
      squared_distance += distance * distance;
    }
    segment.inliers = on_plane.size();
    segment.rms_m = on_plane.empty() ? 0.0 : std::sqrt(squared_distance / static_cast<double>(on_plane.size()));
    segment.area_m2 = on_plane.empty() ? 0.0 : occupied_area(on_plane, cell_m);
  }
}

}  // namespace fransac
