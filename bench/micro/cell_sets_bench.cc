// SPDX-License-Identifier: Apache-2.0
// The kernels over sets of cells, each beside its scalar truth: 80 x 60 cells, those of a 640x480 frame, on a noisy plane with a
// stripe of clutter.
#include <benchmark/benchmark.h>

#include <algorithm>
#include <string>
#include <vector>

#include "fransac/core/random.hpp"
#include "kernels/cell_sets.h"
#include "kernels/cells.h"

namespace {

namespace kernels = fransac::kernels;
using kernels::CellArrays;
using kernels::CellSetPlane;
using kernels::kCell;

constexpr std::size_t kAcross = 80;
constexpr std::size_t kDown = 60;
constexpr std::size_t kStride = kAcross + 2;
constexpr std::size_t kWords = kernels::words_of(kAcross);
constexpr std::size_t kRoom = 64;  // behind the last cell, for whole vectors
constexpr CellSetPlane kPlane{0.0F, 0.0F, 0.5F, 1e-4F, 6e-4F};
constexpr float kNoise = 2e-3F;  // per metre, of inverse depth

/// Cells as planes/cells/grid.hpp keeps them, with a border of one cell.
struct Cells {
  Cells() {
    constexpr std::size_t kSize = kStride * (kDown + 2) + kRoom;
    fransac::RandomStream random(1, 0);
    const auto noise = [&] { return kNoise * static_cast<float>(random.normal()); };
    for (std::size_t i = 0; i < kSize; ++i) {
      const std::size_t column = i % kStride;
      const float u = static_cast<float>(column * kCell);
      const float v = static_cast<float>(i / kStride * kCell);
      const float clutter = column % 25 > 18 ? 0.1F : 0.0F;
      const float q = kPlane.q0 + kPlane.du * u + kPlane.dv * v + clutter + noise();
      const float values[] = {
          64.0F, u, v, q, 5.25F, 0.0F, 5.25F, kPlane.du + noise() / kCell, kPlane.dv + noise() / kCell, kNoise * kNoise};
      for (std::size_t k = 0; k < fields.size(); ++k) fields[k].push_back(values[k]);
      shape.push_back(1.0F);
      slack.push_back(9.0F * kNoise * kNoise);
      weight.push_back(random.below(20) == 0 ? 0.0F : 1.0F);
      count.push_back(static_cast<std::uint8_t>(random.below(65)));
    }
    // The set that most sums are made of: the plane without its clutter.
    set.resize(kWords * kDown);
    for (std::size_t row = 0; row < kDown; ++row) {
      kernels::ref::find_on_plane(arrays(row), &slack[at(row)], kAcross, kPlane, &set[row * kWords]);
    }
    found = set;
    out.resize(kSize);
    nearest.resize(kSize);
  }
  static std::size_t at(std::size_t row) { return (row + 1) * kStride + 1; }
  [[nodiscard]] CellArrays arrays(std::size_t row) const {
    const std::size_t i = at(row);
    return {&fields[0][i],
            &fields[1][i],
            &fields[2][i],
            &fields[3][i],
            &fields[4][i],
            &fields[5][i],
            &fields[6][i],
            &fields[7][i],
            &fields[8][i],
            &fields[9][i],
            static_cast<std::ptrdiff_t>(kStride)};
  }
  std::vector<std::vector<float>> fields{10};
  std::vector<float> shape, slack, weight, out;
  std::vector<std::uint8_t> count;
  std::vector<std::uint64_t> set, found;
  std::vector<std::int32_t> nearest;
};

/// Registers a run over all rows, run(kernel, cells, row), with the kernel and with its truth.
template <class Kernel, class Row>
void add_rows(const std::string& name, Kernel kernel, Kernel truth, Row row) {
  const auto with = [=](Kernel one) {
    return [=](benchmark::State& state) {
      Cells cells;
      for (auto _ : state) {
        for (std::size_t r = 0; r < kDown; ++r) row(one, cells, r);
        benchmark::ClobberMemory();
      }
      state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(kAcross * kDown));
    };
  };
  benchmark::RegisterBenchmark(name.c_str(), with(kernel))->Unit(benchmark::kMicrosecond);
  benchmark::RegisterBenchmark((name + "_ref").c_str(), with(truth))->Unit(benchmark::kMicrosecond);
}

