// SPDX-License-Identifier: Apache-2.0
#include "fransac/planes/orientation.hpp"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <numbers>
#include <optional>

#include "fransac/core/labels.hpp"
#include "fransac/core/point_cloud.hpp"
#include "fransac/planes/segment.hpp"

namespace fransac {
namespace {

constexpr double kDegree = std::numbers::pi / 180.0;

// How far from each other two planes' ideas of up may be that agree: both planes' errors, but no unknown up's. Boards lean on
// walls at more.
constexpr double kAgreement = 5.0 * kDegree;

double squared(double value) { return value * value; }

bool is_level(const Eigen::Vector3d& normal, const Eigen::Vector3d& up) {
  static const double cosine = std::cos(kLevel_rad);
  return std::abs(normal.dot(up)) >= cosine;
}
bool is_vertical(const Eigen::Vector3d& normal, const Eigen::Vector3d& up) {
  static const double sine = std::sin(kLevel_rad);
  return std::abs(normal.dot(up)) <= sine;
}

// How cameras are held: at 15 degrees of pitch (down is positive) with a deviation of 25: hand-held and robot cameras look
// ahead or at what is before them, up to 50 degrees down. To the side the deviation is 10 degrees.
constexpr double kPitch = 15.0 * kDegree;
constexpr double kPitchDeviation = 25.0 * kDegree;
constexpr double kSideDeviation = 10.0 * kDegree;

// How often a camera is turned by a quarter, to each side: hardly ever, but for images that are higher than wide, whose sensor is
// as wide as others and was turned, unless the image was turned back.
constexpr double kTurned = 0.01;
constexpr double kTurnedPortrait = 0.3;

// How many level planes that face down, ceilings mostly, are seen for one that faces up: floors, tables, seats.
constexpr double kFacesDown = 1.0 / 3.0;

// How far off level and vertical things are in a room, one sigma.
constexpr double kBuilt = 1.0 * kDegree;

/// The density of up directions of a camera that is not turned, 1 at its peak.
double density_upright(const Eigen::Vector3d& up) {
  const double pitch = std::atan2(-up.z(), -up.y());
  const double side = std::asin(std::clamp(up.x(), -1.0, 1.0));
  return std::exp(-0.5 * (squared((pitch - kPitch) / kPitchDeviation) + squared(side / kSideDeviation)));
}

/// `v` as it is in an image turned by a quarter, clockwise or (-1) not.
Eigen::Vector3d turned(const Eigen::Vector3d& v, int sense) { return {-sense * v.y(), sense * v.x(), v.z()}; }

/// The logarithm of the density of up directions.
double log_prior(const Eigen::Vector3d& up, double share_turned) {
  const double density = (1.0 - 2.0 * share_turned) * density_upright(up) +
                         share_turned * (density_upright(turned(up, 1)) + density_upright(turned(up, -1)));
  return std::log(std::max(density, std::numeric_limits<double>::min()));
}

/// Planes as evidence for an up direction. Needs no memory but its own.
class UpVote {
 public:
  UpVote(std::span<const PlaneSegment> planes, bool portrait) : share_turned_(portrait ? kTurnedPortrait : kTurned) {
    double squared_weight = 0.0;
    for (const PlaneSegment& segment : planes.first(std::min(planes.size(), planes_.size()))) {
      if (!(segment.area_m2 > 0.0) || !std::isfinite(segment.area_m2) || !segment.plane.normal.allFinite()) continue;
      const double weight = segment.confidence * std::sqrt(segment.area_m2);
      if (!(weight > 0.0)) continue;
      planes_[size_++] = evidence_of(segment, weight);
      squared_weight += squared(weight);
    }
    for (std::size_t i = 0; i < size_; ++i) planes_[i].weight /= std::sqrt(squared_weight);
    std::sort(planes_.begin(), planes_.begin() + size_, [](const Evidence& a, const Evidence& b) { return a.weight > b.weight; });
  }

  [[nodiscard]] std::optional<UpEstimate> winner() {
    find_candidates();
    const auto best = std::max_element(candidates_.begin(), candidates_.begin() + found_,
                                       [](const Candidate& a, const Candidate& b) { return a.score < b.score; });
    if (found_ == 0) return std::nullopt;
    const std::optional<UpEstimate> up = refined(best->up);
    if (!up) return std::nullopt;
    const double to_beat = std::max(best->score, score(up->direction)) - kMinLogOdds;
    const double near = std::cos(2.0 * kAgreement);  // nearer ones share their planes
    const bool doubtful = std::any_of(candidates_.begin(), candidates_.begin() + found_, [&](const Candidate& rival) {
      return rival.score > to_beat && rival.up.dot(up->direction) < near;
    });
    return doubtful ? std::nullopt : up;
  }

