// SPDX-License-Identifier: Apache-2.0
// Section numbers: Portable Network Graphics (PNG) Specification, second edition, W3C 2003.
#include "io/grey_png.h"

#include <libdeflate.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>
#include <new>
#include <optional>
#include <string_view>

#include "io/text.h"

namespace fransac::io {
namespace {

std::uint32_t big_endian(std::span<const std::byte> bytes, std::size_t at) {
  std::uint32_t value = 0;
  for (const std::byte byte : bytes.subspan(at, 4)) value = value << 8U | static_cast<std::uint32_t>(byte);
  return value;
}

/// A chunk (5.3): the length of its data, its type, its data, and a checksum of the last two.
struct Chunk {
  std::string_view type;
  std::span<const std::byte> data;
};

/// Takes the first chunk from `bytes`; nothing where it is cut off, or its checksum is wrong.
std::optional<Chunk> take_chunk(std::span<const std::byte>& bytes) {
  constexpr std::size_t kAround = 12;  // length, type and checksum
  if (bytes.size() < kAround) return {};
  const std::size_t length = big_endian(bytes, 0);
  if (length > bytes.size() - kAround) return {};
  const auto typed = bytes.subspan(4, 4 + length);
  if (libdeflate_crc32(0, typed.data(), typed.size()) != big_endian(bytes, 8 + length)) return {};
  bytes = bytes.subspan(kAround + length);
  return Chunk{as_text(typed.first(4)), typed.subspan(4)};
}

struct Size {
  std::size_t width;
  std::size_t height;

  [[nodiscard]] bool fits(const ReadLimits& limits) const {
    constexpr std::size_t kMaxSide = kMaxImageSide;
    return width >= 1 && height >= 1 && width <= kMaxSide && height <= kMaxSide && width * height <= limits.max_size;
  }
};

/// The size in a header (11.2.2) of greyscale of `bit_depth` that is not interlaced.
std::optional<Size> size_of(const Chunk& header, std::size_t bit_depth) {
  if (header.type != "IHDR" || header.data.size() != 13) return {};
  // Colour type, compression, filters and interlacing: 0.
  const bool plain = std::all_of(header.data.begin() + 9, header.data.end(), [](std::byte b) { return b == std::byte{0}; });
  if (!plain || static_cast<std::size_t>(header.data[8]) != bit_depth) return {};
  return Size{big_endian(header.data, 0), big_endian(header.data, 4)};
}

// A pixel's bytes have 16 bits each in what follows, so that both are added at once.
constexpr std::uint32_t kLanes = 0x00ff00ffU;

std::uint32_t spread(std::uint8_t pixel) { return pixel; }
std::uint32_t spread(std::uint16_t pixel) { return (pixel & 0xff00U) << 8U | (pixel & 0xffU); }

template <class T>
T joined(std::uint32_t lanes) {
  return static_cast<T>(lanes >> 8U | lanes);
}

/// Whether a pixel's bytes stand in a file the other way round.
template <class T>
constexpr bool kSwapped = sizeof(T) == 2 && std::endian::native == std::endian::little;

/// The pixel at `bytes`, whose first byte is the highest.
template <class T>
T loaded(const std::byte* bytes) {
  T value;
  std::memcpy(&value, bytes, sizeof value);
  if constexpr (kSwapped<T>) value = static_cast<T>(value >> 8U | value << 8U);
  return value;
}

// Four pixels, and their bytes in lanes: vectors of the compiler's own, which any processor has or is made to have.
using Pixels = std::uint32_t __attribute__((vector_size(16)));
using Lanes = std::int16_t __attribute__((vector_size(16)));

/// The one of a, b and c that is nearest to a + b - c, the first of them where two are (9.4): c if it is between the others, else
/// the one of them that is farther from it.
Lanes paeth(Lanes a, Lanes b, Lanes c) {
  const auto choose = [](Lanes where, Lanes x, Lanes y) { return (where & x) | (~where & y); };
  const Lanes low = choose(a < b, a, b);
  const Lanes high = choose(a < b, b, a);
  const Lanes threshold = c + c + c - b - a;
  return choose(threshold > low, choose(high > threshold, c, low), high);
}

// Filters (9.2): what is in the file, `raw`, is the difference to a guess from the pixels to the left, above (`up`) and above
// left.

template <class T>
void undo_none(const std::byte* raw, std::size_t width, T* row) {
  for (std::size_t i = 0; i < width; ++i) row[i] = loaded<T>(raw + i * sizeof(T));
}

template <class T>
void undo_sub(const std::byte* raw, std::size_t width, T* row) {
  std::uint32_t left = 0;
  std::size_t i = 0;
  if constexpr (kSwapped<T>) {
    // Four pixels at once: in each lane of the product stands the sum of the lanes up to it.
    constexpr std::uint64_t kBytes = 0x00ff00ff00ff00ffU;
    constexpr std::uint64_t kOnes = 0x0001000100010001U;
    std::uint64_t high = 0;
    std::uint64_t low = 0;
    for (; i + 4 <= width; i += 4) {
      std::uint64_t four = 0;
      std::memcpy(&four, raw + 2 * i, sizeof four);
      const std::uint64_t highs = ((four & kBytes) + high) * kOnes & kBytes;
      const std::uint64_t lows = ((four >> 8U & kBytes) + low) * kOnes & kBytes;
      four = highs << 8U | lows;
      std::memcpy(row + i, &four, sizeof four);
      high = highs >> 48U;
      low = lows >> 48U;
    }
    left = static_cast<std::uint32_t>(high << 16U | low);
  }
  for (; i < width; ++i) {
    left = (left + spread(loaded<T>(raw + i * sizeof(T)))) & kLanes;
    row[i] = joined<T>(left);
  }
}

template <class T>
void undo_up(const std::byte* raw, std::size_t width, const T* up, T* row) {
  constexpr auto kHigh = static_cast<T>(0x8080U);
  for (std::size_t i = 0; i < width; ++i) {
    const T difference = loaded<T>(raw + i * sizeof(T));
    // Bytes added without their carries.
    row[i] = static_cast<T>(((difference & ~kHigh) + (up[i] & ~kHigh)) ^ ((difference ^ up[i]) & kHigh));
  }
}

template <class T>
void undo_average(const std::byte* raw, std::size_t width, const T* up, T* row) {
  std::uint32_t left = 0;
  for (std::size_t i = 0; i < width; ++i) {
    const std::uint32_t average = (left + spread(up[i])) >> 1U & kLanes;
    left = (average + spread(loaded<T>(raw + i * sizeof(T)))) & kLanes;
    row[i] = joined<T>(left);
  }
}

/// Some rows at once, each a pixel behind the one above it: a pixel needs those to its left, which are in a chain, and above it.
template <class T>
struct PaethRows {
  static constexpr std::size_t kMost = 4;
  std::array<const std::byte*, kMost> raw;
  std::array<T*, kMost> row;  ///< The last ones may be those of `raw`: of no use.

