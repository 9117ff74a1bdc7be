// SPDX-License-Identifier: Apache-2.0
/// Points that hang together.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "fransac/core/result.hpp"

namespace fransac::obstacles {

struct Clusters {
  std::uint32_t count = 0;
  std::vector<std::uint32_t> of_point;  ///< From 0, in the order of the clusters' first points.
};

/// Euclidean clusters: two points are of one if a chain of points leads from one to the other whose links are no longer than
/// `distance_m`, to within rounding. All points finite. Fails with invalid_argument where the distance is so small that the
/// cells it makes cannot be counted in 31 bits along an axis. May throw std::bad_alloc; its memory and, but for few points that
/// are many in a place, its time are proportional to the number of points, whatever their extent.
Result<Clusters> find_clusters(const std::vector<Eigen::Vector3f>& points, double distance_m);

}  // namespace fransac::obstacles
