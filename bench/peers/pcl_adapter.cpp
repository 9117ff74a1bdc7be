// SPDX-License-Identifier: Apache-2.0
/// The adapter in the place of PCL's classes.
#include "cloud_peers.hpp"
#include "fransac/pcl/sac_segmentation.hpp"
#include "fransac/pcl/voxel_grid.hpp"

namespace fransac::bench {

void add_pcl_adapter(Party& party) {
  party.peers.push_back(std::make_unique<CloudSac<pcl::SACSegmentation<::pcl::PointXYZ>>>("adapter-sac"));
  party.peers.push_back(std::make_unique<CloudVoxelGrid<pcl::VoxelGrid<::pcl::PointXYZ>>>("adapter-voxelgrid"));
}

}  // namespace fransac::bench