 private:
  // Odds of 3 are the least that count as evidence (Kass & Raftery, Bayes factors, 1995, section 3.2).
  static constexpr double kMinLogOdds = 1.0986;
  // Directions come from the planes that weigh most; more of them would take longer and find no other winner.
  static constexpr std::size_t kLeaders = 8;
  // Worse than by this, one sigma, the planes leave a direction open.
  static constexpr double kMaxSigma = 5.0 * kDegree;

  struct Evidence {
    Eigen::Vector3d normal;
    double weight;         ///< Confidence times the square root of the area; scaled so that the sum of the squares is 1.
    double squared_sine;   ///< Of the angle to up, or to the horizontal, at which the plane no longer agrees.
    double level_gain;     ///< The logarithm of one over the share of all directions that are level to within that, and
    double vertical_gain;  ///< vertical.
    double information;    ///< One over the variance of the normal's angle to what it was built to be.
  };
  struct Candidate {
    Eigen::Vector3d up;
    double score;
  };

  static Evidence evidence_of(const PlaneSegment& segment, double weight) {
    constexpr double kMostAgreement = 45.0 * kDegree;
    const double sigma = normal_sigma_rad(segment);
    const double agreement = std::min(std::hypot(kAgreement, 2.0 * sigma), kMostAgreement);
    return {segment.plane.normal,           weight,
            squared(std::sin(agreement)),   -std::log(1.0 - std::cos(agreement)),
            -std::log(std::sin(agreement)), 1.0 / (squared(kBuilt) + squared(sigma))};
  }

  void add(const Eigen::Vector3d& up) { candidates_[found_++] = {up, score(up)}; }

  /// Up is a normal or its opposite, at right angles to two normals, or, if all planes but one mean nothing and that is a
  /// wall, where it is expected most among the directions at right angles to it, whichever way the camera is turned.
  void find_candidates() {
    const Eigen::Vector3d expected(0.0, -std::cos(kPitch), -std::sin(kPitch));
    for (std::size_t i = 0; i < std::min(size_, kLeaders); ++i) {
      const Eigen::Vector3d& normal = planes_[i].normal;
      add(normal);
      add(-normal);
      for (const Eigen::Vector3d& held : {expected, turned(expected, 1), turned(expected, -1)}) {
        if (const Eigen::Vector3d up = held - normal * normal.dot(held); up.norm() > 1e-6) add(up.normalized());
      }
      for (std::size_t j = 0; j < i; ++j) {
        const Eigen::Vector3d up = normal.cross(planes_[j].normal);
        if (up.norm() < std::sin(kAgreement)) continue;  // the same wall twice
        add(up.normalized());
        add(-up.normalized());
      }
    }
  }

  /// How well a plane agrees that this is up, as the better of level and vertical: from 0 to 1.
  struct Agreement {
    bool level;
    double fit;
  };
  static Agreement agreement(const Evidence& plane, const Eigen::Vector3d& up) {
    const double squared_cosine = squared(plane.normal.dot(up));
    const bool level = squared_cosine > 0.5;
    return {level, std::max(0.0, 1.0 - (level ? 1.0 - squared_cosine : squared_cosine) / plane.squared_sine)};
  }

  /// The logarithm of how much likelier a plane is than one of any direction; 0 without agreement.
  static double gain(const Evidence& plane, const Eigen::Vector3d& up) {
    static const double faces_down = std::log(kFacesDown);
    const auto [level, fit] = agreement(plane, up);
    if (!level) return fit * plane.vertical_gain;
    return fit * (plane.level_gain + (plane.normal.dot(up) > 0.0 ? 0.0 : faces_down));
  }

  /// The logarithm of how much likelier the planes and this up direction are together than planes of any direction.
  [[nodiscard]] double score(const Eigen::Vector3d& up) const {
    double sum = log_prior(up, share_turned_);
    for (std::size_t i = 0; i < size_; ++i) sum += planes_[i].weight * gain(planes_[i], up);
    return sum;
  }

