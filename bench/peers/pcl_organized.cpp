// SPDX-License-Identifier: Apache-2.0
/// PCL's OrganizedMultiPlaneSegmentation on integral-image normals, with its boundaries refined.
/// Settings: those of PCL's organised segmentation demo (3 degrees, 2 cm, normals from covariances over 20 pixels, depth
/// changes of 2 %) with the class's own 1000 inliers instead of the demo's 10000, which is a tenth of a cropped frame.
/// Labels: the regions' inlier indices.
#include <pcl/ModelCoefficients.h>
#include <pcl/PointIndices.h>
#include <pcl/common/angles.h>
#include <pcl/features/integral_image_normal.h>
#include <pcl/segmentation/organized_multi_plane_segmentation.h>

#include <algorithm>
#include <limits>

#include "labelling.hpp"
#include "pcl_cloud.hpp"

namespace fransac::bench {
namespace {

class PclOrganized final : public Peer {
 public:
  PclOrganized() {
    normals_from_.setNormalEstimationMethod(decltype(normals_from_)::COVARIANCE_MATRIX);
    normals_from_.setMaxDepthChangeFactor(0.02F);
    normals_from_.setNormalSmoothingSize(20.0F);
    planes_from_.setMinInliers(1000);
    planes_from_.setAngularThreshold(pcl::deg2rad(3.0));
    planes_from_.setDistanceThreshold(0.02);
  }

  [[nodiscard]] std::string id() const override { return std::string("pcl-organized-") + kBuild; }
  void load(const Frame& frame) override { labels_.resize(frame.size()); }

  bool run(const Frame& frame, Answer& answer) override {
    deproject(frame);
    normals_from_.setInputCloud(cloud_);
    normals_from_.compute(*normals_);
    planes_from_.setInputNormals(normals_);
    planes_from_.setInputCloud(cloud_);

    std::vector<pcl::PlanarRegion<pcl::PointXYZ>, Eigen::aligned_allocator<pcl::PlanarRegion<pcl::PointXYZ>>> regions;
    std::vector<pcl::ModelCoefficients> models;
    std::vector<pcl::PointIndices> inliers;
    std::vector<pcl::PointIndices> label_indices;
    std::vector<pcl::PointIndices> boundaries;
    pcl::PointCloud<pcl::Label>::Ptr regions_of_pixels(new pcl::PointCloud<pcl::Label>);
    planes_from_.segmentAndRefine(regions, models, inliers, regions_of_pixels, label_indices, boundaries);
    if (inliers.empty()) return false;

    for (std::size_t i = 0; i < labels_.size(); ++i) labels_[i] = frame.depth[i] == 0 ? kNoDepth : kNoPlane;
    const std::size_t planes = std::min<std::size_t>(inliers.size(), kNoPlane - 1);
    std::size_t largest = 0;
    for (std::size_t p = 0; p < planes; ++p) {
      if (inliers[p].indices.size() > inliers[largest].indices.size()) largest = p;
      for (const int i : inliers[p].indices) labels_[static_cast<std::size_t>(i)] = static_cast<std::uint8_t>(p + 1);
    }
    const std::vector<std::size_t> sizes = order_by_size(labels_);
    for (std::size_t i = 0; i < 4; ++i) answer.plane[i] = static_cast<double>(models[largest].values[i]);
    answer.planes = static_cast<int>(sizes.size());
    answer.inliers = sizes.front();
    answer.labels = labels_.data();
    return true;
  }

 private:
  void deproject(const Frame& frame) {
    cloud_->points.resize(frame.size());
    cloud_->width = static_cast<std::uint32_t>(frame.width);
    cloud_->height = static_cast<std::uint32_t>(frame.height);
    cloud_->is_dense = false;
    const auto scale = static_cast<float>(1.0 / frame.depth_scale);
    const auto inverse_fx = static_cast<float>(1.0 / frame.fx);
    const auto inverse_fy = static_cast<float>(1.0 / frame.fy);
    const auto cx = static_cast<float>(frame.cx);
    const auto cy = static_cast<float>(frame.cy);
    std::size_t i = 0;
    for (int v = 0; v < frame.height; ++v) {
      for (int u = 0; u < frame.width; ++u, ++i) {
        const float z =
            frame.depth[i] == 0 ? std::numeric_limits<float>::quiet_NaN() : static_cast<float>(frame.depth[i]) * scale;
        pcl::PointXYZ& point = cloud_->points[i];
        point.x = (static_cast<float>(u) - cx) * inverse_fx * z;
        point.y = (static_cast<float>(v) - cy) * inverse_fy * z;
        point.z = z;
      }
    }
  }

  PclCloud::Ptr cloud_{new PclCloud};
  pcl::PointCloud<pcl::Normal>::Ptr normals_{new pcl::PointCloud<pcl::Normal>};
  pcl::IntegralImageNormalEstimation<pcl::PointXYZ, pcl::Normal> normals_from_;
  pcl::OrganizedMultiPlaneSegmentation<pcl::PointXYZ, pcl::Normal, pcl::Label> planes_from_;
  std::vector<std::uint8_t> labels_;
};

}  // namespace

void add_pcl_organized(Party& party) { party.peers.push_back(std::make_unique<PclOrganized>()); }

}  // namespace fransac::bench
