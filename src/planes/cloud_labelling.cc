// SPDX-License-Identifier: Apache-2.0
#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>

#include "planes/labelling.hpp"

namespace fransac {
namespace {

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

/// Area covered by the points, as occupied square cells on the plane; no more than the rectangle that holds them.
double occupied_area(const std::vector<Eigen::Vector2d>& points, double cell_m, LeafTable<std::uint64_t>& cells) {
  constexpr double kPointsPerCell = 4.0;  // evenly spread points then leave e^-4 = 2 % of the cells empty
  Eigen::Vector2d low = points.front();
  Eigen::Vector2d high = low;
  for (const Eigen::Vector2d& p : points) {
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
  }
  const double extent = (high - low).maxCoeff();
  if (!(extent > 0.0)) return 0.0;
  cell_m = std::clamp(cell_m, 0x1p-31 * extent, extent);  // indices fit into 32 bits
  for (;; cell_m *= 2.0) {
    cells.restart();
    for (const Eigen::Vector2d& p : points) {
      const auto index = [&](int axis) { return static_cast<std::uint64_t>((p[axis] - low[axis]) / cell_m); };
      cells.find_or_add(index(0) | index(1) << 32);
    }
    if (kPointsPerCell * cells.size() <= static_cast<double>(points.size()) || cell_m > extent) break;  // all in one
  }
  return std::min(cells.size() * cell_m * cell_m, (high - low).prod());
}

/// Whether points are measurements: PointCloud::measured, for many.
class MeasuredTest {
 public:
  explicit MeasuredTest(const PointCloud& cloud) : cloud_(cloud), zero_((-cloud.origin).cast<float>()) {}
  bool operator()(std::size_t i) const {
    const float x = cloud_.x()[i];
    const float y = cloud_.y()[i];
    const float z = cloud_.z()[i];
    const bool finite = x * 0.0F + y * 0.0F + z * 0.0F == 0.0F;
    return finite && !(x == zero_.x() && y == zero_.y() && z == zero_.z());
  }

 private:
  const PointCloud& cloud_;
  Eigen::Vector3f zero_;
};

/// Points of each label.
std::array<std::uint64_t, 256> count_labels(const std::vector<std::uint8_t>& labels) {
  std::array<std::uint64_t, 256> counts{};
  for (const std::uint8_t label : labels) ++counts[label];
  return counts;
}

}  // namespace

const std::vector<std::uint8_t>& leaf_labels(const PointCloud& leaves, double threshold_m,
                                             const std::vector<PlaneSegment>& planes, LabelBuffers& buffers) {
  std::vector<std::uint8_t>& labels = buffers.leaf_labels;
  labels.resize(leaves.size());
  for (std::size_t leaf = 0; leaf < labels.size(); ++leaf) labels[leaf] = nearest_plane(leaves.point(leaf), planes, threshold_m);
  return labels;
}

void label_leaves(const PointCloud& points, const VoxelGrid& grid, double threshold_m, LabelBuffers& buffers,
                  Segmentation& segmentation) {
  const std::vector<std::uint8_t>& label_of_leaf = leaf_labels(grid.leaves, threshold_m, segmentation.planes, buffers);
  for (std::size_t i = 0; i < points.size(); ++i) segmentation.labels[points.source_of(i)] = label_of_leaf[grid.leaf_of[i]];
}

void label_points(const PointCloud& cloud, const LabelRule& rule, Segmentation& segmentation) {
  const auto axis = static_cast<Eigen::Index>(rule.limits != nullptr ? rule.limits->axis : Axis::z);
  const std::array<const float*, 3> coordinates{cloud.x(), cloud.y(), cloud.z()};
  const float* const limited = coordinates[static_cast<std::size_t>(axis)];
  const std::optional<LocalLimits> limits =
      rule.limits != nullptr ? std::optional<LocalLimits>(std::in_place, *rule.limits, cloud.origin[axis]) : std::nullopt;
  const MeasuredTest measured(cloud);
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    std::uint8_t& label = segmentation.labels[i];
    if (!measured(i)) {
      label = kLabelNoDepth;
      continue;
    }
    const bool kept = !limits || limits->keeps(limited[i]);
    label = kept ? nearest_plane(cloud.point(i), segmentation.planes, rule.threshold_m) : kLabelNoPlane;
  }
}

bool remove_phantoms(const VoxelGrid& grid, double threshold_m, LabelBuffers& buffers, Segmentation& segmentation) {
  constexpr double kLeastShare = 0.25;  // of points as noisy as three thresholds, 1 sigma
  const std::array<std::uint64_t, 256> own = count_labels(segmentation.labels);
  std::array<std::uint64_t, 256> in_leaves{};
  const std::vector<std::uint8_t>& label_of_leaf = leaf_labels(grid.leaves, threshold_m, segmentation.planes, buffers);
  for (std::size_t leaf = 0; leaf < label_of_leaf.size(); ++leaf) in_leaves[label_of_leaf[leaf]] += grid.point_count[leaf];
  const auto is_phantom = [&](const PlaneSegment& plane) {
    const auto label = static_cast<std::size_t>(plane.id);
    return own[label] < 3 || static_cast<double>(own[label]) < kLeastShare * static_cast<double>(in_leaves[label]);
  };
  if (std::erase_if(segmentation.planes, is_phantom) == 0) return false;
  int id = kLabelFirst;
  for (PlaneSegment& plane : segmentation.planes) plane.id = id++;
  return true;
}

void measure_points(const PointCloud& cloud, double cell_m, LabelBuffers& buffers, Segmentation& segmentation) {
  std::vector<Eigen::Vector2d>& on_plane = buffers.on_plane;
  for (PlaneSegment& segment : segmentation.planes) {
    const Eigen::Vector3d& n = segment.plane.normal;
    const Eigen::Vector3d e1 = n.unitOrthogonal();
    const Eigen::Vector3d e2 = n.cross(e1);
    on_plane.clear();
    double squared_distance = 0.0;
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    for (std::size_t i = 0; i < cloud.size(); ++i) {
      if (segmentation.labels[i] != segment.id) continue;
      const Eigen::Vector3d local = cloud.local(i);
      on_plane.emplace_back(e1.dot(local), e2.dot(local));
      sum += local;
      const double distance = segment.plane.signed_distance(cloud.point(i));
      squared_distance += distance * distance;
    }
    segment.inliers = on_plane.size();
    if (!on_plane.empty()) segment.centroid = sum / static_cast<double>(on_plane.size()) + cloud.origin;
    segment.rms_m = on_plane.empty() ? 0.0 : std::sqrt(squared_distance / static_cast<double>(on_plane.size()));
    segment.area_m2 = on_plane.empty() ? 0.0 : occupied_area(on_plane, cell_m, buffers.cells);
  }
}

}  // namespace fransac
