// SPDX-License-Identifier: Apache-2.0
/// The meaning of a label image's values.
#pragma once

#include <cstdint>

namespace fransac {

inline constexpr std::uint8_t kLabelNoDepth = 0;    ///< Nothing was measured here.
inline constexpr std::uint8_t kLabelFirst = 1;      ///< The first plane; further planes count up from here.
inline constexpr std::uint8_t kLabelNoPlane = 255;  ///< On no plane, or outside the pass-through limits.
inline constexpr int kMaxPlanes = 254;              ///< Labels 1 to 254.

}  // namespace fransac
