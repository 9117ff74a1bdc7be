// SPDX-License-Identifier: Apache-2.0
/// What each method consists of.
#pragma once

#include "fransac/planes/options.hpp"

namespace fransac {

/// The parts of the paper's figure 2 that a method has. Every method ends in the same sampling loop and the same labels.
struct MethodParts {
  bool pass_through;  ///< Unless the user says otherwise; depth images only.
  bool voxel_grid;
  int pretest_points;  ///< d of T(d,d), unless the user says otherwise.
};

/// The method that runs for the one that was asked for.
constexpr Method resolve(Method method, [[maybe_unused]] bool depth_image) {
  // TODO(cells): depth_image ? Method::cells : Method::fransac, once find_cells() is there.
  return method == Method::automatic ? Method::fransac : method;
}

/// With everything filled in that the options leave to the method and that does not depend on the input's kind.
inline SegmentOptions resolved(SegmentOptions options, bool depth_image) {
  options.method = resolve(options.method, depth_image);
  const MethodDefaults defaults = defaults_of(options.method);
  options.max_planes = options.max_planes.value_or(defaults.max_planes);
  options.min_support = options.min_support.value_or(defaults.min_support);
  options.order = options.order.value_or(defaults.order);
  return options;
}

constexpr MethodParts parts_of(Method method) {
  switch (method) {
    case Method::automatic:
    case Method::fransac: return {.pass_through = true, .voxel_grid = true, .pretest_points = 0};
    case Method::voxel_ransac: return {.pass_through = false, .voxel_grid = true, .pretest_points = 0};
    case Method::rransac: return {.pass_through = false, .voxel_grid = false, .pretest_points = 1};
    case Method::cells:
    case Method::ransac: return {.pass_through = false, .voxel_grid = false, .pretest_points = 0};
  }
  return {};
}

}  // namespace fransac
