// SPDX-License-Identifier: Apache-2.0
// The pixels of a depth image as data of a plane search: the same as the points of the deprojected cloud.
#include "planes/depth_data.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <map>
#include <type_traits>
#include <vector>

#include "bail_out.hpp"
#include "fransac/filter/deproject.hpp"
#include "support.hpp"

namespace fransac {
namespace {

using Eigen::Vector3d;

constexpr sac::Score kNothingToBeat{-1.0, 0};
constexpr sac::Scoring kScorings[] = {sac::Scoring::inliers, sac::Scoring::msac};

/// A depth image of either format that owns its pixels, and its data.
template <class Raw>
struct Frame {
  static constexpr double kScale = std::is_same_v<Raw, float> ? 1.0 : 5000.0;

  Frame(int width, int height)
      : camera(testing::small_camera(width, height)), raw(static_cast<std::size_t>(width) * static_cast<std::size_t>(height)) {
    camera.fx = 0.8 * width + 1.0;
    camera.fy = 0.82 * width + 1.0;
  }
  /// A slope with noise, pixels anywhere, and holes.
  Frame(int width, int height, const Plane& plane, RandomStream& random) : Frame(width, height) {
    for (int v = 0; v < height; ++v) {
      for (int u = 0; u < width; ++u) {
        const std::uint32_t kind = random.below(5);
        const double z = testing::depth_on(plane, camera, u, v) + 0.004 * random.normal();
        set(u, v, kind == 0 || z > 6.0 ? 0.0 : kind == 1 ? testing::uniform(random, 0.5, 4.0) : z);
      }
    }
  }
  void set(int u, int v, double z) {
    raw[static_cast<std::size_t>(v) * static_cast<std::size_t>(camera.width) + static_cast<std::size_t>(u)] =
        static_cast<Raw>(std::clamp(z * kScale, 0.0, 65535.0));
  }
  [[nodiscard]] DepthView view() const {
    if constexpr (std::is_same_v<Raw, float>) {
      return DepthView::from_float(raw.data(), camera.width, camera.height);
    } else {
      return DepthView::from_uint16(raw.data(), camera.width, camera.height, kScale);
    }
  }
  [[nodiscard]] PointCloud cloud(const AxisLimits* limits = nullptr) const {
    PointCloud points;
    deproject(view(), camera, points);
    if (limits != nullptr) pass_through(*limits, points);
    return points;
  }

