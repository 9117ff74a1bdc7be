// SPDX-License-Identifier: Apache-2.0
#include "planes/cells/grid.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <limits>
#include <numeric>

#include "fransac/core/parallel.hpp"
#include "planes/cells/constants.hpp"

namespace fransac::cells {
namespace {

constexpr const Constants& kC = kConstants;
using kernels::kCell;

/// A Kinect's focal length, at which cells were first measured: 8 pixels are 0.87 degrees.
constexpr double kFocalLength_px = 525.0;
constexpr int kMostParts = 2;
constexpr int kMostMerged = 8;

/// Noise is taken for no less: what the rounding of floats leaves of rendered depth.
constexpr double kLeastSigma = 1e-3 * kKinectNoise_per_m;

Camera camera_of_samples(const Camera& camera, const Sampling& sampling) {
  const double k = sampling.per_pixel();
  Camera scaled = camera;
  scaled.fx *= k;
  scaled.fy *= k;
  scaled.cx = (camera.cx + 0.5) * k - 0.5;
  scaled.cy = (camera.cy + 0.5) * k - 0.5;
  return scaled;
}

void resize(const DepthView& view, const Camera& camera, Grid& grid) {
  const double k = grid.sampling.per_pixel();
  grid.camera = camera_of_samples(camera, grid.sampling);
  grid.width = k * view.width();
  grid.height = k * view.height();
  grid.columns = static_cast<int>(std::ceil(grid.width / kCell));
  grid.rows = static_cast<int>(std::ceil(grid.height / kCell));
  grid.stride = grid.columns + 2;
  const std::size_t size = at(grid.stride) * at(grid.rows + 2);
  for (auto* values : {&grid.n, &grid.u, &grid.v, &grid.q, &grid.uu, &grid.uv, &grid.vv, &grid.du, &grid.dv, &grid.residual,
                       &grid.sigma, &grid.slack}) {
    values->resize(size + Grid::kPadding);
    std::fill_n(values->begin() + static_cast<std::ptrdiff_t>(size), Grid::kPadding, 0.0F);
  }
  grid.usable.resize(size);
  grid.measured.resize(size);
  grid.words = kernels::words_of(at(grid.columns));
  for (auto* set :
       {&grid.usable_set, &grid.measured_set, &grid.links.right, &grid.links.down, &grid.smooth.right, &grid.smooth.down})
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

constexpr int kFields = 10;
kernels::CellMoments fields(float* const (&f)[kFields]) { return {f[0], f[1], f[2], f[3], f[4], f[5], f[6], f[7], f[8], f[9]}; }

/// One cell out of the `merged` x `merged` of `parts`, rows of `stride` cells of 8 x 8 pixels, from column `first` on.
void merge_cell(const kernels::CellMoments& parts, int merged, std::size_t stride, std::size_t first, double least,
                std::size_t cell, const kernels::CellMoments& out) {
  double n = 0.0, u = 0.0, v = 0.0, q = 0.0, uu = 0.0, uv = 0.0, vv = 0.0, uq = 0.0, vq = 0.0, qq = 0.0;
  double reference = 0.0;
  for (int y = 0; y < merged; ++y) {
    for (int x = 0; x < merged; ++x) {
      const std::size_t i = at(y) * stride + first + at(x);
      const auto d = [&](const float* values) { return static_cast<double>(values[i]); };
      const double k = d(parts.n);
      if (k == 0.0) continue;
      if (n == 0.0) reference = d(parts.q);
      const double pu = d(parts.u) + kCell * (x - 0.5 * (merged - 1));
      const double pv = d(parts.v) + kCell * (y - 0.5 * (merged - 1));
      const double pq = d(parts.q) - reference;
      const double puq = d(parts.uu) * d(parts.du) + d(parts.uv) * d(parts.dv);
      const double pvq = d(parts.uv) * d(parts.du) + d(parts.vv) * d(parts.dv);
      n += k;
      u += k * pu;
      v += k * pv;
      q += k * pq;
      uu += k * (d(parts.uu) + pu * pu);
      uv += k * (d(parts.uv) + pu * pv);
      vv += k * (d(parts.vv) + pv * pv);
      uq += k * (puq + pu * pq);
      vq += k * (pvq + pv * pq);
      qq += k * (d(parts.mean_squared_residual) + d(parts.du) * puq + d(parts.dv) * pvq + pq * pq);
    }
  }
  out.n[cell] = out.u[cell] = out.v[cell] = out.q[cell] = out.uu[cell] = out.uv[cell] = out.vv[cell] = out.du[cell] =
      out.dv[cell] = 0.0F;
  out.mean_squared_residual[cell] = kernels::kNoFit;
  const double per_sample = 1.0 / merged;  // lengths become samples
  const double share = per_sample * per_sample;
  if (n * share < least) return;
  u /= n, v /= n, q /= n;
  uu = uu / n - u * u, uv = uv / n - u * v, vv = vv / n - v * v;
  uq = uq / n - u * q, vq = vq / n - v * q, qq = qq / n - q * q;
  const double det = uu * vv - uv * uv;
  if (!(det * share * share > static_cast<double>(kernels::kLeastSpread))) return;
  const double du = (vv * uq - uv * vq) / det;
  const double dv = (uu * vq - uv * uq) / det;
  const auto f = [](double value) { return static_cast<float>(value); };
  out.n[cell] = f(n * share);
  out.u[cell] = f(u * per_sample);
  out.v[cell] = f(v * per_sample);
  out.q[cell] = f(q + reference);
  out.uu[cell] = f(uu * share);
  out.uv[cell] = f(uv * share);
  out.vv[cell] = f(vv * share);
  out.du[cell] = f(du * merged);
  out.dv[cell] = f(dv * merged);
  out.mean_squared_residual[cell] = f(std::max(0.0, qq - du * uq - dv * vq));
}

/// Fills a row of cells.
template <class Raw>
void measure_row(const ImageRows<Raw>& image, int row, float metres_per_unit, GridBuffers::Task& task, Grid& grid) {
  const int first = grid.index(row, 0);
  const auto from = [&](AlignedVector<float>& values) { return values.data() + first; };
  const kernels::CellMoments out{from(grid.n),  from(grid.u),  from(grid.v),  from(grid.q),  from(grid.uu),
                                 from(grid.uv), from(grid.vv), from(grid.du), from(grid.dv), from(grid.residual)};
  const auto cells = static_cast<std::size_t>(grid.columns);
  const auto& kernel = kernels::cell_kernels<Raw>(grid.sampling.side());
  const auto least = static_cast<float>(kC.least_measured);
  const int merged = grid.sampling.merged;
  if (merged == 1) {
    task.measured = kernel.moments(image.cells(row), cells, metres_per_unit, least, out);
  } else {
    const std::size_t stride = cells * at(merged);
    const std::size_t size = at(merged) * stride;
    task.parts.resize(size * kFields);
    task.measured = 0;
    float* of_row[kFields];
    float* of_all[kFields];
    for (int k = 0; k < kFields; ++k) of_all[k] = task.parts.data() + at(k) * size;
    for (int y = 0; y < merged; ++y) {
      for (int k = 0; k < kFields; ++k) of_row[k] = of_all[k] + at(y) * stride;
      task.measured += kernel.moments(image.cells(row * merged + y), stride, metres_per_unit, 0.25F * least, fields(of_row));
    }
    for (std::size_t c = 0; c < cells; ++c) merge_cell(fields(of_all), merged, stride, c * at(merged), kC.least_measured, c, out);
  }
  // From the cell's centre to the image's.
  const double half = 0.5 * (kCell - 1);
  const auto base_v = static_cast<float>(row * kCell + half - 0.5 * grid.height);
  const auto base_u = static_cast<float>(half - 0.5 * grid.width);
  for (std::size_t c = 0; c < cells; ++c) {
    out.u[c] += base_u + static_cast<float>(c) * kCell;
    out.v[c] += base_v;
  }
}

/// Bins of positive floats by the leading bits, steps of an eighth, from which quantiles follow.
struct FloatBins {
  static constexpr int kDropped = 20;
  static constexpr std::uint32_t kFirst = std::bit_cast<std::uint32_t>(1e-16F) >> kDropped;  // less than any noise squared
  static constexpr std::uint32_t kLast = std::bit_cast<std::uint32_t>(1e6F) >> kDropped;
  static constexpr std::size_t kCount = kLast - kFirst;  ///< Values beyond, kernels::kNone among them, are in none.

  static std::size_t of(float value) {
    return std::clamp(std::bit_cast<std::uint32_t>(value) >> kDropped, kFirst, kLast) - kFirst;
  }
  static float start(std::size_t bin) { return std::bit_cast<float>(static_cast<std::uint32_t>(bin + kFirst) << kDropped); }
  /// The value in a bin of which `share` of the bin's values are less.
  static double within(std::size_t bin, double share) {
    const auto from = static_cast<double>(start(bin));
    return from + (static_cast<double>(start(bin + 1)) - from) * share;
  }
};

/// Counts of weighted values.
class Histogram {
 public:
  void add(float value, std::uint32_t weight) { counts_[FloatBins::of(value)] += weight; }
  /// The value below which a share lies; 0 of nothing.
  [[nodiscard]] double quantile(double share) const {
    const std::uint64_t all = std::accumulate(counts_.begin(), counts_.end() - 1, std::uint64_t{0});
    if (all == 0) return 0.0;
    double rank = share * static_cast<double>(all - 1);
    std::size_t bin = 0;
    for (; rank >= static_cast<double>(counts_[bin]); ++bin) rank -= static_cast<double>(counts_[bin]);
    return FloatBins::within(bin, (rank + 0.5) / static_cast<double>(counts_[bin]));
  }

 private:
  std::array<std::uint32_t, FloatBins::kCount + 1> counts_{};
};

/// The value below which a share of a sample lies; 0 without one. Values are not negative. Bisection: counting what is less is
/// the fastest thing to do with them.
double quantile(const AlignedVector<float>& sample, double share) {
  const auto less = [&](std::size_t bin) {
    return bin == 0 ? 0 : kernels::count_less(sample.data(), sample.size(), FloatBins::start(bin));
  };
  std::size_t bin = 0;
  std::size_t end = FloatBins::kCount;
  std::size_t below = 0;
  std::size_t below_end = less(end);
  if (below_end == 0) return 0.0;
  const double rank = share * static_cast<double>(below_end - 1);
  while (end - bin > 1) {
    const std::size_t middle = bin + (end - bin) / 2;
    const std::size_t count = less(middle);
    const bool after = static_cast<double>(count) <= rank;
    (after ? bin : end) = middle;
    (after ? below : below_end) = count;
  }
  return FloatBins::within(bin, (rank - static_cast<double>(below) + 0.5) / static_cast<double>(below_end - below));
}

/// Calls visit(first cell) for rows that a sample is taken from: all, or of large images every so many, some thousands of cells.
template <class Visitor>
void for_each_sampled_row(const Grid& grid, Visitor visit) {
  constexpr int kEnough = 4800;
  const int step = std::max(1, grid.columns * grid.rows / kEnough);
  for (int r = 0; r < grid.rows; r += step) visit(grid.index(r, 0));
}

/// Which cells of a row tell something of noise: not those that hold one value throughout, or a few steps of depth that do not
/// slope. A wall seen from the front in coarse units does, but so do a sky, a far clip and a filled hole.
void find_telling(int row, double step_m, GridBuffers& buffers, const Grid& grid) {
  constexpr float kRounding = 1e-5F;  // far more than sums of one value round to, far less than any sensor's noise
  const auto half_step = static_cast<float>(0.5 * step_m);  // rounding alone leaves 0.29 of a step
  constexpr float kHalf = 0.5F * (kCell - 1);
  const std::size_t first = at(grid.index(row, 0));
  const auto v = static_cast<float>(row * kCell - 0.5 * grid.height) + kHalf;
  const auto left = static_cast<float>(-0.5 * grid.width) + kHalf;
  const auto from = [&](const AlignedVector<float>& values) { return values.data() + first; };
  const float* const __restrict n = from(grid.n);
  const float* const __restrict u = from(grid.u);
  const float* const __restrict means_v = from(grid.v);
  const float* const __restrict q = from(grid.q);
  const float* const __restrict du = from(grid.du);
  const float* const __restrict dv = from(grid.dv);
  const float* const __restrict residual = from(grid.residual);
  float* const __restrict telling = buffers.telling.data() + first;
  float* const __restrict centred = buffers.centred.data() + first;
  for (int c = 0; c < grid.columns; ++c) {
    const float a = kRounding * q[c];
    const float b = half_step * q[c] * q[c];
    const float least = a > b ? a : b;
    constexpr float kAcross = 0.5F * Grid::kHalfCell;  // a quarter of a cell, on which half a step is two of them over the cell
    const float sloping = kAcross * kAcross * (du[c] * du[c] + dv[c] * dv[c]);
    const float most = sloping > residual[c] ? sloping : residual[c];
    telling[c] = most > least * least ? n[c] : 0.0F;
    centred[c] = q[c] - du[c] * (u[c] - (left + static_cast<float>(c * kCell))) - dv[c] * (means_v[c] - v);
  }
}

void clear_border(const Grid& grid, AlignedVector<float>& values) {
  const std::size_t size = grid.size();
  for (int c = 0; c < grid.stride; ++c) values[at(c)] = values[size - 1 - at(c)] = 0.0F;
  for (int r = 0; r <= grid.rows + 1; ++r) values[at(r * grid.stride)] = values[at((r + 1) * grid.stride - 1)] = 0.0F;
}

/// Whether all are multiples of a number that is not 0. Written so that compilers make vector code of it.
bool are_multiples(const std::uint16_t* values, std::size_t count, unsigned of) {
  if (of == 0) return false;
  const float per_step = 1.0F / static_cast<float>(of);
  std::int32_t rest = 0;
  for (std::size_t i = 0; i < count; ++i) {
    const std::int32_t value = values[i];
    rest |= value - static_cast<std::int32_t>(of) * static_cast<std::int32_t>(static_cast<float>(value) * per_step + 0.5F);
  }
  return rest == 0;
}

/// The step of the measured depths, metres: their greatest common divisor, which can be many raw units. 0 of floats.
template <class Raw>
double raw_step(const ImageRows<Raw>& image, const DepthView& view, const Grid& grid) {
  if constexpr (std::is_same_v<Raw, float>) {
    return 0.0;
  } else {
    unsigned common = 0;
    const std::size_t width = at(view.width());
    for (int r = 0; r < grid.rows * grid.sampling.merged && common != 1; ++r) {
      const Raw* const row = image.cells(r).rows[0];
      if (are_multiples(row, width, common)) continue;
      for (std::size_t u = 0; u < width && common != 1; ++u) common = std::gcd(common, static_cast<unsigned>(row[u]));
    }
    // A wall in one value only says nothing.
    constexpr double kMost_m = 0.02;
    const auto unit = static_cast<double>(view.metres_per_unit());
    return common * unit > kMost_m ? unit : common * unit;
  }
}

/// Takes the measurements from cells that were filled: one value in many of them, though depth there is noisier than its steps
/// and could not be the same in a single one. Whether there were any.
bool drop_filled(double step_m, const DepthNoise& shown, GridBuffers& buffers, Grid& grid) {
  constexpr double kExact = 1e-4;  // of the depth: rendered
  constexpr double kMany = 0.03;   // of the measured cells
  AlignedVector<float>& values = buffers.sample;
  values.clear();
  double measured = 0.0;
  for (std::size_t i = 0; i < grid.size(); ++i) {
    if (grid.n[i] == 0.0F) continue;
    measured += 1.0;
    const double z = 1.0 / static_cast<double>(grid.q[i]);
    if (buffers.telling[i] == 0.0F && shown.sigma_m(z) > std::max(step_m, kExact * z)) values.push_back(grid.q[i]);
  }
  if (static_cast<double>(values.size()) < kMany * measured) return false;
  std::sort(values.begin(), values.end());
  bool any = false;
  for (std::size_t first = 0, end = 0; first < values.size(); first = end) {
    // Sums of one value differ in their last bits where cells are not full.
    constexpr float kSame = 1.0F + 1e-6F;
    while (end < values.size() && values[end] <= values[first] * kSame) ++end;
    if (static_cast<double>(end - first) < kMany * measured) continue;
    any = true;
    for (std::size_t i = 0; i < grid.size(); ++i) {
      if (buffers.telling[i] != 0.0F || !(grid.q[i] >= values[first] && grid.q[i] <= values[end - 1])) continue;
      grid.n[i] = grid.q[i] = grid.du[i] = grid.dv[i] = 0.0F;
      grid.residual[i] = kernels::kNoFit;
    }
  }
  return any;
}

/// What the quantile of cells' rms residuals is short of a pixel's sigma by. That of few pixels, less three degrees of freedom,
/// lies lower: the 30 % quantiles of chi squared with 61, 13 and 1 of them are 54.7, 9.93 and 0.148.
double gain_of_cells(const Grid& grid) {
  const double of_64 = std::sqrt(54.7 / 64.0);
  switch (grid.sampling.parts) {
    case 1: return kC.noise_gain;
    case 2: return kC.noise_gain * of_64 / std::sqrt(9.93 / 16.0);
    default: return kC.noise_gain * of_64 / std::sqrt(0.148 / 4.0);
  }
}

/// Pixel noise by depth from the cells' residuals, sigma_z^2 = a^2 + (b z^2)^2: what is constant in depth, as of time of flight,
/// and what is constant in inverse depth, as of triangulation. From the 30 % quantile of each half octave of depth, so that
/// clutter in a cell does not count; of laws that meet at some distance the one with the smallest mean of |log ratio|, with their
/// median as its scale, so that a depth with nothing but clutter, or with what a camera made up, does not either.
DepthNoise measure_pixel_noise(const GridBuffers& buffers, const Grid& grid) {
  const double gain = gain_of_cells(grid);
  constexpr int kOctaveBits = 22;  // two bins an octave
  constexpr std::uint32_t kFirst = std::bit_cast<std::uint32_t>(0.0156F) >> kOctaveBits;
  constexpr std::size_t kBins = 28;
  std::array<Histogram, kBins> of_bin{};
  std::array<double, kBins> sum_q{};
  std::array<double, kBins> cells{};
  for_each_sampled_row(grid, [&](int first) {
    for (std::size_t i = at(first); i < at(first + grid.columns); ++i) {
      if (buffers.telling[i] == 0.0F) continue;
      const std::uint32_t octave = std::bit_cast<std::uint32_t>(grid.q[i]) >> kOctaveBits;
      const std::size_t bin = std::clamp<std::uint32_t>(octave, kFirst, kFirst + kBins - 1) - kFirst;
      of_bin[bin].add(grid.residual[i], static_cast<std::uint32_t>(buffers.telling[i] + 0.5F));
      sum_q[bin] += static_cast<double>(grid.q[i]);
      cells[bin] += 1.0;
    }
  });
  constexpr double kFewest = 12.0;
  const double most = *std::max_element(cells.begin(), cells.end());
  if (most == 0.0) return {};
  struct Sample {
    double q2;     ///< Squared inverse depth.
    double sigma;  ///< Of inverse depth.
    double weight;
    double ratio = 0.0;
  };
  std::array<Sample, kBins> samples{};
  std::size_t count = 0;
  double all = 0.0;
  for (std::size_t b = 0; b < kBins; ++b) {
    if (cells[b] < std::min(kFewest, most)) continue;
    const double sigma = gain * std::sqrt(std::max(of_bin[b].quantile(kC.noise_quantile), 1e-16));
    samples[count++] = {std::pow(sum_q[b] / cells[b], 2), sigma, cells[b]};
    all += cells[b];
  }
  // sigma_q = b sqrt(1 + (q / q0)^4): both parts are equal at 1 / q0, from 25 cm to 4 m, or one of them is all.
  DepthNoise best;
  double least = std::numeric_limits<double>::infinity();
  for (int half_octaves = -5; half_octaves <= 5; ++half_octaves) {
    const double constant = half_octaves == -5 ? 0.0 : half_octaves == 5 ? 1.0 : std::pow(2.0, -half_octaves);
    const double quadratic = half_octaves == 5 ? 0.0 : 1.0;
    for (std::size_t k = 0; k < count; ++k) {
      Sample& s = samples[k];
      s.ratio = std::log(s.sigma / std::hypot(quadratic, constant * s.q2));
    }
    std::sort(samples.begin(), samples.begin() + static_cast<std::ptrdiff_t>(count),
              [](const Sample& x, const Sample& y) { return x.ratio < y.ratio; });
    double below = 0.0;
    std::size_t middle = 0;
    while (2.0 * (below + samples[middle].weight) < all) below += samples[middle++].weight;
    double cost = 0.0;
    for (std::size_t k = 0; k < count; ++k) cost += samples[k].weight * std::abs(samples[k].ratio - samples[middle].ratio);
    if (!(cost < 0.999 * least)) continue;
    least = cost;
    const double scale = std::exp(samples[middle].ratio);
    best = {.constant_m = scale * constant, .quadratic_per_m = scale * quadratic};
  }
  return best;
}

/// One sigma of `values` against the mean of a cell's two neighbours, in its row and in its column, as a share of its pixel
/// noise, from the 30 % quantile; a plane has none.
double second_difference(const Grid& grid, const AlignedVector<float>& values, GridBuffers& buffers) {
  AlignedVector<float>& sample = buffers.sample;
  sample.resize(2 * grid.size());
  std::size_t size = 0;
  for_each_sampled_row(grid, [&](int first) {
    for (const int step : {1, grid.stride}) {
      kernels::measure_differences(&buffers.telling[at(first)], &values[at(first)], &grid.sigma[at(first)], at(grid.columns),
                                   step, static_cast<float>(kC.least_measured), &sample[size]);
      size += at(grid.columns);
    }
  });
  sample.resize(size);
  // |x| of a normal x with sigma 1 is below 0.3853 in 30 % of all cases; the difference of three values has variance 1.5.
  constexpr double kToSigma = 1.0 / (0.3853 * 1.2247);
  return kToSigma * quantile(sample, kC.noise_quantile);
}

/// Squares of what the noise of inverse depth is at q = 1 / z.
struct NoiseOfInverse {
  explicit NoiseOfInverse(const DepthNoise& noise)
      : fourth(static_cast<float>(noise.constant_m * noise.constant_m)),
        second(static_cast<float>(noise.linear * noise.linear)),
        none(static_cast<float>(noise.quadratic_per_m * noise.quadratic_per_m)) {}
  [[nodiscard]] float at(float q) const {
    const float qq = q * q;
    return (fourth * qq + second) * qq + none;
  }
  float fourth, second, none;
};

DepthNoise times(const DepthNoise& noise, double factor) {
  return {noise.constant_m * factor, noise.linear * factor, noise.quadratic_per_m * factor};
}

/// Every cell's own noise: that of the flattest cell nearby, no less than the frame's law says within its bounds, and no more
/// than `local_noise` times that, or what a named sensor may have, or of others a Kinect.
void set_sigmas(const SensorModel& sensor, double step_m, const DepthNoise& shown, int threads, GridBuffers& buffers,
                Grid& grid) {
  const bool known = sensor.kind != SensorKind::automatic;
  AlignedVector<float>& least_residual = buffers.least_residual;
  least_residual.resize(grid.size());
  const auto lesser = [](float a, float b) { return a < b ? a : b; };  // std::min's references keep loops scalar
  const auto greater = [](float a, float b) { return a > b ? a : b; };
  const auto stride = at(grid.stride);
  const std::size_t size = grid.size();
  const float* const __restrict residual = grid.residual.data();
  float* const __restrict least = least_residual.data();
  for_each_row(threads, grid, [&](int row) {
    const std::size_t first = at(grid.index(row, -1));
    for (std::size_t i = first; i < first + stride; ++i) {
      least[i] = lesser(lesser(residual[i - stride], residual[i]), residual[i + stride]);
    }
  });
  std::fill_n(least_residual.begin(), stride, 0.0F);
  std::fill_n(least_residual.end() - static_cast<std::ptrdiff_t>(stride), stride, 0.0F);
  const double rms_to_sigma = gain_of_cells(grid);
  const auto gain = static_cast<float>(rms_to_sigma * rms_to_sigma);
  const NoiseOfInverse frame(shown);
  DepthNoise least_noise = known ? times(sensor.noise, 0.25) : DepthNoise{};
  least_noise.constant_m = std::max(least_noise.constant_m, step_m / std::sqrt(12.0));
  const NoiseOfInverse lowest(least_noise);
  const NoiseOfInverse highest(known ? times(sensor.noise, 2.0)
                                     : DepthNoise{.constant_m = kC.most_constant_m, .quadratic_per_m = 4.0 * kKinectNoise_per_m});
  const NoiseOfInverse local(known ? times(sensor.noise, 2.0)
                                   : DepthNoise{.constant_m = 0.2 * kC.most_constant_m, .quadratic_per_m = kKinectNoise_per_m});
  const auto doubled = static_cast<float>(kC.local_noise * kC.local_noise);
  constexpr auto kLeast = static_cast<float>(kLeastSigma * kLeastSigma);
  const float* const __restrict q = grid.q.data();
  float* const __restrict sigma = grid.sigma.data();
  const auto set = [&](std::size_t first, std::size_t end) {
    for (std::size_t i = first; i < end; ++i) {
      const float near = gain * lesser(lesser(least[i - 1], least[i]), least[i + 1]);
      const float low = greater(kLeast, lowest.at(q[i]));
      const float usual = greater(low, lesser(frame.at(q[i]), highest.at(q[i])));
      const float most = lesser(greater(doubled * usual, local.at(q[i])), greater(usual, highest.at(q[i])));
      sigma[i] = std::sqrt(greater(usual, lesser(near, most)));
    }
  };
  sigma[0] = sigma[size - 1] = std::sqrt(kLeast);
  set(1, stride);
  set(size - stride, size - 1);
  for_each_row(threads, grid, [&](int row) { set(at(grid.index(row, -1)), at(grid.index(row, grid.columns)) + 1); });
}

/// The law of the pixel noise as cells have it: what the frame shows within its bounds, or the sensor's at the frame's scale.
DepthNoise believed(const SensorModel& sensor, double step_m, const DepthNoise& shown, const Grid& grid) {
  if (sensor.kind == SensorKind::automatic) {
    return {.constant_m = std::clamp(shown.constant_m, step_m / std::sqrt(12.0), std::max(step_m, kC.most_constant_m)),
            .quadratic_per_m = std::clamp(shown.quadratic_per_m, kLeastSigma, 4.0 * kKinectNoise_per_m)};
  }
  const NoiseOfInverse model(sensor.noise);
  double ratio = 0.0;
  double cells = 0.0;
  for_each_sampled_row(grid, [&](int first) {
    for (std::size_t i = at(first); i < at(first + grid.columns); ++i) {
      const float usual = model.at(grid.q[i]);
      if (grid.n[i] == 0.0F || !(usual > 0.0F)) continue;
      ratio += static_cast<double>(grid.sigma[i] / std::sqrt(usual));
      cells += 1.0;
    }
  });
  return cells > 0.0 ? times(sensor.noise, ratio / cells) : sensor.noise;
}

/// What is not a cell's own: noise from cell to cell, slow noise, bias; and how well a cell knows its direction.
Noise estimate_noise(const SensorModel& sensor, const SensorOptions& given, double step_m, GridBuffers& buffers,
                     const Grid& grid) {
  const bool known = sensor.kind != SensorKind::automatic;
  Noise noise;
  const double mean = second_difference(grid, buffers.centred, buffers);
  const double slope = static_cast<double>(Grid::kHalfCell) *
                       std::max(second_difference(grid, grid.du, buffers), second_difference(grid, grid.dv, buffers));
  // Errors that are the same in all rows of a cell, as those of rounding are on a wall, leave this share of the pixel's.
  const double side = kCell / grid.sampling.per_pixel();  // pixels
  const double alike = 1.0 / std::sqrt(side);
  constexpr double kMost = 3.0;
  noise.shown = std::min(std::max(mean, slope), kMost);
  noise.cell = std::max(noise.shown, alike);
  noise.slow = given.slow.value_or(kC.slow_noise * noise.cell);
  // If pixels err independently, half a cell times its slopes differs from its neighbours' by this much of a pixel's sigma: the
  // column of a pixel has the variance (side^2 - 1) / 12. What is clearly more, by the 15 % to which both are known, is shared
  // by neighbours.
  const double independent = 1.15 * 0.5 / std::sqrt((side * side - 1.0) / 12.0);
  noise.shared = given.slow
                     ? *given.slow * *given.slow
                     : kC.slow_noise * kC.slow_noise * std::max(0.0, noise.shown * noise.shown - independent * independent);
  // Rendered depth is not bent. Its cells agree to a small part of what any sensor's do.
  double sum = 0.0;
  double relative = 0.0;
  double cells = 0.0;
  for_each_sampled_row(grid, [&](int first) {
    for (std::size_t i = at(first); i < at(first + grid.columns); ++i) {
      if (grid.n[i] == 0.0F) continue;
      const auto sigma = static_cast<double>(grid.sigma[i]);
      sum += sigma;
      relative += sigma / static_cast<double>(grid.q[i]);
      cells += 1.0;
    }
  });
  const double typical = cells > 0.0 ? sum / cells : kLeastSigma;
  noise.slope_rad = cells > 0.0 ? noise.shown * relative / cells * grid.camera.fx / static_cast<double>(Grid::kHalfCell) : 1.0;
  const double exact = std::clamp(noise.cell * typical / (kC.exact_noise * kKinectNoise_per_m), 0.05, 1.0);
  // What bends planes grows with the angle from the optical axis: a narrow view sees less of it than a Kinect's.
  constexpr double kWidth = 640.0 / kFocalLength_px;
  const double view = std::min(1.0, grid.width / grid.camera.fx / kWidth);
  // Rounding makes terraces: pixels near each other are off by the same.
  noise.bias_m = std::hypot(given.bias_m.value_or(known ? sensor.bias_m : exact * view * kC.bias_m), step_m);
  noise.near_m = std::hypot(kC.bias_near * noise.bias_m, step_m);
  return noise;
}

void find_usable(int threads, Grid& grid) {
  const auto square = [](double x) { return static_cast<float>(x * x); };
  const float usable_noise = square(kC.sigmas);
  const float usable_length = square(grid.noise.near_m) + square(kC.flat_m / 3.0);
  const float grow_noise = square(kC.wide_sigmas * grid.noise.cell);
  const float grow_length = square(grid.noise.bias_m) + square(kC.flat_m);
  const auto most = static_cast<float>(kC.most_sigma_m);
  const float* const __restrict n = grid.n.data();
  const float* const __restrict q = grid.q.data();
  const float* const __restrict sigma = grid.sigma.data();
  const float* const __restrict residual = grid.residual.data();
  float* const __restrict slack = grid.slack.data();
  std::uint8_t* const __restrict usable = grid.usable.data();
  std::uint8_t* const __restrict measured = grid.measured.data();
  const auto find = [&](int row) {
    const std::size_t first = at(grid.index(row, -1));
    for (std::size_t i = first; i < first + at(grid.stride); ++i) {
      const float variance = sigma[i] * sigma[i];
      const float squared_q = q[i] * q[i];
      const float fourth = squared_q * squared_q;
      slack[i] = grow_noise * variance + grow_length * fourth;
      const bool flat = residual[i] <= usable_noise * variance + usable_length * fourth;
      const bool near = sigma[i] <= most * squared_q;
      measured[i] = static_cast<std::uint8_t>(n[i] > 0.0F);
      usable[i] = static_cast<std::uint8_t>(static_cast<int>(n[i] > 0.0F) & static_cast<int>(flat) & static_cast<int>(near));
    }
  };
  find(-1);
  find(grid.rows);
  for_each_row(threads, grid, find);
}

/// A row's bytes, 0 or 1, as a set.
void pack(const std::uint8_t* bytes, std::size_t cells, std::uint64_t* set) {
  std::fill_n(set, kernels::words_of(cells), std::uint64_t{0});
  for (std::size_t i = 0; i < cells; ++i) {
    set[i / kernels::kWordBits] |= static_cast<std::uint64_t>(bytes[i]) << (i % kernels::kWordBits);
  }
}

/// Which neighbouring cells of a row, and of it and the next, lie on one surface.
void find_links(const Grid& grid, int row, const kernels::CellLinkLimits& limits, Grid::Links& links) {
  const int i = grid.index(row, 0);
  const float* const sigma = &grid.sigma[at(i)];
  kernels::find_links(grid.arrays(i), sigma, at(grid.columns), 1, limits, &links.right[at(row) * grid.words]);
  kernels::find_links(grid.arrays(i), sigma, at(grid.columns), grid.stride, limits, &links.down[at(row) * grid.words]);
}

/// Leaves links between usable cells only.
void keep_usable(const Grid& grid, Grid::Links& links) {
  const std::vector<std::uint64_t>& usable = grid.usable_set;
  for (std::size_t i = 0; i < usable.size(); ++i) {
    const bool ends = (i + 1) % grid.words == 0;
    const std::uint64_t next = usable[i] >> 1 | (ends ? 0 : usable[i + 1] << (kernels::kWordBits - 1));
    const std::uint64_t below = i + grid.words < usable.size() ? usable[i + grid.words] : 0;
    links.right[i] &= usable[i] & next;
    links.down[i] &= usable[i] & below;
  }
}

void find_links_of_frame(int threads, Grid& grid) {
  const auto square = [](double x) { return static_cast<float>(x * x); };
  const float jump_noise = square(kC.sigmas * grid.noise.cell);
  const kernels::CellLinkLimits one_plane = {.jump_noise = jump_noise,
                                             .jump_m = square(grid.noise.near_m),
                                             .slope_u = Grid::kHalfCell,
                                             .slope_v = Grid::kHalfCell,
                                             .bend_noise = square(kC.sigmas * grid.noise.cell),
                                             .bend_m = square(grid.noise.near_m),
                                             .bend_rad = 0.0F};
  // A plane's slope in depth over the image plane at z = 1 is its slope in q over q.
  const kernels::CellLinkLimits one_surface = {
      .jump_noise = jump_noise,
      .jump_m = square(kC.bias_near * kC.bias_m),  // a rendered surface is as smooth as a measured one
      .slope_u = static_cast<float>(grid.camera.fx),
      .slope_v = static_cast<float>(grid.camera.fy),
      .bend_noise = square(kC.sigmas * grid.noise.cell * grid.camera.fx / static_cast<double>(Grid::kHalfCell)),
      .bend_m = 0.0F,
      .bend_rad = square(0.5 * kC.most_turn)};
  for_each_row(threads, grid, [&](int r) {
    pack(&grid.usable[at(grid.index(r, 0))], at(grid.columns), &grid.usable_set[at(r) * grid.words]);
    pack(&grid.measured[at(grid.index(r, 0))], at(grid.columns), &grid.measured_set[at(r) * grid.words]);
    find_links(grid, r, one_plane, grid.links);
    find_links(grid, r, one_surface, grid.smooth);
  });
  keep_usable(grid, grid.links);
  keep_usable(grid, grid.smooth);
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

Sampling sampling_of(const Camera& camera) {
  Sampling sampling;
  // A Kinect's pixel is one sample, by angle and as a share of the image, whichever makes finer cells.
  constexpr double kPixels = 640.0 * 480.0;
  const double pixels = std::sqrt(static_cast<double>(camera.width) * camera.height / kPixels);
  const double ratio = std::min(std::sqrt(camera.fx * camera.fy) / kFocalLength_px, pixels);
  const double half = std::sqrt(2.0);
  while (sampling.merged < kMostMerged && ratio / sampling.merged > half) sampling.merged *= 2;
  while (sampling.parts < kMostParts && ratio * sampling.parts * 1.6 < 1.0) sampling.parts *= 2;
  return sampling;
}

std::optional<Sampling> finer_sampling(const Noise& noise, const Sampling& sampling) {
  const bool precise = noise.slope_rad * noise.shown < kC.fine_slope;
  if (sampling.merged > 1 || sampling.parts > kMostParts || !precise) return std::nullopt;
  return Sampling{.parts = 2 * sampling.parts};
}

template <class Raw>
std::size_t measure_cells(const ImageRows<Raw>& image, const DepthView& view, const Camera& camera, const SensorModel& sensor,
                          const SensorOptions& given, int threads, GridBuffers& buffers, Grid& grid) {
  resize(view, camera, grid);
  clear_border(grid);
  buffers.tasks.resize(std::max(buffers.tasks.size(), at(grid.rows)));
  for (auto* values : {&buffers.telling, &buffers.centred}) values->resize(grid.size() + Grid::kPadding);
  clear_border(grid, buffers.telling);
  const double step = raw_step(image, view, grid);
  for_each_row(threads, grid, [&](int row) {
    measure_row(image, row, view.metres_per_unit(), buffers.tasks[at(row)], grid);
    find_telling(row, step, buffers, grid);
  });
  const DepthNoise shown = measure_pixel_noise(buffers, grid);
  set_sigmas(sensor, step, shown, threads, buffers, grid);
  if (drop_filled(step, shown, buffers, grid)) set_sigmas(sensor, step, shown, threads, buffers, grid);
  grid.noise = estimate_noise(sensor, given, step, buffers, grid);
  grid.noise.pixel = believed(sensor, step, shown, grid);
  find_usable(threads, grid);
  find_links_of_frame(threads, grid);
  std::size_t measured = 0;
  for (int row = 0; row < grid.rows; ++row) measured += buffers.tasks[at(row)].measured;
  return measured;
}

template std::size_t measure_cells(const ImageRows<std::uint16_t>&, const DepthView&, const Camera&, const SensorModel&,
                                   const SensorOptions&, int, GridBuffers&, Grid&);
template std::size_t measure_cells(const ImageRows<float>&, const DepthView&, const Camera&, const SensorModel&,
                                   const SensorOptions&, int, GridBuffers&, Grid&);

}  // namespace fransac::cells