  void undo(std::size_t width, const T* up) const {
    Lanes left{};
    Lanes above_left{};
    const auto step = [&](std::size_t i, const auto& has_pixel) {  // pixel i of the first row, i - 1 of the second, …
      std::array<std::uint32_t, kMost> difference{};
      for (std::size_t k = 0; k < kMost; ++k) {
        if (has_pixel(k)) difference[k] = spread(loaded<T>(raw[k] + (i - k) * sizeof(T)));
      }
      const auto last = reinterpret_cast<Pixels>(left);
      const Pixels above{has_pixel(0) ? spread(up[i]) : 0U, last[0], last[1], last[2]};
      const auto b = reinterpret_cast<Lanes>(above);
      const Pixels differences{difference[0], difference[1], difference[2], difference[3]};
      left = (paeth(left, b, above_left) + reinterpret_cast<Lanes>(differences)) & 0xff;
      above_left = b;
      const auto pixels = reinterpret_cast<Pixels>(left);
      for (std::size_t k = 0; k < kMost; ++k) {
        if (has_pixel(k)) row[k][i - k] = joined<T>(pixels[k]);
      }
    };
    // At both ends some rows have no pixel. Before a row's first all is 0.
    const auto edge = [&](std::size_t i) { step(i, [&](std::size_t k) { return i >= k && i - k < width; }); };
    const std::size_t end = width + kMost - 1;
    std::size_t i = 0;
    for (; i < std::min(kMost - 1, end); ++i) edge(i);
    for (; i < width; ++i) step(i, [](std::size_t) { return true; });
    for (; i < end; ++i) edge(i);
  }
};

}  // namespace

void GreyPngDecoder::Free::operator()(libdeflate_decompressor* inflater) const { libdeflate_free_decompressor(inflater); }

bool GreyPngDecoder::inflate(std::span<const std::byte> deflated, std::span<std::byte> out) {
  if (inflater_ == nullptr) inflater_.reset(libdeflate_alloc_decompressor());
  if (inflater_ == nullptr) throw std::bad_alloc();
  std::size_t used = 0;
  const libdeflate_result result =
      libdeflate_zlib_decompress_ex(inflater_.get(), deflated.data(), deflated.size(), out.data(), out.size(), &used, nullptr);
  return result == LIBDEFLATE_SUCCESS && used == deflated.size();
}

/// The rows in the file, each after the number of its filter, are where the image's pixels begin: they are overtaken by no row
/// that is written, as each has one byte more than its pixels.
template <class T>
bool GreyPngDecoder::unfilter(Image<T>& image) {
  constexpr unsigned kPaeth = 4;
  constexpr std::size_t kMost = PaethRows<T>::kMost;
  const auto width = static_cast<std::size_t>(image.width);
  const auto height = static_cast<std::size_t>(image.height);
  const std::size_t row_bytes = width * sizeof(T);
  rows_.resize((kMost + 1) * row_bytes);
  // Above the first row all is 0.
  std::byte* const zeros = rows_.data() + kMost * row_bytes;
  std::memset(zeros, 0, row_bytes);
  const T* up = reinterpret_cast<const T*>(zeros);
  const auto* in = reinterpret_cast<const std::byte*>(image.pixels.data());
  T* row = image.pixels.data();
  for (std::size_t v = 0; v < height;) {
    const auto filter = static_cast<unsigned>(*in);
    std::byte* const raw = rows_.data();
    PaethRows<T> several{};
    for (std::size_t k = 0; k < kMost; ++k) {
      several.raw[k] = raw + k * row_bytes;
      several.row[k] = reinterpret_cast<T*>(raw + k * row_bytes);
    }
    std::size_t rows = 0;
    do {
      several.row[rows] = row + rows * width;
      std::memcpy(raw + rows * row_bytes, in + 1, row_bytes);
      in += 1 + row_bytes;
      ++rows;
    } while (filter == kPaeth && rows < kMost && v + rows < height && static_cast<unsigned>(*in) == kPaeth);
    switch (filter) {
      case 0: undo_none(raw, width, row); break;
      case 1: undo_sub(raw, width, row); break;
      case 2: undo_up(raw, width, up, row); break;
      case 3: undo_average(raw, width, up, row); break;
      case kPaeth: several.undo(width, up); break;
      default: return false;
    }
    v += rows;
    row += rows * width;
    up = row - width;
  }
  return true;
}

template <class T>
bool GreyPngDecoder::decode(std::span<const std::byte> bytes, const ReadLimits& limits, Image<T>& image) {
  if (!as_text(bytes).starts_with(kPngSignature)) return false;
  std::span<const std::byte> rest = bytes.subspan(kPngSignature.size());
  const std::optional<Chunk> header = take_chunk(rest);
  if (!header) return false;
  const std::optional<Size> size = size_of(*header, 8 * sizeof(T));
  if (!size || !size->fits(limits)) return false;
  const std::size_t pixels = size->width * size->height;
  const std::size_t raw_bytes = pixels * sizeof(T) + size->height;
  if (raw_bytes / kMaxDeflateFactor > bytes.size()) return false;

  std::span<const std::byte> deflated;
  deflated_.clear();
  for (;;) {
    const std::optional<Chunk> chunk = take_chunk(rest);
    if (!chunk) return false;
    if (chunk->type == "IEND" && chunk->data.empty()) break;
    if (chunk->type != "IDAT") return false;
    if (deflated.empty()) {
      deflated = chunk->data;
    } else {
      if (deflated_.empty()) {
        deflated_.reserve(bytes.size());
        deflated_.assign(deflated.begin(), deflated.end());
      }
      deflated_.insert(deflated_.end(), chunk->data.begin(), chunk->data.end());
      deflated = deflated_;
    }
  }
  image.width = static_cast<int>(size->width);
  image.height = static_cast<int>(size->height);
  image.channels = 1;
  image.pixels.resize(pixels + (size->height + sizeof(T) - 1) / sizeof(T));
  if (!inflate(deflated, std::as_writable_bytes(std::span(image.pixels)).first(raw_bytes)) || !unfilter(image)) return false;
  image.pixels.resize(pixels);
  return true;
}

template bool GreyPngDecoder::decode(std::span<const std::byte>, const ReadLimits&, Image<std::uint8_t>&);
template bool GreyPngDecoder::decode(std::span<const std::byte>, const ReadLimits&, Image<std::uint16_t>&);

}  // namespace fransac::io
