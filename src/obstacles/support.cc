// SPDX-License-Identifier: Apache-2.0
#include "obstacles/support.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

#include "obstacles/floor_error.hpp"

namespace fransac::obstacles {
namespace {

/// Whether a plane is on the support, to within what is no obstacle and no drop: a floor goes on behind things, but the top of a
/// low step is a floor, too, and carries nothing below it. Methods that know no centroid are believed.
/// Far off, where the ray grazes it, a floor is as bent as the sensor bends it.
bool is_on(const Plane& support, const PlaneSegment& plane, const FloorError& error, const ObstacleOptions& options) {
  const Eigen::Vector3d& point = plane.centroid;
  if (!(point.z() > 0.0) || !error.is_known()) return true;
  const double height = support.signed_distance(point);
  const double slack = error.is_grazing(point) ? error.most_m(point) : options.height_sigmas * error.pixel_m(point);
  return height <= std::max(slack, options.least_height_m) && -height <= std::max(slack, options.least_drop_m);
}

/// How far from level a support may be, radians: a ramp, and the errors of up and of the plane where those are known.
double level_tolerance(const Segmentation& segmentation, const PlaneSegment& plane) {
  constexpr double kSigmas = 2.0;
  if (segmentation.up_source != UpSource::estimated) return kLevel_rad;
  return std::min(kLevel_rad, kRamp_rad + kSigmas * std::hypot(segmentation.up_sigma_rad, normal_sigma_rad(plane)));
}

/// Which planes obstacles stand on.
class SupportChooser {
 public:
  SupportChooser(const Segmentation& segmentation, const ObstacleOptions& options, const DepthNoise& noise, Obstacles& result)
      : s_(segmentation), options_(options), noise_(noise), r_(result), up_(up_of(segmentation)) {}

  void run() {
    r_.support_reason = SupportReason::no_planes;
    r_.support_doubt = SupportDoubt::none;
    if (options_.support.kind == SupportKind::plane) return take_named();
    if (s_.planes.empty()) return;
    r_.support_reason = SupportReason::up_unknown;
    if (!up_) return;
    const bool floor_only = options_.support.kind == SupportKind::floor;
    r_.support_reason = floor_only ? SupportReason::no_floor : SupportReason::no_level_plane;
    const PlaneSegment* const floor = largest_floor();
    if (floor != nullptr && options_.support.kind != SupportKind::table) return take(*floor, SupportReason::floor);
    if (floor_only) return;
    const PlaneSegment* const surface = find_surface(floor);
    if (surface != nullptr) take(*surface, SupportReason::surface);
  }

 private:
  /// Where kinds are known but up is not, by other means than segment(), a floor or a table tells.
  static std::optional<Eigen::Vector3d> up_of(const Segmentation& segmentation) {
    if (segmentation.up) return segmentation.up;
    for (const PlaneKind kind : {PlaneKind::floor, PlaneKind::horizontal}) {
      for (const PlaneSegment& plane : segmentation.planes) {
        if (plane.kind == kind) return plane.plane.normal;
      }
    }
    return std::nullopt;
  }

  /// Angle to level, radians.
  [[nodiscard]] double tilt(const PlaneSegment& plane) const {
    return std::acos(std::min(1.0, std::abs(plane.plane.normal.dot(*up_))));
  }
  [[nodiscard]] double height(const PlaneSegment& plane) const { return height_along(*up_, plane); }
  [[nodiscard]] static double evidence(const PlaneSegment& plane) { return plane.confidence * plane.area_m2; }

  /// Whether things can stand on it: level to within its error, and seen from above where it is known from where.
  [[nodiscard]] bool can_be_support(const PlaneSegment& plane) const {
    if (plane.kind != PlaneKind::floor && plane.kind != PlaneKind::horizontal) return false;
    if (tilt(plane) > level_tolerance(s_, plane)) return false;
    return !s_.sensor_position || plane.plane.signed_distance(*s_.sensor_position) * plane.plane.normal.dot(*up_) > 0.0;
  }

  [[nodiscard]] const PlaneSegment* largest_floor() const {
    const PlaneSegment* largest = nullptr;
    for (const PlaneSegment& plane : s_.planes) {
      if (plane.kind != PlaneKind::floor || !can_be_support(plane)) continue;
      if (largest == nullptr || plane.area_m2 > largest->area_m2) largest = &plane;
    }
    return largest;
  }

