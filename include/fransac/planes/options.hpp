// SPDX-License-Identifier: Apache-2.0
/// Everything a user can choose about plane segmentation. Each default stands here and nowhere else: help texts, checks and
/// bindings read `for_each_option`.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <limits>
#include <optional>
#include <string_view>

#include "fransac/core/enum_names.hpp"
#include "fransac/core/labels.hpp"
#include "fransac/core/sensor.hpp"
#include "fransac/filter/pass_through.hpp"
#include "fransac/filter/voxel_grid.hpp"
#include "fransac/sac/plane_problem.hpp"

namespace fransac {

/// How planes are found. What the four that Zeineldin & El-Fishawy compare consist of stands in planes/methods.hpp.
enum class Method {
  automatic,     ///< `cells` for depth images and organised clouds of a pinhole camera, else `fransac`.
  cells,         ///< Every plane of a depth image from blocks of inverse depth.
  fransac,       ///< Pass-through, voxel grid, RANSAC with both stops.
  voxel_ransac,  ///< Voxel grid, RANSAC.
  rransac,       ///< RANSAC with the T(d,d) pre-test on the full cloud.
  ransac,        ///< RANSAC on the full cloud.
};

/// Where full-resolution labels come from.
enum class LabelsFrom {
  pixels,  ///< Every valid source pixel within the threshold of the final plane.
  leaves,  ///< The paper's way: every pixel whose voxel-grid leaf is an inlier. Without a voxel grid the same as pixels.
};

/// Which points take part.
struct PassThroughOptions {
  /// Unset: `fransac` on depth images (a cloud's axes mean nothing by themselves), and wherever limits are chosen: are not the
  /// defaults.
  std::optional<bool> use;
  AxisLimits limits;  ///< Of the points' coordinates.
};

/// The voxel grid of `fransac` and `voxel_ransac`.
struct VoxelGridOptions {
  double leaf_size_m = 0.02;                   ///< Zeineldin & El-Fishawy, section 4.
  LeafPoint leaf_point = LeafPoint::centroid;  ///< The point that stands for a leaf.
};

/// The search of the paper's four methods.
struct RansacPlaneOptions {
  double threshold_m = 0.01;                  ///< t of eq. (1). Zeineldin & El-Fishawy, section 4.
  double probability = 0.99;                  ///< p of eq. (2).
  int max_iterations = 1000;                  ///< The cap I.
  std::optional<int> pretest_points;          ///< d of T(d,d). Unset: 1 for `rransac` (Matas & Chum 2004), else 0.
  sac::Scoring scoring = sac::Scoring::msac;  ///< How hypotheses are compared.
  bool local_optimisation = true;             ///< Refit promising hypotheses to their inliers.
  bool refine = true;                         ///< Final least squares on the inliers.
};

/// Which plane is the first.
enum class PlaneOrder {
  area,     ///< Most visible square metres first.
  support,  ///< Most pixels, points or leaves first.
};

/// What `cells` needs to know besides the sensor.
struct CellsOptions {
  double min_area_m2 = 0.0;  ///< Planes with a smaller visible area are left out; their pixels are on no plane. All methods.
  /// Only planes whose normal is within `prior_angle_deg` of this direction (parallel planes).
  std::optional<Eigen::Vector3d> parallel_to;
  /// Only planes whose normal is perpendicular to this direction, to within `prior_angle_deg`.
  std::optional<Eigen::Vector3d> perpendicular_to;
  double prior_angle_deg = 10.0;  ///< By how much a normal may differ from these.
  double min_confidence = 0.55;   ///< Planes with less PlaneSegment::confidence are left out.
  bool residuals = false;         ///< Fill Segmentation::residuals_m.
};

/// All that a user can choose; for_each_option has names, units and ranges.
struct SegmentOptions {
  Method method = Method::automatic;  ///< How planes are found.
  std::optional<int> max_planes;      ///< 0: all, up to kMaxPlanes. Unset: see defaults_of.
  std::optional<double> min_support;  ///< Smallest support of a plane, as a share of the points that are sampled. Unset: see
                                      ///< defaults_of.
  std::optional<PlaneOrder> order;    ///< Unset: see defaults_of.
  LabelsFrom labels_from = LabelsFrom::pixels;  ///< Where full-resolution labels come from.
  std::uint64_t seed = 0;                       ///< Of all random samples; the same seed, the same answer.
  int threads = 1;                              ///< 0: all cores. Never changes the answer.
  /// Raw value of 16-bit depth that means no measurement, as 0 does: what cameras write for the sky. 0: there is none.
  int saturated = 65535;
  /// Up in the frame of the camera or of the sensor at the cloud's origin, of any length, as an IMU tells it: tells floors from
  /// walls. Unset: `cells` estimates it from the planes of a depth image, the others tell no kinds.
  std::optional<Eigen::Vector3d> up;
  /// Where the sensor was, in the input's coordinates, metres: floors are below it, ceilings above. Unset: the origin of a depth
  /// image and of a cloud that `cells` takes, else PointCloud::sensor_position. No coordinate is beyond kMaxCoordinate_m.
  std::optional<Eigen::Vector3d> sensor_position;
  PassThroughOptions pass_through;  ///< Which points take part.
  VoxelGridOptions voxel_grid;      ///< Of the methods that have one.
  RansacPlaneOptions ransac;        ///< Of all methods but `cells`.
  SensorOptions sensor;             ///< Of `cells`.
  CellsOptions cells;               ///< Of `cells`.
};

/// What SegmentOptions leaves to the method; the parts that a method consists of decide the rest (planes/methods.hpp).
struct MethodDefaults {
  int max_planes;      ///< 0: all.
  double min_support;  ///< Share of the sampled points.
  PlaneOrder order;    ///< Which plane is the first.
};

/// `automatic`: as `fransac`; ask for the method that runs (Segmentation::method).
constexpr MethodDefaults defaults_of(Method method) {
  constexpr double kCellsMinSupport = 0.002;  // some 600 pixels of 640 x 480: about nine cells of 8 x 8
  constexpr double kPaperMinSupport = 0.02;
  if (method == Method::cells) return {.max_planes = 0, .min_support = kCellsMinSupport, .order = PlaneOrder::area};
  return {.max_planes = 1, .min_support = kPaperMinSupport, .order = PlaneOrder::support};
}

/// The same with everything set that `method` decides by itself.
inline SegmentOptions with_defaults(SegmentOptions options, Method method) {
  const MethodDefaults defaults = defaults_of(method);
  options.max_planes = options.max_planes.value_or(defaults.max_planes);
  options.min_support = options.min_support.value_or(defaults.min_support);
  options.order = options.order.value_or(defaults.order);
  return options;
}

/// The methods that an option means something to.
enum class UsedBy {
  all,
  cells,
  ransac,      ///< The paper's four.
  voxel_grid,  ///< Those of them that have a voxel grid.
};

/// Whether an option that is used by `users` means something to `method`; to `automatic`, which becomes one of them, all do.
constexpr bool uses(Method method, UsedBy users) {
  if (method == Method::automatic) return true;
  const bool voxel_grid = method == Method::fransac || method == Method::voxel_ransac;
  switch (users) {
    case UsedBy::cells: return method == Method::cells;
    case UsedBy::ransac: return method != Method::cells;
    case UsedBy::voxel_grid: return voxel_grid;
    case UsedBy::all: break;
  }
  return true;
}

/// What a front end needs to know of one option. `Value` is double, int, std::uint64_t, bool, an enum, or a
/// std::optional of one of these or of a direction, Eigen::Vector3d (unset: the method decides).
struct OptionInfo {
  std::string_view name{};                                ///< As on the command line, without dashes; words joined by "-".
  std::string_view unit{};                                ///< "m", "points", … or empty.
  std::string_view help{};                                ///< One sentence without the default, which the value itself tells.
  double min = -std::numeric_limits<double>::infinity();  ///< Smallest valid number.
  double max = std::numeric_limits<double>::infinity();   ///< Largest valid number.
  bool open_min = false;                                  ///< Whether `min` itself is invalid.
  bool open_max = false;                                  ///< Whether `max` itself is invalid.
  std::string_view parameter_of{};                        ///< Not empty: written as "--parameter_of name=value".
  UsedBy used_by = UsedBy::all;                           ///< The methods that it means something to.
};

/// Whether an option of three numbers is a position, which may be 0, and no direction.
constexpr bool is_position(const OptionInfo& info) { return !info.unit.empty(); }

/// Calls visit(info, value&…) for every option of one or more sets; the one list of names, units, ranges and help texts.
template <class Visitor, class... Options>
void for_each_option_of(Visitor&& visit, Options&... o) {
  constexpr double kInf = std::numeric_limits<double>::infinity();
  constexpr double kIntMax = std::numeric_limits<int>::max();
  constexpr double kRawMax = std::numeric_limits<std::uint16_t>::max();
  visit(OptionInfo{"method", "", "how planes are found"}, o.method...);
  visit(OptionInfo{"planes", "planes", "how many planes to peel off, or 'all'", 0, kMaxPlanes}, o.max_planes...);
  visit(OptionInfo{"min-support", "share", "smallest support of a plane, as a share of the sampled points", 0, 1},
        o.min_support...);
  visit(OptionInfo{"order", "", "which plane comes first: most visible square metres, or most points"}, o.order...);
  visit(OptionInfo{"min-area", "m^2", "smallest visible area of a plane", 0, kInf, false, true}, o.cells.min_area_m2...);
  visit(OptionInfo{"seed", "", "seed of the random samples"}, o.seed...);
  visit(OptionInfo{"threads", "threads", "threads to use, 0 for all cores; never changes the answer", 0, 1024}, o.threads...);
  visit(OptionInfo{"saturated", "", "raw 16-bit value that means no measurement beside 0; 0: none", 0, kRawMax}, o.saturated...);
  visit(OptionInfo{"up", "", "up in the frame of the camera or cloud, which tells floors from walls; cells estimates it"},
        o.up...);
  visit(OptionInfo{"sensor-position", "m", "where the sensor was: floors are below it; of clouds else the PCD's VIEWPOINT"},
        o.sensor_position...);
  visit(OptionInfo{"pass-through", "", "keep only points within limits along an axis"}, o.pass_through.use...);
  visit(OptionInfo{"pass-through-axis", "", "the axis that the limits apply to"}, o.pass_through.limits.axis...);
  visit(OptionInfo{"pass-through-min", "m", "lower limit", -kInf, kInf, true, true}, o.pass_through.limits.min_m...);
  visit(OptionInfo{"pass-through-max", "m", "upper limit", -kInf, kInf, true, true}, o.pass_through.limits.max_m...);
  visit(OptionInfo{"pass-through-outside", "", "keep what lies outside the limits instead"}, o.pass_through.limits.outside...);

  const auto of_cells = [&visit](OptionInfo info, auto&... values) {
    info.used_by = UsedBy::cells;
    visit(info, values...);
  };
  of_cells(OptionInfo{"sensor", "",
                      "how depth was measured, which tells cells its noise; auto: estimated from the frame; or a sensor.json"},
           o.sensor.kind...);
  for_each_parameter_of(
      [&](const SensorParameter& p, auto&... values) {
        of_cells(
            OptionInfo{
                .name = p.name, .unit = p.unit, .help = p.help, .min = p.min, .max = p.max, .parameter_of = "sensor-param"},
            values...);
      },
      o.sensor...);
  of_cells(OptionInfo{"min-confidence", "", "planes less certain than this are left out", 0, 1}, o.cells.min_confidence...);
  of_cells(OptionInfo{"parallel-to", "", "only planes whose normal has this direction"}, o.cells.parallel_to...);
  of_cells(OptionInfo{"perpendicular-to", "", "only planes whose normal is perpendicular to this direction"},
           o.cells.perpendicular_to...);
  of_cells(
      OptionInfo{"prior-angle", "degrees", "by how much a normal may differ from parallel-to and perpendicular-to", 0, 90, true},
      o.cells.prior_angle_deg...);
  of_cells(OptionInfo{"residuals", "", "keep the distance of every pixel to its plane"}, o.cells.residuals...);

  const auto of_ransac = [&visit](OptionInfo info, auto&... values) {
    info.used_by = UsedBy::ransac;
    visit(info, values...);
  };
  of_ransac(OptionInfo{"threshold", "m", "largest distance of an inlier to its plane", 0, kInf, true, true},
            o.ransac.threshold_m...);
  of_ransac(OptionInfo{"probability", "", "confidence of having drawn a sample of inliers only", 0, 1, true, true},
            o.ransac.probability...);
  of_ransac(OptionInfo{"max-iterations", "hypotheses", "cap on the hypotheses per plane", 1, kIntMax},
            o.ransac.max_iterations...);
  of_ransac(OptionInfo{"pretest-points", "points", "d of the T(d,d) pre-test, 0 for none", 0, 100}, o.ransac.pretest_points...);
  of_ransac(OptionInfo{"scoring", "", "compare hypotheses by inlier count or truncated squared distance"}, o.ransac.scoring...);
  of_ransac(OptionInfo{"local-optimisation", "", "refit promising hypotheses to their inliers"}, o.ransac.local_optimisation...);
  of_ransac(OptionInfo{"refine", "", "least-squares fit of the final plane to its inliers"}, o.ransac.refine...);
  of_ransac(OptionInfo{"labels-from", "", "label every pixel near a plane, or the pixels whose leaf is an inlier (the paper)"},
            o.labels_from...);

  const auto of_voxel_grid = [&visit](OptionInfo info, auto&... values) {
    info.used_by = UsedBy::voxel_grid;
    visit(info, values...);
  };
  of_voxel_grid(OptionInfo{"leaf-size", "m", "edge of a voxel-grid leaf", 0, kInf, true, true}, o.voxel_grid.leaf_size_m...);
  of_voxel_grid(OptionInfo{"leaf-point", "", "the point that stands for a leaf"}, o.voxel_grid.leaf_point...);
}

/// Calls visit(info, value&) for every option.
template <class Options, class Visitor>
void for_each_option(Options& o, Visitor&& visit) {
  for_each_option_of(visit, o);
}

/// Whether an option means something to `method`: what a sensor.json says does to all, if it corrects depth.
bool uses(Method method, const OptionInfo& info, const SegmentOptions& options);

/// The options with the defaults of those that mean nothing to `method`: what several methods are given in common.
SegmentOptions used_by(const SegmentOptions& options, Method method);

template <>
struct EnumNames<Method> {
  static constexpr std::string_view values[] = {"auto", "cells", "fransac", "voxel-ransac", "rransac", "ransac"};
};
template <>
struct EnumNames<PlaneOrder> {
  static constexpr std::string_view values[] = {"area", "support"};
};
template <>
struct EnumNames<LabelsFrom> {
  static constexpr std::string_view values[] = {"pixels", "leaves"};
};
template <>
struct EnumNames<Axis> {
  static constexpr std::string_view values[] = {"x", "y", "z"};
};
template <>
struct EnumNames<LeafPoint> {
  static constexpr std::string_view values[] = {"centroid", "centre"};
};
template <>
struct EnumNames<sac::Scoring> {
  static constexpr std::string_view values[] = {"inliers", "msac"};
};

/// The limits of the pass-through that `method` (not `automatic`) runs behind with these options; null: none.
const AxisLimits* limits_of(const SegmentOptions& options, Method method, bool depth_image);

/// Checks every range, that the pass-through limits are in order, that the sensor's numbers mean something to its kind, and that
/// no option has another value than its default that means nothing to the method (`automatic` is checked when the input is
/// known). The message names the option.
Status validate(const SegmentOptions& options);

}  // namespace fransac
