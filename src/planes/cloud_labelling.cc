// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <vector>

#include "fransac/core/parallel.hpp"
#include "kernels/points.h"
#include "planes/labelling.hpp"

namespace fransac {
namespace {

/// Points that one task looks at; fixed, so that sums do not depend on the number of threads. Whole blocks.
constexpr std::size_t kTaskPoints = std::size_t{1} << 16;

std::size_t task_count(std::size_t points) { return (points + kTaskPoints - 1) / kTaskPoints; }

/// Calls body(task, first, end) for all tasks of so many points.
template <class Body>
void for_each_task(std::size_t points, int threads, const Body& body) {
  parallel_for(threads, task_count(points),
               [&](std::size_t task) { body(task, task * kTaskPoints, std::min(points, (task + 1) * kTaskPoints)); });
}

/// Labels by nearness alone. `planes` is where they are put as the kernel wants them.
void label_by_planes(const PointCloud& cloud, const std::vector<PlaneSegment>& segments, double threshold_m, int threads,
                     std::vector<kernels::PlaneD>& planes, std::uint8_t* labels) {
  planes.clear();
  for (const PlaneSegment& segment : segments) {
    const Plane plane = translated(segment.plane, cloud.origin);
    planes.push_back({plane.normal.x(), plane.normal.y(), plane.normal.z(), plane.d});
  }
  const Eigen::Vector3f zero = (-cloud.origin).cast<float>();
  const kernels::NearestPlane rule{.planes = planes.data(),
                                   .count = planes.size(),
                                   .threshold = threshold_m,
                                   .unmeasured = {zero.x(), zero.y(), zero.z()},
                                   .no_depth = kLabelNoDepth,
                                   .no_plane = kLabelNoPlane,
                                   .first = kLabelFirst};
  for_each_task(cloud.size(), threads, [&](std::size_t /*task*/, std::size_t first, std::size_t end) {
    const std::size_t whole = end - (end - first) % PointCloud::kBlock;
    kernels::label_points(cloud.x() + first, cloud.y() + first, cloud.z() + first, whole - first, rule, labels + first);
    if (whole == end) return;
    std::array<std::uint8_t, PointCloud::kBlock> last;  // the cloud's own arrays are padded, labels are not
    kernels::label_points(cloud.x() + whole, cloud.y() + whole, cloud.z() + whole, last.size(), rule, last.data());
    std::copy_n(last.begin(), end - whole, labels + whole);
  });
}

/// Calls body(point, plane) for each point [first, end) that has a plane's label; planes count from 0.
template <class Body>
void for_each_on_plane(const std::vector<std::uint8_t>& labels, std::size_t first, std::size_t end, const Body& body) {
  constexpr std::size_t kAtOnce = 256;
  std::array<std::uint32_t, kAtOnce> found;
  for (; first < end; first += kAtOnce) {
    // Where the next one is cannot be predicted, so finding it is no branch.
    std::size_t count = 0;
    const std::size_t last = std::min(end, first + kAtOnce);
    for (std::size_t i = first; i < last; ++i) {
      found[count] = static_cast<std::uint32_t>(i);
      count += static_cast<std::size_t>(labels[i] != kLabelNoDepth && labels[i] != kLabelNoPlane);
    }
    for (std::size_t k = 0; k < count; ++k) body(found[k], static_cast<std::size_t>(labels[found[k]] - kLabelFirst));
  }
}

/// Points of each label.
std::array<std::uint64_t, 256> count_labels(const std::vector<std::uint8_t>& labels) {
  std::array<std::uint64_t, 256> counts{};
  for (const std::uint8_t label : labels) ++counts[label];
  return counts;
}

}  // namespace

const std::vector<std::uint8_t>& leaf_labels(const PointCloud& leaves, double threshold_m,
                                             const std::vector<PlaneSegment>& planes, int threads, LabelBuffers& buffers) {
  std::vector<std::uint8_t>& labels = buffers.leaf_labels;
  labels.resize(leaves.size());
  label_by_planes(leaves, planes, threshold_m, threads, buffers.planes_of_points, labels.data());
  return labels;
}

void label_leaves(const PointCloud& points, const VoxelGrid& grid, double threshold_m, int threads, LabelBuffers& buffers,
                  Segmentation& segmentation) {
  const std::vector<std::uint8_t>& label_of_leaf = leaf_labels(grid.leaves, threshold_m, segmentation.planes, threads, buffers);
  for (std::size_t i = 0; i < points.size(); ++i) segmentation.labels[points.source_of(i)] = label_of_leaf[grid.leaf_of[i]];
}

void label_points(const PointCloud& cloud, const LabelRule& rule, int threads, LabelBuffers& buffers,
                  Segmentation& segmentation) {
  std::vector<std::uint8_t>& labels = segmentation.labels;
  label_by_planes(cloud, segmentation.planes, rule.threshold_m, threads, buffers.planes_of_points, labels.data());
  if (rule.limits == nullptr) return;
  const auto axis = static_cast<std::size_t>(rule.limits->axis);
  const float* const limited = std::array{cloud.x(), cloud.y(), cloud.z()}[axis];
  const LocalLimits limits(*rule.limits, cloud.origin[static_cast<Eigen::Index>(axis)]);
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    if (labels[i] != kLabelNoDepth && !limits.keeps(limited[i])) labels[i] = kLabelNoPlane;
  }
}

