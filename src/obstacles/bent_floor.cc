// SPDX-License-Identifier: Apache-2.0
#include "obstacles/bent_floor.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>

namespace fransac::obstacles {
namespace {

/// Errors of pixels that are farther apart than 8 are unrelated (docs/algorithms.md, "Errors that neighbours share"): the mean
/// of a patch of twice that, four cells by four, is as far off as a pixel; that of more cells less.
constexpr double kSlowCells = 16.0;

/// One sigma of a cell's mean over that of its pixels, which err together in part. Were it 1, boxes of 5 cm at 3 m would be
/// floor up to 36 mm (scripts/low-obstacles).
constexpr double kOfCell = 0.6;

/// Seen at a grazing angle, bias may be so many times what it is nearer by: it is told as a length, but that of triangulating
/// sensors grows with the squared distance, and what bends the picture's corners with it.
constexpr double kGrazingErrors = 2.0;

/// A group is floor when so much of it is: what stands on the floor has rims that are as low as it.
constexpr double kMostOfGroup = 0.75;

/// The floor about a cell is that of the cells so far to all sides: as far as errors of neighbours reach, and once more.
constexpr int kAround = CellImage::kBorder;

/// One side of the support: what is above it, or below.
template <class Raw>
class Leveller {
 public:
  Leveller(const DepthRows<Raw>& rows, const Segmentation& segmentation, const std::vector<int>& carriers, const Plane& support,
           const FloorError& error, double sigmas, DepthRowBuffer& buffer, BentFloor& work, Sides& sides, bool above)
      : rows_(rows),
        camera_(rows.camera()),
        segmentation_(segmentation),
        support_(support),
        error_(error),
        sigmas_(sigmas),
        buffer_(buffer),
        w_(work),
        s_(sides),
        cells_(sides.cells),
        any_(above ? sides.any_above : sides.any_below),
        count_(above ? sides.above : sides.below),
        q_(above ? sides.q : sides.q_below),
        sign_(above ? 1.0 : -1.0) {
    for (const int label : carriers) carries_[at(label)] = true;
  }

  void run() {
    find_low();
    if (w_.low.empty()) return;
    keep_feet();
    want_floor();
    measure_floor();
    for (const Cell& cell : w_.low) {
      if (w_.kind[at(cell.index)] != kLow) continue;
      find_group(cell.index);
      level_group();
    }
  }

 private:
  // What a cell is.
  static constexpr std::uint8_t kNone = 0;
  static constexpr std::uint8_t kHigh = 1;
  static constexpr std::uint8_t kLow = 2;
  static constexpr std::uint8_t kFoot = 3;
  static constexpr std::uint8_t kGrouped = 4;
  static constexpr std::uint8_t kJoined = 5;

  [[nodiscard]] Eigen::Vector3d point(const Cell& cell) const {
    const double z = 1.0 / static_cast<double>(q_[at(cell.index)]);
    return {z * s_.ray_x[at(cell.column)], z * s_.ray_y[at(cell.row)], z};
  }
  [[nodiscard]] Eigen::Vector3d point(int cell) const { return point({cell, cells_.row(cell), cells_.column(cell)}); }

  /// What may be floor where it joins it.
  [[nodiscard]] double limit_m(const Eigen::Vector3d& point) const {
    return error_.most_m(point) * (error_.is_grazing(point) ? kGrazingErrors : 1.0);
  }

  /// Cells that may be floor.
  void find_low() {
    w_.kind.assign(cells_.size(), kNone);
    w_.height.resize(cells_.size());
    w_.low.clear();
    const int least = least_pixels(cells_.side);
    for (const Cell& cell : any_) {
      if (count_[at(cell.index)] < least) continue;
      const Eigen::Vector3d p = point(cell);
      const double height = support_.signed_distance(p);
      w_.height[at(cell.index)] = static_cast<float>(height);
      const bool low = std::abs(height) <= limit_m(p);
      w_.kind[at(cell.index)] = low ? kLow : kHigh;
      if (low) w_.low.push_back(cell);
    }
  }

