// SPDX-License-Identifier: Apache-2.0
#include "planes/cells/merge.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>
#include <numeric>
#include <optional>

#include "fransac/core/parallel.hpp"
#include "planes/cells/constants.hpp"
#include "planes/cells/judge.hpp"
#include "planes/cells/spread.hpp"

namespace fransac::cells {
namespace {

constexpr const Constants& kC = kConstants;
constexpr float kApart = std::numeric_limits<float>::infinity();

/// Whether the owners of some cells, kOwnersAtOnce from each place on, are the same.
constexpr int kOwnersAtOnce = sizeof(std::uint64_t) / sizeof(std::int16_t);
bool are_same(const std::int16_t* a, const std::int16_t* b) { return std::memcmp(a, b, sizeof(std::uint64_t)) == 0; }

class Merger {
 public:
  Merger(const Grid& grid, MergeBuffers& buffers, Regions& regions) : grid_(grid), b_(buffers), regions_(regions) {}

  void run() {
    b_.alive.clear();
    b_.rank.assign(regions_.list.size(), kNobody);
    for (std::size_t i = 0; i < regions_.list.size(); ++i) {
      if (!regions_.list[i].alive) continue;
      b_.rank[i] = static_cast<std::int16_t>(b_.alive.size());
      b_.alive.push_back(static_cast<std::int16_t>(i));
    }
    b_.target.resize(b_.alive.size());
    for (int i = 0; i < count(); ++i) b_.target[at(i)] = static_cast<std::int16_t>(i);
    make_pairs();
    measure_borders();
    for (MergeBuffers::Pair& pair : b_.pairs) judge(pair);
    b_.nearest.assign(at(count()), 0);
    for (int i = 0; i < count(); ++i) find_nearest(i);
    merge_all();
    for (std::int16_t& owner : regions_.owner) {
      if (owner != kNobody) owner = b_.alive[at(root(b_.rank[at(owner)]))];
    }
  }

 private:
  using Pair = MergeBuffers::Pair;
  using Border = MergeBuffers::Border;

  [[nodiscard]] int count() const { return static_cast<int>(b_.alive.size()); }
  [[nodiscard]] Region& region(int i) const { return regions_.list[at(b_.alive[at(i)])]; }
  [[nodiscard]] Pair& pair(int a, int b) const {
    if (a > b) std::swap(a, b);
    return b_.pairs[at(a * (2 * count() - a - 1) / 2 + b - a - 1)];
  }
  [[nodiscard]] int root(int i) const {
    while (b_.target[at(i)] != i) i = b_.target[at(i)];
    return i;
  }

  void make_pairs() {
    b_.pairs.clear();
    for (int a = 0; a < count(); ++a) {
      for (int b = a + 1; b < count(); ++b) b_.pairs.push_back({a, b, {}, kApart});
    }
  }

  /// How regions meet.
  void measure_borders() {
    const std::int16_t* const owner = regions_.owner.data();
    for (int r = 0; r < grid_.rows; ++r) {
      for (int c = 0; c < grid_.columns; ++c) {
        const int i = grid_.index(r, c);
        if (c + kOwnersAtOnce <= grid_.columns && are_same(owner + i, owner + i + 1) &&
            are_same(owner + i, owner + i + grid_.stride)) {
          c += kOwnersAtOnce - 1;
          continue;
        }
        if (owner[i] == kNobody) continue;
        if (owner[i + 1] != owner[i]) look_across(i, grid_.columns - 1 - c, 0, r, c);
        if (owner[i + grid_.stride] != owner[i]) look_across(i, grid_.rows - 1 - r, 1, r, c);
      }
    }
  }

  /// The next region to the right (0) or below (1), past at most two cells of nobody: edges blur.
  void look_across(int i, int room, int direction, int row, int column) {
    constexpr int kReach = 3;
    const int step = grid_.step(direction);
    const int mine = b_.rank[at(regions_.owner[at(i)])];
    for (int k = 1; k <= std::min(kReach, room); ++k) {
      const int j = i + k * step;
      if (regions_.owner[at(j)] == kNobody) continue;
      const int other = b_.rank[at(regions_.owner[at(j)])];
      if (other == mine) return;
      Border& border = pair(mine, other).border;
      ++border.length;
      const double jump = jump_between(i, j, region(mine).fit.plane, region(other).fit.plane);
      const auto q = 0.5 * (static_cast<double>(grid_.q[at(i)]) + static_cast<double>(grid_.q[at(j)]));
      const auto sigma = static_cast<double>(std::max(grid_.sigma[at(i)], grid_.sigma[at(j)]));
      border.jump += mine < other ? jump : -jump;
      border.variance += sigma * sigma;
      border.q4 += q * q * q * q;
      if (k == 1 && grid_.is_smooth(row, column, direction)) ++border.smooth;
      return;
    }
  }

