// SPDX-License-Identifier: Apache-2.0
// The smallest rectangle around points, against a search over all directions.
#include "obstacles/footprint.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "property.hpp"

namespace fransac::obstacles {
namespace {

using Eigen::Vector2d;
using testing::any_number;
using testing::check_property;

std::vector<Vector2d> any_points() {
  const int count = *rc::gen::inRange(1, 40);
  const double stretch = any_number(0.0, 1.0);
  const double turn = any_number(0.0, std::numbers::pi);
  std::vector<Vector2d> points;
  for (int i = 0; i < count; ++i) {
    const Vector2d p(any_number(-1.0, 1.0), stretch * any_number(-1.0, 1.0));
    points.emplace_back(std::cos(turn) * p.x() - std::sin(turn) * p.y() + 3.0, std::sin(turn) * p.x() + std::cos(turn) * p.y());
  }
  return points;
}

/// Length and width of the box around points in a direction.
Vector2d sides_along(const std::vector<Vector2d>& points, double angle) {
  const Vector2d along(std::cos(angle), std::sin(angle));
  Vector2d low = Vector2d::Constant(1e9);
  Vector2d high = -low;
  for (const Vector2d& p : points) {
    const Vector2d q(p.dot(along), p.dot(Vector2d(-along.y(), along.x())));
    low = low.cwiseMin(q);
    high = high.cwiseMax(q);
  }
  return high - low;
}

Rectangle rectangle_of(const std::vector<Vector2d>& points) {
  Footprint footprint;
  for (const Vector2d& point : points) footprint.add(point);
  return footprint.rectangle();
}

/// How far the farthest point is outside.
double outside(const Rectangle& rectangle, const std::vector<Vector2d>& points) {
  const Vector2d along(std::cos(rectangle.yaw_rad), std::sin(rectangle.yaw_rad));
  double most = 0.0;
  for (const Vector2d& point : points) {
    const Vector2d p = point - rectangle.centre;
    most = std::max({most, std::abs(p.dot(along)) - 0.5 * rectangle.length,
                     std::abs(p.dot(Vector2d(-along.y(), along.x()))) - 0.5 * rectangle.width});
  }
  return most;
}

TEST(FootprintProperty, HoldsEveryPointAndIsNoLargerThanAnyOther) {
  check_property(300, [] {
    const std::vector<Vector2d> points = any_points();
    const Rectangle rectangle = rectangle_of(points);
    RC_ASSERT(rectangle.length >= rectangle.width && rectangle.width >= 0.0);
    RC_ASSERT(rectangle.yaw_rad > -0.5 * std::numbers::pi && rectangle.yaw_rad <= 0.5 * std::numbers::pi);
    double least = 1e9;
    for (int tenth = 0; tenth < 900; ++tenth) {
      least = std::min(least, sides_along(points, tenth * std::numbers::pi / 1800.0).prod());
    }
    RC_ASSERT(rectangle.length * rectangle.width <= least + 1e-9);
    // Between two directions a corner may be missed that is flatter than the angle between them: it sticks out of the side
    // below it by no more than half the side times the tangent of half the angle.
    const double flat = 0.5 * std::tan(0.5 * std::numbers::pi / Footprint::kDirections);
    RC_ASSERT(outside(rectangle, points) <= flat * std::hypot(rectangle.length, rectangle.width) * (1.0 + flat) + 1e-9);
  });
}

TEST(FootprintProperty, ARectangleIsFoundExactly) {
  check_property(300, [] {
    const double length = any_number(0.1, 2.0);
    const double width = any_number(0.0, 0.99) * length;
    const double yaw = any_number(-1.57, 1.57);
    const Vector2d centre(any_number(-3.0, 3.0), any_number(-3.0, 3.0));
    const Vector2d along(std::cos(yaw), std::sin(yaw));
    const Vector2d across(-along.y(), along.x());
    std::vector<Vector2d> points;
    for (const double a : {-0.5, 0.1, 0.5}) {
      for (const double b : {-0.5, 0.2, 0.5}) points.push_back(centre + a * length * along + b * width * across);
    }
    const Rectangle rectangle = rectangle_of(points);
    RC_ASSERT(std::abs(rectangle.length - length) < 1e-9);
    RC_ASSERT(std::abs(rectangle.width - width) < 1e-9);
    RC_ASSERT((rectangle.centre - centre).norm() < 1e-9);
    RC_ASSERT(std::abs(std::sin(rectangle.yaw_rad - yaw)) < 1e-6);
  });
}

TEST(FootprintProperty, APointAndALineAreRectangles) {
  const Rectangle point = rectangle_of({{1.0, 2.0}, {1.0, 2.0}});
  EXPECT_EQ(point.length, 0.0);
  EXPECT_EQ(point.width, 0.0);
  EXPECT_EQ(point.centre, Vector2d(1.0, 2.0));
  const Rectangle line = rectangle_of({{0.0, 0.0}, {0.25, 0.25}, {1.0, 1.0}});
  EXPECT_NEAR(line.length, std::sqrt(2.0), 1e-12);
  EXPECT_NEAR(line.width, 0.0, 1e-12);
  EXPECT_NEAR(line.yaw_rad, 0.25 * std::numbers::pi, 1e-12);
}

}  // namespace
}  // namespace fransac::obstacles
