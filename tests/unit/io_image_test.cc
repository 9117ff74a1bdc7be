// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <spng.h>
#include <turbojpeg.h>

#include <cstdlib>
#include <cstring>
#include <string>

#include "fransac/io/file.hpp"
#include "fransac/io/image.hpp"
#include "temporary_folder.h"

namespace fransac::io {
namespace {

using fransac::testing::TemporaryFolder;
using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::StartsWith;

using Bytes = std::vector<std::byte>;

DepthImage small_depth() {
  DepthImage image{5, 3, 1, {}};
  for (unsigned i = 0; i < 15; ++i) image.pixels.push_back(static_cast<std::uint16_t>(i * 4369U));  // 0 and 61166 among them
  return image;
}

/// A PNG of any kind, as other programs write them.
Bytes make_png(std::uint32_t width, std::uint32_t height, spng_color_type type, int bit_depth, const Bytes& raw,
               bool interlaced = false) {
  spng_ctx* const context = spng_ctx_new(SPNG_CTX_ENCODER);
  spng_ihdr header{};
  header.width = width;
  header.height = height;
  header.bit_depth = static_cast<std::uint8_t>(bit_depth);
  header.color_type = static_cast<std::uint8_t>(type);
  header.interlace_method = interlaced ? 1 : 0;
  spng_set_ihdr(context, &header);
  spng_plte palette{2, {{10, 20, 30, 255}, {40, 50, 60, 255}}};
  if (type == SPNG_COLOR_TYPE_INDEXED) spng_set_plte(context, &palette);
  spng_set_option(context, SPNG_ENCODE_TO_BUFFER, 1);
  EXPECT_EQ(spng_encode_image(context, raw.data(), raw.size(), SPNG_FMT_PNG, SPNG_ENCODE_FINALIZE), 0);
  std::size_t size = 0;
  int error = 0;
  void* const buffer = spng_get_png_buffer(context, &size, &error);
  const Bytes bytes(static_cast<std::byte*>(buffer), static_cast<std::byte*>(buffer) + size);
  std::free(buffer);
  spng_ctx_free(context);
  return bytes;
}

Bytes make_jpeg(int width, int height) {
  std::vector<unsigned char> raw(static_cast<std::size_t>(3 * width * height));
  for (std::size_t i = 0; i < raw.size(); ++i) raw[i] = i % 3 == 0 ? 200 : 50;
  const tjhandle encoder = tjInitCompress();
  unsigned char* buffer = nullptr;
  unsigned long size = 0;
  EXPECT_EQ(tjCompress2(encoder, raw.data(), width, 0, height, TJPF_RGB, &buffer, &size, TJSAMP_444, 95, 0), 0);
  const Bytes bytes(reinterpret_cast<std::byte*>(buffer), reinterpret_cast<std::byte*>(buffer) + size);
  tjFree(buffer);
  tjDestroy(encoder);
  return bytes;
}

std::uint32_t crc32(std::span<const std::byte> bytes) {  // PNG specification, annex D
  std::uint32_t crc = 0xffffffffU;
  for (const std::byte byte : bytes) {
    crc ^= static_cast<std::uint32_t>(byte);
    for (int bit = 0; bit < 8; ++bit) crc = (crc >> 1U) ^ ((crc & 1U) != 0 ? 0xedb88320U : 0U);
  }
  return ~crc;
}

void put_big_endian(Bytes& bytes, std::size_t at, std::uint32_t value) {
  for (std::size_t i = 0; i < 4; ++i) bytes[at + i] = static_cast<std::byte>(value >> (24U - 8U * i));
}

constexpr std::size_t kIhdrAt = 12;  // type of the first chunk
constexpr std::size_t kIhdrSize = 17;

/// The same file with other sizes in a header whose checksum is right.
Bytes with_size(Bytes png, std::uint32_t width, std::uint32_t height) {
  put_big_endian(png, kIhdrAt + 4, width);
  put_big_endian(png, kIhdrAt + 8, height);
  put_big_endian(png, kIhdrAt + kIhdrSize, crc32(std::span(png).subspan(kIhdrAt, kIhdrSize)));
  return png;
}

template <class T>
void expect_format_error(const Result<T>& result, const char* what) {
  ASSERT_FALSE(result.ok());
  EXPECT_EQ(result.error().code, ErrorCode::format);
  EXPECT_THAT(result.error().message, AllOf(StartsWith("name.png: "), HasSubstr(what)));
}

TEST(DepthPng, RoundTripKeepsEveryValue) {
  const TemporaryFolder folder;
  DepthImage image{256, 256, 1, {}};
  for (unsigned i = 0; i < 65536; ++i)
    image.pixels.push_back(static_cast<std::uint16_t>(i * 40503U));  // odd factor: each value once
  ASSERT_TRUE(write_png(folder / "depth.png", image).ok());
  const auto read = read_depth_png(folder / "depth.png");
  ASSERT_TRUE(read.ok()) << read.error().message;
  EXPECT_EQ(read->width, 256);
  EXPECT_EQ(read->height, 256);
  EXPECT_EQ(read->channels, 1);
  EXPECT_EQ(read->pixels, image.pixels);
}

TEST(DepthPng, ReadsInterlacedImages) {
  Bytes raw(2 * 15);
  const DepthImage image = small_depth();
  std::memcpy(raw.data(), image.pixels.data(), raw.size());
  const auto read = decode_depth_png(make_png(5, 3, SPNG_COLOR_TYPE_GRAYSCALE, 16, raw, true), "name.png");
  ASSERT_TRUE(read.ok()) << read.error().message;
  EXPECT_EQ(read->pixels, image.pixels);
}

TEST(DepthPng, ViewGivesMetres) {
  const DepthImage image = small_depth();
  const DepthView depth = view(image, 5000.0);
  EXPECT_TRUE(validate(depth).ok());
  EXPECT_FLOAT_EQ(depth.metres(1, 0), 4369.0F / 5000.0F);
  EXPECT_FLOAT_EQ(depth.metres(4, 2), 61166.0F / 5000.0F);
}

TEST(LabelPng, RoundTripKeepsEveryValue) {
  const TemporaryFolder folder;
  LabelImage image{16, 16, 1, {}};
  for (unsigned i = 0; i < 256; ++i) image.pixels.push_back(static_cast<std::uint8_t>(i));
  ASSERT_TRUE(write_png(folder / "labels.png", image).ok());
  const auto read = read_label_png(folder / "labels.png");
  ASSERT_TRUE(read.ok()) << read.error().message;
  EXPECT_EQ(read->pixels, image.pixels);
}

TEST(ColourPng, RoundTripKeepsEveryValue) {
  ColourImage image{3, 2, 3, {}};
  for (unsigned i = 0; i < 18; ++i) image.pixels.push_back(static_cast<std::uint8_t>(14 * i));
  const auto bytes = encode_png(image);
  ASSERT_TRUE(bytes.ok());
  const auto read = decode_colour_image(*bytes, "name.png");
  ASSERT_TRUE(read.ok()) << read.error().message;
  EXPECT_EQ(read->channels, 3);
  EXPECT_EQ(read->pixels, image.pixels);
}

TEST(ColourPng, ConvertsPaletteGreyAndAlpha) {
  const auto b = [](auto... values) { return Bytes{static_cast<std::byte>(values)...}; };
  const auto pixels = [](const Bytes& png) {
    const auto read = decode_colour_image(png, "name.png");
    return read.ok() ? read->pixels : std::vector<std::uint8_t>{};
  };
  using Values = std::vector<std::uint8_t>;
  EXPECT_EQ(pixels(make_png(2, 1, SPNG_COLOR_TYPE_INDEXED, 8, b(1, 0))), (Values{40, 50, 60, 10, 20, 30}));
  EXPECT_EQ(pixels(make_png(2, 1, SPNG_COLOR_TYPE_GRAYSCALE, 8, b(7, 9))), (Values{7, 7, 7, 9, 9, 9}));
  EXPECT_EQ(pixels(make_png(1, 1, SPNG_COLOR_TYPE_TRUECOLOR_ALPHA, 8, b(1, 2, 3, 4))), (Values{1, 2, 3}));
}

TEST(ColourJpeg, DecodesRedGreenBlue) {
  const auto read = decode_colour_image(make_jpeg(20, 10), "name.jpg");
  ASSERT_TRUE(read.ok()) << read.error().message;
  EXPECT_EQ(read->width, 20);
  EXPECT_EQ(read->height, 10);
  for (std::size_t i = 0; i < read->pixels.size(); ++i) EXPECT_NEAR(read->pixels[i], i % 3 == 0 ? 200 : 50, 2);
}

TEST(ColourJpeg, CutOffAnywhereIsAnError) {
  const Bytes jpeg = make_jpeg(20, 10);
  for (std::size_t size = 0; size + 2 < jpeg.size(); ++size) {  // libjpeg forgives a missing end mark
    const auto read = decode_colour_image(std::span(jpeg).first(size), "name.png");
    expect_format_error(read, "");
  }
}

TEST(ColourJpeg, HugeSizesTakeNoMemory) {
  Bytes jpeg = make_jpeg(20, 10);
  const std::string text(reinterpret_cast<const char*>(jpeg.data()), jpeg.size());
  const std::size_t frame_header = text.find("\xff\xc0");
  ASSERT_NE(frame_header, std::string::npos);
  for (std::size_t i = 5; i < 9; ++i) jpeg[frame_header + i] = std::byte{0x0f};  // 3855 x 3855
  expect_format_error(decode_colour_image(jpeg, "name.png"), "too short for its 3855x3855 pixels");
  for (std::size_t i = 5; i < 9; ++i) jpeg[frame_header + i] = std::byte{0x8f};
  expect_format_error(decode_colour_image(jpeg, "name.png"), "36751x36751 pixels: larger than any accepted picture");
}

TEST(Png, CutOffAnywhereIsAnError) {
  const Bytes png = *encode_png(small_depth());
  ASSERT_TRUE(decode_depth_png(png, "name.png").ok());
  for (std::size_t size = 0; size < png.size(); ++size) {
    SCOPED_TRACE(size);
    expect_format_error(decode_depth_png(std::span(png).first(size), "name.png"), "");
  }
}

TEST(Png, AFlippedBitAnywhereIsAnError) {
  const Bytes png = *encode_png(small_depth());
  for (std::size_t at = 0; at < png.size(); ++at) {
    SCOPED_TRACE(at);
    Bytes broken = png;
    broken[at] ^= std::byte{1};
    EXPECT_FALSE(decode_depth_png(broken, "name.png").ok());
  }
}

TEST(Png, SaysThatAChecksumIsWrong) {
  Bytes png = *encode_png(small_depth());
  png[kIhdrAt + kIhdrSize] ^= std::byte{1};
  expect_format_error(decode_depth_png(png, "name.png"), "broken PNG: ");
}

TEST(Png, SaysWhatAPictureOfAnotherKindIs) {
  const Bytes raw(6);
  expect_format_error(decode_depth_png(make_png(8, 6, SPNG_COLOR_TYPE_GRAYSCALE, 1, raw), "name.png"),
                      "1-bit greyscale PNG, not a depth image (16-bit greyscale PNG)");
  expect_format_error(decode_depth_png(make_png(3, 2, SPNG_COLOR_TYPE_GRAYSCALE, 8, raw), "name.png"), "8-bit greyscale PNG");
  expect_format_error(decode_depth_png(make_png(1, 2, SPNG_COLOR_TYPE_TRUECOLOR, 8, raw), "name.png"), "8-bit RGB PNG");
  expect_format_error(decode_depth_png(make_png(1, 1, SPNG_COLOR_TYPE_TRUECOLOR, 16, raw), "name.png"), "16-bit RGB PNG");
  expect_format_error(decode_depth_png(make_png(3, 2, SPNG_COLOR_TYPE_INDEXED, 8, raw), "name.png"), "8-bit palette PNG");
  expect_format_error(decode_label_png(make_png(3, 1, SPNG_COLOR_TYPE_GRAYSCALE, 16, raw), "name.png"),
                      "16-bit greyscale PNG, not a label image (8-bit greyscale PNG)");
  expect_format_error(decode_label_png(make_png(3, 1, SPNG_COLOR_TYPE_GRAYSCALE_ALPHA, 8, raw), "name.png"),
                      "8-bit greyscale and alpha PNG");
  expect_format_error(decode_depth_png(make_jpeg(8, 8), "name.png"), "is a JPEG, not a PNG");
  expect_format_error(decode_depth_png({}, "name.png"), "is not a PNG");
  expect_format_error(decode_colour_image({}, "name.png"), "is neither a JPEG nor a PNG");
}

TEST(Png, TheLimitIsOnPixels) {
  const DepthImage image{20, 10, 1, std::vector<std::uint16_t>(200, 1000)};
  const Bytes png = *encode_png(image);
  EXPECT_TRUE(decode_depth_png(png, "name.png", {200}).ok());
  expect_format_error(decode_depth_png(png, "name.png", {199}), "20x10 pixels: more than the limit of 199 (--max-size)");
  const Bytes jpeg = make_jpeg(20, 10);
  EXPECT_TRUE(decode_colour_image(jpeg, "name.png", {200}).ok());
  expect_format_error(decode_colour_image(jpeg, "name.png", {199}), "20x10 pixels: more than the limit of 199");
}

TEST(Png, HugeSizesTakeNoMemory) {
  const Bytes png = *encode_png(small_depth());
  expect_format_error(decode_depth_png(with_size(png, 4096, 4096), "name.png"), "too short for its 4096x4096 pixels");
  expect_format_error(decode_depth_png(with_size(png, 32768, 32768), "name.png"), "more than the limit of 33554432 (--max-size)");
  expect_format_error(decode_depth_png(with_size(png, 32769, 1), "name.png"), "broken PNG: ");
  expect_format_error(decode_depth_png(with_size(png, 0x7fffffff, 0x7fffffff), "name.png"), "broken PNG: ");
  expect_format_error(decode_depth_png(with_size(png, 0, 3), "name.png"), "broken PNG: ");
  expect_format_error(decode_depth_png(with_size(png, 5, 4), "name.png"), "broken PNG: ");
}

TEST(Png, AnEmptyWallCompressesFurthestAndIsStillRead) {
  const DepthImage image{2048, 2048, 1, std::vector<std::uint16_t>(2048 * 2048)};
  const auto read = decode_depth_png(*encode_png(image), "name.png");
  ASSERT_TRUE(read.ok()) << read.error().message;
  EXPECT_EQ(read->pixels, image.pixels);
}

TEST(ReadImage, NamesTheMissingFile) {
  for (const auto& message : {read_depth_png("/nowhere/a.png").error().message, read_label_png("/nowhere/a.png").error().message,
                              read_colour_image("/nowhere/a.png").error().message}) {
    EXPECT_EQ(message, "/nowhere/a.png: No such file or directory");
  }
}

TEST(EncodePng, RefusesPicturesThatAreNotWhole) {
  for (const DepthImage& image :
       {DepthImage{}, DepthImage{2, 2, 1, {1, 2, 3}}, DepthImage{1, 1, 2, {1, 2}}, DepthImage{-1, 1, 1, {}},
        DepthImage{kMaxImageSide + 1, 1, 1, std::vector<std::uint16_t>(kMaxImageSide + 1)}}) {
    const auto bytes = encode_png(image);
    ASSERT_FALSE(bytes.ok());
    EXPECT_EQ(bytes.error().code, ErrorCode::invalid_argument);
  }
  EXPECT_FALSE(encode_png(LabelImage{1, 1, 2, {1, 2}}).ok());
}

TEST(WritePng, AFailureNamesTheFileAndLeavesNothing) {
  const TemporaryFolder folder;
  const Status status = write_png(folder / "a.png", DepthImage{});
  ASSERT_FALSE(status.ok());
  EXPECT_THAT(status.error().message, StartsWith((folder / "a.png").string() + ": "));
  EXPECT_TRUE(folder.names().empty());
  EXPECT_EQ(write_png("/dev/full", small_depth()).error().message, "/dev/full: No space left on device");
}

}  // namespace
}  // namespace fransac::io
