// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <limits>
#include <new>
#include <numeric>
#include <optional>
#include <string>

#include "core/caught.hpp"
#include "fransac/obstacles/obstacles.hpp"
#include "obstacles/clusters.hpp"
#include "obstacles/floor_error.hpp"
#include "obstacles/footprint.hpp"
#include "obstacles/support.hpp"

namespace fransac {
namespace {

/// The square root of the area that a point stands for on the planes; nothing where no plane has an area.
std::optional<double> spacing_on_planes(const Segmentation& segmentation) {
  double area_m2 = 0.0;
  double points = 0.0;
  for (const PlaneSegment& plane : segmentation.planes) {
    area_m2 += plane.area_m2;
    points += plane.area_m2 > 0.0 ? static_cast<double>(plane.inliers) : 0.0;
  }
  if (!(area_m2 > 0.0) || !std::isfinite(area_m2) || points == 0.0) return std::nullopt;
  return std::sqrt(area_m2 / points);
}

/// The plane with its normal up where that is known; else the sensor is above it, or the origin.
Plane upright(const Plane& plane, const std::optional<Eigen::Vector3d>& up, const std::optional<Eigen::Vector3d>& sensor) {
  const bool upside_down = up ? up->dot(plane.normal) < 0.0 : sensor && plane.signed_distance(*sensor) < 0.0;
  return upside_down ? Plane{-plane.normal, -plane.d} : plane;
}

/// Finds the points above the support, groups them, and describes the groups.
class CloudFinder {
 public:
  CloudFinder(const PointCloud& cloud, const Segmentation& segmentation, const ObstacleOptions& options, const AxisLimits* limits,
              Obstacles& result)
      : cloud_(cloud),
        segmentation_(segmentation),
        options_(options),
        r_(result),
        spacing_on_planes_(spacing_on_planes(segmentation)) {
    if (limits != nullptr) limits_.emplace(*limits, cloud.origin[static_cast<Eigen::Index>(limits->axis)]);
    if (limits != nullptr) limited_ = std::array{cloud.x(), cloud.y(), cloud.z()}[static_cast<std::size_t>(limits->axis)];
    for (const int label : r_.support) carries_[at(label)] = true;
    sensor_ = segmentation.sensor_position.value_or(Eigen::Vector3d::Zero());
    set_ground();
    local_d_ = r_.support_plane.normal.dot(cloud.origin) + r_.support_plane.d;
  }

  Status run() {
    collect();
    if (points_.empty()) return {};
    measure_spacing();
    const double distance_m = options_.cluster_distance_m > 0.0 ? options_.cluster_distance_m : default_distance();
    Result<obstacles::Clusters> clusters = obstacles::find_clusters(points_, distance_m);
    if (!clusters) return clusters.error();
    choose(*clusters);
    describe(*clusters, distance_m);
    return {};
  }

 private:
  void set_ground() {
    r_.support_plane = r_.support.empty() ? plane_below_all()
                                          : upright(segmentation_.planes[at(r_.support.front() - 1)].plane, segmentation_.up,
                                                    segmentation_.sensor_position);
    r_.ground = ground_frame(r_.support_plane, sensor_);
  }

  /// The plane through the lowest point, at right angles to up.
  [[nodiscard]] Plane plane_below_all() const {
    // Where up is unknown: y of a camera's frame is down, z of others mostly up (ROS, REP 103).
    const bool of_camera = segmentation_.method == Method::cells;
    const Eigen::Vector3d usual =
        of_camera ? Eigen::Vector3d(-Eigen::Vector3d::UnitY()) : Eigen::Vector3d(Eigen::Vector3d::UnitZ());
    const Eigen::Vector3d up = segmentation_.up.value_or(usual);
    double lowest = std::numeric_limits<double>::infinity();
    for (std::size_t i = 0; i < cloud_.size(); ++i) {
      if (can_be_above(i)) lowest = std::min(lowest, up.dot(cloud_.point(i)));
    }
    return {up, std::isfinite(lowest) ? -lowest : 0.0};
  }

  /// Whether a point is measured, within the limits, and not on the support.
  [[nodiscard]] bool can_be_above(std::size_t i) const {
    const std::uint8_t label = segmentation_.labels[i];
    if (label == kLabelNoDepth || carries_[label] || !cloud_.measured(i)) return false;
    return !limits_ || limits_->keeps(limited_[i]);
  }

  /// Heights at which points leave the support.
  struct Limit {
    const DepthNoise& noise;
    const Eigen::Vector3d& up;
    double sigmas;
    double least;

