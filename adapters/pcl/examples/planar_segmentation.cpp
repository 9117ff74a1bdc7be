// SPDX-License-Identifier: Apache-2.0
/// A plane among a few points, with PCL's calls. WITH_PCL compiles the same with PCL's own class.
#include <pcl/ModelCoefficients.h>
#include <pcl/PointIndices.h>
#include <pcl/point_cloud.h>
#include <pcl/point_types.h>
#include <pcl/sample_consensus/method_types.h>
#include <pcl/sample_consensus/model_types.h>

#include <cstddef>
#include <cstdio>

// [port]
#ifdef WITH_PCL
#include <pcl/segmentation/sac_segmentation.h>
using pcl::SACSegmentation;
#else
#include "fransac/pcl/sac_segmentation.hpp"
using fransac::pcl::SACSegmentation;
#endif
// [port]

namespace {

/// Twelve points one metre up, and three that are not.
pcl::PointCloud<pcl::PointXYZ>::Ptr some_points() {
  const pcl::PointCloud<pcl::PointXYZ>::Ptr cloud(new pcl::PointCloud<pcl::PointXYZ>);
  for (int i = 0; i < 15; ++i) {
    cloud->emplace_back(static_cast<float>(37 * i % 16) * 0.1F, static_cast<float>(53 * i % 17) * 0.1F, 1.0F);
  }
  (*cloud)[2].z = 2.0F;
  (*cloud)[7].z = -2.0F;
  (*cloud)[11].z = 4.0F;
  return cloud;
}

}  // namespace

int main() {
  const pcl::PointCloud<pcl::PointXYZ>::Ptr cloud = some_points();

  SACSegmentation<pcl::PointXYZ> segmentation;
  segmentation.setOptimizeCoefficients(true);
  segmentation.setModelType(pcl::SACMODEL_PLANE);
  segmentation.setMethodType(pcl::SAC_RANSAC);
  segmentation.setDistanceThreshold(0.01);
  segmentation.setInputCloud(cloud);

  pcl::PointIndices inliers;
  pcl::ModelCoefficients plane;
  segmentation.segment(inliers, plane);
  if (inliers.indices.empty()) {
    std::fprintf(stderr, "there is no plane\n");
    return 1;
  }
  std::printf("plane");
  for (const float value : plane.values) std::printf(" %g", static_cast<double>(value));
  std::printf(" inliers %zu\n", inliers.indices.size());
  for (const auto i : inliers.indices) {
    const pcl::PointXYZ& p = (*cloud)[static_cast<std::size_t>(i)];
    std::printf("%d: %g %g %g\n", i, static_cast<double>(p.x), static_cast<double>(p.y), static_cast<double>(p.z));
  }
}