  /// By how much inverse depth jumps from one cell to another beyond what the two planes' mean slope makes.
  [[nodiscard]] double jump_between(int i, int j, const InversePlane& a, const InversePlane& b) const {
    const auto difference = [&](const AlignedVector<float>& values) {
      return static_cast<double>(values[at(j)]) - static_cast<double>(values[at(i)]);
    };
    return difference(grid_.q) - 0.5 * ((a.du + b.du) * difference(grid_.u) + (a.dv + b.dv) * difference(grid_.v));
  }

  /// Whether a step runs along a border: its mean jump is more than slow noise and bias make. A few pairs say nothing.
  [[nodiscard]] bool is_step(const Border& border) const {
    constexpr int kFewest = 6;
    if (border.length < kFewest || border.smooth > 0.5 * border.length) return false;
    const double mean = border.jump / border.length;
    const double noise = grid_.noise.slow;
    const double length = kC.bias_far * grid_.noise.bias_m;
    return mean * mean > (noise * noise * border.variance + length * length * border.q4) / border.length;
  }

  /// Square of k of the slow errors plus a length, for the cells of two regions.
  [[nodiscard]] double tolerance(const Pair& p, double k) const {
    const double cells = region(p.a).cells + region(p.b).cells;
    const double noise = k * grid_.noise.slow;
    const double length = grid_.noise.near_m;
    return (noise * noise * (region(p.a).variance + region(p.b).variance) + length * length * (region(p.a).q4 + region(p.b).q4)) /
           cells;
  }

  void judge(Pair& p) const {
    p.rise = kApart;
    const Region& a = region(p.a);
    const Region& b = region(p.b);
    if (is_step(p.border)) return;
    const Region& large = a.cells >= b.cells ? a : b;
    const Region& small = a.cells >= b.cells ? b : a;
    const bool meet = meets(p);
    const double most = tolerance(p, meet ? kC.wide_sigmas : kC.sigmas);
    if (!meet && !predicts(large, small.fit, most)) return;
    const auto joint = joint_fit(p);
    if (!joint) return;
    const double rise = (joint->mean_squared_residual * (a.moments.n + b.moments.n) - a.fit.mean_squared_residual * a.moments.n -
                         b.fit.mean_squared_residual * b.moments.n) /
                        std::min(a.moments.n, b.moments.n);
    if (rise <= most && !turns(a, b)) p.rise = static_cast<float>(rise);
  }

  /// Whether the normals of two regions differ by more than those of neighbouring cells of one surface may, for certain.
  [[nodiscard]] bool turns(const Region& a, const Region& b) const {
    const Eigen::Vector3d n = grid_.parameters(a.fit.plane);
    const Eigen::Vector3d m = grid_.parameters(b.fit.plane);
    const double angle = std::atan2(n.cross(m).norm(), n.dot(m));
    constexpr double kSigmas = 2.0;
    const double sigma = std::hypot(turn_sigma(a) / n.norm(), turn_sigma(b) / m.norm());
    return angle - kSigmas * sigma > 0.25 * kC.most_turn;
  }

  /// One sigma of a region's Grid::parameters() across the direction in which the region is shortest.
  [[nodiscard]] double turn_sigma(const Region& region) const {
    const PlaneFit& f = region.fit;
    const double least = 0.5 * (f.uu + f.vv) - std::hypot(0.5 * (f.uu - f.vv), f.uv);
    return std::sqrt(mean_variance(region) / least * grid_.camera.fx * grid_.camera.fy);
  }

  /// Square of the slow errors that a region's mean has.
  [[nodiscard]] double mean_variance(const Region& region) const {
    return std::pow(grid_.noise.slow * region.sigma(), 2) * kC.slow_cells / region.cells;
  }

  /// Whether two regions touch along a border that is long for the smaller one.
  [[nodiscard]] bool meets(const Pair& p) const {
    const int cells = std::min(region(p.a).cells, region(p.b).cells);
    return p.border.length >= std::min(3.0, 0.5 * std::sqrt(cells));
  }

