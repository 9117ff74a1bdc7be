// SPDX-License-Identifier: Apache-2.0
#include "arrays.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <functional>
#include <limits>
#include <numeric>

#include "fransac/core/camera.hpp"
#include "fransac/core/labels.hpp"
#include "fransac/core/origin.hpp"

namespace fransac::python {
namespace {

std::string word_of(nb::handle dtype, const char* attribute) { return nb::str(dtype.attr(attribute)).c_str(); }

bool is_numpy(nb::handle given) { return nb::hasattr(given, "dtype") && nb::hasattr(given.attr("dtype"), "isnative"); }

/// A NumPy array in this machine's byte order; what a mask hides is `hidden`, a value of the array's type.
nb::object unmasked(nb::handle given, const nb::object& hidden) {
  nb::object array = nb::borrow(given);
  if (nb::hasattr(array, "mask") && nb::hasattr(array, "filled")) array = array.attr("filled")(hidden);
  const nb::object dtype = array.attr("dtype");
  return nb::cast<bool>(dtype.attr("isnative")) ? array : array.attr("astype")(dtype.attr("newbyteorder")("="));
}

bool is_integer(nb::handle array) {
  const std::string kind = word_of(array.attr("dtype"), "kind");
  return kind == "i" || kind == "u";
}
bool is_half(nb::handle array) { return word_of(array.attr("dtype"), "name") == "float16"; }

/// Whole numbers of other types as uint16, where they fit. A mask hides what is no measurement.
nb::object as_depth(const char* argument, nb::handle given) {
  if (!is_numpy(given)) return nb::borrow(given);
  nb::object array = unmasked(given, nb::int_(0));
  if (is_half(array)) return array.attr("astype")("float32");
  if (!is_integer(array) || word_of(array.attr("dtype"), "name") == "uint16" || nb::cast<std::size_t>(array.attr("size")) == 0) {
    return array;
  }
  const nb::object least = array.attr("min")();
  const nb::object most = array.attr("max")();
  if (nb::cast<double>(nb::float_(least)) < 0.0 || nb::cast<double>(nb::float_(most)) > 65535.0) {
    raise_value_error(std::string(argument) + ": raw depth must be 0 to 65535, these " + word_of(array.attr("dtype"), "name") +
                      " values are " + nb::str(least).c_str() + " to " + nb::str(most).c_str());
  }
  return array.attr("astype")("uint16");
}

/// Whole numbers as float64, where they are exact in it. A mask hides points that were not measured.
nb::object as_points(const char* argument, nb::handle given) {
  if (!is_numpy(given)) return nb::borrow(given);
  nb::object array = nb::borrow(given);
  if (is_half(array)) array = array.attr("astype")("float32");
  if (is_integer(array)) {
    constexpr double kMostExact = 0x1p53;
    const bool empty = nb::cast<std::size_t>(array.attr("size")) == 0;
    const auto value = [&](const char* which) { return empty ? 0.0 : nb::cast<double>(nb::float_(array.attr(which)())); };
    if (value("min") < -kMostExact || value("max") > kMostExact) {
      raise_value_error(std::string(argument) + ": whole numbers beyond 2**53 are not exact in float64");
    }
    array = array.attr("astype")("float64");
  }
  return unmasked(array, nb::float_(std::numeric_limits<double>::quiet_NaN()));
}

template <class T>
bool holds(const Array& array) {
  return array.dtype() == nb::dtype<T>();
}

template <class T>
bool aligned(const Array& array) {
  return reinterpret_cast<std::uintptr_t>(array.data()) % alignof(T) == 0;
}

/// "float16", "int32", …
std::string dtype_text(const Array& array) {
  const auto type = array.dtype();
  const auto code = static_cast<nb::dlpack::dtype_code>(type.code);
  const char* const kind = code == nb::dlpack::dtype_code::Int       ? "int"
                           : code == nb::dlpack::dtype_code::UInt    ? "uint"
                           : code == nb::dlpack::dtype_code::Float   ? "float"
                           : code == nb::dlpack::dtype_code::Complex ? "complex"
                                                                     : "another type of ";
  return code == nb::dlpack::dtype_code::Bool ? "bool" : kind + std::to_string(type.bits);
}

[[noreturn]] void wrong_dtype(const char* argument, const std::string& expected, const Array& array) {
  raise_type_error(std::string(argument) + ": expected " + expected + " values, got " + dtype_text(array));
}

[[noreturn]] void wrong_shape(const char* argument, const std::string& expected, const Array& array) {
  raise_value_error(std::string(argument) + ": expected an array of shape " + expected + ", got " + shape_text(array));
}

/// The value at `offset` values from the array's first, which need not be aligned.
template <class T>
T value_at(const Array& array, std::int64_t offset) {
  T value;
  std::memcpy(&value, static_cast<const std::byte*>(array.data()) + offset * static_cast<std::int64_t>(sizeof(T)), sizeof(T));
  return value;
}

template <class T, class Out>
const Out* copy_rows(const Array& array, std::vector<Out>& out) {
  const std::size_t height = array.shape(0);
  const std::size_t width = array.shape(1);
  out.resize(width * height);
  for (std::size_t v = 0; v < height; ++v) {
    const std::int64_t row = static_cast<std::int64_t>(v) * array.stride(0);
    for (std::size_t u = 0; u < width; ++u) {
      out[v * width + u] = static_cast<Out>(value_at<T>(array, row + static_cast<std::int64_t>(u) * array.stride(1)));
    }
  }
  return out.data();
}

/// Whether a DepthView can see the rows as they are.
template <class T>
bool rows_in_place(const Array& array) {
  const bool side_by_side = array.shape(1) == 1 || array.stride(1) == 1;
  const bool one_after_other = array.shape(0) == 1 || array.stride(0) >= static_cast<std::int64_t>(array.shape(1));
  return side_by_side && one_after_other && aligned<T>(array);
}

template <class T>
std::ptrdiff_t row_stride(const Array& array) {
  return array.shape(0) == 1 ? 0 : static_cast<std::ptrdiff_t>(array.stride(0)) * static_cast<std::ptrdiff_t>(sizeof(T));
}

/// Where the points of an array are, in values from its first: its last axis holds x, y, z.
struct PointLayout {
  explicit PointLayout(const Array& array) {
    const bool image = array.ndim() == 3;
    rows = image ? array.shape(0) : 1;
    columns = array.shape(image ? 1 : 0);
    row_step = image ? array.stride(0) : 0;
    column_step = array.stride(image ? 1 : 0);
    axis_step = array.stride(image ? 2 : 1);
  }
  std::size_t rows;
  std::size_t columns;
  std::int64_t row_step;
  std::int64_t column_step;
  std::int64_t axis_step;
};

template <class T>
Eigen::Matrix<T, 3, 1> point_at(const Array& array, std::int64_t offset, std::int64_t axis_step) {
  return {value_at<T>(array, offset), value_at<T>(array, offset + axis_step), value_at<T>(array, offset + 2 * axis_step)};
}

/// Calls visit(i, point) for every point in order.
template <class T, class Visitor>
void for_each_point(const Array& array, const Visitor& visit) {
  const PointLayout layout(array);
  std::size_t i = 0;
  for (std::size_t v = 0; v < layout.rows; ++v) {
    std::int64_t offset = static_cast<std::int64_t>(v) * layout.row_step;
    for (std::size_t u = 0; u < layout.columns; ++u, offset += layout.column_step) {
      visit(i++, point_at<T>(array, offset, layout.axis_step));
    }
  }
}

template <class T>
Eigen::Vector3d origin_of(const Array& array) {
  bool far = false;  // or not finite
  for_each_point<T>(array, [&](std::size_t, const Eigen::Matrix<T, 3, 1>& point) {
    far |= !(point.cwiseAbs().sum() <= static_cast<T>(kFarFromZero_m));
  });
  if (!far) return Eigen::Vector3d::Zero();
  const PointLayout layout(array);
  return choose_origin(layout.rows * layout.columns, [&](std::size_t i) {
    const auto row = static_cast<std::int64_t>(i / layout.columns);
    const auto column = static_cast<std::int64_t>(i % layout.columns);
    const std::int64_t offset = row * layout.row_step + column * layout.column_step;
    return Eigen::Vector3d(point_at<T>(array, offset, layout.axis_step).template cast<double>());
  });
}

/// Calls visit(i, local point, whether it is finite) in order and sets the origin that the points are relative to.
template <class T, class Visitor>
void visit_points(const Array& array, PointCloud& cloud, const Visitor& visit) {
  cloud.origin = origin_of<T>(array);
  const Eigen::Matrix<T, 3, 1> origin = cloud.origin.cast<T>();
  constexpr T kMost = static_cast<T>(std::numeric_limits<float>::max());
  for_each_point<T>(array, [&](std::size_t i, const Eigen::Matrix<T, 3, 1>& point) {
    const Eigen::Matrix<T, 3, 1> local = point - origin;
    const bool finite = std::abs(local.x()) <= kMost && std::abs(local.y()) <= kMost && std::abs(local.z()) <= kMost;
    visit(i, Eigen::Vector3f(local.template cast<float>()), finite);
  });
}

template <class Visitor>
void visit_points(const Array& array, PointCloud& cloud, const Visitor& visit) {
  if (holds<float>(array)) return visit_points<float>(array, cloud, visit);
  visit_points<double>(array, cloud, visit);
}

}  // namespace

std::string shape_text(const Array& array) {
  std::string text = "(";
  for (std::size_t i = 0; i < array.ndim(); ++i) text += (i == 0 ? "" : ", ") + std::to_string(array.shape(i));
  return text + (array.ndim() == 1 ? ",)" : ")");
}

Array import_array(const char* argument, nb::handle given, const char* expected) {
  Array array;
  if (!given.is_none() && nb::try_cast<Array>(given, array, false)) return array;
  PyErr_Clear();  // of arrays that cannot be shared
  std::string got = nb::type_name(given.type()).c_str();
  if (nb::hasattr(given, "dtype")) {
    const nb::object dtype = given.attr("dtype");
    got += " of " + std::string(nb::str(dtype).c_str());
  }
  raise_type_error(std::string(argument) + ": expected " + expected + ", got " + got);
}

DepthInput::DepthInput(const char* argument, nb::handle given)
    : array_(import_array(argument, as_depth(argument, given), "an array of shape (H, W)")) {
  if (array_.ndim() != 2) wrong_shape(argument, "(H, W)", array_);
  if (!holds<std::uint16_t>(array_) && !holds<float>(array_) && !holds<double>(array_)) {
    wrong_dtype(argument, "whole numbers from 0 to 65535, float16, float32 or float64", array_);
  }
  const auto fits = [](std::size_t side) { return side >= 1 && side <= static_cast<std::size_t>(kMaxImageSide); };
  if (!fits(array_.shape(0)) || !fits(array_.shape(1))) {
    wrong_shape(argument, "(H, W) with sides of 1 to " + std::to_string(kMaxImageSide), array_);
  }
}

DepthView DepthInput::view(double depth_scale, DepthBuffer& buffer) const {
  if (holds<std::uint16_t>(array_)) {
    if (!rows_in_place<std::uint16_t>(array_)) {
      return DepthView::from_uint16(copy_rows<std::uint16_t>(array_, buffer.units), width(), height(), depth_scale);
    }
    const auto* const data = static_cast<const std::uint16_t*>(array_.data());
    return DepthView::from_uint16(data, width(), height(), depth_scale, row_stride<std::uint16_t>(array_));
  }
  if (holds<double>(array_)) {
    return DepthView::from_float(copy_rows<double>(array_, buffer.metres), width(), height());
  }
  if (!rows_in_place<float>(array_)) {
    return DepthView::from_float(copy_rows<float>(array_, buffer.metres), width(), height());
  }
  return DepthView::from_float(static_cast<const float*>(array_.data()), width(), height(), row_stride<float>(array_));
}

PointsInput::PointsInput(const char* argument, nb::handle given)
    : array_(import_array(argument, as_points(argument, given), "an array of shape (N, 3) or (H, W, 3)")) {
  const std::size_t last = array_.ndim() == 2 || array_.ndim() == 3 ? array_.shape(array_.ndim() - 1) : 0;
  if (last != 3 && last != 4) wrong_shape(argument, "(N, 3) or (H, W, 3), or with a fourth value that is not used,", array_);
  if (!holds<float>(array_) && !holds<double>(array_))
    wrong_dtype(argument, "whole numbers, float16, float32 or float64", array_);
  if (size() > static_cast<std::size_t>(std::numeric_limits<int>::max())) {
    raise_value_error(std::string(argument) + ": at most 2**31 - 1 points, got an array of shape " + shape_text(array_));
  }
}

std::size_t PointsInput::size() const {
  const Shape sides = shape();
  return std::accumulate(sides.begin(), sides.end(), std::size_t{1}, std::multiplies<>());
}

bool PointsInput::is_double() const { return holds<double>(array_); }

Shape PointsInput::shape() const { return array_.ndim() == 3 ? Shape{array_.shape(0), array_.shape(1)} : Shape{array_.shape(0)}; }

void PointsInput::load(PointCloud& cloud) const {
  constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();
  cloud.source.clear();
  cloud.resize_uninitialised(size());
  const Shape rows_and_columns = shape();
  cloud.height = rows_and_columns.size() == 2 ? static_cast<int>(rows_and_columns[0]) : 1;
  cloud.width = static_cast<int>(rows_and_columns.back());
  visit_points(array_, cloud, [&](std::size_t i, const Eigen::Vector3f& point, bool finite) {
    cloud.set(i, finite ? point : Eigen::Vector3f(Eigen::Vector3f::Constant(kNaN)));
  });
}

void PointsInput::load_finite(PointCloud& cloud) const {
  cloud.resize_uninitialised(size());
  cloud.source.resize(size());
  std::size_t kept = 0;
  visit_points(array_, cloud, [&](std::size_t i, const Eigen::Vector3f& point, bool finite) {
    if (!finite) return;
    cloud.source[kept] = static_cast<std::uint32_t>(i);
    cloud.set(kept++, point);
  });
  cloud.resize_uninitialised(kept);
  cloud.source.resize(kept);
  cloud.width = static_cast<int>(kept);
  cloud.height = 1;
}

LabelsInput::LabelsInput(const char* argument, nb::handle given) {
  nb::object labels = nb::hasattr(given, "labels") ? nb::object(given.attr("labels")) : nb::borrow(given);
  if (is_numpy(labels)) labels = unmasked(labels, nb::int_(static_cast<int>(kLabelNoDepth)));
  array_ = import_array(argument, labels, "an array of labels or a Segmentation");
  if (!holds<std::uint8_t>(array_)) wrong_dtype(argument, "uint8", array_);
  if (array_.ndim() != 1 && array_.ndim() != 2) wrong_shape(argument, "(H, W) or (N,)", array_);
  std::int64_t expected = 1;
  bool gaps = false;
  for (std::size_t i = array_.ndim(); i-- > 0;) {
    gaps = gaps || (array_.shape(i) > 1 && array_.stride(i) != expected);
    expected *= static_cast<std::int64_t>(array_.shape(i));
  }
  if (!gaps) return;
  copy_.resize(array_.size());
  const std::size_t columns = array_.shape(array_.ndim() - 1);
  for (std::size_t i = 0; i < copy_.size(); ++i) {
    const auto column = static_cast<std::int64_t>(i % columns);
    const auto row = static_cast<std::int64_t>(i / columns);
    const std::int64_t first = array_.ndim() == 2 ? row * array_.stride(0) : 0;
    copy_[i] = value_at<std::uint8_t>(array_, first + column * array_.stride(array_.ndim() - 1));
  }
}

std::span<const std::uint8_t> LabelsInput::labels() const {
  if (!copy_.empty()) return copy_;
  return {static_cast<const std::uint8_t*>(array_.data()), array_.size()};
}

Shape LabelsInput::shape() const {
  Shape shape;
  for (std::size_t i = 0; i < array_.ndim(); ++i) shape.push_back(array_.shape(i));
  return shape;
}

nb::object to_numpy(const Eigen::Vector3d& vector) { return copied_array(vector.data(), {3}); }

nb::object to_numpy(const Eigen::Matrix3d& matrix) {
  const Eigen::Matrix3d rows = matrix.transpose();  // Eigen's columns are NumPy's rows
  return copied_array(rows.data(), {3, 3});
}

nb::object to_numpy(const Eigen::Matrix4d& matrix) {
  const Eigen::Matrix4d rows = matrix.transpose();
  return copied_array(rows.data(), {4, 4});
}

}  // namespace fransac::python
