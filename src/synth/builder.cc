// SPDX-License-Identifier: Apache-2.0
#include "synth/builder.hpp"

#include <cmath>
#include <utility>

namespace fransac::synth::detail {
namespace {

using Eigen::AlignedBox2d;
using Eigen::Isometry3d;
using Eigen::Vector2d;
using Eigen::Vector3d;

// Neighbouring rectangles of one surface overlap by this much, so that no ray slips through the seam. Metres.
constexpr double kSeam = 1e-7;

Vector3d lift(const Vector2d& p, double z) { return {p.x(), p.y(), z}; }

Isometry3d raised(const Isometry3d& base, double z) { return base * Eigen::Translation3d(0.0, 0.0, z); }

}  // namespace

Isometry3d standing(double x, double y, double z, double yaw) {
  return Eigen::Translation3d(x, y, z) * Eigen::AngleAxisd(yaw, Vector3d::UnitZ());
}

bool Occupancy::free(double x, double y, double radius) const {
  for (const Vector3d& circle : circles_) {
    if (std::hypot(circle.x() - x, circle.y() - y) < circle.z() + radius) return false;
  }
  return true;
}

bool Occupancy::find(Dice& dice, const AlignedBox2d& area, double radius, Vector2d& spot) {
  constexpr int kTries = 100;
  for (int i = 0; i < kTries; ++i) {
    const double x = dice.between(area.min().x(), area.max().x());
    const double y = dice.between(area.min().y(), area.max().y());
    if (!free(x, y, radius)) continue;
    take(x, y, radius);
    spot = {x, y};
    return true;
  }
  return false;
}

void Builder::object() { group(true); }

void Builder::fixture() { group(false); }

void Builder::group(bool free_standing) {
  const int next = static_cast<int>(scene_.primitives.size());
  if (!scene_.objects.empty() && scene_.objects.back().first == next) scene_.objects.pop_back();  // nothing came
  scene_.objects.push_back({next, next, free_standing ? 1 : 0});
}

void Builder::add(Shape shape, const Isometry3d& pose, const Vector3d& half, const Material& material) {
  scene_.primitives.push_back({.shape = shape, .pose = pose, .half = half, .material = material});
  scene_.objects.back().last = static_cast<int>(scene_.primitives.size());
}

void Builder::box(const Isometry3d& base, const Vector3d& size, const Material& material) {
  add(Shape::box, raised(base, 0.5 * size.z()), 0.5 * size, material);
}

void Builder::cylinder(const Isometry3d& base, double radius, double height, const Material& material) {
  add(Shape::cylinder, raised(base, 0.5 * height), {radius, radius, 0.5 * height}, material);
}

void Builder::sphere(const Isometry3d& base, double radius, const Material& material) {
  add(Shape::sphere, raised(base, radius), {radius, radius, radius}, material);
}

void Builder::rectangle(const Isometry3d& pose, double width, double height, const Material& material) {
  add(Shape::rectangle, pose, {0.5 * width + kSeam, 0.5 * height + kSeam, 0.0}, material);
  scene_.primitives.back().pattern_origin = (pose.linear().transpose() * pose.translation()).head<2>();
}

void Builder::level(const AlignedBox2d& area, double z, const Material& material) {
  const Vector2d size = area.sizes();
  rectangle(Isometry3d(Eigen::Translation3d(lift(area.center(), z))), size.x(), size.y(), material);
}

void Builder::upright(const Vector2d& a, const Vector2d& b, double bottom, double top, const Material& material) {
  const Vector2d along = (b - a).normalized();
  Isometry3d pose = Isometry3d::Identity();
  pose.linear().col(0) = lift(along, 0.0);
  pose.linear().col(1) = Vector3d::UnitZ();
  pose.linear().col(2) = Vector3d(along.y(), -along.x(), 0.0);
  pose.translation() = lift(0.5 * (a + b), 0.5 * (bottom + top));
  rectangle(pose, (b - a).norm(), top - bottom, material);
}

void Builder::wall(const Vector2d& a, const Vector2d& b, double bottom, double top, const Material& material,
                   const std::vector<Recess>& recesses) {
  const Vector2d along = (b - a).normalized();
  const Vector2d outward(along.y(), -along.x());
  const auto point = [&](double s) -> Vector2d { return a + s * along; };
  double done = 0.0;
  for (const Recess& r : recesses) {
    if (r.from > done) upright(point(done), point(r.from), bottom, top, material);
    if (r.bottom > bottom) upright(point(r.from), point(r.to), bottom, r.bottom, material);
    if (r.top < top) upright(point(r.from), point(r.to), r.top, top, material);
    const Vector2d in = r.depth * outward;
    for (const double s : {r.from, r.to}) upright(point(s), point(s) + in, r.bottom, r.top, material);
    for (const double z : {r.bottom, r.top}) {
      Isometry3d pose = Isometry3d::Identity();
      pose.linear().col(0) = lift(along, 0.0);
      pose.linear().col(1) = lift(-outward, 0.0);
      pose.translation() = lift(point(0.5 * (r.from + r.to)) + 0.5 * in, z);
      rectangle(pose, r.to - r.from, r.depth, material);
    }
    upright(point(r.from) + in, point(r.to) + in, r.bottom, r.top, r.back);
    scene_.primitives.back().pattern_origin = Vector2d::Zero();  // the back's frame is its own
    done = r.to;
  }
  upright(point(done), b, bottom, top, material);
}

Scene Builder::finish() {
  int things = 0;
  for (Object& object : scene_.objects) {
    if (object.id != 0) object.id = ++things;
  }
  return std::exchange(scene_, {});
}

}  // namespace fransac::synth::detail