  [[nodiscard]] std::optional<PlaneFit> joint_fit(const Pair& p) const {
    Moments sum = region(p.a).moments;
    sum += region(p.b).moments;
    return fit(sum);
  }

  /// Whether the large region's plane foretells the small one, as far as it can foretell anything there.
  [[nodiscard]] bool predicts(const Region& region, const PlaneFit& small, double squared) const {
    const PlaneFit& large = region.fit;
    const double u = small.u - large.u;
    const double v = small.v - large.v;
    const double det = large.uu * large.vv - large.uv * large.uv;
    const double leverage = (large.vv * u * u - 2.0 * large.uv * u * v + large.uu * v * v) / det;
    const double slow = std::pow(grid_.noise.slow * region.sigma(), 2);
    const double variance = mean_variance(region) * (1.0 + leverage);
    if (variance > slow * kC.far_prediction_k * kC.far_prediction_k) return false;
    constexpr double kSigmas = 3.0;
    const double off = small.q - large.plane.at(small.u, small.v);
    if (off * off > kSigmas * kSigmas * (variance + slow)) return false;
    const double a = small.plane.du - large.plane.du;
    const double b = small.plane.dv - large.plane.dv;
    return a * a * small.uu + 2.0 * a * b * small.uv + b * b * small.vv <= squared;
  }

  /// Whether the camera sees past the joint plane between the two regions: then there is a gap, and nothing that hides the plane.
  [[nodiscard]] bool is_seen_past(const Pair& p) const {
    const PlaneFit joint = *joint_fit(p);  // judge() has seen that there is one
    const PlaneFit& a = region(p.a).fit;
    const PlaneFit& b = region(p.b).fit;
    const double u = b.u - a.u;
    const double v = b.v - a.v;
    const int steps = static_cast<int>(std::max(std::abs(u), std::abs(v)) / kernels::kCell) + 1;
    const double k = 4.0 * grid_.noise.cell;
    int between = 0;
    int past = 0;
    for (int t = 0; t <= steps; ++t) {
      const double x = a.u + u * t / steps + 0.5 * grid_.width;
      const double y = a.v + v * t / steps + 0.5 * grid_.height;
      const int i = grid_.index(std::clamp(static_cast<int>(y) / kernels::kCell, 0, grid_.rows - 1),
                                std::clamp(static_cast<int>(x) / kernels::kCell, 0, grid_.columns - 1));
      const std::int16_t owner = regions_.owner[at(i)];
      if (owner != kNobody && (root(b_.rank[at(owner)]) == p.a || root(b_.rank[at(owner)]) == p.b)) continue;
      ++between;
      if (!(grid_.n[at(i)] > 0.0F)) continue;
      const double q = joint.plane.at(static_cast<double>(grid_.u[at(i)]), static_cast<double>(grid_.v[at(i)]));
      const double noise = k * static_cast<double>(grid_.sigma[at(i)]);
      const double length = kC.bias_far * grid_.noise.bias_m * q * q;
      const double off = q - static_cast<double>(grid_.q[at(i)]);
      if (off > 0.0 && off * off > noise * noise + length * length) ++past;
    }
    return past > kC.seen_past * between;
  }

  /// Of the pairs of a region with those of higher rank the one whose merging costs least.
  void find_nearest(int a) {
    int nearest = std::min(a + 1, count() - 1);
    for (int b = nearest + 1; b < count(); ++b) {
      if (pair(a, b).rise < pair(a, nearest).rise) nearest = b;
    }
    b_.nearest[at(a)] = static_cast<std::int16_t>(nearest);
  }

  void merge_all() {
    for (;;) {
      Pair* best = nullptr;
      for (int a = 0; a + 1 < count(); ++a) {
        Pair& p = pair(a, b_.nearest[at(a)]);
        if (best == nullptr || p.rise < best->rise) best = &p;
      }
      if (best == nullptr || best->rise == kApart) return;
      if (meets(*best) || !is_seen_past(*best)) {
        merge(best->a, best->b);
      } else {
        best->rise = kApart;
        find_nearest(best->a);
      }
    }
  }

