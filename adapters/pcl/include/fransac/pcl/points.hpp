// SPDX-License-Identifier: Apache-2.0
/// PCL's points as the library wants them.
#pragma once

#include <pcl/console/print.h>
#include <pcl/point_cloud.h>
#include <pcl/types.h>

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <type_traits>
#include <vector>

#include "fransac/core/plane.hpp"
#include "fransac/core/point_cloud.hpp"

namespace fransac::pcl::detail {

/// What is wrong, as PCL says such things: on its console, where pcl::console::setVerbosityLevel silences it. Not by PCL_ERROR,
/// which means another namespace `pcl` in here.
inline void complain(const std::string& where, const std::string& what) {
  ::pcl::console::print(::pcl::console::L_ERROR, "[fransac::pcl::%s] %s\n", where.c_str(), what.c_str());
}

template <class PointT>
bool is_finite(const PointT& p) {
  // Free of branches: a difference of a number and itself is 0 unless it is infinite or NaN.
  return ((p.x - p.x) + (p.y - p.y)) + (p.z - p.z) == 0.0F;
}

inline std::vector<float> coefficients_of(const Plane& plane) {
  return {static_cast<float>(plane.normal.x()), static_cast<float>(plane.normal.y()), static_cast<float>(plane.normal.z()),
          static_cast<float>(plane.d)};
}

/// The cloud as it lies in memory; nothing where x, y and z of a point are not three floats side by side.
template <class PointT>
std::optional<PointsView> view_of(const ::pcl::PointCloud<PointT>& cloud) {
  if constexpr (std::is_same_v<decltype(PointT::x), float> && sizeof(PointT) % sizeof(float) == 0) {
    if (cloud.empty()) return PointsView{};
    const PointT& first = cloud.front();
    const auto offset = [&](const float& member) {
      return reinterpret_cast<const unsigned char*>(&member) - reinterpret_cast<const unsigned char*>(&first.x);
    };
    if (offset(first.y) == sizeof(float) && offset(first.z) == 2 * sizeof(float)) {
      return PointsView{&first.x, cloud.size(), sizeof(PointT) / sizeof(float)};
    }
  }
  return std::nullopt;
}

/// The x, y and z of all points in order; false when one of them is not finite.
template <class PointT>
bool read_all(const ::pcl::PointCloud<PointT>& from, PointCloud& to) {
  to.source.clear();
  to.resize_uninitialised(from.size());
  const PointT* const points = from.data();
  float* const x = to.x();
  float* const y = to.y();
  float* const z = to.z();
  float differences = 0.0F;
  for (std::size_t i = 0; i < from.size(); ++i) {
    const PointT& p = points[i];
    differences += ((p.x - p.x) + (p.y - p.y)) + (p.z - p.z);
    x[i] = p.x;
    y[i] = p.y;
    z[i] = p.z;
  }
  return differences == 0.0F;
}

/// The finite ones of `candidates` points, of which the i-th is number index_of(i) of `from`, where keep(number) says so.
template <class PointT, class IndexOf, class Keep>
void read_some(const ::pcl::PointCloud<PointT>& from, std::size_t candidates, const IndexOf& index_of, const Keep& keep,
               PointCloud& to) {
  to.resize_uninitialised(candidates);
  to.source.resize(candidates);
  const PointT* const points = from.data();
  float* const x = to.x();
  float* const y = to.y();
  float* const z = to.z();
  std::uint32_t* const source = to.source.data();
  std::size_t n = 0;
  for (std::size_t i = 0; i < candidates; ++i) {
    const auto number = static_cast<std::size_t>(index_of(i));
    if (number >= from.size()) continue;  // negative indices too
    const PointT& p = points[number];
    x[n] = p.x;
    y[n] = p.y;
    z[n] = p.z;
    source[n] = static_cast<std::uint32_t>(number);
    n += static_cast<std::size_t>(is_finite(p)) & static_cast<std::size_t>(keep(number));
  }
  to.source.resize(n);
  to.resize_uninitialised(n);
}

/// The finite points of a cloud, or of those that `indices` names (null: all), where keep(number) says so. Indices outside the
/// cloud are left out. `to.source` names PCL's points; empty when they are all of them in order.
template <class PointT, class Keep>
void read(const ::pcl::PointCloud<PointT>& from, const ::pcl::Indices* indices, const Keep& keep, PointCloud& to) {
  to.origin.setZero();
  to.width = to.height = 0;
  if (indices != nullptr) {
    return read_some(
        from, indices->size(), [indices](std::size_t i) { return (*indices)[i]; }, keep, to);
  }
  read_some(
      from, from.size(), [](std::size_t i) { return i; }, keep, to);
}

template <class PointT>
void read(const ::pcl::PointCloud<PointT>& from, const ::pcl::Indices* indices, PointCloud& to) {
  to.origin.setZero();
  to.width = to.height = 0;
  if (indices == nullptr && from.is_dense && read_all(from, to)) return;
  read(
      from, indices, [](std::size_t) { return true; }, to);
}

/// All points in order, organised as they are; NaN where a point is not finite or not among `indices` (null: all).
template <class PointT>
void read_organised(const ::pcl::PointCloud<PointT>& from, const ::pcl::Indices* indices, PointCloud& to) {
  constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();
  to.origin.setZero();
  to.width = static_cast<int>(from.width);
  to.height = static_cast<int>(from.height);
  to.source.clear();
  to.resize_uninitialised(from.size());
  const auto copy = [&](std::size_t i) {
    const PointT& p = from[i];
    is_finite(p) ? to.set(i, {p.x, p.y, p.z}) : to.set(i, {kNaN, kNaN, kNaN});
  };
  if (indices == nullptr) {
    for (std::size_t i = 0; i < from.size(); ++i) copy(i);
    return;
  }
  for (std::size_t i = 0; i < from.size(); ++i) to.set(i, {kNaN, kNaN, kNaN});
  for (const ::pcl::index_t index : *indices) {
    if (static_cast<std::size_t>(index) < from.size()) copy(static_cast<std::size_t>(index));
  }
}

}  // namespace fransac::pcl::detail
