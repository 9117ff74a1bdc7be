// SPDX-License-Identifier: Apache-2.0
/// Keep the points inside (or outside) an interval of one coordinate.
#pragma once

#include "fransac/core/point_cloud.hpp"
#include "fransac/core/result.hpp"

namespace fransac {

/// A coordinate axis.
enum class Axis { x, y, z };

/// An interval of one coordinate, ends included.
struct AxisLimits {
  Axis axis = Axis::z;   ///< The coordinate that the interval is of.
  double min_m = 0.0;    ///< Metres.
  double max_m = 4.5;    ///< Metres. Zeineldin & El-Fishawy, section 3: Z in 0 to 4.5 m, the Kinect's useful range.
  bool outside = false;  ///< Keep what lies outside the interval instead.

  bool operator==(const AxisLimits&) const = default;
};

/// Limits for coordinates relative to a cloud's origin, as the float comparison that means the same.
struct LocalLimits {
  /// `origin_m` is the cloud's origin along limits.axis.
  explicit LocalLimits(const AxisLimits& limits, double origin_m = 0.0);

  /// Whether a point with this coordinate stays. NaN never does. Free of branches: it runs once per point.
  [[nodiscard]] bool keeps(float coordinate) const {
    const bool inside = (coordinate >= min) & (coordinate <= max);
    const bool comparable = coordinate == coordinate;
    return (inside != outside) & comparable;
  }

  float min;     ///< The smallest float that is not below the lower limit.
  float max;     ///< The largest float that is not above the upper limit.
  bool outside;  ///< As AxisLimits::outside.
};

/// Removes, in place and in order, the points that the limits do not keep, and those that are not finite.
/// `cloud.source` then names the input's points; the cloud is no longer organised.
void pass_through(const AxisLimits& limits, PointCloud& cloud);

/// How many of the points are measurements (PointCloud::measured).
std::size_t count_measured(const PointCloud& cloud);

/// Removes the points that are no measurements (PointCloud::measured); `cloud.source` then names the input's points.
void remove_unmeasured(PointCloud& cloud);

}  // namespace fransac
