// SPDX-License-Identifier: Apache-2.0
#include "fransac/planes/segment.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <array>
#include <cmath>
#include <numbers>
#include <numeric>
#include <vector>

#include "property/property.hpp"

namespace fransac {
namespace {

using Eigen::Vector3d;
using testing::any_number;

Method any_method() {
  return *rc::gen::elementOf(std::vector<Method>(std::begin(testing::kMethods), std::end(testing::kMethods)));
}

Segmentation segmented(const PointCloud& cloud, const SegmentOptions& options) {
  const Result<Segmentation> result = segment(cloud, options);
  RC_ASSERT(result.ok());
  return *result;
}

/// A plane in view of the camera, 1 to 3 m away and tilted by up to 50 degrees.
Plane any_plane() {
  const double tilt = any_number(0.0, 50.0) * std::numbers::pi / 180.0;
  const double heading = any_number(0.0, 2.0 * std::numbers::pi);
  return {{std::sin(tilt) * std::cos(heading), std::sin(tilt) * std::sin(heading), -std::cos(tilt)}, any_number(1.0, 3.0)};
}

/// Two noisy planes, holes, and pixels anywhere.
testing::FloatImage any_image() {
  RandomStream random = testing::any_stream();
  testing::FloatImage image(testing::small_camera(*rc::gen::inRange(20, 70), *rc::gen::inRange(15, 50)));
  const int border = *rc::gen::inRange(0, image.camera.width);
  image.draw(any_plane(), 0, border);
  image.draw(any_plane(), border, image.camera.width);
  const double noise = any_number(0.0, 0.01);
  for (float& z : image.metres) {
    z += static_cast<float>(noise * random.normal());
    const std::uint32_t fate = random.below(10);
    if (fate == 0) z = 0.0F;
    if (fate == 1) z = static_cast<float>(testing::uniform(random, 0.5, 6.0));
  }
  return image;
}

SegmentOptions any_options() {
  SegmentOptions options;
  options.method = any_method();
  options.max_planes = *rc::gen::inRange(0, 4);
  options.min_support = 0.05;
  options.seed = *rc::gen::arbitrary<std::uint64_t>();
  options.ransac.threshold_m = any_number(0.005, 0.05);
  options.ransac.max_iterations = *rc::gen::inRange(1, 200);
  options.ransac.scoring = *rc::gen::element(sac::Scoring::inliers, sac::Scoring::msac);
  options.ransac.local_optimisation = *rc::gen::arbitrary<bool>();
  options.ransac.refine = *rc::gen::arbitrary<bool>();
  if (*rc::gen::arbitrary<bool>()) {
    options.pass_through.limits = {.axis = *rc::gen::element(Axis::x, Axis::y, Axis::z),
                                   .min_m = any_number(-0.5, 0.5),
                                   .max_m = any_number(1.0, 3.0),
                                   .outside = *rc::gen::arbitrary<bool>()};
  }
  if (*rc::gen::arbitrary<bool>()) options.pass_through.use = *rc::gen::arbitrary<bool>();
  return options;
}

TEST(SegmentProperty, LabelsPartitionThePixels) {
  testing::check_property(60, [] {
    const testing::FloatImage image = any_image();
    const SegmentOptions options = any_options();
    const Result<Segmentation> result = segment(image.view(), image.camera, options);
    if (!result) {
      RC_ASSERT(result.error().code == ErrorCode::no_data);  // limits that keep nothing
      return;
    }
    const Segmentation& s = *result;
    const AxisLimits& limits = options.pass_through.limits;
    const bool limited = options.pass_through.use.value_or(options.method == Method::fransac || limits != AxisLimits{});
    std::vector<std::uint64_t> inliers(256);
    for (int v = 0; v < image.camera.height; ++v) {
      for (int u = 0; u < image.camera.width; ++u) {
        const std::size_t i =
            static_cast<std::size_t>(v) * static_cast<std::size_t>(image.camera.width) + static_cast<std::size_t>(u);
        const std::uint8_t label = s.labels[i];
        const float z = image.metres[i];
        ++inliers[label];
        RC_ASSERT((label == kLabelNoDepth) == !(z > 0.0F));
        if (label == kLabelNoDepth) continue;
        RC_ASSERT((label == kLabelNoPlane || label <= s.planes.size()));

        constexpr double kRounding = 5e-6;  // of float at up to 6 m
        const Vector3d p = static_cast<double>(z) * testing::ray(image.camera, u, v);
        const double c = p[static_cast<int>(limits.axis)];
        const bool near_limit = std::abs(c - limits.min_m) < kRounding || std::abs(c - limits.max_m) < kRounding;
        const bool kept = !limited || (c >= limits.min_m && c <= limits.max_m) != limits.outside;
        double nearest = std::numeric_limits<double>::infinity();
        for (const PlaneSegment& plane : s.planes) nearest = std::min(nearest, std::abs(plane.plane.signed_distance(p)));
        if (label == kLabelNoPlane) {
          RC_ASSERT((!kept || near_limit || nearest > options.ransac.threshold_m - kRounding));
        } else {
          const double distance = std::abs(s.planes[label - kLabelFirst].plane.signed_distance(p));
          RC_ASSERT((kept || near_limit));
          RC_ASSERT(distance <= options.ransac.threshold_m + kRounding);
          RC_ASSERT(distance <= nearest + kRounding);
        }
      }
    }
    for (std::size_t i = 0; i < s.planes.size(); ++i) {
      const PlaneSegment& plane = s.planes[i];
      RC_ASSERT(plane.id == static_cast<int>(i) + kLabelFirst);
      RC_ASSERT(plane.inliers == inliers[static_cast<std::size_t>(plane.id)]);
      RC_ASSERT((i == 0 || plane.support <= s.planes[i - 1].support));
      RC_ASSERT(plane.rms_m <= options.ransac.threshold_m + 5e-6);
      RC_ASSERT(std::abs(plane.plane.normal.norm() - 1.0) < 1e-12);
      RC_ASSERT(plane.plane.d >= 0.0);
    }
    RC_ASSERT(s.valid_points == image.metres.size() - inliers[kLabelNoDepth]);
    RC_ASSERT(s.iterations <= static_cast<std::uint64_t>(options.ransac.max_iterations) * (s.planes.size() + 1));
  });
}

TEST(SegmentProperty, ThreadsChangeNothing) {
  testing::check_property(25, [] {
    const testing::FloatImage image = any_image();
    SegmentOptions options = any_options();
    options.pass_through.use = false;
    options.threads = 1;
    const Result<Segmentation> one = segment(image.view(), image.camera, options);
    for (const int threads : {2, 5}) {
      options.threads = threads;
      const Result<Segmentation> many = segment(image.view(), image.camera, options);
      RC_ASSERT(many.ok() == one.ok());
      if (!one) continue;
      RC_ASSERT(many->labels == one->labels);
      RC_ASSERT(many->planes.size() == one->planes.size());
      for (std::size_t i = 0; i < one->planes.size(); ++i) {
        RC_ASSERT(many->planes[i].plane.normal == one->planes[i].plane.normal);
        RC_ASSERT(many->planes[i].plane.d == one->planes[i].plane.d);
        RC_ASSERT(many->planes[i].support == one->planes[i].support);
      }
      RC_ASSERT(many->iterations == one->iterations);
      RC_ASSERT(many->rejected == one->rejected);
      RC_ASSERT(many->degenerate == one->degenerate);
    }
  });
}

/// Points on a rectangle, with clutter that stays more than 5 cm away from its plane; all within about 3 m of zero.
struct PlaneInClutter {
  Plane plane;
  std::vector<Vector3d> points;
  std::size_t on_plane;
};
PlaneInClutter any_plane_in_clutter() {
  RandomStream random = testing::any_stream();
  PlaneInClutter scene;
  scene.plane = *make_plane(testing::unit_vector(random), any_number(0.2, 1.5));
  const Vector3d e1 = scene.plane.normal.unitOrthogonal();
  const Vector3d e2 = scene.plane.normal.cross(e1);
  scene.on_plane = static_cast<std::size_t>(*rc::gen::inRange(100, 400));
  for (std::size_t i = 0; i < scene.on_plane; ++i) {
    const double a = testing::uniform(random, -1.0, 1.0);
    scene.points.push_back(-scene.plane.d * scene.plane.normal + a * e1 + testing::uniform(random, -1.0, 1.0) * e2);
  }
  for (std::size_t i = 0; i < scene.on_plane / 3;) {
    const Vector3d p = testing::uniform_point(random, -2.0, 2.0);
    if (std::abs(scene.plane.signed_distance(p)) < 0.05) continue;
    scene.points.push_back(p);
    ++i;
  }
  return scene;
}

TEST(SegmentProperty, TheCloudsMotionMovesThePlane) {
  testing::check_property(40, [] {
    const PlaneInClutter scene = any_plane_in_clutter();
    RandomStream random = testing::any_stream();
    const Eigen::AngleAxisd turn(any_number(0.0, std::numbers::pi), testing::unit_vector(random));
    const Vector3d shift = testing::uniform_point(random, -5.0, 5.0);
    std::vector<Vector3d> moved;
    for (const Vector3d& p : scene.points) moved.push_back(turn * p + shift);
    const Plane truth = translated(*make_plane(turn * scene.plane.normal, scene.plane.d), -shift);

    SegmentOptions options;
    options.method = any_method();
    if (uses(options.method, UsedBy::voxel_grid))
      options.voxel_grid.leaf_size_m = 0.001;  // a leaf for each point: the lattice does not turn with the cloud
    const Segmentation a = segmented(testing::cloud_of(scene.points), options);
    const Segmentation b = segmented(testing::cloud_of(moved), options);
    RC_ASSERT((a.planes.size() == 1U && b.planes.size() == 1U));
    RC_ASSERT(angle_between(a.planes[0].plane, scene.plane) < 1e-5);
    RC_ASSERT(std::abs(a.planes[0].plane.d - scene.plane.d) < 1e-5);
    RC_ASSERT(angle_between(b.planes[0].plane, truth) < 1e-5);
    RC_ASSERT(std::abs(b.planes[0].plane.d - truth.d) < 1e-5);
    RC_ASSERT(a.labels == b.labels);
    RC_ASSERT(a.planes[0].inliers == scene.on_plane);
  });
}

TEST(SegmentProperty, OrderOfThePointsChangesOnlyTheOrderOfTheLabels) {
  testing::check_property(40, [] {
    const PlaneInClutter scene = any_plane_in_clutter();
    RandomStream random = testing::any_stream();
    std::vector<std::size_t> order(scene.points.size());
    std::iota(order.begin(), order.end(), std::size_t{0});
    for (std::size_t i = order.size(); i > 1; --i) std::swap(order[i - 1], order[random.below(static_cast<std::uint32_t>(i))]);
    std::vector<Vector3d> shuffled;
    for (const std::size_t i : order) shuffled.push_back(scene.points[i]);

    SegmentOptions options;
    options.method = any_method();
    const Segmentation a = segmented(testing::cloud_of(scene.points), options);
    const Segmentation b = segmented(testing::cloud_of(shuffled), options);
    RC_ASSERT(angle_between(a.planes[0].plane, b.planes[0].plane) < 1e-5);
    RC_ASSERT(std::abs(a.planes[0].plane.d - b.planes[0].plane.d) < 1e-5);
    for (std::size_t i = 0; i < order.size(); ++i) RC_ASSERT(b.labels[i] == a.labels[order[i]]);
  });
}

}  // namespace
}  // namespace fransac
