// SPDX-License-Identifier: Apache-2.0
#include "synth/walk.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "synth/builder.hpp"

namespace fransac::synth::detail {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector3d;

constexpr double kRound = 2.0 * std::numbers::pi;
constexpr int kSamples = 1440;  // of the path, to measure it: nowhere is a frame as short as one

// Our choice, for a hand: how far it looks aside and up of what it follows, as tangents, and how far it rolls.
constexpr double kGlance = 0.11;
constexpr double kNod = 0.06;
constexpr double kRoll_rad = 0.05;
// The look follows the camera by this share of its way, as one looks along rather than at one point.
constexpr double kFollow = 0.5;

// Room for the camera, and for sight ahead: more than the nearest that sensors measure.
constexpr double kClearance_m = 0.15;
constexpr double kSight_m = 0.6;

}  // namespace

Walk::Walk(const Stage& stage, std::uint64_t seed) : middle_(stage.camera), target_(stage.target), facing_(facing(stage)) {
  Dice dice(seed, stream_index(Purpose::walk));
  direction_ = dice.sign();
  for (double* phase : {&start_, &bob_, &glance_, &nod_, &roll_, &pace_}) *phase = dice.between(0.0, kRound);
  // As wide as leaves the camera free, at least what every scene keeps free.
  for (const double scale : {3.0, 2.5, 2.0, 1.5, 1.0}) {
    reach_ = {scale * stage.sway.x(), scale * stage.sway.y(), stage.sway.z()};
    if (is_free(stage.scene)) break;
  }
  measure();
}

Isometry3d Walk::at(double angle) const {
  const double a = start_ + direction_ * angle;
  const Vector3d aside = facing_.col(0);
  const Vector3d up = facing_.col(2);
  const Vector3d moved =
      facing_ * Vector3d(reach_.x() * std::cos(a), reach_.y() * std::sin(a), reach_.z() * std::sin(2.0 * a + bob_));
  const double distance = (target_ - middle_).norm();
  const Vector3d look = target_ + kFollow * moved + kGlance * distance * std::sin(3.0 * a + glance_) * aside +
                        kNod * distance * std::sin(2.0 * a + nod_) * up;
  return looking(middle_ + moved, look) * Eigen::AngleAxisd(kRoll_rad * std::sin(2.0 * a + roll_), Vector3d::UnitZ());
}

bool Walk::is_free(const Scene& scene) const {
  constexpr int kPlaces = 90;  // a few centimetres apart: nothing is passed through between two of them
  for (int i = 0; i < kPlaces; ++i) {
    const Isometry3d pose = at(kRound * i / kPlaces);
    if (scene.encloses(pose.translation())) return false;
    const RayCaster caster(scene, pose.translation());
    if (caster.cast(pose.linear().col(2), kSight_m).primitive >= 0) return false;
    for (const double sign : {-1.0, 1.0}) {
      for (int axis = 0; axis < 3; ++axis) {
        if (caster.cast(sign * Vector3d::Unit(axis), kClearance_m).primitive >= 0) return false;
      }
    }
  }
  return true;
}

// Frames pass in proportion to how far the camera moves and turns, and how much its way bends.
void Walk::measure() {
  frames_.assign(1, 0.0);
  Isometry3d last = at(0.0);
  Vector3d last_step = last.translation() - at(-kRound / kSamples).translation();
  for (int i = 1; i <= kSamples; ++i) {
    const double angle = kRound * i / kSamples;
    const Isometry3d next = at(angle);
    const Vector3d step = next.translation() - last.translation();
    const double moved = step.norm() / walk::kStep_m;
    const double turned = Eigen::AngleAxisd(last.linear().transpose() * next.linear()).angle() / walk::kTurn_rad;
    const double pace = 1.0 + walk::kPace * std::sin(5.0 * angle + pace_);
    const double bent = std::acos(std::min(1.0, step.normalized().dot(last_step.normalized()))) / walk::kBend_rad;
    frames_.push_back(frames_.back() + std::hypot(moved, turned, bent) / (std::numbers::sqrt3 * pace));
    last = next;
    last_step = step;
  }
}

Isometry3d Walk::after(double frames) const {
  const double rest = std::fmod(frames, frames_.back());
  const auto next = std::upper_bound(frames_.begin() + 1, frames_.end() - 1, rest);
  const double before = *(next - 1);
  const double sample = static_cast<double>(next - 1 - frames_.begin()) + (rest - before) / (*next - before);
  return at(kRound * sample / kSamples);
}

Isometry3d Walk::pose(int frame) const { return after(frame); }

Isometry3d Walk::view(int i, int count) const { return after(frames_.back() * i / count); }

}  // namespace fransac::synth::detail
