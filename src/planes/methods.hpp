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
constexpr Method resolve(Method method, bool depth_image) {
  if (method != Method::automatic) return method;
  return depth_image ? Method::cells : Method::fransac;
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
