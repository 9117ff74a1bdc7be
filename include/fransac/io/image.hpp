// SPDX-License-Identifier: Apache-2.0
/// Images as files.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "fransac/core/camera.hpp"
#include "fransac/core/depth_image.hpp"
#include "fransac/core/result.hpp"
#include "fransac/io/limits.hpp"

namespace fransac::io {

/// Rows of `channels` interleaved values without gaps.
template <class T>
struct Image {
  int width = 0;          ///< Columns, pixels.
  int height = 0;         ///< Rows, pixels.
  int channels = 1;       ///< Values of a pixel.
  std::vector<T> pixels;  ///< width * height * channels.

  /// Pixels.
  [[nodiscard]] std::size_t size() const { return static_cast<std::size_t>(width) * static_cast<std::size_t>(height); }
};
/// Raw depth, one channel.
using DepthImage = Image<std::uint16_t>;
/// Labels (core/labels.hpp), one channel.
using LabelImage = Image<std::uint8_t>;
using MetresImage = Image<float>;          ///< Depth in metres, one channel; what DepthFormat::float32 says is no measurement.
using ObjectImage = Image<std::uint16_t>;  ///< Which object each pixel belongs to; 0: none.
using ColourImage = Image<std::uint8_t>;   ///< Three channels: red, green, blue.

/// A depth image as a file holds it.
struct RawDepth {
  DepthImage units;    ///< Raw units; without pixels where the file holds metres.
  MetresImage metres;  ///< Without pixels where the file holds raw units.
};

/// Reads a depth image: 16-bit raw units from a greyscale PNG, a greyscale TIFF, a binary PGM or an NPY array (uint16), or metres
/// from a TIFF of 32-bit floats or an NPY array of float32 or float64. The format is found from the content. Other images and
/// arrays are format errors that say what they are; so is one with more pixels than `limits` allow, here and below.
Result<RawDepth> read_depth_image(const std::filesystem::path& file, const ReadLimits& limits = {});
/// The same from memory; `name` stands for the file in messages.
Result<RawDepth> decode_depth_image(std::span<const std::byte> bytes, const std::string& name, const ReadLimits& limits = {});
/// Reads a 16-bit greyscale PNG. Any other PNG is a format error that says what it is.
Result<DepthImage> read_depth_png(const std::filesystem::path& file, const ReadLimits& limits = {});
/// The same from memory; `name` stands for the file in messages.
Result<DepthImage> decode_depth_png(std::span<const std::byte> bytes, const std::string& name, const ReadLimits& limits = {});
/// Reads an 8-bit greyscale PNG.
Result<LabelImage> read_label_png(const std::filesystem::path& file, const ReadLimits& limits = {});
/// The same from memory.
Result<LabelImage> decode_label_png(std::span<const std::byte> bytes, const std::string& name, const ReadLimits& limits = {});
/// Reads an 8-bit or 16-bit greyscale PNG of object ids.
Result<ObjectImage> read_object_png(const std::filesystem::path& file, const ReadLimits& limits = {});
/// The same from memory.
Result<ObjectImage> decode_object_png(std::span<const std::byte> bytes, const std::string& name, const ReadLimits& limits = {});
/// Reads an 8-bit colour picture, JPEG or PNG (found from the content), as red, green, blue.
Result<ColourImage> read_colour_image(const std::filesystem::path& file, const ReadLimits& limits = {});
/// The same from memory.
Result<ColourImage> decode_colour_image(std::span<const std::byte> bytes, const std::string& name, const ReadLimits& limits = {});

/// Writes a PNG: 16-bit grey for depth, 8-bit grey for one channel, 8-bit colour for three. Temporary name, then renamed.
Status write_png(const std::filesystem::path& file, const DepthImage& image);
/// The same of 8-bit images.
Status write_png(const std::filesystem::path& file, const Image<std::uint8_t>& image);
/// Writes object ids: 8-bit grey where all fit, else 16-bit.
Status write_object_png(const std::filesystem::path& file, const ObjectImage& image);
/// The bytes that write_png writes.
Result<std::vector<std::byte>> encode_png(const DepthImage& image);
/// The same of 8-bit images.
Result<std::vector<std::byte>> encode_png(const Image<std::uint8_t>& image);

/// A view of an image with the camera's depth scale.
DepthView view(const DepthImage& image, double depth_scale);
/// A view of an image in metres.
DepthView view(const MetresImage& image);

}  // namespace fransac::io
