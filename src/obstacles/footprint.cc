// SPDX-License-Identifier: Apache-2.0
#include "obstacles/footprint.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <numbers>

namespace fransac::obstacles {
namespace {

double cross(const Eigen::Vector2d& a, const Eigen::Vector2d& b) { return a.x() * b.y() - a.y() * b.x(); }

/// A few points, without asking for memory.
class Points {
 public:
  Points() { points_.fill(Eigen::Vector2d::Zero()); }
  void push(const Eigen::Vector2d& point) { points_[size_++] = point; }
  void pop() { --size_; }
  void resize(std::size_t size) { size_ = size; }
  [[nodiscard]] std::size_t size() const { return size_; }
  Eigen::Vector2d* begin() { return points_.data(); }
  Eigen::Vector2d* end() { return points_.data() + size_; }
  [[nodiscard]] const Eigen::Vector2d* begin() const { return points_.data(); }
  [[nodiscard]] const Eigen::Vector2d* end() const { return points_.data() + size_; }
  const Eigen::Vector2d& operator[](std::size_t i) const { return points_[i]; }
  [[nodiscard]] const Eigen::Vector2d& back() const { return points_[size_ - 1]; }

 private:
  std::array<Eigen::Vector2d, 2 * Footprint::kExtremes> points_;
  std::size_t size_ = 0;
};

/// Andrew's monotone chain ("Another efficient algorithm for convex hulls in two dimensions", Inf. Proc. Letters 9(5), 1979).
Points hull(Points points) {
  std::sort(points.begin(), points.end(),
            [](const auto& a, const auto& b) { return a.x() < b.x() || (a.x() == b.x() && a.y() < b.y()); });
  points.resize(static_cast<std::size_t>(std::unique(points.begin(), points.end()) - points.begin()));
  if (points.size() < 3) return points;
  Points chain;
  const auto half = [&](auto begin, auto end) {
    const std::size_t base = chain.size();
    for (auto point = begin; point != end; ++point) {
      while (chain.size() >= base + 2 && cross(chain.back() - chain[chain.size() - 2], *point - chain.back()) <= 0.0) chain.pop();
      chain.push(*point);
    }
    chain.pop();  // the other half's first
  };
  half(points.begin(), points.end());
  half(std::make_reverse_iterator(points.end()), std::make_reverse_iterator(points.begin()));
  return chain;
}

Rectangle along(const Points& points, const Eigen::Vector2d& direction) {
  const Eigen::Vector2d across(-direction.y(), direction.x());
  Eigen::Vector2d low = Eigen::Vector2d::Constant(std::numeric_limits<double>::infinity());
  Eigen::Vector2d high = -low;
  for (const Eigen::Vector2d& point : points) {
    const Eigen::Vector2d p(point.dot(direction), point.dot(across));
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
  }
  const Eigen::Vector2d size = high - low;
  const Eigen::Vector2d middle = 0.5 * (low + high);
  const bool turned = size.y() > size.x();
  const Eigen::Vector2d& longer = turned ? across : direction;
  double yaw = std::atan2(longer.y(), longer.x());
  if (yaw > 0.5 * std::numbers::pi) yaw -= std::numbers::pi;
  if (yaw <= -0.5 * std::numbers::pi) yaw += std::numbers::pi;
  return {middle.x() * direction + middle.y() * across, size.maxCoeff(), size.minCoeff(), yaw};
}

}  // namespace

void Footprint::add(const Eigen::Vector2d& point) {
  static const Reaches kCosines = Reaches::LinSpaced(0.0, std::numbers::pi * (kDirections - 1) / kDirections).cos();
  static const Reaches kSines = Reaches::LinSpaced(0.0, std::numbers::pi * (kDirections - 1) / kDirections).sin();
  static const Rough kRoughCosines = kCosines.cast<float>();
  static const Rough kRoughSines = kSines.cast<float>();
  const Eigen::Vector2f rough = point.cast<float>();
  const Rough about = rough.x() * kRoughCosines + rough.y() * kRoughSines;
  if ((about - inner_most_).max(inner_least_ - about).maxCoeff() < 0.0F) return;  // most are within what was seen before
  const Reaches reach = point.x() * kCosines + point.y() * kSines;
  size_ = std::max(size_, point.lpNorm<1>());
  constexpr double kRounding = 0x1p-20;  // several times that of what is computed in floats
  const double rounding = kRounding * size_;
  for (Eigen::Index k = 0; k < kDirections; ++k) {
    if (reach[k] > most_[k]) {
      most_[k] = reach[k];
      inner_most_[k] = static_cast<float>(reach[k] - rounding);
      extremes_[static_cast<std::size_t>(2 * k)] = point;
    }
    if (reach[k] < least_[k]) {
      least_[k] = reach[k];
      inner_least_[k] = static_cast<float>(reach[k] + rounding);
      extremes_[static_cast<std::size_t>(2 * k + 1)] = point;
    }
  }
}

/// One side of the least rectangle lies on a side of the hull (Freeman and Shapira, "Determining the minimum-area encasing
/// rectangle for an arbitrary closed curve", CACM 18(7), 1975).
Rectangle Footprint::rectangle() const {
  Points points;
  for (const Eigen::Vector2d& extreme : extremes_) points.push(extreme);
  const Points corners = hull(points);
  Rectangle best = along(corners, Eigen::Vector2d::UnitX());
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < corners.size() && corners.size() > 1; ++i) {
    const Eigen::Vector2d side = corners[(i + 1) % corners.size()] - corners[i];
    const Rectangle rectangle = along(corners, side.normalized());
    // Of equal areas, as a line's are, the shorter boundary.
    const double size = rectangle.length * rectangle.width + 1e-9 * (rectangle.length + rectangle.width);
    if (size >= least) continue;
    least = size;
    best = rectangle;
  }
  return best;
}

}  // namespace fransac::obstacles
