// SPDX-License-Identifier: Apache-2.0
#include "planes/cells/grid.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>

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
    values->resize(size);
  }
  grid.usable.resize(size);
  grid.links.resize(size);
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

template <class Raw>
void measure_row(const ImageRows<Raw>& image, int row, float metres_per_unit, Grid& grid) {
  const int first = grid.index(row, 0);
  const auto from = [&](AlignedVector<float>& values) { return values.data() + first; };
  const kernels::CellMoments out{from(grid.n),  from(grid.u),  from(grid.v),  from(grid.q),  from(grid.uu),
                                 from(grid.uv), from(grid.vv), from(grid.du), from(grid.dv), from(grid.residual)};
  const auto cells = static_cast<std::size_t>(grid.columns);
  kernels::cell_kernels<Raw>().moments(image.cells(row), cells, metres_per_unit, static_cast<float>(kC.least_measured), out);
  // From the cell's centre to the image's.
  const float half = 0.5F * (kCell - 1);
  const float base_v = static_cast<float>(row * kCell) + half - 0.5F * static_cast<float>(grid.height);
  const float base_u = half - 0.5F * static_cast<float>(grid.width);
  for (std::size_t c = 0; c < cells; ++c) {
    out.u[c] += base_u + static_cast<float>(c) * kCell;
    out.v[c] += base_v;
  }
}

/// The value below which a share of the sample lies; 0 without a sample. Values are not negative. Reorders the sample.
float quantile(AlignedVector<float>& sample, double share) {
  if (sample.empty()) return 0.0F;
  auto rank = static_cast<std::size_t>(share * static_cast<double>(sample.size() - 1));
  // The bits of floats are in the order of their values: count by the leading ones, then look only at those of one count.
  constexpr int kDropped = 20;
  std::array<std::uint32_t, std::size_t{1} << (32 - kDropped - 1)> counts{};
  const auto leading = [](float value) { return std::bit_cast<std::uint32_t>(value) >> kDropped; };
  for (const float value : sample) ++counts[leading(value)];
  std::uint32_t bin = 0;
  for (; rank >= counts[bin]; ++bin) rank -= counts[bin];
  const auto end = std::partition(sample.begin(), sample.end(), [&](float value) { return leading(value) == bin; });
  const auto nth = sample.begin() + static_cast<std::ptrdiff_t>(rank);
  std::nth_element(sample.begin(), nth, end);
  return *nth;
}

/// Calls visit(cell) for cells that a sample is taken from: all, or of large images every so many, some thousands.
template <class Visitor>
void for_each_sampled(const Grid& grid, Visitor visit) {
  constexpr int kEnough = 4800;
  int stride = 1;
  while (grid.columns * grid.rows / (stride * stride) > kEnough) ++stride;
  for (int r = 0; r < grid.rows; r += stride) {
    // Shifted from row to row, so that rows and columns of the scene are not seen in step.
    for (int c = (r / stride) % stride; c < grid.columns; c += stride) visit(grid.index(r, c));
  }
}

constexpr float kFull = kCell * kCell - 4;  // a few pixels may be missing

/// One sigma of `values` against the mean of a cell's two neighbours, from its 30 % quantile; a plane has none.
double second_difference(const Grid& grid, const AlignedVector<float>& values, AlignedVector<float>& sample) {
  sample.clear();
  bool across = false;
  for_each_sampled(grid, [&](int i) {
    across = !across;
    const int step = across ? 1 : grid.stride;
    if (grid.n[at(i)] < kFull || grid.n[at(i - step)] < kFull || grid.n[at(i + step)] < kFull) return;
    sample.push_back(std::abs(values[at(i)] - 0.5F * (values[at(i - step)] + values[at(i + step)])) / grid.shape[at(i)]);
  });
  // |x| of a normal x with sigma 1 is below 0.3853 in 30 % of all cases; the difference of three values has variance 1.5.
  constexpr double kToSigma = 1.0 / (0.3853 * 1.2247);
  return kToSigma * static_cast<double>(quantile(sample, kC.noise_quantile));
}

constexpr double kKinectSigma = 1.425e-3;            // per metre, Khoshelham & Elberink 2012
constexpr double kLeastSigma = 1e-3 * kKinectSigma;  // floats of rendered depth

