// SPDX-License-Identifier: Apache-2.0
/// PCL's voxel grids alone: cloud in memory to downsampled cloud in memory.
#include <pcl/filters/approximate_voxel_grid.h>
#include <pcl/filters/voxel_grid.h>

#include "pcl_cloud.hpp"

namespace fransac::bench {
namespace {

template <class Filter>
class PclVoxelGrid final : public Peer {
 public:
  explicit PclVoxelGrid(const char* name) : name_(name) {
    constexpr auto kLeaf = static_cast<float>(kLeafSize_m);
    filter_.setLeafSize(kLeaf, kLeaf, kLeaf);
  }

  [[nodiscard]] std::string id() const override { return name_ + "-" + kBuild; }
  void load(const Frame& frame) override { points_.read(frame); }
  bool run(const Frame& /*frame*/, Answer& answer) override {
    filter_.setInputCloud(points_.cloud);
    filter_.filter(leaves_);
    answer.leaves = leaves_.size();
    return !leaves_.empty();
  }

 private:
  std::string name_;
  PclPoints points_;
  PclCloud leaves_;
  Filter filter_;
};

}  // namespace

void add_pcl_voxel_grid(Party& party) {
  party.peers.push_back(std::make_unique<PclVoxelGrid<pcl::VoxelGrid<pcl::PointXYZ>>>("pcl-voxelgrid"));
  party.peers.push_back(std::make_unique<PclVoxelGrid<pcl::ApproximateVoxelGrid<pcl::PointXYZ>>>("pcl-approximate-voxelgrid"));
}

}  // namespace fransac::bench
