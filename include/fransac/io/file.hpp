// SPDX-License-Identifier: Apache-2.0
/// Whole files in and out.
#pragma once

#include <cstddef>
#include <filesystem>
#include <span>
#include <string_view>
#include <vector>

#include "fransac/core/result.hpp"

namespace fransac::io {

/// Reads a whole file. Errors name the file. Directories and files above `max_bytes` are refused.
Result<std::vector<std::byte>> read_file(const std::filesystem::path& file, std::size_t max_bytes = std::size_t{1} << 36);

/// Writes `bytes` under a temporary name in the same folder, flushes, then renames: readers see the old file or the new
/// one, and a failure (full disk, no permission) leaves the old one and no temporary.
/// Things that are not regular files (/dev/full, /dev/stdout, a pipe) are written in place.
Status write_file(const std::filesystem::path& file, std::span<const std::byte> bytes);
/// The same of text.
Status write_file(const std::filesystem::path& file, std::string_view text);

}  // namespace fransac::io