    /// A depth camera's noise errs along the ray.
    [[nodiscard]] double at(const Eigen::Vector3d& p) const {
      const double slant = p.z() > 0.0 ? std::abs(up.dot(p)) / p.z() : 0.0;
      return std::max(least, sigmas * noise.sigma_m(std::max(p.z(), 0.0)) * slant);
    }
  };

  [[nodiscard]] double height(std::size_t i) const { return r_.support_plane.normal.dot(cloud_.local(i)) + local_d_; }

  /// Without a model of the noise, what the segmentation took for noise: the farthest of the support's own points.
  [[nodiscard]] double least_height() const {
    double least = options_.least_height_m;
    if (segmentation_.noise != DepthNoise{}) return least;
    for (std::size_t i = 0; i < cloud_.size(); ++i) {
      if (segmentation_.labels[i] != r_.support.front() || !cloud_.measured(i)) continue;
      least = std::max(least, std::abs(height(i)));
    }
    return least;
  }

  /// A stray point farther away would be all that clusters can be counted by.
  [[nodiscard]] bool within_reach(std::size_t i) const {
    constexpr double kMostSpacings = 0x1p26;
    return !spacing_on_planes_ || cloud_.local(i).cwiseAbs().maxCoeff() <= kMostSpacings * *spacing_on_planes_;
  }

  void collect() {
    const bool none = r_.support.empty();  // all is above
    const Limit limit{segmentation_.noise, r_.support_plane.normal, options_.height_sigmas, none ? 0.0 : least_height()};
    for (std::size_t i = 0; i < cloud_.size(); ++i) {
      if (!can_be_above(i)) continue;
      const double above = height(i);
      const double noise = limit.at(cloud_.point(i));
      if (!(none || above > noise) || !within_reach(i)) continue;
      points_.emplace_back(cloud_.x()[i], cloud_.y()[i], cloud_.z()[i]);
      index_.push_back(i);
      over_.push_back(above - noise);
    }
  }

  /// Without areas of planes, as if the points covered a square as large as they reach.
  void measure_spacing() {
    Eigen::Vector3d low = points_.front().cast<double>();
    Eigen::Vector3d high = low;
    for (const Eigen::Vector3f& point : points_) {
      low = low.cwiseMin(point.cast<double>());
      high = high.cwiseMax(point.cast<double>());
    }
    extent_ = (high - low).maxCoeff();
    spacing_ = spacing_on_planes_.value_or(extent_ / std::sqrt(static_cast<double>(points_.size())));
  }

  [[nodiscard]] double default_distance() const {
    constexpr double kSpacings = 4.0;        // points of a surface at 75 degrees to the ray are so many times as far apart
    constexpr double kLeastShare = 0x1p-28;  // of the extent: so that find_clusters can count
    return std::max({kSpacings * spacing_, kLeastShare * extent_, std::numeric_limits<double>::min()});
  }

  /// How many points make an obstacle.
  [[nodiscard]] double fewest() const {
    constexpr double kFewest = 3.0;  // as for cells of images
    const double side = spacing_ > 0.0 ? options_.min_size_m / spacing_ : 0.0;
    return std::max(kFewest, side * side);
  }

  /// How many points of each cluster are seen at a grazing angle and are no higher than floor may seem to be.
  [[nodiscard]] std::vector<std::uint32_t> points_like_floor(const obstacles::Clusters& clusters) const {
    std::vector<std::uint32_t> count(clusters.count, 0);
    if (r_.support.empty()) return count;
    const PlaneSegment& support = segmentation_.planes[at(r_.support.front() - 1)];
    const obstacles::FloorError error(segmentation_, support, segmentation_.noise, options_.height_sigmas);
    for (std::size_t k = 0; k < points_.size(); ++k) {
      const Eigen::Vector3d point = cloud_.point(index_[k]);
      if (error.is_grazing(point) && height(index_[k]) <= error.most_m(point)) ++count[clusters.of_point[k]];
    }
    return count;
  }

