// SPDX-License-Identifier: Apache-2.0
/// What stands on a table: thins out a cloud, takes its large planes away, and gathers the rest into clusters.
/// Usage: cluster_extraction CLOUD.pcd. WITH_PCL compiles the same with PCL's own classes.
#include <pcl/ModelCoefficients.h>
#include <pcl/PointIndices.h>
#include <pcl/filters/extract_indices.h>
#include <pcl/io/pcd_io.h>
#include <pcl/point_cloud.h>
#include <pcl/point_types.h>
#include <pcl/sample_consensus/method_types.h>
#include <pcl/sample_consensus/model_types.h>
#include <pcl/search/kdtree.h>
#include <pcl/segmentation/extract_clusters.h>

#include <cstddef>
#include <cstdio>
#include <vector>

// [port]
#ifdef WITH_PCL
#include <pcl/filters/voxel_grid.h>
#include <pcl/segmentation/sac_segmentation.h>
using pcl::SACSegmentation;
using pcl::VoxelGrid;
#else
#include "fransac/pcl/sac_segmentation.hpp"
#include "fransac/pcl/voxel_grid.hpp"
using fransac::pcl::SACSegmentation;
using fransac::pcl::VoxelGrid;
#endif
// [port]

namespace {

using Cloud = pcl::PointCloud<pcl::PointXYZ>;

constexpr float kLeaf_m = 0.01F;
constexpr double kThreshold_m = 0.02;
constexpr double kShareToLeave = 0.3;

Cloud::Ptr thinned_out(const Cloud::ConstPtr& cloud) {
  const Cloud::Ptr leaves(new Cloud);
  VoxelGrid<pcl::PointXYZ> grid;
  grid.setInputCloud(cloud);
  grid.setLeafSize(kLeaf_m, kLeaf_m, kLeaf_m);
  grid.filter(*leaves);
  return leaves;
}

/// Takes planes away, largest first, until few enough points are left.
Cloud::Ptr without_planes(Cloud::Ptr cloud) {
  SACSegmentation<pcl::PointXYZ> segmentation;
  segmentation.setOptimizeCoefficients(true);
  segmentation.setModelType(pcl::SACMODEL_PLANE);
  segmentation.setMethodType(pcl::SAC_RANSAC);
  segmentation.setMaxIterations(100);
  segmentation.setDistanceThreshold(kThreshold_m);
  const auto few = static_cast<std::size_t>(kShareToLeave * static_cast<double>(cloud->size()));
  while (cloud->size() > few) {
    const pcl::PointIndices::Ptr inliers(new pcl::PointIndices);
    pcl::ModelCoefficients plane;
    segmentation.setInputCloud(cloud);
    segmentation.segment(*inliers, plane);
    if (inliers->indices.empty()) break;
    std::printf("plane");
    for (const float value : plane.values) std::printf(" %g", static_cast<double>(value));
    std::printf(" inliers %zu\n", inliers->indices.size());

    const Cloud::Ptr rest(new Cloud);
    pcl::ExtractIndices<pcl::PointXYZ> extract;
    extract.setInputCloud(cloud);
    extract.setIndices(inliers);
    extract.setNegative(true);
    extract.filter(*rest);
    cloud = rest;
  }
  return cloud;
}

std::vector<pcl::PointIndices> clusters_of(const Cloud::ConstPtr& cloud) {
  const pcl::search::KdTree<pcl::PointXYZ>::Ptr tree(new pcl::search::KdTree<pcl::PointXYZ>);
  tree->setInputCloud(cloud);
  pcl::EuclideanClusterExtraction<pcl::PointXYZ> extraction;
  extraction.setClusterTolerance(2.0 * static_cast<double>(kLeaf_m));
  extraction.setMinClusterSize(100);
  extraction.setMaxClusterSize(25000);
  extraction.setSearchMethod(tree);
  extraction.setInputCloud(cloud);
  std::vector<pcl::PointIndices> clusters;
  extraction.extract(clusters);
  return clusters;
}

}  // namespace

int main(int argc, char** argv) {
  const Cloud::Ptr cloud(new Cloud);
  if (argc != 2 || pcl::io::loadPCDFile(argv[1], *cloud) != 0) {
    std::fprintf(stderr, "usage: cluster_extraction CLOUD.pcd\n");
    return 1;
  }
  const Cloud::Ptr leaves = thinned_out(cloud);
  std::printf("points %zu leaves %zu\n", cloud->size(), leaves->size());
  const Cloud::Ptr rest = without_planes(leaves);
  for (const pcl::PointIndices& cluster : clusters_of(rest)) std::printf("cluster %zu\n", cluster.indices.size());
}
