// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <atomic>
#include <chrono>
#include <cmath>
#include <limits>
#include <numbers>
#include <thread>
#include <vector>

#include "fransac/core/camera.hpp"
#include "fransac/core/depth_image.hpp"
#include "fransac/core/parallel.hpp"
#include "fransac/core/plane.hpp"
#include "fransac/core/point_cloud.hpp"
#include "fransac/core/random.hpp"
#include "fransac/core/result.hpp"
#include "support.hpp"

namespace fransac {
namespace {

using Eigen::Vector3d;
using ::testing::HasSubstr;

constexpr double kInf = std::numeric_limits<double>::infinity();
constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

// ---- random numbers ----

TEST(Philox, KnownAnswers) {
  // The vectors that the Random123 distribution publishes for philox4x32 with 10 rounds.
  using Block = std::array<std::uint32_t, 4>;
  EXPECT_EQ(philox4x32({0, 0, 0, 0}, {0, 0}), (Block{0x6627e8d5, 0xe169c58d, 0xbc57ac4c, 0x9b00dbd8}));
  constexpr std::uint32_t kOnes = 0xffffffff;
  EXPECT_EQ(philox4x32({kOnes, kOnes, kOnes, kOnes}, {kOnes, kOnes}), (Block{0x408f276d, 0x41c83b0e, 0xa20bc7c6, 0x6d5451fd}));
  EXPECT_EQ(philox4x32({0x243f6a88, 0x85a308d3, 0x13198a2e, 0x03707344}, {0xa4093822, 0x299f31d0}),
            (Block{0xd16cfe09, 0x94fdcceb, 0x5001e420, 0x24126ea1}));
}

TEST(RandomStream, IsAPureFunctionOfSeedAndIndex) {
  RandomStream a(7, 9);
  RandomStream b(7, 9);
  for (int i = 0; i < 100; ++i) EXPECT_EQ(a.next(), b.next());
  const std::uint32_t first = RandomStream(7, 9).next();
  EXPECT_NE(first, RandomStream(7, 10).next());
  EXPECT_NE(first, RandomStream(8, 9).next());
  EXPECT_NE(first, RandomStream(7, 9 + (std::uint64_t{1} << 32)).next());  // the high half counts
  EXPECT_NE(first, RandomStream(7 + (std::uint64_t{1} << 32), 9).next());
}

TEST(RandomStream, DrawsTheBlocksInOrder) {
  RandomStream random(0, 0);
  for (const std::uint32_t word : philox4x32({0, 0, 0, 0}, {0, 0})) EXPECT_EQ(random.next(), word);
  for (const std::uint32_t word : philox4x32({0, 0, 1, 0}, {0, 0})) EXPECT_EQ(random.next(), word);
}

/// Pearson's statistic of counts that should all be equal.
double chi_square(const std::vector<std::uint32_t>& counts) {
  double total = 0.0;
  for (const std::uint32_t count : counts) total += count;
  const double expected = total / static_cast<double>(counts.size());
  double sum = 0.0;
  for (const std::uint32_t count : counts) sum += (count - expected) * (count - expected) / expected;
  return sum;
}

TEST(RandomStream, BelowIsUniform) {
  RandomStream random = testing::test_random();
  std::vector<std::uint32_t> counts(7);
  for (int i = 0; i < 70000; ++i) ++counts[random.below(7)];
  EXPECT_LT(chi_square(counts), 22.46);  // 6 degrees of freedom: exceeded with probability 0.001
}

TEST(RandomStream, BelowIsUnbiasedForLargeBounds) {
  // With the bound 3 * 2^30 and no rejection a third of the numbers would have twice the weight of the others: those
  // divisible by 3 with a multiplication, those below 2^30 with a remainder.
  RandomStream random = testing::test_random();
  constexpr std::uint32_t kBound = 3U << 30;
  std::vector<std::uint32_t> by_size(3);
  std::vector<std::uint32_t> by_remainder(3);
  for (int i = 0; i < 60000; ++i) {
    const std::uint32_t number = random.below(kBound);
    ASSERT_LT(number, kBound);
    ++by_size[number >> 30];
    ++by_remainder[number % 3];
  }
  EXPECT_LT(chi_square(by_size), 13.82);  // 2 degrees of freedom: exceeded with probability 0.001
  EXPECT_LT(chi_square(by_remainder), 13.82);
}

TEST(RandomStream, BelowOneIsZero) {
  RandomStream random = testing::test_random();
  for (int i = 0; i < 100; ++i) EXPECT_EQ(random.below(1), 0U);
}

TEST(RandomStream, UniformAndNormalMoments) {
  RandomStream random = testing::test_random();
  constexpr int kDraws = 40000;
  double uniform_sum = 0.0;
  double normal_sum = 0.0;
  double normal_squares = 0.0;
  for (int i = 0; i < kDraws; ++i) {
    const double u = random.uniform();
    ASSERT_TRUE(u >= 0.0 && u < 1.0);
    uniform_sum += u;
    const double g = random.normal();
    ASSERT_TRUE(std::isfinite(g));
    normal_sum += g;
    normal_squares += g * g;
  }
  // Each mean lies within 4 of its standard deviations (two-sided 6e-5).
  EXPECT_NEAR(uniform_sum / kDraws, 0.5, 4.0 / std::sqrt(12.0 * kDraws));
  EXPECT_NEAR(normal_sum / kDraws, 0.0, 4.0 / std::sqrt(1.0 * kDraws));
  EXPECT_NEAR(normal_squares / kDraws, 1.0, 4.0 * std::sqrt(2.0 / kDraws));
}

// ---- planes ----

TEST(Plane, UnitNormalAndOffsetInMetres) {
  const auto plane = make_plane({0.0, 3.0, 4.0}, 10.0);
  ASSERT_TRUE(plane);
  EXPECT_DOUBLE_EQ(plane->normal.y(), 0.6);
  EXPECT_DOUBLE_EQ(plane->normal.z(), 0.8);
  EXPECT_DOUBLE_EQ(plane->d, 2.0);
}

TEST(Plane, OriginIsOnThePositiveSide) {
  const auto plane = make_plane({0.0, 0.0, 1.0}, -2.0);
  ASSERT_TRUE(plane);
  EXPECT_EQ(plane->normal, Vector3d(0.0, 0.0, -1.0));
  EXPECT_EQ(plane->d, 2.0);
  EXPECT_EQ(plane->signed_distance(Vector3d::Zero()), 2.0);
  EXPECT_EQ(plane->signed_distance({5.0, -5.0, 3.0}), -1.0);
}

TEST(Plane, ThroughTheOriginTheFirstNonZeroComponentIsPositive) {
  EXPECT_EQ(make_plane({-1.0, 0.0, 0.0}, 0.0)->normal, Vector3d(1.0, 0.0, 0.0));
  EXPECT_EQ(make_plane({0.0, -2.0, 0.0}, 0.0)->normal, Vector3d(0.0, 1.0, 0.0));
  EXPECT_EQ(make_plane({0.0, 0.0, -2.0}, -0.0)->normal, Vector3d(0.0, 0.0, 1.0));
  EXPECT_LT(make_plane({1.0, -1.0, 1.0}, 0.0)->normal.y(), 0.0);
  EXPECT_FALSE(std::signbit(make_plane({0.0, 0.0, -2.0}, 0.0)->d));
}

TEST(Plane, NothingWithoutANormal) {
  EXPECT_FALSE(make_plane(Vector3d::Zero(), 1.0));
  EXPECT_FALSE(make_plane({kNaN, 0.0, 1.0}, 1.0));
  EXPECT_FALSE(make_plane({0.0, kInf, 1.0}, 1.0));
  EXPECT_FALSE(make_plane({0.0, 0.0, 1.0}, kNaN));
  EXPECT_FALSE(make_plane({0.0, 0.0, 1.0}, -kInf));
}

TEST(Plane, ExtremeScalesKeepTheUnitNormal) {
  for (const double scale : {1e-170, 1e-160, 1e-30, 1e30, 1e160, 1e200}) {
    const auto plane = make_plane({0.0, 3.0 * scale, 4.0 * scale}, 10.0 * scale);
    ASSERT_TRUE(plane) << scale;
    EXPECT_NEAR(plane->normal.norm(), 1.0, 1e-12) << scale;
    EXPECT_NEAR(plane->d, 2.0, 1e-12) << scale;
  }
  EXPECT_FALSE(make_plane({1e-200, 0.0, 0.0}, 1e200));  // its offset is no number
}

TEST(PlaneThrough, ThreePoints) {
  const auto plane = plane_through({1.0, 0.0, 0.0}, {0.0, 1.0, 0.0}, {0.0, 0.0, 1.0});  // x + y + z = 1
  ASSERT_TRUE(plane);
  EXPECT_NEAR(plane->d, 1.0 / std::sqrt(3.0), 1e-15);
  EXPECT_NEAR((plane->normal - Vector3d::Constant(-1.0 / std::sqrt(3.0))).norm(), 0.0, 1e-15);
}

TEST(PlaneThrough, NothingForCollinearPoints) {
  EXPECT_FALSE(plane_through({0, 0, 1}, {1, 1, 2}, {2, 2, 3}));
  EXPECT_FALSE(plane_through({0, 0, 1}, {0, 0, 1}, {2, 2, 3}));
  EXPECT_FALSE(plane_through({0, 0, 1}, {2, 2, 3}, {2, 2, 3}));
  EXPECT_FALSE(plane_through({1, 2, 3}, {1, 2, 3}, {1, 2, 3}));
  EXPECT_FALSE(plane_through({kNaN, 2, 3}, {1, 2, 3}, {1, 0, 3}));
}

TEST(PlaneThrough, TheSmallestHeightDecides) {
  // The height over the longest side (1 m) is the third point's y; the limit is 1e-4 of that side. In every order.
  const Vector3d a(0, 0, 5);
  const Vector3d b(1, 0, 5);
  for (const double height : {0.9e-4, 1.1e-4}) {
    const Vector3d c(0.5, height, 5);
    const bool expected = height > 1e-4;
    EXPECT_EQ(plane_through(a, b, c).has_value(), expected);
    EXPECT_EQ(plane_through(c, a, b).has_value(), expected);
    EXPECT_EQ(plane_through(b, c, a).has_value(), expected);
    EXPECT_EQ(plane_through(a, c, b).has_value(), expected);
  }
}

TEST(Plane, TranslationKeepsDistances) {
  const Plane plane = *make_plane({0.2, -0.5, 0.7}, 1.5);
  const Vector3d shift(4.0, -3.0, -7.0);
  const Plane moved = translated(plane, shift);
  EXPECT_GE(moved.d, 0.0);
  for (const Vector3d& p : {Vector3d(0, 0, 0), Vector3d(1, 2, 3), Vector3d(-4, 0.5, 2)}) {
    EXPECT_NEAR(std::abs(moved.signed_distance(p - shift)), std::abs(plane.signed_distance(p)), 1e-14);
  }
}

TEST(Plane, AngleIsOfUndirectedNormals) {
  const Plane z{Vector3d::UnitZ(), 1.0};
  const auto tilted = [](double angle) { return Plane{{std::sin(angle), 0.0, std::cos(angle)}, 1.0}; };
  EXPECT_DOUBLE_EQ(angle_between(z, tilted(0.3)), 0.3);
  EXPECT_NEAR(angle_between(z, tilted(std::numbers::pi - 0.3)), 0.3, 1e-15);
  EXPECT_NEAR(angle_between(z, tilted(1e-9)), 1e-9, 1e-20);  // an arc cosine would return 0
  EXPECT_DOUBLE_EQ(angle_between(z, tilted(std::numbers::pi / 2)), std::numbers::pi / 2);
}

// ---- point clouds ----

bool padding_is_nan(const PointCloud& cloud) {
  for (std::size_t i = cloud.size(); i < cloud.padded_size(); ++i) {
    if (!std::isnan(cloud.x()[i]) || !std::isnan(cloud.y()[i]) || !std::isnan(cloud.z()[i])) return false;
  }
  return true;
}

TEST(PointCloud, PaddingIsNaNAtEverySize) {
  PointCloud cloud;
  EXPECT_EQ(cloud.padded_size(), 0U);
  for (const std::size_t size : std::initializer_list<std::size_t>{0, 1, 15, 16, 17, 33, 100, 5, 31, 0, 16, 200}) {
    cloud.resize(size);
    EXPECT_EQ(cloud.size(), size);
    EXPECT_EQ(cloud.padded_size() % PointCloud::kBlock, 0U);
    EXPECT_TRUE(padding_is_nan(cloud)) << size;
    for (std::size_t i = 0; i < size; ++i) cloud.set(i, {1.0F, 2.0F, 3.0F});
  }
}

TEST(PointCloud, NewPointsAreNaNAndOldOnesStay) {
  PointCloud cloud;
  cloud.resize(40);
  EXPECT_FALSE(cloud.finite(0));
  EXPECT_FALSE(cloud.finite(39));
  for (std::size_t i = 0; i < 40; ++i) cloud.set(i, {static_cast<float>(i), 0.0F, 0.0F});
  cloud.resize(10);
  cloud.resize(50);  // what lay beyond the tenth must not come back
  for (std::size_t i = 0; i < 10; ++i) EXPECT_EQ(cloud.local(i).x(), static_cast<double>(i));
  for (std::size_t i = 10; i < 50; ++i) EXPECT_FALSE(cloud.finite(i)) << i;
}

TEST(PointCloud, ArraysAreAligned) {
  PointCloud cloud;
  for (const std::size_t size : std::initializer_list<std::size_t>{1, 100, 10000}) {
    cloud.resize(size);
    for (const float* axis : {cloud.x(), cloud.y(), cloud.z()}) {
      EXPECT_EQ(reinterpret_cast<std::uintptr_t>(axis) % kAlignment, 0U);
    }
  }
}

TEST(PointCloud, OriginAddsInDouble) {
  const PointCloud cloud = testing::cloud_of({{0.125, 0.25, 0.5}}, {5e5, 5.4e6, 200.0});
  EXPECT_EQ(cloud.point(0), Vector3d(500000.125, 5400000.25, 200.5));
  EXPECT_EQ(cloud.local(0), Vector3d(0.125, 0.25, 0.5));
}

TEST(PointCloud, SourceIsTheIdentityUntilFiltered) {
  PointCloud cloud = testing::cloud_of({{0, 0, 1}, {0, 0, 2}});
  EXPECT_EQ(cloud.source_of(1), 1U);
  cloud.source.assign({7, 9});
  EXPECT_EQ(cloud.source_of(1), 9U);
}

TEST(PointCloud, ZeroInTheInputsCoordinatesIsNoMeasurement) {
  const PointCloud near = testing::cloud_of({{0, 0, 0}, {-0.0, 0, 0}, {0, 0, 1e-30}, {kNaN, 0, 0}});
  EXPECT_FALSE(near.measured(0));
  EXPECT_FALSE(near.measured(1));
  EXPECT_TRUE(near.measured(2));
  EXPECT_FALSE(near.measured(3));
  const PointCloud far = testing::cloud_of({{0, 0, 0}, {-5e5, -5.4e6, -200.0}}, {5e5, 5.4e6, 200.0});
  EXPECT_TRUE(far.measured(0));  // the cloud's own origin is a place like any other
  EXPECT_FALSE(far.measured(1));
}

TEST(PointCloud, FiniteLooksAtEveryAxis) {
  const double inf = kInf;
  const PointCloud cloud = testing::cloud_of({{1, 2, 3}, {kNaN, 2, 3}, {1, inf, 3}, {1, 2, -inf}});
  EXPECT_TRUE(cloud.finite(0));
  for (std::size_t i = 1; i < 4; ++i) EXPECT_FALSE(cloud.finite(i));
}

TEST(PointCloud, PositionsAreFiniteAndNoFartherThanNumbersReach) {
  for (int axis = 0; axis < 3; ++axis) {
    PointCloud cloud = testing::cloud_of({{1, 2, 3}});
    for (const double valid : {0.0, -kMaxCoordinate_m, kMaxCoordinate_m}) {
      cloud.origin[axis] = valid;
      cloud.sensor_position = cloud.origin;
      EXPECT_TRUE(validate(cloud)) << valid;
    }
    for (const double wrong : {1.01 * kMaxCoordinate_m, -1.01 * kMaxCoordinate_m, kInf, -kInf, kNaN}) {
      Vector3d position = Vector3d::Zero();
      position[axis] = wrong;
      const Status status = validate_position(position, "place");
      ASSERT_FALSE(status) << wrong;
      EXPECT_EQ(status.error().code, ErrorCode::invalid_argument);
      EXPECT_EQ(status.error().message, "place: must be finite, with no coordinate beyond 1e+30 m");
      cloud.origin = position;
      cloud.sensor_position.reset();
      EXPECT_THAT(validate(cloud).error().message, HasSubstr("point cloud: origin: must be finite"));
      cloud.origin.setZero();
      cloud.sensor_position = position;
      EXPECT_THAT(validate(cloud).error().message, HasSubstr("point cloud: sensor position: must be finite"));
    }
  }
}

// ---- depth images ----

TEST(DepthView, Uint16InMetres) {
  const std::vector<std::uint16_t> pixels{0, 5000, 1, 65535, 10000, 0};
  const DepthView depth = DepthView::from_uint16(pixels.data(), 3, 2, 5000.0);
  ASSERT_TRUE(validate(depth));
  EXPECT_EQ(depth.size(), 6U);
  EXPECT_EQ(depth.metres(0, 0), 0.0F);
  EXPECT_FLOAT_EQ(depth.metres(1, 0), 1.0F);
  EXPECT_FLOAT_EQ(depth.metres(2, 0), 0.0002F);
  EXPECT_FLOAT_EQ(depth.metres(0, 1), 13.107F);
  EXPECT_FLOAT_EQ(depth.metres(1, 1), 2.0F);
}

TEST(DepthView, PaddedRows) {
  // Two rows of two pixels, each followed by one that belongs to nobody.
  const std::vector<std::uint16_t> pixels{1000, 2000, 9, 3000, 4000, 9};
  const DepthView depth = DepthView::from_uint16(pixels.data(), 2, 2, 1000.0, 6);
  ASSERT_TRUE(validate(depth));
  EXPECT_FLOAT_EQ(depth.metres(1, 0), 2.0F);
  EXPECT_FLOAT_EQ(depth.metres(0, 1), 3.0F);
  EXPECT_FLOAT_EQ(depth.metres(1, 1), 4.0F);
}

TEST(DepthView, NegativeStrideReadsUpwards) {
  const std::vector<float> pixels{1.0F, 2.0F, 3.0F, 4.0F};
  const DepthView depth = DepthView::from_float(pixels.data() + 2, 2, 2, -8);
  ASSERT_TRUE(validate(depth));
  EXPECT_EQ(depth.metres(0, 0), 3.0F);
  EXPECT_EQ(depth.metres(1, 1), 2.0F);
}

TEST(DepthView, OnlyPositiveFiniteFloatsAreMeasurements) {
  constexpr float kFloatInf = std::numeric_limits<float>::infinity();
  constexpr float kFloatNaN = std::numeric_limits<float>::quiet_NaN();
  const std::vector<float> pixels{1.5F, 0.0F, -0.0F, -1.0F, kFloatNaN, kFloatInf, -kFloatInf};
  const DepthView depth = DepthView::from_float(pixels.data(), 7, 1);
  ASSERT_TRUE(validate(depth));
  EXPECT_EQ(depth.metres(0, 0), 1.5F);
  for (int u = 1; u < 7; ++u) EXPECT_EQ(depth.metres(u, 0), 0.0F) << u;
}

TEST(DepthView, ValidationNamesWhatIsWrong) {
  const std::uint16_t pixel = 1000;
  const float metre = 1.0F;
  const auto message = [](const DepthView& depth) {
    const Status status = validate(depth);
    return status ? std::string("valid") : status.error().message;
  };
  EXPECT_EQ(message(DepthView::from_uint16(&pixel, 1, 1, 1000.0)), "valid");
  EXPECT_THAT(message(DepthView()), HasSubstr("width"));
  EXPECT_THAT(message(DepthView::from_uint16(&pixel, 0, 1, 1000.0)), HasSubstr("width"));
  EXPECT_THAT(message(DepthView::from_uint16(&pixel, kMaxImageSide + 1, 1, 1000.0)), HasSubstr("width"));
  EXPECT_THAT(message(DepthView::from_uint16(&pixel, 1, -1, 1000.0)), HasSubstr("height"));
  EXPECT_THAT(message(DepthView::from_uint16(nullptr, 1, 1, 1000.0)), HasSubstr("null"));
  EXPECT_THAT(message(DepthView::from_float(nullptr, 1, 1)), HasSubstr("null"));
  EXPECT_THAT(message(DepthView::from_uint16(&pixel, 2, 1, 1000.0, 2)), HasSubstr("stride"));
  EXPECT_THAT(message(DepthView::from_uint16(&pixel, 2, 1, 1000.0, -2)), HasSubstr("stride"));
  EXPECT_THAT(message(DepthView::from_uint16(&pixel, 1, 1, 1000.0, 3)), HasSubstr("stride"));
  EXPECT_THAT(message(DepthView::from_float(&metre, 1, 1, 6)), HasSubstr("stride"));
  EXPECT_THAT(message(DepthView::from_float(&metre, 1, 2, std::numeric_limits<std::ptrdiff_t>::min() + 2)), HasSubstr("stride"));
  for (const double scale : {0.0, -1000.0, kNaN, kInf, 1e-300, 1e-36}) {  // the last: 65535 units are no float any more
    EXPECT_THAT(message(DepthView::from_uint16(&pixel, 1, 1, scale)), HasSubstr("depth scale")) << scale;
  }
}

// ---- cameras ----

TEST(Camera, ValidationNamesTheField) {
  const Camera good = testing::small_camera();
  EXPECT_TRUE(validate(good));
  const auto expect_error = [&](const char* field, auto set) {
    Camera camera = good;
    set(camera);
    const Status status = validate(camera);
    ASSERT_FALSE(status) << field;
    EXPECT_EQ(status.error().code, ErrorCode::invalid_argument);
    EXPECT_THAT(status.error().message, HasSubstr('"' + std::string(field) + '"'));
  };
  for (const int side : {0, -1, kMaxImageSide + 1, std::numeric_limits<int>::min()}) {
    expect_error("width", [&](Camera& c) { c.width = side; });
    expect_error("height", [&](Camera& c) { c.height = side; });
  }
  for (const double length : {0.0, -500.0, 1e-300, 1e7, kNaN, kInf}) {
    expect_error("fx", [&](Camera& c) { c.fx = length; });
    expect_error("fy", [&](Camera& c) { c.fy = length; });
    expect_error("depth_scale", [&](Camera& c) { c.depth_scale = length; });
  }
  expect_error("depth_scale", [&](Camera& c) { c.depth_scale = 0.001; });  // metres per unit instead of units per metre
  for (const double point : {kNaN, kInf, -kInf, 1e300}) {
    expect_error("cx", [&](Camera& c) { c.cx = point; });
    expect_error("cy", [&](Camera& c) { c.cy = point; });
  }
}

// ---- errors as values ----

TEST(Result, HoldsAValueOrAnError) {
  const Result<int> value = 3;
  EXPECT_TRUE(value.ok());
  EXPECT_EQ(*value, 3);
  const Result<int> error = Error{ErrorCode::io, "cannot open x"};
  EXPECT_FALSE(error);
  EXPECT_EQ(error.error().message, "cannot open x");
  EXPECT_TRUE(Status());
  EXPECT_FALSE(Status(Error{ErrorCode::no_data, "nothing"}).ok());
}

TEST(Result, EveryCodeHasAName) {
  EXPECT_EQ(to_string(ErrorCode::invalid_argument), "invalid_argument");
  EXPECT_EQ(to_string(ErrorCode::io), "io");
  EXPECT_EQ(to_string(ErrorCode::format), "format");
  EXPECT_EQ(to_string(ErrorCode::no_data), "no_data");
  EXPECT_EQ(to_string(ErrorCode::unsupported), "unsupported");
  EXPECT_EQ(to_string(ErrorCode::out_of_memory), "out_of_memory");
}

// ---- threads ----

TEST(ParallelFor, CoversEachIndexOnce) {
  for (const int threads : {0, 1, 2, 5}) {
    for (const std::size_t n : std::initializer_list<std::size_t>{0, 1, 2, 1000}) {
      std::vector<std::atomic<int>> visits(n);
      parallel_for(threads, n, [&](std::size_t i) { ++visits[i]; });
      for (const auto& count : visits) ASSERT_EQ(count.load(), 1) << threads << " threads, n = " << n;
    }
  }
}

TEST(ParallelFor, OneThreadIsInOrderAndHere) {
  std::vector<std::size_t> order;
  parallel_for(1, 20, [&](std::size_t i) { order.push_back(i); });
  for (std::size_t i = 0; i < 20; ++i) EXPECT_EQ(order[i], i);
}

TEST(ParallelFor, MoreThreadsThanCoresIsNoCauseToPrint) {
  ::testing::internal::CaptureStderr();
  parallel_for(1000, 10, [](std::size_t /*i*/) {});
  EXPECT_EQ(::testing::internal::GetCapturedStderr(), "");
}

// What run_pipeline promises, with `threads`: a stream of `items` through a stage that overtakes and two in order.
void expect_pipeline_in_order(int threads, std::size_t slots, std::size_t items) {
  std::vector<std::size_t> item_in(slots, 0);
  std::vector<std::size_t> squares(slots, 0);
  std::size_t begun = 0;
  std::size_t summed = 0;
  std::vector<std::size_t> written;
  std::atomic<std::size_t> under_way{0};
  std::atomic<std::size_t> most{0};
  const auto next = [&](std::size_t slot) {
    EXPECT_LT(slot, slots);
    if (begun == items) return false;
    const std::size_t now = ++under_way;
    if (now > most) most = now;
    item_in[slot] = begun++;
    return true;
  };
  const auto square = [&](std::size_t slot) {
    // Every third item takes its time: others overtake it.
    if (item_in[slot] % 3 == 0) std::this_thread::sleep_for(std::chrono::microseconds(200));
    squares[slot] = item_in[slot] * item_in[slot];
  };
  const auto sum = [&](std::size_t slot) {
    EXPECT_EQ(item_in[slot], summed);
    ++summed;
  };
  const auto write = [&](std::size_t slot) {
    written.push_back(squares[slot]);
    --under_way;
  };
  const std::array<PipelineStage, 3> stages{{{square, true}, {sum}, {write}}};
  run_pipeline(threads, slots, next, stages);
  EXPECT_EQ(summed, items);
  ASSERT_EQ(written.size(), items);
  for (std::size_t i = 0; i < items; ++i) EXPECT_EQ(written[i], i * i);
  EXPECT_LE(most.load(), slots);
}

TEST(RunPipeline, KeepsTheOrderAndNoMoreThanItsSlots) {
  for (const int threads : {0, 1, 2, 5}) {
    for (const std::size_t slots : {1U, 2U, 7U}) {
      for (const std::size_t items : {0U, 1U, 2U, 100U}) {
        SCOPED_TRACE(::testing::Message() << threads << " threads, " << slots << " slots, " << items << " items");
        expect_pipeline_in_order(threads, slots, items);
      }
    }
  }
}

TEST(RunPipeline, AnExceptionEndsItAndIsThrown) {
  struct Broken {
    std::size_t item;
  };
  constexpr std::size_t kSlots = 4;
  for (const int threads : {1, 4}) {
    for (const std::size_t where : {0U, 1U, 2U, 3U}) {
      std::array<std::size_t, kSlots> item_in{};
      std::size_t begun = 0;
      std::vector<std::size_t> written;
      const auto fail_at = [&](std::size_t stage, std::size_t item) {
        if (stage == where && item == 20) throw Broken{item};
      };
      const auto next = [&](std::size_t slot) {
        fail_at(0, begun);
        item_in[slot] = begun++;
        return begun < 100000;
      };
      const auto first = [&](std::size_t slot) { fail_at(1, item_in[slot]); };
      const auto second = [&](std::size_t slot) { fail_at(2, item_in[slot]); };
      const auto last = [&](std::size_t slot) {
        fail_at(3, item_in[slot]);
        written.push_back(item_in[slot]);
      };
      const std::array<PipelineStage, 3> stages{{{first, true}, {second}, {last}}};
      try {
        run_pipeline(threads, kSlots, next, stages);
        ADD_FAILURE() << "nothing was thrown";
      } catch (const Broken& broken) {
        EXPECT_EQ(broken.item, 20U);
      }
      EXPECT_LE(begun, 20 + kSlots + 1);
      ASSERT_LE(written.size(), 20U);
      for (std::size_t i = 0; i < written.size(); ++i) EXPECT_EQ(written[i], i);
    }
  }
}

TEST(RunPipeline, OneThreadIsHere) {
  const auto here = std::this_thread::get_id();
  int items = 0;
  const auto next = [&](std::size_t slot) { return slot == 0 && std::this_thread::get_id() == here && items < 5; };
  const auto count = [&](std::size_t /*slot*/) { ++items; };
  const std::array<PipelineStage, 1> stages{{{count}}};
  run_pipeline(1, 3, next, stages);
  EXPECT_EQ(items, 5);
}

TEST(ParallelFor, ZeroMeansAllCores) {
  EXPECT_GE(resolve_threads(0), 1);
  EXPECT_EQ(resolve_threads(3), 3);
}

}  // namespace
}  // namespace fransac
