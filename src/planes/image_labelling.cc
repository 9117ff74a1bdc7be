// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <cstring>

#include "fransac/core/parallel.hpp"
#include "planes/image_plane.hpp"
#include "planes/labelling.hpp"
#include "planes/row_tasks.hpp"

namespace fransac {
namespace {

/// A plane is never taken for nearer to the camera's centre than this, some tens of times the noise: seen that edge-on, a pixel's
/// footprint would be noise.
constexpr double kLeastDistance_m = 0.05;

/// The image's planes as its rows see them.
class ImagePlanes {
 public:
  template <class Raw>
  ImagePlanes(const DepthRows<Raw>& rows, const std::vector<PlaneSegment>& segments, AlignedVector<ImagePlane>& planes)
      : planes_(&planes) {
    planes.clear();
    for (const PlaneSegment& s : segments) planes.emplace_back(s.plane, rows.camera(), rows.view().metres_per_unit());
  }
  [[nodiscard]] std::size_t size() const { return planes_->size(); }
  [[nodiscard]] kernels::LabelPlane at(std::size_t p, int v) const {
    return {(*planes_)[p].row(v), static_cast<std::uint8_t>(p + kLabelFirst)};
  }

 private:
  const AlignedVector<ImagePlane>* planes_;
};

PlaneSums& operator+=(PlaneSums& sum, const kernels::RowEvidence& row) {
  sum.count += row.count;
  sum.squared_distance += static_cast<double>(row.squared_distance);
  sum.cubed_depth += static_cast<double>(row.cubed_depth);
  return sum;
}

/// Labels one row, or takes the labels it has, and adds up what each plane shows.
template <class Raw>
class RowLabeller {
 public:
  RowLabeller(const DepthRows<Raw>& rows, const ImagePlanes& planes, float threshold, bool labelled)
      : rows_(rows), planes_(planes), threshold_(threshold), labelled_(labelled) {}

  void run(int v, LabelTask& task, std::uint8_t* labels) const {
    const auto row = rows_.row(v, task.row);
    const std::size_t n = rows_.padded_width();
    std::uint8_t* const out = n == rows_.width() ? labels : task.labels.data();
    if (labelled_ && out != labels) std::memcpy(out, labels, rows_.width());
    task.planes.resize(planes_.size());
    for (std::size_t p = 0; p < planes_.size(); ++p) task.planes[p] = planes_.at(p, v);
    if (planes_.size() == 1 && !labelled_) {
      task.evidence.front() += kernels_.label_one(row.measured, row.kept, n, task.planes.front(), threshold_, out);
    } else {
      if (!labelled_) kernels_.label(row.measured, row.kept, n, task.planes.data(), planes_.size(), threshold_, out);
      for (std::size_t p = 0; p < planes_.size(); ++p) {
        task.evidence[p] += kernels_.evidence(row.measured, out, n, task.planes[p]);
      }
    }
    if (!labelled_ && out != labels) std::memcpy(labels, out, rows_.width());
  }

 private:
  const kernels::RowKernels<Raw>& kernels_ = kernels::row_kernels<Raw>();
  const DepthRows<Raw>& rows_;
  const ImagePlanes& planes_;
  float threshold_;
  bool labelled_;
};

template <class Raw>
void run(const DepthRows<Raw>& rows, double threshold_m, bool labelled, int threads, LabelBuffers& buffers,
         Segmentation& segmentation) {
  const ImagePlanes planes(rows, segmentation.planes, buffers.planes);
  const RowLabeller<Raw> labeller(rows, planes, static_cast<float>(threshold_m), labelled);
  const std::size_t tasks = row_tasks(rows.height());
  buffers.tasks.resize(std::max(tasks, buffers.tasks.size()));
  parallel_for(threads_for_rows(threads, rows.view().size()), tasks, [&](std::size_t i) {
    LabelTask& task = buffers.tasks[i];
    task.evidence.assign(planes.size(), PlaneSums{});
    task.labels.assign(rows.padded_width(), kLabelNoDepth);
    const int first = static_cast<int>(i) * kRowsOfTask;
    for (int v = first; v < std::min(first + kRowsOfTask, rows.height()); ++v) {
      labeller.run(v, task, &segmentation.labels[static_cast<std::size_t>(v) * rows.width()]);
    }
  });

  const auto metres = static_cast<double>(rows.view().metres_per_unit());
  const double per_volume = metres * metres * metres / (rows.camera().fx * rows.camera().fy);
  for (std::size_t p = 0; p < planes.size(); ++p) {
    PlaneSums sum;
    for (std::size_t i = 0; i < tasks; ++i) sum += buffers.tasks[i].evidence[p];
    PlaneSegment& segment = segmentation.planes[p];
    segment.inliers = sum.count;
    segment.rms_m = sum.count > 0 ? std::sqrt(sum.squared_distance / static_cast<double>(sum.count)) : 0.0;
    segment.area_m2 = sum.cubed_depth * per_volume / std::max(std::abs(segment.plane.d), kLeastDistance_m);
  }
}

}  // namespace

PlaneSums& PlaneSums::operator+=(const PlaneSums& other) {
  count += other.count;
  squared_distance += other.squared_distance;
  cubed_depth += other.cubed_depth;
  return *this;
}

void label_image(const DepthView& depth, const Camera& camera, const LabelRule& rule, int threads, LabelBuffers& buffers,
                 Segmentation& segmentation) {
  with_raw_type(depth.format(), [&](auto raw) {
    run(DepthRows<decltype(raw)>(depth, camera, rule.limits), rule.threshold_m, false, threads, buffers, segmentation);
  });
}

void label_image_by_leaves(const DepthView& depth, const Camera& camera, const VoxelGrid& grid, double threshold_m, int threads,
                           LabelBuffers& buffers, Segmentation& segmentation) {
  const std::vector<std::uint8_t>& label_of_leaf = leaf_labels(grid.leaves, threshold_m, segmentation.planes, threads, buffers);
  const auto width = static_cast<std::size_t>(depth.width());
  for (std::size_t i = 0; i < segmentation.labels.size(); ++i) {
    const std::uint32_t leaf = grid.leaf_of[i];
    const auto unlabelled = [&] {
      return depth.metres(static_cast<int>(i % width), static_cast<int>(i / width)) > 0.0F ? kLabelNoPlane : kLabelNoDepth;
    };
    segmentation.labels[i] = leaf == VoxelGrid::kNoLeaf ? unlabelled() : label_of_leaf[leaf];
  }
  with_raw_type(depth.format(), [&](auto raw) {
    run(DepthRows<decltype(raw)>(depth, camera, nullptr), threshold_m, true, threads, buffers, segmentation);
  });
}

}  // namespace fransac
