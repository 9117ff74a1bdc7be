// SPDX-License-Identifier: Apache-2.0
// The kernels over rows of cells, each beside its scalar truth: a 640x480 frame of 16-bit depth, a tilted noisy plane with
// clutter, complete and with holes.
#include <benchmark/benchmark.h>

#include <algorithm>
#include <iterator>
#include <string>
#include <vector>

#include "fransac/core/random.hpp"
#include "kernels/cells.h"

namespace {

using fransac::kernels::CellKernels;
using fransac::kernels::CellMoments;
using fransac::kernels::CellPlane;
using fransac::kernels::CellRows;
using fransac::kernels::CellRunEvidence;
using fransac::kernels::CellTolerance;
using fransac::kernels::kCell;

constexpr std::size_t kWidth = 640;
constexpr std::size_t kHeight = 480;
constexpr std::size_t kAcross = kWidth / kCell;
constexpr std::size_t kDown = kHeight / kCell;
constexpr float kUnit = 0.001F;
// Inverse depth (0.8 + 0.001 v) / 1.6 m: a floor from 2 m in the first row to 1.25 m in the last.
constexpr float kBase = 0.5F;
constexpr float kSlope = 0.001F / 1.6F;

std::vector<std::uint16_t> make_frame(bool holes) {
  fransac::RandomStream random(1, 0);
  std::vector<std::uint16_t> frame(kWidth * kHeight);
  for (std::size_t i = 0; i < frame.size(); ++i) {
    const std::size_t u = i % kWidth;
    const double v = static_cast<double>(i / kWidth);  // NOLINT: whole
    const bool hole = holes && u % 160 < 28;           // in stripes, as holes are connected; one cell in 20 is partly one
    const double on_plane = 1.0 / (static_cast<double>(kBase) + static_cast<double>(kSlope) * v);
    const double clutter = u % 200 > 150 ? 0.3 : 0.0;
    frame[i] = hole ? std::uint16_t{0} : static_cast<std::uint16_t>(1000.0 * (on_plane - clutter) + 2.0 * random.normal());
  }
  return frame;
}

struct Outputs {
  Outputs() : fields(10, std::vector<float>(kAcross)), labels(kHeight * kWidth), counts(9, std::vector<std::uint8_t>(kAcross)) {
    for (std::size_t p = 0; p < counts.size(); ++p) evidence.push_back({counts[p].data(), 0.0F});
    std::fill_n(std::back_inserter(per_cell), kAcross, 2e-3F);
  }
  CellMoments moments() {
    return {fields[0].data(), fields[1].data(), fields[2].data(), fields[3].data(), fields[4].data(),
            fields[5].data(), fields[6].data(), fields[7].data(), fields[8].data(), fields[9].data()};
  }
  [[nodiscard]] CellTolerance tolerance() const { return {per_cell.data(), 0.005F}; }
  std::vector<std::vector<float>> fields;
  std::vector<std::uint8_t> labels;
  std::vector<std::vector<std::uint8_t>> counts;
  std::vector<CellRunEvidence> evidence;
  std::vector<float> per_cell;
};

struct RowOfCells {
  CellRows<std::uint16_t> raw;
  std::uint8_t* labels[kCell];
  float first_row;
};

/// Calls row(row_of_cells, outputs) for every row of cells of the frame.
template <class Row>
void over_frame(benchmark::State& state, bool holes, const Row& row) {
  const std::vector<std::uint16_t> frame = make_frame(holes);
  Outputs out;
  for (auto _ : state) {
    for (std::size_t y = 0; y < kDown; ++y) {
      RowOfCells cells{};
      cells.first_row = static_cast<float>(y * kCell);
      for (std::size_t v = 0; v < kCell; ++v) {
        cells.raw.rows[v] = frame.data() + (y * kCell + v) * kWidth;
        cells.labels[v] = out.labels.data() + (y * kCell + v) * kWidth;
      }
      row(cells, out);
    }
    benchmark::ClobberMemory();
  }
  state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(frame.size()));
}

using Kernels = const CellKernels<std::uint16_t>&;

void cell_moments(Kernels k, const RowOfCells& cells, Outputs& out) {
  k.moments(cells.raw, kAcross, kUnit, 32.0F, out.moments());
}
/// In runs of ten cells.
template <std::size_t kPlanes>
void cell_label(Kernels k, const RowOfCells& cells, Outputs& out) {
  CellPlane planes[kPlanes];
  for (std::size_t p = 0; p < kPlanes; ++p) {
    const float base = kBase + kSlope * (cells.first_row + 20.0F * static_cast<float>(p));
    planes[p] = {base, 0.0F, kSlope, static_cast<std::uint8_t>(1 + p)};
  }
  for (std::size_t first = 0; first < kAcross; first += 10) {
    k.label(cells.raw, first, 10, kUnit, planes, kPlanes, out.tolerance(), cells.labels, out.evidence.data());
  }
}
void cell_label_none(Kernels k, const RowOfCells& cells, Outputs& /*out*/) { k.label_none(cells.raw, 0, kAcross, cells.labels); }
void cell_fits(Kernels k, const RowOfCells& cells, Outputs& out) {
  const CellPlane plane{kBase + kSlope * cells.first_row, 0.0F, kSlope, 1};
  for (std::size_t c = 0; c < kAcross; ++c) benchmark::DoNotOptimize(k.fits(cells.raw, c, kUnit, plane, out.tolerance()));
}

using Kernel = void (*)(Kernels, const RowOfCells&, Outputs&);

void add(const char* name, Kernel kernel) {
  const auto with = [=](Kernels kernels, bool holes) {
    return [=, &kernels](benchmark::State& state) {
      over_frame(state, holes, [&](const RowOfCells& cells, Outputs& out) { kernel(kernels, cells, out); });
    };
  };
  const std::string base = name;
  using fransac::kernels::cell_kernels;
  const auto register_one = [](const std::string& full, const auto& run) {
    benchmark::RegisterBenchmark(full.c_str(), run)->Unit(benchmark::kMicrosecond);
  };
  register_one(base, with(cell_kernels<std::uint16_t>(kCell), false));
  register_one(base + "_holes", with(cell_kernels<std::uint16_t>(kCell), true));
  register_one(base + "_ref", with(fransac::kernels::ref::cell_kernels<std::uint16_t>(kCell), false));
}

[[maybe_unused]] const bool kAdded = [] {
  add("cell_moments", cell_moments);
  add("cell_label_one", cell_label<1>);
  add("cell_label_two", cell_label<2>);
  add("cell_label_three", cell_label<3>);
  add("cell_label_none", cell_label_none);
  add("cell_fits", cell_fits);
  return true;
}();

}  // namespace
