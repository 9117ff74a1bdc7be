// SPDX-License-Identifier: Apache-2.0
/// What stands on, hangs above or falls away from a plane that carries, in a segmented depth image or
/// point cloud.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cstdint>
#include <limits>
#include <memory>
#include <string_view>
#include <vector>

#include "fransac/core/camera.hpp"
#include "fransac/core/depth_image.hpp"
#include "fransac/core/labels.hpp"
#include "fransac/core/plane.hpp"
#include "fransac/core/point_cloud.hpp"
#include "fransac/core/result.hpp"
#include "fransac/planes/options.hpp"
#include "fransac/planes/outline.hpp"
#include "fransac/planes/segment.hpp"

namespace fransac {

/// Which plane carries.
enum class SupportKind {
  automatic,  ///< The floor where one is known, else the first plane.
  floor,      ///< The largest plane of kind floor.
  table,      ///< The largest plane of kind horizontal: a table top, a shelf.
  plane,      ///< The one with a given label.
};
template <>
struct EnumNames<SupportKind> {
  static constexpr std::string_view values[] = {"auto", "floor", "table", "plane"};
};

/// Which plane carries, and its label where one is named.
struct SupportChoice {
  SupportKind kind = SupportKind::automatic;  ///< Which one.
  int plane = 0;                              ///< Its label, with `plane`.

  bool operator==(const SupportChoice&) const = default;
};

/// Lengths are about the world, not the sensor; the sensor's noise comes from the segmentation.
struct ObstacleOptions {
  SupportChoice support{};  ///< The plane that obstacles are above or below.
  /// Pixels above the support by more than this many sigmas of their height, and
  double height_sigmas = 4.0;
  /// by more than this are on obstacles: what floors and tables are uneven by. Slow noise and bias (Segmentation) count as well,
  /// where what they lift joins the support without a step or is seen at less than ten degrees.
  double least_height_m = 0.005;
  /// Pixels below it by more than the sigmas and this are in drops.
  double least_drop_m = 0.03;
  /// Smaller obstacles, measured by the square root of their visible area, are left out.
  double min_size_m = 0.01;
  /// Two things that touch are told apart when each shows this much of itself, measured likewise.
  double touching_size_m = 0.02;
  /// Clouds: points nearer to each other than this are of one obstacle. 0: four times the points' spacing, which is the square
  /// root of the area that a point stands for on the planes.
  double cluster_distance_m = 0.0;
};

/// Calls visit(info, value&) for every option but the support.
template <class Options, class Visitor>
void for_each_obstacle_option(Options& o, Visitor&& visit) {
  constexpr double kInf = std::numeric_limits<double>::infinity();
  visit(OptionInfo{"height-sigmas", "sigmas", "noise that is no obstacle, in standard deviations of a pixel's height", 0, 100,
                   true},
        o.height_sigmas);
  visit(OptionInfo{"least-height", "m", "height above the support that is no obstacle", 0, kInf, false, true}, o.least_height_m);
  visit(OptionInfo{"least-drop", "m", "depth below the support that is no drop", 0, kInf, false, true}, o.least_drop_m);
  visit(OptionInfo{"min-size", "m", "smallest obstacle, as the square root of its visible area", 0, kInf, false, true},
        o.min_size_m);
  visit(OptionInfo{"touching-size", "m", "smallest obstacle that is told from another that it touches, likewise", 0, kInf, false,
                   true},
        o.touching_size_m);
  visit(OptionInfo{"cluster-distance", "m",
                   "clouds: points nearer to each other than this are of one obstacle; 0: four times their spacing", 0, kInf,
                   false, true},
        o.cluster_distance_m);
}

/// Checks every range, and that the support's label can be one. The message names the option.
Status validate(const ObstacleOptions& options);

/// Coordinates on the support: the camera's foot is the origin, z up along the support's normal, x the camera's viewing direction
/// laid on the plane, y to the left.
struct GroundFrame {
  Eigen::Vector3d origin = Eigen::Vector3d::Zero();    ///< In the camera's frame, metres.
  Eigen::Matrix3d axes = Eigen::Matrix3d::Identity();  ///< Columns: x, y, z in the camera's frame.

