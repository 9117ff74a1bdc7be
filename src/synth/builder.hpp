// SPDX-License-Identifier: Apache-2.0
/// Puts scenes together from solids.
#pragma once

#include <Eigen/Geometry>
#include <array>
#include <cstdint>
#include <vector>

#include "fransac/core/random.hpp"
#include "synth/geometry.hpp"

namespace fransac::synth::detail {

/// Random choices. Arguments of one call are evaluated in no fixed order: draw each number in a statement or braces of its own.
class Dice {
 public:
  Dice(std::uint64_t seed, std::uint64_t index) : stream_(seed, index) {}

  double between(double low, double high) { return low + (high - low) * stream_.uniform(); }
  int whole(int low, int high) { return low + static_cast<int>(stream_.below(static_cast<std::uint32_t>(high - low + 1))); }
  bool chance(double probability) { return stream_.uniform() < probability; }
  double sign() { return chance(0.5) ? 1.0 : -1.0; }
  template <class T, std::size_t N>
  const T& pick(const std::array<T, N>& choices) {
    return choices[stream_.below(static_cast<std::uint32_t>(N))];
  }
  double normal() { return stream_.normal(); }

 private:
  RandomStream stream_;
};

/// A recess in a wall: a door, a window, a niche. Along the wall and up, metres.
struct Recess {
  double from, to, bottom, top, depth;
  Material back;
};

/// A pose that stands upright: turned about z, then moved.
Eigen::Isometry3d standing(double x, double y, double z, double yaw);

/// Circles on a floor or table that are taken.
class Occupancy {
 public:
  void take(double x, double y, double radius) { circles_.push_back({x, y, radius}); }
  [[nodiscard]] bool free(double x, double y, double radius) const;
  /// A free spot in a rectangle; takes it. False when many tries find none.
  bool find(Dice& dice, const Eigen::AlignedBox2d& area, double radius, Eigen::Vector2d& spot);

 private:
  std::vector<Eigen::Vector3d> circles_;  // x, y, radius
};

/// Solids are placed by a pose whose origin is the middle of their base, z up; their front is -y.
class Builder {
 public:
  /// What follows belongs to one free-standing object until the next call of either.
  void object();
  /// What follows belongs to the room, or is what things stand on.
  void fixture();
  void box(const Eigen::Isometry3d& base, const Eigen::Vector3d& size, const Material& material);
  void cylinder(const Eigen::Isometry3d& base, double radius, double height, const Material& material);
  void sphere(const Eigen::Isometry3d& base, double radius, const Material& material);
  /// Centred on the pose, normal along its z.
  void rectangle(const Eigen::Isometry3d& pose, double width, double height, const Material& material);
  /// A horizontal rectangle.
  void level(const Eigen::AlignedBox2d& area, double z, const Material& material);
  /// A vertical rectangle over the line from a to b.
  void upright(const Eigen::Vector2d& a, const Eigen::Vector2d& b, double bottom, double top, const Material& material);
  /// A wall from a to b with recesses (in order, apart from each other) to the right of that line.
  void wall(const Eigen::Vector2d& a, const Eigen::Vector2d& b, double bottom, double top, const Material& material,
            const std::vector<Recess>& recesses = {});

  [[nodiscard]] Scene finish();

 private:
  void group(bool free_standing);
  void add(Shape shape, const Eigen::Isometry3d& pose, const Eigen::Vector3d& half, const Material& material);

  Scene scene_;
};

}  // namespace fransac::synth::detail
