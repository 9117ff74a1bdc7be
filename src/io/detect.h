// SPDX-License-Identifier: Apache-2.0
/// Recognising inputs by their first bytes.
#pragma once

#include <filesystem>
#include <optional>
#include <vector>

#include "fransac/core/result.hpp"
#include "fransac/io/dataset.hpp"

namespace fransac::io {

/// What a file's first bytes say that it is. An 8-bit or colour picture counts: the reader says what is wrong with it.
std::optional<InputKind> kind_of_content(std::string_view head);

/// The entries of a folder, sorted by name.
Result<std::vector<std::filesystem::path>> sorted_entries(const std::filesystem::path& folder);

/// A folder's depth.png, or its depth.tiff, .tif, .pgm or .npy.
std::optional<std::filesystem::path> depth_in(const std::filesystem::path& folder);
/// Whether a file has such a name.
bool is_named_depth(const std::filesystem::path& file);

/// A file whose lines pair the depth images and pictures of a TUM RGB-D sequence.
inline constexpr const char* kTumAssociations = "associations.txt";

/// Whether a folder holds the lists of a TUM RGB-D sequence.
bool is_tum_sequence(const std::filesystem::path& folder);

bool is_file(const std::filesystem::path& path);

/// Whether a file is a depth image by how it starts: a 16-bit greyscale PNG, or a TIFF, PGM or NPY of any kind.
bool is_depth_image(const std::filesystem::path& file);

}  // namespace fransac::io
