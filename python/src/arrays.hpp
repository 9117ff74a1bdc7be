// SPDX-License-Identifier: Apache-2.0
// NumPy arrays in and out.
#pragma once

#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>

#include <Eigen/Core>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "errors.hpp"
#include "fransac/core/depth_image.hpp"
#include "fransac/core/point_cloud.hpp"

namespace fransac::python {

using Array = nb::ndarray<nb::ro, nb::device::cpu>;
using Shape = std::vector<std::size_t>;

/// "(480, 640)"
std::string shape_text(const Array& array);

/// Any array in this machine's memory, in place. TypeError names the argument and what is expected.
Array import_array(const char* argument, nb::handle given, const char* expected);

/// Where depth goes that cannot be read in place.
struct DepthBuffer {
  std::vector<std::uint16_t> units;
  std::vector<float> metres;
};

/// A depth image as Python gave it. Rows of uint16 and float32 whose values lie side by side are read in place; others are
/// copied once, and float64 is rounded to float32. Whole numbers of other types are taken where uint16 holds them all; what a
/// masked array hides is no measurement. TypeError and ValueError name the argument.
class DepthInput {
 public:
  DepthInput(const char* argument, nb::handle given);
  [[nodiscard]] int width() const { return static_cast<int>(array_.shape(1)); }
  [[nodiscard]] int height() const { return static_cast<int>(array_.shape(0)); }
  /// Valid while this and the buffer live. Needs no GIL.
  [[nodiscard]] DepthView view(double depth_scale, DepthBuffer& buffer) const;

 private:
  Array array_;
};

/// Points as Python gave them: (N, 3) or (H, W, 3), float32 or float64, with any strides; other numbers are converted where that
/// loses nothing, a fourth value of each point is not looked at, and what a masked array hides is NaN.
class PointsInput {
 public:
  PointsInput(const char* argument, nb::handle given);
  [[nodiscard]] bool is_double() const;
  [[nodiscard]] std::size_t size() const;  ///< Points.
  /// The shape without its last axis, of length 3 or 4.
  [[nodiscard]] Shape shape() const;
  /// Every point; those that are not finite become NaN. Organised where the shape has rows. Reads the array in place,
  /// whatever its strides; needs no GIL.
  void load(PointCloud& cloud) const;
  /// The finite points alone; `cloud.source` says which they are.
  void load_finite(PointCloud& cloud) const;

 private:
  Array array_;
};

/// One label per pixel or point, uint8, read in place where the array has no gaps.
class LabelsInput {
 public:
  LabelsInput(const char* argument, nb::handle given);
  [[nodiscard]] std::span<const std::uint8_t> labels() const;
  [[nodiscard]] Shape shape() const;

 private:
  Array array_;
  std::vector<std::uint8_t> copy_;
};

/// An array of memory that `owner` keeps alive.
template <class T>
nb::object array_of(T* data, const Shape& shape, nb::handle owner) {
  return nb::cast(nb::ndarray<nb::numpy, T>(data, shape.size(), shape.data(), owner), nb::rv_policy::reference);
}

/// An array with a copy of its own.
template <class T>
nb::object copied_array(const T* data, const Shape& shape) {
  return nb::cast(nb::ndarray<nb::numpy, T>(const_cast<T*>(data), shape.size(), shape.data()), nb::rv_policy::copy);
}

/// An array that takes over a vector.
template <class Vector>
nb::object array_from(Vector&& values, const Shape& shape) {
  auto* const held = new Vector(std::forward<Vector>(values));
  const nb::capsule owner(held, [](void* p) noexcept { delete static_cast<Vector*>(p); });
  return array_of(held->data(), shape, owner);
}

nb::object to_numpy(const Eigen::Vector3d& vector);
nb::object to_numpy(const Eigen::Matrix3d& matrix);
nb::object to_numpy(const Eigen::Matrix4d& matrix);

// The types of what these return, for signatures.
#define FRANSAC_VECTOR "numpy.typing.NDArray[numpy.float64]"

}  // namespace fransac::python
