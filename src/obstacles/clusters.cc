// SPDX-License-Identifier: Apache-2.0
// Space is cut into cubes whose diagonal is the distance: points of one cube hang together by themselves, and only cubes, not
// points, need be joined (Gunawan, "A faster algorithm for DBSCAN", TU Eindhoven 2013, there in the plane). Links from a cube
// lead two cubes far at most.
#include "obstacles/clusters.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <numbers>
#include <numeric>
#include <span>
#include <utility>

#include "core/union_find.hpp"

namespace fransac::obstacles {
namespace {

using Points = std::span<Eigen::Vector3f>;
using Index = Eigen::Vector3i;  ///< Of a cube.

/// Occupied cubes by index: a hash table with open addressing.
class Cubes {
 public:
  static constexpr std::uint32_t kNone = 0xFFFFFFFF;

  explicit Cubes(std::size_t most) : slots_(std::bit_ceil(2 * most + 2), kNone) {}

  [[nodiscard]] std::size_t size() const { return indices_.size(); }
  [[nodiscard]] const Index& index(std::uint32_t cube) const { return indices_[cube]; }

  [[nodiscard]] std::uint32_t find(const Index& index) const { return slots_[slot(index)]; }

  std::uint32_t find_or_add(const Index& index) {
    std::uint32_t& found = slots_[slot(index)];
    if (found == kNone) {
      found = static_cast<std::uint32_t>(indices_.size());
      indices_.push_back(index);
    }
    return found;
  }

 private:
  /// Where the index is, or where it belongs.
  [[nodiscard]] std::size_t slot(const Index& index) const {
    // The finalizer of SplitMix64 (Steele, Lea and Flood, "Fast splittable pseudorandom number generators", OOPSLA 2014), once
    // after each coordinate.
    std::uint64_t hash = 0;
    for (const int coordinate : index) {
      hash ^= static_cast<std::uint32_t>(coordinate);
      hash = (hash ^ (hash >> 30)) * 0xBF58476D1CE4E5B9;
      hash = (hash ^ (hash >> 27)) * 0x94D049BB133111EB;
      hash ^= hash >> 31;
    }
    const std::size_t mask = slots_.size() - 1;
    std::size_t i = static_cast<std::size_t>(hash) & mask;
    while (slots_[i] != kNone && indices_[slots_[i]] != index) i = (i + 1) & mask;
    return i;
  }

  std::vector<std::uint32_t> slots_;
  std::vector<Index> indices_;
};

struct Box {
  Eigen::Vector3d low;
  Eigen::Vector3d high;

  explicit Box(Points points) : low(points.front().cast<double>()), high(low) {
    for (const Eigen::Vector3f& point : points) {
      low = low.cwiseMin(point.cast<double>());
      high = high.cwiseMax(point.cast<double>());
    }
  }
};

/// Whether a point of `a` is within a distance of one of `b`. Reorders both; neither is empty. Many points are halved until their
/// boxes tell, so that a hundred thousand points in two neighbouring cubes are not as many squared.
bool are_near(Points a, Points b, double squared) {
  constexpr std::size_t kFew = 64;  // pairs that cost no more than two boxes
  if (a.size() * b.size() <= kFew) {
    return std::any_of(a.begin(), a.end(), [&](const Eigen::Vector3f& p) {
      return std::any_of(b.begin(), b.end(), [&](const Eigen::Vector3f& q) {
        return (p.cast<double>() - q.cast<double>()).squaredNorm() <= squared;
      });
    });
  }
  const Box box_a(a);
  const Box box_b(b);
  const Eigen::Vector3d gap = (box_b.low - box_a.high).cwiseMax(box_a.low - box_b.high).cwiseMax(0.0);
  if (gap.squaredNorm() > squared) return false;
  const Eigen::Vector3d farthest = (box_b.high - box_a.low).cwiseMax(box_a.high - box_b.low);
  if (farthest.squaredNorm() <= squared) return true;
  const bool larger_is_a = (box_a.high - box_a.low).maxCoeff() >= (box_b.high - box_b.low).maxCoeff();
  const Box& box = larger_is_a ? box_a : box_b;
  const Points larger = larger_is_a ? a : b;
  const Points other = larger_is_a ? b : a;
  Eigen::Index axis = 0;
  (box.high - box.low).maxCoeff(&axis);
  // Half-way between two floats, in double: neither half is empty.
  const double middle = 0.5 * (box.low[axis] + box.high[axis]);
  const auto end = std::partition(larger.begin(), larger.end(),
                                  [&](const Eigen::Vector3f& p) { return static_cast<double>(p[axis]) <= middle; });
  const auto half = static_cast<std::size_t>(end - larger.begin());
  return are_near(larger.first(half), other, squared) || are_near(larger.subspan(half), other, squared);
}

/// The half of a cube's neighbours that comes after it in order of z, y, x, nearest first. Corners two cubes away are a whole
/// distance away.
std::vector<Index> neighbours() {
  std::vector<Index> offsets;
  for (int z = 0; z <= 2; ++z) {
    for (int y = -2; y <= 2; ++y) {
      for (int x = -2; x <= 2; ++x) {
        const bool after = z > 0 || y > 0 || (y == 0 && x > 0);
        const bool corner = std::abs(x) == 2 && std::abs(y) == 2 && z == 2;
        if (after && !corner) offsets.emplace_back(x, y, z);
      }
    }
  }
  std::stable_sort(offsets.begin(), offsets.end(),
                   [](const Index& a, const Index& b) { return a.squaredNorm() < b.squaredNorm(); });
  return offsets;
}

class Finder {
 public:
  Finder(const std::vector<Eigen::Vector3f>& points, double distance_m)
      : points_(points), squared_(distance_m * distance_m), cubes_(points.size()) {}

