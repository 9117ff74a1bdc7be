// SPDX-License-Identifier: Apache-2.0
#include "planes/cells/cells.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>
#include <tuple>

#include "filter/depth_rows.hpp"
#include "planes/cells/constants.hpp"
#include "planes/covariance.hpp"
#include "planes/renumber.hpp"
#include "planes/require_points.hpp"
#include "planes/set_up.hpp"

namespace fransac::cells {
namespace {

constexpr const Constants& kC = kConstants;

/// Finer cells whose means and slopes differ from their neighbours' by more than this many times the noise of a pixel show that
/// it is more than they see: neighbouring pixels err alike.
constexpr double kMostShown = 2.0;

/// From Grid::parameters() and their covariance: of independent errors of the pixels, and of slow ones that cells near each other
/// share.
std::optional<PlaneEstimate> estimate(const Region& region, const Grid& grid) {
  const PlaneFit& f = region.fit;
  const Camera& camera = grid.camera;
  const double u = camera.cx - 0.5 * grid.width;
  const double v = camera.cy - 0.5 * grid.height;
  const double cells = std::max(region.cells, 1);
  const double pixel = region.sigma() * region.sigma();
  const double pixels = region.moments.n / std::pow(grid.sampling.per_pixel(), 2);
  const double variance = pixel / pixels + pixel * grid.noise.shared * std::min(kC.slow_cells, cells) / cells;
  Eigen::Matrix3d about_mean = Eigen::Matrix3d::Zero();  // of du, dv, and q at the mean pixel
  const double det = f.uu * f.vv - f.uv * f.uv;
  about_mean << f.vv / det, -f.uv / det, 0.0, -f.uv / det, f.uu / det, 0.0, 0.0, 0.0, 1.0;
  Eigen::Matrix3d to_parameters;
  to_parameters << camera.fx, 0.0, 0.0, 0.0, camera.fy, 0.0, u - f.u, v - f.v, 1.0;
  return plane_from_inverse_depth(grid.parameters(f.plane), variance * to_parameters * about_mean * to_parameters.transpose());
}

/// Angle between two directions as undirected lines, degrees.
double angle_deg(const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
  const double cosine = std::min(1.0, std::abs(unit(a).dot(unit(b))));
  return std::acos(cosine) * 180.0 / std::numbers::pi;
}

bool is_wanted(const Plane& plane, const CellsOptions& options) {
  if (options.parallel_to && angle_deg(plane.normal, *options.parallel_to) > options.prior_angle_deg) return false;
  return !options.perpendicular_to || 90.0 - angle_deg(plane.normal, *options.perpendicular_to) <= options.prior_angle_deg;
}

/// Visible square metres, from the cells alone.
double rough_area(const Region& region, const Plane& plane, const Camera& camera) {
  const double z = 1.0 / region.fit.q;
  return region.moments.n * z * z * z / (camera.fx * camera.fy * std::max(std::abs(plane.d), 1e-3));
}

/// The order of planes: most square metres or most pixels first. By area, planes whose depth is known worse than to half of
/// `most_sigma_m` come after the others: so far away a few pixels span metres, and would leave what is near and certain behind a
/// strip of a far wall.
void sort_planes(PlaneOrder order, const DepthNoise& noise, const DepthNoise& slow, std::vector<PlaneSegment>& planes) {
  const bool by_area = order == PlaneOrder::area;
  // The depth whose error is that: sigma^2 = a^2 + (b z^2)^2.
  const auto sum = [](double x, double y) { return x * x + y * y; };
  const double fourth = sum(noise.quadratic_per_m, slow.quadratic_per_m);
  const double left = 0.5 * kC.most_sigma_m * 0.5 * kC.most_sigma_m - sum(noise.constant_m, slow.constant_m);
  const double farthest = fourth > 0.0 ? std::pow(std::max(left, 0.0) / fourth, 0.25) : std::numeric_limits<double>::infinity();
  const auto rank = [&](const PlaneSegment& s) {
    const bool last = by_area && s.centroid.z() > farthest;
    return std::tuple(last, by_area ? -s.area_m2 : -static_cast<double>(s.inliers), s.id);
  };
  std::sort(planes.begin(), planes.end(), [&](const PlaneSegment& a, const PlaneSegment& b) { return rank(a) < rank(b); });
}

/// Makes a plane of every region that can be one, numbered as they will probably be ordered, so that labels seldom change.
void number_regions(const Grid& grid, const SegmentOptions& options, Buffers& b, Segmentation& result) {
  b.labels.assign(b.regions.list.size(), 0);
  b.ranked.clear();
  for (std::size_t g = 0; g < b.regions.list.size(); ++g) {
    const Region& region = b.regions.list[g];
    if (!region.alive || !(region.fit.q > 0.0)) continue;
    const auto plane = estimate(region, grid);
    if (!plane || !is_wanted(plane->plane, options.cells)) continue;
    PlaneSegment& segment = result.planes.emplace_back();
    segment.id = static_cast<int>(g);  // for now
    segment.plane = plane->plane;
    segment.covariance = plane->covariance;
    segment.confidence = region.confidence;
    segment.evidence = region.evidence;
    segment.support = static_cast<std::uint64_t>(region.moments.n / std::pow(grid.sampling.per_pixel(), 2));
    segment.inliers = segment.support;
    segment.area_m2 = rough_area(region, plane->plane, grid.camera);
    segment.centroid.z() = 1.0 / region.fit.q;
  }
  sort_planes(*options.order, result.noise, result.slow_noise, result.planes);
  if (result.planes.size() > static_cast<std::size_t>(kMaxPlanes)) result.planes.resize(static_cast<std::size_t>(kMaxPlanes));
  for (PlaneSegment& segment : result.planes) {
    b.ranked.push_back(static_cast<std::int16_t>(segment.id));
    b.labels[static_cast<std::size_t>(segment.id)] = static_cast<std::uint8_t>(b.ranked.size());
    segment.id = static_cast<int>(b.ranked.size());
  }
}

void measure_planes(const Buffers& b, Segmentation& result) {
  for (std::size_t i = 0; i < result.planes.size(); ++i) {
    PlaneSegment& segment = result.planes[i];
    const PixelEvidence& pixels = b.pixels.evidence[static_cast<std::size_t>(b.ranked[i])];
    const auto count = static_cast<double>(pixels.count);
    segment.inliers = pixels.count;
    segment.area_m2 = pixels.area_m2;
    segment.rms_m = count > 0.0 ? std::abs(segment.plane.d) * std::sqrt(pixels.squared_residual / count) : 0.0;
    segment.centroid = count > 0.0 ? Eigen::Vector3d(pixels.sum / count) : Eigen::Vector3d::Zero();
  }
}

/// Leaves out planes that are too small, puts the others in order, and makes the labels follow.
void arrange(const SegmentOptions& options, Segmentation& result) {
  const int numbered = static_cast<int>(result.planes.size());
  const double least = std::max(1.0, *options.min_support * static_cast<double>(result.sampled_points));
  std::erase_if(result.planes, [&](const PlaneSegment& s) {
    return static_cast<double>(s.inliers) < least || s.area_m2 < options.cells.min_area_m2;
  });
  sort_planes(*options.order, result.noise, result.slow_noise, result.planes);
  const auto most = static_cast<std::size_t>(*options.max_planes == 0 ? kMaxPlanes : *options.max_planes);
  if (result.planes.size() > most) result.planes.resize(most);
  renumber(numbered, result);
}

/// Measured pixels outside the limits are on no plane.
template <class Raw>
void mark_excluded(const DepthRows<Raw>& rows, DepthRowBuffer& buffer, Segmentation& result) {
  for (int v = 0; v < rows.height(); ++v) {
    const auto row = rows.row(v, buffer);
    std::uint8_t* const labels = &result.labels[static_cast<std::size_t>(v) * rows.width()];
    for (std::size_t u = 0; u < rows.width(); ++u) {
      if (row.measured[u] != Raw{0} && row.kept[u] == Raw{0}) labels[u] = kLabelNoPlane;
    }
  }
}

void measure_residuals(const DepthView& depth, const Camera& camera, Segmentation& result) {
  result.residuals_m.assign(result.labels.size(), std::numeric_limits<float>::quiet_NaN());
  for (int v = 0; v < depth.height(); ++v) {
    for (int u = 0; u < depth.width(); ++u) {
      const std::size_t i = static_cast<std::size_t>(v) * static_cast<std::size_t>(depth.width()) + static_cast<std::size_t>(u);
      const std::uint8_t label = result.labels[i];
      if (label == kLabelNoDepth || label == kLabelNoPlane) continue;
      const Eigen::Vector3d ray((u - camera.cx) / camera.fx, (v - camera.cy) / camera.fy, 1.0);
      const Plane& plane = result.planes[static_cast<std::size_t>(label - kLabelFirst)].plane;
      result.residuals_m[i] = static_cast<float>(plane.signed_distance(static_cast<double>(depth.metres(u, v)) * ray));
    }
  }
}

/// Where planes should be seen that were wanted first.
void expect(Buffers& b) {
  const Camera& camera = b.grid.camera;
  b.expected.clear();
  for (const PlaneSegment& wanted : b.wanted) {
    const Plane& plane = wanted.plane;
    const Eigen::Vector3d& middle = wanted.centroid;
    constexpr double kNearest_m = 1e-3;  // nothing is seen there, and planes through the camera are not affine in q
    if (middle.z() < kNearest_m || std::abs(plane.d) < kNearest_m) continue;
    // -n . ray / d, ray = (x / fx, y / fy, 1) with x, y from the principal point.
    InversePlane inverse;
    inverse.du = -plane.normal.x() / (plane.d * camera.fx);
    inverse.dv = -plane.normal.y() / (plane.d * camera.fy);
    inverse.base = -plane.normal.z() / plane.d + inverse.du * (0.5 * b.grid.width - camera.cx) +
                   inverse.dv * (0.5 * b.grid.height - camera.cy);
    const double u = camera.fx * middle.x() / middle.z() + camera.cx;
    const double v = camera.fy * middle.y() / middle.z() + camera.cy;
    if (!(u >= 0.0 && u < b.grid.width && v >= 0.0 && v < b.grid.height)) continue;
    b.expected.push_back({inverse, u - 0.5 * b.grid.width, v - 0.5 * b.grid.height});
  }
}

template <class Raw>
Status find(const DepthView& depth, const Camera& camera, const SegmentOptions& options, const AxisLimits* limits,
            const SensorModel& sensor, Buffers& b, StageClock& clock, Segmentation& result) {
  const DepthRows<Raw> rows(depth, camera, limits);
  std::optional<ImageRows<Raw>> rows_of_cells;
  const auto measure = [&](const Sampling& sampling) {
    b.grid.sampling = sampling;
    rows_of_cells.emplace(rows, sampling.side(), sampling.merged, options.threads, b.image);
    result.sampled_points =
        measure_cells(*rows_of_cells, depth, camera, sensor, options.sensor, options.threads, b.grid_buffers, b.grid);
  };
  const Sampling usual = sampling_of(camera);
  measure(usual);
  if (const auto finer = finer_sampling(b.grid.noise, usual)) {
    measure(*finer);
    if (b.grid.noise.shown > kMostShown) measure(usual);
  }
  const ImageRows<Raw>& image = *rows_of_cells;
  result.valid_points = limits == nullptr ? result.sampled_points : 0;
  for (int v = 0; limits != nullptr && v < rows.height(); ++v) {
    result.valid_points += rows.count(rows.row(v, b.image.work.front()).measured);
  }
  if (Status status = require_points(result.valid_points, kMeasured); !status) return status;
  if (Status status = require_points(result.sampled_points, kWithinLimits); !status) return status;
  const Noise& noise = b.grid.noise;
  result.noise = noise.pixel;
  result.slow_noise = {noise.slow * noise.pixel.constant_m, noise.slow * noise.pixel.linear,
                       noise.slow * noise.pixel.quadratic_per_m};
  result.bias_m = noise.bias_m;
  clock.end(Stage::cells);
  expect(b);
  grow_regions(b.grid, b.expected, options.threads, b.region_buffers, b.judge.front(), b.regions);
  clock.end(Stage::regions);
  merge_regions(b.grid, b.merge, b.regions);
  reassign_borders(b.grid, options.threads, b.reassign, b.regions);
  judge_regions(b.grid, options.cells.min_confidence, options.threads, b.reassign, b.judge, b.regions);
  clock.end(Stage::merge);
  number_regions(b.grid, options, b, result);
  label_pixels(image, depth, camera, b.grid, b.regions, b.labels, options.threads, b.pixels, result.labels.data());
  measure_planes(b, result);
  arrange(options, result);
  if (limits != nullptr) mark_excluded(rows, b.image.work.front(), result);
  set_up(options, result);
  if (options.cells.residuals) measure_residuals(depth, camera, result);
  clock.end(Stage::labels);
  return {};
}

}  // namespace

Status find_planes(const DepthView& depth, const Camera& camera, const SegmentOptions& options, const AxisLimits* limits,
                   Buffers& buffers, StageClock& clock, Segmentation& result) {
  // Metres in floats are rounded to nothing that matters.
  const double step = depth.format() == DepthFormat::uint16 ? static_cast<double>(depth.metres_per_unit()) : 0.0;
  const Result<SensorModel> sensor = sensor_model(options.sensor, camera, step);
  if (!sensor) return sensor.error();
  return with_raw_type(depth.format(), [&](auto raw) {
    return find<decltype(raw)>(depth, camera, options, limits, sensor.value(), buffers, clock, result);
  });
}

}  // namespace fransac::cells
