// SPDX-License-Identifier: Apache-2.0
#include "planes/cells/grid.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <numeric>

#include "fransac/core/parallel.hpp"
#include "planes/cells/constants.hpp"

namespace fransac::cells {
namespace {

constexpr const Constants& kC = kConstants;
using kernels::kCell;

void resize(int width, int height, Grid& grid) {
  grid.width = width;
  grid.height = height;
  grid.columns = (width + kCell - 1) / kCell;
  grid.rows = (height + kCell - 1) / kCell;
  grid.stride = grid.columns + 2;
  const std::size_t size = at(grid.stride) * at(grid.rows + 2);
  for (auto* values : {&grid.n, &grid.u, &grid.v, &grid.q, &grid.uu, &grid.uv, &grid.vv, &grid.du, &grid.dv, &grid.residual,
                       &grid.shape, &grid.slack}) {
    values->resize(size + Grid::kPadding);
    std::fill_n(values->begin() + static_cast<std::ptrdiff_t>(size), Grid::kPadding, 0.0F);
  }
  grid.usable.resize(size);
  grid.words = kernels::words_of(at(grid.columns));
  for (auto* set : {&grid.usable_set, &grid.links.right, &grid.links.down, &grid.smooth.right, &grid.smooth.down})
    set->resize(at(grid.rows) * grid.words);
}

/// Makes the cells around the image ones without measurements.
void clear_border(Grid& grid) {
  const auto clear = [&](int i) {
    for (auto* values : {&grid.n, &grid.u, &grid.v, &grid.q, &grid.uu, &grid.uv, &grid.vv, &grid.du, &grid.dv})
      (*values)[at(i)] = 0.0F;
    grid.residual[at(i)] = kernels::kNoFit;
  };
  for (int c = 0; c < grid.stride; ++c) {
    clear(c);
    clear((grid.rows + 1) * grid.stride + c);
  }
  for (int r = 1; r <= grid.rows; ++r) {
    clear(r * grid.stride);
    clear(r * grid.stride + grid.columns + 1);
  }
}

/// Returns how many pixels were measured.
template <class Raw>
std::size_t measure_row(const ImageRows<Raw>& image, int row, float metres_per_unit, Grid& grid) {
  const int first = grid.index(row, 0);
  const auto from = [&](AlignedVector<float>& values) { return values.data() + first; };
  const kernels::CellMoments out{from(grid.n),  from(grid.u),  from(grid.v),  from(grid.q),  from(grid.uu),
                                 from(grid.uv), from(grid.vv), from(grid.du), from(grid.dv), from(grid.residual)};
  const auto cells = static_cast<std::size_t>(grid.columns);
  const std::size_t measured =
      kernels::cell_kernels<Raw>().moments(image.cells(row), cells, metres_per_unit, static_cast<float>(kC.least_measured), out);
  // From the cell's centre to the image's.
  const float half = 0.5F * (kCell - 1);
  const float base_v = static_cast<float>(row * kCell) + half - 0.5F * static_cast<float>(grid.height);
  const float base_u = half - 0.5F * static_cast<float>(grid.width);
  for (std::size_t c = 0; c < cells; ++c) {
    out.u[c] += base_u + static_cast<float>(c) * kCell;
    out.v[c] += base_v;
  }
  return measured;
}

/// The value below which a share of a sample lies; 0 without one. Values are not negative.
float quantile(const AlignedVector<float>& sample, double share) {
  // The bits of floats are in the order of their values: counted by the leading ones, steps of an eighth, and between evenly.
  constexpr int kDropped = 20;
  const auto leading = [](float value) { return std::bit_cast<std::uint32_t>(value) >> kDropped; };
  std::array<std::uint32_t, std::size_t{1} << (32 - kDropped - 1)> counts{};
  auto others = counts;  // neighbours are often alike, and one counter would wait for itself
  const std::size_t even = sample.size() / 2 * 2;
  for (std::size_t i = 0; i < even; i += 2) {
    ++counts[leading(sample[i])];
    ++others[leading(sample[i + 1])];
  }
  if (even < sample.size()) ++counts[leading(sample[even])];
  for (std::size_t bin = 0; bin < counts.size(); ++bin) counts[bin] += others[bin];
  const std::uint32_t none = leading(kernels::kNone);
  const auto size = std::accumulate(counts.begin(), counts.begin() + none, std::uint32_t{0});
  if (size == 0) return 0.0F;
  double rank = share * static_cast<double>(size - 1);
  std::uint32_t bin = 0;
  for (; rank >= static_cast<double>(counts[bin]); ++bin) rank -= static_cast<double>(counts[bin]);
  const float low = std::bit_cast<float>(bin << kDropped);
  const float high = std::bit_cast<float>((bin + 1) << kDropped);
  return low + (high - low) * static_cast<float>((rank + 0.5) / static_cast<double>(counts[bin]));
}

/// Calls visit(first cell) for rows that a sample is taken from: all, or of large images every so many, some thousands of cells.
template <class Visitor>
void for_each_sampled_row(const Grid& grid, Visitor visit) {
  constexpr int kEnough = 4800;
  const int step = std::max(1, grid.columns * grid.rows / kEnough);
  for (int r = 0; r < grid.rows; r += step) visit(grid.index(r, 0));
}

constexpr float kFull = kCell * kCell - 4;  // a few pixels may be missing

/// One sigma of `values` against the mean of a cell's two neighbours, in its row and in its column, from the 30 % quantile; a
/// plane has none.
double second_difference(const Grid& grid, const AlignedVector<float>& values, AlignedVector<float>& sample) {
  sample.clear();
  for_each_sampled_row(grid, [&](int first) {
    for (const int step : {1, grid.stride}) {
      const std::size_t size = sample.size();
      sample.resize(size + at(grid.columns));
      kernels::measure_differences(&grid.n[at(first)], &values[at(first)], &grid.shape[at(first)], at(grid.columns), step, kFull,
                                   &sample[size]);
    }
  });
  // |x| of a normal x with sigma 1 is below 0.3853 in 30 % of all cases; the difference of three values has variance 1.5.
  constexpr double kToSigma = 1.0 / (0.3853 * 1.2247);
  return kToSigma * static_cast<double>(quantile(sample, kC.noise_quantile));
}

constexpr double kLeastSigma = 1e-3 * kKinectNoise_per_m;  // floats of rendered depth

/// Sets the shape of the noise over depth that the sensor is known for, 1 on average; returns what 1 stands for, per metre.
double set_shape(const SensorModel& sensor, Grid& grid) {
  if (sensor.kind == SensorKind::automatic) {
    std::fill(grid.shape.begin(), grid.shape.end(), 1.0F);
    return kKinectNoise_per_m;
  }
  double sum = 0.0;
  double cells = 0.0;
  for (std::size_t i = 0; i < grid.size(); ++i) {
    const auto q = static_cast<double>(grid.q[i]);
    const double sigma = q > 0.0 ? std::max(sensor.noise.sigma_m(1.0 / q) * q * q, kLeastSigma) : kLeastSigma;
    grid.shape[i] = static_cast<float>(sigma);
    if (!(q > 0.0)) continue;
    sum += sigma;
    cells += 1.0;
  }
  const double unit = cells > 0.0 ? sum / cells : kLeastSigma;
  for (float& shape : grid.shape) shape /= static_cast<float>(unit);
  return unit;
}

/// The noise of an unknown sensor is whatever the frame shows, within what depth cameras do; of a known one it is near the
/// model's.
Noise estimate_noise(const SensorModel& sensor, double unit, GridBuffers& buffers, const Grid& grid) {
  AlignedVector<float>& sample = buffers.sample;
  sample.clear();
  for_each_sampled_row(grid, [&](int first) {
    for (std::size_t i = at(first); i < at(first + grid.columns); ++i) {
      const float scaled = grid.residual[i] / (grid.shape[i] * grid.shape[i]);
      sample.push_back(grid.n[i] >= kFull ? scaled : kernels::kNone);
    }
  });
  const bool known = sensor.kind != SensorKind::automatic;
  Noise noise;
  noise.pixel = std::clamp(kC.noise_gain * std::sqrt(static_cast<double>(quantile(sample, kC.noise_quantile))),
                           known ? 0.25 * unit : kLeastSigma, (known ? 2.0 : 4.0) * unit);
  noise.of_model = noise.pixel / unit;
  const double mean = second_difference(grid, grid.q, sample);
  const double slope = static_cast<double>(Grid::kHalfCell) *
                       std::max(second_difference(grid, grid.du, sample), second_difference(grid, grid.dv, sample));
  // Errors that are the same in all rows of a cell, as those of rounding are on a wall, leave 1 / sqrt(8) of the pixel's.
  constexpr double kShared = 0.3536;
  noise.shown = std::min(std::max(mean, slope), 3.0 * unit);
  noise.cell = std::max(noise.shown, kShared * noise.pixel);
  noise.slow = kC.slow_noise * noise.cell;
  noise.bias_scale = known ? sensor.bias_m / kC.bias_m : std::clamp(noise.cell / kKinectNoise_per_m, kC.least_bias_scale, 1.0);
  return noise;
}

/// Multiplies the shape by how much noisier than the frame the flattest cell nearby is.
void add_local_noise(GridBuffers& buffers, Grid& grid) {
  AlignedVector<float>& least_residual = buffers.least_residual;
  least_residual.resize(grid.size());
  const auto lesser = [](float a, float b) { return a < b ? a : b; };  // std::min's references keep loops scalar
  const auto stride = at(grid.stride);
  const std::size_t size = grid.size();
  const float* const __restrict residual = grid.residual.data();
  float* const __restrict least = least_residual.data();
  for (std::size_t i = stride; i < size - stride; ++i) {
    least[i] = lesser(lesser(residual[i - stride], residual[i]), residual[i + stride]);
  }
  const auto scale = static_cast<float>(kC.noise_gain / grid.noise.pixel);
  const auto most = static_cast<float>(kC.local_noise);
  float* const __restrict shape = grid.shape.data();
  for (std::size_t i = stride + 1; i < size - stride - 1; ++i) {
    const float near = scale * std::sqrt(lesser(lesser(least[i - 1], least[i]), least[i + 1]));
    const float bounded = lesser(near, most * shape[i]);
    shape[i] = bounded > shape[i] ? bounded : shape[i];
  }
}

void find_usable(Grid& grid) {
  const auto square = [](double x) { return static_cast<float>(x * x); };
  const float usable_noise = square(kC.usable_k * grid.noise.pixel);
  const float usable_length = square(kC.usable_m * grid.noise.bias_scale) + square(kC.flat_in_cell_m);
  const float grow_noise = square(kC.grow_k * grid.noise.cell);
  const float grow_length = square(kC.bias_m * grid.noise.bias_scale) + square(kC.flat_m);
  const auto pixel = static_cast<float>(grid.noise.pixel);
  const auto most = static_cast<float>(kC.most_sigma_m);
  const float* const __restrict n = grid.n.data();
  const float* const __restrict q = grid.q.data();
  const float* const __restrict shape = grid.shape.data();
  const float* const __restrict residual = grid.residual.data();
  float* const __restrict slack = grid.slack.data();
  std::uint8_t* const __restrict usable = grid.usable.data();
  const std::size_t size = grid.size();
  for (std::size_t i = 0; i < size; ++i) {
    const float squared_shape = shape[i] * shape[i];
    const float squared_q = q[i] * q[i];
    const float fourth = squared_q * squared_q;
    slack[i] = grow_noise * squared_shape + grow_length * fourth;
    const bool flat = residual[i] <= usable_noise * squared_shape + usable_length * fourth;
    const bool near = pixel * shape[i] <= most * squared_q;
    usable[i] = static_cast<std::uint8_t>(static_cast<int>(n[i] > 0.0F) & static_cast<int>(flat) & static_cast<int>(near));
  }
}

/// A row's bytes, 0 or 1, as a set.
void pack(const std::uint8_t* bytes, std::size_t cells, std::uint64_t* set) {
  std::fill_n(set, kernels::words_of(cells), std::uint64_t{0});
  for (std::size_t i = 0; i < cells; ++i) {
    set[i / kernels::kWordBits] |= static_cast<std::uint64_t>(bytes[i]) << (i % kernels::kWordBits);
  }
}

/// Which neighbouring usable cells lie on one surface.
void find_links(const Grid& grid, const kernels::CellLinkLimits& limits, Grid::Links& links) {
  for (int r = 0; r < grid.rows; ++r) {
    const int i = grid.index(r, 0);
    const float* const shape = &grid.shape[at(i)];
    kernels::find_links(grid.arrays(i), shape, at(grid.columns), 1, limits, &links.right[at(r) * grid.words]);
    kernels::find_links(grid.arrays(i), shape, at(grid.columns), grid.stride, limits, &links.down[at(r) * grid.words]);
  }
  const std::vector<std::uint64_t>& usable = grid.usable_set;
  for (std::size_t i = 0; i < usable.size(); ++i) {
    const bool ends = (i + 1) % grid.words == 0;
    const std::uint64_t next = usable[i] >> 1 | (ends ? 0 : usable[i + 1] << (kernels::kWordBits - 1));
    const std::uint64_t below = i + grid.words < usable.size() ? usable[i + grid.words] : 0;
    links.right[i] &= usable[i] & next;
    links.down[i] &= usable[i] & below;
  }
}

void find_links(const Camera& camera, Grid& grid) {
  const auto square = [](double x) { return static_cast<float>(x * x); };
  for (int r = 0; r < grid.rows; ++r) {
    pack(&grid.usable[at(grid.index(r, 0))], at(grid.columns), &grid.usable_set[at(r) * grid.words]);
  }
  const float jump_noise = square(kC.jump_k * grid.noise.cell);
  find_links(grid,
             {.jump_noise = jump_noise,
              .jump_m = square(kC.jump_m * grid.noise.bias_scale),
              .slope_u = Grid::kHalfCell,
              .slope_v = Grid::kHalfCell,
              .bend_noise = square(kC.bend_k * grid.noise.cell),
              .bend_m = square(kC.bend_m * grid.noise.bias_scale),
              .bend_rad = 0.0F},
             grid.links);
  // A plane's slope in depth over the image plane at z = 1 is its slope in q over q.
  find_links(grid,
             {.jump_noise = jump_noise,
              .jump_m = square(kC.jump_m),
              .slope_u = static_cast<float>(camera.fx),
              .slope_v = static_cast<float>(camera.fy),
              .bend_noise = square(kC.bend_k * grid.noise.cell * camera.fx / static_cast<double>(Grid::kHalfCell)),
              .bend_m = 0.0F,
              .bend_rad = square(kC.slight_bend)},
             grid.smooth);
}

}  // namespace

std::optional<PlaneFit> fit(const Moments& m) {
  if (!(m.n > 0.0)) return std::nullopt;
  PlaneFit f;
  f.u = m.u / m.n;
  f.v = m.v / m.n;
  f.q = m.q / m.n;
  f.uu = m.uu / m.n - f.u * f.u;
  f.uv = m.uv / m.n - f.u * f.v;
  f.vv = m.vv / m.n - f.v * f.v;
  const double uq = m.uq / m.n - f.u * f.q;
  const double vq = m.vq / m.n - f.v * f.q;
  const double qq = m.qq / m.n - f.q * f.q;
  const double det = f.uu * f.vv - f.uv * f.uv;
  if (!(det > 1e-3 * f.uu * f.vv)) return std::nullopt;
  f.plane.du = (f.vv * uq - f.uv * vq) / det;
  f.plane.dv = (f.uu * vq - f.uv * uq) / det;
  f.plane.base = f.q - f.plane.du * f.u - f.plane.dv * f.v;
  f.mean_squared_residual = std::max(0.0, qq - f.plane.du * uq - f.plane.dv * vq);
  return f;
}

template <class Raw>
std::size_t measure_cells(const ImageRows<Raw>& image, const DepthView& view, const Camera& camera, const SensorModel& sensor,
                          int threads, GridBuffers& buffers, Grid& grid) {
  resize(view.width(), view.height(), grid);
  clear_border(grid);
  buffers.measured.resize(at(grid.rows));
  parallel_for(threads, cell_row_tasks(grid.rows), [&](std::size_t task) {
    for_each_cell_row(task, grid.rows,
                      [&](int row) { buffers.measured[at(row)] = measure_row(image, row, view.metres_per_unit(), grid); });
  });
  const double unit = set_shape(sensor, grid);
  grid.noise = estimate_noise(sensor, unit, buffers, grid);
  add_local_noise(buffers, grid);
  find_usable(grid);
  find_links(camera, grid);
  return std::accumulate(buffers.measured.begin(), buffers.measured.end(), std::size_t{0});
}

template std::size_t measure_cells(const ImageRows<std::uint16_t>&, const DepthView&, const Camera&, const SensorModel&, int,
                                   GridBuffers&, Grid&);
template std::size_t measure_cells(const ImageRows<float>&, const DepthView&, const Camera&, const SensorModel&, int,
                                   GridBuffers&, Grid&);

}  // namespace fransac::cells
