// SPDX-License-Identifier: Apache-2.0
// The classes in the place of PCL's, with any parameters, on points of any numbers and indices that may be none: no exception,
// indices of the cloud's own points, each once, and coefficients of planes; the same every time.
#include <pcl/console/print.h>
#include <pcl/point_types.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include "draw.hpp"
#include "fransac/pcl/organized_multi_plane_segmentation.hpp"
#include "fransac/pcl/sac_segmentation.hpp"
#include "fransac/pcl/voxel_grid.hpp"
#include "require.hpp"

namespace {

using namespace fransac::fuzz;
using Point = pcl::PointXYZRGB;
using Cloud = pcl::PointCloud<Point>;

Cloud::Ptr draw_pcl_cloud(Bytes& bytes) {
  const fransac::PointCloud drawn = draw_cloud(bytes, draw_depth(bytes));
  Cloud::Ptr cloud(new Cloud);
  cloud->resize(drawn.size());
  for (std::size_t i = 0; i < drawn.size(); ++i) {
    Point& point = (*cloud)[i];
    point.x = drawn.x()[i];
    point.y = drawn.y()[i];
    point.z = drawn.z()[i];
    point.rgba = static_cast<std::uint32_t>(i);
  }
  if (drawn.organised() && static_cast<std::size_t>(drawn.width) * static_cast<std::size_t>(drawn.height) == drawn.size()) {
    cloud->width = static_cast<std::uint32_t>(drawn.width);
    cloud->height = static_cast<std::uint32_t>(drawn.height);
  }
  cloud->is_dense = draw_seldom(bytes);
  return cloud;
}

/// Some of the points, or what are none.
void draw_indices(Bytes& bytes, const Cloud& cloud, pcl::PCLBase<Point>& user) {
  if (bytes.ConsumeBool()) return;
  pcl::IndicesPtr indices(new pcl::Indices);
  const auto size = static_cast<pcl::index_t>(cloud.size());
  const auto first = bytes.ConsumeIntegralInRange<pcl::index_t>(0, size - 1);
  for (pcl::index_t i = first; i < size; ++i) indices->push_back(i);
  if (draw_seldom(bytes)) indices->push_back(bytes.ConsumeIntegral<pcl::index_t>());
  user.setIndices(indices);
}

void require_coefficients(const pcl::ModelCoefficients& coefficients) {
  require(coefficients.values.size() == 4);
  const float* const c = coefficients.values.data();
  require(std::abs(std::hypot(c[0], c[1], c[2]) - 1.0F) < 1e-5F && std::isfinite(c[3]) && c[3] >= 0.0F);
}

void require_indices(pcl::Indices indices, const Cloud& cloud) {
  std::sort(indices.begin(), indices.end());
  require(std::adjacent_find(indices.begin(), indices.end()) == indices.end());
  for (const pcl::index_t i : indices) {
    require(i >= 0 && static_cast<std::size_t>(i) < cloud.size());
    require(fransac::pcl::detail::is_finite(cloud[static_cast<std::size_t>(i)]));
  }
}

double draw_parameter(Bytes& bytes, double min, double max) {
  return draw_seldom(bytes) ? draw_any(bytes) : draw_number(bytes, min, max);
}

void check_sac(Bytes& bytes, const Cloud::Ptr& cloud) {
  fransac::pcl::SACSegmentation<Point> sac;
  sac.setInputCloud(cloud);
  sac.setModelType(bytes.PickValueInArray(
      {pcl::SACMODEL_PLANE, pcl::SACMODEL_PARALLEL_PLANE, pcl::SACMODEL_PERPENDICULAR_PLANE, pcl::SACMODEL_SPHERE}));
  sac.setMethodType(bytes.ConsumeIntegralInRange(0, 6));
  sac.setDistanceThreshold(draw_parameter(bytes, 0.0, 0.5));
  sac.setProbability(draw_parameter(bytes, 0.0, 1.0));
  sac.setMaxIterations(bytes.ConsumeIntegralInRange(-1, 200));
  sac.setOptimizeCoefficients(bytes.ConsumeBool());
  sac.setAxis(
      (draw_seldom(bytes) ? draw_any_vector(bytes) : draw_vector(bytes, 1.0)).cwiseMax(-1e38).cwiseMin(1e38).cast<float>());
  sac.setEpsAngle(draw_parameter(bytes, 0.0, 2.0));
  sac.setRandomSeed(bytes.ConsumeIntegral<std::uint8_t>());
  draw_indices(bytes, *cloud, sac);
  pcl::PointIndices inliers;
  pcl::ModelCoefficients coefficients;
  sac.segment(inliers, coefficients);
  if (coefficients.values.empty()) return require(inliers.indices.empty());
  require_coefficients(coefficients);
  pcl::Indices indices = inliers.indices;
  require_indices(indices, *cloud);
  sac.setNumberOfThreads(2);
  sac.segment(inliers, coefficients);
  require(indices == inliers.indices);
}

void check_grid(Bytes& bytes, const Cloud::Ptr& cloud) {
  fransac::pcl::VoxelGrid<Point> grid;
  grid.setInputCloud(cloud);
  const auto edge = [&] { return static_cast<float>(std::clamp(draw_parameter(bytes, 1e-3, 1.0), -1e38, 1e38)); };
  grid.setLeafSize(edge(), edge(), edge());
  grid.setDownsampleAllData(bytes.ConsumeBool());
  grid.setMinimumPointsNumberPerVoxel(bytes.ConsumeIntegralInRange(0U, 4U));
  grid.setFilterFieldName(bytes.PickValueInArray({"", "z", "rgb", "none"}));
  grid.setFilterLimits(draw_parameter(bytes, 0.0, 1.0), draw_parameter(bytes, 0.0, 10.0));
  grid.setFilterLimitsNegative(bytes.ConsumeBool());
  draw_indices(bytes, *cloud, grid);
  Cloud output;
  grid.filter(output);
  require(output.size() <= cloud->size());
  Cloud again;
  grid.setNumberOfThreads(2);
  grid.filter(again);
  require(output.size() == again.size());
  for (const Point& point : *cloud) {
    const int leaf = grid.getCentroidIndex(point);
    require(leaf >= -1 && leaf < static_cast<int>(output.size()));
  }
}

void check_planes(Bytes& bytes, const Cloud::Ptr& cloud) {
  fransac::pcl::OrganizedMultiPlaneSegmentation<Point> planes;
  planes.setInputCloud(cloud);
  planes.setMinInliers(bytes.ConsumeIntegralInRange(0U, 200U));
  planes.setProjectPoints(bytes.ConsumeBool());
  if (bytes.ConsumeBool()) planes.options() = draw_segment_options(bytes);
  draw_indices(bytes, *cloud, planes);
  decltype(planes)::Regions regions;
  decltype(planes)::Models models;
  decltype(planes)::IndexLists inliers;
  decltype(planes)::LabelsPtr labels;
  decltype(planes)::IndexLists label_indices;
  decltype(planes)::IndexLists boundaries;
  planes.segmentAndRefine(regions, models, inliers, labels, label_indices, boundaries);
  require(models.size() == inliers.size() && regions.size() == models.size() && boundaries.size() == models.size());
  require(labels->size() == cloud->size());
  for (std::size_t i = 0; i < models.size(); ++i) {
    require_coefficients(models[i]);
    require_indices(inliers[i].indices, *cloud);
    for (const pcl::index_t point : inliers[i].indices) require((*labels)[static_cast<std::size_t>(point)].label == i);
    for (const pcl::index_t point : boundaries[i].indices) require((*labels)[static_cast<std::size_t>(point)].label == i);
  }
}

}  // namespace

extern "C" int LLVMFuzzerInitialize(int* /*argc*/, char*** /*argv*/) {
  pcl::console::setVerbosityLevel(pcl::console::L_ALWAYS);
  return 0;
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  Bytes bytes(data, size);
  const int what = bytes.ConsumeIntegralInRange(0, 2);
  const Cloud::Ptr cloud = draw_pcl_cloud(bytes);
  if (what == 0) check_sac(bytes, cloud);
  if (what == 1) check_grid(bytes, cloud);
  if (what == 2) check_planes(bytes, cloud);
  return 0;
}
