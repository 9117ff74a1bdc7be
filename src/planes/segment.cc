// SPDX-License-Identifier: Apache-2.0
#include "fransac/planes/segment.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <new>
#include <string>

#include "core/caught.hpp"
#include "fransac/core/parallel.hpp"
#include "fransac/filter/correct.hpp"
#include "fransac/filter/organised.hpp"
#include "fransac/filter/voxel_grid.hpp"
#include "fransac/sac/plane_problem.hpp"
#include "fransac/sac/ransac.hpp"
#include "kernels/targets.h"
#include "planes/cells/cells.hpp"
#include "planes/depth_data.hpp"
#include "planes/labelling.hpp"
#include "planes/methods.hpp"
#include "planes/renumber.hpp"
#include "planes/require_points.hpp"
#include "planes/set_up.hpp"
#include "planes/stage_clock.hpp"

namespace fransac {

struct Workspace::Impl {
  OrganisedDepth organised;
  CorrectedDepth corrected;
  PointCloud points;            // of a cloud, those measured and within the limits where not all are, and those drawn of too many
  std::size_t kept_points = 0;  // before any were drawn
  VoxelGrid grid;
  DepthDataBuffers depth;
  PointCloud remaining;  // what is left after peeling planes off
  AlignedVector<std::uint16_t> remaining_units;
  AlignedVector<float> remaining_metres;
  PointCloud sample;
  sac::RansacWorkspace<sac::PlaneProblem> ransac;
  LabelBuffers labels;
  cells::Buffers cells;
};

Workspace::Workspace() : impl_(std::make_unique<Impl>()) {}
Workspace::~Workspace() = default;
Workspace::Workspace(Workspace&&) noexcept = default;
Workspace& Workspace::operator=(Workspace&&) noexcept = default;
void Workspace::expect(std::span<const PlaneSegment> planes) { impl_->cells.wanted.assign(planes.begin(), planes.end()); }

namespace {

Status check_instruction_set() {
  static const char* const wanted = std::getenv("FRANSAC_TARGET");
  if (wanted == nullptr || instruction_set() == wanted) return {};
  return Error{ErrorCode::unsupported, "FRANSAC_TARGET: this machine has no instruction set of that name; without it " +
                                           std::string(instruction_set()) + " is used"};
}

Status check(const DepthView& depth, const Camera& camera) {
  if (Status status = validate(depth); !status) return status;
  if (Status status = validate(camera); !status) return status;
  if (camera.width == depth.width() && camera.height == depth.height()) return {};
  const auto size = [](int w, int h) { return std::to_string(w) + " x " + std::to_string(h); };
  return Error{ErrorCode::invalid_argument, "camera is for " + size(camera.width, camera.height) +
                                                " pixels, the depth image has " + size(depth.width(), depth.height())};
}

sac::RansacOptions ransac_options(const SegmentOptions& options) {
  sac::RansacOptions r;
  r.probability = options.ransac.probability;
  r.max_iterations = static_cast<std::uint32_t>(options.ransac.max_iterations);
  r.pretest_points = options.ransac.pretest_points.value_or(parts_of(options.method).pretest_points);
  r.local_optimisation = options.ransac.local_optimisation;
  r.seed = options.seed;
  r.threads = options.threads;
  return r;
}

/// The points that planes are peeled off: a cloud, or the leaves of one.
class CloudPeeler {
 public:
  CloudPeeler(const PointCloud& cloud, int threads, PointCloud& remaining)
      : cloud_(&cloud), remaining_(&remaining), threads_(threads) {
    data_.emplace(cloud, threads);
  }
  [[nodiscard]] const sac::PlaneData& data() const { return *data_; }
  [[nodiscard]] const Eigen::Vector3d& origin() const { return cloud_->origin; }

  /// Takes away the points within the threshold of the plane (local coordinates).
  void remove(const Plane& plane, double threshold_m) {
    remaining_->origin = cloud_->origin;
    if (cloud_ != remaining_) remaining_->resize_uninitialised(cloud_->size());
    std::size_t k = 0;
    for (std::size_t i = 0; i < cloud_->size(); ++i) {
      const Eigen::Vector3d p = cloud_->local(i);
      if (std::abs(plane.signed_distance(p)) > threshold_m) remaining_->set(k++, p.cast<float>());
    }
    remaining_->resize_uninitialised(k);
    cloud_ = remaining_;
    data_.emplace(*cloud_, threads_);
  }

