// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <filesystem>
#include <vector>

#include "fransac/core/result.hpp"

namespace fransac::io {

/// The first `max_bytes` of a file, or all of a shorter one.
Result<std::vector<std::byte>> read_head(const std::filesystem::path& file, std::size_t max_bytes);

}  // namespace fransac::io
