// SPDX-License-Identifier: Apache-2.0
/// How large an input may be.
#pragma once

#include <cstddef>

namespace fransac::io {

/// The largest image or cloud that is read. A file of a few kilobytes can promise gigabytes; what promises more than this is
/// refused before memory is taken for it.
struct ReadLimits {
  std::size_t max_size = std::size_t{1} << 25;  ///< Pixels of an image, or points of a cloud.

  /// Bytes that a file's compressed content may expand to; also of an image's file.
  [[nodiscard]] constexpr std::size_t max_decoded_bytes() const { return 8 * max_size; }
  /// Bytes of a cloud's file.
  [[nodiscard]] constexpr std::size_t max_cloud_file_bytes() const { return 64 * max_size; }
};

}  // namespace fransac::io