 private:
  const PointCloud* cloud_;
  PointCloud* remaining_;
  int threads_;
  std::optional<sac::CloudData> data_;
};

/// The pixels that planes are peeled off.
template <class Raw>
class DepthPeeler {
 public:
  DepthPeeler(const DepthRows<Raw>& rows, int threads, DepthDataBuffers& buffers, AlignedVector<Raw>& remaining)
      : rows_(rows), buffers_(&buffers), remaining_(&remaining), threads_(threads) {
    data_.emplace(rows_, threads, buffers);
  }
  [[nodiscard]] const DepthData<Raw>& data() const { return *data_; }
  [[nodiscard]] static Eigen::Vector3d origin() { return Eigen::Vector3d::Zero(); }

  void remove(const Plane& plane, double threshold_m) {
    const ImagePlane image_plane(plane, rows_.camera(), rows_.view().metres_per_unit(), threshold_m);
    const std::size_t width = rows_.padded_width();
    remaining_->resize(width * static_cast<std::size_t>(rows_.height()));
    DepthRowBuffer& buffer = buffers_->rows.front();
    for (int v = 0; v < rows_.height(); ++v) {
      // In place from the second plane on; a kernel reads each block before it writes it.
      Raw* const left = remaining_->data() + static_cast<std::size_t>(v) * width;
      kernels::row_kernels<Raw>().remove(rows_.row(v, buffer).kept, width, image_plane.row(v), left);
    }
    view_ = rows_.view().in_memory(remaining_->data(), static_cast<std::ptrdiff_t>(width * sizeof(Raw)));
    rows_ = DepthRows<Raw>(view_, rows_.camera(), nullptr);
    data_.emplace(rows_, threads_, *buffers_);
  }

 private:
  DepthView view_;
  DepthRows<Raw> rows_;
  DepthDataBuffers* buffers_;
  AlignedVector<Raw>* remaining_;
  int threads_;
  std::optional<DepthData<Raw>> data_;
};

/// First the planes with most of it; of equals the one with the smaller id.
void sort_planes(PlaneOrder order, std::vector<PlaneSegment>& planes) {
  const auto size = [order](const PlaneSegment& p) {
    return order == PlaneOrder::area ? p.area_m2 : static_cast<double>(p.support);
  };
  // std::stable_sort would ask for memory.
  std::sort(planes.begin(), planes.end(),
            [&](const PlaneSegment& a, const PlaneSegment& b) { return size(a) != size(b) ? size(a) > size(b) : a.id < b.id; });
}

/// Finds planes one by one, each in what the ones before left over. Planes are in the input's coordinates, most support first.
template <class Peeler>
Status peel_planes(Peeler& peeler, const SegmentOptions& options, Workspace::Impl& work, Segmentation& result) {
  const double threshold = options.ransac.threshold_m;
  const int max_planes = *options.max_planes == 0 ? kMaxPlanes : *options.max_planes;
  const double min_support = std::max(3.0, *options.min_support * static_cast<double>(result.sampled_points));
  sac::RansacOptions ransac = ransac_options(options);
  for (;;) {
    const sac::PlaneProblem problem(peeler.data(), threshold, options.ransac.scoring, ransac.seed, ransac.round, work.sample);
    const sac::RansacResult<Plane> found = sac::ransac(problem, ransac, work.ransac);
    result.iterations += found.iterations;
    result.rejected += found.rejected;
    result.degenerate += found.degenerate;
    if (result.planes.empty()) {
      result.stop_reason = found.stop_reason;
      if (!found.model && found.stop_reason == StopReason::degenerate) {
        return Error{ErrorCode::no_data, "all points are collinear or coincide (" + std::to_string(found.degenerate) +
                                             " degenerate samples): they determine no plane"};
      }
    }
    if (!found.model || static_cast<double>(found.score.inliers) < min_support) break;

    Plane plane = *found.model;
    if (options.ransac.refine) {
      if (const std::optional<Plane> refined = problem.refine_on_all(plane)) plane = *refined;
    }
    PlaneSegment& segment = result.planes.emplace_back();
    segment.plane = translated(plane, -peeler.origin());
    segment.support = found.score.inliers;
    segment.iterations = found.iterations;
    segment.stop_reason = found.stop_reason;
    if (static_cast<int>(result.planes.size()) == max_planes) break;
    peeler.remove(plane, threshold);
    ++ransac.round;
  }
  for (std::size_t i = 0; i < result.planes.size(); ++i) result.planes[i].id = static_cast<int>(i) + kLabelFirst;
  sort_planes(PlaneOrder::support, result.planes);
  for (std::size_t i = 0; i < result.planes.size(); ++i) result.planes[i].id = static_cast<int>(i) + kLabelFirst;
  return {};
}

/// Leaves out planes that are too small and brings the others into the order asked for, once areas are known.
void arrange(const SegmentOptions& options, Segmentation& s) {
  const auto numbered = static_cast<int>(s.planes.size());
  std::erase_if(s.planes, [&](const PlaneSegment& plane) { return plane.area_m2 < options.cells.min_area_m2; });
  sort_planes(*options.order, s.planes);
  renumber(numbered, s);
}

/// What a run does, once options, method and kind of input have been put together.
struct Recipe {
  const SegmentOptions& options;
  bool voxel_grid;
  const AxisLimits* limits;  ///< Null: no pass-through.
  [[nodiscard]] bool labels_from_leaves() const { return voxel_grid && options.labels_from == LabelsFrom::leaves; }
};

constexpr const char* kAfterGrid = "after the voxel grid (leaf-size)";

struct DepthSource {
  const DepthView& depth;
  const Camera& camera;
  static constexpr bool kDepthImage = true;

