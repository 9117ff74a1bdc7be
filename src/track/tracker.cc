// SPDX-License-Identifier: Apache-2.0
#include "fransac/track/tracker.hpp"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>

#include "core/caught.hpp"
#include "core/index.hpp"
#include "planes/range_check.hpp"

namespace fransac {
namespace {

using Matrix3 = Eigen::Matrix3d;
using Vector6 = Eigen::Matrix<double, 6, 1>;
using Matrix6 = Eigen::Matrix<double, 6, 6>;

double radians(double degrees) { return degrees * std::numbers::pi / 180.0; }

/// A plane with an orientation of its own: not the canonical sign, which changes when the camera goes through it.
struct OrientedPlane {
  Eigen::Vector3d normal;
  double d;
};

OrientedPlane transformed(const OrientedPlane& plane, const Eigen::Isometry3d& T) {
  const Eigen::Vector3d normal = T.linear() * plane.normal;
  return {normal, plane.d - normal.dot(T.translation())};
}

/// The same plane with its normal on the side of another.
OrientedPlane turned_to(const Eigen::Vector3d& side, const OrientedPlane& plane) {
  return plane.normal.dot(side) < 0.0 ? OrientedPlane{-plane.normal, -plane.d} : plane;
}

/// Two directions across a normal: where it can go.
Eigen::Matrix<double, 3, 2> tangents(const Eigen::Vector3d& normal) {
  Eigen::Matrix<double, 3, 2> basis;
  basis.col(0) = normal.unitOrthogonal();
  basis.col(1) = normal.cross(basis.col(0));
  return basis;
}

/// How much (normal, d) changes with the two angles of the normal and d: 4 x 3.
Eigen::Matrix<double, 4, 3> chart(const Eigen::Vector3d& normal) {
  Eigen::Matrix<double, 4, 3> map = Eigen::Matrix<double, 4, 3>::Zero();
  map.topLeftCorner<3, 2>() = tangents(normal);
  map(3, 2) = 1.0;
  return map;
}

/// The difference of two planes in the chart of the first.
Eigen::Vector3d difference(const OrientedPlane& from, const OrientedPlane& to) {
  Eigen::Vector3d result;
  result.head<2>() = tangents(from.normal).transpose() * to.normal;
  result[2] = to.d - from.d;
  return result;
}

OrientedPlane moved(const OrientedPlane& plane, const Eigen::Vector3d& by) {
  return {(plane.normal + tangents(plane.normal) * by.head<2>()).normalized(), plane.d + by[2]};
}

/// A covariance of (normal, d) in the chart of its plane.
Matrix3 in_chart(const Eigen::Vector3d& normal, const Eigen::Matrix4d& covariance) {
  const Eigen::Matrix<double, 4, 3> map = chart(normal);
  return map.transpose() * covariance * map;
}

Eigen::Matrix4d transformed(const Eigen::Matrix4d& covariance, const Eigen::Vector3d& new_normal, const Eigen::Isometry3d& T) {
  // n' = R n, d' = d - n' . t
  Eigen::Matrix4d map = Eigen::Matrix4d::Identity();
  map.topLeftCorner<3, 3>() = T.linear();
  map.block<1, 3>(3, 0) = -T.translation().transpose() * T.linear();
  Eigen::Matrix4d result = map * covariance * map.transpose();
  // Errors of the normal's length are none.
  Eigen::Matrix4d keep = Eigen::Matrix4d::Identity();
  keep.topLeftCorner<3, 3>() -= new_normal * new_normal.transpose();
  return keep * result * keep.transpose();
}

Eigen::Isometry3d step(const Vector6& twist) {
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  const Eigen::Vector3d turn = twist.head<3>();
  if (turn.norm() > 0.0) T.linear() = Eigen::AngleAxisd(turn.norm(), turn.normalized()).toRotationMatrix();
  T.translation() = twist.tail<3>();
  return T;
}

/// How a plane, in the chart of `normal`, changes with a small turn w and step t of the camera in the world: (n, d) goes to
/// (n + w x n, d - n . t).
Eigen::Matrix<double, 3, 6> motion_jacobian(const Eigen::Vector3d& normal, const OrientedPlane& plane) {
  const Eigen::Matrix<double, 3, 2> basis = tangents(normal);
  Eigen::Matrix<double, 3, 6> jacobian = Eigen::Matrix<double, 3, 6>::Zero();
  for (int axis = 0; axis < 3; ++axis) {
    jacobian.block<2, 1>(0, axis) = basis.transpose() * Eigen::Vector3d::Unit(axis).cross(plane.normal);
  }
  jacobian.block<1, 3>(2, 3) = -plane.normal.transpose();
  return jacobian;
}

/// Something that is followed.
struct PlaneTrack {
  int id;
  OrientedPlane plane;       ///< In the world.
  Matrix3 covariance;        ///< In its chart.
  Eigen::Vector3d centroid;  ///< Of what was seen last, in the world.
  double reach_m;            ///< Radius of a disc of its area.
  int age = 1;
  int gap = 0;  ///< Frames since it was seen.
};

struct ObjectTrack {
  int id;
  Eigen::Vector3d centre;  ///< In the world.
  Eigen::Vector3d size;
  int age = 1;
  int gap = 0;
};

struct Pair {
  int track;
  int measured;
  double cost;
};

/// What was where in the last frame, at some pixels, and how much what is there now covers of it. Between two frames most things
/// move by less than their size.
class Sightings {
 public:
  /// The labels of a frame, 1 to `most`, at a pixel of every few; anything else is nothing. Call before overlap().
  template <class Label>
  void look(const std::vector<Label>& labels, int width, int height, int most) {
    const bool same = width == width_ && height == height_;
    width_ = width;
    height_ = height;
    constexpr int kAcross = 80;
    const int step = std::max(1, std::max(width, height) / kAcross);
    now_.clear();
    for (int v = step / 2; v < height; v += step) {
      for (int u = step / 2; u < width; u += step) {
        const int label = labels[at(v) * at(width) + at(u)];
        now_.push_back(label <= most ? label : 0);
      }
    }
    most_ = most;
    if (!same) before_.assign(now_.size(), 0);
  }

