// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <cmath>
#include <limits>

#include "../obstacle_output.hpp"
#include "writers.hpp"

namespace fransac::cli {
namespace {

/// Extent and spacing of a cloud, metres: what tells a user that the threshold or the unit is wrong.
struct CloudScale {
  double extent_m = 0.0;   ///< Diagonal of the bounding box.
  double spacing_m = 0.0;  ///< Median distance to the nearest other point, over some points.
};

CloudScale scale_of(const PointCloud& cloud) {
  constexpr std::size_t kProbes = 101;
  std::vector<std::size_t> finite;
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    if (cloud.finite(i)) finite.push_back(i);
  }
  if (finite.size() < 2) return {};
  Eigen::Vector3d low = cloud.local(finite[0]);
  Eigen::Vector3d high = low;
  for (const std::size_t i : finite) {
    low = low.cwiseMin(cloud.local(i));
    high = high.cwiseMax(cloud.local(i));
  }
  std::vector<double> nearest;
  for (std::size_t probe = 0; probe < kProbes; ++probe) {
    const std::size_t i = finite[probe * finite.size() / kProbes];
    double best = std::numeric_limits<double>::infinity();
    for (const std::size_t j : finite) {
      if (j != i) best = std::min(best, (cloud.local(i) - cloud.local(j)).squaredNorm());
    }
    nearest.push_back(std::sqrt(best));
  }
  std::nth_element(nearest.begin(), nearest.begin() + kProbes / 2, nearest.end());
  return {(high - low).norm(), nearest[kProbes / 2]};
}

/// The options by which the user left planes out.
std::string chosen_limits(const CellsOptions& cells) {
  std::vector<std::string> names;
  if (cells.parallel_to) names.emplace_back("--parallel-to");
  if (cells.perpendicular_to) names.emplace_back("--perpendicular-to");
  if (cells.min_area_m2 > 0.0) names.emplace_back("--min-area");
  if (cells.min_confidence > CellsOptions{}.min_confidence) names.emplace_back("--min-confidence");
  return joined(names, " and ");
}

/// Why there may be no plane and what to try.
void explain_no_planes(const SegmentOptions& options, const SegmentResult& result) {
  const Segmentation& segmentation = result.segmentation;
  const double min_support = *with_defaults(options, segmentation.method).min_support;
  const bool cells = segmentation.method == Method::cells;  // it knows no threshold
  const std::string threshold = cells ? "" : fmt::format("a larger --threshold (now {:g} m) or ", options.ransac.threshold_m);
  log(fmt::format(
      "{}: no plane has the minimum support of {:g} % of the {} sampled points; try {}a smaller --min-support (now {:g})",
      result.name, 100.0 * min_support, segmentation.sampled_points, threshold, min_support));
  const std::string limits = chosen_limits(options.cells);
  if (!limits.empty()) log(fmt::format("{}: {} may have left planes out", result.name, limits));
  const PointCloud* const cloud = result.cloud();
  if (cloud == nullptr || cells) return;
  const CloudScale scale = scale_of(*cloud);
  if (scale.spacing_m <= options.ransac.threshold_m) return;
  log(fmt::format(
      "{}: its points are typically {:.4g} m apart (extent {:.4g} m), more than the threshold: if its unit is not metres, say so "
      "with --unit; if it is this coarse, choose --threshold and --leaf-size to match",
      result.name, scale.spacing_m, scale.extent_m));
}

}  // namespace

void explain(const SegmentRequest& request, const SegmentResult& result) {
  if (result.segmentation.planes.empty()) explain_no_planes(request.options, result);
  if (!result.obstacles) return;
  const std::string warning = support_warning(request.obstacles.options.support, result.segmentation, *result.obstacles);
  if (!warning.empty()) log(fmt::format("{}: {}", result.name, warning));
}

}  // namespace fransac::cli
