// SPDX-License-Identifier: Apache-2.0
/// Depth images from files, in memory that is kept from one to the next.
#pragma once

#include <cstddef>
#include <filesystem>
#include <vector>

#include "fransac/io/image.hpp"
#include "io/grey_png.h"

namespace fransac::io {

/// What read_depth_image keeps. One thread at a time.
struct DepthReader {
  std::vector<std::byte> file;  ///< The last file's bytes.
  GreyPngDecoder decoder;
};

/// read_depth_image() into `image`, whose memory is used again; after an error it is not to be used. May throw std::bad_alloc.
Status read_depth_image(const std::filesystem::path& file, const ReadLimits& limits, DepthReader& reader, RawDepth& image);

}  // namespace fransac::io
