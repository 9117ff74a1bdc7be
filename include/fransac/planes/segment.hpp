// SPDX-License-Identifier: Apache-2.0
/// Planes of a depth image or a point cloud.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "fransac/core/camera.hpp"
#include "fransac/core/depth_image.hpp"
#include "fransac/core/plane.hpp"
#include "fransac/core/point_cloud.hpp"
#include "fransac/core/result.hpp"
#include "fransac/core/sensor.hpp"
#include "fransac/planes/options.hpp"
#include "fransac/planes/orientation.hpp"
#include "fransac/sac/stopping.hpp"

namespace fransac {

template <>
struct EnumNames<PlaneKind> {
  static constexpr std::string_view values[] = {"unknown", "floor", "ceiling", "wall", "horizontal", "other"};
};
template <>
struct EnumNames<UpSource> {
  static constexpr std::string_view values[] = {"none", "given", "estimated"};
};

/// What `cells` saw of a plane when it judged it: what PlaneSegment::confidence follows from. Zero for other methods.
struct PlaneEvidence {
  double share = 0.0;           ///< Of the pixels of all cells with enough measurements.
  double turn_rad = 0.0;        ///< By how much the surface's normal turns from end to end, with or without its border, which
                                ///< is blurred: the lesser, radians.
  double turn_sigma_rad = 0.0;  ///< One sigma of that, border included, radians.
  double smooth_border = 0.0;   ///< Share of the border beyond which the surface goes on smoothly, 0 to 1.
};

/// One plane of a segmentation, with its evidence.
struct PlaneSegment {
  int id = 0;                    ///< Its label, from 1.
  Plane plane;                   ///< In the input's coordinates (depth images: the camera's optical frame), metres.
  std::uint64_t inliers = 0;     ///< Pixels or points with this label.
  std::uint64_t support = 0;     ///< Searched points (leaves, for the voxel methods) within the threshold when it was found.
  std::uint64_t iterations = 0;  ///< Hypotheses of the search that found it.
  StopReason stop_reason = StopReason::max_iterations;  ///< Why that search ended.
  double rms_m = 0.0;                                  ///< Root mean square distance of the labelled points to the plane, metres.
  Eigen::Vector3d centroid = Eigen::Vector3d::Zero();  ///< Of the labelled points, metres (`cells`, clouds; else zero).
  /// Of (normal, d), rank 3 (`cells`; else zero). Unaligned, so that programs built for other instruction sets agree on the
  /// layout.
  Eigen::Matrix<double, 4, 4, Eigen::DontAlign> covariance = Eigen::Matrix4d::Zero();
  PlaneKind kind = PlaneKind::unknown;  ///< Floor, wall …; `unknown` where nothing tells what is up.
  double confidence = 1.0;   ///< Probability that this is a plane of the scene, 0 to 1; calibrated on frames that its weights did
                             ///< not see. Methods other than `cells` do not judge: 1.
  PlaneEvidence evidence{};  ///< What that follows from.
  double area_m2 = 0.0;  ///< Visible area. Depth images: sum of the pixels' footprints on the plane; clouds: occupied cells of a
                         ///< grid on the plane.
};

/// The stages of a segmentation, in the order of the paper's figure 2. Of a depth image no cloud is made (but for a
/// grid of very fine leaves): pixels are deprojected and passed through within the stage that reads them, the voxel grid or
/// else RANSAC. Of a cloud, `deproject` is the removal of points that are no measurements.
/// `cells`, `regions` and `merge` are those of the method `cells`.
enum class Stage { deproject, pass_through, voxel_grid, ransac, cells, regions, merge, labels };
/// How many stages there are.
inline constexpr int kStages = 8;
template <>
struct EnumNames<Stage> {
  static constexpr std::string_view values[] = {"deproject", "pass_through", "voxel_grid", "ransac",
                                                "cells",     "regions",      "merge",      "labels"};
};

/// Where the time of a call went, milliseconds.
struct Timing {
  std::array<double, kStages> stage_ms{};  ///< 0 where a method has no such stage.
  double total_ms = 0.0;                   ///< Of the whole call.
};

/// What segment() found.
struct Segmentation {
  Method method = Method::fransac;    ///< The method that ran; never `automatic`.
  int width = 0;                      ///< Of the label image; unorganised clouds: the number of points.
  int height = 0;                     ///< 1 for unorganised clouds.
  std::vector<std::uint8_t> labels;   ///< One per pixel or point, row by row; see core/labels.hpp.
  std::vector<float> residuals_m;     ///< On request: distance of each pixel to its label's plane, positive on the camera's side;
                                      ///< NaN where there is none. Else empty.
  std::optional<Eigen::Vector3d> up;  ///< Unit vector in the input's coordinates.
  UpSource up_source = UpSource::none;  ///< Who says so.
  double up_sigma_rad = 0.0;            ///< One sigma of the estimate's angle, radians; 0 where up is given.
  /// Where the sensor was, in the input's coordinates, metres: given, a cloud's own, or the camera's place in a depth image.
  /// Unset: unknown.
  std::optional<Eigen::Vector3d> sensor_position;
  // The errors that `cells` worked with, the sensor's or estimated (SensorModel); zero for the other methods.
  DepthNoise noise;       ///< Pixel noise: one sigma of what is independent from pixel to pixel.
  DepthNoise slow_noise;  ///< Slow noise: one sigma of what pixels near each other share, over tens of pixels.
  double bias_m = 0.0;    ///< Bias: by how much a plane may be bent or shifted, the same in every frame, metres.
  Distortion distortion;  ///< By which the depth image was corrected; what else looks at that image with this segmentation
                          ///< corrects it likewise.
  int saturated = 0;      ///< The raw value that was taken for no measurement, if the depth image held it; else 0.
  std::vector<PlaneSegment> planes;  ///< In the order asked for; planes[i].id == i + 1.

