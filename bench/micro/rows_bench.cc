// SPDX-License-Identifier: Apache-2.0
// The kernels over image rows, each beside its scalar truth: a 640x480 frame of 16-bit depth, a tilted noisy plane with clutter
// and holes.
#include <benchmark/benchmark.h>

#include <vector>

#include "fransac/core/random.hpp"
#include "kernels/rows.h"

namespace {

using fransac::kernels::LabelPlane;
using fransac::kernels::Ramp;
using fransac::kernels::RowKernels;
using fransac::kernels::RowPlane;

constexpr std::size_t kWidth = 640;
constexpr std::size_t kHeight = 480;
constexpr float kUnit = 0.001F;
// z (0.8 + 0.001 v) = 1.6 m: a floor from 2 m in the first row to 1.25 m in the last.
RowPlane plane_of(std::size_t v) { return {{kUnit * (0.8F + 0.001F * static_cast<float>(v)), 0.0F}, -1.6F}; }

std::vector<std::uint16_t> make_frame() {
  fransac::RandomStream random(1, 0);
  std::vector<std::uint16_t> frame(kWidth * kHeight);
  for (std::size_t i = 0; i < frame.size(); ++i) {
    const std::size_t u = i % kWidth;
    const std::size_t v = i / kWidth;
    const bool hole = u % 160 < 24;  // in stripes, as holes are connected
    const double on_plane = 1600.0 / (0.8 + 0.001 * static_cast<double>(v)) + 5.0 * random.normal();
    const double clutter = u % 200 > 150 ? 300.0 : 0.0;
    frame[i] = hole ? std::uint16_t{0} : static_cast<std::uint16_t>(on_plane - clutter);
  }
  return frame;
}

struct Outputs {
  std::vector<std::uint16_t> kept = std::vector<std::uint16_t>(kWidth);
  std::vector<std::uint32_t> keys = std::vector<std::uint32_t>(kWidth + 1);
  std::vector<std::uint32_t> starts = std::vector<std::uint32_t>(kWidth + fransac::kernels::kBlock);
  std::vector<std::uint64_t> sums = std::vector<std::uint64_t>(kWidth + 1);
  std::vector<std::uint8_t> labels = std::vector<std::uint8_t>(kWidth);
  std::vector<float> ray_x = std::vector<float>(kWidth, 0.1F);
};

/// Calls row(v, raw, outputs) for every row of the frame.
template <class Row>
void over_frame(benchmark::State& state, const Row& row) {
  const std::vector<std::uint16_t> frame = make_frame();
  Outputs out;
  for (std::size_t u = 0; u < kWidth; ++u) out.ray_x[u] = (static_cast<float>(u) - 319.5F) / 525.0F;
  for (auto _ : state) {
    for (std::size_t v = 0; v < kHeight; ++v) row(v, frame.data() + v * kWidth, out);
    benchmark::ClobberMemory();
  }
  state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(frame.size()));
}

const RowKernels<std::uint16_t>& vector_kernels() { return fransac::kernels::row_kernels<std::uint16_t>(); }
const RowKernels<std::uint16_t>& scalar_kernels() { return fransac::kernels::ref::row_kernels<std::uint16_t>(); }

using Kernels = const RowKernels<std::uint16_t>&;

void keep_range(Kernels k, std::size_t /*v*/, const std::uint16_t* raw, Outputs& out) {
  k.keep_range(raw, kWidth, 1, 4500, out.kept.data());
}
void leaf_runs(Kernels k, std::size_t v, const std::uint16_t* raw, Outputs& out) {
  const fransac::kernels::LeafRow row{
      kUnit / 0.02F, out.ray_x.data(), (static_cast<float>(v) - 239.5F) / 525.0F, {200, 150, 1}, 9, 18};
  benchmark::DoNotOptimize(k.leaf_runs(raw, kWidth, row, out.keys.data() + 1, out.starts.data()));
}
void score(Kernels k, std::size_t v, const std::uint16_t* raw, Outputs& /*out*/) {
  benchmark::DoNotOptimize(k.score(raw, kWidth, plane_of(v)));
}
void moments(Kernels k, std::size_t v, const std::uint16_t* raw, Outputs& /*out*/) {
  benchmark::DoNotOptimize(k.moments(raw, kWidth, plane_of(v), 0.01F, Ramp{-0.6F, 1.0F / 525.0F}));
}
void label_one(Kernels k, std::size_t v, const std::uint16_t* raw, Outputs& out) {
  benchmark::DoNotOptimize(k.label_one(raw, raw, kWidth, LabelPlane{plane_of(v), 1}, 0.01F, out.labels.data()));
}
void label_three(Kernels k, std::size_t v, const std::uint16_t* raw, Outputs& out) {
  const LabelPlane planes[] = {{plane_of(v), 1}, {plane_of(v + 20), 2}, {plane_of(v + 40), 3}};
  k.label(raw, raw, kWidth, planes, 3, 0.01F, out.labels.data());
}

#define FRANSAC_ROW_BENCH(name)                                                                  \
  void vector_##name(benchmark::State& state) {                                                  \
    over_frame(state, [](auto v, auto raw, auto& out) { name(vector_kernels(), v, raw, out); }); \
  }                                                                                              \
  BENCHMARK(vector_##name)->Name(#name)->Unit(benchmark::kMicrosecond);                          \
  void scalar_##name(benchmark::State& state) {                                                  \
    over_frame(state, [](auto v, auto raw, auto& out) { name(scalar_kernels(), v, raw, out); }); \
  }                                                                                              \
  BENCHMARK(scalar_##name)->Name(#name "_ref")->Unit(benchmark::kMicrosecond)

FRANSAC_ROW_BENCH(keep_range);
FRANSAC_ROW_BENCH(leaf_runs);
FRANSAC_ROW_BENCH(score);
FRANSAC_ROW_BENCH(moments);
FRANSAC_ROW_BENCH(label_one);
FRANSAC_ROW_BENCH(label_three);

void running_sums(benchmark::State& state) {
  over_frame(state, [](auto, auto raw, auto& out) { fransac::kernels::running_sums(raw, kWidth, out.sums.data()); });
}
BENCHMARK(running_sums)->Unit(benchmark::kMicrosecond);
void running_sums_ref(benchmark::State& state) {
  over_frame(state, [](auto, auto raw, auto& out) { fransac::kernels::ref::running_sums(raw, kWidth, out.sums.data()); });
}
BENCHMARK(running_sums_ref)->Unit(benchmark::kMicrosecond);

}  // namespace
