// SPDX-License-Identifier: Apache-2.0
// The voxel grid and the least-squares plane against PCL's, on a rendered and on a real frame.
#include <gtest/gtest.h>
#include <pcl/common/centroid.h>
#include <pcl/common/eigen.h>
#include <pcl/filters/voxel_grid.h>
#include <pcl/point_cloud.h>
#include <pcl/point_types.h>
#include <pcl/sample_consensus/sac_model_plane.h>

#include <cmath>
#include <filesystem>
#include <limits>
#include <map>
#include <set>
#include <vector>

#include "fransac/core/depth_image.hpp"
#include "fransac/filter/deproject.hpp"
#include "fransac/filter/voxel_grid.hpp"
#include "fransac/io/dataset.hpp"
#include "fransac/sac/plane_problem.hpp"
#include "fransac/synth/synth.hpp"
#include "support.hpp"

namespace fransac {
namespace {

PointCloud rendered_room() {
  const auto frame = synth::render({.scene = "office", .sensor = synth::Sensor::none, .seed = 1});
  EXPECT_TRUE(frame);
  PointCloud cloud;
  deproject(DepthView::from_float(frame->exact_depth_m.data(), frame->camera.width, frame->camera.height), frame->camera, cloud);
  return cloud;
}

PointCloud real_frame() {
  const auto files = io::list_frames(std::filesystem::path(FRANSAC_DATA_DIR) / "tum" / "scene4");
  if (!files) return {};
  const auto frame = io::load_frame(files->frames.front());
  EXPECT_TRUE(frame);
  PointCloud cloud;
  deproject(frame->view(), frame->camera, cloud);
  return cloud;
}

pcl::PointCloud<pcl::PointXYZ>::Ptr to_pcl(const PointCloud& cloud) {
  auto out = pcl::make_shared<pcl::PointCloud<pcl::PointXYZ>>();
  for (std::size_t i = 0; i < cloud.size(); ++i) out->emplace_back(cloud.x()[i], cloud.y()[i], cloud.z()[i]);
  return out;
}

/// Whether a point lies so near to a leaf's border that PCL's float arithmetic may put it on the other side. Depth in whole
/// units of 0.2 mm meets a border of 2 cm leaves at every hundredth value, so a real frame has many of these.
bool at_a_border(const PointCloud& cloud, std::size_t i, double leaf_size_m) {
  const Eigen::Array3d place = cloud.local(i).array() / leaf_size_m;
  constexpr double kFloatSteps = 4.0 * static_cast<double>(std::numeric_limits<float>::epsilon());
  return ((place - place.round()).abs() <= kFloatSteps * place.abs().max(1.0)).any();
}

void expect_the_same_leaves(const PointCloud& cloud) {
  constexpr double kLeaf = 0.02;
  VoxelGrid ours;
  ASSERT_TRUE(voxel_grid(cloud, kLeaf, LeafPoint::centroid, ours));
  pcl::VoxelGrid<pcl::PointXYZ> theirs;
  pcl::PointCloud<pcl::PointXYZ> their_leaves;
  const auto pcl_cloud = to_pcl(cloud);
  theirs.setInputCloud(pcl_cloud);
  theirs.setLeafSize(static_cast<float>(kLeaf), static_cast<float>(kLeaf), static_cast<float>(kLeaf));
  theirs.setSaveLeafLayout(true);
  theirs.filter(their_leaves);

  // Away from borders: two points share a leaf here exactly when they share one there.
  std::map<std::uint32_t, int> to_theirs;
  std::map<int, std::uint32_t> to_ours;
  std::set<std::uint32_t> ours_touched;  // leaves that a point at a border may have changed
  std::set<int> theirs_touched;
  std::size_t at_borders = 0;
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const std::uint32_t our_leaf = ours.leaf_of[i];
    const int their_leaf = theirs.getCentroidIndex((*pcl_cloud)[i]);
    if (at_a_border(cloud, i, kLeaf)) {
      ++at_borders;
      ours_touched.insert(our_leaf);
      theirs_touched.insert(their_leaf);
      continue;
    }
    ASSERT_EQ(to_theirs.emplace(our_leaf, their_leaf).first->second, their_leaf);
    ASSERT_EQ(to_ours.emplace(their_leaf, our_leaf).first->second, our_leaf);
  }
  EXPECT_LE(at_borders, cloud.size() / 50);
  EXPECT_NEAR(static_cast<double>(ours.leaves.size()), static_cast<double>(their_leaves.size()), static_cast<double>(at_borders));

