// SPDX-License-Identifier: Apache-2.0
/// PCL's own classes alone.
#include <pcl/filters/approximate_voxel_grid.h>
#include <pcl/filters/voxel_grid.h>
#include <pcl/segmentation/sac_segmentation.h>

#include "cloud_peers.hpp"

namespace fransac::bench {

void add_pcl_clouds(Party& party) {
  const std::string build = std::string("-") + kBuild;
  const auto add = [&](auto peer) { party.peers.push_back(std::move(peer)); };
  add(std::make_unique<CloudSac<pcl::SACSegmentation<pcl::PointXYZ>>>("pcl-sac" + build));
  add(std::make_unique<CloudVoxelGrid<pcl::VoxelGrid<pcl::PointXYZ>>>("pcl-voxelgrid" + build));
  add(std::make_unique<CloudVoxelGrid<pcl::ApproximateVoxelGrid<pcl::PointXYZ>>>("pcl-approximate-voxelgrid" + build));
}

}  // namespace fransac::bench
