// SPDX-License-Identifier: Apache-2.0
// The adapter, beside PCL's own classes where both have an answer.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <pcl/common/io.h>
#include <pcl/console/print.h>
#include <pcl/filters/voxel_grid.h>
#include <pcl/point_cloud.h>
#include <pcl/point_types.h>
#include <pcl/segmentation/sac_segmentation.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <map>
#include <numbers>
#include <set>
#include <string>
#include <tuple>
#include <vector>

#include "fransac/core/random.hpp"
#include "fransac/filter/deproject.hpp"
#include "fransac/pcl/organized_multi_plane_segmentation.hpp"
#include "fransac/pcl/sac_segmentation.hpp"
#include "fransac/pcl/voxel_grid.hpp"
#include "fransac/synth/synth.hpp"
#include "support.hpp"

/// A point type of a user's own, registered as PCL wants it.
struct LaserPoint {
  PCL_ADD_POINT4D;
  float intensity = 0.0F;
  std::uint16_t ring = 0;
  double time = 0.0;
  PCL_MAKE_ALIGNED_OPERATOR_NEW
};
POINT_CLOUD_REGISTER_POINT_STRUCT(LaserPoint,
                                  (float, x, x)(float, y, y)(float, z, z)(float, intensity, intensity)(std::uint16_t, ring,
                                                                                                       ring)(double, time, time))

