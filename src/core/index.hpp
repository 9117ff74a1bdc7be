// SPDX-License-Identifier: Apache-2.0
/// Numbers as indices.
#pragma once

#include <cstddef>

namespace fransac {

/// `i`, which is not negative, as containers count.
inline std::size_t at(int i) { return static_cast<std::size_t>(i); }

}  // namespace fransac