/// The same for one call for all rows, run(kernel, cells).
template <class Kernel, class Whole>
void add_whole(const std::string& name, Kernel kernel, Kernel truth, Whole whole) {
  add_rows(name, kernel, truth, [=](Kernel one, Cells& cells, std::size_t row) {
    if (row == 0) whole(one, cells);
  });
}

[[maybe_unused]] const bool kAdded = [] {
  namespace ref = kernels::ref;
  add_rows("find_on_plane", &kernels::find_on_plane, &ref::find_on_plane, [](auto kernel, Cells& c, std::size_t row) {
    kernel(c.arrays(row), &c.slack[Cells::at(row)], kAcross, kPlane, &c.found[row * kWords]);
  });
  constexpr float kSquared = kNoise * kNoise;
  constexpr kernels::CellLinkLimits kLimits{9.0F * kSquared, 1e-4F, 0.5F * kCell, 0.5F * kCell, 9.0F * kSquared, 1e-4F, 0.0F};
  add_rows("find_links", &kernels::find_links, &ref::find_links, [=](auto kernel, Cells& c, std::size_t row) {
    kernel(c.arrays(row), &c.shape[Cells::at(row)], kAcross, 1, kLimits, &c.found[row * kWords]);
    kernel(c.arrays(row), &c.shape[Cells::at(row)], kAcross, kStride, kLimits, &c.found[row * kWords]);
  });
  add_whole("sum_cells", &kernels::sum_cells, &ref::sum_cells,
            [](auto kernel, Cells& c) { benchmark::DoNotOptimize(kernel(c.arrays(0), c.set.data(), kDown, kWords, kPlane)); });
  add_whole("sum_shape", &kernels::sum_shape, &ref::sum_shape,
            [](auto kernel, Cells& c) { benchmark::DoNotOptimize(kernel(c.arrays(0), c.set.data(), kDown, kWords, kPlane)); });
  add_rows("find_nearest", &kernels::find_nearest, &ref::find_nearest, [](auto kernel, Cells& c, std::size_t row) {
    const std::size_t i = Cells::at(row);
    std::fill_n(&c.out[i], kAcross, 1.0F);  // as if no plane had been offered yet
    kernel(c.arrays(row), &c.slack[i], kAcross, kPlane, &c.set[row * kWords], 1, &c.out[i], &c.nearest[i]);
  });
  add_rows("measure_differences", &kernels::measure_differences, &ref::measure_differences,
           [](auto kernel, Cells& c, std::size_t row) {
             const std::size_t i = Cells::at(row);
             kernel(&c.fields[0][i], &c.fields[3][i], &c.shape[i], kAcross, kStride, 60.0F, &c.out[i]);
           });
  add_rows("measure_blocks", &kernels::measure_blocks, &ref::measure_blocks, [](auto kernel, Cells& c, std::size_t row) {
    const std::size_t i = Cells::at(row);
    kernel(c.arrays(row), &c.weight[i], &c.shape[i], kAcross, {3, 3, 1, 1, 7}, 9.0F * kSquared, 1e-4F, &c.out[i]);
  });
  add_rows("sum_pixels", &kernels::sum_pixels, &ref::sum_pixels, [](auto kernel, Cells& c, std::size_t row) {
    const std::size_t i = Cells::at(row);
    benchmark::DoNotOptimize(kernel(&c.count[i], &c.fields[3][i], kAcross, kPlane.q0, kPlane.du, 0.05F));
  });
  return true;
}();

}  // namespace