  /// Shares of (known thing, label), its union as 1: row by row of the known, whose ids are `ids`, in rising order.
  void compare(const std::vector<int>& ids) {
    share_.assign(ids.size() * at(most_ + 1), 0.0);
    std::vector<double> of_known(ids.size(), 0.0);
    std::vector<double> of_label(at(most_ + 1), 0.0);
    for (std::size_t i = 0; i < now_.size(); ++i) {
      of_label[at(now_[i])] += 1.0;
      if (before_[i] == 0) continue;
      const auto known = std::lower_bound(ids.begin(), ids.end(), before_[i]);
      if (known == ids.end() || *known != before_[i]) continue;
      const auto k = static_cast<std::size_t>(known - ids.begin());
      of_known[k] += 1.0;
      share_[k * at(most_ + 1) + at(now_[i])] += 1.0;
    }
    for (std::size_t k = 0; k < ids.size(); ++k) {
      for (int label = 1; label <= most_; ++label) {
        double& share = share_[k * at(most_ + 1) + at(label)];
        if (share > 0.0) share /= of_known[k] + of_label[at(label)] - share;
      }
    }
  }
  [[nodiscard]] double overlap(std::size_t known, int label) const { return share_[known * at(most_ + 1) + at(label)]; }

  /// `id_of_label[label]` is what the labels were.
  void remember(const std::vector<int>& id_of_label) {
    before_.resize(now_.size());
    std::transform(now_.begin(), now_.end(), before_.begin(), [&](int label) { return label == 0 ? 0 : id_of_label[at(label)]; });
  }

