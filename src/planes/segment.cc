// SPDX-License-Identifier: Apache-2.0
#include "fransac/planes/segment.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>
#include <new>
#include <string>

#include "fransac/filter/deproject.hpp"
#include "fransac/filter/voxel_grid.hpp"
#include "fransac/sac/plane_problem.hpp"
#include "fransac/sac/ransac.hpp"
#include "planes/labelling.hpp"
#include "planes/methods.hpp"

namespace fransac {

struct Workspace::Impl {
  PointCloud points;  // the input's measured points, then those within the limits
  VoxelGrid grid;
  PointCloud remaining;  // what is left after peeling planes off
  sac::RansacWorkspace<Plane> ransac;
  RowBuffers row;
};

Workspace::Workspace() : impl_(std::make_unique<Impl>()) {}
Workspace::~Workspace() = default;
Workspace::Workspace(Workspace&&) noexcept = default;
Workspace& Workspace::operator=(Workspace&&) noexcept = default;

namespace {

class Stopwatch {
 public:
  /// Milliseconds since the last call or the start.
  double lap() {
    const auto now = Clock::now();
    const std::chrono::duration<double, std::milli> elapsed = now - last_;
    last_ = now;
    return elapsed.count();
  }

 private:
  using Clock = std::chrono::steady_clock;
  Clock::time_point last_ = Clock::now();
};

Status check(const DepthView& depth, const Camera& camera) {
  if (Status status = validate(depth); !status) return status;
  if (Status status = validate(camera); !status) return status;
  if (camera.width == depth.width() && camera.height == depth.height()) return {};
  const auto size = [](int w, int h) { return std::to_string(w) + " x " + std::to_string(h); };
  return Error{ErrorCode::invalid_argument, "camera is for " + size(camera.width, camera.height) +
                                                " pixels, the depth image has " + size(depth.width(), depth.height())};
}

Status check(const PointCloud& cloud) {
  if (cloud.size() > static_cast<std::size_t>(std::numeric_limits<int>::max())) {
    return Error{ErrorCode::unsupported,
                 "point cloud: " + std::to_string(cloud.size()) + " points; at most 2^31 - 1 are supported"};
  }
  const std::size_t organised_size =
      static_cast<std::size_t>(std::max(cloud.width, 0)) * static_cast<std::size_t>(std::max(cloud.height, 0));
  if (cloud.organised() && organised_size != cloud.size()) {
    return Error{ErrorCode::invalid_argument, "point cloud: width x height is not its number of points"};
  }
  if (!cloud.origin.allFinite()) return Error{ErrorCode::invalid_argument, "point cloud: origin must be finite"};
  return {};
}

/// What the pipeline needs of an input: its points, and labels in its own layout.
struct DepthSource {
  const DepthView& depth;
  const Camera& camera;
  static constexpr bool kAxesAreKnown = true;

  [[nodiscard]] Status check() const { return fransac::check(depth, camera); }
  [[nodiscard]] int width() const { return depth.width(); }
  [[nodiscard]] int height() const { return depth.height(); }
  void points(PointCloud& out) const { deproject(depth, camera, out); }
  void label(const LabelRule& rule, Workspace::Impl& work, Segmentation& s) const {
    label_image(depth, camera, rule, work.row, s);
  }
  void measure(double /*cell_m*/, Workspace::Impl& work, Segmentation& s) const { measure_image(depth, camera, work.row, s); }
};

struct CloudSource {
  const PointCloud& cloud;
  static constexpr bool kAxesAreKnown = false;