  [[nodiscard]] Status check() const { return fransac::check(depth, camera); }
  [[nodiscard]] int width() const { return depth.width(); }
  [[nodiscard]] int height() const { return depth.height(); }
  static void set_up(const SegmentOptions& options, Segmentation& s) { fransac::set_up(options, s); }

  /// No cloud is made: the voxel grid, or RANSAC itself, reads raw depth.
  Status find(const Recipe& recipe, Workspace::Impl& work, StageClock& clock, Segmentation& result) const {
    const SegmentOptions& options = recipe.options;
    if (recipe.voxel_grid) {
      const DepthGridOptions grid{.leaf_size_m = options.voxel_grid.leaf_size_m,
                                  .leaf_point = options.voxel_grid.leaf_point,
                                  .limits = recipe.limits,
                                  .leaf_of = recipe.labels_from_leaves(),
                                  .threads = options.threads};
      if (Status status = voxel_grid(depth, camera, grid, work.grid); !status) return status;
      if (Status status = count(work.grid.measured, work.grid.points, work.grid.leaves.size(), result); !status) return status;
      clock.end(Stage::voxel_grid);
      CloudPeeler peeler(work.grid.leaves, options.threads, work.remaining);
      return peel_planes(peeler, options, work, result);
    }
    if (depth.format() == DepthFormat::uint16) return find_in_pixels(recipe, work.remaining_units, work, result);
    return find_in_pixels(recipe, work.remaining_metres, work, result);
  }

  void label(const Recipe& recipe, Workspace::Impl& work, Segmentation& s) const {
    const double threshold = recipe.options.ransac.threshold_m;
    if (recipe.labels_from_leaves()) {
      label_image_by_leaves(depth, camera, work.grid, threshold, recipe.options.threads, work.labels, s);
    } else {
      label_image(depth, camera, {threshold, recipe.limits}, recipe.options.threads, work.labels, s);
    }
  }

 private:
  static Status count(std::uint64_t measured, std::uint64_t kept, std::uint64_t sampled, Segmentation& result) {
    result.valid_points = measured;
    result.sampled_points = sampled;
    if (Status status = require_points(measured, kMeasured); !status) return status;
    if (Status status = require_points(kept, kWithinLimits); !status) return status;
    return require_points(sampled, kAfterGrid);
  }