 private:
  int width_ = 0;
  int height_ = 0;
  int most_ = 0;
  std::vector<int> before_;
  std::vector<int> now_;
  std::vector<double> share_;
};

/// Things that cover each other by this much from one frame to the next are the same if their measures are only near.
constexpr double kCovers = 0.5;
/// However uncertain a plane is, one that is turned by more than twenty degrees is another.
constexpr double kMostTurn_rad = 0.35;
/// What no overlap at all costs, against squared sigmas.
constexpr double kNoOverlap = 9.0;

/// Exact planes have covariances without an inverse: 1e-7 radians and metres are nothing.
constexpr double kLeastVariance = 1e-14;

/// Squared angle that a normal is uncertain by.
double spread(const Matrix3& covariance) { return covariance.topLeftCorner<2, 2>().trace(); }

/// The cheapest pairs first, each side once. Costs that are no numbers, of things beyond all measure, are none.
template <class Take>
void match(std::vector<Pair>& pairs, std::size_t tracks, std::size_t measured, const Take& take) {
  std::erase_if(pairs, [](const Pair& pair) { return std::isnan(pair.cost); });
  std::sort(pairs.begin(), pairs.end(), [](const Pair& a, const Pair& b) {
    if (a.cost != b.cost) return a.cost < b.cost;
    return a.track != b.track ? a.track < b.track : a.measured < b.measured;
  });
  std::vector<bool> track_taken(tracks, false);
  std::vector<bool> measured_taken(measured, false);
  for (const Pair& pair : pairs) {
    if (track_taken[at(pair.track)] || measured_taken[at(pair.measured)]) continue;
    track_taken[at(pair.track)] = measured_taken[at(pair.measured)] = true;
    take(pair);
  }
}

}  // namespace

struct Tracker::Impl {
  explicit Impl(const TrackOptions& chosen) : options(chosen) {}

  TrackOptions options;
  std::vector<PlaneTrack> planes;
  std::vector<ObjectTrack> objects;
  int next_plane = 1;
  int next_object = 1;
  bool started = false;
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();      ///< Of the last frame.
  Eigen::Isometry3d velocity = Eigen::Isometry3d::Identity();  ///< From the last frame's camera to the one's before.

  /// A plane of the frame, in the camera's frame.
  struct Measured {
    OrientedPlane plane;
    Eigen::Matrix4d covariance;
    Eigen::Vector3d centroid;
    double reach_m;
  };
  std::vector<Measured> measured;
  Sightings plane_sightings;
  Sightings object_sightings;

