// SPDX-License-Identifier: Apache-2.0
#include "obstacles/support.hpp"

#include <algorithm>

#include "obstacles/floor_error.hpp"

namespace fransac::obstacles {
namespace {

/// Whether a plane is on the support, to within what is no obstacle and no drop: a floor goes on behind things, but the top of a
/// low step is a floor, too, and carries nothing below it. Methods that know no centroid are believed.
/// Far off, where the ray grazes it, a floor is as bent as the sensor bends it.
bool is_on(const Plane& support, const PlaneSegment& plane, const FloorError& error, const ObstacleOptions& options) {
  const Eigen::Vector3d& point = plane.centroid;
  if (!(point.z() > 0.0)) return true;
  const double height = support.signed_distance(point);
  const double slack = error.is_grazing(point) ? error.most_m(point) : options.height_sigmas * error.pixel_m(point);
  return height <= std::max(slack, options.least_height_m) && -height <= std::max(slack, options.least_drop_m);
}

}  // namespace

Status as_segmented(const DepthView& depth, const Segmentation& segmentation, CorrectedDepth& buffer, DepthView& view) {
  view = depth;
  if (without_saturated(view, segmentation.saturated, buffer)) view = buffer.view;
  if (segmentation.distortion.empty()) return {};
  if (Status status = correct(view, segmentation.distortion, 0, buffer); !status) return status;
  view = buffer.view;
  return {};
}

Status check_sizes(const DepthView& depth, const Camera& camera, const Segmentation& segmentation) {
  if (Status status = validate(depth); !status) return status;
  if (Status status = validate(camera); !status) return status;
  if (camera.width != depth.width() || camera.height != depth.height()) {
    return Error{ErrorCode::invalid_argument, "the camera's size is not the depth image's"};
  }
  if (segmentation.width != depth.width() || segmentation.height != depth.height() ||
      segmentation.labels.size() != depth.size()) {
    return Error{ErrorCode::invalid_argument, "the segmentation's size is not the depth image's"};
  }
  return {};
}

void choose_support(const Segmentation& segmentation, const ObstacleOptions& options, const DepthNoise& noise,
                    std::vector<int>& support) {
  const SupportChoice& choice = options.support;
  support.clear();
  const auto take = [&](PlaneKind kind, bool all) {
    for (const PlaneSegment& plane : segmentation.planes) {
      if (plane.kind == kind && (all || support.empty())) support.push_back(plane.id);
    }
    std::stable_sort(support.begin(), support.end(), [&](int a, int b) {
      return segmentation.planes[at(a - 1)].area_m2 > segmentation.planes[at(b - 1)].area_m2;
    });
    if (support.empty()) return;
    const PlaneSegment& first = segmentation.planes[at(support.front() - 1)];
    const FloorError error(segmentation, first, noise, options.height_sigmas);
    support.erase(
        std::remove_if(support.begin() + 1, support.end(),
                       [&](int label) { return !is_on(first.plane, segmentation.planes[at(label - 1)], error, options); }),
        support.end());
  };
  switch (choice.kind) {
    case SupportKind::automatic:
      take(PlaneKind::floor, true);
      if (support.empty() && !segmentation.planes.empty()) support.push_back(segmentation.planes.front().id);
      break;
    case SupportKind::floor: take(PlaneKind::floor, true); break;
    case SupportKind::table: take(PlaneKind::horizontal, false); break;
    case SupportKind::plane:
      if (choice.plane <= static_cast<int>(segmentation.planes.size())) support.push_back(choice.plane);
      break;
  }
}

void name_planes(const std::uint32_t* on_plane, const Segmentation& segmentation, Obstacle& obstacle) {
  constexpr double kShare = 0.1;
  constexpr double kMost = 0.8;  // the rest are its edges
  const auto pixels = static_cast<double>(obstacle.pixels);
  obstacle.planes.clear();
  for (const PlaneSegment& plane : segmentation.planes) {
    if (on_plane[at(plane.id)] >= kShare * pixels) obstacle.planes.push_back(plane.id);
  }
  std::stable_sort(obstacle.planes.begin(), obstacle.planes.end(),
                   [&](int a, int b) { return on_plane[at(a)] > on_plane[at(b)]; });
  const bool is_plane = !obstacle.planes.empty() && on_plane[at(obstacle.planes.front())] >= kMost * pixels;
  obstacle.kind = is_plane ? ObstacleKind::plane : ObstacleKind::object;
}

void set_box(const Footprint& footprint, Obstacle& obstacle) {
  const Rectangle rectangle = footprint.rectangle();
  const double low = obstacle.min_height_m;
  const double high = obstacle.max_height_m;
  obstacle.box.centre << rectangle.centre, 0.5 * (low + high);
  obstacle.box.size << rectangle.length, rectangle.width, high - low;
  obstacle.box.yaw_rad = rectangle.yaw_rad;
}

}  // namespace fransac::obstacles