  void merge(int a, int b) {
    Region& into = region(a);
    Region& from = region(b);
    into.moments += from.moments;
    into.fit = *fit(into.moments);  // judge() has seen that there is one
    into.cells += from.cells;
    from.alive = false;
    b_.target[at(b)] = static_cast<std::int16_t>(a);
    into.variance += from.variance;
    into.q4 += from.q4;
    pair(a, b).rise = kApart;
    for (int other = 0; other < count(); ++other) {
      if (other == a || other == b || !region(other).alive) continue;
      Pair& gone = pair(b, other);
      Pair& kept = pair(a, other);
      kept.border.length += gone.border.length;
      kept.border.smooth += gone.border.smooth;
      kept.border.variance += gone.border.variance;
      kept.border.q4 += gone.border.q4;
      kept.border.jump += (a < other) == (b < other) ? gone.border.jump : -gone.border.jump;
      gone.rise = kApart;
      judge(kept);
    }
    for (int first = 0; first < b; ++first) {
      std::int16_t& nearest = b_.nearest[at(first)];
      if (first == a || nearest == a || nearest == b) {
        find_nearest(first);
      } else if (first < a && pair(first, a).rise < pair(first, nearest).rise) {
        nearest = static_cast<std::int16_t>(a);
      }
    }
  }

  const Grid& grid_;
  MergeBuffers& b_;
  Regions& regions_;
};

/// Gives cells to the regions they fit best.
class Reassigner {
 public:
  Reassigner(const Grid& grid, int threads, ReassignBuffers& buffers, Regions& regions)
      : grid_(grid), threads_(threads), b_(buffers), regions_(regions), words_(grid.words) {
    b_.tasks.resize(std::max(b_.tasks.size(), at(grid.rows)));
    clear_sets();
    b_.words_of_row = words_;
    b_.words_of_set = at(grid.rows) * words_;
    b_.sets.resize(std::max(b_.sets.size(), regions.list.size() * b_.words_of_set));
    make_sets();
  }

  void run() {
    for_each_row(threads_, grid_, [&](int row) { give_cells(row); });
    clear_sets();
    make_sets();
    for_each_region([&](std::size_t g) {
      if (regions_.list[g].alive) fit_again(g);
    });
  }

  /// The regions' sums that are not moments.
  void sum_again() {
    for_each_region([&](std::size_t g) {
      const auto [top, bottom] = b_.rows[g];
      if (top <= bottom) regions_.list[g].sum_errors(grid_, {set(g) + at(top) * words_, top, bottom});
    });
  }

 private:
  [[nodiscard]] std::uint64_t* set(std::size_t region) { return &b_.sets[region * b_.words_of_set]; }

  template <class Visitor>
  void for_each_region(const Visitor& visit) {
    parallel_for(threads_, regions_.list.size(), visit);
  }

  /// As they were made last, maybe for another image.
  void clear_sets() {
    for (std::size_t g = 0; g < b_.rows.size(); ++g) {
      const auto [top, bottom] = b_.rows[g];
      if (top <= bottom) std::fill_n(set(g) + at(top) * b_.words_of_row, at(bottom - top + 1) * b_.words_of_row, 0);
    }
    b_.rows.clear();
  }

  void make_sets() {
    b_.rows.assign(regions_.list.size(), {grid_.rows, -1});
    for (int r = 0; r < grid_.rows; ++r) {
      const std::int16_t* const owner = &regions_.owner[at(grid_.index(r, 0))];
      for (int first = 0, end = 0; first < grid_.columns; first = end) {
        while (end + kOwnersAtOnce < grid_.columns && are_same(owner + end, owner + end + 1)) end += kOwnersAtOnce;
        while (end < grid_.columns && owner[end] == owner[first]) ++end;
        if (owner[first] == kNobody) continue;
        std::uint64_t* const row = set(at(owner[first])) + at(r) * words_;
        for (int w = first / kernels::kWordBits; w <= (end - 1) / kernels::kWordBits; ++w) {
          row[w] |= bits_between(first, end - 1, w * kernels::kWordBits);
        }
        ReassignBuffers::Rows& rows = b_.rows[at(owner[first])];
        rows.top = std::min(rows.top, r);
        rows.bottom = r;
      }
    }
  }