  [[nodiscard]] Status check() const { return fransac::check(cloud); }
  [[nodiscard]] int width() const { return cloud.organised() ? cloud.width : static_cast<int>(cloud.size()); }
  [[nodiscard]] int height() const { return cloud.organised() ? cloud.height : 1; }
  void points(PointCloud& out) const {
    out = cloud;
    out.source.clear();  // labels belong to this cloud's points, whatever it was filtered from
    remove_unmeasured(out);
  }
  void label(const LabelRule& rule, Workspace::Impl& /*work*/, Segmentation& s) const { label_points(cloud, rule, s); }
  void measure(double cell_m, Workspace::Impl& /*work*/, Segmentation& s) const { measure_points(cloud, cell_m, s); }
};

/// Takes the points within the threshold of the plane (local coordinates) out of the cloud.
void remove_inliers(const Plane& plane, double threshold_m, PointCloud& cloud) {
  std::size_t k = 0;
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const Eigen::Vector3d p = cloud.local(i);
    if (std::abs(plane.signed_distance(p)) <= threshold_m) continue;
    cloud.set(k++, p.cast<float>());
  }
  cloud.resize_uninitialised(k);
}

sac::RansacOptions ransac_options(const SegmentOptions& options, const MethodParts& parts) {
  sac::RansacOptions r;
  r.probability = options.ransac.probability;
  r.max_iterations = static_cast<std::uint32_t>(options.ransac.max_iterations);
  r.pretest_points = options.ransac.pretest_points.value_or(parts.pretest_points);
  r.local_optimisation = options.ransac.local_optimisation;
  r.seed = options.seed;
  r.threads = options.threads;
  return r;
}

/// Finds planes one by one, each in what the ones before left over. Planes are in the input's coordinates, most support first.
Status peel_planes(const PointCloud& sampled, const SegmentOptions& options, const MethodParts& parts, Workspace::Impl& work,
                   Segmentation& result) {
  const double threshold = options.ransac.threshold_m;
  const int max_planes = options.max_planes == 0 ? kMaxPlanes : options.max_planes;
  const double min_support = std::max(3.0, options.min_support * static_cast<double>(sampled.size()));
  sac::RansacOptions ransac = ransac_options(options, parts);
  const PointCloud* cloud = &sampled;
  while (static_cast<int>(result.planes.size()) < max_planes) {
    const sac::PlaneProblem problem(*cloud, threshold, options.ransac.scoring);
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
      const std::optional<sac::PlaneFit> fit = sac::fit_plane(sac::inlier_moments(*cloud, plane, threshold));
      if (fit) plane = fit->plane;
    }
    PlaneSegment& segment = result.planes.emplace_back();
    segment.plane = translated(plane, -cloud->origin);
    segment.support = found.score.inliers;
    segment.iterations = found.iterations;
    segment.stop_reason = found.stop_reason;
    if (static_cast<int>(result.planes.size()) == max_planes) break;
    if (cloud == &sampled) work.remaining = sampled;
    cloud = &work.remaining;
    remove_inliers(plane, threshold, work.remaining);
    ++ransac.round;
  }
  std::stable_sort(result.planes.begin(), result.planes.end(),
                   [](const PlaneSegment& a, const PlaneSegment& b) { return a.support > b.support; });
  for (std::size_t i = 0; i < result.planes.size(); ++i) result.planes[i].id = static_cast<int>(i) + kLabelFirst;
  return {};
}

Status require_points(const PointCloud& points, const char* where) {
  if (points.size() >= 3) return {};
  return Error{ErrorCode::no_data, "a plane needs three points, there are " + std::to_string(points.size()) + " " + where};
}

