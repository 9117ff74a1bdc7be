// SPDX-License-Identifier: Apache-2.0
/// PCL's classes, and those in their place, from a cloud of PCL's in memory to the answer in memory.
#pragma once

#include <pcl/ModelCoefficients.h>
#include <pcl/PointIndices.h>

#include <string>
#include <utility>

#include "pcl_cloud.hpp"
#include "pcl_ransac.hpp"

namespace fransac::bench {

/// To a plane and the indices of its inliers.
template <class Segmentation>
class CloudSac final : public Peer {
 public:
  explicit CloudSac(std::string id) : id_(std::move(id)) { prepare(segmentation_); }

  [[nodiscard]] std::string id() const override { return id_; }
  void load(const Frame& frame) override { points_.read(frame); }
  bool run(const Frame& /*frame*/, Answer& answer) override {
    segmentation_.setInputCloud(points_.cloud);
    segmentation_.segment(inliers_, coefficients_);
    if (coefficients_.values.size() != 4) return false;
    for (std::size_t i = 0; i < 4; ++i) answer.plane[i] = static_cast<double>(coefficients_.values[i]);
    answer.planes = 1;
    answer.inliers = inliers_.indices.size();
    return true;
  }

 private:
  std::string id_;
  PclPoints points_;
  Segmentation segmentation_;
  ::pcl::PointIndices inliers_;
  ::pcl::ModelCoefficients coefficients_;
};

/// To one point per leaf.
template <class Filter>
class CloudVoxelGrid final : public Peer {
 public:
  explicit CloudVoxelGrid(std::string id) : id_(std::move(id)) {
    constexpr auto kLeaf = static_cast<float>(kLeafSize_m);
    filter_.setLeafSize(kLeaf, kLeaf, kLeaf);
  }

  [[nodiscard]] std::string id() const override { return id_; }
  void load(const Frame& frame) override { points_.read(frame); }
  bool run(const Frame& /*frame*/, Answer& answer) override {
    filter_.setInputCloud(points_.cloud);
    filter_.filter(leaves_);
    answer.leaves = leaves_.size();
    return !leaves_.empty();
  }

 private:
  std::string id_;
  PclPoints points_;
  PclCloud leaves_;
  Filter filter_;
};

}  // namespace fransac::bench
