// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>

#include "fransac/core/result.hpp"

namespace fransac {

inline constexpr const char* kMeasured = "with a measurement";
inline constexpr const char* kWithinLimits = "within the pass-through limits";

/// no_data when there are too few points for a plane; the message says which.
inline Status require_points(std::uint64_t points, const char* where) {
  if (points >= 3) return {};
  return Error{ErrorCode::no_data, "a plane needs three points, there are " + std::to_string(points) + " " + where};
}

}  // namespace fransac
