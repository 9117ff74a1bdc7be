// SPDX-License-Identifier: Apache-2.0
/// Open3D as packaged: segment_plane on the full cloud and after voxel_down_sample, and voxel_down_sample alone.
/// Labels: by inlier indices at full resolution, after the voxel grid by the distance of each point to the plane.
#include <omp.h>
#include <open3d/Open3DConfig.h>
#include <open3d/camera/PinholeCameraIntrinsic.h>
#include <open3d/geometry/Image.h>
#include <open3d/geometry/PointCloud.h>
#include <open3d/utility/Random.h>

#include <cstring>
#include <limits>

#include "labelling.hpp"

namespace fransac::bench {
namespace {

using Cloud = open3d::geometry::PointCloud;

std::shared_ptr<Cloud> read(const Frame& frame) {
  if (frame.depth == nullptr) {
    auto cloud = std::make_shared<Cloud>();
    for (std::size_t i = 0; i < frame.size(); ++i) {
      const float* const p = frame.points + 3 * i;
      cloud->points_.emplace_back(static_cast<double>(p[0]), static_cast<double>(p[1]), static_cast<double>(p[2]));
    }
    return cloud;
  }
  open3d::geometry::Image depth;
  depth.Prepare(frame.width, frame.height, 1, sizeof(std::uint16_t));
  std::memcpy(depth.data_.data(), frame.depth, frame.size() * sizeof(std::uint16_t));
  const open3d::camera::PinholeCameraIntrinsic camera(frame.width, frame.height, frame.fx, frame.fy, frame.cx, frame.cy);
  constexpr double kNoLimit_m = 1000.0;
  return Cloud::CreateFromDepthImage(depth, camera, Eigen::Matrix4d::Identity(), frame.depth_scale, kNoLimit_m);
}

class Open3dSegment final : public Peer {
 public:
  explicit Open3dSegment(bool voxels) : voxels_(voxels) {}

  [[nodiscard]] std::string id() const override { return voxels_ ? "open3d-segment-voxel" : "open3d-segment"; }

  void load(const Frame& frame) override {
    labels_.resize(frame.size());
    if (frame.depth == nullptr) cloud_ = read(frame);
  }

  bool run(const Frame& frame, Answer& answer) override {
    if (frame.depth != nullptr) cloud_ = read(frame);
    pixels_.clear();  // Open3D's points are the measured pixels in their order
    for (std::uint32_t i = 0; i < frame.size(); ++i) {
      if (frame.depth == nullptr || frame.depth[i] != 0) pixels_.push_back(i);
    }
    const std::shared_ptr<const Cloud> sampled = voxels_ ? cloud_->VoxelDownSample(kLeafSize_m) : cloud_;
    const auto [plane, inliers] = sampled->SegmentPlane(kThreshold_m, kSampleSize, kMaxIterations, kProbability);
    if (inliers.empty()) return false;
    for (int i = 0; i < 4; ++i) answer.plane[i] = plane[i];
    const auto pixel = [this](std::size_t i) { return pixels_[i]; };
    if (voxels_) {
      const auto xyz = [this](std::size_t i, float& x, float& y, float& z) {
        const Eigen::Vector3d& point = cloud_->points_[i];
        x = static_cast<float>(point.x());
        y = static_cast<float>(point.y());
        z = static_cast<float>(point.z());
      };
      answer.inliers =
          label_by_distance(cloud_->points_.size(), answer.plane, std::numeric_limits<double>::infinity(), xyz, pixel, labels_);
    } else {
      answer.inliers = label_by_index(frame, inliers, pixel, labels_);
    }
    answer.planes = 1;
    answer.labels = labels_.data();
    return true;
  }

 private:
  bool voxels_;
  std::shared_ptr<Cloud> cloud_;
  std::vector<std::uint32_t> pixels_;
  std::vector<std::uint8_t> labels_;
};

class Open3dVoxelGrid final : public Peer {
 public:
  [[nodiscard]] std::string id() const override { return "open3d-voxelgrid"; }
  void load(const Frame& frame) override { cloud_ = read(frame); }
  bool run(const Frame& /*frame*/, Answer& answer) override {
    leaves_ = cloud_->VoxelDownSample(kLeafSize_m);
    answer.leaves = leaves_->points_.size();
    return answer.leaves > 0;
  }

 private:
  std::shared_ptr<Cloud> cloud_;
  std::shared_ptr<Cloud> leaves_;
};

}  // namespace

void add_open3d(Party& party) {
  omp_set_num_threads(1);
  open3d::utility::random::Seed(0);
  party.peers.push_back(std::make_unique<Open3dSegment>(false));
  party.peers.push_back(std::make_unique<Open3dSegment>(true));
  party.peers.push_back(std::make_unique<Open3dVoxelGrid>());
  party.versions.emplace_back("open3d", OPEN3D_VERSION);
}

}  // namespace fransac::bench
