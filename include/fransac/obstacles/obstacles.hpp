// SPDX-License-Identifier: Apache-2.0
/// What stands on, hangs above or falls away from a support plane, in a segmented depth image or point cloud.
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

/// Which plane is the support. All but `plane` are level planes that face up, to within 5 degrees and the errors of up and of the
/// plane; where up is not known there is none.
enum class SupportKind {
  automatic,  ///< The floor where one is known, else as `table`.
  floor,      ///< The largest plane of kind floor.
  table,      ///< What things stand on: of the planes at a table's height above a floor, else of all, the one with most area and
              ///< confidence, and of those with half as much the lowest.
  plane,      ///< The one with a given label.
};
template <>
struct EnumNames<SupportKind> {
  static constexpr std::string_view values[] = {"auto", "floor", "table", "plane"};
};

/// Why the support is what it is, or why there is none.
enum class SupportReason {
  named,           ///< The user named the plane.
  floor,           ///< The largest plane of kind floor.
  surface,         ///< The surface that things stand on, as SupportKind::table says.
  no_planes,       ///< None: no plane was found.
  no_such_plane,   ///< None: no plane has the label that was named.
  up_unknown,      ///< None: nothing tells what is up.
  no_floor,        ///< None: no plane is a floor that is level to within its error.
  no_level_plane,  ///< None: no plane faces up and is level to within its error.
};
template <>
struct EnumNames<SupportReason> {
  static constexpr std::string_view values[] = {"named",         "floor",      "surface",  "no_planes",
                                                "no_such_plane", "up_unknown", "no_floor", "no_level_plane"};
};

/// The reason in words: "the largest plane of the lowest level".
std::string_view reason_text(SupportReason reason);

/// What speaks against the support.
enum class SupportDoubt {
  none,             ///< Nothing.
  up_unknown,       ///< It was named, and nothing tells what is up.
  tilted,           ///< It is farther from level than a ramp of 1 : 12.
  up_uncertain,     ///< Up is estimated with more than 3 degrees of error, one sigma.
  something_lower,  ///< It stands for the floor, and something is seen that is lower.
};
template <>
struct EnumNames<SupportDoubt> {
  static constexpr std::string_view values[] = {"none", "up_unknown", "tilted", "up_uncertain", "something_lower"};
};

/// Which plane is the support, and its label where one is named.
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

/// Coordinates on the support: the foot of the camera, or of a cloud's sensor, is the origin, z up along the support's normal, x
/// the camera's viewing direction (z of the input's coordinates) laid on the plane, y to the left.
struct GroundFrame {
  Eigen::Vector3d origin = Eigen::Vector3d::Zero();    ///< In the camera's frame, metres.
  Eigen::Matrix3d axes = Eigen::Matrix3d::Identity();  ///< Columns: x, y, z in the camera's frame.

  /// A point of the camera's frame on the ground, metres.
  [[nodiscard]] Eigen::Vector3d from_camera(const Eigen::Vector3d& point) const { return axes.transpose() * (point - origin); }
  /// A point of the ground in the camera's frame, metres.
  [[nodiscard]] Eigen::Vector3d to_camera(const Eigen::Vector3d& point) const { return axes * point + origin; }
};
/// The coordinates on a plane, in the frame of the plane and of the sensor's position, metres.
GroundFrame ground_frame(const Plane& support, const Eigen::Vector3d& sensor = Eigen::Vector3d::Zero());

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
  /// Labels of the support's planes, the chosen first, with all planes of its kind that are no higher or lower than what is no
  /// obstacle and no drop. Empty: there is none, as support_reason says, and all that is seen is an obstacle.
  std::vector<int> support;
  SupportReason support_reason = SupportReason::no_planes;  ///< Why these, or none.
  SupportDoubt support_doubt = SupportDoubt::none;          ///< What speaks against them.
  GroundFrame ground;                                       ///< Coordinates on the support, or on support_plane without one.
  /// The chosen one, in the camera's frame. Without a support a plane below all that is seen, at right angles to up; where up is
  /// not known, either, as if the camera was level, or a cloud's z was up.
  Plane support_plane;
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
/// sizes that differ). No support is no error: everything is an obstacle then, and nothing a drop.
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
/// none. Segmentation::sensor_position counts as the camera, or the origin where that is not known: it is above the support
/// (unless Segmentation::up says otherwise), and distances are from there.
/// Errors: invalid_argument (options, cloud, the sensor's position, sizes that differ, a cluster distance too small for the
/// cloud's extent), out_of_memory.
Result<Obstacles> find_obstacles(const PointCloud& cloud, const Segmentation& segmentation, const ObstacleOptions& options = {},
                                 const AxisLimits* limits = nullptr);

/// Where drops are seen through the support: the i-th element is of the i-th obstacle, empty for other kinds, its points on the
/// support. The first kMaxPlanes drops only.
std::vector<std::vector<Outline>> drop_outlines(const Obstacles& obstacles, const Camera& camera,
                                                const OutlineOptions& options = {});

}  // namespace fransac