  template <class Raw>
  Status find_in_pixels(const Recipe& recipe, AlignedVector<Raw>& remaining, Workspace::Impl& work, Segmentation& result) const {
    const DepthRows<Raw> rows(depth, camera, recipe.limits);
    DepthPeeler<Raw> peeler(rows, recipe.options.threads, work.depth, remaining);
    const std::uint64_t kept = peeler.data().size();
    if (Status status = count(peeler.data().measured(), kept, kept, result); !status) return status;
    return peel_planes(peeler, recipe.options, work, result);
  }
};

/// The most points that are sorted into leaves for the search. Of larger clouds so many are drawn: leaves are to have a few
/// points each, and a plane that 1 % of them lie on still has ten thousand.
constexpr std::size_t kMostPointsInGrid = std::size_t{1} << 20;

/// `n` of the cloud's points: one of each stretch of size / n, at a place in it that follows no pattern. May be the same cloud.
void draw_evenly(const PointCloud& cloud, std::size_t n, PointCloud& drawn) {
  constexpr std::uint32_t kGolden = 0x9E3779B9;  // 2^32 / golden ratio: its multiples are spread evenly (Knuth, TAOCP 3, 6.4)
  const std::size_t size = cloud.size();
  drawn.origin = cloud.origin;
  drawn.source.clear();
  if (drawn.size() < n) drawn.resize_uninitialised(n);
  for (std::size_t k = 0; k < n; ++k) {
    const std::size_t begin = k * size / n;
    const std::size_t length = (k + 1) * size / n - begin;
    const std::uint32_t place = static_cast<std::uint32_t>(k) * kGolden;
    const std::size_t i = begin + (length * place >> 32);
    drawn.x()[k] = cloud.x()[i];
    drawn.y()[k] = cloud.y()[i];
    drawn.z()[k] = cloud.z()[i];
  }
  drawn.resize_uninitialised(n);
  drawn.width = static_cast<int>(n);
  drawn.height = 1;
}

/// Removes points that are a hundred times as far away as the middle 98 % of all reach: whether there were any.
bool remove_stray_points(PointCloud& cloud) {
  constexpr std::size_t kShare = 100;  // one in so many may lie beyond the middle, on either side
  constexpr double kReach = 100.0;
  const std::size_t size = cloud.size();
  const std::size_t beyond = std::min(std::max<std::size_t>(size / kShare, 1), size / 2);
  std::array<AxisLimits, 3> middle{};
  double extent_m = 0.0;
  for (const Axis axis : {Axis::x, Axis::y, Axis::z}) {
    const auto i = static_cast<std::size_t>(axis);
    const float* const coordinate = std::array{cloud.x(), cloud.y(), cloud.z()}[i];
    std::vector<float> values(coordinate, coordinate + size);
    const auto at = [&](std::size_t rank) {
      std::nth_element(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(rank), values.end());
      return static_cast<double>(values[rank]) + cloud.origin[static_cast<Eigen::Index>(i)];
    };
    middle[i] = {.axis = axis, .min_m = at(beyond), .max_m = at(size - 1 - beyond)};
    extent_m = std::max(extent_m, middle[i].max_m - middle[i].min_m);
  }
  for (AxisLimits& limits : middle) {
    limits.min_m -= kReach * extent_m;
    limits.max_m += kReach * extent_m;
    pass_through(limits, cloud);
  }
  return cloud.size() < size;
}

struct CloudSource {
  const PointCloud& cloud;
  static constexpr bool kDepthImage = false;

  [[nodiscard]] Status check() const { return validate(cloud); }
  [[nodiscard]] int width() const { return cloud.organised() ? cloud.width : static_cast<int>(cloud.size()); }
  [[nodiscard]] int height() const { return cloud.organised() ? cloud.height : 1; }
  void set_up(const SegmentOptions& options, Segmentation& s) const { fransac::set_up(options, cloud, s); }

  Status find(const Recipe& recipe, Workspace::Impl& work, StageClock& clock, Segmentation& result) const {
    const SegmentOptions& options = recipe.options;
    result.valid_points = count_measured(cloud);
    if (Status status = require_points(result.valid_points, kMeasured); !status) return status;
    const PointCloud* sampled = &cloud;
    if (result.valid_points < cloud.size() || recipe.limits != nullptr || recipe.labels_from_leaves()) {
      sampled = &work.points;
      work.points = cloud;
      work.points.source.clear();  // labels belong to this cloud's points, whatever it was filtered from
      remove_unmeasured(work.points);
    }
    clock.end(Stage::deproject);
    if (recipe.limits != nullptr) {
      pass_through(*recipe.limits, work.points);
      if (Status status = require_points(work.points.size(), kWithinLimits); !status) return status;
      clock.end(Stage::pass_through);
    }
    work.kept_points = sampled->size();
    if (recipe.voxel_grid) {
      const VoxelGridOptions& grid = options.voxel_grid;
      const PointsGridOptions leaves{.leaf_size_m = Eigen::Vector3d::Constant(grid.leaf_size_m),
                                     .leaf_point = grid.leaf_point,
                                     .leaf_of = recipe.labels_from_leaves(),
                                     .threads = options.threads};
      if (sampled->size() > kMostPointsInGrid && !leaves.leaf_of) {
        draw_evenly(*sampled, kMostPointsInGrid, work.points);
        sampled = &work.points;
      }
      Status status = voxel_grid(*sampled, leaves, work.grid);
      // A stray point far away must not make the lattice too large for all others.
      if (!status && status.error().code == ErrorCode::invalid_argument) {
        if (sampled == &cloud) work.points = cloud;
        if (remove_stray_points(work.points)) status = voxel_grid(work.points, leaves, work.grid);
      }
      if (!status) return status;
      sampled = &work.grid.leaves;
      if (status = require_points(sampled->size(), kAfterGrid); !status) return status;
      clock.end(Stage::voxel_grid);
    }
    result.sampled_points = sampled->size();
    CloudPeeler peeler(*sampled, options.threads, work.remaining);
    return peel_planes(peeler, options, work, result);
  }

