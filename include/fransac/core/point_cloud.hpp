// SPDX-License-Identifier: Apache-2.0
/// Points as a structure of arrays.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string_view>

#include "fransac/core/aligned.hpp"
#include "fransac/core/result.hpp"

namespace fransac {

/// Points in somebody else's memory, metres: x, y and z of each side by side, as in PCL's point types and in arrays of N x 3.
struct PointsView {
  const float* data = nullptr;  ///< x, y and z of the first point.
  std::size_t size = 0;         ///< Points.
  std::size_t stride = 3;       ///< Floats from one point to the next, 3 or more.
};

/// A point cloud as three aligned float arrays. The arrays are readable up to `padded_size()`; the padding is NaN, so a
/// kernel may work in whole vectors: a NaN is an inlier of nothing. A point of an organised cloud that was not measured
/// is NaN as well and never a point at the origin.
///
/// Coordinates are metres relative to `origin`, which is kept in double: a cloud in UTM coordinates loses nothing.
class PointCloud {
 public:
  /// Points that one padded block holds.
  static constexpr std::size_t kBlock = kAlignment / sizeof(float);

  /// No points.
  PointCloud() = default;

  [[nodiscard]] std::size_t size() const { return size_; }  ///< Points.
  [[nodiscard]] bool empty() const { return size_ == 0; }   ///< Whether there are none.
  /// Points of all blocks, padding included.
  [[nodiscard]] std::size_t padded_size() const { return (size_ + kBlock - 1) / kBlock * kBlock; }

  [[nodiscard]] const float* x() const { return x_.data(); }  ///< padded_size() values, metres, relative to `origin`.
  [[nodiscard]] const float* y() const { return y_.data(); }  ///< Likewise.
  [[nodiscard]] const float* z() const { return z_.data(); }  ///< Likewise.
  float* x() { return x_.data(); }                            ///< Likewise.
  float* y() { return y_.data(); }                            ///< Likewise.
  float* z() { return z_.data(); }                            ///< Likewise.

  /// The i-th point relative to `origin`.
  [[nodiscard]] Eigen::Vector3d local(std::size_t i) const {
    return {static_cast<double>(x_[i]), static_cast<double>(y_[i]), static_cast<double>(z_[i])};
  }
  /// The i-th point in the coordinates of the input.
  [[nodiscard]] Eigen::Vector3d point(std::size_t i) const { return local(i) + origin; }
  /// Whether the i-th point has three finite coordinates.
  [[nodiscard]] bool finite(std::size_t i) const;
  /// Whether the i-th point is a measurement: finite, and not exactly (0, 0, 0) in the coordinates of the input. That is what
  /// many drivers write where nothing came back; thousands of such "points" would pull every plane through the sensor.
  [[nodiscard]] bool measured(std::size_t i) const;

  /// Sets the number of points; new points and the padding are NaN. Keeps capacity when shrinking.
  void resize(std::size_t size);
  /// Sets the number of points without touching those that stay and without initialising new ones; only the padding is set.
  void resize_uninitialised(std::size_t size);
  /// Removes all points; capacity stays.
  void clear() { resize_uninitialised(0); }
  /// Sets the i-th point, relative to `origin`.
  void set(std::size_t i, const Eigen::Vector3f& local_point);

  /// Metres, none beyond kMaxCoordinate_m; added to every coordinate.
  Eigen::Vector3d origin = Eigen::Vector3d::Zero();
  /// Where the sensor was, in the coordinates of the input, metres, none beyond kMaxCoordinate_m. Unset: unknown.
  std::optional<Eigen::Vector3d> sensor_position;
  /// Organised clouds: columns, width * height == size(). Unorganised: height 1 (width = size()) or both 0.
  int width = 0;
  int height = 0;                                              ///< Rows, likewise.
  [[nodiscard]] bool organised() const { return height > 1; }  ///< Whether it has rows and columns.

  /// Index in the input (pixel v * width + u, or point) of each point of a filtered cloud; empty: the identity.
  AlignedVector<std::uint32_t> source;
  /// The i-th point's index in the input.
  [[nodiscard]] std::uint32_t source_of(std::size_t i) const {
    return source.empty() ? static_cast<std::uint32_t>(i) : source[i];
  }

 private:
  void pad();

  AlignedVector<float> x_;
  AlignedVector<float> y_;
  AlignedVector<float> z_;
  std::size_t size_ = 0;
};

/// Largest coordinate of a position, metres: a float, and products of two are finite in double.
inline constexpr double kMaxCoordinate_m = 1e30;

/// Whether a position in the input's coordinates, such as a sensor's, is finite and no coordinate is beyond kMaxCoordinate_m.
/// Errors: invalid_argument, with `name` before the message.
Status validate_position(const Eigen::Vector3d& position, std::string_view name);

/// Whether a cloud's size, origin and sensor position can be worked with. Errors: invalid_argument; unsupported for more than
/// 2^31 - 1 points.
Status validate(const PointCloud& cloud);

}  // namespace fransac