bool remove_phantoms(const VoxelGrid& grid, std::size_t points, double threshold_m, int threads, LabelBuffers& buffers,
                     Segmentation& segmentation) {
  constexpr double kLeastShare = 0.25;  // of points as noisy as three thresholds, 1 sigma
  const std::array<std::uint64_t, 256> own = count_labels(segmentation.labels);
  std::array<std::uint64_t, 256> in_leaves{};
  const std::vector<std::uint8_t>& label_of_leaf = leaf_labels(grid.leaves, threshold_m, segmentation.planes, threads, buffers);
  for (std::size_t leaf = 0; leaf < label_of_leaf.size(); ++leaf) in_leaves[label_of_leaf[leaf]] += grid.point_count[leaf];
  const double points_each = static_cast<double>(points) / static_cast<double>(grid.points);  // of the grid stands for so many
  const auto is_phantom = [&](const PlaneSegment& plane) {
    const auto label = static_cast<std::size_t>(plane.id);
    return own[label] < 3 || static_cast<double>(own[label]) < kLeastShare * points_each * static_cast<double>(in_leaves[label]);
  };
  if (std::erase_if(segmentation.planes, is_phantom) == 0) return false;
  int id = kLabelFirst;
  for (PlaneSegment& plane : segmentation.planes) plane.id = id++;
  return true;
}

void measure_points(const PointCloud& cloud, double cell_m, int threads, LabelBuffers& buffers, Segmentation& segmentation) {
  const std::size_t planes = segmentation.planes.size();
  const std::vector<std::uint8_t>& labels = segmentation.labels;
  std::vector<PlaneFrame>& frames = buffers.frames;
  frames.clear();
  for (const PlaneSegment& segment : segmentation.planes) frames.emplace_back(translated(segment.plane, cloud.origin));

  std::vector<PointsOnPlane>& parts = buffers.points;  // by task and plane
  parts.assign(std::max<std::size_t>(1, task_count(cloud.size())) * planes, PointsOnPlane{});
  for_each_task(cloud.size(), threads, [&](std::size_t task, std::size_t first, std::size_t end) {
    PointsOnPlane* const part = parts.data() + task * planes;
    for_each_on_plane(labels, first, end,
                      [&](std::size_t i, std::size_t plane) { part[plane].add(frames[plane], cloud.local(i)); });
  });
  for (std::size_t i = planes; i < parts.size(); ++i) parts[i % planes] += parts[i];

  std::vector<OccupiedCells>& cells = buffers.cells;
  cells.resize(std::max(cells.size(), planes));
  for (std::size_t plane = 0; plane < planes; ++plane) cells[plane].restart(parts[plane], cell_m);
  for_each_task(cloud.size(), threads, [&](std::size_t /*task*/, std::size_t first, std::size_t end) {
    for_each_on_plane(labels, first, end,
                      [&](std::size_t i, std::size_t plane) { cells[plane].add(frames[plane].place(cloud.local(i))); });
  });
  for (std::size_t plane = 0; plane < planes; ++plane) {
    PlaneSegment& segment = segmentation.planes[plane];
    segment.inliers = parts[plane].count;
    if (segment.inliers > 0) segment.centroid = parts[plane].sum / static_cast<double>(segment.inliers) + cloud.origin;
    segment.rms_m = segment.inliers == 0 ? 0.0 : std::sqrt(parts[plane].squared_distance / static_cast<double>(segment.inliers));
    segment.area_m2 = cells[plane].area(segment.inliers);
  }
}

}  // namespace fransac
