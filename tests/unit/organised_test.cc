// SPDX-License-Identifier: Apache-2.0
#include "fransac/filter/organised.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <functional>
#include <limits>
#include <string>

#include "fransac/planes/segment.hpp"
#include "support.hpp"

namespace fransac {
namespace {

using Eigen::Vector3d;
using testing::FloatImage;
using ::testing::HasSubstr;

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

/// A sloping plane with noise of 1 % in depth, and holes.
FloatImage noisy_image(const Camera& camera = testing::small_camera()) {
  FloatImage image(camera);
  image.draw(*make_plane({0.2, -0.5, -1.0}, 1.5));
  RandomStream random = testing::test_random();
  for (float& z : image.metres) z = random.uniform() < 0.1 ? 0.0F : z * static_cast<float>(1.0 + 0.01 * random.normal());
  return image;
}

/// An organised cloud with a point per pixel; `point_of(u, v)` gives it.
PointCloud organised_cloud(int width, int height, const std::function<Vector3d(int, int)>& point_of) {
  PointCloud cloud;
  cloud.resize(static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
  cloud.width = width;
  cloud.height = height;
  std::size_t i = 0;
  for (int v = 0; v < height; ++v) {
    for (int u = 0; u < width; ++u) cloud.set(i++, point_of(u, v).cast<float>());
  }
  return cloud;
}

PointCloud cloud_of_image(FloatImage& image) {
  return organised_cloud(image.camera.width, image.camera.height, [&](int u, int v) -> Vector3d {
    const auto z = static_cast<double>(image.at(u, v));
    return (z > 0.0 ? z : kNaN) * testing::ray(image.camera, u, v);
  });
}

OrganisedDepth recovered(const PointCloud& cloud) {
  OrganisedDepth depth;
  const Status status = organised_depth(cloud, depth);
  EXPECT_TRUE(status) << (status ? "" : status.error().message);
  return depth;
}

void expect_camera(const Camera& found, const Camera& truth) {
  EXPECT_EQ(found.width, truth.width);
  EXPECT_EQ(found.height, truth.height);
  // Coordinates are floats: 6e-8 of a few metres, some thousand points.
  EXPECT_NEAR(found.fx, truth.fx, 1e-4);
  EXPECT_NEAR(found.fy, truth.fy, 1e-4);
  EXPECT_NEAR(found.cx, truth.cx, 1e-4);
  EXPECT_NEAR(found.cy, truth.cy, 1e-4);
}

TEST(OrganisedDepth, IntrinsicsAndDepthComeBackWhateverTheNoiseInDepth) {
  FloatImage image = noisy_image();
  const OrganisedDepth depth = recovered(cloud_of_image(image));
  expect_camera(depth.camera, image.camera);
  EXPECT_EQ(depth.metres, image.metres);
  EXPECT_LT(depth.max_px, 1e-4);
  EXPECT_LE(depth.rms_px, depth.max_px * std::sqrt(2.0));
  EXPECT_TRUE(validate(depth.view()));
}

TEST(OrganisedDepth, PointsAtTheOriginAreNoMeasurement) {
  FloatImage image = noisy_image();
  PointCloud cloud = cloud_of_image(image);
  for (std::size_t i = 0; i < cloud.size(); i += 7) {
    cloud.set(i, Eigen::Vector3f::Zero());
    image.metres[i] = 0.0F;
  }
  const OrganisedDepth depth = recovered(cloud);
  expect_camera(depth.camera, image.camera);
  EXPECT_EQ(depth.metres, image.metres);
}

TEST(OrganisedDepth, ACroppedImageHasAnotherPrincipalPoint) {
  FloatImage image = noisy_image();
  const PointCloud whole = cloud_of_image(image);
  const PointCloud part =
      organised_cloud(30, 20, [&](int u, int v) { return whole.point(static_cast<std::size_t>((v + 35) * 80 + u + 45)); });
  Camera camera = image.camera;
  camera.width = 30;
  camera.height = 20;
  camera.cx -= 45.0;
  camera.cy -= 35.0;
  // A third of the image, off the axis: the centre is extrapolated over some 20 px.
  const OrganisedDepth depth = recovered(part);
  EXPECT_NEAR(depth.camera.fx, camera.fx, 1e-3);
  EXPECT_NEAR(depth.camera.fy, camera.fy, 1e-3);
  EXPECT_NEAR(depth.camera.cx, camera.cx, 1e-3);
  EXPECT_NEAR(depth.camera.cy, camera.cy, 1e-3);
}

TEST(OrganisedDepth, CoordinatesRoundedToMillimetresAreStillOfTheirPixels) {
  FloatImage image = noisy_image();
  const PointCloud exact = cloud_of_image(image);
  const PointCloud rounded = organised_cloud(80, 60, [&](int u, int v) -> Vector3d {
    return (exact.point(static_cast<std::size_t>(v * 80 + u)) * 1000.0).array().round() / 1000.0;
  });
  const OrganisedDepth depth = recovered(rounded);
  // 0.5 mm at 1 m and more is 0.04 px; of thousands of points the mean is far better.
  EXPECT_NEAR(depth.camera.fx, image.camera.fx, 0.01);
  EXPECT_NEAR(depth.camera.cx, image.camera.cx, 0.01);
  EXPECT_GT(depth.max_px, 1e-3);
}

TEST(OrganisedDepth, AnArrayIsReused) {
  FloatImage image = noisy_image();
  const PointCloud cloud = cloud_of_image(image);
  OrganisedDepth depth = recovered(cloud);
  const float* const memory = depth.metres.data();
  EXPECT_TRUE(organised_depth(cloud, depth));
  EXPECT_EQ(depth.metres.data(), memory);
}

// ---- what is no image of a pinhole camera ----

struct Refused {
  const char* reason;
  PointCloud cloud;
};

std::vector<Refused> refused_clouds() {
  FloatImage image = noisy_image();
  const PointCloud good = cloud_of_image(image);
  std::vector<Refused> all;
  const auto changed = [&](const char* reason, const std::function<Vector3d(const Vector3d&)>& change) {
    all.push_back({reason, organised_cloud(80, 60, [&](int u, int v) -> Vector3d {
                     return change(good.point(static_cast<std::size_t>(v * 80 + u)));
                   })});
  };
  PointCloud unorganised = good;
  unorganised.width = static_cast<int>(good.size());
  unorganised.height = 1;
  all.push_back({"not organised", unorganised});
  PointCloud far_away = good;
  far_away.origin = {400000.0, 5000000.0, 200.0};
  all.push_back({"large coordinates", far_away});
  all.push_back({"only 0 points", organised_cloud(80, 60, [](int, int) -> Vector3d { return Vector3d::Zero(); })});
  // A parallel projection: x = 1 cm times the column, whatever the depth.
  all.push_back({"beside their own", organised_cloud(80, 60, [&](int u, int v) -> Vector3d {
                   return {0.01 * (u - 40), 0.01 * (v - 30), 1.0 + 0.01 * u + 0.2 * std::sin(0.3 * v)};
                 })});
  // A laser scanner of 64 beams that turns around: points all around it.
  all.push_back({"in front of it", organised_cloud(180, 64, [](int u, int v) -> Vector3d {
                   const double azimuth = u * 2.0 * 3.14159265358979 / 180.0;
                   const double elevation = (v - 32) * 0.4 * 3.14159265358979 / 180.0;
                   return 5.0 * Vector3d(std::cos(elevation) * std::cos(azimuth), std::cos(elevation) * std::sin(azimuth),
                                         std::sin(elevation));
                 })});
  // The same with all it sees in front: 80 degrees, equal angles instead of equal steps on the image plane.
  all.push_back({"beside their own", organised_cloud(80, 60, [](int u, int v) -> Vector3d {
                   const double azimuth = (u - 40) * 3.14159265358979 / 180.0;
                   const double elevation = (v - 30) * 0.4 * 3.14159265358979 / 180.0;
                   return 3.0 * Vector3d(std::cos(elevation) * std::sin(azimuth), std::sin(elevation),
                                         std::cos(elevation) * std::cos(azimuth));
                 })});
  // A camera's cloud in other frames: x forward (REP 103's body), y up, moved, turned by 5 degrees.
  changed("in front of it", [](const Vector3d& p) -> Vector3d { return {p.z(), -p.x(), -p.y()}; });
  changed("y does not grow", [](const Vector3d& p) -> Vector3d { return {p.x(), -p.y(), p.z()}; });
  changed("x does not grow", [](const Vector3d& p) -> Vector3d { return {-p.x(), p.y(), p.z()}; });
  changed("beside their own", [](const Vector3d& p) -> Vector3d { return p + Vector3d(0.3, 0.0, 0.0); });
  changed("beside their own", [](const Vector3d& p) -> Vector3d { return Eigen::AngleAxisd(0.09, Vector3d::UnitY()) * p; });
  // Barrel distortion of 2 px at the border.
  changed("beside their own", [&](const Vector3d& p) -> Vector3d {
    const double r2 = (p.x() * p.x() + p.y() * p.y()) / (p.z() * p.z());
    return {p.x() * (1.0 + 0.15 * r2), p.y() * (1.0 + 0.15 * r2), p.z()};
  });
  return all;
}

TEST(OrganisedDepth, WhatIsNoImageOfAPinholeCameraIsRefused) {
  for (const Refused& refused : refused_clouds()) {
    OrganisedDepth depth;
    const Status status = organised_depth(refused.cloud, depth);
    ASSERT_FALSE(status) << refused.reason;
    EXPECT_EQ(status.error().code, ErrorCode::unsupported);
    EXPECT_THAT(status.error().message, HasSubstr(refused.reason));
  }
  PointCloud lying;
  lying.resize(100);
  lying.width = 20;
  lying.height = 6;
  OrganisedDepth depth;
  const Status status = organised_depth(lying, depth);
  ASSERT_FALSE(status);
  EXPECT_EQ(status.error().code, ErrorCode::invalid_argument);
}

// ---- segmentation ----

TEST(SegmentOrganised, CellsOnACloudIsCellsOnItsDepthImage) {
  FloatImage image(testing::small_camera());
  image.draw(*make_plane({0.2, -0.5, -1.0}, 1.5));
  SegmentOptions options;
  options.method = Method::cells;
  const PointCloud cloud = cloud_of_image(image);
  const OrganisedDepth depth = recovered(cloud);
  const auto of_cloud = segment(cloud, options);
  const auto of_depth = segment(depth.view(), depth.camera, options);
  ASSERT_EQ(of_cloud.ok(), of_depth.ok());
  if (of_cloud) {
    testing::expect_same(*of_cloud, *of_depth);
  } else {
    EXPECT_EQ(of_cloud.error().message, of_depth.error().message);
  }
}

TEST(SegmentOrganised, PointsAreNotCorrectedAsDepthIs) {
  FloatImage image(testing::small_camera(320, 240));
  image.draw(*make_plane({0.2, -0.5, -1.0}, 1.5));
  SegmentOptions options;
  options.method = Method::cells;
  const PointCloud cloud = cloud_of_image(image);
  const auto plain = segment(cloud, options);
  options.sensor.distortion = {.width = 320, .height = 240};
  options.sensor.distortion.offset_per_m.fill(0.05);
  const auto corrected = segment(cloud, options);
  ASSERT_TRUE(plain && corrected);
  ASSERT_FALSE(plain->planes.empty());
  testing::expect_same(*corrected, *plain);
}

TEST(SegmentOrganised, ADistortionThatIsNoneIsRefusedAsForDepthImages) {
  FloatImage image(testing::small_camera());
  image.draw(*make_plane({0.2, -0.5, -1.0}, 1.5));
  SegmentOptions options;
  options.sensor.distortion = {.width = 80, .height = 60};
  options.sensor.distortion.gain[0] = std::nan("");
  const auto of_cloud = segment(cloud_of_image(image), options);
  ASSERT_FALSE(of_cloud);
  EXPECT_THAT(of_cloud.error().message, HasSubstr("distortion gain"));
}

TEST(SegmentOrganised, OtherCloudsAreForFransac) {
  for (const Refused& refused : refused_clouds()) {
    SegmentOptions options;
    options.method = Method::cells;
    const auto cells = segment(refused.cloud, options);
    ASSERT_FALSE(cells);
    EXPECT_EQ(cells.error().code, ErrorCode::unsupported);
    EXPECT_THAT(cells.error().message, HasSubstr("cells needs a depth image or an organised cloud of a pinhole camera: "));
    EXPECT_THAT(cells.error().message, HasSubstr(refused.reason));
    options.method = Method::automatic;
    const auto automatic = segment(refused.cloud, options);
    options.method = Method::fransac;
    const auto fransac = segment(refused.cloud, options);
    ASSERT_EQ(automatic.ok(), fransac.ok()) << refused.reason;
    if (automatic) testing::expect_same(*automatic, *fransac);
  }
}

}  // namespace
}  // namespace fransac