namespace {

using Cloud = pcl::PointCloud<pcl::PointXYZ>;
using fransac::RandomStream;
using fransac::testing::test_random;
using fransac::testing::uniform;
using ::testing::ElementsAre;
using ::testing::IsEmpty;

constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();

/// PCL's console is silent while this lives.
struct Silence {
  Silence() : level(pcl::console::getVerbosityLevel()) { pcl::console::setVerbosityLevel(pcl::console::L_ALWAYS); }
  ~Silence() { pcl::console::setVerbosityLevel(level); }
  Silence(const Silence&) = delete;
  Silence& operator=(const Silence&) = delete;
  pcl::console::VERBOSITY_LEVEL level;
};

/// A floor 1.2 m below the camera with 6000 points, a wall 3 m ahead with 3000 and 1000 points anywhere; 3 mm of noise.
template <class PointT = pcl::PointXYZ>
typename pcl::PointCloud<PointT>::Ptr room() {
  RandomStream random = test_random();
  typename pcl::PointCloud<PointT>::Ptr cloud(new pcl::PointCloud<PointT>);
  const auto add = [&](double x, double y, double z) {
    PointT p;
    p.x = static_cast<float>(x);
    p.y = static_cast<float>(y);
    p.z = static_cast<float>(z);
    cloud->push_back(p);
  };
  for (int i = 0; i < 10000; ++i) {
    const double a = uniform(random, -1.5, 1.5);
    const double b = uniform(random, 0.0, 3.0);
    if (i % 10 < 6)
      add(a, 1.2 + 0.003 * random.normal(), b);
    else if (i % 10 < 9)
      add(a, 1.2 - 0.8 * b, 3.0 + 0.003 * random.normal());
    else
      add(a, uniform(random, -1.2, 1.2), b);
  }
  return cloud;
}

template <class Segmentation>
void set_up(Segmentation& segmentation, int method = pcl::SAC_RANSAC) {
  segmentation.setModelType(pcl::SACMODEL_PLANE);
  segmentation.setMethodType(method);
  segmentation.setDistanceThreshold(0.01);
  segmentation.setMaxIterations(1000);
  segmentation.setOptimizeCoefficients(true);
}

struct Answer {
  pcl::PointIndices inliers;
  pcl::ModelCoefficients plane;
};

template <class Segmentation>
Answer answer_of(Segmentation& segmentation) {
  Answer answer;
  segmentation.segment(answer.inliers, answer.plane);
  return answer;
}

/// Largest difference of coefficients, whichever way the normals point.
double difference(const pcl::ModelCoefficients& a, const pcl::ModelCoefficients& b) {
  if (a.values.size() != 4 || b.values.size() != 4) return std::numeric_limits<double>::infinity();
  const Eigen::Map<const Eigen::Vector4f> u(a.values.data());
  const Eigen::Map<const Eigen::Vector4f> v(b.values.data());
  return static_cast<double>(std::min((u - v).cwiseAbs().maxCoeff(), (u + v).cwiseAbs().maxCoeff()));
}

TEST(SacSegmentation, CoefficientsAreTheLeastSquaresFitWhateverItDoesToTheInliers) {
  // 3 mm of noise, a threshold far above it, and clutter that a tilted plane can have more of.
  for (std::uint64_t trial = 0; trial < 20; ++trial) {
    RandomStream random = test_random(trial);
    const Cloud::Ptr cloud(new Cloud);
    const auto add = [&](double x, double y, double z) {
      cloud->push_back({static_cast<float>(x), static_cast<float>(y), static_cast<float>(z)});
    };
    for (int i = 0; i < 4000; ++i) add(uniform(random, -1.0, 1.0), uniform(random, -1.0, 1.0), 1.5 + 0.003 * random.normal());
    for (int i = 0; i < 1000; ++i) add(uniform(random, -1.0, 1.0), uniform(random, -1.0, 1.0), uniform(random, 0.5, 2.5));
    fransac::pcl::SACSegmentation<pcl::PointXYZ> ours;
    set_up(ours);
    ours.setDistanceThreshold(0.1);
    ours.setInputCloud(cloud);
    const Answer found = answer_of(ours);
    ASSERT_EQ(found.plane.values.size(), 4U);
    EXPECT_GT(static_cast<double>(std::abs(found.plane.values[2])), std::cos(0.15 * std::numbers::pi / 180.0)) << trial;
    EXPECT_NEAR(static_cast<double>(found.plane.values[3]), 1.5, 2e-3) << trial;
  }
}

TEST(SacSegmentation, FindsThePlaneOfPcl) {
  const auto cloud = room();
  for (const int method : {pcl::SAC_RANSAC, pcl::SAC_MSAC, pcl::SAC_RRANSAC}) {
    fransac::pcl::SACSegmentation<pcl::PointXYZ> ours;
    set_up(ours, method);
    ours.setInputCloud(cloud);
    const Answer found = answer_of(ours);
    // PCL's R-RANSAC tests a tenth of all points beforehand and finds nothing; its RANSAC is what both are compared with.
    pcl::SACSegmentation<pcl::PointXYZ> theirs;
    set_up(theirs, method == pcl::SAC_RRANSAC ? pcl::SAC_RANSAC : method);
    theirs.setInputCloud(cloud);
    const Answer wanted = answer_of(theirs);
    EXPECT_LT(difference(found.plane, wanted.plane), 1e-2) << method;
    EXPECT_GE(found.inliers.indices.size(), wanted.inliers.indices.size()) << method;
    ASSERT_EQ(found.plane.values.size(), 4U);
    EXPECT_GT(found.plane.values[3], 0.0F);
    for (const auto i : found.inliers.indices) {
      const auto p = (*cloud)[static_cast<std::size_t>(i)];
      const double distance = static_cast<double>(found.plane.values[0] * p.x + found.plane.values[1] * p.y +
                                                  found.plane.values[2] * p.z + found.plane.values[3]);
      EXPECT_LE(std::abs(distance), 0.01 + 1e-6);
    }
    EXPECT_TRUE(std::is_sorted(found.inliers.indices.begin(), found.inliers.indices.end()));
  }
}

TEST(SacSegmentation, InliersAreAllPointsWithinTheThreshold) {
  const auto cloud = room();
  fransac::pcl::SACSegmentation<pcl::PointXYZ> segmentation;
  set_up(segmentation);
  segmentation.setInputCloud(cloud);
  const Answer found = answer_of(segmentation);
  ASSERT_EQ(found.plane.values.size(), 4U);
  std::size_t within = 0;
  std::size_t at_border = 0;
  for (const pcl::PointXYZ& p : *cloud) {
    const Eigen::Map<const Eigen::Vector4f> plane(found.plane.values.data());
    const double distance =
        std::abs(plane.head<3>().cast<double>().dot(p.getVector3fMap().cast<double>()) + plane.cast<double>()[3]);
    if (distance <= 0.01) ++within;
    if (std::abs(distance - 0.01) < 1e-6) ++at_border;
  }
  EXPECT_NEAR(static_cast<double>(found.inliers.indices.size()), static_cast<double>(within), static_cast<double>(at_border));
}

TEST(SacSegmentation, SameSeedSameAnswerAtAnyNumberOfThreads) {
  const auto cloud = room();
  fransac::pcl::SACSegmentation<pcl::PointXYZ> segmentation;
  set_up(segmentation);
  segmentation.setInputCloud(cloud);
  segmentation.setRandomSeed(7);
  const Answer first = answer_of(segmentation);
  for (const int threads : {0, 1, 3}) {
    segmentation.setNumberOfThreads(threads);
    const Answer again = answer_of(segmentation);
    EXPECT_EQ(first.plane.values, again.plane.values) << threads;
    EXPECT_EQ(first.inliers.indices, again.inliers.indices) << threads;
  }
}

TEST(SacSegmentation, AxesChooseThePlane) {
  const auto cloud = room();
  fransac::pcl::SACSegmentation<pcl::PointXYZ> segmentation;
  set_up(segmentation);
  segmentation.setInputCloud(cloud);
  segmentation.setEpsAngle(0.1);
  const auto normal = [&](int model, const Eigen::Vector3f& axis) {
    segmentation.setModelType(model);
    segmentation.setAxis(axis);
    const Answer found = answer_of(segmentation);
    return found.plane.values.size() == 4 ? Eigen::Vector3f(found.plane.values.data()) : Eigen::Vector3f::Zero();
  };
  const Eigen::Vector3f down = Eigen::Vector3f::UnitY();
  const Eigen::Vector3f ahead = Eigen::Vector3f::UnitZ();
  EXPECT_GT(std::abs(normal(pcl::SACMODEL_PERPENDICULAR_PLANE, 5.0F * down).y()), 0.999F);  // the floor
  EXPECT_GT(std::abs(normal(pcl::SACMODEL_PERPENDICULAR_PLANE, -ahead).z()), 0.999F);       // the wall
  EXPECT_GT(std::abs(normal(pcl::SACMODEL_PARALLEL_PLANE, down).z()), 0.999F);
  EXPECT_GT(std::abs(normal(pcl::SACMODEL_PARALLEL_PLANE, ahead).y()), 0.999F);
  const Silence silence;
  EXPECT_EQ(normal(pcl::SACMODEL_PERPENDICULAR_PLANE, Eigen::Vector3f::Zero()), Eigen::Vector3f::Zero());
  segmentation.setEpsAngle(0.0);  // as in PCL: no limit
  EXPECT_GT(std::abs(normal(pcl::SACMODEL_PERPENDICULAR_PLANE, ahead).y()), 0.999F);
}

TEST(SacSegmentation, NoPlaneOutsideTheAngle) {
  // All points on z = 2: nothing is upright.
  const Cloud::Ptr cloud(new Cloud);
  for (int i = 0; i < 400; ++i) cloud->emplace_back(static_cast<float>(i % 20), static_cast<float>(i / 20), 2.0F);
  fransac::pcl::SACSegmentation<pcl::PointXYZ> segmentation;
  set_up(segmentation);
  segmentation.setModelType(pcl::SACMODEL_PERPENDICULAR_PLANE);
  segmentation.setAxis(Eigen::Vector3f::UnitX());
  segmentation.setEpsAngle(0.2);
  segmentation.setInputCloud(cloud);
  const Silence silence;
  const Answer found = answer_of(segmentation);
  EXPECT_THAT(found.plane.values, IsEmpty());
  EXPECT_THAT(found.inliers.indices, IsEmpty());
}

TEST(SacSegmentation, IndicesAndPointsThatAreNotFinite) {
  const auto cloud = room();
  cloud->is_dense = false;
  for (std::size_t i = 0; i < cloud->size(); i += 7) (*cloud)[i].y = kNaN;
  const pcl::PointIndices::Ptr wall(new pcl::PointIndices);
  for (int i = 0; i < static_cast<int>(cloud->size()); ++i) {
    if (i % 10 >= 6 && i % 10 < 9) wall->indices.push_back(i);
  }
  std::reverse(wall->indices.begin(), wall->indices.end());
  wall->indices.push_back(-1);
  wall->indices.push_back(1 << 30);
  fransac::pcl::SACSegmentation<pcl::PointXYZ> segmentation;
  set_up(segmentation);
  segmentation.setInputCloud(cloud);
  segmentation.setIndices(wall);
  const Answer found = answer_of(segmentation);
  ASSERT_EQ(found.plane.values.size(), 4U);
  EXPECT_NEAR(static_cast<double>(found.plane.values[3]), 3.0, 0.01);
  EXPECT_GT(found.inliers.indices.size(), 2500U);
  EXPECT_TRUE(std::is_sorted(found.inliers.indices.rbegin(), found.inliers.indices.rend()));
  for (const int i : found.inliers.indices) {
    EXPECT_TRUE(i % 10 >= 6 && i % 10 < 9);
    EXPECT_TRUE(std::isfinite((*cloud)[static_cast<std::size_t>(i)].y));
  }
}

TEST(SacSegmentation, ADenseCloudThatIsNotFinite) {
  const auto cloud = room();
  (*cloud)[17].x = kNaN;
  (*cloud)[23].z = std::numeric_limits<float>::infinity();
  fransac::pcl::SACSegmentation<pcl::PointXYZ> segmentation;
  set_up(segmentation);
  segmentation.setInputCloud(cloud);
  const Answer found = answer_of(segmentation);
  EXPECT_GT(found.inliers.indices.size(), 5500U);
}

TEST(SacSegmentation, AnyPointType) {
  const auto plain = room();
  fransac::pcl::SACSegmentation<pcl::PointXYZ> of_plain;
  set_up(of_plain);
  of_plain.setInputCloud(plain);
  const Answer wanted = answer_of(of_plain);
  const auto check = [&](auto point) {
    using PointT = decltype(point);
    fransac::pcl::SACSegmentation<PointT> segmentation;
    set_up(segmentation);
    segmentation.setInputCloud(room<PointT>());
    const Answer found = answer_of(segmentation);
    EXPECT_EQ(found.plane.values, wanted.plane.values);
    EXPECT_EQ(found.inliers.indices, wanted.inliers.indices);
  };
  check(LaserPoint{});
  check(pcl::PointXYZRGBNormal{});
}

/// A tabletop and a floor below it of nearly the same size, noise of half the threshold, and points on neither.
Cloud::Ptr two_planes(int larger, int smaller, int others) {
  RandomStream random = test_random();
  const Cloud::Ptr cloud(new Cloud);
  const auto side = [&] { return static_cast<float>(uniform(random, -1.0, 1.0)); };
  const auto noise = [&] { return static_cast<float>(0.005 * random.normal()); };
  for (int i = 0; i < larger; ++i) cloud->emplace_back(side(), 0.5F + noise(), 2.0F + side());
  for (int i = 0; i < smaller; ++i) cloud->emplace_back(side(), 1.2F + noise(), 2.0F + side());
  for (int i = 0; i < others; ++i) cloud->emplace_back(side(), side(), 2.0F + side());
  return cloud;
}

TEST(SacSegmentation, TheLargestPlaneWithTheProbabilityAskedFor) {
  fransac::pcl::SACSegmentation<pcl::PointXYZ> segmentation;
  set_up(segmentation);
  segmentation.setInputCloud(two_planes(5600, 5200, 9200));
  int missed = 0;
  for (std::uint64_t seed = 0; seed < 200; ++seed) {
    segmentation.setRandomSeed(seed);
    const Answer found = answer_of(segmentation);
    ASSERT_EQ(found.plane.values.size(), 4U);
    missed += std::abs(found.plane.values[3] - 0.5F) > 0.1F ? 1 : 0;
  }
  EXPECT_LE(missed, 4);  // two are to be expected at p = 0.99
}

TEST(SacSegmentation, EveryPlaneOfACloudBesidePclOnTheSamePoints) {
  // Who takes more of the first plane leaves fewer points near it for the second: both therefore get what ours left over.
  Cloud::Ptr cloud = two_planes(40000, 25000, 6000);
  for (int plane = 0; plane < 2; ++plane) {
    fransac::pcl::SACSegmentation<pcl::PointXYZ> ours;
    pcl::SACSegmentation<pcl::PointXYZ> theirs;
    set_up(ours);
    set_up(theirs);
    ours.setInputCloud(cloud);
    theirs.setInputCloud(cloud);
    const Answer found = answer_of(ours);
    const Answer wanted = answer_of(theirs);
    EXPECT_LT(difference(found.plane, wanted.plane), 1e-2);
    EXPECT_GE(found.inliers.indices.size(), wanted.inliers.indices.size());
    std::set<int> taken(found.inliers.indices.begin(), found.inliers.indices.end());
    const Cloud::Ptr rest(new Cloud);
    for (int i = 0; i < static_cast<int>(cloud->size()); ++i) {
      if (taken.count(i) == 0) rest->push_back((*cloud)[static_cast<std::size_t>(i)]);
    }
    cloud = rest;
  }
}

TEST(SacSegmentation, WhatMeansNothingForPlanesIsKept) {
  fransac::pcl::SACSegmentation<pcl::PointXYZ> ours;
  pcl::SACSegmentation<pcl::PointXYZ> theirs;
  double low = 0.0;
  double high = 0.0;
  double pcl_low = 1.0;
  double pcl_high = 1.0;
  ours.getRadiusLimits(low, high);
  theirs.getRadiusLimits(pcl_low, pcl_high);
  EXPECT_EQ(low, pcl_low);
  EXPECT_EQ(high, pcl_high);
  ours.setRadiusLimits(0.1, 0.2);
  ours.getRadiusLimits(low, high);
  EXPECT_EQ(low, 0.1);
  EXPECT_EQ(high, 0.2);
  ours.setSamplesMaxDist(0.3, nullptr);
  ours.getSamplesMaxDist(low);
  EXPECT_EQ(low, 0.3);
}

TEST(SacSegmentation, WhatCannotBeDoneLeavesNothingBehind) {
  const Silence silence;
  const auto check = [](const char* what, const auto& change) {
    fransac::pcl::SACSegmentation<pcl::PointXYZ> segmentation;
    set_up(segmentation);
    segmentation.setInputCloud(room());
    change(segmentation);
    Answer answer;
    answer.inliers.indices = {1, 2, 3};
    answer.plane.values = {1.0F};
    segmentation.segment(answer.inliers, answer.plane);
    EXPECT_THAT(answer.inliers.indices, IsEmpty()) << what;
    EXPECT_THAT(answer.plane.values, IsEmpty()) << what;
  };
  check("a sphere", [](auto& s) { s.setModelType(pcl::SACMODEL_SPHERE); });
  check("LMedS", [](auto& s) { s.setMethodType(pcl::SAC_LMEDS); });
  check("a negative threshold", [](auto& s) { s.setDistanceThreshold(-1.0); });
  check("a threshold that is no number", [](auto& s) { s.setDistanceThreshold(std::numeric_limits<double>::quiet_NaN()); });
  check("certainty", [](auto& s) { s.setProbability(1.0); });
  check("no iterations", [](auto& s) { s.setMaxIterations(0); });
  check("no cloud", [](auto& s) { s.setInputCloud(nullptr); });
  check("two points", [](auto& s) { s.setIndices(pcl::IndicesPtr(new pcl::Indices{0, 1})); });
  check("no points", [](auto& s) { s.setInputCloud(Cloud::Ptr(new Cloud)); });
}

// ---- voxel grid ----

template <class PointT>
pcl::PointCloud<PointT> filtered(pcl::Filter<PointT>& filter, const typename pcl::PointCloud<PointT>::ConstPtr& cloud) {
  pcl::PointCloud<PointT> output;
  filter.setInputCloud(cloud);
  filter.filter(output);
  return output;
}

/// Points by value, rounded to a tenth of a millimetre.
std::multiset<std::array<int, 3>> rounded(const Cloud& cloud) {
  std::multiset<std::array<int, 3>> points;
  for (const pcl::PointXYZ& p : cloud) {
    points.insert({static_cast<int>(std::lround(p.x * 1e4F)), static_cast<int>(std::lround(p.y * 1e4F)),
                   static_cast<int>(std::lround(p.z * 1e4F))});
  }
  return points;
}

/// Points in the middle of sixteenths of a unit: none lies at a leaf's border, and sums of them are exact.
Cloud::Ptr lattice_points(int count) {
  RandomStream random = test_random();
  const Cloud::Ptr cloud(new Cloud);
  const auto coordinate = [&] { return (static_cast<float>(random.below(128)) - 64.0F + 0.5F) / 16.0F; };
  for (int i = 0; i < count; ++i) {
    const float x = coordinate();
    const float y = coordinate();
    cloud->emplace_back(x, y, coordinate());
  }
  return cloud;
}

TEST(VoxelGrid, LeavesOfPcl) {
  const Cloud::Ptr cloud = lattice_points(5000);
  for (const Eigen::Vector3f& leaf : {Eigen::Vector3f(1, 1, 1), Eigen::Vector3f(0.5F, 2, 4), Eigen::Vector3f(4, 0.25F, 1)}) {
    for (const unsigned fewest : {0U, 3U}) {
      fransac::pcl::VoxelGrid<pcl::PointXYZ> ours;
      pcl::VoxelGrid<pcl::PointXYZ> theirs;
      for (const auto& set : {std::pair{-10.0, 10.0}, std::pair{-1.0, 2.5}}) {
        const auto configure = [&](auto& grid) {
          grid.setLeafSize(leaf.x(), leaf.y(), leaf.z());
          grid.setMinimumPointsNumberPerVoxel(fewest);
          grid.setFilterFieldName("y");
          grid.setFilterLimits(set.first, set.second);
          grid.setFilterLimitsNegative(set.first == -1.0);
          grid.setSaveLeafLayout(true);
        };
        configure(ours);
        configure(theirs);
        const Cloud found = filtered(ours, cloud);
        const Cloud wanted = filtered(theirs, cloud);
        ASSERT_GT(wanted.size(), 10U);
        EXPECT_EQ(rounded(found), rounded(wanted));
        EXPECT_EQ(found.width, wanted.width);
        EXPECT_EQ(found.height, 1U);
        EXPECT_EQ(ours.getMinBoxCoordinates(), theirs.getMinBoxCoordinates());
        EXPECT_EQ(ours.getMaxBoxCoordinates(), theirs.getMaxBoxCoordinates());
        EXPECT_EQ(ours.getNrDivisions(), theirs.getNrDivisions());
        EXPECT_EQ(ours.getDivisionMultiplier(), theirs.getDivisionMultiplier());
        const std::vector<int> layout = ours.getLeafLayout();
        const std::vector<int> pcl_layout = theirs.getLeafLayout();
        ASSERT_EQ(layout.size(), pcl_layout.size());
        for (std::size_t i = 0; i < layout.size(); ++i) ASSERT_EQ(layout[i] < 0, pcl_layout[i] < 0);
        // Every point's leaf is the point of the output that PCL has there.
        for (const pcl::PointXYZ& p : *cloud) {
          const Eigen::Vector3i place = ours.getGridCoordinates(p.x, p.y, p.z);
          ASSERT_EQ(place, theirs.getGridCoordinates(p.x, p.y, p.z));
          const int mine = ours.getCentroidIndexAt(place);
          const bool in_box = (place.array() >= theirs.getMinBoxCoordinates().array()).all() &&
                              (place.array() <= theirs.getMaxBoxCoordinates().array()).all();
          const int pcls = in_box ? theirs.getCentroidIndex(p) : -1;
          ASSERT_EQ(mine < 0, pcls < 0);
          ASSERT_EQ(mine, ours.getCentroidIndex(p));
          if (mine < 0) continue;
          const Eigen::Vector3f there = found[static_cast<std::size_t>(mine)].getVector3fMap();
          EXPECT_LT((there - wanted[static_cast<std::size_t>(pcls)].getVector3fMap()).norm(), 1e-5F);
        }
      }
    }
  }
}

TEST(VoxelGrid, NeighboursAreThoseOfPcl) {
  const Cloud::Ptr cloud = lattice_points(300);
  fransac::pcl::VoxelGrid<pcl::PointXYZ> ours;
  pcl::VoxelGrid<pcl::PointXYZ> theirs;
  ours.setLeafSize(1, 1, 1);
  theirs.setLeafSize(1, 1, 1);
  theirs.setSaveLeafLayout(true);
  const Cloud found = filtered(ours, cloud);
  const Cloud wanted = filtered(theirs, cloud);
  Eigen::MatrixXi steps(3, 4);
  steps.transpose() << 0, 0, 0, 1, 0, 0, 0, -1, 1, 9, 0, 0;
  for (const pcl::PointXYZ& p : *cloud) {
    const std::vector<int> a = ours.getNeighborCentroidIndices(p, steps);
    const std::vector<int> b = theirs.getNeighborCentroidIndices(p, steps);
    ASSERT_EQ(a.size(), b.size());
    for (std::size_t i = 0; i < a.size(); ++i) {
      ASSERT_EQ(a[i] < 0, b[i] < 0);
      if (a[i] < 0) continue;
      const Eigen::Vector3f there = found[static_cast<std::size_t>(a[i])].getVector3fMap();
      EXPECT_LT((there - wanted[static_cast<std::size_t>(b[i])].getVector3fMap()).norm(), 1e-5F);
    }
  }
}

TEST(VoxelGrid, WherePclGivesUp) {
  // Ten kilometres in leaves of one millimetre: 10^7 along two axes, which no 32-bit number counts.
  const Cloud::Ptr cloud(new Cloud);
  cloud->emplace_back(0.0001F, 0.0001F, 0.0001F);
  cloud->emplace_back(0.0003F, 0.0001F, 0.0001F);
  cloud->emplace_back(10000.0F, 10000.0F, 10000.0F);
  fransac::pcl::VoxelGrid<pcl::PointXYZ> ours;
  pcl::VoxelGrid<pcl::PointXYZ> theirs;
  ours.setLeafSize(0.001F, 0.001F, 1.0F);
  theirs.setLeafSize(0.001F, 0.001F, 1.0F);
  const Silence silence;
  EXPECT_EQ(filtered(theirs, cloud).size(), 3U);  // its input
  const Cloud found = filtered(ours, cloud);
  ASSERT_EQ(found.size(), 2U);
  EXPECT_NEAR(static_cast<double>(found[0].x), 0.0002, 1e4 * 0x1p-30);
  EXPECT_EQ(found[1].z, 10000.0F);
  EXPECT_EQ(ours.getCentroidIndex((*cloud)[1]), 0);
  EXPECT_EQ(ours.getCentroidIndex((*cloud)[2]), 1);
  EXPECT_EQ(ours.getCentroidIndex(pcl::PointXYZ(5000.0F, 5000.0F, 5000.0F)), -1);
  EXPECT_EQ(ours.getCentroidIndex(pcl::PointXYZ(-1e30F, 1e30F, 0.0F)), -1);
  EXPECT_EQ(ours.getCentroidIndex(pcl::PointXYZ(kNaN, 0.0F, 0.0F)), -1);
}

TEST(VoxelGrid, BeyondSixtyThreeBitsTheInputComesBack) {
  const Cloud::Ptr cloud(new Cloud);
  cloud->emplace_back(0.0F, 0.0F, 0.0F);
  cloud->emplace_back(1e9F, 1e9F, 1e9F);
  fransac::pcl::VoxelGrid<pcl::PointXYZ> grid;
  grid.setLeafSize(0.5F, 0.5F, 0.5F);
  const Silence silence;
  EXPECT_EQ(filtered(grid, cloud).size(), 2U);
  EXPECT_EQ(grid.getCentroidIndex((*cloud)[0]), -1);
  grid.setLeafSize(0.0F, 1.0F, 1.0F);
  EXPECT_THAT(filtered(grid, cloud), IsEmpty());
  grid.setLeafSize(1.0F, 1.0F, 1.0F);
  grid.setFilterFieldName("colour");
  EXPECT_THAT(filtered(grid, cloud), IsEmpty());
}

TEST(VoxelGrid, AveragesAllFieldsAsPcl) {
  RandomStream random = test_random();
  const pcl::PointCloud<pcl::PointXYZRGBNormal>::Ptr cloud(new pcl::PointCloud<pcl::PointXYZRGBNormal>);
  const Cloud::Ptr places = lattice_points(500);
  for (const pcl::PointXYZ& place : *places) {
    pcl::PointXYZRGBNormal p;
    p.getVector3fMap() = place.getVector3fMap();
    p.r = static_cast<std::uint8_t>(random.below(256));
    p.g = static_cast<std::uint8_t>(random.below(256));
    p.a = 255;
    p.getNormalVector3fMap() = Eigen::Vector3f(1.0F, static_cast<float>(random.uniform()), 0.0F).normalized();
    p.curvature = static_cast<float>(random.uniform());
    cloud->push_back(p);
  }
  fransac::pcl::VoxelGrid<pcl::PointXYZRGBNormal> ours;
  pcl::VoxelGrid<pcl::PointXYZRGBNormal> theirs;
  ours.setLeafSize(2, 2, 2);
  theirs.setLeafSize(2, 2, 2);
  theirs.setSaveLeafLayout(true);
  const auto found = filtered(ours, cloud);
  const auto wanted = filtered(theirs, cloud);
  ASSERT_EQ(found.size(), wanted.size());
  ASSERT_LT(found.size(), 100U);
  for (const auto& p : *cloud) {
    const auto& a = found[static_cast<std::size_t>(ours.getCentroidIndex(p))];
    const auto& b = wanted[static_cast<std::size_t>(theirs.getCentroidIndex(p))];
    EXPECT_LT((a.getVector3fMap() - b.getVector3fMap()).norm(), 1e-5F);
    EXPECT_LT((a.getNormalVector3fMap() - b.getNormalVector3fMap()).norm(), 1e-5F);
    EXPECT_NEAR(static_cast<double>(a.curvature), static_cast<double>(b.curvature), 1e-5);
    EXPECT_LE(std::abs(a.r - b.r), 1);
    EXPECT_LE(std::abs(a.g - b.g), 1);
  }
  ours.setDownsampleAllData(false);
  for (const auto& p : filtered(ours, cloud)) EXPECT_EQ(p.curvature, 0.0F);
}

TEST(VoxelGrid, AveragesFieldsOfAnyTypeAndFiltersByThem) {
  const pcl::PointCloud<LaserPoint>::Ptr cloud(new pcl::PointCloud<LaserPoint>);
  for (int i = 0; i < 4; ++i) {
    LaserPoint p;
    p.x = p.y = p.z = 0.25F + 0.125F * static_cast<float>(i % 2);
    p.intensity = static_cast<float>(i);
    p.ring = static_cast<std::uint16_t>(65000 + 2 * i);
    p.time = 1e9 + 0.25 * i;
    cloud->push_back(p);
  }
  fransac::pcl::VoxelGrid<LaserPoint> grid;
  grid.setLeafSize(1, 1, 1);
  const auto all = filtered(grid, cloud);
  ASSERT_EQ(all.size(), 1U);
  EXPECT_EQ(all[0].x, 0.3125F);
  EXPECT_EQ(all[0].intensity, 1.5F);
  EXPECT_EQ(all[0].ring, 65003);
  EXPECT_EQ(all[0].time, 1e9 + 0.375);
  grid.setFilterFieldName("ring");
  grid.setFilterLimits(65002, 65004);
  const auto two = filtered(grid, cloud);
  ASSERT_EQ(two.size(), 1U);
  EXPECT_EQ(two[0].ring, 65003);
  EXPECT_EQ(two[0].time, 1e9 + 0.375);
  grid.setFilterLimitsNegative(true);  // the limits themselves stay
  EXPECT_EQ(filtered(grid, cloud)[0].intensity, 1.5F);
}

TEST(VoxelGrid, SameLeavesWhereverThePointsAreRead) {
  // In place, gathered by indices, and in place around points that are not finite.
  const Cloud::Ptr cloud = lattice_points(3000);
  fransac::pcl::VoxelGrid<pcl::PointXYZ> grid;
  grid.setLeafSize(1, 1, 1);
  const std::multiset<std::array<int, 3>> wanted = rounded(filtered(grid, cloud));
  const Cloud::Ptr holes(new Cloud);
  const pcl::IndicesPtr indices(new pcl::Indices);
  for (const pcl::PointXYZ& p : *cloud) {
    indices->push_back(static_cast<int>(indices->size()));
    holes->push_back(p);
    if (indices->size() % 3 == 0) holes->emplace_back(p.x, kNaN, p.z);
  }
  holes->is_dense = false;
  EXPECT_EQ(rounded(filtered(grid, holes)), wanted);
  EXPECT_EQ(grid.getCentroidIndex(holes->front()), 0);
  grid.setIndices(indices);
  EXPECT_EQ(rounded(filtered(grid, cloud)), wanted);
  pcl::PointCloud<pcl::PointXYZI>::Ptr with_intensity(new pcl::PointCloud<pcl::PointXYZI>);
  pcl::copyPointCloud(*holes, *with_intensity);
  for (std::size_t i = 0; i < with_intensity->size(); ++i) (*with_intensity)[i].intensity = (*with_intensity)[i].x;
  fransac::pcl::VoxelGrid<pcl::PointXYZI> with_fields;
  with_fields.setLeafSize(1, 1, 1);
  const auto found = filtered(with_fields, with_intensity);
  EXPECT_EQ(found.size(), wanted.size());
  for (const pcl::PointXYZI& p : found) EXPECT_NEAR(static_cast<double>(p.intensity), static_cast<double>(p.x), 1e-5);
}

TEST(VoxelGrid, IndicesAndPointsThatAreNotFinite) {
  const Cloud::Ptr cloud(new Cloud);
  cloud->emplace_back(0.25F, 0.25F, 0.25F);
  cloud->emplace_back(kNaN, 0.0F, 0.0F);
  cloud->emplace_back(0.75F, 0.25F, 0.25F);
  cloud->emplace_back(5.5F, 0.25F, 0.25F);
  fransac::pcl::VoxelGrid<pcl::PointXYZ> grid;
  grid.setLeafSize(1, 1, 1);
  EXPECT_EQ(filtered(grid, cloud).size(), 2U);
  grid.setIndices(pcl::IndicesPtr(new pcl::Indices{0, 1, 99, -3}));
  const Cloud found = filtered(grid, cloud);
  ASSERT_EQ(found.size(), 1U);
  EXPECT_EQ(found[0].x, 0.25F);
}

// ---- planes of organised clouds ----

Cloud::Ptr rendered(const std::string& scene) {
  const auto frame = fransac::synth::render({.scene = scene, .sensor = fransac::synth::Sensor::none, .seed = 1});
  EXPECT_TRUE(frame);
  const fransac::Camera& camera = frame->camera;
  const Cloud::Ptr cloud(new Cloud(static_cast<std::uint32_t>(camera.width), static_cast<std::uint32_t>(camera.height)));
  cloud->is_dense = false;
  std::size_t i = 0;
  for (int v = 0; v < camera.height; ++v) {
    for (int u = 0; u < camera.width; ++u, ++i) {
      const double z = static_cast<double>(frame->exact_depth_m[i]);
      const bool measured = z > 0.0 && i % 1009 != 0;
      (*cloud)[i] = measured ? pcl::PointXYZ(static_cast<float>(z * (u - camera.cx) / camera.fx),
                                             static_cast<float>(z * (v - camera.cy) / camera.fy), static_cast<float>(z))
                             : pcl::PointXYZ(kNaN, kNaN, kNaN);
    }
  }
  return cloud;
}

TEST(OrganizedMultiPlane, PlanesLabelsAndContoursBelongTogether) {
  const Cloud::Ptr cloud = rendered("office");
  fransac::pcl::OrganizedMultiPlaneSegmentation<pcl::PointXYZ> segmentation;
  segmentation.setInputCloud(cloud);
  decltype(segmentation)::Regions regions;
  std::vector<pcl::ModelCoefficients> models;
  std::vector<pcl::PointIndices> inliers;
  std::vector<pcl::PointIndices> label_indices;
  std::vector<pcl::PointIndices> boundaries;
  pcl::PointCloud<pcl::Label>::Ptr labels(new pcl::PointCloud<pcl::Label>);
  segmentation.segmentAndRefine(regions, models, inliers, labels, label_indices, boundaries);
  ASSERT_GE(models.size(), 3U);
  ASSERT_EQ(inliers.size(), models.size());
  ASSERT_EQ(regions.size(), models.size());
  ASSERT_EQ(boundaries.size(), models.size());
  ASSERT_EQ(labels->size(), cloud->size());
  EXPECT_EQ(labels->width, cloud->width);
  std::size_t labelled = 0;
  for (std::size_t plane = 0; plane < models.size(); ++plane) {
    const Eigen::Map<const Eigen::Vector4f> model(models[plane].values.data());
    EXPECT_NEAR(static_cast<double>(model.head<3>().norm()), 1.0, 1e-6);
    EXPECT_GE(model[3], 0.0F);
    EXPECT_GE(inliers[plane].indices.size(), segmentation.getMinInliers());
    EXPECT_EQ(regions[plane].getCount(), inliers[plane].indices.size());
    EXPECT_EQ(regions[plane].getCoefficients(), model);
    EXPECT_LT(std::abs(model.head<3>().dot(regions[plane].getCentroid()) + model[3]), 0.01F);
    labelled += inliers[plane].indices.size();
    for (const auto i : inliers[plane].indices) {
      const auto pixel = static_cast<std::size_t>(i);
      ASSERT_EQ((*labels)[pixel].label, plane);
      ASSERT_LT(std::abs(model.head<3>().dot((*cloud)[pixel].getVector3fMap()) + model[3]), 0.05F);
    }
    // A boundary pixel is on the plane and has a neighbour that is not, or is at the image's border.
    ASSERT_GT(boundaries[plane].indices.size(), 8U);
    EXPECT_EQ(regions[plane].getContour().size(), boundaries[plane].indices.size());
    for (const auto i : boundaries[plane].indices) {
      const int u = i % static_cast<int>(cloud->width);
      const int v = i / static_cast<int>(cloud->width);
      ASSERT_EQ((*labels)[static_cast<std::size_t>(i)].label, plane);
      bool inside = true;
      for (int dv = -1; dv <= 1; ++dv) {
        for (int du = -1; du <= 1; ++du) {
          const bool in_image =
              u + du >= 0 && v + dv >= 0 && u + du < static_cast<int>(cloud->width) && v + dv < static_cast<int>(cloud->height);
          inside = inside && in_image && cloud->at(u, v).z == cloud->at(u, v).z && labels->at(u + du, v + dv).label == plane;
        }
      }
      EXPECT_FALSE(inside) << u << ", " << v;
    }
  }
  EXPECT_EQ(labelled, static_cast<std::size_t>(std::count_if(labels->begin(), labels->end(), [](const pcl::Label& l) {
              return l.label != decltype(segmentation)::kNoPlane;
            })));
  EXPECT_GT(labelled, cloud->size() / 2);

  const std::vector<pcl::PointIndices> found = inliers;
  segmentation.refine(models, inliers, labels, label_indices);
  for (std::size_t plane = 0; plane < found.size(); ++plane) EXPECT_EQ(inliers[plane].indices, found[plane].indices);

  segmentation.setProjectPoints(true);
  segmentation.segment(regions);
  for (std::size_t plane = 0; plane < regions.size(); ++plane) {
    const Eigen::Vector4f model = regions[plane].getCoefficients();
    for (const pcl::PointXYZ& p : regions[plane].getContour()) {
      EXPECT_LT(std::abs(model.head<3>().dot(p.getVector3fMap()) + model[3]), 1e-4F);
    }
  }

  segmentation.setMinInliers(static_cast<unsigned>(inliers[0].indices.size()));
  segmentation.segment(models, inliers);
  for (const pcl::PointIndices& plane : inliers) EXPECT_GE(plane.indices.size(), segmentation.getMinInliers());
}

TEST(OrganizedMultiPlane, WhatNoCameraTookIsRefused) {
  const Silence silence;
  fransac::pcl::OrganizedMultiPlaneSegmentation<pcl::PointXYZ> segmentation;
  std::vector<pcl::ModelCoefficients> models(2);
  std::vector<pcl::PointIndices> inliers(2);
  segmentation.setInputCloud(room());
  segmentation.segment(models, inliers);
  EXPECT_THAT(models, IsEmpty());
  EXPECT_THAT(inliers, IsEmpty());
  segmentation.setInputCloud(nullptr);
  decltype(segmentation)::Regions regions(2);
  segmentation.segmentAndRefine(regions);
  EXPECT_TRUE(regions.empty());
}

}  // namespace