  /// Which clusters are obstacles, and their order.
  void choose(const obstacles::Clusters& clusters) {
    std::vector<std::uint32_t> count(clusters.count, 0);
    std::vector<double> nearest(clusters.count, std::numeric_limits<double>::infinity());
    for (std::size_t k = 0; k < points_.size(); ++k) {
      const std::uint32_t cluster = clusters.of_point[k];
      ++count[cluster];
      nearest[cluster] = std::min(nearest[cluster], (cloud_.point(index_[k]) - sensor_).norm());
    }
    std::vector<std::uint32_t> order(clusters.count);
    std::iota(order.begin(), order.end(), 0U);
    const double least = fewest();
    const std::vector<std::uint32_t> like_floor = points_like_floor(clusters);
    // As for images: rims of what stands on the floor are as low as it.
    constexpr double kMostOfCluster = 0.75;
    std::erase_if(order, [&](std::uint32_t cluster) {
      return count[cluster] < least || like_floor[cluster] >= kMostOfCluster * count[cluster];
    });
    std::stable_sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) { return nearest[a] < nearest[b]; });
    order.resize(std::min(order.size(), at(obstacles::kMostObjects)));
    id_of_.assign(clusters.count, 0);
    r_.obstacles.resize(order.size());
    for (std::size_t i = 0; i < order.size(); ++i) {
      id_of_[order[i]] = static_cast<std::uint16_t>(i + 1);
      r_.obstacles[i].id = static_cast<int>(i + 1);
      r_.obstacles[i].nearest_m = nearest[order[i]];
      r_.obstacles[i].min_height_m = std::numeric_limits<double>::infinity();
      r_.obstacles[i].max_height_m = -std::numeric_limits<double>::infinity();
    }
  }

  void describe(const obstacles::Clusters& clusters, double distance_m) {
    const std::size_t planes = segmentation_.planes.size();
    std::vector<std::uint32_t> on_plane(r_.obstacles.size() * (planes + 1), 0);
    std::vector<obstacles::Footprint> footprints(r_.obstacles.size());
    for (std::size_t k = 0; k < points_.size(); ++k) {
      const std::uint16_t id = id_of_[clusters.of_point[k]];
      if (id == 0) continue;
      r_.labels[index_[k]] = id;
      Obstacle& obstacle = r_.obstacles[id - std::size_t{1}];
      const Eigen::Vector3d point = r_.ground.from_camera(cloud_.point(index_[k]));
      ++obstacle.pixels;
      obstacle.centroid += cloud_.local(index_[k]);
      obstacle.min_height_m = std::min(obstacle.min_height_m, point.z());
      obstacle.max_height_m = std::max(obstacle.max_height_m, point.z());
      obstacle.contact = obstacle.contact || (!r_.support.empty() && over_[k] <= distance_m);
      footprints[id - std::size_t{1}].add(point.head<2>());
      const std::uint8_t plane = segmentation_.labels[index_[k]];
      ++on_plane[(id - std::size_t{1}) * (planes + 1) + (plane <= planes ? plane : 0)];
    }
    for (std::size_t i = 0; i < r_.obstacles.size(); ++i) {
      Obstacle& obstacle = r_.obstacles[i];
      obstacle.centroid = obstacle.centroid / static_cast<double>(obstacle.pixels) + cloud_.origin;
      obstacles::set_box(footprints[i], obstacle);
      obstacles::name_planes(&on_plane[i * (planes + 1)], segmentation_, obstacle);
    }
  }

  const PointCloud& cloud_;
  const Segmentation& segmentation_;
  const ObstacleOptions& options_;
  Obstacles& r_;
  std::optional<double> spacing_on_planes_;
  std::optional<LocalLimits> limits_;
  const float* limited_ = nullptr;
  std::array<bool, 256> carries_{};  ///< By label.
  Eigen::Vector3d sensor_;           ///< Where distances are measured from.
  double local_d_ = 0.0;             ///< Of the support, in the cloud's local coordinates.
  // What is above: local coordinates, index in the cloud, height above what may be noise.
  std::vector<Eigen::Vector3f> points_;
  std::vector<std::size_t> index_;
  std::vector<double> over_;
  double extent_ = 0.0;
  double spacing_ = 0.0;
  std::vector<std::uint16_t> id_of_;  ///< By cluster; 0: too small.
};

}  // namespace

Result<Obstacles> find_obstacles(const PointCloud& cloud, const Segmentation& segmentation, const ObstacleOptions& options,
                                 const AxisLimits* limits) try {
  const auto start = std::chrono::steady_clock::now();
  if (Status status = validate(options); !status) return status.error();
  if (Status status = validate(cloud); !status) return status.error();
  if (segmentation.sensor_position) {
    if (Status status = validate_position(*segmentation.sensor_position, "segmentation: sensor position"); !status) {
      return status.error();
    }
  }
  if (segmentation.labels.size() != cloud.size()) {
    return Error{ErrorCode::invalid_argument, "the segmentation's size is not the cloud's"};
  }
  Obstacles result;
  result.width = segmentation.width;
  result.height = segmentation.height;
  result.labels.assign(cloud.size(), 0);
  obstacles::choose_support(segmentation, options, segmentation.noise, result);
  if (Status status = CloudFinder(cloud, segmentation, options, limits, result).run(); !status) return status.error();
  result.total_ms = std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
  return result;
} catch (const std::exception& exception) {
  return caught(exception, [&] { return "obstacles of " + std::to_string(cloud.size()) + " points"; });
}

}  // namespace fransac