  Clusters run(const Eigen::Vector3d& low, double side) {
    sort_points(low, side);
    parent_.resize(cubes_.size());
    std::iota(parent_.begin(), parent_.end(), 0U);
    const std::vector<Index> offsets = neighbours();
    for (std::uint32_t cube = 0; cube < cubes_.size(); ++cube) {
      for (const Index& offset : offsets) join(cube, cubes_.find(cubes_.index(cube) + offset));
    }
    return number();
  }

 private:
  /// Tells each point's cube, and puts those of a cube side by side.
  void sort_points(const Eigen::Vector3d& low, double side) {
    cube_of_.resize(points_.size());
    std::vector<std::uint32_t> count;
    for (std::size_t i = 0; i < points_.size(); ++i) {
      const Index index = ((points_[i].cast<double>() - low) / side).array().floor().cast<int>();
      const bool same = i > 0 && index == cubes_.index(cube_of_[i - 1]);
      cube_of_[i] = same ? cube_of_[i - 1] : cubes_.find_or_add(index);
      count.resize(cubes_.size());
      ++count[cube_of_[i]];
    }
    begin_.assign(cubes_.size() + 1, 0);
    std::partial_sum(count.begin(), count.end(), begin_.begin() + 1);
    sorted_.resize(points_.size());
    for (std::size_t i = 0; i < points_.size(); ++i) sorted_[begin_[cube_of_[i] + 1] - count[cube_of_[i]]--] = points_[i];
  }

  void join(std::uint32_t a, std::uint32_t b) {
    if (b == Cubes::kNone) return;
    const std::uint32_t root_a = root(a);
    const std::uint32_t root_b = root(b);
    if (root_a != root_b && are_near(points_in(a), points_in(b), squared_)) join_roots(parent_.data(), root_a, root_b);
  }

  Points points_in(std::uint32_t cube) { return Points(sorted_).subspan(begin_[cube], begin_[cube + 1] - begin_[cube]); }

  std::uint32_t root(std::uint32_t cube) { return root_of(parent_.data(), cube); }

  /// Cubes are in the order of their first points, and a root is the first of its cubes.
  Clusters number() {
    Clusters clusters;
    std::vector<std::uint32_t> number_of(cubes_.size());
    for (std::uint32_t cube = 0; cube < cubes_.size(); ++cube) {
      const std::uint32_t first = root(cube);
      number_of[cube] = first == cube ? clusters.count++ : number_of[first];
    }
    clusters.of_point = std::move(cube_of_);
    for (std::uint32_t& of : clusters.of_point) of = number_of[of];
    return clusters;
  }

  const std::vector<Eigen::Vector3f>& points_;
  double squared_;
  Cubes cubes_;
  std::vector<std::uint32_t> cube_of_;
  std::vector<std::uint32_t> begin_;  ///< In `sorted_`, by cube; and the end.
  std::vector<Eigen::Vector3f> sorted_;
  std::vector<std::uint32_t> parent_;
};

}  // namespace

Result<Clusters> find_clusters(const std::vector<Eigen::Vector3f>& points, double distance_m) {
  if (points.empty()) return Clusters{};
  Eigen::Vector3d low = points.front().cast<double>();
  Eigen::Vector3d high = low;
  for (const Eigen::Vector3f& point : points) {
    low = low.cwiseMin(point.cast<double>());
    high = high.cwiseMax(point.cast<double>());
  }
  const double side = distance_m * std::numbers::inv_sqrt3;
  constexpr double kMostCubes = 0x1p31 - 4.0;  // along an axis, with neighbours
  if (!((high - low).maxCoeff() / side < kMostCubes)) {
    return Error{ErrorCode::invalid_argument, "cluster-distance is too small for the cloud's extent; take a larger one"};
  }
  return Finder(points, distance_m).run(low, side);
}

}  // namespace fransac::obstacles
