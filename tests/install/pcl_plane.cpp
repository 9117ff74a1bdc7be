// SPDX-License-Identifier: Apache-2.0
// A program of somebody else's that uses the adapter for PCL: succeeds when it finds the plane z = 1.
#include <fransac/pcl/organized_multi_plane_segmentation.hpp>
#include <fransac/pcl/sac_segmentation.hpp>
#include <fransac/pcl/voxel_grid.hpp>

int main() {
  const pcl::PointCloud<pcl::PointXYZ>::Ptr cloud(new pcl::PointCloud<pcl::PointXYZ>);
  for (int i = 0; i < 100; ++i) cloud->emplace_back(static_cast<float>(i % 10), static_cast<float>(i / 10), 1.0F);
  fransac::pcl::SACSegmentation<pcl::PointXYZ> segmentation;
  segmentation.setModelType(pcl::SACMODEL_PLANE);
  segmentation.setDistanceThreshold(0.01);
  segmentation.setInputCloud(cloud);
  pcl::PointIndices inliers;
  pcl::ModelCoefficients plane;
  segmentation.segment(inliers, plane);
  fransac::pcl::VoxelGrid<pcl::PointXYZ> grid;
  pcl::PointCloud<pcl::PointXYZ> leaves;
  grid.setInputCloud(cloud);
  grid.setLeafSize(5.0F, 5.0F, 5.0F);
  grid.filter(leaves);
  return inliers.indices.size() == 100 && leaves.size() == 4 ? 0 : 1;
}