  /// To each region the usable cells of its cells' 3 x 3 in a row that fit it best.
  void give_cells(int row) {
    ReassignBuffers::Task& task = b_.tasks[at(row)];
    const std::size_t columns = at(grid_.columns);
    task.least.assign(columns + Grid::kPadding, kApart);
    task.nearest.assign(columns + Grid::kPadding, kNobody);
    task.around.resize(words_);
    const int i = grid_.index(row, 0);
    for (std::size_t g = 0; g < regions_.list.size(); ++g) {
      const auto [top, bottom] = b_.rows[g];
      if (row < top - 1 || row > bottom + 1 || !regions_.list[g].alive || !find_around(g, row, task.around)) continue;
      const PlaneFit& fit = regions_.list[g].fit;
      kernels::find_nearest(grid_.arrays(i), &grid_.slack[at(i)], columns, about(fit.plane, fit.u, fit.v), task.around.data(),
                            static_cast<std::int32_t>(g), task.least.data(), task.nearest.data());
    }
    std::transform(task.nearest.begin(), task.nearest.begin() + grid_.columns, regions_.owner.begin() + i,
                   [](std::int32_t region) { return static_cast<std::int16_t>(region); });
  }

  /// Whether there are any.
  bool find_around(std::size_t region, int row, std::vector<std::uint64_t>& around) {
    const auto [top, bottom] = b_.rows[region];
    std::fill(around.begin(), around.end(), 0);
    for (int r = std::max(row - 1, top); r <= std::min(row + 1, bottom); ++r) {
      for (std::size_t w = 0; w < words_; ++w) around[w] |= set(region)[at(r) * words_ + w];
    }
    std::uint64_t before = 0;
    std::uint64_t any = 0;
    for (std::size_t w = 0; w < words_; ++w) {
      const std::uint64_t word = around[w];
      const std::uint64_t after = w + 1 < words_ ? around[w + 1] << (kernels::kWordBits - 1) : 0;
      around[w] = (word | word << 1 | word >> 1 | before | after) & grid_.usable_set[at(row) * words_ + w];
      before = word >> (kernels::kWordBits - 1);
      any |= around[w];
    }
    return any != 0;
  }

  void fit_again(std::size_t g) {
    Region& region = regions_.list[g];
    const auto [top, bottom] = b_.rows[g];
    region.alive = false;
    if (bottom < top) return;
    const std::uint64_t* const cells = set(g) + at(top) * words_;
    const std::size_t rows = at(bottom - top + 1);
    const kernels::CellSetPlane plane = about(region.fit.plane, region.fit.u, region.fit.v);
    const kernels::CellSetSums sums = kernels::sum_cells(grid_.arrays(grid_.index(top, 0)), cells, rows, words_, plane);
    region.moments = moments_of(sums, plane);
    region.cells = sums.cells;
    if (const auto again = fit(region.moments)) {
      region.fit = *again;
      region.alive = true;
    }
  }

  const Grid& grid_;
  int threads_;
  ReassignBuffers& b_;
  Regions& regions_;
  std::size_t words_;
};

/// Cells of regions that are no more are nobody's.
void release_cells(Regions& regions) {
  for (std::int16_t& owner : regions.owner) {
    if (owner != kNobody && !regions.list[at(owner)].alive) owner = kNobody;
  }
}

}  // namespace

void merge_regions(const Grid& grid, MergeBuffers& buffers, Regions& regions) { Merger(grid, buffers, regions).run(); }

void reassign_borders(const Grid& grid, int threads, ReassignBuffers& buffers, Regions& regions) {
  Reassigner reassigner(grid, threads, buffers, regions);
  constexpr int kPasses = 2;
  for (int pass = 0; pass < kPasses; ++pass) reassigner.run();
  reassigner.sum_again();
}

void judge_regions(const Grid& grid, double min_confidence, int threads, const ReassignBuffers& reassigned,
                   JudgeBuffersOfTasks& buffers, Regions& regions) {
  const double measured = std::accumulate(grid.n.begin(), grid.n.end(), 0.0);
  parallel_for(threads, buffers.size(), [&](std::size_t task) {
    const Judge judge(grid, buffers[task]);
    for (std::size_t g = task; g < regions.list.size(); g += buffers.size()) {
      Region& region = regions.list[g];
      if (!region.alive) continue;
      const auto [top, bottom] = reassigned.rows[g];
      const std::uint64_t* const bits = &reassigned.sets[g * reassigned.words_of_set + at(top) * grid.words];
      region.evidence = judge.look(region, {bits, top, bottom}, measured);
      region.confidence = Judge::confidence(region.evidence);
      region.alive = region.confidence >= min_confidence;
    }
  });
  release_cells(regions);
}

}  // namespace fransac::cells
