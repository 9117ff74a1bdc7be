// SPDX-License-Identifier: Apache-2.0
/// The adapter in the place of PCL's classes: PCL's cloud in memory to indices and coefficients, or to a cloud of PCL's, in
/// memory.
#include "fransac/pcl/sac_segmentation.hpp"
#include "fransac/pcl/voxel_grid.hpp"
#include "pcl_cloud.hpp"
#include "pcl_peers.hpp"

namespace fransac::bench {

void add_pcl_adapter(Party& party) {
  party.peers.push_back(std::make_unique<CloudSac<pcl::SACSegmentation<::pcl::PointXYZ>>>("adapter-sac"));
  party.peers.push_back(std::make_unique<CloudVoxelGrid<pcl::VoxelGrid<::pcl::PointXYZ>>>("adapter-voxelgrid"));
}

}  // namespace fransac::bench
