// SPDX-License-Identifier: Apache-2.0
#include "fransac/io/image.hpp"

#include <spng.h>
#include <turbojpeg.h>

#include <algorithm>
#include <cstdlib>
#include <memory>
#include <string_view>
#include <utility>

#include "fransac/io/file.hpp"
#include "io/depth_reader.h"
#include "io/grey_png.h"
#include "io/guard.h"
#include "io/raw_depth.h"
#include "io/text.h"

namespace fransac::io {
namespace {

// A colour profile or a text in a picture may be as large; a zlib bomb in one ends here.
constexpr std::size_t kMaxChunkBytes = std::size_t{1} << 24;
constexpr std::size_t kMaxChunkCacheBytes = std::size_t{1} << 26;
// A Huffman-coded JPEG spends at least one bit on the mean of each 8 x 8 block (ITU-T T.81, F.1.2.1): 512 pixels a byte.
constexpr std::uint64_t kMaxJpegPixelsPerByte = 512;

constexpr std::string_view kPngEnd("\0\0\0\0IEND\xae\x42\x60\x82", 12);  // the last chunk, always the same
constexpr std::string_view kJpegSignature = "\xff\xd8\xff";

constexpr std::string_view kDepthImage = "a depth image (16-bit greyscale PNG)";

using PngContext = std::unique_ptr<spng_ctx, decltype(&spng_ctx_free)>;
using JpegDecoder = std::unique_ptr<void, decltype(&tjDestroy)>;

/// What a picture that is not wanted is, for messages: "8-bit RGB PNG".
std::string describe(const spng_ihdr& header) {
  const auto colour = [&]() -> std::string_view {
    switch (header.color_type) {
      case SPNG_COLOR_TYPE_GRAYSCALE: return "greyscale";
      case SPNG_COLOR_TYPE_TRUECOLOR: return "RGB";
      case SPNG_COLOR_TYPE_INDEXED: return "palette";
      case SPNG_COLOR_TYPE_GRAYSCALE_ALPHA: return "greyscale and alpha";
      default: return "RGB and alpha";
    }
  }();
  return std::to_string(header.bit_depth) + "-bit " + std::string(colour) + " PNG";
}

std::uint64_t raw_bits_per_pixel(const spng_ihdr& header) {
  switch (header.color_type) {
    case SPNG_COLOR_TYPE_TRUECOLOR: return 3U * header.bit_depth;
    case SPNG_COLOR_TYPE_GRAYSCALE_ALPHA: return 2U * header.bit_depth;
    case SPNG_COLOR_TYPE_TRUECOLOR_ALPHA: return 4U * header.bit_depth;
    default: return header.bit_depth;
  }
}

/// What spng says of an error; throws where that is a lack of memory.
std::string reason(int error) {
  if (error == SPNG_EMEM || error == SPNG_EZLIB_INIT) throw std::bad_alloc();
  return spng_strerror(error);
}

/// A PNG whose header has been read and checked.
struct PngReader {
  PngContext context;
  spng_ihdr header;
};

Result<PngReader> open_png(std::span<const std::byte> bytes, const ReadLimits& limits, const std::string& name) {
  if (as_text(bytes).starts_with(kJpegSignature)) return format_error(name, "is a JPEG, not a PNG");
  if (!as_text(bytes).starts_with(kPngSignature)) return format_error(name, "is not a PNG");
  PngReader reader{PngContext(spng_ctx_new(0), &spng_ctx_free), {}};
  spng_ctx* const context = reader.context.get();
  if (context == nullptr) throw std::bad_alloc();
  int error = spng_set_image_limits(context, kMaxImageSide, kMaxImageSide);
  if (error == 0) error = spng_set_chunk_limits(context, kMaxChunkBytes, kMaxChunkCacheBytes);
  if (error == 0) error = spng_set_png_buffer(context, bytes.data(), bytes.size());
  if (error == 0) error = spng_get_ihdr(context, &reader.header);
  if (error != 0) return format_error(name, "broken PNG: " + reason(error));
  const spng_ihdr& header = reader.header;
  const std::uint64_t raw_bytes = std::uint64_t{header.width} * header.height * raw_bits_per_pixel(header) / 8;
  if (Status status = check_size(header.width, header.height, raw_bytes / kMaxDeflateFactor, bytes.size(), limits, name);
      !status) {
    return status.error();
  }
  // spng does not ask for the end chunk's checksum.
  if (as_text(bytes).rfind(kPngEnd) == std::string_view::npos) return format_error(name, "broken PNG: cut off before its end");
  return reader;
}

/// Decodes to `format`, whose pixels are `channels` values of type T.
template <class T>
Result<Image<T>> decode_png(const PngReader& reader, int format, int channels, const std::string& name) {
  Image<T> image{static_cast<int>(reader.header.width), static_cast<int>(reader.header.height), channels, {}};
  image.pixels.resize(image.size() * static_cast<std::size_t>(channels));
  spng_ctx* const context = reader.context.get();
  int error = spng_decode_image(context, image.pixels.data(), image.pixels.size() * sizeof(T), format, 0);
  if (error == 0) error = spng_decode_chunks(context);  // to the end mark: a file that was cut off short is not whole
  if (error != 0) return format_error(name, "broken PNG: " + reason(error));
  return image;
}

/// Greyscale of `wanted`, by the faster decoder where it can; else by libspng, which knows what is wrong.
template <class T>
Status decode_grey(std::span<const std::byte> bytes, const std::string& name, const ReadLimits& limits, std::string_view wanted,
                   GreyPngDecoder& decoder, Image<T>& image) {
  if (decoder.decode(bytes, limits, image)) return {};
  Result<Image<T>> slow = decode_grey_by_spng<T>(bytes, name, limits, wanted);
  if (!slow) return slow.error();
  image = *std::move(slow);
  return {};
}

template <class T>
Result<Image<T>> decode_grey(std::span<const std::byte> bytes, const std::string& name, const ReadLimits& limits,
                             std::string_view wanted) {
  return guarded(name, [&]() -> Result<Image<T>> {
    GreyPngDecoder decoder;
    Image<T> image;
    if (Status status = decode_grey(bytes, name, limits, wanted, decoder, image); !status) return status.error();
    return image;
  });
}

Result<ColourImage> decode_jpeg(std::span<const std::byte> bytes, const ReadLimits& limits, const std::string& name) {
  const JpegDecoder decoder(tjInitDecompress(), &tjDestroy);
  if (decoder == nullptr) throw std::bad_alloc();
  const auto broken = [&] { return format_error(name, std::string("broken JPEG: ") + tjGetErrorStr2(decoder.get())); };
  const auto* const data = reinterpret_cast<const unsigned char*>(bytes.data());
  ColourImage image{0, 0, 3, {}};
  int subsampling = 0;
  int colour_space = 0;
  if (tjDecompressHeader3(decoder.get(), data, bytes.size(), &image.width, &image.height, &subsampling, &colour_space) != 0) {
    return broken();
  }
  const auto width = static_cast<std::uint64_t>(image.width);
  const auto height = static_cast<std::uint64_t>(image.height);
  if (Status status = check_size(width, height, width * height / kMaxJpegPixelsPerByte, bytes.size(), limits, name); !status) {
    return status.error();
  }
  image.pixels.resize(image.size() * 3);
  constexpr int kFlags = TJFLAG_STOPONWARNING | TJFLAG_LIMITSCANS;  // cut off: an error; thousands of scans: refused
  if (tjDecompress2(decoder.get(), data, bytes.size(), image.pixels.data(), image.width, 0, image.height, TJPF_RGB, kFlags) !=
      0) {
    return broken();
  }
  return image;
}

template <class Image>
Result<Image> read_image(const std::filesystem::path& file, const ReadLimits& limits,
                         Result<Image> (*decode)(std::span<const std::byte>, const std::string&, const ReadLimits&)) {
  return guarded(file.native(), [&]() -> Result<Image> {
    const Result<std::vector<std::byte>> bytes = read_file(file, limits.max_decoded_bytes());
    if (!bytes) return bytes.error();
    return decode(*bytes, file.string(), limits);
  });
}

template <class T>
Status check_image(const Image<T>& image, std::string_view channels, bool channels_fit) {
  const auto error = [](const std::string& what) { return Error{ErrorCode::invalid_argument, "picture: " + what}; };
  if (image.width < 1 || image.height < 1 || image.width > kMaxImageSide || image.height > kMaxImageSide) {
    return error("width and height must be between 1 and " + std::to_string(kMaxImageSide) + " pixels");
  }
  if (!channels_fit) return error("needs " + std::string(channels) + ", not " + std::to_string(image.channels));
  if (image.pixels.size() != image.size() * static_cast<std::size_t>(image.channels)) return error("pixels do not fill its size");
  return {};
}

template <class T>
Result<std::vector<std::byte>> encode(const Image<T>& image) {
  const PngContext context(spng_ctx_new(SPNG_CTX_ENCODER), &spng_ctx_free);
  if (context == nullptr) throw std::bad_alloc();
  spng_ihdr header{};
  header.width = static_cast<std::uint32_t>(image.width);
  header.height = static_cast<std::uint32_t>(image.height);
  header.bit_depth = 8 * sizeof(T);
  header.color_type = image.channels == 3 ? SPNG_COLOR_TYPE_TRUECOLOR : SPNG_COLOR_TYPE_GRAYSCALE;
  int error = spng_set_ihdr(context.get(), &header);
  // Speed before size: a dataset is many pictures, and depth noise hardly compresses.
  if (error == 0) error = spng_set_option(context.get(), SPNG_IMG_COMPRESSION_LEVEL, 1);
  if (error == 0) error = spng_set_option(context.get(), SPNG_FILTER_CHOICE, SPNG_FILTER_CHOICE_SUB);
  if (error == 0) error = spng_set_option(context.get(), SPNG_ENCODE_TO_BUFFER, 1);
  if (error == 0) {
    error = spng_encode_image(context.get(), image.pixels.data(), image.pixels.size() * sizeof(T), SPNG_FMT_PNG,
                              SPNG_ENCODE_FINALIZE);
  }
  std::size_t size = 0;
  void* const buffer = error == 0 ? spng_get_png_buffer(context.get(), &size, &error) : nullptr;
  const std::unique_ptr<void, decltype(&std::free)> owner(buffer, &std::free);
  if (error != 0) return Error{ErrorCode::io, "PNG encoder: " + reason(error)};
  const auto* const first = static_cast<const std::byte*>(buffer);
  return std::vector<std::byte>(first, first + size);
}

template <class T>
Status write_image(const std::filesystem::path& file, const Image<T>& image) {
  return guarded(file.native(), [&]() -> Status {
    const Result<std::vector<std::byte>> bytes = encode_png(image);
    if (!bytes) return file_error(bytes.error().code, file.native(), bytes.error().message);
    return write_file(file, *bytes);
  });
}

}  // namespace

template <class T>
Result<Image<T>> decode_grey_by_spng(std::span<const std::byte> bytes, const std::string& name, const ReadLimits& limits,
                                     std::string_view wanted) {
  const Result<PngReader> reader = open_png(bytes, limits, name);
  if (!reader) return reader.error();
  if (reader->header.color_type != SPNG_COLOR_TYPE_GRAYSCALE || reader->header.bit_depth != 8 * sizeof(T)) {
    return format_error(name, describe(reader->header) + ", not " + std::string(wanted));
  }
  return decode_png<T>(*reader, SPNG_FMT_PNG, 1, name);
}
template Result<LabelImage> decode_grey_by_spng(std::span<const std::byte>, const std::string&, const ReadLimits&,
                                                std::string_view);
template Result<DepthImage> decode_grey_by_spng(std::span<const std::byte>, const std::string&, const ReadLimits&,
                                                std::string_view);

Result<DepthImage> decode_depth_png(std::span<const std::byte> bytes, const std::string& name, const ReadLimits& limits) {
  return decode_grey<std::uint16_t>(bytes, name, limits, kDepthImage);
}

Result<LabelImage> decode_label_png(std::span<const std::byte> bytes, const std::string& name, const ReadLimits& limits) {
  return decode_grey<std::uint8_t>(bytes, name, limits, "a label image (8-bit greyscale PNG)");
}

Result<ObjectImage> decode_object_png(std::span<const std::byte> bytes, const std::string& name, const ReadLimits& limits) {
  return guarded(name, [&]() -> Result<ObjectImage> {
    const auto widened = [](const LabelImage& narrow) {
      return ObjectImage{narrow.width, narrow.height, 1, {narrow.pixels.begin(), narrow.pixels.end()}};
    };
    GreyPngDecoder decoder;
    ObjectImage image;
    if (decoder.decode(bytes, limits, image)) return image;
    if (LabelImage narrow; decoder.decode(bytes, limits, narrow)) return widened(narrow);
    const Result<PngReader> reader = open_png(bytes, limits, name);
    if (!reader) return reader.error();
    const bool grey = reader->header.color_type == SPNG_COLOR_TYPE_GRAYSCALE;
    if (grey && reader->header.bit_depth == 16) return decode_png<std::uint16_t>(*reader, SPNG_FMT_PNG, 1, name);
    if (!grey || reader->header.bit_depth != 8) {
      return format_error(name, describe(reader->header) + ", not an image of object ids (8-bit or 16-bit greyscale PNG)");
    }
    const Result<LabelImage> narrow = decode_png<std::uint8_t>(*reader, SPNG_FMT_PNG, 1, name);
    if (!narrow) return narrow.error();
    return widened(*narrow);
  });
}

Result<ColourImage> decode_colour_image(std::span<const std::byte> bytes, const std::string& name, const ReadLimits& limits) {
  return guarded(name, [&]() -> Result<ColourImage> {
    if (as_text(bytes).starts_with(kJpegSignature)) return decode_jpeg(bytes, limits, name);
    if (!as_text(bytes).starts_with(kPngSignature)) return format_error(name, "is neither a JPEG nor a PNG");
    const Result<PngReader> reader = open_png(bytes, limits, name);
    if (!reader) return reader.error();
    return decode_png<std::uint8_t>(*reader, SPNG_FMT_RGB8, 3, name);
  });
}

namespace {

Status decode_depth(std::span<const std::byte> bytes, const std::string& name, const ReadLimits& limits, GreyPngDecoder& decoder,
                    RawDepth& image) {
  switch (depth_format_of(as_text(bytes)).value_or(DepthFileFormat::png)) {
    case DepthFileFormat::tiff: return decode_depth_tiff(bytes, name, limits, image);
    case DepthFileFormat::pgm: return decode_depth_pgm(bytes, name, limits, image);
    case DepthFileFormat::npy: return decode_depth_npy(bytes, name, limits, image);
    case DepthFileFormat::png: break;
  }
  image.metres = {};
  return decode_grey(bytes, name, limits, kDepthImage, decoder, image.units);
}

}  // namespace

Status read_depth_image(const std::filesystem::path& file, const ReadLimits& limits, DepthReader& reader, RawDepth& image) {
  if (Status status = read_file(file, limits.max_decoded_bytes(), reader.file); !status) return status;
  return decode_depth(reader.file, file.string(), limits, reader.decoder, image);
}
Result<RawDepth> decode_depth_image(std::span<const std::byte> bytes, const std::string& name, const ReadLimits& limits) {
  return guarded(name, [&]() -> Result<RawDepth> {
    GreyPngDecoder decoder;
    RawDepth image;
    if (Status status = decode_depth(bytes, name, limits, decoder, image); !status) return status.error();
    return image;
  });
}
Result<RawDepth> read_depth_image(const std::filesystem::path& file, const ReadLimits& limits) {
  return read_image<RawDepth>(file, limits, &decode_depth_image);
}
Result<DepthImage> read_depth_png(const std::filesystem::path& file, const ReadLimits& limits) {
  return read_image<DepthImage>(file, limits, &decode_depth_png);
}
Result<LabelImage> read_label_png(const std::filesystem::path& file, const ReadLimits& limits) {
  return read_image<LabelImage>(file, limits, &decode_label_png);
}
Result<ObjectImage> read_object_png(const std::filesystem::path& file, const ReadLimits& limits) {
  return read_image<ObjectImage>(file, limits, &decode_object_png);
}
Result<ColourImage> read_colour_image(const std::filesystem::path& file, const ReadLimits& limits) {
  return read_image<ColourImage>(file, limits, &decode_colour_image);
}

Result<std::vector<std::byte>> encode_png(const DepthImage& image) {
  return guarded("picture", [&]() -> Result<std::vector<std::byte>> {
    if (Status status = check_image(image, "one channel", image.channels == 1); !status) return status.error();
    return encode(image);
  });
}

Result<std::vector<std::byte>> encode_png(const Image<std::uint8_t>& image) {
  return guarded("picture", [&]() -> Result<std::vector<std::byte>> {
    const bool fits = image.channels == 1 || image.channels == 3;
    if (Status status = check_image(image, "one or three channels", fits); !status) return status.error();
    return encode(image);
  });
}

Status write_png(const std::filesystem::path& file, const DepthImage& image) { return write_image(file, image); }
Status write_png(const std::filesystem::path& file, const Image<std::uint8_t>& image) { return write_image(file, image); }

Status write_object_png(const std::filesystem::path& file, const ObjectImage& image) {
  return guarded(file.native(), [&]() -> Status {
    if (std::any_of(image.pixels.begin(), image.pixels.end(), [](std::uint16_t id) { return id > 0xff; })) {
      return write_image(file, image);
    }
    LabelImage narrow{image.width, image.height, image.channels, std::vector<std::uint8_t>(image.pixels.size())};
    std::transform(image.pixels.begin(), image.pixels.end(), narrow.pixels.begin(),
                   [](std::uint16_t id) { return static_cast<std::uint8_t>(id); });
    return write_image(file, narrow);
  });
}

DepthView view(const DepthImage& image, double depth_scale) {
  return DepthView::from_uint16(image.pixels.data(), image.width, image.height, depth_scale);
}

DepthView view(const MetresImage& image) { return DepthView::from_float(image.pixels.data(), image.width, image.height); }

}  // namespace fransac::io