  std::uint64_t valid_points = 0;                       ///< Measured pixels or points of the input.
  std::uint64_t sampled_points = 0;                     ///< Points that were searched: after pass-through and voxel grid.
  std::uint64_t iterations = 0;                         ///< Hypotheses, over all planes.
  std::uint64_t rejected = 0;                           ///< Of them rejected by the pre-test.
  std::uint64_t degenerate = 0;                         ///< Degenerate samples thrown away.
  StopReason stop_reason = StopReason::max_iterations;  ///< Of the first plane's search.
  Timing timing;                                        ///< Of this call.
};

/// Buffers kept from one call to the next, so that a stream of depth frames need not allocate them anew. Not for concurrent use.
class Workspace {
 public:
  Workspace();  ///< Takes no memory for frames yet.
  ~Workspace();
  Workspace(Workspace&&) noexcept;
  Workspace& operator=(Workspace&&) noexcept;

  /// Planes that `cells` tries first from now on, at their centroids: the last frame's. They have to be seen as clearly as any
  /// other. Empty, the default: none. What is found depends on them a little.
  void expect(std::span<const PlaneSegment> planes);

  struct Impl;                     ///< The library's own.
  Impl& impl() { return *impl_; }  ///< The library's own.

 private:
  std::unique_ptr<Impl> impl_;
};

/// Finds planes in a depth image, corrected by the sensor's distortion if it has one. `camera` must have the image's size; the
/// view's depth scale counts, not the camera's. Errors: invalid_argument (options, camera, view), no_data (fewer than three
/// measured pixels, or none within the pass-through limits, or all points collinear), out_of_memory. A frame in which no plane
/// has `min_support` is no error: `planes` is empty.
Result<Segmentation> segment(const DepthView& depth, const Camera& camera, const SegmentOptions& options = {});
/// The same, reusing the memory of `workspace` and `segmentation`; after an error `segmentation` holds no planes.
Status segment(const DepthView& depth, const Camera& camera, const SegmentOptions& options, Workspace& workspace,
               Segmentation& segmentation);

/// Finds planes in a point cloud, organised or not. Points that are no measurements (not finite, or exactly (0, 0, 0); see
/// PointCloud::measured) get label 0. `cells` needs an organised cloud that a pinhole camera took (filter/organised.hpp) and
/// works on its depth image; for other clouds it is an error (unsupported), and `automatic` takes `fransac`.
Result<Segmentation> segment(const PointCloud& cloud, const SegmentOptions& options = {});
/// The same, reusing the memory of `workspace` and `segmentation`; after an error `segmentation` holds no planes.
Status segment(const PointCloud& cloud, const SegmentOptions& options, Workspace& workspace, Segmentation& segmentation);

/// The instruction set that runs on this machine, chosen at the first call: "AVX2", "SSE4", "NEON", "SCALAR" … The environment
/// variable FRANSAC_TARGET, read when the program starts, names another one that the machine has; any other name makes segment()
/// fail (unsupported).
std::string_view instruction_set();

}  // namespace fransac