  /// Least squares over the planes that agree: minimises the sum of w sin^2 of the level ones' angles to up and of the vertical
  /// ones' angles to the horizontal, w their information, in full for the plane that weighs most. Nothing when they leave a
  /// direction open.
  [[nodiscard]] std::optional<UpEstimate> refined(Eigen::Vector3d up) const {
    constexpr int kRounds = 3;  // which planes agree hardly changes after the first
    double sigma_rad = 0.0;
    for (int round = 0; round < kRounds; ++round) {
      Eigen::Matrix3d sum = Eigen::Matrix3d::Zero();
      for (std::size_t i = 0; i < size_; ++i) {
        const Eigen::Vector3d& normal = planes_[i].normal;
        const auto [level, fit] = agreement(planes_[i], up);
        const double weight = planes_[i].weight / planes_[0].weight * fit * planes_[i].information;
        const Eigen::Matrix3d outer = normal * normal.transpose();
        sum += weight * (level ? Eigen::Matrix3d(Eigen::Matrix3d::Identity() - outer) : outer);
      }
      const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(sum);
      // What is left of the smallest eigenvalue is the planes' disagreement, and holds no direction.
      sigma_rad = 1.0 / std::sqrt(std::max(solver.eigenvalues()[1] - solver.eigenvalues()[0], 1.0));
      if (!(sigma_rad <= kMaxSigma)) return std::nullopt;
      const Eigen::Vector3d axis = solver.eigenvectors().col(0);
      up = axis.dot(up) < 0.0 ? Eigen::Vector3d(-axis) : axis;
    }
    return UpEstimate{up, sigma_rad};
  }

  double share_turned_;
  std::array<Evidence, kMaxPlanes> planes_;  ///< Those that weigh most first.
  std::size_t size_ = 0;
  std::array<Candidate, kLeaders*(kLeaders + 4)> candidates_;  ///< 5 a plane and 2 a pair.
  std::size_t found_ = 0;
};

/// Which of a scene's planes are floor, ceiling and level.
class Scene {
 public:
  Scene(const Eigen::Vector3d& up, const std::optional<Eigen::Vector3d>& sensor, std::span<PlaneSegment> planes)
      : up_(up), sensor_(sensor), planes_(planes) {}

  /// `is_edge` tells of a plane and a direction along up whether the rest of the scene lets the plane be the last one that way.
  template <class IsEdge>
  void mark(const IsEdge& is_edge) {
    for (PlaneSegment& segment : planes_) {
      const Eigen::Vector3d& normal = segment.plane.normal;
      segment.kind = is_level(normal, up_)      ? PlaneKind::horizontal
                     : is_vertical(normal, up_) ? PlaneKind::wall
                                                : PlaneKind::other;
    }
    mark_last(-1.0, PlaneKind::floor, is_edge);
    mark_last(1.0, PlaneKind::ceiling, is_edge);
  }

 private:
  [[nodiscard]] double height(const PlaneSegment& segment) const {
    return height_along(up_, segment) - (sensor_ ? up_.dot(*sensor_) : 0.0);
  }

  /// Whether the plane is seen from the other side than `direction` leads to; without a sensor, whether it can be.
  [[nodiscard]] bool is_seen(const PlaneSegment& segment, double direction) const {
    // No camera rides lower; a plane that is seen edge-on is at any height.
    constexpr double kMinHeight_m = 0.05;
    if (segment.kind != PlaneKind::horizontal) return false;
    if (!sensor_) return true;
    const double side = segment.plane.normal.dot(up_) > 0.0 ? -direction : direction;
    return side * segment.plane.signed_distance(*sensor_) > kMinHeight_m;
  }

