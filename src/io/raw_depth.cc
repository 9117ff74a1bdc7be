// SPDX-License-Identifier: Apache-2.0
// PGM: the Netpbm format "P5" (netpbm.sourceforge.net/doc/pgm.html). NPY: NumPy's format, versions 1 to 3
// (numpy.org/doc/stable/reference/generated/numpy.lib.format.html).
#include "io/raw_depth.h"

#include <algorithm>
#include <bit>
#include <charconv>
#include <cstring>

#include "fransac/core/printable.hpp"
#include "io/grey_png.h"
#include "io/guard.h"
#include "io/text.h"

namespace fransac::io {
namespace {

using namespace std::string_view_literals;

constexpr std::string_view kNpySignature = "\x93NUMPY";

bool is_blank(char c) { return c == ' ' || (c >= '\t' && c <= '\r'); }

/// The whole number at the start of `text`, which is cut off.
std::optional<std::uint32_t> take_number(std::string_view& text) {
  std::uint32_t number = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (error != std::errc()) return std::nullopt;
  text.remove_prefix(static_cast<std::size_t>(end - text.data()));
  return number;
}

/// Values of type Stored, in the machine's order of bytes or the other one, as values of type T.
template <class Stored, class T>
void read_values(std::span<const std::byte> bytes, std::endian order, std::vector<T>& values) {
  for (std::size_t i = 0; i < values.size(); ++i) {
    std::array<std::byte, sizeof(Stored)> one{};
    std::copy_n(bytes.begin() + static_cast<std::ptrdiff_t>(i * sizeof(Stored)), sizeof(Stored), one.begin());
    if (order != std::endian::native) std::reverse(one.begin(), one.end());
    values[i] = static_cast<T>(std::bit_cast<Stored>(one));
  }
}

/// Blanks and comments between the words of a PGM's header; at least one of them must be there.
bool skip_blanks(std::string_view& text) {
  const std::size_t before = text.size();
  while (!text.empty() && (is_blank(text.front()) || text.front() == '#')) {
    text.remove_prefix(text.front() == '#' ? std::min(text.find('\n'), text.size()) : 1);
  }
  return text.size() < before;
}

/// What an NPY's header says.
struct NpyHeader {
  std::string_view type;   ///< Order of bytes, kind and size: "<u2".
  std::string_view order;  ///< "False", or "True" for column by column.
  std::vector<std::uint32_t> shape;
};

/// The text between a key of the header's dictionary and the mark that ends its value.
std::string_view value_of(std::string_view dictionary, std::string_view key, std::string_view ends) {
  const std::size_t at = dictionary.find(key);
  if (at == std::string_view::npos) return {};
  std::string_view value = dictionary.substr(at + key.size());
  value.remove_prefix(std::min(value.find_first_not_of(" :"), value.size()));
  return value.substr(0, value.find_first_of(ends));
}

std::optional<NpyHeader> parse_npy_header(std::string_view dictionary) {
  NpyHeader header;
  header.type = value_of(dictionary, "'descr'", ",}");
  if (header.type.size() < 3 || header.type.front() != '\'' || header.type.back() != '\'') return std::nullopt;
  header.type = header.type.substr(1, header.type.size() - 2);
  header.order = value_of(dictionary, "'fortran_order'", ",} ");
  std::string_view shape = value_of(dictionary, "'shape'", ")");
  if (!shape.starts_with('(')) return std::nullopt;
  shape.remove_prefix(1);
  while (true) {
    shape.remove_prefix(std::min(shape.find_first_not_of(" ,"), shape.size()));
    if (shape.empty()) return header;
    const auto number = take_number(shape);
    if (!number || header.shape.size() == 8) return std::nullopt;
    header.shape.push_back(*number);
  }
}

std::size_t little_endian(std::string_view bytes) {
  std::size_t value = 0;
  for (auto byte = bytes.rbegin(); byte != bytes.rend(); ++byte) value = value << 8U | static_cast<unsigned char>(*byte);
  return value;
}

}  // namespace

std::optional<DepthFileFormat> depth_format_of(std::string_view head) {
  if (head.starts_with(kPngSignature)) return DepthFileFormat::png;
  if (head.starts_with(kNpySignature)) return DepthFileFormat::npy;
  for (const std::string_view start : {"II*\0"sv, "MM\0*"sv, "II+\0"sv, "MM\0+"sv}) {
    if (head.starts_with(start)) return DepthFileFormat::tiff;
  }
  const bool is_pgm = head.size() > 2 && (head.starts_with("P5") || head.starts_with("P2")) && is_blank(head[2]);
  return is_pgm ? std::optional(DepthFileFormat::pgm) : std::nullopt;
}

Status check_size(std::uint64_t width, std::uint64_t height, std::uint64_t needed_bytes, std::size_t file_bytes,
                  const ReadLimits& limits, const std::string& name) {
  const std::string size = std::to_string(width) + "x" + std::to_string(height) + " pixels";
  if (width < 1 || height < 1 || width > kMaxImageSide || height > kMaxImageSide) {
    return format_error(name, size + ": larger than any accepted picture");
  }
  if (width * height > limits.max_size) {
    return format_error(name, size + ": more than the limit of " + std::to_string(limits.max_size) + " (--max-size)");
  }
  if (needed_bytes > file_bytes) return format_error(name, "too short for its " + size);
  return {};
}

Status decode_depth_pgm(std::span<const std::byte> bytes, const std::string& name, const ReadLimits& limits, RawDepth& image) {
  std::string_view text = as_text(bytes);
  if (text.starts_with("P2")) return format_error(name, "a PGM of text (P2), not a depth image (16-bit, P5)");
  text.remove_prefix(2);
  std::array<std::uint32_t, 3> header{};  // width, height, largest value
  for (std::uint32_t& number : header) {
    const bool apart = skip_blanks(text);
    const auto read = apart ? take_number(text) : std::nullopt;
    if (!read) return format_error(name, "broken PGM: its header is not \"P5 WIDTH HEIGHT MAXIMUM\"");
    number = *read;
  }
  const auto [width, height, maximum] = header;
  if (maximum < 256 || maximum > 65535) {
    return format_error(name, "a PGM of values up to " + std::to_string(maximum) + ", not a depth image (16-bit: up to 65535)");
  }
  if (text.empty() || !is_blank(text.front())) return format_error(name, "broken PGM: no blank after its header");
  text.remove_prefix(1);
  const std::uint64_t needed = std::uint64_t{2} * width * height;
  if (Status status = check_size(width, height, needed, text.size(), limits, name); !status) return status;
  if (text.size() != needed) return format_error(name, "broken PGM: has bytes after its pixels");
  resize(image.units, width, height);
  image.metres = {};
  read_values<std::uint16_t>(std::as_bytes(std::span(text)), std::endian::big, image.units.pixels);
  return {};
}

Status decode_depth_npy(std::span<const std::byte> bytes, const std::string& name, const ReadLimits& limits, RawDepth& image) {
  const std::string_view text = as_text(bytes);
  constexpr std::size_t kVersionAt = kNpySignature.size();
  constexpr std::size_t kLengthAt = kVersionAt + 2;
  const std::size_t length_bytes = text.size() > kVersionAt && text[kVersionAt] == 1 ? 2 : 4;
  const std::size_t header_at = kLengthAt + length_bytes;
  if (text.size() < header_at) return format_error(name, "broken NPY: cut off within its header");
  if (text[kVersionAt] < 1 || text[kVersionAt] > 3) return format_error(name, "an NPY of unknown version");
  const std::size_t length = little_endian(text.substr(kLengthAt, length_bytes));
  if (length > text.size() - header_at) return format_error(name, "broken NPY: cut off within its header");
  const std::optional<NpyHeader> header = parse_npy_header(text.substr(header_at, length));
  if (!header) return format_error(name, "broken NPY: its header has no descr, fortran_order and shape as NumPy writes them");
  if (header->shape.size() != 2) {
    return format_error(name, "an array of " + std::to_string(header->shape.size()) + " dimensions, not a depth image (2)");
  }
  if (header->order != "False") return format_error(name, "an array that is not in C order");
  const bool big = header->type.starts_with('>');
  const std::string_view type = header->type.substr(1);
  const bool known = (big || header->type.starts_with('<')) && (type == "u2" || type == "f4" || type == "f8");
  if (!known)
    return format_error(name, "an array of " + quoted_text(header->type) + ", not a depth image (uint16, float32 or float64)");
  const std::uint64_t height = header->shape[0];
  const std::uint64_t width = header->shape[1];
  const std::span<const std::byte> data = bytes.subspan(header_at + length);
  // What is larger than any picture is refused by its sides, whatever the product.
  const bool fits = width <= kMaxImageSide && height <= kMaxImageSide;
  const std::uint64_t needed = fits ? width * height * static_cast<std::uint64_t>(type[1] - '0') : 0;
  if (Status status = check_size(width, height, needed, data.size(), limits, name); !status) return status;
  if (data.size() != needed) return format_error(name, "broken NPY: has bytes after its values");
  const std::endian order = big ? std::endian::big : std::endian::little;
  if (type == "u2") {
    resize(image.units, width, height);
    image.metres = {};
    read_values<std::uint16_t>(data, order, image.units.pixels);
    return {};
  }
  image.units = {};
  resize(image.metres, width, height);
  type == "f4" ? read_values<float>(data, order, image.metres.pixels) : read_values<double>(data, order, image.metres.pixels);
  return {};
}

}  // namespace fransac::io