  /// How many cells what is upright takes to rise above what may be floor.
  [[nodiscard]] int foot(int cell) const {
    const Eigen::Vector3d p = point(cell);
    const double per_cell = cells_.side * p.z() / std::max(camera_.fx, camera_.fy);
    constexpr double kMost = 1000.0;
    return 1 + static_cast<int>(std::min(kMost, std::ceil(limit_m(p) / per_cell)));
  }

  /// Whether two neighbouring cells can be of one upright surface, up to 60 degrees to the ray: not what is seen behind it.
  [[nodiscard]] bool stands_under(int low, int cell) const {
    constexpr double kSteepest = 1.73;
    const Eigen::Vector3d p = point(low);
    const double slant = std::abs(support_.normal.dot(p)) / p.z();
    const double per_cell = cells_.side * p.z() / std::min(camera_.fx, camera_.fy);
    return slant * std::abs(p.z() - point(cell).z()) <= slant * kSteepest * per_cell + sigmas_ * error_.pixel_m(p);
  }

  [[nodiscard]] std::array<int, 4> beside(int cell) const {
    return {cell - cells_.stride, cell - 1, cell + 1, cell + cells_.stride};
  }

  /// What is high has feet, which are as low as a floor.
  void keep_feet() {
    w_.queue.clear();
    w_.steps.resize(cells_.size());
    const auto add = [&](int cell, int steps) {
      w_.kind[at(cell)] = kFoot;
      w_.steps[at(cell)] = static_cast<std::uint16_t>(steps);
      w_.queue.push_back(cell);
    };
    for (const Cell& cell : w_.low) {
      const auto is_under = [&](int high) {
        return w_.kind[at(high)] == kHigh && is_strong(high) && stands_under(cell.index, high);
      };
      const std::array<int, 4> next = beside(cell.index);
      if (std::any_of(next.begin(), next.end(), is_under)) add(cell.index, 1);
    }
    for (std::size_t head = 0; head < w_.queue.size(); ++head) {
      const int cell = w_.queue[head];
      const int steps = w_.steps[at(cell)] + 1;
      for (const int next : beside(cell)) {
        if (w_.kind[at(next)] == kLow && steps <= foot(next) && stands_under(next, cell)) add(next, steps);
      }
    }
  }

  /// Flying pixels and outliers make two cells.
  [[nodiscard]] bool is_strong(int cell) const {
    constexpr int kFewest = 3;
    int high = 0;
    for (int row = -1; row <= 1; ++row) {
      for (int column = -1; column <= 1; ++column) high += w_.kind[at(cell + row * cells_.stride + column)] == kHigh ? 1 : 0;
    }
    return high >= kFewest;
  }

  void want_floor() {
    w_.wanted.assign(cells_.size(), 0);
    w_.rows.assign(at(cells_.rows + 2 * CellImage::kBorder), 0);
    for (const Cell& cell : w_.low) {
      if (w_.kind[at(cell.index)] != kLow) continue;
      for (int row = -kAround; row <= kAround; ++row) {
        std::uint8_t* const first = &w_.wanted[at(cell.index + row * cells_.stride - kAround)];
        std::fill_n(first, 2 * kAround + 1, std::uint8_t{1});
      }
      std::fill_n(&w_.rows[at(cell.row + CellImage::kBorder - kAround)], 2 * kAround + 1, std::uint8_t{1});
    }
  }