  /// Makes the last of the level planes in a direction along up (-1: the lowest) `kind`, with those at its level, unless
  /// something is seen beyond it.
  template <class IsEdge>
  void mark_last(double direction, PlaneKind kind, const IsEdge& is_edge) {
    // Half of the lowest stair there is, 10 cm: what differs by less is one floor, with carpets, sills and noise.
    constexpr double kSameLevel_m = 0.05;
    // Smaller ones do not count: reflections in the floor are below it.
    constexpr double kMinAreaShare = 0.1;
    const auto place = [&](const PlaneSegment& segment) { return direction * height(segment); };
    double largest = 0.0;
    for (const PlaneSegment& segment : planes_) {
      if (is_seen(segment, direction)) largest = std::max(largest, segment.area_m2);
    }
    const PlaneSegment* last = nullptr;
    for (const PlaneSegment& segment : planes_) {
      if (!is_seen(segment, direction) || segment.area_m2 < kMinAreaShare * largest) continue;
      if (last == nullptr || place(segment) > place(*last)) last = &segment;
    }
    if (last == nullptr) return;
    const double level = place(*last);
    const double area = last->area_m2;
    const auto is_beyond = [&](const PlaneSegment& segment) {
      return !is_seen(segment, direction) && !segment.centroid.isZero(0.0) && segment.area_m2 >= kMinAreaShare * area &&
             place(segment) > level + kSameLevel_m;
    };
    if (std::any_of(planes_.begin(), planes_.end(), is_beyond)) return;
    if (!is_edge(*last, direction)) return;
    for (PlaneSegment& segment : planes_) {
      if (is_seen(segment, direction) && std::abs(place(segment) - level) <= kSameLevel_m) segment.kind = kind;
    }
  }

  const Eigen::Vector3d& up_;
  std::optional<Eigen::Vector3d> sensor_;
  std::span<PlaneSegment> planes_;
};

/// A cloud's points along up.
class Heights {
 public:
  Heights(const Eigen::Vector3d& up, const PointCloud& cloud, std::span<const std::uint8_t> labels)
      : up_(up), cloud_(cloud), labels_(labels) {}

  /// Whether the points let a plane be the floor (`direction` -1) or the ceiling: few lie beyond it.
  [[nodiscard]] bool is_edge(const PlaneSegment& plane, double direction) const {
    constexpr double kMargin_m = 0.05;   // as for planes at one level
    constexpr double kMostBeyond = 0.1;  // of the plane's own points: what is seen through windows and in mirrors, or is noise
    std::uint64_t beyond = 0;
    std::uint64_t before = 0;
    for_each([&](double height) {
      const double past = direction * (height - up_.dot(plane.centroid));
      if (past > kMargin_m) ++beyond;
      if (past < -kMargin_m) ++before;
    });
    return beyond <= before || static_cast<double>(beyond) <= kMostBeyond * static_cast<double>(plane.inliers);
  }

  /// Whether there is a room's height between a plane and the lowest points.
  [[nodiscard]] bool is_overhead(const PlaneSegment& plane) const {
    constexpr double kRoom_m = 2.0;   // few rooms are lower, hardly any furniture is higher
    constexpr double kFewest = 0.01;  // of all points: fewer are stray
    std::uint64_t low = 0;
    std::uint64_t all = 0;
    for_each([&](double height) {
      ++all;
      if (height < up_.dot(plane.centroid) - kRoom_m) ++low;
    });
    return static_cast<double>(low) >= kFewest * static_cast<double>(all);
  }

 private:
  template <class Visit>
  void for_each(const Visit& visit) const {
    for (std::size_t i = 0; i < cloud_.size(); ++i) {
      if (labels_[i] != kLabelNoDepth) visit(up_.dot(cloud_.point(i)));
    }
  }

  const Eigen::Vector3d& up_;
  const PointCloud& cloud_;
  std::span<const std::uint8_t> labels_;
};

}  // namespace

std::optional<UpEstimate> estimate_up(std::span<const PlaneSegment> planes, bool portrait) {
  return UpVote(planes, portrait).winner();
}

double normal_sigma_rad(const PlaneSegment& plane) {
  return std::sqrt(std::max(0.0, plane.covariance.topLeftCorner<3, 3>().trace()));
}

double height_along(const Eigen::Vector3d& up, const PlaneSegment& plane) {
  const Eigen::Vector3d foot = -plane.plane.d * plane.plane.normal;
  return up.dot(plane.centroid.isZero(0.0) ? foot : plane.centroid);
}

void classify(const Eigen::Vector3d& up, std::span<PlaneSegment> planes, const Eigen::Vector3d& sensor) {
  Scene(up, sensor, planes).mark([](const PlaneSegment&, double) { return true; });
}

void classify(const Eigen::Vector3d& up, const PointCloud& cloud, std::span<const std::uint8_t> labels,
              const std::optional<Eigen::Vector3d>& sensor, std::span<PlaneSegment> planes) {
  const Heights heights(up, cloud, labels);
  Scene(up, sensor, planes).mark([&](const PlaneSegment& plane, double direction) {
    return heights.is_edge(plane, direction) && (sensor || direction < 0.0 || heights.is_overhead(plane));
  });
}

}  // namespace fransac