  /// A point of the camera's frame on the ground, metres.
  [[nodiscard]] Eigen::Vector3d from_camera(const Eigen::Vector3d& point) const { return axes.transpose() * (point - origin); }
  /// A point of the ground in the camera's frame, metres.
  [[nodiscard]] Eigen::Vector3d to_camera(const Eigen::Vector3d& point) const { return axes * point + origin; }
};
/// The coordinates on a plane in the camera's frame.
GroundFrame ground_frame(const Plane& support);

/// A box that stands upright on the support: the one with the smallest footprint around what is seen.
struct UprightBox {
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();  ///< In the ground frame, metres.
  Eigen::Vector3d size = Eigen::Vector3d::Zero();    ///< Length >= width, height; metres.
  double yaw_rad = 0.0;                              ///< Of the length against the ground's x, in (-pi/2, pi/2].
};

/// What kind of obstacle it is.
enum class ObstacleKind {
  object,  ///< Anything with more than one side.
  plane,   ///< What is seen is one plane: a wall, a door, the front of a cabinet, a sheet of paper that hangs.
  drop,    ///< Falls away from the support: a hole, a step down, a kerb, what lies beyond a table's edge.
};
template <>
struct EnumNames<ObstacleKind> {
  static constexpr std::string_view values[] = {"object", "plane", "drop"};
};

/// One thing that stands on, hangs above or falls away from the support.
struct Obstacle {
  int id = 0;                                          ///< Its label, from 1.
  ObstacleKind kind = ObstacleKind::object;            ///< Object, plane or drop.
  std::uint64_t pixels = 0;                            ///< Pixels or points with its label.
  Eigen::Vector3d centroid = Eigen::Vector3d::Zero();  ///< Of its pixels' points, camera frame, metres.
  UprightBox box;                                      ///< Around what is seen of it.
  double min_height_m = 0.0;  ///< Above the support (negative: below) of the lowest of its cells of 4 x 4 pixels.
  double max_height_m = 0.0;  ///< Of the highest.
  double nearest_m = 0.0;     ///< Distance from the camera to the nearest of its cells.
  bool contact = false;       ///< Whether it is seen to come down to the support, to within noise and the least height.
  std::vector<int> planes;    ///< Labels of the planes that a tenth or more of its pixels are on, most pixels first.
};

/// What find_obstacles() found.
struct Obstacles {
  /// Labels of the planes that carry, the chosen first; with a floor, all planes of that kind that are no higher or lower than
  /// what is no obstacle and no drop. Empty: no such plane was found, and all else is empty, too.
  std::vector<int> support;
  GroundFrame ground;                 ///< Coordinates on the support.
  Plane support_plane;                ///< The chosen one, in the camera's frame.
  int width = 0;                      ///< Of the label image; unorganised clouds: the number of points.
  int height = 0;                     ///< 1 for unorganised clouds.
  std::vector<std::uint16_t> labels;  ///< One per pixel: 0, or an obstacle's id.
  std::vector<Obstacle> obstacles;    ///< Nearest first; obstacles[i].id == i + 1.
  double total_ms = 0.0;              ///< Time of the call.
};

/// Buffers kept from one call to the next. Not for concurrent use.
class ObstacleWorkspace {
 public:
  ObstacleWorkspace();  ///< Takes no memory for frames yet.
  ~ObstacleWorkspace();
  ObstacleWorkspace(ObstacleWorkspace&&) noexcept;
  ObstacleWorkspace& operator=(ObstacleWorkspace&&) noexcept;

  struct Impl;                     ///< The library's own.
  Impl& impl() { return *impl_; }  ///< The library's own.

 private:
  std::unique_ptr<Impl> impl_;
};

/// Finds obstacles in a depth image of which `segmentation` is the segmentation. `limits`: those it was made with, null without;
/// what is outside them is no obstacle. docs/algorithms.md, "Obstacles", derives the steps. Errors: invalid_argument (options,
/// sizes that differ). No support is no error.
Result<Obstacles> find_obstacles(const DepthView& depth, const Camera& camera, const Segmentation& segmentation,
                                 const ObstacleOptions& options = {}, const AxisLimits* limits = nullptr);
/// The same, reusing the memory of `workspace` and `obstacles`; after an error `obstacles` holds none.
Status find_obstacles(const DepthView& depth, const Camera& camera, const Segmentation& segmentation,
                      const ObstacleOptions& options, const AxisLimits* limits, ObstacleWorkspace& workspace,
                      Obstacles& obstacles);

/// The same for a point cloud, organised or not: points above the support are grouped by Euclidean clusters. `labels` is one per
/// point, `pixels` counts points, and an obstacle of min_size_m has as many points as a piece of plane of that size. What touches
/// is not told apart (touching_size_m means nothing), and nothing is known to be seen through the support: there are no drops.
/// Where the method that found the planes knows no noise, heights up to that of the farthest of the support's own points are
/// none. The origin of the coordinates counts as the camera: it is above the support (unless Segmentation::up says otherwise).
/// Errors: invalid_argument (options, sizes that differ, a cluster distance too small for the cloud's extent), out_of_memory.
Result<Obstacles> find_obstacles(const PointCloud& cloud, const Segmentation& segmentation, const ObstacleOptions& options = {},
                                 const AxisLimits* limits = nullptr);

/// Where drops are seen through the support: the i-th element is of the i-th obstacle, empty for other kinds, its points on the
/// support. The first kMaxPlanes drops only.
std::vector<std::vector<Outline>> drop_outlines(const Obstacles& obstacles, const Camera& camera,
                                                const OutlineOptions& options = {});

}  // namespace fransac