  /// The surface that things stand on; null: none. Tops of things on a table are lower above it than a table above the floor.
  [[nodiscard]] const PlaneSegment* find_surface(const PlaneSegment* floor) const {
    constexpr double kTable_m = 0.35;  // coffee tables are 0.4 m high
    constexpr double kShare = 0.1;     // of the floor's evidence: a table is no speck beside it
    const auto is_table = [&](const PlaneSegment& plane) {
      return height(plane) >= height(*floor) + kTable_m && evidence(plane) >= kShare * evidence(*floor);
    };
    const PlaneSegment* const table =
        floor == nullptr ? lowest_of_largest([](const PlaneSegment&) { return true; }) : lowest_of_largest(is_table);
    return table != nullptr ? table : floor;
  }

  /// The lowest of the planes with half as much evidence as the one with most, or more.
  template <class Filter>
  [[nodiscard]] const PlaneSegment* lowest_of_largest(const Filter& filter) const {
    constexpr double kAlike = 0.5;
    double most = 0.0;
    for (const PlaneSegment& plane : s_.planes) {
      if (can_be_support(plane) && filter(plane)) most = std::max(most, evidence(plane));
    }
    const PlaneSegment* lowest = nullptr;
    for (const PlaneSegment& plane : s_.planes) {
      if (!can_be_support(plane) || !filter(plane) || evidence(plane) < kAlike * most) continue;
      if (lowest == nullptr || height(plane) < height(*lowest)) lowest = &plane;
    }
    return lowest;
  }

  void take_named() {
    const int label = options_.support.plane;
    r_.support_reason = SupportReason::no_such_plane;
    if (label > static_cast<int>(s_.planes.size())) return;
    r_.support_reason = SupportReason::named;
    r_.support.push_back(label);
    r_.support_doubt = SupportDoubt::up_unknown;
    if (up_) doubt(s_.planes[at(label - 1)]);
  }

  /// The plane, and those of its kind that are on it, largest first.
  void take(const PlaneSegment& first, SupportReason reason) {
    r_.support_reason = reason;
    const FloorError error(s_, first, noise_, options_.height_sigmas);
    for (const PlaneSegment& plane : s_.planes) {
      if (plane.kind == first.kind && can_be_support(plane) && (&plane == &first || is_on(first.plane, plane, error, options_))) {
        r_.support.push_back(plane.id);
      }
    }
    // std::stable_sort would ask for memory.
    std::sort(r_.support.begin(), r_.support.end(), [&](int a, int b) {
      if (a == first.id || b == first.id) return a == first.id && b != first.id;
      const double area_a = s_.planes[at(a - 1)].area_m2;
      const double area_b = s_.planes[at(b - 1)].area_m2;
      return area_a != area_b ? area_a > area_b : a < b;
    });
    doubt(first);
    const bool instead_of_floor = options_.support.kind == SupportKind::automatic && reason == SupportReason::surface;
    if (r_.support_doubt == SupportDoubt::none && instead_of_floor) r_.support_doubt = SupportDoubt::something_lower;
  }

  void doubt(const PlaneSegment& plane) {
    constexpr double kUncertain_rad = 3.0 * std::numbers::pi / 180.0;
    r_.support_doubt = tilt(plane) > kRamp_rad            ? SupportDoubt::tilted
                       : s_.up_sigma_rad > kUncertain_rad ? SupportDoubt::up_uncertain
                                                          : SupportDoubt::none;
  }

  const Segmentation& s_;
  const ObstacleOptions& options_;
  const DepthNoise& noise_;
  Obstacles& r_;
  std::optional<Eigen::Vector3d> up_;
};

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
                    Obstacles& result) {
  result.support.clear();
  SupportChooser(segmentation, options, noise, result).run();
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

namespace fransac {

std::string_view reason_text(SupportReason reason) {
  switch (reason) {
    case SupportReason::named: return "named by its label";
    case SupportReason::floor: return "the largest plane of the lowest level";
    case SupportReason::surface: return "the surface that things stand on";
    case SupportReason::no_planes: return "no plane was found";
    case SupportReason::no_such_plane: return "no plane has this label";
    case SupportReason::up_unknown: return "nothing tells what is up";
    case SupportReason::no_floor: return "no plane is a floor and level to within its error";
    case SupportReason::no_level_plane: return "no plane faces up and is level to within its error";
  }
  return {};
}

}  // namespace fransac
