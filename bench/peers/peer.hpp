// SPDX-License-Identifier: Apache-2.0
/// The one interface of everything that is timed. Plain C++ types only: rivals compiled for this machine's own instruction
/// set come from a module of their own, and no inline function of a library may be shared with it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace fransac::bench {

/// What every method is given where it has such a parameter: Zeineldin & El-Fishawy, section 4.
inline constexpr double kThreshold_m = 0.01;
inline constexpr double kLeafSize_m = 0.02;
inline constexpr double kProbability = 0.99;
inline constexpr int kMaxIterations = 1000;
inline constexpr int kSampleSize = 3;
inline constexpr double kNearest_m = 0.0;   ///< Pass-through along z.
inline constexpr double kFarthest_m = 4.5;  ///< Pass-through along z.

/// What a peer is given: a depth frame, or a point cloud (`depth` is null).
struct Frame {
  int width = 0;   ///< Of a cloud: the number of points.
  int height = 0;  ///< Of a cloud: 1.
  double fx = 0.0;
  double fy = 0.0;
  double cx = 0.0;
  double cy = 0.0;
  double depth_scale = 0.0;              ///< Raw units per metre.
  const std::uint16_t* depth = nullptr;  ///< Row by row, 0 is no measurement.
  const float* points = nullptr;         ///< x, y, z of each point, metres.
  double plane[4] = {};                  ///< One plane of the frame, for those that only label.

  [[nodiscard]] std::size_t size() const { return static_cast<std::size_t>(width) * static_cast<std::size_t>(height); }
};

/// What a peer found. `labels` belongs to the peer and is overwritten by its next run.
struct Answer {
  const std::uint8_t* labels = nullptr;    ///< One per pixel or point: 0 no depth, 1 the largest plane, 2 …, 255 on none.
  const std::uint16_t* objects = nullptr;  ///< One per pixel: 0, or what it is on, from 1. Like `labels`.
  double plane[4] = {};                    ///< The largest plane.
  int planes = 0;
  std::size_t inliers = 0;                                  ///< Pixels with label 1.
  std::size_t leaves = 0;                                   ///< Points left by a voxel grid.
  std::vector<std::pair<std::string_view, double>> stages;  ///< Milliseconds, where the library tells.
};

class Peer {
 public:
  Peer() = default;
  Peer(const Peer&) = delete;
  Peer& operator=(const Peer&) = delete;
  virtual ~Peer() = default;

  /// The peer's name in the roster.
  [[nodiscard]] virtual std::string id() const = 0;
  /// Outside the clock. Segmentation of depth frames may prepare what depends on the camera alone; the voxel grids, and
  /// everything on point clouds, bring the points into the library's own type here.
  virtual void load(const Frame& /*frame*/) {}
  /// Under the clock: from depth (or the loaded cloud) in memory to the answer in memory. False when nothing was found.
  virtual bool run(const Frame& frame, Answer& answer) = 0;
};

/// Everybody who takes part.
struct Party {
  std::vector<std::unique_ptr<Peer>> peers;
  std::vector<std::pair<std::string, std::string>> versions;  ///< Library and version.
};

#ifdef FRANSAC_BENCH_NATIVE
inline constexpr const char* kBuild = "native";
#else
inline constexpr const char* kBuild = "packaged";
#endif

// One function per file, called where its library was found.
void add_ours(Party& party, int threads);
void add_floors(Party& party);
void add_pcl_sac(Party& party);
void add_pcl_organized(Party& party);
void add_pcl_clouds(Party& party);
void add_pcl_clusters(Party& party);
void add_pcl_adapter(Party& party);
void add_open3d(Party& party);
void add_opencv(Party& party);
void add_cgal(Party& party);

}  // namespace fransac::bench