  /// The mean height of the pixels on the support in each cell that is wanted.
  void measure_floor() {
    w_.floor.assign(cells_.size() + 1, 0.0F);
    w_.is_floor.assign(cells_.size() + 1, 0);
    for (int r = 0; r < cells_.rows; ++r) {
      if (w_.rows[at(r + CellImage::kBorder)] == 0) continue;
      const std::size_t first = at(cells_.index(r, 0));
      w_.sums.clear();
      for (int column = 0; column < cells_.columns; ++column) {
        if (w_.wanted[first + at(column)] != 0 && s_.seen[first + at(column)] != 0) w_.sums.push_back({column, 0, 0.0});
      }
      if (w_.sums.empty()) continue;
      for (int v = r * cells_.side; v < std::min((r + 1) * cells_.side, rows_.height()); ++v) add_row(v);
      for (const BentFloor::Sum& sum : w_.sums) {
        if (sum.count < at(least_pixels(cells_.side))) continue;
        w_.floor[first + at(sum.column)] = static_cast<float>(sum.height_m / sum.count);
        w_.is_floor[first + at(sum.column)] = 1;
      }
    }
  }

  /// Adds a row's pixels on the support to the sums of the cells that are wanted.
  void add_row(int v) {
    const Raw* const raw = rows_.row(v, buffer_).kept;
    const std::uint8_t* const labels = &segmentation_.labels[at(v) * rows_.width()];
    const float metres = rows_.view().metres_per_unit();
    const double step = support_.normal.x() / camera_.fx;
    const double base =
        support_.normal.z() + support_.normal.y() * (v - camera_.cy) / camera_.fy - support_.normal.x() * camera_.cx / camera_.fx;
    const double offset = support_.d;
    for (BentFloor::Sum& sum : w_.sums) {
      const int end = std::min((sum.column + 1) * cells_.side, static_cast<int>(rows_.width()));
      double height_m = sum.height_m;
      std::uint32_t count = sum.count;
      for (int u = sum.column * cells_.side; u < end; ++u) {
        if (!carries_[labels[u]] || raw[u] == Raw{0}) continue;
        height_m += static_cast<double>(static_cast<float>(raw[u]) * metres) * (base + step * u) + offset;
        ++count;
      }
      sum.height_m = height_m;
      sum.count = count;
    }
  }

  /// Low cells that hang together.
  void find_group(int start) {
    w_.group.assign(1, start);
    w_.kind[at(start)] = kGrouped;
    for (std::size_t head = 0; head < w_.group.size(); ++head) {
      const int cell = w_.group[head];
      for (const int next : beside(cell)) {
        if (w_.kind[at(next)] != kLow) continue;
        w_.kind[at(next)] = kGrouped;
        w_.group.push_back(next);
      }
    }
  }

  /// Whether what is certainly no floor begins beside a group.
  [[nodiscard]] bool touches_kept() const {
    return std::any_of(w_.group.begin(), w_.group.end(), [&](std::int32_t cell) {
      const std::array<int, 4> next = beside(cell);
      return std::any_of(next.begin(), next.end(), [&](int i) { return w_.kind[at(i)] == kHigh || w_.kind[at(i)] == kFoot; });
    });
  }

  /// The mean height of the floor about a cell; not a number where none is seen.
  [[nodiscard]] double floor_about(int cell) const {
    constexpr int kColumns = 2 * kAround + 2;  // one too many: a whole vector
    std::array<float, kColumns> sums{};
    std::array<std::uint8_t, kColumns> counts{};
    for (int row = -kAround; row <= kAround; ++row) {
      const std::size_t first = at(cell + row * cells_.stride - kAround);
      for (std::size_t k = 0; k < kColumns; ++k) sums[k] += w_.floor[first + k];
      for (std::size_t k = 0; k < kColumns; ++k) counts[k] = static_cast<std::uint8_t>(counts[k] + w_.is_floor[first + k]);
    }
    const float sum = std::accumulate(sums.begin(), sums.end() - 1, 0.0F);
    return static_cast<double>(sum) / std::accumulate(counts.begin(), counts.end() - 1, 0);
  }

  /// Least steps that are none, as a share of a pixel's noise. Drops are much deeper than low boxes are high.
  [[nodiscard]] double step_noise(bool grazing) const { return grazing || sign_ < 0.0 ? 1.0 : kOfCell; }

