// SPDX-License-Identifier: Apache-2.0
/// Fields of PCL's point types, and their means.
#pragma once

#include <pcl/PCLPointField.h>
#include <pcl/common/centroid.h>
#include <pcl/common/io.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

namespace fransac::pcl::detail {

/// Calls visit(value of the type that a field holds) with an arbitrary value; a type that PCL does not know is a float.
template <class Visitor>
auto with_field_type(std::uint8_t datatype, const Visitor& visit) {
  using Field = ::pcl::PCLPointField;
  switch (datatype) {
    case Field::INT8: return visit(std::int8_t{});
    case Field::UINT8: return visit(std::uint8_t{});
    case Field::INT16: return visit(std::int16_t{});
    case Field::UINT16: return visit(std::uint16_t{});
    case Field::INT32: return visit(std::int32_t{});
    case Field::UINT32: return visit(std::uint32_t{});
    case Field::FLOAT64: return visit(double{});
    default: return visit(float{});
  }
}

/// One number of a point.
struct Component {
  std::size_t offset = 0;
  std::uint8_t datatype = 0;

  template <class PointT>
  [[nodiscard]] double read(const PointT& point) const {
    return with_field_type(datatype, [&](auto value) {
      std::memcpy(&value, reinterpret_cast<const unsigned char*>(&point) + offset, sizeof value);
      return static_cast<double>(value);
    });
  }

  /// Whole numbers are rounded to nearest.
  template <class PointT>
  void write(double mean, PointT& point) const {
    with_field_type(datatype, [&](auto value) {
      using T = decltype(value);
      if constexpr (std::is_integral_v<T>) mean = std::nearbyint(mean);
      value = static_cast<T>(mean);
      std::memcpy(reinterpret_cast<unsigned char*>(&point) + offset, &value, sizeof value);
    });
  }
};

/// The registered field of that name; nothing where there is none.
template <class PointT>
std::optional<Component> field_named(const std::string& name) {
  for (const ::pcl::PCLPointField& field : ::pcl::getFields<PointT>()) {
    if (field.name == name) return Component{field.offset, field.datatype};
  }
  return std::nullopt;
}

/// The numbers of a point that pcl::CentroidPoint does not average.
template <class PointT>
std::vector<Component> plain_components() {
  constexpr std::array<std::string_view, 11> kPcl{"x",         "y",         "z",   "normal_x", "normal_y", "normal_z",
                                                  "curvature", "intensity", "rgb", "rgba",     "label"};
  std::vector<Component> components;
  for (const ::pcl::PCLPointField& field : ::pcl::getFields<PointT>()) {
    if (std::find(kPcl.begin(), kPcl.end(), field.name) != kPcl.end()) continue;
    const std::size_t size = with_field_type(field.datatype, [](auto value) { return sizeof value; });
    for (std::size_t i = 0; i < std::max<std::size_t>(1, field.count); ++i) {
      components.push_back({field.offset + i * size, field.datatype});
    }
  }
  return components;
}

/// Whether a point type has fields besides x, y and z.
template <class PointT>
bool has_more_than_xyz() {
  return ::pcl::getFields<PointT>().size() > 3;
}

/// Means of all fields over groups of points.
template <class PointT>
class FieldMeans {
 public:
  explicit FieldMeans(std::size_t groups) : plain_(plain_components<PointT>()), means_(groups), sums_(groups * plain_.size()) {}

  void add(std::size_t group, const PointT& point) {
    means_[group].add(point);
    for (std::size_t i = 0; i < plain_.size(); ++i) sums_[group * plain_.size() + i] += plain_[i].read(point);
  }

  /// Expects a group that is not empty.
  void get(std::size_t group, PointT& point) const {
    means_[group].get(point);
    const auto count = static_cast<double>(means_[group].getSize());
    for (std::size_t i = 0; i < plain_.size(); ++i) plain_[i].write(sums_[group * plain_.size() + i] / count, point);
  }

 private:
  std::vector<Component> plain_;
  std::vector<::pcl::CentroidPoint<PointT>, Eigen::aligned_allocator<::pcl::CentroidPoint<PointT>>> means_;
  std::vector<double> sums_;
};

}  // namespace fransac::pcl::detail
