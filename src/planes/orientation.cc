// SPDX-License-Identifier: Apache-2.0
#include "fransac/planes/orientation.hpp"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <optional>

#include "fransac/planes/segment.hpp"

namespace fransac {
namespace {

constexpr double kDegree = std::numbers::pi / 180.0;

// How far from level or vertical a plane may be found that is: an up direction off by 3 degrees, a small plane off by 3, a
// ramp, which is a floor to who uses it, up to 1 : 12 or 5 degrees. Roofs, leaning boards and screens begin beyond it.
constexpr double kTolerance = 10.0 * kDegree;

// How far from each other two planes' ideas of up may be that agree: both planes' errors, but no unknown up's. Boards lean on
// walls at more.
constexpr double kAgreement = 5.0 * kDegree;

double squared(double value) { return value * value; }

bool is_level(const Eigen::Vector3d& normal, const Eigen::Vector3d& up) {
  static const double cosine = std::cos(kTolerance);
  return std::abs(normal.dot(up)) >= cosine;
}
bool is_vertical(const Eigen::Vector3d& normal, const Eigen::Vector3d& up) {
  static const double sine = std::sin(kTolerance);
  return std::abs(normal.dot(up)) <= sine;
}

// How cameras are held: at 15 degrees of pitch (down is positive) with a deviation of 25: hand-held and robot cameras look
// ahead or at what is before them, up to 50 degrees down. To the side the deviation is 10 degrees.
constexpr double kPitch = 15.0 * kDegree;
constexpr double kPitchDeviation = 25.0 * kDegree;
constexpr double kSideDeviation = 10.0 * kDegree;

/// The logarithm of the density of up directions, 0 at its peak.
double log_prior(const Eigen::Vector3d& up) {
  const double pitch = std::atan2(-up.z(), -up.y());
  const double side = std::asin(std::clamp(up.x(), -1.0, 1.0));
  return -0.5 * (squared((pitch - kPitch) / kPitchDeviation) + squared(side / kSideDeviation));
}

/// Planes as evidence for an up direction. Needs no memory but its own.
class UpVote {
 public:
  explicit UpVote(std::span<const PlaneSegment> planes) {
    double area = 0.0;
    double squared_area = 0.0;
    for (const PlaneSegment& segment : planes.first(std::min(planes.size(), planes_.size()))) {
      if (!(segment.area_m2 > 0.0) || !std::isfinite(segment.area_m2) || !segment.plane.normal.allFinite()) continue;
      planes_[size_++] = {segment.plane.normal, segment.area_m2};
      area += segment.area_m2;
      squared_area += squared(segment.area_m2);
    }
    for (std::size_t i = 0; i < size_; ++i) planes_[i].weight *= area / squared_area;
    std::sort(planes_.begin(), planes_.begin() + size_, [](const Evidence& a, const Evidence& b) { return a.weight > b.weight; });
  }

  [[nodiscard]] std::optional<Eigen::Vector3d> winner() {
    find_candidates();
    const auto best = std::max_element(candidates_.begin(), candidates_.begin() + found_,
                                       [](const Candidate& a, const Candidate& b) { return a.score < b.score; });
    if (found_ == 0) return std::nullopt;
    const std::optional<Eigen::Vector3d> up = refined(best->up);
    if (!up) return std::nullopt;
    const double to_beat = std::max(best->score, score(*up)) - kMinLogOdds;
    const double near = std::cos(2.0 * kAgreement);  // nearer ones share their planes
    const bool doubtful = std::any_of(candidates_.begin(), candidates_.begin() + found_,
                                      [&](const Candidate& rival) { return rival.score > to_beat && rival.up.dot(*up) < near; });
    return doubtful ? std::nullopt : up;
  }

 private:
  // Odds of 3 are the least that count as evidence (Kass & Raftery, Bayes factors, 1995, section 3.2).
  static constexpr double kMinLogOdds = 1.0986;
  // Directions come from the largest planes; more of them would take longer and find no other winner.
  static constexpr std::size_t kLeaders = 8;
  // The least share of the evidence that must hold up in every direction.
  static constexpr double kMinHold = 0.05;

  struct Evidence {
    Eigen::Vector3d normal;
    double weight;  ///< Square metres, scaled so that the sum is n where n planes share the area equally.
  };
  struct Candidate {
    Eigen::Vector3d up;
    double score;
  };

  void add(const Eigen::Vector3d& up) { candidates_[found_++] = {up, score(up)}; }

  /// Up is a normal or its opposite, at right angles to two normals, or, if all planes but one mean nothing and that is a
  /// wall, where it is expected most among the directions at right angles to it.
  void find_candidates() {
    const Eigen::Vector3d expected(0.0, -std::cos(kPitch), -std::sin(kPitch));
    for (std::size_t i = 0; i < std::min(size_, kLeaders); ++i) {
      const Eigen::Vector3d& normal = planes_[i].normal;
      add(normal);
      add(-normal);
      if (const Eigen::Vector3d up = expected - normal * normal.dot(expected); up.norm() > 1e-6) add(up.normalized());
      for (std::size_t j = 0; j < i; ++j) {
        const Eigen::Vector3d up = normal.cross(planes_[j].normal);
        if (up.norm() < std::sin(kAgreement)) continue;  // the same wall twice
        add(up.normalized());
        add(-up.normalized());
      }
    }
  }