  void label(const Recipe& recipe, Workspace::Impl& work, Segmentation& s) const {
    const LabelRule rule{recipe.options.ransac.threshold_m, recipe.limits};
    if (recipe.labels_from_leaves()) {
      std::vector<PlaneSegment> planes;
      planes.swap(s.planes);
      label_points(cloud, rule, recipe.options.threads, work.labels, s);  // without planes: only "no depth" and "no plane"
      planes.swap(s.planes);
      label_leaves(work.points, work.grid, rule.threshold_m, recipe.options.threads, work.labels, s);
    } else {
      do {
        label_points(cloud, rule, recipe.options.threads, work.labels, s);
      } while (recipe.voxel_grid &&
               remove_phantoms(work.grid, work.kept_points, rule.threshold_m, recipe.options.threads, work.labels, s));
    }
    measure_points(cloud, recipe.options.voxel_grid.leaf_size_m, recipe.options.threads, work.labels, s);
  }
};

/// The paper's figure 2: depth -> cloud -> pass-through -> voxel grid -> RANSAC -> labels. The other methods leave parts out.
template <class Source>
Status run_pipeline(const Source& source, const SegmentOptions& options, Workspace::Impl& work, Segmentation& result) {
  const MethodParts parts = parts_of(options.method);
  const Recipe recipe{options, parts.voxel_grid, limits_of(options, options.method, Source::kDepthImage)};
  StageClock clock(result.timing);
  if (Status status = source.find(recipe, work, clock, result); !status) return status;
  clock.end(Stage::ransac);
  source.label(recipe, work, result);
  arrange(options, result);
  source.set_up(options, result);
  clock.end(Stage::labels);
  return {};
}

/// Empties the result but keeps its memory.
void reset(Segmentation& s, Method method, int width, int height) {
  std::vector<std::uint8_t> labels = std::move(s.labels);
  std::vector<float> residuals = std::move(s.residuals_m);
  std::vector<PlaneSegment> planes = std::move(s.planes);
  s = Segmentation{};
  labels.resize(static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
  residuals.clear();
  planes.clear();
  s.labels = std::move(labels);
  s.residuals_m = std::move(residuals);
  s.planes = std::move(planes);
  s.method = method;
  s.width = width;
  s.height = height;
}

template <class Source>
Status find_planes(const Source& source, const SegmentOptions& options, Workspace::Impl& work, Segmentation& segmentation) {
  if constexpr (Source::kDepthImage) {
    if (options.method == Method::cells) {
      StageClock clock(segmentation.timing);
      return cells::find_planes(source.depth, source.camera, options, limits_of(options, options.method, Source::kDepthImage),
                                work.cells, clock, segmentation);
    }
  }
  return run_pipeline(source, options, work, segmentation);
}

/// The time of a step before the first stage.
void add_time_before(const Timing& before, Timing& timing) {
  timing.stage_ms[static_cast<std::size_t>(Stage::deproject)] += before.total_ms;
  timing.total_ms += before.total_ms;
}

/// Without saturated values and the sensor's distortion, in a copy where there is either.
Status find_planes_of_image(const DepthSource& source, const SegmentOptions& options, Workspace::Impl& work,
                            Segmentation& segmentation) {
  Timing before;
  StageClock clock(before);
  DepthView depth = source.depth;
  const bool saturated = without_saturated(depth, options.saturated, work.corrected);
  if (saturated) depth = work.corrected.view;
  if (!options.sensor.distortion.empty()) {
    if (Status status = correct(depth, options.sensor.distortion, 0, work.corrected); !status) {
      return Error{status.error().code, "sensor: " + status.error().message};
    }
    depth = work.corrected.view;
  }
  clock.end(Stage::deproject);
  if (Status status = find_planes(DepthSource{depth, source.camera}, options, work, segmentation); !status) return status;
  segmentation.distortion = options.sensor.distortion;
  segmentation.saturated = saturated ? options.saturated : 0;
  add_time_before(before, segmentation.timing);
  return {};
}

template <class Source>
Status segment_checked(const Source& source, const SegmentOptions& options, Workspace& workspace,
                       Segmentation& segmentation) try {
  if (Status status = check_instruction_set(); !status) return status;
  if (Status status = validate(options); !status) return status;
  if (Status status = source.check(); !status) return status;
  const Method method = resolve(options.method, Source::kDepthImage);
  SegmentOptions chosen = with_defaults(options, method);
  chosen.method = method;
  if (Status status = validate(chosen); !status) return status;  // `automatic` may have become one that does not know an option
  const AwakeThreads awake(chosen.threads);
  reset(segmentation, method, source.width(), source.height());
  if constexpr (Source::kDepthImage) {
    return find_planes_of_image(source, chosen, workspace.impl(), segmentation);
  } else {
    return find_planes(source, chosen, workspace.impl(), segmentation);
  }
} catch (const std::exception& exception) {
  return caught(exception, [&] { return std::to_string(source.width()) + " x " + std::to_string(source.height()) + " points"; });
}

template <class Source>
Status segment_source(const Source& source, const SegmentOptions& options, Workspace& workspace, Segmentation& segmentation) {
  Status status = segment_checked(source, options, workspace, segmentation);
  // No planes of a frame before, no half of this one.
  if (!status) reset(segmentation, resolve(options.method, Source::kDepthImage), 0, 0);
  return status;
}

/// `cells`, or what `automatic` makes of the cloud: its depth image is segmented where there is one.
Status segment_organised(const PointCloud& cloud, const SegmentOptions& options, Workspace& workspace,
                         Segmentation& segmentation) try {
  Status valid = validate(options);  // the distortion too, which is left out below
  if (valid) valid = validate(cloud);
  if (!valid) {
    reset(segmentation, Method::cells, 0, 0);
    return valid;
  }
  Timing before;
  StageClock clock(before);
  OrganisedDepth& organised = workspace.impl().organised;
  Status found = organised_depth(cloud, organised);
  clock.end(Stage::deproject);
  if (found) {
    const DepthView depth = organised.view();
    SegmentOptions of_cloud = options;
    of_cloud.sensor.distortion = {};  // planes are of the points as they are given
    if (Status status = segment_source(DepthSource{depth, organised.camera}, of_cloud, workspace, segmentation); !status) {
      return status;
    }
    add_time_before(before, segmentation.timing);
    return {};
  }
  const bool no_image = found.error().code == ErrorCode::unsupported;
  if (no_image && options.method == Method::automatic) {
    return segment_source(CloudSource{cloud}, options, workspace, segmentation);
  }
  reset(segmentation, Method::cells, 0, 0);
  if (!no_image) return found;
  return Error{ErrorCode::unsupported,
               "cells needs a depth image or an organised cloud of a pinhole camera: " + found.error().message};
} catch (const std::exception& exception) {
  return caught(exception, "organised cloud");
}

template <class... Input>
Result<Segmentation> segment_once(const SegmentOptions& options, const Input&... input) try {
  Workspace workspace;
  Segmentation segmentation;
  if (Status status = segment(input..., options, workspace, segmentation); !status) return status.error();
  return segmentation;
} catch (const std::exception& exception) {
  return caught(exception, "segmentation");
}

}  // namespace

std::string_view instruction_set() { return kernels::target_name(); }

Status segment(const DepthView& depth, const Camera& camera, const SegmentOptions& options, Workspace& workspace,
               Segmentation& segmentation) {
  return segment_source(DepthSource{depth, camera}, options, workspace, segmentation);
}

Status segment(const PointCloud& cloud, const SegmentOptions& options, Workspace& workspace, Segmentation& segmentation) {
  if (resolve(options.method, true) == Method::cells) return segment_organised(cloud, options, workspace, segmentation);
  return segment_source(CloudSource{cloud}, options, workspace, segmentation);
}

Result<Segmentation> segment(const DepthView& depth, const Camera& camera, const SegmentOptions& options) {
  return segment_once(options, depth, camera);
}

Result<Segmentation> segment(const PointCloud& cloud, const SegmentOptions& options) { return segment_once(options, cloud); }

}  // namespace fransac
