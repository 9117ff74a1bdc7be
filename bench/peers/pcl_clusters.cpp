// SPDX-License-Identifier: Apache-2.0
/// Objects as PCL's tutorial on Euclidean cluster extraction finds them: the plane by RANSAC, what is off it by a k-d tree and
/// connected points, 2 cm apart at most, 100 or more together. The tutorial thins the cloud out first, to one point per
/// centimetre; both are here. Plane threshold as everywhere, 1 cm (the tutorial's 2 cm hide what is low).
#include <pcl/ModelCoefficients.h>
#include <pcl/PointIndices.h>
#include <pcl/filters/extract_indices.h>
#include <pcl/filters/voxel_grid.h>
#include <pcl/search/kdtree.h>
#include <pcl/segmentation/extract_clusters.h>
#include <pcl/segmentation/sac_segmentation.h>

#include <algorithm>

#include "pcl_cloud.hpp"
#include "pcl_ransac.hpp"

namespace fransac::bench {
namespace {

constexpr double kTolerance_m = 0.02;
constexpr int kFewest = 100;
constexpr float kThinning_m = 0.01F;

class PclClusters final : public Peer {
 public:
  explicit PclClusters(bool thin) : thin_(thin) {
    prepare(ransac_);
    clusters_.setClusterTolerance(kTolerance_m);
    clusters_.setMinClusterSize(kFewest);
    clusters_.setSearchMethod(tree_);
    voxel_grid_.setLeafSize(kThinning_m, kThinning_m, kThinning_m);
    voxel_grid_.setSaveLeafLayout(true);  // which leaf each point went into
  }

  [[nodiscard]] std::string id() const override { return std::string(thin_ ? "pcl-voxel-clusters-" : "pcl-clusters-") + kBuild; }

  bool run(const Frame& frame, Answer& answer) override {
    if (frame.depth == nullptr) return false;
    points_.read(frame);
    const PclCloud::ConstPtr cloud = thinned();
    pcl::PointIndices::Ptr plane(new pcl::PointIndices);
    pcl::ModelCoefficients coefficients;
    ransac_.setInputCloud(cloud);
    ransac_.segment(*plane, coefficients);
    if (coefficients.values.size() != 4) return false;
    pcl::ExtractIndices<pcl::PointXYZ> extract;
    pcl::IndicesPtr off_plane(new pcl::Indices);
    extract.setInputCloud(cloud);
    extract.setIndices(plane);
    extract.setNegative(true);
    extract.filter(*off_plane);
    PclCloud::Ptr rest(new PclCloud(*cloud, *off_plane));
    std::vector<pcl::PointIndices> found;
    if (!rest->empty()) {
      tree_->setInputCloud(rest);
      clusters_.setInputCloud(rest);
      clusters_.extract(found);
    }
    object_of_.assign(cloud->size(), 0);
    for (std::size_t i = 0; i < found.size(); ++i) {
      for (const auto point : found[i].indices) {
        object_of_[static_cast<std::size_t>((*off_plane)[static_cast<std::size_t>(point)])] = static_cast<std::uint16_t>(i + 1);
      }
    }
    write(frame);
    answer.objects = objects_.data();
    answer.planes = 1;
    for (int i = 0; i < 4; ++i) answer.plane[i] = static_cast<double>(coefficients.values[static_cast<std::size_t>(i)]);
    return true;
  }

 private:
  PclCloud::ConstPtr thinned() {
    if (!thin_) return points_.cloud;
    voxel_grid_.setInputCloud(points_.cloud);
    voxel_grid_.filter(*leaves_);
    return leaves_;
  }

  /// The object of each pixel's point, or of its leaf.
  void write(const Frame& frame) {
    objects_.assign(frame.size(), 0);
    for (std::size_t i = 0; i < points_.size(); ++i) {
      const auto place = thin_ ? static_cast<std::size_t>(voxel_grid_.getCentroidIndex((*points_.cloud)[i])) : i;
      objects_[points_.pixels[i]] = object_of_[place];
    }
  }

  bool thin_;
  PclPoints points_;
  PclCloud::Ptr leaves_{new PclCloud};
  pcl::VoxelGrid<pcl::PointXYZ> voxel_grid_;
  pcl::SACSegmentation<pcl::PointXYZ> ransac_;
  pcl::search::KdTree<pcl::PointXYZ>::Ptr tree_{new pcl::search::KdTree<pcl::PointXYZ>};
  pcl::EuclideanClusterExtraction<pcl::PointXYZ> clusters_;
  std::vector<std::uint16_t> object_of_;
  std::vector<std::uint16_t> objects_;
};

}  // namespace

void add_pcl_clusters(Party& party) {
  party.peers.push_back(std::make_unique<PclClusters>(false));
  party.peers.push_back(std::make_unique<PclClusters>(true));
}

}  // namespace fransac::bench
