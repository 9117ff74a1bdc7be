// SPDX-License-Identifier: Apache-2.0
/// Depth images in formats other than PNG.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "fransac/io/image.hpp"

namespace fransac::io {

/// Formats of depth images, told by a file's first bytes.
enum class DepthFileFormat { png, tiff, pgm, npy };
std::optional<DepthFileFormat> depth_format_of(std::string_view head);

/// Checks a size that a header promises before memory is taken. `needed_bytes`: the shortest file that can hold it.
Status check_size(std::uint64_t width, std::uint64_t height, std::uint64_t needed_bytes, std::size_t file_bytes,
                  const ReadLimits& limits, const std::string& name);

/// Gives an image of one channel its size; what its pixels were is left.
template <class T>
void resize(Image<T>& image, std::uint64_t width, std::uint64_t height) {
  image.width = static_cast<int>(width);
  image.height = static_cast<int>(height);
  image.channels = 1;
  image.pixels.resize(image.size());
}

/// Decode into `image`, whose memory is used again; after an error it is not to be used. Errors name `name`. May throw
/// std::bad_alloc.
Status decode_depth_pgm(std::span<const std::byte> bytes, const std::string& name, const ReadLimits& limits, RawDepth& image);
Status decode_depth_npy(std::span<const std::byte> bytes, const std::string& name, const ReadLimits& limits, RawDepth& image);
Status decode_depth_tiff(std::span<const std::byte> bytes, const std::string& name, const ReadLimits& limits, RawDepth& image);

}  // namespace fransac::io
