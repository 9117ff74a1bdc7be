// SPDX-License-Identifier: Apache-2.0
// Decoding a depth PNG of 640x480 pixels, a tilted noisy plane with holes, all of whose rows have the same filter; `_ref`: by
// libspng. The memory is kept, as for a sequence of frames.
#include <benchmark/benchmark.h>
#include <spng.h>

#include <cstdlib>
#include <span>
#include <vector>

#include "fransac/core/random.hpp"
#include "io/grey_png.h"

namespace {

using namespace fransac;

constexpr std::size_t kWidth = 640;
constexpr std::size_t kHeight = 480;

std::vector<std::uint16_t> make_frame() {
  RandomStream random(1, 0);
  std::vector<std::uint16_t> frame(kWidth * kHeight);
  for (std::size_t i = 0; i < frame.size(); ++i) {
    const double on_plane = 8000.0 / (0.8 + 0.001 * static_cast<double>(i / kWidth)) + 5.0 * random.normal();
    frame[i] = i % kWidth % 160 < 24 ? std::uint16_t{0} : static_cast<std::uint16_t>(on_plane);
  }
  return frame;
}

std::vector<std::byte> make_png(spng_filter_choice filter) {
  const std::vector<std::uint16_t> frame = make_frame();
  spng_ctx* const context = spng_ctx_new(SPNG_CTX_ENCODER);
  spng_ihdr header{kWidth, kHeight, 16, SPNG_COLOR_TYPE_GRAYSCALE, 0, 0, 0};
  spng_set_ihdr(context, &header);
  spng_set_option(context, SPNG_FILTER_CHOICE, filter);
  spng_set_option(context, SPNG_ENCODE_TO_BUFFER, 1);
  spng_encode_image(context, frame.data(), 2 * frame.size(), SPNG_FMT_PNG, SPNG_ENCODE_FINALIZE);
  std::size_t size = 0;
  int error = 0;
  auto* const buffer = static_cast<std::byte*>(spng_get_png_buffer(context, &size, &error));
  std::vector<std::byte> bytes(buffer, buffer + size);
  std::free(buffer);
  spng_ctx_free(context);
  return bytes;
}

void decode(benchmark::State& state, spng_filter_choice filter) {
  const std::vector<std::byte> png = make_png(filter);
  io::GreyPngDecoder decoder;
  io::DepthImage image;
  for (auto _ : state) {
    if (!decoder.decode(png, {}, image)) return state.SkipWithError("left to libspng");
    benchmark::ClobberMemory();
  }
  if (image.pixels != make_frame()) state.SkipWithError("wrong pixels");
}

void decode_ref(benchmark::State& state, spng_filter_choice filter) {
  const std::vector<std::byte> png = make_png(filter);
  for (auto _ : state) {
    if (!io::decode_grey_by_spng<std::uint16_t>(png, "frame", {}, "depth")) return state.SkipWithError("not decoded");
    benchmark::ClobberMemory();
  }
}

#define FRANSAC_PNG_BENCH(name, filter)                                                       \
  BENCHMARK_CAPTURE(decode, name, filter)->Name("png_" #name)->Unit(benchmark::kMicrosecond); \
  BENCHMARK_CAPTURE(decode_ref, name, filter)->Name("png_" #name "_ref")->Unit(benchmark::kMicrosecond)

FRANSAC_PNG_BENCH(none, SPNG_FILTER_CHOICE_NONE);
FRANSAC_PNG_BENCH(sub, SPNG_FILTER_CHOICE_SUB);
FRANSAC_PNG_BENCH(up, SPNG_FILTER_CHOICE_UP);
FRANSAC_PNG_BENCH(average, SPNG_FILTER_CHOICE_AVG);
FRANSAC_PNG_BENCH(paeth, SPNG_FILTER_CHOICE_PAETH);

}  // namespace
