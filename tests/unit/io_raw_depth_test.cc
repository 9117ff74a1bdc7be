// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <tiffio.h>

#include <bit>
#include <cstring>
#include <string>
#include <vector>

#include "fransac/io/dataset.hpp"
#include "fransac/io/image.hpp"
#include "temporary_folder.h"

namespace fransac::io {
namespace {

using fransac::testing::TemporaryFolder;
using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::StartsWith;

const std::vector<std::uint16_t> kUnits{0, 1, 258, 4000, 65535, 7};
const std::vector<float> kMetres{0.0F, 0.25F, 1.5F, -1.0F, 3e4F, 7.125F};

Result<RawDepth> decode(const std::string& file, const ReadLimits& limits = {}) {
  return decode_depth_image(std::as_bytes(std::span(file)), "depth", limits);
}

/// Values as bytes, in the machine's order (little-endian) or reversed.
template <class T>
std::string bytes_of(const std::vector<T>& values, bool reversed = false) {
  std::string bytes;
  for (const T& value : values) {
    std::string one(sizeof(T), '\0');
    std::memcpy(one.data(), &value, sizeof(T));
    if (reversed) one.assign(one.rbegin(), one.rend());
    bytes += one;
  }
  return bytes;
}

std::string pgm(const std::string& header, const std::string& data) { return header + data; }

std::string npy(const std::string& dictionary, const std::string& data, char version = 1) {
  std::string length(version == 1 ? 2 : 4, '\0');
  length[0] = static_cast<char>(dictionary.size());
  return std::string("\x93NUMPY") + version + '\0' + length + dictionary + data;
}

std::string dictionary(const std::string& type, const std::string& shape, const std::string& fortran = "False") {
  return "{'descr': '" + type + "', 'fortran_order': " + fortran + ", 'shape': " + shape + ", }\n";
}

struct TiffTags {
  std::uint32_t width = 3;
  std::uint32_t height = 2;
  std::uint16_t samples = 1;
  std::uint16_t compression = COMPRESSION_NONE;
  bool tiled = false;
};

/// A TIFF by libtiff, its rows in strips of one.
template <class T>
std::string tiff(const std::vector<T>& values, std::uint16_t format, const TiffTags& tags = {}, const char* mode = "w") {
  const TemporaryFolder folder;
  const auto file = folder / "depth.tiff";
  TIFF* const out = TIFFOpen(file.c_str(), mode);
  TIFFSetField(out, TIFFTAG_IMAGEWIDTH, tags.width);
  TIFFSetField(out, TIFFTAG_IMAGELENGTH, tags.height);
  TIFFSetField(out, TIFFTAG_BITSPERSAMPLE, 8 * sizeof(T));
  TIFFSetField(out, TIFFTAG_SAMPLESPERPIXEL, tags.samples);
  TIFFSetField(out, TIFFTAG_SAMPLEFORMAT, format);
  TIFFSetField(out, TIFFTAG_PHOTOMETRIC, PHOTOMETRIC_MINISBLACK);
  TIFFSetField(out, TIFFTAG_COMPRESSION, tags.compression);
  TIFFSetField(out, TIFFTAG_PLANARCONFIG, PLANARCONFIG_CONTIG);
  std::vector<T> copy = values;
  if (tags.tiled) {
    TIFFSetField(out, TIFFTAG_TILEWIDTH, 16);
    TIFFSetField(out, TIFFTAG_TILELENGTH, 16);
    copy.resize(256);
    TIFFWriteTile(out, copy.data(), 0, 0, 0, 0);
  } else {
    TIFFSetField(out, TIFFTAG_ROWSPERSTRIP, 1);
    const std::size_t row = std::size_t{tags.width} * tags.samples;
    for (std::uint32_t v = 0; v < tags.height; ++v) TIFFWriteScanline(out, copy.data() + v * row, v, 0);
  }
  TIFFClose(out);
  return fransac::testing::read_text(file);
}

void expect_units(const std::string& file) {
  const auto read = decode(file);
  ASSERT_TRUE(read.ok()) << read.error().message;
  EXPECT_EQ(read->units.width, 3);
  EXPECT_EQ(read->units.height, 2);
  EXPECT_EQ(read->units.pixels, kUnits);
  EXPECT_TRUE(read->metres.pixels.empty());
}

void expect_metres(const std::string& file) {
  const auto read = decode(file);
  ASSERT_TRUE(read.ok()) << read.error().message;
  EXPECT_EQ(read->metres.width, 3);
  EXPECT_EQ(read->metres.height, 2);
  EXPECT_EQ(read->metres.pixels, kMetres);
  EXPECT_TRUE(read->units.pixels.empty());
}

void expect_error(const std::string& file, const std::string& part, const ReadLimits& limits = {}) {
  const auto read = decode(file, limits);
  ASSERT_FALSE(read.ok()) << part;
  EXPECT_EQ(read.error().code, ErrorCode::format);
  EXPECT_THAT(read.error().message, AllOf(StartsWith("depth: "), HasSubstr(part)));
}

TEST(RawDepth, ReadsPng) {
  const auto png = encode_png(DepthImage{3, 2, 1, kUnits});
  expect_units(std::string(reinterpret_cast<const char*>(png->data()), png->size()));
}

TEST(RawDepth, ReadsPgm) {
  expect_units(pgm("P5\n3 2\n65535\n", bytes_of(kUnits, true)));
  expect_units(pgm("P5 # a comment\n# another\n 3\t2\r\n1000\n", bytes_of(kUnits, true)));
}

TEST(RawDepth, RefusesOtherPgms) {
  const std::string data = bytes_of(kUnits, true);
  expect_error(pgm("P5\n3 2\n255\n", data), "a PGM of values up to 255");
  expect_error(pgm("P5\n3 2\n70000\n", data), "a PGM of values up to 70000");
  expect_error(pgm("P2\n3 2\n65535\n", "1 2 3 4 5 6"), "a PGM of text (P2)");
  expect_error(pgm("P5\n3 x\n", data), "broken PGM: its header is not");
  expect_error(pgm("P5\n3 -2\n65535\n", data), "broken PGM: its header is not");
  expect_error(pgm("P5\n3 99999999999\n65535\n", data), "broken PGM: its header is not");
  expect_error("P5\n3 2 65535", "broken PGM: no blank");
  expect_error(pgm("P5\n3 2\n65535\n", data + "x"), "has bytes after its pixels");
  expect_error(pgm("P5\n0 2\n65535\n", ""), "0x2 pixels: larger than any accepted picture");
  expect_error(pgm("P5\n4294967295 4294967295\n65535\n", data), "larger than any accepted picture");
  expect_error(pgm("P5\n20000 20000\n65535\n", data), "more than the limit");
  expect_error(pgm("P5\n3 2\n65535\n", data), "more than the limit of 5 (--max-size)", {5});
}

TEST(RawDepth, ReadsNpy) {
  for (const char version : {'\1', '\2', '\3'}) expect_units(npy(dictionary("<u2", "(2, 3)"), bytes_of(kUnits), version));
  expect_units(npy(dictionary(">u2", "(2, 3)"), bytes_of(kUnits, true)));
  expect_units(npy("{'shape': (2, 3,), 'fortran_order': False, 'descr': '<u2'}", bytes_of(kUnits)));
  expect_metres(npy(dictionary("<f4", "(2, 3)"), bytes_of(kMetres)));
  expect_metres(npy(dictionary(">f4", "(2, 3)"), bytes_of(kMetres, true)));
  const std::vector<double> doubles(kMetres.begin(), kMetres.end());
  expect_metres(npy(dictionary("<f8", "(2, 3)"), bytes_of(doubles)));
  expect_metres(npy(dictionary(">f8", "(2, 3)"), bytes_of(doubles, true)));
}

TEST(RawDepth, RefusesOtherArrays) {
  const std::string data = bytes_of(kUnits);
  expect_error(npy(dictionary("<u2", "(2, 3)", "True"), data), "not in C order");
  expect_error(npy(dictionary("<u2", "(2, 3, 1)"), data), "an array of 3 dimensions");
  expect_error(npy(dictionary("<u2", "()"), data), "an array of 0 dimensions");
  expect_error(npy(dictionary("<i2", "(2, 3)"), data), "an array of '<i2'");
  expect_error(npy(dictionary("|u1", "(2, 3)"), data), "an array of '|u1'");
  expect_error(npy(dictionary("|O", "(2, 3)"), data), "an array of '|O'");
  expect_error(npy(dictionary("", "(2, 3)"), data), "broken NPY: its header has no descr");
  expect_error(npy("{'descr': '<u2', 'fortran_order': False}", data), "broken NPY: its header has no");
  expect_error(npy("{'descr': [('a', '<u2')], 'fortran_order': False, 'shape': (2, 3)}", data), "broken NPY: its header has no");
  expect_error(npy(dictionary("<u2", "(2, 99999999999)"), data), "broken NPY: its header has no");
  expect_error(npy(dictionary("<u2", "(4294967295, 4294967295)"), data), "larger than any accepted picture");
  expect_error(npy(dictionary("<f8", "(5000, 5000)"), data), "too short for its 5000x5000");
  expect_error(npy(dictionary("<u2", "(20000, 20000)"), data), "more than the limit");
  expect_error(npy(dictionary("<u2", "(2, 3)"), data + "x"), "has bytes after its values");
  expect_error(npy(dictionary("<u2", "(2, 3)"), data, 4), "an NPY of unknown version");
  expect_error(npy(dictionary("<u2", "(2, 3)"), data), "more than the limit of 5", {5});
}

TEST(RawDepth, ReadsTiff) {
  for (const int codec : {COMPRESSION_NONE, COMPRESSION_LZW, COMPRESSION_ADOBE_DEFLATE, COMPRESSION_PACKBITS}) {
    const auto compression = static_cast<std::uint16_t>(codec);
    expect_units(tiff(kUnits, SAMPLEFORMAT_UINT, {.compression = compression}));
    expect_metres(tiff(kMetres, SAMPLEFORMAT_IEEEFP, {.compression = compression}));
  }
  for (const char* const mode : {"wl", "wb", "w8"}) {
    expect_units(tiff(kUnits, SAMPLEFORMAT_UINT, {}, mode));
    expect_metres(tiff(kMetres, SAMPLEFORMAT_IEEEFP, {}, mode));
  }
}

TEST(RawDepth, RefusesOtherTiffs) {
  const std::vector<std::uint8_t> bytes(18, 1);
  expect_error(tiff(bytes, SAMPLEFORMAT_UINT), "a TIFF of 1 8-bit unsigned value(s) a pixel");
  expect_error(tiff(bytes, SAMPLEFORMAT_UINT, {.samples = 3}), "a TIFF of 3 8-bit unsigned");
  expect_error(tiff(std::vector<std::int16_t>(6), SAMPLEFORMAT_INT), "a TIFF of 1 16-bit signed");
  expect_error(tiff(std::vector<double>(6), SAMPLEFORMAT_IEEEFP), "a TIFF of 1 64-bit float");
  expect_error(tiff(kUnits, SAMPLEFORMAT_UINT, {.tiled = true}), "a TIFF of tiles");
  expect_error(tiff(kUnits, SAMPLEFORMAT_UINT, {.compression = COMPRESSION_LZMA}), "a TIFF of compression 34925");
  expect_error(tiff(kUnits, SAMPLEFORMAT_UINT), "more than the limit of 5", {5});
  expect_error(std::string("II*\0garbage", 11), "broken TIFF: ");
  expect_error(tiff(std::vector<std::uint16_t>(20000), SAMPLEFORMAT_UINT, {.width = 20000, .height = 1}), "more than the limit",
               {1000});
}

TEST(RawDepth, ATruncatedFileIsAnError) {
  const std::vector<std::string> files{pgm("P5\n3 2\n65535\n", bytes_of(kUnits, true)),
                                       npy(dictionary("<u2", "(2, 3)"), bytes_of(kUnits)),
                                       npy(dictionary("<f8", "(2, 3)"), bytes_of(std::vector<double>(6))),
                                       tiff(kUnits, SAMPLEFORMAT_UINT, {.compression = COMPRESSION_LZW})};
  for (const std::string& file : files) {
    for (std::size_t size = 0; size < file.size(); ++size) expect_error(file.substr(0, size), "");
  }
}

TEST(RawDepth, FramesMayHoldMetres) {
  const TemporaryFolder folder;
  folder.write("frame/depth.npy", npy(dictionary("<f4", "(2, 3)"), bytes_of(kMetres)));
  folder.write("frame/camera.json", R"({"width": 3, "height": 2, "fx": 3, "fy": 3, "cx": 1, "cy": 1})");
  EXPECT_EQ(*detect_kind(folder / "frame"), InputKind::frame);
  EXPECT_EQ(*detect_kind(folder / "frame/depth.npy"), InputKind::depth_image);
  FrameFiles files = list_frames(folder / "frame")->frames[0];
  auto frame = load_frame(files);
  ASSERT_TRUE(frame.ok()) << frame.error().message;
  EXPECT_EQ(frame->view().format(), DepthFormat::float32);
  EXPECT_EQ(frame->view().metres(2, 0), 1.5F);
  files.depth_scale = 1000.0;
  EXPECT_EQ(load_frame(files)->view().metres(2, 0), 1.5e-3F);
  files.depth_scale = 0.5;
  EXPECT_THAT(load_frame(files).error().message, HasSubstr("depth.npy: camera field \"depth_scale\""));
}

TEST(RawDepth, FoldersOfImagesAndScaleByTheUser) {
  const TemporaryFolder folder;
  folder.write("a.pgm", pgm("P5\n3 2\n65535\n", bytes_of(kUnits, true)));
  folder.write("b.tiff", tiff(kUnits, SAMPLEFORMAT_UINT));
  folder.write("camera.json", R"({"width": 3, "height": 2, "fx": 3, "fy": 3, "cx": 1, "cy": 1})");
  const auto dataset = list_frames(folder.path());
  ASSERT_TRUE(dataset.ok()) << dataset.error().message;
  ASSERT_EQ(dataset->frames.size(), 2U);
  for (FrameFiles files : dataset->frames) {
    EXPECT_EQ(load_frame(files)->view().metres(0, 1), 4.0F);
    files.depth_scale = 4000.0;
    EXPECT_EQ(load_frame(files)->view().metres(0, 1), 1.0F);
  }
}

}  // namespace
}  // namespace fransac::io
