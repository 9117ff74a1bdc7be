// SPDX-License-Identifier: Apache-2.0
// Pictures: any bytes are a whole image or an error, and depth and labels survive a round trip. The first byte chooses the
// reader.
#include <cstddef>
#include <cstdint>
#include <span>

#include "fransac/io/image.hpp"

namespace {

using namespace fransac;

template <class Image>
void check(const Result<Image>& image, int channels) {
  if (!image) {
    if (!image.error().message.starts_with("picture: ")) __builtin_trap();
    return;
  }
  if (image->channels != channels || image->pixels.size() != image->size() * static_cast<std::size_t>(channels)) __builtin_trap();
}

template <class Image>
void check_round_trip(const Result<Image>& image,
                      Result<Image> (*decode)(std::span<const std::byte>, const std::string&, const io::ReadLimits&)) {
  check(image, 1);
  if (!image || image->size() > 4096) return;
  const auto bytes = io::encode_png(*image);
  if (!bytes) __builtin_trap();
  const auto again = decode(*bytes, "picture", {});
  if (!again || again->pixels != image->pixels) __builtin_trap();
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size == 0) return 0;
  const auto bytes = std::as_bytes(std::span(data, size)).subspan(1);
  switch (data[0] % 4) {
    case 0: check_round_trip(io::decode_depth_png(bytes, "picture"), &io::decode_depth_png); break;
    case 1: check_round_trip(io::decode_label_png(bytes, "picture"), &io::decode_label_png); break;
    case 3: check(io::decode_object_png(bytes, "picture"), 1); break;
    default: check(io::decode_colour_image(bytes, "picture"), 3); break;
  }
  return 0;
}