  /// The highest step above the floor about a cell that is none, metres. `shared` is the part of the slow noise's square that a
  /// group's mean has.
  [[nodiscard]] double most_step_m(int cell, double shared) const {
    const Eigen::Vector3d p = point(cell);
    const bool grazing = error_.is_grazing(p);
    if (grazing && static_cast<double>(std::abs(w_.height[at(cell)])) <= error_.most_m(p)) {
      return std::numeric_limits<double>::infinity();
    }
    return sigmas_ * step_noise(grazing) * std::hypot(error_.pixel_m(p), std::sqrt(shared) * error_.slow_m(p));
  }

  /// Lets the floor spread over a group, and takes it out if most of it is floor then.
  void level_group() {
    const auto size = static_cast<double>(w_.group.size());
    const double shared = std::min(1.0, kSlowCells / size);
    std::sort(w_.group.begin(), w_.group.end());
    w_.most.resize(cells_.size());
    for (const std::int32_t cell : w_.group) w_.most[at(cell)] = most_step_m(cell, shared);
    std::size_t joined = 0;
    bool met = false;
    constexpr int kRounds = 16;
    for (int round = 0; round < kRounds; ++round) {
      const std::size_t before = joined;
      for (const std::int32_t cell : w_.group) {
        if (w_.kind[at(cell)] == kJoined) continue;
        const double floor = floor_about(cell);
        if (std::isnan(floor)) continue;
        met = true;
        if (sign_ * (static_cast<double>(w_.height[at(cell)]) - floor) > w_.most[at(cell)]) continue;
        w_.kind[at(cell)] = kJoined;
        w_.floor[at(cell)] = w_.height[at(cell)];
        w_.is_floor[at(cell)] = 1;
        ++joined;
      }
      if (joined == before) break;
      std::reverse(w_.group.begin(), w_.group.end());
    }
    // Where no floor is near, nothing tells it from one.
    const bool is_floor = (!met && !touches_kept()) || static_cast<double>(joined) >= kMostOfGroup * size;
    for (const std::int32_t cell : w_.group) {
      if (w_.kind[at(cell)] == kJoined && !is_floor) {
        w_.floor[at(cell)] = 0.0F;
        w_.is_floor[at(cell)] = 0;
      }
      if (!is_floor || (met && w_.kind[at(cell)] != kJoined)) continue;
      count_[at(cell)] = 0;
      q_[at(cell)] = 0.0F;
      s_.seen[at(cell)] = 1;
    }
  }

  const DepthRows<Raw>& rows_;
  const Camera& camera_;
  const Segmentation& segmentation_;
  const Plane& support_;
  const FloorError& error_;
  double sigmas_;
  DepthRowBuffer& buffer_;
  BentFloor& w_;
  Sides& s_;
  const CellImage& cells_;
  const std::vector<Cell>& any_;
  std::vector<std::uint16_t>& count_;
  std::vector<float>& q_;
  double sign_;
  std::array<bool, 256> carries_{};  ///< By label.
};

}  // namespace

template <class Raw>
void remove_bent_floor(const DepthRows<Raw>& rows, const Segmentation& segmentation, const std::vector<int>& carriers,
                       const Plane& support, const FloorError& error, double sigmas, DepthRowBuffer& buffer, BentFloor& work,
                       Sides& sides) {
  Leveller<Raw>(rows, segmentation, carriers, support, error, sigmas, buffer, work, sides, true).run();
  if (!sides.any_below.empty())
    Leveller<Raw>(rows, segmentation, carriers, support, error, sigmas, buffer, work, sides, false).run();
}

template void remove_bent_floor(const DepthRows<std::uint16_t>&, const Segmentation&, const std::vector<int>&, const Plane&,
                                const FloorError&, double, DepthRowBuffer&, BentFloor&, Sides&);
template void remove_bent_floor(const DepthRows<float>&, const Segmentation&, const std::vector<int>&, const Plane&,
                                const FloorError&, double, DepthRowBuffer&, BentFloor&, Sides&);

}  // namespace fransac::obstacles