/// The paper's figure 2: depth -> cloud -> pass-through -> voxel grid -> RANSAC -> labels. The other methods leave parts out.
template <class Source>
Status run_pipeline(const Source& source, const SegmentOptions& options, Workspace::Impl& work, Segmentation& result) {
  const MethodParts parts = parts_of(options.method);
  const bool limits_chosen = options.pass_through.limits != AxisLimits{};
  const bool limited = options.pass_through.use.value_or(limits_chosen || (parts.pass_through && Source::kAxesAreKnown));
  const auto time_of = [&](Stage stage) -> double& { return result.timing.stage_ms[static_cast<std::size_t>(stage)]; };
  Stopwatch total;
  Stopwatch watch;

  source.points(work.points);
  result.valid_points = work.points.size();
  if (Status status = require_points(work.points, "with a measurement"); !status) return status;
  time_of(Stage::deproject) = watch.lap();

  if (limited) {
    pass_through(options.pass_through.limits, work.points);
    if (Status status = require_points(work.points, "within the pass-through limits"); !status) return status;
    time_of(Stage::pass_through) = watch.lap();
  }

  const PointCloud* sampled = &work.points;
  if (parts.voxel_grid) {
    if (Status status = voxel_grid(work.points, options.voxel_grid.leaf_size_m, options.voxel_grid.leaf_point, work.grid);
        !status)
      return status;
    sampled = &work.grid.leaves;
    if (Status status = require_points(*sampled, "after the voxel grid (leaf-size)"); !status) return status;
    time_of(Stage::voxel_grid) = watch.lap();
  }
  result.sampled_points = sampled->size();

  if (Status status = peel_planes(*sampled, options, parts, work, result); !status) return status;
  time_of(Stage::ransac) = watch.lap();

  const LabelRule rule{options.ransac.threshold_m, limited ? &options.pass_through.limits : nullptr};
  if (options.labels_from == LabelsFrom::leaves && parts.voxel_grid) {
    std::vector<PlaneSegment> planes;
    planes.swap(result.planes);
    source.label(rule, work, result);  // without planes: only "no depth" and "no plane"
    planes.swap(result.planes);
    label_leaves(work.points, work.grid, rule.threshold_m, result);
  } else {
    source.label(rule, work, result);
  }
  source.measure(options.voxel_grid.leaf_size_m, work, result);
  time_of(Stage::labels) = watch.lap();
  result.timing.total_ms = total.lap();
  return {};
}

/// Empties the result but keeps its memory.
void reset(Segmentation& s, Method method, int width, int height) {
  std::vector<std::uint8_t> labels = std::move(s.labels);
  std::vector<PlaneSegment> planes = std::move(s.planes);
  s = Segmentation{};
  labels.assign(static_cast<std::size_t>(width) * static_cast<std::size_t>(height), kLabelNoDepth);
  planes.clear();
  s.labels = std::move(labels);
  s.planes = std::move(planes);
  s.method = method == Method::automatic ? Method::fransac : method;
  s.width = width;
  s.height = height;
}

template <class Source>
Status segment_checked(const Source& source, const SegmentOptions& options, Workspace& workspace,
                       Segmentation& segmentation) try {
  if (Status status = validate(options); !status) return status;
  if (Status status = source.check(); !status) return status;
  reset(segmentation, options.method, source.width(), source.height());
  return run_pipeline(source, options, workspace.impl(), segmentation);
} catch (const std::bad_alloc&) {
  return Error{ErrorCode::out_of_memory,
               "not enough memory for " + std::to_string(source.width()) + " x " + std::to_string(source.height()) + " points"};
}

template <class Source>
Status segment_source(const Source& source, const SegmentOptions& options, Workspace& workspace, Segmentation& segmentation) {
  Status status = segment_checked(source, options, workspace, segmentation);
  if (!status) reset(segmentation, options.method, 0, 0);  // no planes of a frame before, no half of this one
  return status;
}

template <class... Input>
Result<Segmentation> segment_once(const SegmentOptions& options, const Input&... input) {
  Workspace workspace;
  Segmentation segmentation;
  if (Status status = segment(input..., options, workspace, segmentation); !status) return status.error();
  return segmentation;
}

}  // namespace

Status segment(const DepthView& depth, const Camera& camera, const SegmentOptions& options, Workspace& workspace,
               Segmentation& segmentation) {
  return segment_source(DepthSource{depth, camera}, options, workspace, segmentation);
}

Status segment(const PointCloud& cloud, const SegmentOptions& options, Workspace& workspace, Segmentation& segmentation) {
  return segment_source(CloudSource{cloud}, options, workspace, segmentation);
}

Result<Segmentation> segment(const DepthView& depth, const Camera& camera, const SegmentOptions& options) {
  return segment_once(options, depth, camera);
}

Result<Segmentation> segment(const PointCloud& cloud, const SegmentOptions& options) { return segment_once(options, cloud); }

}  // namespace fransac
