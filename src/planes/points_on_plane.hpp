// SPDX-License-Identifier: Apache-2.0
/// What is measured of a plane by the points of a cloud that lie on it.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <algorithm>
#include <atomic>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

#include "fransac/core/plane.hpp"

namespace fransac {

/// A plane with two directions in it.
struct PlaneFrame {
  explicit PlaneFrame(const Plane& p) : plane(p), e1(p.normal.unitOrthogonal()), e2(p.normal.cross(e1)) {}
  /// Where a point lies along the two, metres.
  [[nodiscard]] Eigen::Vector2d place(const Eigen::Vector3d& point) const { return {e1.dot(point), e2.dot(point)}; }

  Plane plane;
  Eigen::Vector3d e1;
  Eigen::Vector3d e2;
};

/// The points of one plane.
struct PointsOnPlane {
  std::uint64_t count = 0;
  double squared_distance = 0.0;
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  Eigen::Vector2d low = Eigen::Vector2d::Constant(std::numeric_limits<double>::infinity());  ///< The rectangle around them.
  Eigen::Vector2d high = -low;

  void add(const PlaneFrame& frame, const Eigen::Vector3d& point) {
    const double distance = frame.plane.signed_distance(point);
    const Eigen::Vector2d place = frame.place(point);
    ++count;
    squared_distance += distance * distance;
    sum += point;
    low = low.cwiseMin(place);
    high = high.cwiseMax(place);
  }
  PointsOnPlane& operator+=(const PointsOnPlane& other) {
    count += other.count;
    squared_distance += other.squared_distance;
    sum += other.sum;
    low = low.cwiseMin(other.low);
    high = high.cwiseMax(other.high);
    return *this;
  }
};

/// Which square cells of the rectangle around a plane's points hold one.
class OccupiedCells {
 public:
  /// No cell is; they are of at least `cell_m`, and so large that not too many of them fill the rectangle.
  void restart(const PointsOnPlane& points, double cell_m) {
    constexpr double kMostCells = 0x1p27;  // 16 MiB
    if (points.count == 0) return;
    low_ = points.low;
    size_ = points.high - points.low;
    cell_m_ = std::clamp(cell_m, 0x1p-31 * size_.maxCoeff(), std::max(size_.maxCoeff(), std::numeric_limits<double>::min()));
    while ((size_ / cell_m_ + Eigen::Vector2d::Ones()).prod() > kMostCells) cell_m_ *= 2.0;
    resize();
  }

  /// From several threads at once.
  void add(const Eigen::Vector2d& place) {
    const Eigen::Vector2d at = (place - low_) * per_cell_;
    const std::size_t cell = static_cast<std::size_t>(at.y()) * columns_ + static_cast<std::size_t>(at.x());
    std::atomic_ref<std::uint64_t> word(words_[cell / kBits]);
    const std::uint64_t bit = std::uint64_t{1} << cell % kBits;
    if ((word.load(std::memory_order_relaxed) & bit) == 0) word.fetch_or(bit, std::memory_order_relaxed);
  }

  /// Of the occupied cells, m^2: made twice as large until they hold enough of `points` each. At most that of the rectangle.
  double area(std::uint64_t points) {
    constexpr double kPointsPerCell = 4.0;  // evenly spread points then leave e^-4 = 2 % of the cells empty
    if (points == 0) return 0.0;
    double occupied = count();
    while (kPointsPerCell * occupied > static_cast<double>(points) && cell_m_ <= size_.maxCoeff()) {
      halve();
      occupied = count();
    }
    return std::min(occupied * cell_m_ * cell_m_, size_.prod());
  }

 private:
  static constexpr std::size_t kBits = 64;

  void resize() {
    per_cell_ = 1.0 / cell_m_;  // half of it is exact, so that cells halve exactly
    columns_ = static_cast<std::size_t>(size_.x() * per_cell_) + 1;
    words_.assign(columns_ * (static_cast<std::size_t>(size_.y() * per_cell_) + 1) / kBits + 1, 0);
  }

  [[nodiscard]] double count() const {
    std::size_t count = 0;
    for (const std::uint64_t word : words_) count += static_cast<std::size_t>(std::popcount(word));
    return static_cast<double>(count);
  }

  /// Half as many along each side.
  void halve() {
    finer_.swap(words_);
    const std::size_t columns = columns_;
    cell_m_ *= 2.0;
    resize();
    for (std::size_t i = 0; i < finer_.size(); ++i) {
      for (std::uint64_t left = finer_[i]; left != 0; left &= left - 1) {
        const std::size_t cell = i * kBits + static_cast<std::size_t>(std::countr_zero(left));
        const std::size_t half = cell / columns / 2 * columns_ + cell % columns / 2;
        words_[half / kBits] |= std::uint64_t{1} << half % kBits;
      }
    }
  }

  Eigen::Vector2d low_ = Eigen::Vector2d::Zero();
  Eigen::Vector2d size_ = Eigen::Vector2d::Zero();
  double cell_m_ = 1.0;
  double per_cell_ = 1.0;
  std::size_t columns_ = 0;
  std::vector<std::uint64_t> words_;
  std::vector<std::uint64_t> finer_;
};

}  // namespace fransac