  std::size_t compared = 0;
  for (const auto& [our_leaf, their_leaf] : to_theirs) {
    if (ours_touched.count(our_leaf) != 0 || theirs_touched.count(their_leaf) != 0) continue;
    const auto& their_point = their_leaves[static_cast<std::size_t>(their_leaf)];
    // PCL adds up in float: some ten roundings at up to 10 m.
    ASSERT_LT((ours.leaves.local(our_leaf) - their_point.getVector3fMap().cast<double>()).norm(), 1e-5);
    ++compared;
  }
  EXPECT_GT(compared, ours.leaves.size() / 2);
}

TEST(PclCross, VoxelGridOfARenderedRoom) { expect_the_same_leaves(rendered_room()); }

TEST(PclCross, VoxelGridOfARealFrame) {
  const PointCloud cloud = real_frame();
  if (cloud.empty()) GTEST_SKIP() << "no frames in " FRANSAC_DATA_DIR;
  expect_the_same_leaves(cloud);
}

void expect_the_same_fit(const PointCloud& cloud) {
  // A plane through some of the points, and what lies within 2 cm of it.
  const auto found = plane_through(cloud.local(100), cloud.local(20000), cloud.local(cloud.size() - 100));
  ASSERT_TRUE(found);
  const auto fit = sac::fit_plane(sac::CloudData(cloud).inlier_moments(*found, 0.02F));
  ASSERT_TRUE(fit);

  const auto pcl_cloud = to_pcl(cloud);
  pcl::Indices inliers;
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    if (std::abs(found->signed_distance(cloud.local(i))) <= 0.02) inliers.push_back(static_cast<int>(i));
  }
  EXPECT_NEAR(static_cast<double>(inliers.size()), static_cast<double>(fit->points), 3.0);  // float here, double there
  ASSERT_GT(inliers.size(), 100U);

  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  Eigen::Vector4d mean = Eigen::Vector4d::Zero();
  pcl::computeMeanAndCovarianceMatrix(*pcl_cloud, inliers, covariance, mean);
  Eigen::Vector3d normal;
  double smallest_variance = 0.0;
  pcl::eigen33(covariance, smallest_variance, normal);
  const Plane theirs = *make_plane(normal, -normal.dot(mean.head<3>()));
  EXPECT_LT(angle_between(fit->plane, theirs), 2e-6);
  EXPECT_NEAR(fit->plane.d, theirs.d, 5e-6);
  EXPECT_NEAR(fit->rms_m, std::sqrt(smallest_variance), 1e-6);

  // PCL's own refinement works in float.
  pcl::SampleConsensusModelPlane<pcl::PointXYZ> model(pcl_cloud);
  Eigen::VectorXf start(4);
  start << found->normal.cast<float>(), static_cast<float>(found->d);
  Eigen::VectorXf optimised(4);  // sized here: under AddressSanitizer Eigen allocates in another way than PCL was built with
  model.optimizeModelCoefficients(inliers, start, optimised);
  ASSERT_EQ(optimised.size(), 4);
  const Plane refined = *make_plane(optimised.head<3>().cast<double>(), static_cast<double>(optimised[3]));
  EXPECT_LT(angle_between(fit->plane, refined), 1e-3);
  EXPECT_NEAR(fit->plane.d, refined.d, 1e-3);
}

TEST(PclCross, LeastSquaresPlaneInARenderedRoom) { expect_the_same_fit(rendered_room()); }

TEST(PclCross, LeastSquaresPlaneInARealFrame) {
  const PointCloud cloud = real_frame();
  if (cloud.empty()) GTEST_SKIP() << "no frames in " FRANSAC_DATA_DIR;
  expect_the_same_fit(cloud);
}

}  // namespace
}  // namespace fransac
