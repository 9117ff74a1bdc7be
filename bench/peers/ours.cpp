// SPDX-License-Identifier: Apache-2.0
/// The project's own methods, through the public interface, with one workspace per method as for a stream of frames.
#include <algorithm>
#include <limits>
#include <stdexcept>

#include "fransac/filter/deproject.hpp"
#include "fransac/filter/voxel_grid.hpp"
#include "fransac/obstacles/obstacles.hpp"
#include "fransac/planes/segment.hpp"
#include "fransac/version.hpp"
#include "peer.hpp"

namespace fransac::bench {
namespace {

DepthView view_of(const Frame& frame) {
  return DepthView::from_uint16(frame.depth, frame.width, frame.height, frame.depth_scale);
}

Camera camera_of(const Frame& frame) {
  return {frame.width, frame.height, frame.fx, frame.fy, frame.cx, frame.cy, frame.depth_scale};
}

void read(const Frame& frame, PointCloud& cloud) {
  if (frame.depth != nullptr) return deproject(view_of(frame), camera_of(frame), cloud);
  cloud.resize(frame.size());
  for (std::size_t i = 0; i < frame.size(); ++i) {
    const float* const p = frame.points + 3 * i;
    cloud.set(i, {p[0], p[1], p[2]});
  }
}

class Ours final : public Peer {
 public:
  Ours(Method method, int threads) {
    options_.method = method;
    options_.threads = threads;
    options_.pass_through.limits = {Axis::z, kNearest_m, kFarthest_m};
    options_.voxel_grid.leaf_size_m = kLeafSize_m;
    options_.ransac.threshold_m = kThreshold_m;
    options_.ransac.probability = kProbability;
    options_.ransac.max_iterations = kMaxIterations;
  }

  [[nodiscard]] std::string id() const override { return std::string(enum_name(options_.method)); }

  void load(const Frame& frame) override {
    if (frame.depth == nullptr) read(frame, cloud_);
  }

  bool run(const Frame& frame, Answer& answer) override {
    const Status status = frame.depth != nullptr ? segment(view_of(frame), camera_of(frame), options_, workspace_, found_)
                                                 : segment(cloud_, options_, workspace_, found_);
    if (!status || found_.planes.empty()) return false;
    const PlaneSegment& first = found_.planes.front();
    for (int i = 0; i < 3; ++i) answer.plane[i] = first.plane.normal[i];
    answer.plane[3] = first.plane.d;
    answer.planes = static_cast<int>(found_.planes.size());
    answer.inliers = first.inliers;
    answer.labels = found_.labels.data();
    answer.stages.resize(kStages);
    for (std::size_t s = 0; s < kStages; ++s) answer.stages[s] = {EnumNames<Stage>::values[s], found_.timing.stage_ms[s]};
    return true;
  }

 private:
  SegmentOptions options_;
  PointCloud cloud_;
  Workspace workspace_;
  Segmentation found_;
};

/// Planes by `cells`, then what is on top of them.
class OurObstacles final : public Peer {
 public:
  explicit OurObstacles(int threads) {
    options_.method = Method::cells;
    options_.threads = threads;
  }

  [[nodiscard]] std::string id() const override { return "obstacles"; }

  bool run(const Frame& frame, Answer& answer) override {
    if (frame.depth == nullptr) return false;
    const DepthView view = view_of(frame);
    const Camera camera = camera_of(frame);
    if (!segment(view, camera, options_, workspace_, planes_)) return false;
    if (!find_obstacles(view, camera, planes_, {}, nullptr, obstacle_workspace_, found_) || found_.support.empty()) return false;
    leave_out_drops();
    answer.planes = static_cast<int>(planes_.planes.size());
    answer.objects = found_.labels.data();
    answer.stages = {{"planes", planes_.timing.total_ms}, {"obstacles", found_.total_ms}};
    return true;
  }

 private:
  /// What falls away is an obstacle and no object.
  void leave_out_drops() {
    const auto is_drop = [](const Obstacle& obstacle) { return obstacle.kind == ObstacleKind::drop; };
    if (std::none_of(found_.obstacles.begin(), found_.obstacles.end(), is_drop)) return;
    for (std::uint16_t& label : found_.labels) {
      if (label != 0 && is_drop(found_.obstacles[label - 1U])) label = 0;
    }
  }

  SegmentOptions options_;
  Workspace workspace_;
  Segmentation planes_;
  ObstacleWorkspace obstacle_workspace_;
  Obstacles found_;
};

/// The voxel grid alone, from the cloud in memory, as its rivals.
class OurVoxelGrid final : public Peer {
 public:
  [[nodiscard]] std::string id() const override { return "voxel-grid"; }
  void load(const Frame& frame) override { read(frame, cloud_); }
  bool run(const Frame& /*frame*/, Answer& answer) override {
    if (!voxel_grid(cloud_, kLeafSize_m, LeafPoint::centroid, grid_)) return false;
    answer.leaves = grid_.leaves.size();
    return true;
  }

 private:
  PointCloud cloud_;
  VoxelGrid grid_;
};

/// The voxel grid straight from depth, as `fransac` uses it: deprojection included, which the rivals are spared.
class OurDepthGrid final : public Peer {
 public:
  [[nodiscard]] std::string id() const override { return "voxel-grid-depth"; }
  bool run(const Frame& frame, Answer& answer) override {
    if (frame.depth == nullptr) return false;
    const Status status = voxel_grid(view_of(frame), camera_of(frame), {.leaf_size_m = kLeafSize_m}, grid_);
    answer.leaves = grid_.leaves.size();
    return static_cast<bool>(status);
  }

 private:
  VoxelGrid grid_;
};

}  // namespace

void add_ours(Party& party, int threads) {
  for (const Method method : {Method::cells, Method::fransac, Method::voxel_ransac, Method::rransac, Method::ransac}) {
    party.peers.push_back(std::make_unique<Ours>(method, threads));
  }
  party.peers.push_back(std::make_unique<OurObstacles>(threads));
  party.peers.push_back(std::make_unique<OurVoxelGrid>());
  party.peers.push_back(std::make_unique<OurDepthGrid>());
  party.versions.emplace_back("fransac", kVersion);
}

}  // namespace fransac::bench
