// SPDX-License-Identifier: Apache-2.0
/// Greyscale PNGs as programs for depth cameras write them, decoded fast.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "fransac/io/image.hpp"

struct libdeflate_decompressor;

namespace fransac::io {

inline constexpr std::string_view kPngSignature = "\x89PNG\r\n\x1a\n";
/// Deflate expands no stream by more (zlib technical details, "Maximum Compression Factor").
inline constexpr std::uint64_t kMaxDeflateFactor = 1032;

/// Keeps its memory from picture to picture. One thread at a time.
class GreyPngDecoder {
 public:
  /// Decodes a PNG of one grey value of type T a pixel (8 or 16 bits), not interlaced, without other chunks than IHDR, IDAT and
  /// IEND, whose checksums are right and whose data are what the header promises. False for anything else, broken files
  /// included; then `image` is not to be used, and libspng reads the file or says what is wrong with it. May throw
  /// std::bad_alloc.
  template <class T>
  [[nodiscard]] bool decode(std::span<const std::byte> bytes, const ReadLimits& limits, Image<T>& image);

 private:
  struct Free {
    void operator()(libdeflate_decompressor* inflater) const;
  };
  [[nodiscard]] bool inflate(std::span<const std::byte> deflated, std::span<std::byte> out);
  template <class T>
  [[nodiscard]] bool unfilter(Image<T>& image);

  std::unique_ptr<libdeflate_decompressor, Free> inflater_;
  std::vector<std::byte> deflated_;  ///< The data chunks, one after the other, where there are several.
  std::vector<std::byte> rows_;      ///< Some rows as they stand in the file.
};

extern template bool GreyPngDecoder::decode(std::span<const std::byte>, const ReadLimits&, Image<std::uint8_t>&);
extern template bool GreyPngDecoder::decode(std::span<const std::byte>, const ReadLimits&, Image<std::uint16_t>&);

/// The same by libspng, whatever the file is; an Error says that it is not `wanted`, or what is wrong with it.
template <class T>
Result<Image<T>> decode_grey_by_spng(std::span<const std::byte> bytes, const std::string& name, const ReadLimits& limits,
                                     std::string_view wanted);

}  // namespace fransac::io
