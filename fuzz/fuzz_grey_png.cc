// SPDX-License-Identifier: Apache-2.0
// Greyscale PNGs by the fast decoder and by libspng: what the first reads the second reads, with the same pixels. The first
// byte says what the rest is: a file, whose chunks get the checksums that a fuzzer cannot find; or the raw rows of a picture.
#include <libdeflate.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

#include "io/grey_png.h"
#include "require.hpp"

namespace {

using namespace fransac;
using Bytes = std::vector<std::byte>;

using fuzz::require;

void put_big_endian(std::span<std::byte> at, std::uint32_t value) {
  for (std::size_t i = 0; i < 4; ++i) at[i] = static_cast<std::byte>(value >> (24U - 8U * i));
}

std::uint32_t big_endian(std::span<const std::byte> at) {
  std::uint32_t value = 0;
  for (const std::byte byte : at.first(4)) value = value << 8U | static_cast<std::uint32_t>(byte);
  return value;
}

/// Gives all chunks their checksums.
void mend(Bytes& png) {
  std::span<std::byte> rest = png;
  if (rest.size() < io::kPngSignature.size()) return;
  rest = rest.subspan(io::kPngSignature.size());
  while (rest.size() >= 12) {
    const std::size_t length = big_endian(rest);
    if (length > rest.size() - 12) return;
    put_big_endian(rest.subspan(8 + length), libdeflate_crc32(0, rest.data() + 4, 4 + length));
    rest = rest.subspan(12 + length);
  }
}

void append_chunk(Bytes& png, std::string_view type, std::span<const std::byte> data) {
  std::array<std::byte, 4> number{};
  put_big_endian(number, static_cast<std::uint32_t>(data.size()));
  png.insert(png.end(), number.begin(), number.end());
  const auto name = std::as_bytes(std::span(type));
  png.insert(png.end(), name.begin(), name.end());
  png.insert(png.end(), data.begin(), data.end());
  png.insert(png.end(), number.begin(), number.end());
}

/// A file whose rows are `raw`, over and over; its data are in chunks of `part` bytes.
Bytes file_of(std::span<const std::byte> raw, std::uint32_t width, std::uint32_t height, std::size_t bytes_per_pixel,
              std::size_t part) {
  const auto signature = std::as_bytes(std::span(io::kPngSignature));
  Bytes png(signature.begin(), signature.end());
  std::array<std::byte, 13> header{};
  put_big_endian(header, width);
  put_big_endian(std::span(header).subspan(4), height);
  header[8] = static_cast<std::byte>(8 * bytes_per_pixel);
  append_chunk(png, "IHDR", header);
  const std::size_t row_bytes = 1 + width * bytes_per_pixel;
  Bytes rows(height * row_bytes);
  for (std::size_t i = 0; i < rows.size() && !raw.empty(); ++i) {
    rows[i] = raw[i % raw.size()];
    if (i % row_bytes == 0) rows[i] = static_cast<std::byte>(static_cast<unsigned>(rows[i]) % 5);
  }
  libdeflate_compressor* const compressor = libdeflate_alloc_compressor(6);
  Bytes data(libdeflate_zlib_compress_bound(compressor, rows.size()));
  data.resize(libdeflate_zlib_compress(compressor, rows.data(), rows.size(), data.data(), data.size()));
  libdeflate_free_compressor(compressor);
  for (std::span<const std::byte> rest = data; !rest.empty(); rest = rest.subspan(std::min(part, rest.size()))) {
    append_chunk(png, "IDAT", rest.first(std::min(part, rest.size())));
  }
  append_chunk(png, "IEND", {});
  mend(png);
  return png;
}

/// Whether the fast decoder read it.
template <class T>
bool compare(const Bytes& png) {
  static io::GreyPngDecoder decoder;
  static io::Image<T> image;  // what is left of the last is not to be seen
  const io::ReadLimits limits{1 << 20};
  if (!decoder.decode(png, limits, image)) return false;
  const Result<io::Image<T>> slow = io::decode_grey_by_spng<T>(png, "picture", limits, "wanted");
  // libdeflate knows what to do with codes that deflate does not have.
  if (!slow) return slow.error().message == "picture: broken PNG: IDAT stream error";
  require(slow->width == image.width && slow->height == image.height && image.channels == 1 && slow->pixels == image.pixels);
  return true;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size < 4) return 0;
  const auto bytes = std::as_bytes(std::span(data, size));
  const bool wide = (data[0] & 1U) != 0;
  const auto check = [&](const Bytes& png) { return wide ? compare<std::uint16_t>(png) : compare<std::uint8_t>(png); };
  if ((data[0] & 2U) == 0) {
    Bytes png(bytes.begin() + 1, bytes.end());
    mend(png);
    (void)check(png);
  } else {
    const std::size_t part = data[3] == 0 ? size : data[3];
    require(check(file_of(bytes.subspan(4), 1 + data[1] % 80U, 1 + data[2] % 80U, wide ? 2 : 1, part)));
  }
  return 0;
}