/// Sets the shape of the noise over depth that the sensor is known for, 1 on average; returns what 1 stands for, per metre.
double set_shape(const SensorModel& sensor, Grid& grid) {
  if (sensor.kind == SensorKind::automatic) {
    std::fill(grid.shape.begin(), grid.shape.end(), 1.0F);
    return kKinectSigma;
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
  for_each_sampled(grid, [&](int i) {
    if (grid.n[at(i)] >= kFull) sample.push_back(std::sqrt(grid.residual[at(i)]) / grid.shape[at(i)]);
  });
  const bool known = sensor.kind != SensorKind::automatic;
  Noise noise;
  noise.pixel = std::clamp(kC.noise_gain * static_cast<double>(quantile(sample, kC.noise_quantile)),
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
  noise.bias_scale = known ? sensor.bias_m / kC.bias_m : std::clamp(noise.cell / kKinectSigma, kC.least_bias_scale, 1.0);
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

/// Which cells and their neighbours `step` further lie on one smooth surface: the links to there and back.
void find_links(int step, std::uint8_t there, std::uint8_t back, GridBuffers& buffers, Grid& grid) {
  const auto jump_k = static_cast<float>(kC.jump_k * grid.noise.cell);
  const auto jump_m = static_cast<float>(kC.jump_m * grid.noise.bias_scale);
  const auto bend_k = static_cast<float>(kC.bend_k * grid.noise.cell);
  const auto bend_m = static_cast<float>(kC.bend_m * grid.noise.bias_scale);
  const float* const __restrict u = grid.u.data();
  const float* const __restrict v = grid.v.data();
  const float* const __restrict q = grid.q.data();
  const float* const __restrict du = grid.du.data();
  const float* const __restrict dv = grid.dv.data();
  const float* const __restrict shape = grid.shape.data();
  const std::uint8_t* const __restrict usable = grid.usable.data();
  buffers.linked.resize(grid.size());
  std::int32_t* const __restrict linked = buffers.linked.data();
  const std::ptrdiff_t first = grid.index(0, 0);
  const std::ptrdiff_t end = grid.index(grid.rows - 1, grid.columns);
  for (std::ptrdiff_t i = first; i < end; ++i) {
    const std::ptrdiff_t j = i + step;
    const float jump = q[j] - q[i] - 0.5F * ((du[i] + du[j]) * (u[j] - u[i]) + (dv[i] + dv[j]) * (v[j] - v[i]));
    const float x = Grid::kHalfCell * (du[j] - du[i]);
    const float y = Grid::kHalfCell * (dv[j] - dv[i]);
    const float noise = std::max(shape[i], shape[j]);
    const float mean = 0.5F * (q[i] + q[j]);
    const float squared_noise = noise * noise;
    const float fourth = mean * mean * mean * mean;
    const bool level = jump * jump <= jump_k * jump_k * squared_noise + jump_m * jump_m * fourth;
    const bool straight = x * x + y * y <= bend_k * bend_k * squared_noise + bend_m * bend_m * fourth;
    linked[i] = static_cast<std::int32_t>(level) & static_cast<std::int32_t>(straight);
  }
  for (std::ptrdiff_t i = first; i < end; ++i) linked[i] &= usable[i] & usable[i + step];
  std::uint8_t* const __restrict links = grid.links.data();
  for (std::ptrdiff_t i = first; i < end; ++i) links[i] |= static_cast<std::uint8_t>(linked[i] * there);
  for (std::ptrdiff_t i = first; i < end; ++i) links[i + step] |= static_cast<std::uint8_t>(linked[i] * back);
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
void measure_cells(const ImageRows<Raw>& image, const DepthView& view, const SensorModel& sensor, int threads,
                   GridBuffers& buffers, Grid& grid) {
  resize(view.width(), view.height(), grid);
  clear_border(grid);
  parallel_for(threads, cell_row_tasks(grid.rows), [&](std::size_t task) {
    for_each_cell_row(task, grid.rows, [&](int row) { measure_row(image, row, view.metres_per_unit(), grid); });
  });
  const double unit = set_shape(sensor, grid);
  grid.noise = estimate_noise(sensor, unit, buffers, grid);
  add_local_noise(buffers, grid);
  find_usable(grid);
  std::fill(grid.links.begin(), grid.links.end(), std::uint8_t{0});
  find_links(1, Grid::kRight, Grid::kLeft, buffers, grid);
  find_links(grid.stride, Grid::kDown, Grid::kUp, buffers, grid);
}

template void measure_cells(const ImageRows<std::uint16_t>&, const DepthView&, const SensorModel&, int, GridBuffers&, Grid&);
template void measure_cells(const ImageRows<float>&, const DepthView&, const SensorModel&, int, GridBuffers&, Grid&);

}  // namespace fransac::cells