  /// How well a plane agrees that this is up, as the better of level and vertical.
  struct Agreement {
    bool level;
    double gain;  ///< The logarithm of how much likelier the plane is than one of any direction; 0 without agreement.
  };
  static Agreement agreement(const Eigen::Vector3d& normal, const Eigen::Vector3d& up) {
    // One over the share of all directions that are level, or vertical, to within the angle.
    static const double level_gain = -std::log(1.0 - std::cos(kAgreement));
    static const double vertical_gain = -std::log(std::sin(kAgreement));
    static const double squared_sine = squared(std::sin(kAgreement));
    const double squared_cosine = squared(normal.dot(up));
    const bool level = squared_cosine > 0.5;
    const double fit = std::max(0.0, 1.0 - (level ? 1.0 - squared_cosine : squared_cosine) / squared_sine);
    return {level, fit * (level ? level_gain : vertical_gain)};
  }

  /// The logarithm of how much likelier the planes and this up direction are together than planes of any direction.
  [[nodiscard]] double score(const Eigen::Vector3d& up) const {
    double sum = log_prior(up);
    for (std::size_t i = 0; i < size_; ++i) sum += planes_[i].weight * agreement(planes_[i].normal, up).gain;
    return sum;
  }

  /// Least squares over the planes that agree, with what their agreement is worth as weight: minimises the sum of w sin^2 of
  /// the level ones' angles to up and of the vertical ones' angles to the horizontal. Nothing when they leave a direction open.
  [[nodiscard]] std::optional<Eigen::Vector3d> refined(Eigen::Vector3d up) const {
    constexpr int kRounds = 3;  // which planes agree hardly changes after the first
    for (int round = 0; round < kRounds; ++round) {
      Eigen::Matrix3d sum = Eigen::Matrix3d::Zero();
      double total = 0.0;
      for (std::size_t i = 0; i < size_; ++i) {
        const Eigen::Vector3d& normal = planes_[i].normal;
        const auto [level, gain] = agreement(normal, up);
        const double weight = planes_[i].weight * gain;
        const Eigen::Matrix3d outer = normal * normal.transpose();
        sum += weight * (level ? Eigen::Matrix3d(Eigen::Matrix3d::Identity() - outer) : outer);
        total += weight;
      }
      const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(sum);
      if (!(solver.eigenvalues()[1] > kMinHold * total)) return std::nullopt;
      const Eigen::Vector3d axis = solver.eigenvectors().col(0);
      up = axis.dot(up) < 0.0 ? Eigen::Vector3d(-axis) : axis;
    }
    return up;
  }

  std::array<Evidence, kMaxPlanes> planes_;  ///< Largest first.
  std::size_t size_ = 0;
  std::array<Candidate, kLeaders*(kLeaders + 2)> candidates_;  ///< 3 a plane and 2 a pair.
  std::size_t found_ = 0;
};

/// How far a plane's visible part lies above the camera, where known; else the plane's nearest point.
double height_of(const PlaneSegment& segment, const Eigen::Vector3d& up) {
  const Eigen::Vector3d foot = -segment.plane.d * segment.plane.normal;
  return up.dot(segment.centroid.isZero(0.0) ? foot : segment.centroid);
}

/// Makes the lowest of the horizontal planes below the camera `kind`, unless something is seen lower. With `up` upside down it
/// is the highest above.
void mark_lowest(const Eigen::Vector3d& up, PlaneKind kind, std::span<PlaneSegment> planes) {
  // Half of the lowest stair there is, 10 cm: what differs by less is one floor, with carpets, sills and noise.
  constexpr double kSameLevel_m = 0.05;
  // No camera rides lower; a plane that is seen edge-on is at any height.
  constexpr double kMinHeight_m = 0.05;
  // Smaller ones do not count: reflections in the floor are below it.
  constexpr double kMinAreaShare = 0.1;
  const auto faces_up = [&](const PlaneSegment& segment) {
    return segment.kind == PlaneKind::horizontal && segment.plane.normal.dot(up) > 0.0 && segment.plane.d > kMinHeight_m;
  };
  double largest = 0.0;
  for (const PlaneSegment& segment : planes) {
    if (faces_up(segment)) largest = std::max(largest, segment.area_m2);
  }
  const PlaneSegment* lowest = nullptr;
  for (const PlaneSegment& segment : planes) {
    if (!faces_up(segment) || segment.area_m2 < kMinAreaShare * largest) continue;
    if (lowest == nullptr || height_of(segment, up) < height_of(*lowest, up)) lowest = &segment;
  }
  if (lowest == nullptr) return;
  const double level = height_of(*lowest, up);
  const double area = lowest->area_m2;
  const auto is_lower = [&](const PlaneSegment& segment) {
    return !faces_up(segment) && !segment.centroid.isZero(0.0) && segment.area_m2 >= kMinAreaShare * area &&
           height_of(segment, up) < level - kSameLevel_m;
  };
  if (std::any_of(planes.begin(), planes.end(), is_lower)) return;
  for (PlaneSegment& segment : planes) {
    if (faces_up(segment) && std::abs(height_of(segment, up) - level) <= kSameLevel_m) segment.kind = kind;
  }
}

}  // namespace

std::optional<Eigen::Vector3d> estimate_up(std::span<const PlaneSegment> planes) { return UpVote(planes).winner(); }

void classify(const Eigen::Vector3d& up, std::span<PlaneSegment> planes) {
  for (PlaneSegment& segment : planes) {
    const Eigen::Vector3d& normal = segment.plane.normal;
    segment.kind = is_level(normal, up) ? PlaneKind::horizontal : is_vertical(normal, up) ? PlaneKind::wall : PlaneKind::other;
  }
  mark_lowest(up, PlaneKind::floor, planes);
  mark_lowest(-up, PlaneKind::ceiling, planes);
}

}  // namespace fransac
