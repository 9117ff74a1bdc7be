// SPDX-License-Identifier: Apache-2.0
/// PCL's sample consensus: RANSAC, R-RANSAC, and both the paper's pipelines made of PCL's parts.
/// Labels: by inlier indices at full resolution; after a voxel grid by the distance of each point to the plane.
#include <pcl/ModelCoefficients.h>
#include <pcl/PointIndices.h>
#include <pcl/console/print.h>
#include <pcl/filters/passthrough.h>
#include <pcl/filters/voxel_grid.h>
#include <pcl/pcl_config.h>
#include <pcl/sample_consensus/rransac.h>
#include <pcl/sample_consensus/sac_model_plane.h>
#include <pcl/segmentation/sac_segmentation.h>

#include <limits>

#include "labelling.hpp"
#include "pcl_cloud.hpp"
#include "pcl_ransac.hpp"

namespace fransac::bench {
namespace {

enum class Pipeline { ransac, rransac, voxel_ransac, fransac };

class PclSac final : public Peer {
 public:
  explicit PclSac(Pipeline pipeline) : pipeline_(pipeline) {
    prepare(ransac_);
    pass_through_.setFilterFieldName("z");
    pass_through_.setFilterLimits(static_cast<float>(kNearest_m), static_cast<float>(kFarthest_m));
    constexpr auto kLeaf = static_cast<float>(kLeafSize_m);
    voxel_grid_.setLeafSize(kLeaf, kLeaf, kLeaf);
  }

  [[nodiscard]] std::string id() const override {
    const char* const names[] = {"ransac", "rransac", "voxel-ransac", "fransac"};
    return std::string("pcl-") + names[static_cast<int>(pipeline_)] + "-" + kBuild;
  }

  void load(const Frame& frame) override {
    labels_.resize(frame.size());
    if (frame.depth == nullptr) points_.read(frame);
  }

  bool run(const Frame& frame, Answer& answer) override {
    if (frame.depth != nullptr) points_.read(frame);
    const auto pixel = [this](std::size_t i) { return points_.pixels[i]; };
    if (!find(frame.depth != nullptr)) return false;
    for (int i = 0; i < 4; ++i) answer.plane[i] = static_cast<double>(coefficients_.values[static_cast<std::size_t>(i)]);
    if (uses_voxels()) {
      const auto xyz = [this](std::size_t i, float& x, float& y, float& z) {
        const pcl::PointXYZ& point = points_.cloud->points[i];
        x = point.x;
        y = point.y;
        z = point.z;
      };
      const double farthest = pipeline_ == Pipeline::fransac ? kFarthest_m : std::numeric_limits<double>::infinity();
      answer.inliers = label_by_distance(points_.size(), answer.plane, farthest, xyz, pixel, labels_);
    } else {
      answer.inliers = label_by_index(frame, inliers_.indices, pixel, labels_);
    }
    answer.planes = 1;
    answer.labels = labels_.data();
    return true;
  }

 private:
  [[nodiscard]] bool uses_voxels() const { return pipeline_ == Pipeline::voxel_ransac || pipeline_ == Pipeline::fransac; }

  bool find(bool is_depth) {
    PclCloud::ConstPtr cloud = points_.cloud;
    if (pipeline_ == Pipeline::fransac && is_depth) {  // the axes of a cloud mean nothing by themselves
      pass_through_.setInputCloud(cloud);
      pass_through_.filter(*passed_);
      cloud = passed_;
    }
    if (uses_voxels()) {
      voxel_grid_.setInputCloud(cloud);
      voxel_grid_.filter(*leaves_);
      cloud = leaves_;
    }
    if (pipeline_ == Pipeline::rransac) return find_rransac(cloud);
    ransac_.setInputCloud(cloud);
    ransac_.segment(inliers_, coefficients_);
    return coefficients_.values.size() == 4;
  }

  /// SACSegmentation cannot set the share of the points that is pre-tested; its default, a tenth of them, all of which must be
  /// inliers, is passed by nearly no plane. One point is what Matas & Chum 2004 recommend. The rest is as SACSegmentation does
  /// it.
  bool find_rransac(const PclCloud::ConstPtr& cloud) {
    using Model = pcl::SampleConsensusModelPlane<pcl::PointXYZ>;
    const Model::Ptr model(new Model(cloud));
    pcl::RandomizedRandomSampleConsensus<pcl::PointXYZ> rransac(model, kThreshold_m);
    rransac.setProbability(kProbability);
    rransac.setMaxIterations(kMaxIterations);
    rransac.setFractionNrPretest(100.0 / static_cast<double>(cloud->size()));
    if (!rransac.computeModel()) return false;
    Eigen::VectorXf found;
    Eigen::VectorXf refined;
    rransac.getInliers(inliers_.indices);
    rransac.getModelCoefficients(found);
    model->optimizeModelCoefficients(inliers_.indices, found, refined);
    model->selectWithinDistance(refined, kThreshold_m, inliers_.indices);
    coefficients_.values.assign(refined.data(), refined.data() + refined.size());
    return coefficients_.values.size() == 4;
  }

  Pipeline pipeline_;
  PclPoints points_;
  PclCloud::Ptr passed_{new PclCloud};
  PclCloud::Ptr leaves_{new PclCloud};
  pcl::PassThrough<pcl::PointXYZ> pass_through_;
  pcl::VoxelGrid<pcl::PointXYZ> voxel_grid_;
  pcl::SACSegmentation<pcl::PointXYZ> ransac_;
  pcl::PointIndices inliers_;
  pcl::ModelCoefficients coefficients_;
  std::vector<std::uint8_t> labels_;
};

}  // namespace

void add_pcl_sac(Party& party) {
  pcl::console::setVerbosityLevel(pcl::console::L_ALWAYS);
  for (const Pipeline pipeline : {Pipeline::ransac, Pipeline::rransac, Pipeline::voxel_ransac, Pipeline::fransac}) {
    party.peers.push_back(std::make_unique<PclSac>(pipeline));
  }
  party.versions.emplace_back("pcl", PCL_VERSION_PRETTY);
}

}  // namespace fransac::bench