  /// Forgets what is followed and what the frame says of it, but never gives an id again.
  void lose_track(TrackedFrame& frame);
  void measure(const Segmentation& segmentation);
  [[nodiscard]] std::vector<Pair> plane_pairs(const Eigen::Isometry3d& T, double rotation, double translation) const;
  [[nodiscard]] bool estimate_pose(const Eigen::Isometry3d& guess, Eigen::Isometry3d& T, Matrix6& pose_covariance) const;
  void fuse(const Eigen::Isometry3d& T, const Matrix6& pose_covariance, bool exact, TrackedFrame& frame);
  void follow_objects(const Obstacles& obstacles, const Eigen::Isometry3d& T, TrackedFrame& frame);
};

void Tracker::Impl::measure(const Segmentation& segmentation) {
  measured.clear();
  for (const PlaneSegment& plane : segmentation.planes) {
    measured.push_back(
        {{plane.plane.normal, plane.plane.d}, plane.covariance, plane.centroid, std::sqrt(plane.area_m2 / std::numbers::pi)});
  }
  plane_sightings.look(segmentation.labels, segmentation.width, segmentation.height, static_cast<int>(measured.size()));
  std::vector<int> ids;
  for (const PlaneTrack& track : planes) ids.push_back(track.id);
  plane_sightings.compare(ids);
}

/// Which known planes the measured ones may be, if the camera is at T give or take its uncertainty, radians and metres.
std::vector<Pair> Tracker::Impl::plane_pairs(const Eigen::Isometry3d& T, double rotation, double translation) const {
  std::vector<Pair> pairs;
  for (std::size_t m = 0; m < measured.size(); ++m) {
    const Eigen::Vector3d normal = T.linear() * measured[m].plane.normal;
    const Eigen::Vector3d centroid = T * measured[m].centroid;
    const Matrix3 own = in_chart(measured[m].plane.normal, measured[m].covariance);
    const double distance = measured[m].centroid.norm();
    for (std::size_t k = 0; k < planes.size(); ++k) {
      const PlaneTrack& track = planes[k];
      // Measured normals point to the camera, which may have gone through the plane.
      const double angle = std::acos(std::min(1.0, std::abs(normal.dot(track.plane.normal))));
      const double offset = track.plane.normal.dot(centroid) + track.plane.d;
      const double angle_variance = rotation * rotation + spread(own) + spread(track.covariance);
      // At the middle of what is seen a plane is known to the sensor's noise and the camera's to how it moves and turns.
      const double offset_variance = translation * translation + rotation * rotation * distance * distance +
                                     spread(track.covariance) * (centroid - track.centroid).squaredNorm() +
                                     track.covariance(2, 2);
      const double squared_angle = angle * angle / angle_variance;
      const double squared_offset = offset * offset / offset_variance;
      const double overlap = plane_sightings.overlap(k, static_cast<int>(m) + 1);
      const double gate = options.gate_sigmas * (overlap >= kCovers ? 2.0 : 1.0);
      if (angle > kMostTurn_rad || squared_angle > gate * gate || squared_offset > gate * gate) continue;
      // Parts of one plane that lie apart are told by where they are.
      const double along = (centroid - track.centroid).norm() / std::max(measured[m].reach_m + track.reach_m, 1e-3);
      const double place = kNoOverlap * (1.0 - overlap) + along * along;
      pairs.push_back({static_cast<int>(k), static_cast<int>(m), squared_angle + squared_offset + place});
    }
  }
  return pairs;
}

/// Least squares of the planes that are recognised, and of the guess: Gauss and Newton's method from there.
bool Tracker::Impl::estimate_pose(const Eigen::Isometry3d& guess, Eigen::Isometry3d& T, Matrix6& pose_covariance) const {
  T = guess;
  double rotation = radians(options.rotation_deg);
  double translation = options.translation_m;
  constexpr int kRounds = 4;
  bool any = false;
  for (int round = 0; round < kRounds; ++round) {
    std::vector<Pair> pairs = plane_pairs(T, rotation, translation);
    // The guess holds back what no plane says.
    const double known_rotation = 1.0 / std::pow(radians(options.rotation_deg), 2);
    const double known_translation = 1.0 / std::pow(options.translation_m, 2);
    const Eigen::Isometry3d back = guess * T.inverse();
    const Eigen::AngleAxisd turn(back.linear());
    Vector6 off;
    off << turn.angle() * turn.axis(), back.translation();
    Vector6 weights;
    weights << Eigen::Vector3d::Constant(known_rotation), Eigen::Vector3d::Constant(known_translation);
    pose_covariance = weights.cwiseInverse().asDiagonal();
    Matrix6 normal = weights.asDiagonal();
    Vector6 right = weights.cwiseProduct(off);
    any = false;
    match(pairs, planes.size(), measured.size(), [&](const Pair& pair) {
      any = true;
      const PlaneTrack& track = planes[at(pair.track)];
      const Measured& m = measured[at(pair.measured)];
      const OrientedPlane seen = turned_to(track.plane.normal, transformed(m.plane, T));
      const Eigen::Matrix<double, 3, 6> jacobian = motion_jacobian(track.plane.normal, seen);
      const Eigen::Matrix4d world = transformed(m.covariance, seen.normal, T);
      Matrix3 covariance = in_chart(track.plane.normal, world) + track.covariance;
      covariance.diagonal().array() += 1e-12;
      const Matrix3 information = covariance.inverse();
      // Huber: a wrong pair shall not pull.
      const Eigen::Vector3d residual = -difference(track.plane, seen);
      const double length = std::sqrt(std::max(0.0, residual.dot(information * residual)));
      const double weight = length > options.gate_sigmas ? options.gate_sigmas / length : 1.0;
      normal += weight * jacobian.transpose() * information * jacobian;
      right += weight * jacobian.transpose() * information * residual;
    });
    if (!any) return false;
    const Vector6 twist = normal.ldlt().solve(right);
    if (!twist.allFinite()) return false;
    pose_covariance = normal.inverse();
    T = step(twist) * T;
    // What is left unknown is less with every round; the gates close.
    rotation = std::max(0.5 * rotation, radians(0.3));
    translation = std::max(0.5 * translation, 0.005);
  }
  return any;
}

/// Updates known planes by what was measured of them, and makes new ones.
void Tracker::Impl::fuse(const Eigen::Isometry3d& T, const Matrix6& pose_covariance, bool exact, TrackedFrame& frame) {
  const double rotation = exact ? radians(0.5) : radians(0.5 * options.rotation_deg);
  const double translation = exact ? 0.01 : 0.5 * options.translation_m;
  std::vector<int> track_of(measured.size(), -1);
  for (PlaneTrack& track : planes) {
    ++track.gap;
    const Eigen::Vector3d drift(radians(options.drift_deg), radians(options.drift_deg), options.drift_m);
    track.covariance.diagonal() += drift.cwiseAbs2();
  }
  std::vector<Pair> pairs = plane_pairs(T, rotation, translation);
  match(pairs, planes.size(), measured.size(), [&](const Pair& pair) { track_of[at(pair.measured)] = pair.track; });
  for (std::size_t m = 0; m < measured.size(); ++m) {
    const OrientedPlane seen = transformed(measured[m].plane, T);
    const Eigen::Matrix4d world = transformed(measured[m].covariance, seen.normal, T);
    // What the camera's pose is off by, the plane is off by. Else a narrow plane, whose turn about its length is hardly known,
    // would turn wildly to go through what is seen of it now and what was seen before.
    const auto covariance_in_chart = [&](const Eigen::Vector3d& normal) -> Matrix3 {
      const Eigen::Matrix<double, 3, 6> jacobian = motion_jacobian(normal, seen);
      return in_chart(normal, world) + jacobian * pose_covariance * jacobian.transpose();
    };
    if (track_of[m] < 0) {
      track_of[m] = static_cast<int>(planes.size());
      planes.push_back({next_plane++, seen, covariance_in_chart(seen.normal), T * measured[m].centroid, measured[m].reach_m});
    } else {
      PlaneTrack& track = planes[at(track_of[m])];
      // The information filter: informations add up.
      Matrix3 covariance = covariance_in_chart(track.plane.normal);
      covariance.diagonal().array() += kLeastVariance;
      track.covariance.diagonal().array() += kLeastVariance;
      const Matrix3 prior = track.covariance.inverse();
      // Huber: what contradicts all that is known counts for less.
      const Eigen::Vector3d off = difference(track.plane, turned_to(track.plane.normal, seen));
      const double squared = off.dot((track.covariance + covariance).inverse() * off);
      covariance *= std::max(1.0, squared / (options.gate_sigmas * options.gate_sigmas));
      const Matrix3 information = covariance.inverse();
      const Matrix3 both = (prior + information).inverse();
      Eigen::Vector3d by = both * (information * off);
      if (by.head<2>().norm() <= off.head<2>().norm()) {
        track.covariance = both;
      } else {
        // Of a narrow plane each frame tells a line well and the turn about it hardly. Two such lines a little apart would ask
        // for a turn far beyond what either frame saw: a mean between the two instead, whose covariance is below the mean of
        // theirs whatever they share.
        const double share = spread(track.covariance) / (spread(track.covariance) + spread(covariance));
        by = share * off;
        track.covariance = (1.0 - share) * track.covariance + share * covariance;
      }
      track.covariance = 0.5 * (track.covariance + track.covariance.transpose()).eval();
      track.plane = moved(track.plane, by);
      track.centroid = T * measured[m].centroid;
      track.reach_m = measured[m].reach_m;
      ++track.age;
      track.gap = 0;
    }
    const PlaneTrack& track = planes[at(track_of[m])];
    const Eigen::Isometry3d back = T.inverse();
    const OrientedPlane smoothed = transformed(track.plane, back);
    const Eigen::Matrix<double, 4, 3> map = chart(track.plane.normal);
    TrackedPlane& out = frame.planes.emplace_back();
    out.id = track.id;
    out.label = static_cast<int>(m) + 1;
    out.plane = make_plane(smoothed.normal, smoothed.d).value_or(Plane{});
    const Eigen::Matrix4d of_world = map * track.covariance * map.transpose();
    out.covariance = transformed(of_world, smoothed.normal, back);
    out.age = track.age;
  }
  std::vector<int> ids(measured.size() + 1, 0);
  for (const TrackedPlane& plane : frame.planes) ids[at(plane.label)] = plane.id;
  plane_sightings.remember(ids);
  std::erase_if(planes, [&](const PlaneTrack& track) { return track.gap > options.longest_gap; });
}

void Tracker::Impl::follow_objects(const Obstacles& obstacles, const Eigen::Isometry3d& T, TrackedFrame& frame) {
  std::vector<int> which;
  std::vector<Eigen::Vector3d> centres;
  for (const Obstacle& obstacle : obstacles.obstacles) {
    if (obstacle.kind == ObstacleKind::drop) continue;
    which.push_back(obstacle.id);
    centres.push_back(T * obstacles.ground.to_camera(obstacle.box.centre));
  }
  object_sightings.look(obstacles.labels, obstacles.width, obstacles.height, static_cast<int>(obstacles.obstacles.size()));
  std::vector<int> known;
  for (const ObjectTrack& track : objects) known.push_back(track.id);
  object_sightings.compare(known);
  std::vector<Pair> pairs;
  for (std::size_t m = 0; m < which.size(); ++m) {
    const Eigen::Vector3d& size = obstacles.obstacles[at(which[m] - 1)].box.size;
    for (std::size_t k = 0; k < objects.size(); ++k) {
      // What is seen of a large thing changes by more.
      const double reach = options.object_reach_m + 0.25 * std::min(size.maxCoeff(), objects[k].size.maxCoeff());
      const double distance = (centres[m] - objects[k].centre).norm() / reach;
      const double growth = std::abs(std::log((size.norm() + 0.02) / (objects[k].size.norm() + 0.02)));
      const double overlap = object_sightings.overlap(k, which[m]);
      if (distance > 1.0 && overlap < kCovers) continue;
      pairs.push_back(
          {static_cast<int>(k), static_cast<int>(m), distance * distance + growth * growth + kNoOverlap * (1.0 - overlap)});
    }
  }
  std::vector<int> track_of(which.size(), -1);
  match(pairs, objects.size(), which.size(), [&](const Pair& pair) { track_of[at(pair.measured)] = pair.track; });
  for (ObjectTrack& track : objects) ++track.gap;
  for (std::size_t m = 0; m < which.size(); ++m) {
    const Eigen::Vector3d& size = obstacles.obstacles[at(which[m] - 1)].box.size;
    if (track_of[m] < 0) {
      track_of[m] = static_cast<int>(objects.size());
      objects.push_back({next_object++, centres[m], size});
    } else {
      ObjectTrack& track = objects[at(track_of[m])];
      track.centre = centres[m];
      track.size = size;
      ++track.age;
      track.gap = 0;
    }
    const ObjectTrack& track = objects[at(track_of[m])];
    frame.objects.push_back({track.id, which[m], track.age});
  }
  std::vector<int> ids(obstacles.obstacles.size() + 1, 0);
  for (const TrackedObject& object : frame.objects) ids[at(object.obstacle)] = object.id;
  object_sightings.remember(ids);
  std::erase_if(objects, [&](const ObjectTrack& track) { return track.gap > options.longest_gap; });
}

Status validate(const TrackOptions& options) try {
  RangeCheck check;
  for_each_track_option(options, check);
  return check.status;
} catch (const std::exception& exception) {
  return caught(exception, "options of the tracker");
}

namespace {

constexpr double kRounding = 1e-3;  // of unit vectors and rotations from elsewhere

bool is_rigid(const Eigen::Isometry3d& T) {
  const Matrix3 R = T.linear();
  return T.matrix().allFinite() && (R * R.transpose()).isIdentity(kRounding) && R.determinant() > 0.0;
}

bool is_sound(const PlaneSegment& plane) {
  return std::abs(plane.plane.normal.norm() - 1.0) <= kRounding && std::isfinite(plane.plane.d) && plane.centroid.allFinite() &&
         plane.covariance.allFinite() && std::isfinite(plane.area_m2) && plane.area_m2 >= 0.0;
}

/// The i-th of a frame.
bool is_sound(const Obstacle& obstacle, std::size_t i) {
  return at(obstacle.id) == i + 1 && obstacle.box.centre.allFinite() && obstacle.box.size.allFinite() &&
         (obstacle.box.size.array() >= 0.0).all();
}

bool is_finite(const TrackedFrame& frame) {
  const auto finite = [](const TrackedPlane& p) {
    return p.plane.normal.allFinite() && std::isfinite(p.plane.d) && p.covariance.allFinite();
  };
  return frame.T_world_camera.matrix().allFinite() && std::all_of(frame.planes.begin(), frame.planes.end(), finite);
}

bool fills(std::size_t labels, int width, int height) { return width >= 0 && height >= 0 && labels == at(width) * at(height); }

Status check_input(const Segmentation& segmentation, const Obstacles* obstacles,
                   const std::optional<Eigen::Isometry3d>& T_world_camera) {
  const auto invalid = [](const char* what) { return Error{ErrorCode::invalid_argument, what}; };
  if (segmentation.method != Method::cells) {
    return Error{ErrorCode::unsupported, "tracking needs the planes' covariances, which only the method cells gives"};
  }
  if (T_world_camera && !is_rigid(*T_world_camera)) return invalid("the camera's pose is no finite rotation and translation");
  if (!fills(segmentation.labels.size(), segmentation.width, segmentation.height)) {
    return invalid("the planes' label image has not the size that it says");
  }
  const auto& planes = segmentation.planes;
  if (!std::all_of(planes.begin(), planes.end(), [](const PlaneSegment& plane) { return is_sound(plane); })) {
    return invalid("a plane is not finite, or its normal is no unit vector");
  }
  if (obstacles != nullptr && !fills(obstacles->labels.size(), obstacles->width, obstacles->height)) {
    return invalid("the obstacles' label image has not the size that it says");
  }
  for (std::size_t i = 0; obstacles != nullptr && i < obstacles->obstacles.size(); ++i) {
    if (!is_sound(obstacles->obstacles[i], i)) return invalid("an obstacle's box is not finite, or its id not its place");
  }
  return {};
}

}  // namespace

Tracker::Tracker(const TrackOptions& options) : impl_(std::make_unique<Impl>(options)) {}
Tracker::~Tracker() = default;
Tracker::Tracker(Tracker&&) noexcept = default;
Tracker& Tracker::operator=(Tracker&&) noexcept = default;

void Tracker::reset() { *impl_ = Impl(impl_->options); }

void Tracker::Impl::lose_track(TrackedFrame& frame) {
  frame = {};
  Impl fresh(options);
  fresh.next_plane = next_plane;
  fresh.next_object = next_object;
  *this = std::move(fresh);
}

Status Tracker::update(const Segmentation& segmentation, const Obstacles* obstacles,
                       const std::optional<Eigen::Isometry3d>& T_world_camera, TrackedFrame& frame) try {
  frame.planes.clear();
  frame.objects.clear();
  if (Status status = validate(impl_->options); !status) return status;
  if (Status status = check_input(segmentation, obstacles, T_world_camera); !status) return status;
  Impl& t = *impl_;
  t.measure(segmentation);
  Eigen::Isometry3d T = t.started ? Eigen::Isometry3d(t.pose * t.velocity) : Eigen::Isometry3d::Identity();
  frame.pose_source = PoseSource::estimated;
  Matrix6 pose_covariance = Matrix6::Zero();
  if (T_world_camera) {
    T = *T_world_camera;
    frame.pose_source = PoseSource::given;
  } else if (t.started) {
    const Eigen::Isometry3d guess = T;
    if (!t.estimate_pose(guess, T, pose_covariance)) {
      T = guess;
      frame.pose_source = PoseSource::guessed;
    }
  }
  t.fuse(T, pose_covariance, T_world_camera.has_value(), frame);
  if (obstacles != nullptr) t.follow_objects(*obstacles, T, frame);
  t.velocity = t.started ? Eigen::Isometry3d(t.pose.inverse() * T) : Eigen::Isometry3d::Identity();
  // Rotations stay rotations however long the sequence.
  t.velocity.linear() = Eigen::Quaterniond(t.velocity.linear()).normalized().toRotationMatrix();
  T.linear() = Eigen::Quaterniond(T.linear()).normalized().toRotationMatrix();
  t.pose = T;
  t.started = true;
  frame.T_world_camera = T;
  if (is_finite(frame)) return {};
  t.lose_track(frame);
  return Error{ErrorCode::invalid_argument, "planes, pose and options have numbers too large or too small to work with"};
} catch (const std::exception& exception) {
  impl_->lose_track(frame);  // part of it is of this frame, part of the one before
  return caught(exception, "tracker");
}

}  // namespace fransac