  Camera camera;
  std::vector<Raw> raw;
};

/// DepthData with what it refers to.
template <class Raw>
struct Data {
  explicit Data(const Frame<Raw>& frame, const AxisLimits* limits = nullptr, int threads = 1)
      : view(frame.view()), rows(view, frame.camera, limits), data(rows, threads, buffers) {}
  DepthView view;
  DepthRows<Raw> rows;
  DepthDataBuffers buffers;
  DepthData<Raw> data;
};

template <class Raw>
class DepthDataTest : public ::testing::Test {};
using RawTypes = ::testing::Types<std::uint16_t, float>;
TYPED_TEST_SUITE(DepthDataTest, RawTypes);

const Plane kSlope = *make_plane({0.3, -0.4, -1.0}, 1.7);

/// Planes that have something to do with the frame: near the slope, and through three of its points.
std::vector<Plane> some_planes(const PointCloud& cloud, RandomStream& random) {
  std::vector<Plane> planes{kSlope};
  for (int i = 0; i < 5; ++i) {
    planes.push_back(*make_plane(kSlope.normal + 0.01 * testing::unit_vector(random), kSlope.d + 0.005 * random.normal()));
    const auto point = [&] { return cloud.local(random.below(static_cast<std::uint32_t>(cloud.size()))); };
    if (const auto plane = plane_through(point(), point(), point())) planes.push_back(*plane);
  }
  return planes;
}

/// Points whose distance float may put on the other side of the threshold: some roundings of up to 6 m.
std::uint64_t undecided(const PointCloud& cloud, const Plane& plane, double threshold_m) {
  std::uint64_t count = 0;
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    count += static_cast<std::uint64_t>(std::abs(std::abs(plane.signed_distance(cloud.local(i))) - threshold_m) < 4e-6);
  }
  return count;
}

TYPED_TEST(DepthDataTest, CountsMeasuredAndKept) {
  RandomStream random = testing::test_random();
  const Frame<TypeParam> frame(77, 50, kSlope, random);
  const AxisLimits limits[] = {{.axis = Axis::z, .min_m = 1.0, .max_m = 2.0},
                               {.axis = Axis::x, .min_m = -0.2, .max_m = 0.3, .outside = true}};
  const std::size_t measured = frame.cloud().size();
  EXPECT_EQ(Data<TypeParam>(frame).data.size(), measured);
  EXPECT_EQ(Data<TypeParam>(frame).data.measured(), measured);
  for (const AxisLimits& within : limits) {
    const Data<TypeParam> limited(frame, &within);
    EXPECT_EQ(limited.data.size(), frame.cloud(&within).size());
    EXPECT_EQ(limited.data.measured(), measured);
  }
}

TYPED_TEST(DepthDataTest, ScoresAreThoseOfTheCloud) {
  RandomStream random = testing::test_random();
  const AxisLimits limits{.axis = Axis::z, .min_m = 0.9, .max_m = 2.1};
  for (const int width : {16, 77, 320}) {
    const Frame<TypeParam> frame(width, 70, kSlope, random);
    for (const AxisLimits* within : {static_cast<const AxisLimits*>(nullptr), &limits}) {
      const Data<TypeParam> depth(frame, within);
      const PointCloud cloud = frame.cloud(within);
      const sac::CloudData points(cloud);
      for (const Plane& plane : some_planes(cloud, random)) {
        const auto border = static_cast<double>(undecided(cloud, plane, 0.01));
        for (const sac::Scoring scoring : kScorings) {
          const sac::Score a = depth.data.score(plane, 0.01F, scoring, kNothingToBeat);
          const sac::Score b = points.score(plane, 0.01F, scoring, kNothingToBeat);
          EXPECT_NEAR(static_cast<double>(a.inliers), static_cast<double>(b.inliers), border);
          // Each gain is off by 2 dr / t, dr being some 2e-6 m on either side.
          EXPECT_NEAR(a.value, b.value, border + 1e-3 * static_cast<double>(b.inliers));
        }
      }
    }
  }
}

TYPED_TEST(DepthDataTest, MomentsAreThoseOfTheCloud) {
  RandomStream random = testing::test_random();
  for (const int width : {16, 77, 640}) {
    const Frame<TypeParam> frame(width, 90, kSlope, random);
    const Data<TypeParam> depth(frame);
    const PointCloud cloud = frame.cloud();
    const sac::CloudData points(cloud);
    for (const Plane& plane : some_planes(cloud, random)) {
      const sac::Moments a = depth.data.inlier_moments(plane, 0.01F);
      const sac::Moments b = points.inlier_moments(plane, 0.01F);
      const auto border = static_cast<double>(undecided(cloud, plane, 0.01));
      const auto n = static_cast<double>(b.count);
      EXPECT_NEAR(static_cast<double>(a.count), n, border);
      // Sums of rows are in float: 2^-24 a term at worst, some 2^-24 sqrt(n) in truth. Nothing is farther than 6 m away.
      const double rounding = 1e-6 * n + 1.01 * border;
      EXPECT_LE((a.sum - b.sum).cwiseAbs().maxCoeff(), 6.0 * rounding + 1e-6);
      EXPECT_LE((a.sum_outer - b.sum_outer).cwiseAbs().maxCoeff(), 36.0 * rounding + 1e-6);
      EXPECT_EQ(a.sum_outer, a.sum_outer.transpose().eval());
    }
  }
}

TYPED_TEST(DepthDataTest, PlanesFittedToPixelsAreThoseFittedToPoints) {
  // What the rounding of the sums above does to a plane, and on far walls, where sums of squares are large beside the spread.
  RandomStream random = testing::test_random();
  for (const double distance : {1.0, 3.0, 10.0}) {
    const Plane wall = *make_plane({0.1, -0.2, -1.0}, distance);
    Frame<TypeParam> frame(640, 480);
    for (int v = 180; v < 300; ++v) {
      for (int u = 260; u < 400; ++u) frame.set(u, v, testing::depth_on(wall, frame.camera, u, v) + 0.003 * random.normal());
    }
    const PointCloud cloud = frame.cloud();
    const auto a = sac::fit_plane(Data<TypeParam>(frame).data.inlier_moments(wall, 0.02F));
    const auto b = sac::fit_plane(sac::CloudData(cloud).inlier_moments(wall, 0.02F));
    ASSERT_TRUE(a && b);
    EXPECT_LT(angle_between(a->plane, b->plane), 2e-5) << distance;  // 0.001 degrees
    EXPECT_NEAR(a->plane.d, b->plane.d, 1e-5 * distance);
  }
}

TYPED_TEST(DepthDataTest, BailOutNeverRaisesALoserNorTouchesAWinner) {
  RandomStream random = testing::test_random();
  const Frame<TypeParam> frame(200, 300, kSlope, random);
  const PointCloud cloud = frame.cloud();
  int early = 0;
  for (const int threads : {1, 2}) {
    const Data<TypeParam> depth(frame, nullptr, threads);
    for (const Plane& plane : some_planes(cloud, random)) {
      for (const sac::Scoring scoring : kScorings) {
        early += testing::expect_bail_out_is_fair(depth.data, plane, 0.01F, scoring, {100.0, 10000.0, 30000.0, 47000.0});
      }
    }
  }
  EXPECT_GT(early, 10);
}

TYPED_TEST(DepthDataTest, ThreadsChangeNothing) {
  // Large enough for a second thread to be worth it.
  RandomStream random = testing::test_random();
  const Frame<TypeParam> frame(1024, 530, kSlope, random);
  ASSERT_GE(frame.raw.size(), std::size_t{1} << 19);
  const Data<TypeParam> serial(frame);
  for (const int threads : {2, 5, 0}) {
    const Data<TypeParam> threaded(frame, nullptr, threads);
    EXPECT_EQ(threaded.data.size(), serial.data.size());
    for (const Plane& plane : some_planes(frame.cloud(), random)) {
      for (const sac::Scoring scoring : kScorings) {
        const sac::Score a = serial.data.score(plane, 0.01F, scoring, kNothingToBeat);
        const sac::Score b = threaded.data.score(plane, 0.01F, scoring, kNothingToBeat);
        EXPECT_EQ(a.value, b.value);
        EXPECT_EQ(a.inliers, b.inliers);
      }
      const sac::Moments a = serial.data.inlier_moments(plane, 0.01F);
      const sac::Moments b = threaded.data.inlier_moments(plane, 0.01F);
      EXPECT_EQ(a.count, b.count);
      EXPECT_EQ(a.sum, b.sum);
      EXPECT_EQ(a.sum_outer, b.sum_outer);
    }
  }
}

// ---- samples ----

TYPED_TEST(DepthDataTest, DrawsAllInOrderWhenAskedForAsMany) {
  RandomStream random = testing::test_random();
  const Frame<TypeParam> frame(30, 20, kSlope, random);
  const AxisLimits limits{.axis = Axis::z, .min_m = 1.2, .max_m = 2.0};
  for (const AxisLimits* within : {static_cast<const AxisLimits*>(nullptr), &limits}) {
    const Data<TypeParam> depth(frame, within);
    const PointCloud cloud = frame.cloud(within);
    for (const std::size_t n : {cloud.size(), cloud.size() + 1, std::size_t{4096}}) {
      PointCloud sample = testing::cloud_of({{7, 7, 7}}, {1, 2, 3});
      sample.source.push_back(5);
      depth.data.draw(random, static_cast<std::uint32_t>(n), sample);
      ASSERT_EQ(sample.size(), cloud.size());
      EXPECT_EQ(sample.origin, Vector3d::Zero());
      EXPECT_TRUE(sample.source.empty());
      for (std::size_t i = 0; i < cloud.size(); ++i) EXPECT_LT((sample.local(i) - cloud.local(i)).norm(), 1e-6);
      for (std::size_t i = sample.size(); i < sample.padded_size(); ++i) EXPECT_TRUE(std::isnan(sample.z()[i]));
    }
  }
}

/// Chi-square of how often 8 x 8 blocks of the image are hit, against how many kept pixels they have; degrees of freedom.
struct ChiSquare {
  double value = 0.0;
  int degrees = -1;
};

template <class Raw>
ChiSquare chi_square_of_blocks(const Frame<Raw>& frame, const AxisLimits* limits, RandomStream& random) {
  constexpr std::uint32_t kDrawn = 4000;
  const Data<Raw> depth(frame, limits);
  const auto block = [&](const Vector3d& p) {
    const auto u = static_cast<int>(std::lround(p.x() / p.z() * frame.camera.fx + frame.camera.cx));
    const auto v = static_cast<int>(std::lround(p.y() / p.z() * frame.camera.fy + frame.camera.cy));
    return 8 * (8 * v / frame.camera.height) + 8 * u / frame.camera.width;
  };
  std::map<int, double> there;
  std::map<int, double> drawn;
  const PointCloud cloud = frame.cloud(limits);
  for (std::size_t i = 0; i < cloud.size(); ++i) ++there[block(cloud.local(i))];
  PointCloud sample;
  for (int repeat = 0; repeat < 4; ++repeat) {
    depth.data.draw(random, kDrawn, sample);
    EXPECT_EQ(sample.size(), kDrawn);
    for (std::size_t i = 0; i < sample.size(); ++i) ++drawn[block(sample.local(i))];
  }
  ChiSquare sum;
  for (const auto& [at, pixels] : there) {
    const double expected = 4.0 * kDrawn * pixels / static_cast<double>(cloud.size());
    sum.value += (drawn[at] - expected) * (drawn[at] - expected) / expected;
    ++sum.degrees;
  }
  for (const auto& [at, count] : drawn) EXPECT_TRUE(there.contains(at)) << "a pixel that is not there: block " << at;
  return sum;
}

TYPED_TEST(DepthDataTest, DrawsUniformly) {
  // Depth that differs much, so that a draw by depth or by row would show; 64 blocks, then 32 of them, and one pixel in 40.
  RandomStream random = testing::test_random();
  const AxisLimits near{.axis = Axis::z, .min_m = 0.0, .max_m = 1.6};
  Frame<TypeParam> full(320, 160, kSlope, random);
  Frame<TypeParam> sparse(320, 640);
  for (int v = 0; v < 640; ++v) {
    for (int u = 0; u < 320; ++u) {
      if (random.below(40) == 0) sparse.set(u, v, testing::uniform(random, 0.5, 4.0));
    }
  }
  ASSERT_GT(sparse.cloud().size(), 4000U);
  for (const auto& [frame, limits] : {std::pair{&full, static_cast<const AxisLimits*>(nullptr)}, std::pair{&full, &near},
                                      std::pair{&sparse, static_cast<const AxisLimits*>(nullptr)}}) {
    const ChiSquare c = chi_square_of_blocks(*frame, limits, random);
    EXPECT_GT(c.degrees, 30);
    // Mean k, variance 2 k: 5 standard deviations.
    EXPECT_LT(c.value, c.degrees + 5.0 * std::sqrt(2.0 * c.degrees));
  }
}

TYPED_TEST(DepthDataTest, AFrameOfFewPixels) {
  Frame<TypeParam> frame(64, 64);
  PointCloud sample;
  RandomStream random = testing::test_random();
  Data<TypeParam>(frame).data.draw(random, 100, sample);
  EXPECT_TRUE(sample.empty());
  frame.set(63, 63, 1.0);
  frame.set(0, 0, 2.0);
  Data<TypeParam>(frame).data.draw(random, 100, sample);
  EXPECT_EQ(sample.size(), 2U);
  Data<TypeParam>(frame).data.draw(random, 1, sample);  // one of 4096: listed, not tried for
  ASSERT_EQ(sample.size(), 1U);
  EXPECT_GE(sample.local(0).z(), 0.99);
}

}  // namespace
}  // namespace fransac
