// SPDX-License-Identifier: Apache-2.0
/// The internal constants of `cells`, in builds with FRANSAC_TUNABLE only: for measuring how much each matters, not for use.
/// Not installed.
#pragma once

#ifdef FRANSAC_TUNABLE
#include <span>
#include <string_view>

#include "fransac/core/result.hpp"

namespace fransac {

/// Their names.
std::span<const std::string_view> tunable_constants();

/// Whether the environment variable FRANSAC_CELLS_TUNE, "name=factor,name=factor", could be understood when the program started.
/// If not, no constant was changed, and the message names the variable and its wrong part.
const Status& tuning_status();

}  // namespace fransac
#endif
