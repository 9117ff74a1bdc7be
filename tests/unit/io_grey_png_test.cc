// SPDX-License-Identifier: Apache-2.0
// The fast decoder of greyscale PNGs beside libspng: the same pixels, or it leaves the file to libspng.
#include <gmock/gmock.h>
#include <libdeflate.h>

#include <array>
#include <cstdlib>
#include <string>
#include <string_view>
#include <vector>

#include "fransac/core/random.hpp"
#include "io/grey_png.h"

namespace fransac::io {
namespace {

using Bytes = std::vector<std::byte>;

constexpr std::size_t kHeaderEnd = 33;  // signature and header
constexpr std::size_t kEndSize = 12;    // the last chunk

void append(Bytes& bytes, std::span<const std::byte> more) {
  for (const std::byte byte : more) bytes.push_back(byte);
}

void append_number(Bytes& bytes, std::uint32_t value) {
  for (int shift = 24; shift >= 0; shift -= 8) bytes.push_back(static_cast<std::byte>(value >> shift & 0xffU));
}

Bytes chunk(std::string_view type, const Bytes& data) {
  Bytes bytes;
  append_number(bytes, static_cast<std::uint32_t>(data.size()));
  append(bytes, std::as_bytes(std::span(type)));
  append(bytes, data);
  append_number(bytes, libdeflate_crc32(0, bytes.data() + 4, bytes.size() - 4));
  return bytes;
}

Bytes head(std::uint32_t width, std::uint32_t height, int bits, int colour = 0, int interlacing = 0) {
  Bytes data;
  append_number(data, width);
  append_number(data, height);
  for (const int byte : {bits, colour, 0, 0, interlacing}) data.push_back(static_cast<std::byte>(byte));
  Bytes bytes;
  append(bytes, std::as_bytes(std::span(kPngSignature)));
  append(bytes, chunk("IHDR", data));
  return bytes;
}

Bytes zlib(const Bytes& raw) {
  libdeflate_compressor* const compressor = libdeflate_alloc_compressor(6);
  Bytes bytes(libdeflate_zlib_compress_bound(compressor, raw.size()));
  bytes.resize(libdeflate_zlib_compress(compressor, raw.data(), raw.size(), bytes.data(), bytes.size()));
  libdeflate_free_compressor(compressor);
  return bytes;
}

/// A whole file around data chunks of given contents.
Bytes file_of(Bytes bytes, const std::vector<Bytes>& data) {
  for (const Bytes& part : data) append(bytes, chunk("IDAT", part));
  append(bytes, chunk("IEND", {}));
  return bytes;
}

/// The guess of a filter, as the specification has it (9.2): a to the left, b above, c above left.
int guess(int filter, int a, int b, int c) {
  const int p = a + b - c;
  const int pa = std::abs(p - a);
  const int pb = std::abs(p - b);
  const int pc = std::abs(p - c);
  switch (filter) {
    case 1: return a;
    case 2: return b;
    case 3: return (a + b) / 2;
    case 4: return pa <= pb && pa <= pc ? a : pb <= pc ? b : c;
    default: return 0;
  }
}

/// Rows as they stand in a file, row v with filter filters[v % size].
template <class T>
Bytes filtered(const Image<T>& image, const std::vector<int>& filters) {
  const auto row_bytes = static_cast<std::size_t>(image.width) * sizeof(T);
  const auto byte_at = [&](std::ptrdiff_t v, std::ptrdiff_t i) -> int {
    if (v < 0 || i < 0) return 0;
    const auto pixel =
        static_cast<std::size_t>(v) * static_cast<std::size_t>(image.width) + static_cast<std::size_t>(i) / sizeof(T);
    const bool high = sizeof(T) == 2 && i % 2 == 0;
    return image.pixels[pixel] >> (high ? 8 : 0) & 0xff;
  };
  Bytes raw;
  for (std::ptrdiff_t v = 0; v < image.height; ++v) {
    const int filter = filters[static_cast<std::size_t>(v) % filters.size()];
    raw.push_back(static_cast<std::byte>(filter));
    for (std::ptrdiff_t i = 0; i < static_cast<std::ptrdiff_t>(row_bytes); ++i) {
      constexpr std::ptrdiff_t kPixel = sizeof(T);
      const int g = guess(filter, byte_at(v, i - kPixel), byte_at(v - 1, i), byte_at(v - 1, i - kPixel));
      raw.push_back(static_cast<std::byte>(byte_at(v, i) - g));
    }
  }
  return raw;
}

/// Smooth in some places and noise in others, so that every guess is taken.
template <class T>
Image<T> some_image(int width, int height, std::uint64_t seed = 1) {
  RandomStream random(seed, 0);
  Image<T> image{width, height, 1, {}};
  for (std::size_t i = 0; i < image.size(); ++i) {
    const bool smooth = !image.pixels.empty() && random.below(2) == 0;
    image.pixels.push_back(static_cast<T>(smooth ? image.pixels.back() + random.below(5) : random.below(65536)));
  }
  return image;
}

template <class T>
Bytes png_of(const Image<T>& image, const std::vector<int>& filters) {
  return file_of(head(static_cast<std::uint32_t>(image.width), static_cast<std::uint32_t>(image.height), 8 * sizeof(T)),
                 {zlib(filtered(image, filters))});
}

template <class T>
Result<Image<T>> by_spng(const Bytes& png, const ReadLimits& limits = {}) {
  return decode_grey_by_spng<T>(png, "name.png", limits, "wanted");
}

template <class T>
void expect_decoded(const Bytes& png, const Image<T>& expected) {
  GreyPngDecoder decoder;
  Image<T> image;
  ASSERT_TRUE(decoder.decode(png, {}, image));
  EXPECT_EQ(image.width, expected.width);
  EXPECT_EQ(image.height, expected.height);
  EXPECT_EQ(image.channels, 1);
  EXPECT_EQ(image.pixels, expected.pixels);
  const auto slow = by_spng<T>(png);
  ASSERT_TRUE(slow.ok()) << slow.error().message;
  EXPECT_EQ(slow->pixels, expected.pixels);
}

/// The decoder leaves it to libspng, which must say the same as the public function.
void expect_left(const Bytes& png, const ReadLimits& limits = {}) {
  GreyPngDecoder decoder;
  DepthImage image;
  EXPECT_FALSE(decoder.decode(png, limits, image));
  const auto slow = by_spng<std::uint16_t>(png, limits);
  const auto read = decode_depth_png(png, "name.png", limits);
  ASSERT_EQ(read.ok(), slow.ok());
  if (read.ok()) {
    EXPECT_EQ(read->pixels, slow->pixels);
  } else {
    EXPECT_EQ(read.error().code, ErrorCode::format);
    EXPECT_THAT(read.error().message, ::testing::StartsWith("name.png: "));
  }
}

void expect_refused(const Bytes& png, const ReadLimits& limits = {}) {
  expect_left(png, limits);
  EXPECT_FALSE(decode_depth_png(png, "name.png", limits).ok());
}

template <class T>
class GreyPng : public ::testing::Test {};
using Depths = ::testing::Types<std::uint8_t, std::uint16_t>;
TYPED_TEST_SUITE(GreyPng, Depths);

TYPED_TEST(GreyPng, EveryFilterAtAnySize) {
  for (const auto& [width, height] : {std::pair{1, 1}, {1, 7}, {3, 1}, {4, 4}, {5, 3}, {17, 9}, {64, 33}, {129, 2}}) {
    const auto image = some_image<TypeParam>(width, height);
    for (int filter = 0; filter < 5; ++filter) {
      SCOPED_TRACE(::testing::Message() << width << "x" << height << ", filter " << filter);
      expect_decoded(png_of(image, {filter}), image);
    }
    expect_decoded(png_of(image, {4, 1, 3, 2, 0, 3, 4}), image);
  }
}

TYPED_TEST(GreyPng, EveryPairOfBytesUnderEveryFilter) {
  // Left, above and above left take all values beside each other.
  for (int filter = 1; filter < 5; ++filter) {
    const auto image = some_image<TypeParam>(512, 512, static_cast<std::uint64_t>(filter));
    expect_decoded(png_of(image, {filter}), image);
  }
}

TYPED_TEST(GreyPng, DataInSeveralChunks) {
  const auto image = some_image<TypeParam>(5, 4);
  const Bytes data = zlib(filtered(image, {4}));
  const Bytes start = head(5, 4, 8 * sizeof(TypeParam));
  for (std::size_t at = 0; at <= data.size(); ++at) {
    const auto cut = data.begin() + static_cast<std::ptrdiff_t>(at);
    expect_decoded(file_of(start, {Bytes(data.begin(), cut), Bytes(cut, data.end())}), image);
  }
  std::vector<Bytes> bytes;
  for (const std::byte byte : data) bytes.insert(bytes.end(), {{}, {byte}, {}});
  expect_decoded(file_of(start, bytes), image);
}

TYPED_TEST(GreyPng, WhateverFollowsTheEndIsNotRead) {
  const auto image = some_image<TypeParam>(5, 4);
  Bytes png = png_of(image, {1});
  append(png, Bytes(100, std::byte{'x'}));
  expect_decoded(png, image);
}

TEST(GreyPngDecoder, KeepsItsMemoryAndNothingElse) {
  GreyPngDecoder decoder;
  DepthImage image;
  Bytes broken = png_of(some_image<std::uint16_t>(50, 40), {4});
  broken.resize(broken.size() / 2);
  for (const auto& [width, height] : {std::pair{64, 48}, {3, 2}, {20, 90}}) {
    const auto expected = some_image<std::uint16_t>(width, height, 7);
    ASSERT_TRUE(decoder.decode(png_of(expected, {3, 4, 2}), {}, image));
    EXPECT_EQ(image.pixels, expected.pixels);
    EXPECT_FALSE(decoder.decode(broken, {}, image));
  }
}

class GreyPngLeft : public ::testing::Test {
 protected:
  DepthImage image_ = some_image<std::uint16_t>(5, 4);
  Bytes raw_ = filtered(image_, {0, 1, 2, 3});
  Bytes head_ = head(5, 4, 16);
  Bytes whole_ = file_of(head_, {zlib(raw_)});
};

TEST_F(GreyPngLeft, WrongChecksums) {
  Bytes data = zlib(raw_);
  data.back() ^= std::byte{1};  // Adler-32
  expect_left(file_of(head_, {data}));
  for (std::size_t at = 0; at < whole_.size(); ++at) {
    SCOPED_TRACE(at);
    Bytes broken = whole_;
    broken[at] ^= std::byte{16};
    expect_refused(broken);
  }
}

TEST_F(GreyPngLeft, CutOffAnywhere) {
  for (std::size_t size = 0; size < whole_.size(); ++size) {
    expect_refused(Bytes(whole_.begin(), whole_.begin() + static_cast<std::ptrdiff_t>(size)));
  }
  Bytes data = zlib(raw_);
  for (; !data.empty(); data.pop_back()) expect_left(file_of(head_, {Bytes(data.begin(), data.end() - 1)}));
}

TEST_F(GreyPngLeft, TooLittleAndTooMuchData) {
  for (const std::size_t size : {std::size_t{0}, std::size_t{1}, raw_.size() - 1}) {
    SCOPED_TRACE(size);
    expect_refused(file_of(head_, {zlib(Bytes(raw_.begin(), raw_.begin() + static_cast<std::ptrdiff_t>(size)))}));
  }
  Bytes longer = raw_;
  longer.push_back(std::byte{0});
  expect_left(file_of(head_, {zlib(longer)}));
  Bytes followed = zlib(raw_);
  followed.push_back(std::byte{0});
  expect_left(file_of(head_, {followed}));
  expect_refused(file_of(head_, {}));
}

TEST_F(GreyPngLeft, UnknownFilters) {
  for (const int filter : {5, 255}) {
    Bytes raw = raw_;
    raw[2 * 11] = static_cast<std::byte>(filter);
    expect_refused(file_of(head_, {zlib(raw)}));
  }
}

TEST_F(GreyPngLeft, OtherKindsAndOtherChunks) {
  Bytes with_text = head_;
  append(with_text, chunk("tEXt", {std::byte{'a'}, std::byte{0}, std::byte{'b'}}));
  const auto text = decode_depth_png(file_of(with_text, {zlib(raw_)}), "name.png");
  expect_left(file_of(with_text, {zlib(raw_)}));
  ASSERT_TRUE(text.ok()) << text.error().message;
  EXPECT_EQ(text->pixels, image_.pixels);
  expect_left(file_of(head(5, 4, 16, 0, 1), {zlib(raw_)}));
  expect_refused(file_of(head(5, 4, 8), {zlib(raw_)}));
  expect_refused(file_of(head(5, 4, 16, 2), {zlib(raw_)}));
  expect_refused(file_of({}, {zlib(raw_)}));
}

TEST_F(GreyPngLeft, SizesThatTheHeaderMayNotHave) {
  for (const auto& [width, height] : {std::pair{0U, 4U}, {5U, 0U}, {32769U, 1U}, {0x7fffffffU, 0x7fffffffU}, {8192U, 8192U}}) {
    expect_refused(file_of(head(width, height, 16), {zlib(raw_)}));
  }
  expect_refused(whole_, {19});
  GreyPngDecoder decoder;
  DepthImage image;
  EXPECT_TRUE(decoder.decode(whole_, {20}, image));
}

}  // namespace
}  // namespace fransac::io
