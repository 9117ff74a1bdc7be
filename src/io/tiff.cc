// SPDX-License-Identifier: Apache-2.0
// Depth images as TIFF, by libtiff from memory.
#include <tiffio.h>

#include <algorithm>
#include <array>
#include <cstdarg>
#include <cstdio>
#include <cstring>
#include <memory>
#include <new>

#include "fransac/core/printable.hpp"
#include "io/guard.h"
#include "io/raw_depth.h"

namespace fransac::io {
namespace {

// A code of LZW, 9 bits or more, stands for 4096 bytes at most; deflate and PackBits expand by less.
constexpr std::uint64_t kMaxCompression = 4096;
// Of one allocation: a file's tags need some, however small the images that are allowed.
constexpr std::size_t kMinAllocation = std::size_t{1} << 20;

/// A file in memory, and what libtiff said of it first.
struct Memory {
  std::span<const std::byte> bytes;
  std::size_t at = 0;
  std::array<char, 256> message{};
};

Memory& memory_of(thandle_t handle) { return *static_cast<Memory*>(handle); }

tmsize_t read_memory(thandle_t handle, void* to, tmsize_t size) {
  Memory& memory = memory_of(handle);
  const std::size_t rest = memory.bytes.size() - std::min(memory.at, memory.bytes.size());
  const std::size_t count = std::min(rest, static_cast<std::size_t>(std::max<tmsize_t>(size, 0)));
  if (count > 0) std::memcpy(to, memory.bytes.data() + memory.at, count);
  memory.at += count;
  return static_cast<tmsize_t>(count);
}

tmsize_t write_nothing(thandle_t /*handle*/, void* /*from*/, tmsize_t /*size*/) { return 0; }

toff_t seek_memory(thandle_t handle, toff_t offset, int whence) {
  Memory& memory = memory_of(handle);
  const std::size_t base = whence == SEEK_CUR ? memory.at : whence == SEEK_END ? memory.bytes.size() : 0;
  memory.at = base + static_cast<std::size_t>(offset);
  return memory.at;
}

int close_nothing(thandle_t /*handle*/) { return 0; }
toff_t size_of_memory(thandle_t handle) { return memory_of(handle).bytes.size(); }

int keep_message(TIFF* /*tiff*/, void* user, const char* /*module*/, const char* form, va_list arguments) {
  Memory& memory = *static_cast<Memory*>(user);
  if (memory.message.front() == '\0') (void)std::vsnprintf(memory.message.data(), memory.message.size(), form, arguments);
  return 1;
}

int drop_message(TIFF* /*tiff*/, void* /*user*/, const char* /*module*/, const char* /*form*/, va_list /*arguments*/) {
  return 1;
}

using Tiff = std::unique_ptr<TIFF, decltype(&TIFFClose)>;

Tiff open_tiff(Memory& memory, const ReadLimits& limits) {
  const std::unique_ptr<TIFFOpenOptions, decltype(&TIFFOpenOptionsFree)> options(TIFFOpenOptionsAlloc(), &TIFFOpenOptionsFree);
  if (options == nullptr) throw std::bad_alloc();
  TIFFOpenOptionsSetMaxSingleMemAlloc(options.get(), static_cast<tmsize_t>(std::max(kMinAllocation, limits.max_decoded_bytes())));
  TIFFOpenOptionsSetErrorHandlerExtR(options.get(), &keep_message, &memory);
  TIFFOpenOptionsSetWarningHandlerExtR(options.get(), &drop_message, nullptr);
  return {TIFFClientOpenExt("memory", "rm", &memory, &read_memory, &write_nothing, &seek_memory, &close_nothing, &size_of_memory,
                            nullptr, nullptr, options.get()),
          &TIFFClose};
}

/// What a TIFF's tags say of its pixels.
struct Pixels {
  std::uint32_t width = 0;
  std::uint32_t height = 0;
  std::uint16_t bits = 1;
  std::uint16_t samples = 1;
  std::uint16_t format = SAMPLEFORMAT_UINT;
  std::uint16_t compression = COMPRESSION_NONE;
};

Pixels pixels_of(TIFF* tiff) {
  Pixels pixels;
  TIFFGetField(tiff, TIFFTAG_IMAGEWIDTH, &pixels.width);
  TIFFGetField(tiff, TIFFTAG_IMAGELENGTH, &pixels.height);
  TIFFGetFieldDefaulted(tiff, TIFFTAG_BITSPERSAMPLE, &pixels.bits);
  TIFFGetFieldDefaulted(tiff, TIFFTAG_SAMPLESPERPIXEL, &pixels.samples);
  TIFFGetFieldDefaulted(tiff, TIFFTAG_SAMPLEFORMAT, &pixels.format);
  TIFFGetFieldDefaulted(tiff, TIFFTAG_COMPRESSION, &pixels.compression);
  return pixels;
}

std::string describe(const Pixels& pixels) {
  const std::string kind = pixels.format == SAMPLEFORMAT_UINT     ? "unsigned"
                           : pixels.format == SAMPLEFORMAT_INT    ? "signed"
                           : pixels.format == SAMPLEFORMAT_IEEEFP ? "float"
                                                                  : "other";
  return "a TIFF of " + std::to_string(pixels.samples) + " " + std::to_string(pixels.bits) + "-bit " + kind +
         " value(s) a pixel, not a depth image (one, 16-bit unsigned or 32-bit float)";
}

bool is_known_compression(std::uint16_t compression) {
  constexpr std::array<std::uint16_t, 5> kKnown{COMPRESSION_NONE, COMPRESSION_LZW, COMPRESSION_ADOBE_DEFLATE, COMPRESSION_DEFLATE,
                                                COMPRESSION_PACKBITS};
  return std::find(kKnown.begin(), kKnown.end(), compression) != kKnown.end();
}

template <class T>
Status read_rows(TIFF* tiff, const Memory& memory, const Pixels& pixels, const std::string& name, Image<T>& image) {
  if (TIFFScanlineSize64(tiff) != std::uint64_t{pixels.width} * sizeof(T))
    return format_error(name, "broken TIFF: its rows' size");
  resize(image, pixels.width, pixels.height);
  for (std::uint32_t v = 0; v < pixels.height; ++v) {
    if (TIFFReadScanline(tiff, image.pixels.data() + std::size_t{v} * pixels.width, v, 0) == 1) continue;
    return format_error(name, "broken TIFF: " + printable(memory.message.data()));
  }
  return {};
}

}  // namespace

Status decode_depth_tiff(std::span<const std::byte> bytes, const std::string& name, const ReadLimits& limits, RawDepth& image) {
  Memory memory{bytes, 0, {}};
  const Tiff tiff = open_tiff(memory, limits);
  if (tiff == nullptr) return format_error(name, "broken TIFF: " + printable(memory.message.data()));
  const Pixels pixels = pixels_of(tiff.get());
  const bool units = pixels.bits == 16 && pixels.format == SAMPLEFORMAT_UINT;
  const bool metres = pixels.bits == 32 && pixels.format == SAMPLEFORMAT_IEEEFP;
  if (pixels.samples != 1 || (!units && !metres)) return format_error(name, describe(pixels));
  if (TIFFIsTiled(tiff.get()) != 0) return format_error(name, "a TIFF of tiles, which is not read: save it in strips");
  if (!is_known_compression(pixels.compression)) {
    return format_error(name, "a TIFF of compression " + std::to_string(pixels.compression) +
                                  ", which is not read: save it uncompressed, or by deflate, LZW or PackBits");
  }
  const bool plain = pixels.compression == COMPRESSION_NONE;
  const std::uint64_t raw_bytes = std::uint64_t{pixels.width} * pixels.height * (pixels.bits / 8U);
  const std::uint64_t needed = plain ? raw_bytes : raw_bytes / kMaxCompression;
  if (Status status = check_size(pixels.width, pixels.height, needed, bytes.size(), limits, name); !status) return status;
  if (units) {
    image.metres = {};
    return read_rows(tiff.get(), memory, pixels, name, image.units);
  }
  image.units = {};
  return read_rows(tiff.get(), memory, pixels, name, image.metres);
}

}  // namespace fransac::io
