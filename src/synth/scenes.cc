// SPDX-License-Identifier: Apache-2.0
#include "synth/scenes.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <utility>
#include <vector>

#include "fransac/synth/synth.hpp"
#include "synth/builder.hpp"

namespace fransac::synth {
namespace detail {
namespace {

using Eigen::AlignedBox2d;
using Eigen::Isometry3d;
using Eigen::Vector2d;
using Eigen::Vector3d;
using std::numbers::pi;

constexpr double degrees(double value) { return value * pi / 180.0; }

// A pose on another one.
Isometry3d on(const Isometry3d& base, double x, double y, double z, double yaw = 0.0) { return base * standing(x, y, z, yaw); }

// ---- Materials. Sizes below are those of common furniture and building parts, metres.

constexpr double kSmoothTexture = 0.25;  // plastic, screens: little for a matcher to see

Material plain(const Vector3d& colour, double texture = 0.85) { return {.colour = colour, .texture = texture}; }

Material wood() {
  return {
      .colour = {0.50, 0.30, 0.15}, .second = {0.27, 0.15, 0.07}, .pattern = Pattern::planks, .period_m = 0.14, .texture = 0.95};
}

Material table_wood() { return plain({0.55, 0.36, 0.19}, 0.95); }

Material wall_paint(Dice& dice) {
  static const std::array<Vector3d, 5> kPaints{Vector3d{0.72, 0.68, 0.60}, Vector3d{0.50, 0.61, 0.66}, Vector3d{0.66, 0.60, 0.44},
                                               Vector3d{0.52, 0.62, 0.50}, Vector3d{0.74, 0.73, 0.71}};
  return plain(dice.pick(kPaints), 0.8);
}

Material floor_cover(Dice& dice) {
  static const std::array<Material, 3> kCovers{wood(),
                                               Material{.colour = {0.62, 0.60, 0.56},
                                                        .second = {0.40, 0.41, 0.42},
                                                        .pattern = Pattern::checker,
                                                        .period_m = 0.4,
                                                        .texture = 0.9},
                                               Material{.colour = {0.22, 0.27, 0.34},
                                                        .second = {0.17, 0.21, 0.28},
                                                        .pattern = Pattern::speckled,
                                                        .period_m = 0.02,
                                                        .texture = 1.0}};
  return dice.pick(kCovers);
}

Material step_cover(Dice& dice) {
  static const std::array<Vector3d, 3> kTreads{Vector3d{0.52, 0.33, 0.17}, Vector3d{0.42, 0.42, 0.43},
                                               Vector3d{0.45, 0.22, 0.16}};
  const Vector3d tread = dice.pick(kTreads);
  return {.colour = 0.6 * tread + Vector3d::Constant(0.22),
          .second = tread,
          .pattern = Pattern::framed,
          .period_m = 0.04,
          .texture = 0.9};
}

Material door(Dice& dice) {
  static const std::array<Vector3d, 3> kDoors{Vector3d{0.38, 0.21, 0.10}, Vector3d{0.18, 0.32, 0.42}, Vector3d{0.56, 0.54, 0.48}};
  const Vector3d colour = dice.pick(kDoors);
  return {.colour = colour, .second = 0.8 * colour, .pattern = Pattern::framed, .period_m = 0.12, .texture = 0.8};
}

Material window() {
  return {
      .colour = {0.75, 0.75, 0.73}, .second = {0.45, 0.62, 0.80}, .pattern = Pattern::framed, .period_m = 0.07, .texture = 0.5};
}

Material screen() {
  return {.colour = {0.03, 0.03, 0.035},
          .second = {0.05, 0.16, 0.30},
          .pattern = Pattern::framed,
          .period_m = 0.015,
          .texture = kSmoothTexture};
}

Material cardboard() { return plain({0.48, 0.33, 0.19}, 0.95); }

Material ceiling_paint() { return plain({0.80, 0.80, 0.78}, 0.6); }

Material metal() { return plain({0.35, 0.36, 0.38}, 0.5); }

Material bright(Dice& dice) {
  static const std::array<Vector3d, 8> kColours{
      Vector3d{0.62, 0.10, 0.08}, Vector3d{0.08, 0.28, 0.55}, Vector3d{0.75, 0.50, 0.06}, Vector3d{0.10, 0.42, 0.20},
      Vector3d{0.70, 0.68, 0.62}, Vector3d{0.40, 0.12, 0.38}, Vector3d{0.06, 0.42, 0.45}, Vector3d{0.78, 0.30, 0.10}};
  return plain(dice.pick(kColours), 0.9);
}

Material book_cover(Dice& dice) {
  Material cover = bright(dice);
  cover.second = 0.55 * cover.colour + Vector3d::Constant(0.25);
  cover.pattern = Pattern::framed;
  cover.period_m = 0.025;
  return cover;
}

// ---- Things.

void table(Builder& b, const Isometry3d& base, double width, double depth, double height) {
  constexpr double kTop = 0.03;
  constexpr double kLeg = 0.05;
  b.fixture();
  b.box(on(base, 0.0, 0.0, height - kTop), {width, depth, kTop}, table_wood());
  for (const double sx : {-1.0, 1.0}) {
    for (const double sy : {-1.0, 1.0}) {
      // Set in by one centimetre, or the legs' sides would continue the edges of the top.
      const double x = sx * (0.5 * (width - kLeg) - 0.01);
      const double y = sy * (0.5 * (depth - kLeg) - 0.01);
      b.box(on(base, x, y, 0.0), {kLeg, kLeg, height - kTop}, metal());
    }
  }
}

void monitor(Builder& b, const Isometry3d& base, Dice& dice) {
  const double width = dice.between(0.48, 0.62);
  const double height = 0.58 * width;
  b.object();
  b.box(base, {0.24, 0.18, 0.012}, metal());
  b.box(on(base, 0.0, 0.03, 0.012), {0.04, 0.02, 0.25}, metal());
  const Isometry3d tilted = on(base, 0.0, 0.0, 0.12) * Eigen::AngleAxisd(degrees(-dice.between(0.0, 8.0)), Vector3d::UnitX());
  b.box(tilted, {width, 0.035, height}, screen());
}

void keyboard(Builder& b, const Isometry3d& base) {
  b.object();
  b.box(base, {0.44, 0.14, 0.02}, plain({0.06, 0.06, 0.065}, 0.6));
}

void mug(Builder& b, const Isometry3d& base, Dice& dice) {
  const double radius = dice.between(0.035, 0.045);
  const double height = dice.between(0.09, 0.13);
  b.object();
  b.cylinder(base, radius, height, bright(dice));
}

void book(Builder& b, const Isometry3d& base, Dice& dice) {
  const double thickness = dice.between(0.012, 0.025);
  const double width = dice.between(0.15, 0.20);
  b.object();
  b.box(base, {width, 1.4 * width, thickness}, book_cover(dice));
}

// A low lid, 3 cm: what a fixed 1 cm threshold and a 2 cm voxel easily merge with the table.
void lid(Builder& b, const Isometry3d& base, Dice& dice) {
  const double width = dice.between(0.26, 0.34);
  const double depth = dice.between(0.19, 0.25);
  b.object();
  b.box(base, {width, depth, 0.03}, cardboard());
}

void carton(Builder& b, const Isometry3d& base, Dice& dice, double low, double high) {
  const double width = dice.between(low, high);
  const double depth = dice.between(0.6, 1.0) * width;
  const double height = dice.between(0.5, 1.0) * width;
  b.object();
  b.box(base, {width, depth, height}, cardboard());
}

void packet(Builder& b, const Isometry3d& base, Dice& dice) {
  const double width = dice.between(0.10, 0.19);
  const double depth = dice.between(0.05, 0.10);
  const double height = dice.between(0.14, 0.28);
  b.object();
  b.box(base, {width, depth, height}, book_cover(dice));
}

void bin(Builder& b, const Isometry3d& base, Dice& dice) {
  const double radius = dice.between(0.13, 0.19);
  const double height = dice.between(0.30, 0.45);
  b.object();
  b.cylinder(base, radius, height, dice.chance(0.5) ? metal() : bright(dice));
}

void plant(Builder& b, const Isometry3d& base, Dice& dice) {
  const double pot = dice.between(0.13, 0.18);
  const double crown = dice.between(0.22, 0.30);
  b.object();
  b.cylinder(base, pot, 0.32, plain({0.50, 0.20, 0.10}));
  b.cylinder(on(base, 0.0, 0.0, 0.32), 0.025, 0.25, plain({0.20, 0.12, 0.06}));
  b.sphere(on(base, 0.0, 0.0, 0.45), crown, plain({0.10, 0.30, 0.08}, 1.0));
  b.sphere(on(base, 0.6 * crown, 0.3 * crown, 0.60), 0.7 * crown, plain({0.13, 0.35, 0.10}, 1.0));
}

void chair(Builder& b, const Isometry3d& base, Dice& dice) {
  const Material fabric = bright(dice);
  const double seat = dice.between(0.43, 0.48);
  b.object();
  for (const double yaw : {0.0, 0.5 * pi}) b.box(on(base, 0.0, 0.0, 0.02, yaw), {0.56, 0.05, 0.05}, metal());
  b.cylinder(on(base, 0.0, 0.0, 0.07), 0.03, seat - 0.07, metal());
  b.box(on(base, 0.0, 0.0, seat), {0.46, 0.45, 0.06}, fabric);
  b.box(on(base, 0.0, 0.22, seat + 0.02), {0.05, 0.03, 0.25}, metal());
  const Isometry3d back = on(base, 0.0, 0.21, seat + 0.16) * Eigen::AngleAxisd(degrees(-8.0), Vector3d::UnitX());
  b.box(back, {0.42, 0.05, 0.42}, fabric);
}

void shelf(Builder& b, const Isometry3d& base, double width, double depth, double height, Dice& dice) {
  constexpr double kBoard = 0.02;
  const Material board = plain({0.62, 0.60, 0.56}, 0.7);
  const int floors = std::max(2, static_cast<int>(height / 0.36));
  const double step = (height - kBoard) / floors;
  b.object();
  for (const double side : {-1.0, 1.0}) b.box(on(base, side * 0.5 * (width - kBoard), 0.0, 0.0), {kBoard, depth, height}, board);
  b.box(on(base, 0.0, 0.5 * depth - 0.005, 0.0), {width - 2.0 * kBoard, 0.01, height}, board);
  const double inner = width - 2.0 * kBoard;
  for (int i = 0; i <= floors; ++i) b.box(on(base, 0.0, -0.005, i * step), {inner, depth - 0.01, kBoard}, board);
  for (int i = 0; i < floors; ++i) {
    const double fill = dice.between(0.3, 1.0) * inner;
    for (double x = -0.5 * inner + 0.005; x < -0.5 * inner + fill - 0.07;) {
      const double thickness = dice.between(0.02, 0.06);
      const double tall = dice.between(0.55, 0.85) * step;
      const double deep = dice.between(0.5, 0.8) * depth;
      const Isometry3d spot = on(base, x + 0.5 * thickness, 0.5 * depth - 0.012 - 0.5 * deep, i * step + kBoard);
      b.box(spot, {thickness, deep, tall}, bright(dice));
      x += thickness + 0.001;
    }
  }
}

// A pose whose z is horizontal, for what lies: the base of a lying cylinder is one of its ends.
Isometry3d lying(double x, double y, double z, double yaw) {
  return standing(x, y, z, yaw) * Eigen::AngleAxisd(0.5 * pi, Vector3d::UnitX());
}

// A cylinder with round ends, which are a hair thicker, so that nothing is seen of the flat ones.
void capsule(Builder& b, const Isometry3d& base, double radius, double length, const Material& material) {
  constexpr double kHair = 1e-4;
  b.object();
  b.cylinder(base, radius, length, material);
  for (const double end : {0.0, length}) b.sphere(on(base, 0.0, 0.0, end - radius - kHair), radius + kHair, material);
}

void cabinet(Builder& b, const Isometry3d& base, double width, double depth, double height, Dice& dice) {
  Material front = plain({0.46, 0.46, 0.45}, 0.6);
  if (dice.chance(0.5)) front = table_wood();
  front.second = 0.85 * front.colour;
  front.pattern = Pattern::framed;
  front.period_m = 0.03;
  b.object();
  b.box(base, {width, depth, height}, front);
}

// What lies about on a table top: flat things anywhere, tall ones in the rear half.
void clutter(Builder& b, const Isometry3d& top, double width, double depth, Occupancy& taken, Dice& dice, int tall, int flat) {
  const auto area = [&](double front, double margin) {
    return AlignedBox2d(Vector2d(-0.5 * width + margin, front + margin), Vector2d(0.5 * width - margin, 0.5 * depth - margin));
  };
  Vector2d spot;
  for (int i = 0; i < tall; ++i) {
    if (!taken.find(dice, area(-0.1 * depth, 0.11), 0.11, spot)) continue;
    const Isometry3d at = on(top, spot.x(), spot.y(), 0.0, dice.between(-pi, pi));
    dice.chance(0.7) ? packet(b, at, dice) : mug(b, at, dice);
  }
  for (int i = 0; i < flat; ++i) {
    if (!taken.find(dice, area(-0.5 * depth, 0.17), 0.17, spot)) continue;
    const Isometry3d at = on(top, spot.x(), spot.y(), 0.0, dice.between(-0.6, 0.6));
    dice.chance(0.6) ? book(b, at, dice) : mug(b, at, dice);
  }
}

struct RoomSize {
  AlignedBox2d area;
  double height;
};

// Floor, ceiling and four walls as one fixture; recesses[i] belong to the walls in front (y low), right, behind (y high), left.
void room(Builder& b, const RoomSize& size, const Material& floor, const std::array<Material, 4>& walls,
          const std::array<std::vector<Recess>, 4>& recesses = {}) {
  const Vector2d low = size.area.min();
  const Vector2d high = size.area.max();
  const std::array<Vector2d, 5> corners{low, Vector2d(high.x(), low.y()), high, Vector2d(low.x(), high.y()), low};
  b.fixture();
  b.level(size.area, 0.0, floor);
  b.level(size.area, size.height, ceiling_paint());
  for (std::size_t i = 0; i < 4; ++i) b.wall(corners[i], corners[i + 1], 0.0, size.height, walls[i], recesses[i]);
}

Recess door_recess(double from, Dice& dice) {
  const double depth = dice.between(0.06, 0.15);
  return {from, from + dice.between(0.85, 1.0), 0.0, 2.05, depth, door(dice)};
}

Recess window_recess(double from, Dice& dice) {
  const double width = dice.between(0.9, 1.4);
  const double depth = dice.between(0.12, 0.22);
  return {from, from + width, 0.9, 2.1, depth, window()};
}

// ---- Scenes.

Stage empty_room(std::uint64_t seed) {
  Dice dice(seed, stream_index(Purpose::scene));
  const double width = dice.between(3.2, 5.2);
  const double depth = dice.between(4.2, 6.2);
  const double height = dice.between(2.4, 3.0);
  const Material paint = wall_paint(dice);
  const Material accent = wall_paint(dice);
  const Material floor = floor_cover(dice);
  std::array<std::vector<Recess>, 4> recesses;
  if (dice.chance(0.7)) recesses[2] = {window_recess(dice.between(0.4, width - 2.0), dice)};
  if (dice.chance(0.7)) recesses[1] = {door_recess(dice.between(1.8, depth - 1.6), dice)};

  Builder b;
  room(b, {AlignedBox2d(Vector2d(-0.5 * width, 0.0), Vector2d(0.5 * width, depth)), height}, floor, {paint, paint, accent, paint},
       recesses);
  Stage stage{.scene = b.finish()};
  const double side = dice.sign();
  stage.camera = {side * dice.between(0.1, 0.5 * width - 1.0), dice.between(0.6, 0.9), dice.between(1.2, 1.7)};
  stage.target = {-side * dice.between(0.05, 0.2) * width, 0.75 * depth, dice.between(0.5, 0.9)};
  stage.sway = {0.3, 0.2, 0.1};
  stage.scene.lamp = {0.3 * side, 0.45 * depth, height - 0.3};
  return stage;
}

Stage desk(std::uint64_t seed) {
  Dice dice(seed, stream_index(Purpose::scene));
  const double width = dice.between(1.3, 1.7);
  const double depth = dice.between(0.70, 0.85);
  const double height = dice.between(0.70, 0.77);
  const double gap = dice.between(0.03, 0.25);
  constexpr double kBack = 2.2;  // the wall behind the desk
  const Material paint = wall_paint(dice);
  const Material other = wall_paint(dice);
  const Material floor = floor_cover(dice);

  Builder b;
  room(b, {AlignedBox2d(Vector2d(-2.0, -1.0), Vector2d(2.2, kBack)), 2.6}, floor, {paint, other, paint, other});
  const double yaw = dice.between(-0.02, 0.02);
  const Isometry3d base = standing(dice.between(-0.1, 0.1), kBack - gap - 0.5 * depth - 0.02, 0.0, yaw);
  table(b, base, width, depth, height);
  const Isometry3d top = on(base, 0.0, 0.0, height);

  Occupancy taken;
  const auto area = [&](double margin) {
    return AlignedBox2d(Vector2d(-0.5 * width + margin, -0.5 * depth + margin),
                        Vector2d(0.5 * width - margin, 0.5 * depth - margin));
  };
  Vector2d spot;
  if (dice.chance(0.5)) {
    const double x = dice.between(-0.25, 0.25) * width;
    taken.take(x - 0.14, 0.5 * depth - 0.15, 0.12);
    taken.take(x + 0.14, 0.5 * depth - 0.15, 0.12);
    monitor(b, on(top, x, 0.5 * depth - 0.14, 0.0, dice.between(-0.15, 0.15)), dice);
  }
  if (taken.find(dice, area(0.21), 0.21, spot)) lid(b, on(top, spot.x(), spot.y(), 0.0, dice.between(-0.7, 0.7)), dice);
  if (taken.find(dice, area(0.18), 0.17, spot)) book(b, on(top, spot.x(), spot.y(), 0.0, dice.between(-0.7, 0.7)), dice);
  const double radius = dice.between(0.05, 0.10);
  if (taken.find(dice, area(radius), radius, spot)) {
    b.object();
    b.sphere(on(top, spot.x(), spot.y(), 0.0), radius, bright(dice));
  }
  for (int i = 0; i < 2; ++i) {
    if (taken.find(dice, area(0.06), 0.05, spot)) mug(b, on(top, spot.x(), spot.y(), 0.0), dice);
  }
  const int tall = dice.whole(2, 4);
  const int flat = dice.whole(0, 2);
  clutter(b, top, width, depth, taken, dice, tall, flat);

  Stage stage{.scene = b.finish()};
  const double front = base.translation().y() - 0.5 * depth;
  stage.camera = {dice.between(-0.4, 0.4), front - dice.between(0.4, 0.6), height + dice.between(0.6, 0.85)};
  stage.target = {dice.between(-0.1, 0.1), front + dice.between(0.35, 0.5) * depth, height};
  stage.sway = {0.25, 0.1, 0.08};
  stage.scene.lamp = {dice.between(-1.2, 1.2), front - 0.3, 2.45};
  return stage;
}

struct Flight {
  int steps;
  double rise, tread, width;
};

Stage stairs_up(Dice& dice, const Flight& f) {
  constexpr double kLanding = 1.4;
  const Material step = step_cover(dice);
  const Material paint = wall_paint(dice);
  const Material other = wall_paint(dice);
  const double end = f.steps * f.tread + kLanding;
  const double height = f.steps * f.rise + 2.3;
  const double open_side = dice.chance(0.6) ? dice.between(0.6, 1.4) : 0.0;
  const Material floor = floor_cover(dice);

  Builder b;
  // The flight runs along the left wall.
  const double left = -0.5 * f.width;
  const double right = 0.5 * f.width + open_side;
  room(b, {AlignedBox2d(Vector2d(left, -2.8), Vector2d(right, end)), height}, floor, {other, paint, other, paint});
  b.fixture();
  for (int k = 0; k < f.steps; ++k) {
    const double from = k * f.tread;
    b.box(standing(0.0, 0.5 * (from + end), k * f.rise, 0.0), {f.width, end - from, f.rise}, step);
  }
  if (open_side > 0.0) {
    for (int k = 0; k < f.steps; k += 2) {
      const double y = (k + 0.5) * f.tread;
      b.object();
      b.cylinder(standing(0.5 * f.width - 0.05, y, (k + 1) * f.rise, 0.0), 0.015, 0.9, metal());
    }
  }
  Stage stage{.scene = b.finish()};
  stage.camera = {dice.between(-0.12, 0.12) * f.width + 0.25 * open_side, -dice.between(1.2, 1.8), dice.between(1.2, 1.6)};
  stage.target = {0.1 * open_side, 0.6 * f.steps * f.tread, 0.45 * f.steps * f.rise};
  stage.sway = {0.15, 0.2, 0.05};
  stage.scene.lamp = {0.3 * f.width, -0.9, height - 0.3};
  return stage;
}

// Seen from the upper floor, z = 0: the risers are hidden.
Stage stairs_down(Dice& dice, const Flight& f) {
  constexpr double kLower = 2.2;
  const Material step = step_cover(dice);
  const Material paint = wall_paint(dice);
  const Material other = wall_paint(dice);
  const Material floor = floor_cover(dice);
  const double left = -0.5 * f.width;
  const double right = 0.5 * f.width;
  const double end = (f.steps - 1) * f.tread + kLower;
  const double bottom = -f.steps * f.rise;
  constexpr double kStart = -1.6;
  constexpr double kCeiling = 2.5;

  Builder b;
  b.fixture();
  b.level(AlignedBox2d(Vector2d(left, kStart), Vector2d(right, 0.0)), 0.0, floor);
  b.level(AlignedBox2d(Vector2d(left, kStart), Vector2d(right, end)), kCeiling, ceiling_paint());
  b.level(AlignedBox2d(Vector2d(left, 0.0), Vector2d(right, end)), bottom, floor);
  b.upright({left, 0.0}, {right, 0.0}, bottom, 0.0, step);
  b.wall({left, kStart}, {right, kStart}, 0.0, kCeiling, other);
  b.wall({right, kStart}, {right, end}, bottom, kCeiling, paint);
  b.wall({right, end}, {left, end}, bottom, kCeiling, other, {door_recess(0.5 * f.width - 0.5, dice)});
  b.wall({left, end}, {left, kStart}, bottom, kCeiling, paint);
  b.fixture();
  for (int k = 1; k < f.steps; ++k) {
    const double top = -k * f.rise;
    b.box(standing(0.0, (k - 0.5) * f.tread, bottom, 0.0), {f.width, f.tread, top - bottom}, step);
  }
  Stage stage{.scene = b.finish()};
  stage.camera = {dice.between(-0.15, 0.15) * f.width, -dice.between(0.35, 0.6), dice.between(1.35, 1.6)};
  stage.target = {0.0, 0.75 * f.steps * f.tread, 0.75 * bottom};
  stage.sway = {0.15, 0.15, 0.05};
  stage.scene.lamp = {0.2 * f.width, 0.4 * end, kCeiling - 0.3};
  return stage;
}

Stage stairs(std::uint64_t seed) {
  Dice dice(seed, stream_index(Purpose::scene));
  const int steps = dice.whole(5, 9);
  const double rise = dice.between(0.15, 0.19);
  const double tread = dice.between(0.26, 0.32);
  const double width = dice.between(1.1, 1.7);
  const Flight flight{steps, rise, tread, width};
  return dice.chance(0.65) ? stairs_up(dice, flight) : stairs_down(dice, flight);
}

// Doors along a corridor's wall of the given length.
std::vector<Recess> doors_along(double length, Dice& dice) {
  std::vector<Recess> doors;
  for (double s = dice.between(0.8, 2.4); s < length - 1.4;) {
    doors.push_back(door_recess(s, dice));
    s = doors.back().to + dice.between(1.0, 2.6);
  }
  return doors;
}

Stage corridor(std::uint64_t seed) {
  Dice dice(seed, stream_index(Purpose::scene));
  const double length = dice.between(8.0, 13.0);
  const double width = dice.between(1.6, 2.3);
  const double height = dice.between(2.4, 2.8);
  const Material paint = wall_paint(dice);
  const Material end = wall_paint(dice);
  const Material floor = floor_cover(dice);
  std::array<std::vector<Recess>, 4> recesses;
  recesses[1] = doors_along(length, dice);
  recesses[3] = doors_along(length, dice);
  recesses[2] = {window_recess(0.1, dice)};
  recesses[2][0].to = width - 0.1;

  Builder b;
  room(b, {AlignedBox2d(Vector2d(-0.5 * width, 0.0), Vector2d(0.5 * width, length)), height}, floor, {end, paint, end, paint},
       recesses);
  // Furniture keeps to the walls; the way stays free.
  const int things = dice.whole(2, 4);
  Occupancy taken;
  for (int i = 0; i < things; ++i) {
    const double side = dice.sign();
    const double y = dice.between(2.6, 6.0);
    const double x = side * (0.5 * width - 0.24);
    if (!taken.free(x, y, 0.4)) continue;
    taken.take(x, y, 0.4);
    switch (dice.whole(0, 3)) {
      case 0: bin(b, standing(x, y, 0.0, 0.0), dice); break;
      case 1: carton(b, standing(x, y, 0.0, side * 0.5 * pi), dice, 0.3, 0.42); break;
      case 2: cabinet(b, standing(x, y, 0.0, -side * 0.5 * pi), 0.7, 0.4, dice.between(0.7, 1.1), dice); break;
      default: plant(b, standing(x - side * 0.12, y, 0.0, side > 0.0 ? pi : 0.0), dice); break;
    }
  }
  Stage stage{.scene = b.finish()};
  stage.camera = {dice.between(-0.25, 0.25) * width, dice.between(0.9, 1.2), dice.between(1.1, 1.6)};
  stage.target = {dice.between(-0.15, 0.15) * width, 4.5, dice.between(0.5, 0.8)};
  stage.sway = {0.15, 0.5, 0.05};
  stage.scene.lamp = {0.0, 3.0, height - 0.3};
  return stage;
}

// A road (z = 0, y < 0), a pavement behind its kerb, a hole in the pavement or in the road, a wall or hedge behind.
Stage kerb(std::uint64_t seed) {
  Dice dice(seed, stream_index(Purpose::scene));
  const double step = dice.between(0.09, 0.16);
  const double pavement = dice.between(1.8, 2.6);
  const double road = dice.between(3.5, 5.0);
  const bool from_pavement = dice.chance(0.5);
  constexpr double kHalf = 9.0;
  const Material asphalt{.colour = {0.17, 0.17, 0.18},
                         .second = {0.13, 0.13, 0.14},
                         .pattern = Pattern::speckled,
                         .period_m = 0.015,
                         .texture = 1.0};
  const Material paving{
      .colour = {0.46, 0.44, 0.41}, .second = {0.38, 0.37, 0.35}, .pattern = Pattern::checker, .period_m = 0.3, .texture = 0.95};
  const Material stone = plain({0.58, 0.57, 0.54}, 0.9);
  const Material earth{
      .colour = {0.24, 0.16, 0.10}, .second = {0.18, 0.12, 0.08}, .pattern = Pattern::speckled, .period_m = 0.02, .texture = 1.0};

  // The ground within x in [-kHalf, kHalf], with a rectangular hole in one of its two levels.
  const bool hole_in_road = !from_pavement && dice.chance(0.4);
  const double hole_width = dice.between(0.5, 0.9);
  const double hole_length = dice.between(0.45, 0.7);
  const double hole_depth = dice.between(0.2, 0.5);
  const double x = dice.between(-0.5, 0.5);
  const double y = hole_in_road ? -dice.between(0.15, 0.3) - hole_length : dice.between(0.3, 0.45);
  const AlignedBox2d hole(Vector2d(x - 0.5 * hole_width, y), Vector2d(x + 0.5 * hole_width, y + hole_length));
  constexpr double kStone = 0.14;

  Builder b;
  const auto ground = [&](double y0, double y1, double z, const Material& material, bool with_hole) {
    const auto part = [&](double xa, double ya, double xb, double yb) {
      if (xb > xa && yb > ya) b.level(AlignedBox2d(Vector2d(xa, ya), Vector2d(xb, yb)), z, material);
    };
    if (!with_hole) return part(-kHalf, y0, kHalf, y1);
    part(-kHalf, y0, hole.min().x(), y1);
    part(hole.max().x(), y0, kHalf, y1);
    part(hole.min().x(), y0, hole.max().x(), hole.min().y());
    part(hole.min().x(), hole.max().y(), hole.max().x(), y1);
  };
  b.fixture();
  ground(-road, 0.0, 0.0, asphalt, hole_in_road);
  b.fixture();
  ground(kStone, pavement, step, paving, !hole_in_road);
  ground(0.0, kStone, step, stone, false);
  b.upright({-kHalf, 0.0}, {kHalf, 0.0}, 0.0, step, stone);
  const double rim = hole_in_road ? 0.0 : step;
  b.fixture();
  b.level(hole, rim - hole_depth, earth);
  for (int i = 0; i < 4; ++i) {
    b.upright(hole.corner(static_cast<AlignedBox2d::CornerType>(std::array{0, 1, 3, 2}[static_cast<std::size_t>(i)])),
              hole.corner(static_cast<AlignedBox2d::CornerType>(std::array{1, 3, 2, 0}[static_cast<std::size_t>(i)])),
              rim - hole_depth, rim, earth);
  }
  // The far side of the road.
  b.fixture();
  ground(-road - 3.0, -road, step, paving, false);
  b.upright({-kHalf, -road}, {kHalf, -road}, 0.0, step, stone);
  // A wall behind each pavement.
  const Material brick{
      .colour = {0.46, 0.20, 0.13}, .second = {0.40, 0.17, 0.11}, .pattern = Pattern::checker, .period_m = 0.12, .texture = 1.0};
  const double wall_height = dice.between(0.9, 2.8);
  const double far_wall_height = dice.between(1.2, 2.6);
  b.fixture();
  b.box(standing(0.0, pavement + 0.15, step, 0.0), {2.0 * kHalf, 0.3, wall_height}, brick);
  b.fixture();
  b.box(standing(0.0, -road - 3.15, step, 0.0), {2.0 * kHalf, 0.3, far_wall_height}, brick);

  // Street furniture on the pavement; the camera's own place stays free.
  Occupancy taken;
  taken.take(x, y + 0.5 * hole_length, 0.55);
  taken.take(0.0, 1.5, from_pavement ? 0.9 : 0.0);
  const AlignedBox2d kerbside(Vector2d(-1.8, 0.3), Vector2d(1.8, pavement - 0.35));
  Vector2d spot;
  const int bollards = dice.whole(1, 3);
  for (int i = 0; i < bollards; ++i) {
    if (!taken.find(dice, kerbside, 0.3, spot)) continue;
    b.object();
    b.cylinder(standing(spot.x(), spot.y(), step, 0.0), dice.between(0.05, 0.08), 0.85, plain({0.10, 0.11, 0.12}, 0.7));
  }
  if (taken.find(dice, kerbside, 0.35, spot))
    carton(b, standing(spot.x(), spot.y(), step, dice.between(-1.0, 1.0)), dice, 0.35, 0.5);
  if (dice.chance(0.6) && taken.find(dice, kerbside, 0.3, spot)) {
    b.object();
    b.cylinder(standing(spot.x(), spot.y(), step, 0.0), 0.22, 0.85, plain({0.08, 0.26, 0.14}, 0.8));
  }
  Stage stage{.scene = b.finish()};
  stage.scene.outdoors = true;
  const double look = dice.between(-0.7, 0.7);
  const double above = dice.between(1.0, 1.5);
  if (from_pavement) {
    stage.camera = {dice.between(-0.2, 0.2), 1.5, step + above};
    stage.target = {look, -0.7, 0.0};
  } else {
    stage.camera = {dice.between(-0.3, 0.3), -dice.between(1.2, 1.7), above};
    stage.target = {look, 0.6, 0.0};
  }
  stage.sway = {0.25, 0.15, 0.05};
  stage.scene.lamp = {300.0 * dice.sign(), from_pavement ? 150.0 : -150.0, 400.0};
  return stage;
}

// A desk in an office with what stands on it and its chair.
void workplace(Builder& b, const Isometry3d& base, double width, Dice& dice) {
  constexpr double kDepth = 0.75;
  const double height = dice.between(0.70, 0.76);
  table(b, base, width, kDepth, height);
  const Isometry3d top = on(base, 0.0, 0.0, height);
  Occupancy taken;
  const double x = dice.between(-0.15, 0.15) * width;
  monitor(b, on(top, x, 0.2, 0.0, dice.between(-0.2, 0.2)), dice);
  taken.take(x - 0.15, 0.22, 0.15);
  taken.take(x + 0.15, 0.22, 0.15);
  if (dice.chance(0.8)) {
    keyboard(b, on(top, x, -0.18, 0.0, dice.between(-0.1, 0.1)));
    taken.take(x - 0.13, -0.18, 0.13);
    taken.take(x + 0.13, -0.18, 0.13);
  }
  const int tall = dice.whole(1, 3);
  const int flat = dice.whole(1, 3);
  clutter(b, top, width, kDepth, taken, dice, tall, flat);
  // Turned to the desk: the back of the chair to the room.
  const double aside = dice.between(-0.2, 0.2);
  const double back = -0.5 * kDepth - dice.between(0.15, 0.4);
  chair(b, on(base, x + aside, back, 0.0, pi + dice.between(-0.8, 0.8)), dice);
}

// Furniture along a wall from a, towards b, the room to its left, leaving `corner` free at both ends.
void furnish(Builder& b, const Vector2d& a, const Vector2d& end, double corner, Occupancy& taken, Dice& dice) {
  const Vector2d along = (end - a).normalized();
  const Vector2d inward(-along.y(), along.x());
  const double length = (end - a).norm();
  const double yaw = std::atan2(inward.x(), -inward.y());  // fronts (-y) look into the room
  for (double s = corner;;) {
    const int kind = dice.whole(0, 3);
    const double width = kind <= 1 ? dice.between(1.3, 1.6) : dice.between(0.7, 1.0);
    const double depth = kind <= 1 ? 0.75 : dice.between(0.30, 0.45);
    if (s + width > length - corner) return;
    const Vector2d middle = a + (s + 0.5 * width) * along + (0.5 * depth + dice.between(0.02, 0.06)) * inward;
    const double reach = kind <= 1 ? 1.0 : 0.5 * width;
    if (taken.free(middle.x(), middle.y(), reach)) {
      const Isometry3d base = standing(middle.x(), middle.y(), 0.0, yaw);
      switch (kind) {
        case 2: shelf(b, base, width, depth, dice.between(1.5, 2.0), dice); break;
        case 3: cabinet(b, base, width, depth, dice.between(0.75, 1.25), dice); break;
        default: workplace(b, base, width, dice); break;
      }
      taken.take(middle.x(), middle.y(), 0.5 * width);
      if (kind <= 1) taken.take(middle.x() + 0.6 * inward.x(), middle.y() + 0.6 * inward.y(), 0.45);
    }
    s += width + dice.between(0.08, 0.35);
  }
}

Stage office(std::uint64_t seed) {
  Dice dice(seed, stream_index(Purpose::scene));
  const double width = dice.between(4.4, 5.6);
  const double depth = dice.between(4.6, 5.8);
  const double height = dice.between(2.6, 2.9);
  const Material paint = wall_paint(dice);
  const Material accent = wall_paint(dice);
  const Material floor = floor_cover(dice);
  const Vector2d low(-0.5 * width, 0.0);
  const Vector2d high(0.5 * width, depth);
  std::array<std::vector<Recess>, 4> recesses;
  recesses[2] = {window_recess(dice.between(0.5, width - 2.0), dice)};

  Builder b;
  room(b, {AlignedBox2d(low, high), height}, floor, {paint, paint, accent, paint}, recesses);
  const double side = dice.sign();
  const Vector3d camera{side * dice.between(0.3, 0.25 * width), dice.between(0.7, 0.9), dice.between(1.35, 1.65)};
  Occupancy taken;
  taken.take(camera.x(), camera.y(), 0.8);
  furnish(b, {high.x(), depth}, {low.x(), depth}, 0.1, taken, dice);
  furnish(b, {high.x(), 0.0}, {high.x(), depth}, 0.9, taken, dice);
  furnish(b, {low.x(), depth}, {low.x(), 0.0}, 0.9, taken, dice);
  const AlignedBox2d middle(Vector2d(-0.5 * width + 0.8, 1.6), Vector2d(0.5 * width - 0.8, depth - 1.1));
  Vector2d spot;
  if (taken.find(dice, middle, 0.8, spot)) workplace(b, standing(spot.x(), spot.y(), 0.0, dice.between(-pi, pi)), 1.3, dice);
  const int loose = dice.whole(4, 7);
  for (int i = 0; i < loose; ++i) {
    if (!taken.find(dice, middle, 0.36, spot)) continue;
    const Isometry3d base = standing(spot.x(), spot.y(), 0.0, dice.between(-pi, pi));
    switch (dice.whole(0, 3)) {
      case 0: bin(b, base, dice); break;
      case 1: plant(b, base, dice); break;
      case 2: chair(b, base, dice); break;
      default: carton(b, base, dice, 0.3, 0.5); break;
    }
  }
  Stage stage{.scene = b.finish()};
  stage.camera = camera;
  stage.target = {-side * dice.between(0.0, 0.15) * width, 0.62 * depth, dice.between(0.45, 0.7)};
  stage.sway = {0.3, 0.2, 0.1};
  stage.scene.lamp = {dice.between(-0.5, 0.5), 0.5 * depth, height - 0.25};
  return stage;
}

// No plane at all: columns so thick that each is a curved wall, and round things before them, none of which rests on anything.
Stage curved(std::uint64_t seed) {
  Dice dice(seed, stream_index(Purpose::scene));
  constexpr double kTall = 30.0;  // ends far outside the picture
  const auto column = [&](Builder& b, double x, double y, double radius, const Material& material) {
    b.fixture();
    b.cylinder(standing(x, y, -0.5 * kTall, 0.0), radius, kTall, material);
  };
  Builder b;
  const double radius = dice.between(1.0, 2.0);
  const double near = dice.between(1.8, 2.4);  // of the middle column's surface
  column(b, dice.between(-0.3, 0.3), near + radius, radius, wall_paint(dice));
  // Their neighbours run into them: creases, but no gaps.
  for (const double side : {-1.0, 1.0}) {
    const double other = dice.between(1.0, 2.0);
    const double x = side * (0.85 * (radius + other));
    column(b, x, near + radius + dice.between(0.0, 0.5) * other, other, wall_paint(dice));
  }
  const AlignedBox2d before(Vector2d(-0.8, 0.9), Vector2d(0.8, near - 0.35));
  Occupancy taken;
  Vector2d spot;
  const int things = dice.whole(4, 7);
  for (int i = 0; i < things; ++i) {
    const double thickness = dice.between(0.06, 0.22);
    if (!taken.find(dice, before, thickness, spot)) continue;
    const double z = dice.between(-0.4, 0.4);
    const Material material = bright(dice);
    switch (dice.whole(0, 2)) {
      case 0:
        b.object();
        b.sphere(standing(spot.x(), spot.y(), z, 0.0), thickness, material);
        break;
      case 1: capsule(b, standing(spot.x(), spot.y(), z - 0.2, 0.0), thickness, dice.between(0.3, 0.7), material); break;
      default: {
        const double length = dice.between(0.3, 0.6);
        const double yaw = dice.between(0.0, 2.0 * pi);
        capsule(b, lying(spot.x(), spot.y(), z, yaw), 0.6 * thickness, length, material);
        break;
      }
    }
  }
  Stage stage{.scene = b.finish()};
  stage.camera = {0.0, 0.0, 0.0};
  stage.target = {dice.between(-0.1, 0.1), 2.0, dice.between(-0.1, 0.1)};
  stage.sway = {0.1, 0.1, 0.05};
  stage.scene.lamp = {dice.between(-1.0, 1.0), -0.5, 1.5};
  return stage;
}

// Steps of a few centimetres on a desk: a low lid, a keyboard on its tray, boxes upon boxes; floor and wall behind it.
Stage boxes(std::uint64_t seed) {
  Dice dice(seed, stream_index(Purpose::scene));
  const double width = dice.between(1.4, 1.8);
  const double depth = dice.between(0.75, 0.90);
  const double height = dice.between(0.70, 0.77);
  const double back = depth + dice.between(1.9, 2.6);  // of the wall; the desk's front edge is at y = 0
  const Material paint = wall_paint(dice);
  const Material other = wall_paint(dice);
  const Material floor = floor_cover(dice);

  Builder b;
  room(b, {AlignedBox2d(Vector2d(-2.3, -1.5), Vector2d(2.5, back)), 2.6}, floor, {paint, other, paint, other});
  table(b, standing(0.0, 0.5 * depth, 0.0, dice.between(-0.05, 0.05)), width, depth, height);
  // In the frame of the desk's top: x to the right, y from its front edge, three places side by side.
  const Isometry3d top = standing(0.0, 0.0, height, 0.0);
  const double side = dice.sign();
  const double aside = 0.28 * width;

  // In front: a tray, 2 cm, and upon it a smaller one half as high.
  const double tray = dice.between(0.44, 0.52);
  const Isometry3d tray_at = on(top, dice.between(-0.05, 0.05), 0.16, 0.0, dice.between(-0.08, 0.08));
  b.object();
  b.box(tray_at, {tray, 0.20, 0.02}, metal());
  b.object();
  b.box(on(tray_at, 0.0, 0.0, 0.02), {tray - 0.08, 0.12, 0.01}, plain({0.06, 0.06, 0.065}, 0.6));

  // The lid: 2 to 4 cm.
  const double lid_height = dice.between(0.02, 0.04);
  const double lid_width = dice.between(0.26, 0.36);
  const double lid_depth = dice.between(0.19, 0.26);
  const Isometry3d lid_at = on(top, side * aside, 0.5 * depth + 0.05, 0.0, dice.between(-0.5, 0.5));
  b.object();
  b.box(lid_at, {lid_width, lid_depth, lid_height}, cardboard());

  // A pile, each box smaller than the one below and turned a little.
  double base_width = dice.between(0.28, 0.36);
  double base_depth = dice.between(0.24, 0.30);
  Isometry3d at = on(top, -side * aside, 0.62 * depth, 0.0, dice.between(-0.4, 0.4));
  const int stacked = dice.whole(2, 3);
  for (int i = 0; i < stacked; ++i) {
    const double tall = dice.between(0.06, 0.14);
    b.object();
    b.box(at, {base_width, base_depth, tall}, i % 2 == 0 ? cardboard() : book_cover(dice));
    base_width *= dice.between(0.6, 0.75);
    base_depth *= dice.between(0.6, 0.75);
    at = on(at, 0.0, 0.0, tall, dice.between(-0.3, 0.3));
  }
  // Between them, at the back, a packet; a box on the floor behind the desk.
  packet(b, on(top, dice.between(-0.06, 0.06), depth - 0.13, 0.0, dice.between(-0.25, 0.25)), dice);
  carton(b, standing(side * dice.between(0.5, 1.0), depth + 0.9, 0.0, dice.between(-pi, pi)), dice, 0.35, 0.5);

  Stage stage{.scene = b.finish()};
  stage.camera = {dice.between(-0.15, 0.15), -dice.between(0.4, 0.55), height + dice.between(0.6, 0.8)};
  stage.target = {dice.between(-0.05, 0.05), 0.6 * depth, height};
  stage.sway = {0.15, 0.08, 0.06};
  stage.scene.lamp = {dice.between(-1.2, 1.2), -0.3, 2.4};
  return stage;
}

// A door set back by 5 to 12 cm, the middle of it at `middle` along its wall.
Recess set_back_door(double middle, Dice& dice) {
  const double half = 0.5 * dice.between(0.85, 1.1);
  const double depth = dice.between(0.05, 0.12);
  return {middle - half, middle + half, 0.0, 2.05, depth, door(dice)};
}

// A hall that narrows: a floor seen to its far end, walls at three depths with doors in them, pillars, a table in the way.
Stage hall(std::uint64_t seed) {
  Dice dice(seed, stream_index(Purpose::scene));
  const double left = -dice.between(2.6, 3.6);
  const double right = dice.between(2.6, 3.6);
  const double end = dice.between(9.0, 13.0);
  const double height = dice.between(2.7, 3.3);
  const std::array<double, 2> passage{-dice.between(0.8, 1.2), dice.between(0.8, 1.2)};
  const std::array<double, 2> narrows{dice.between(4.2, 5.0), dice.between(5.2, 6.4)};
  const int first = dice.chance(0.5) ? 0 : 1;  // which side narrows first
  const double left_front = narrows[static_cast<std::size_t>(first)];
  const double right_front = narrows[static_cast<std::size_t>(1 - first)];
  const Material paint = wall_paint(dice);
  const Material other = wall_paint(dice);
  const Material accent = wall_paint(dice);
  const Material floor = floor_cover(dice);

  Builder b;
  b.fixture();
  const AlignedBox2d area(Vector2d(left, -1.0), Vector2d(right, end));
  b.level(area, 0.0, floor);
  b.level(area, height, ceiling_paint());
  // Round the hall against the clock, the room to the left.
  b.wall({left, -1.0}, {right, -1.0}, 0.0, height, other);
  b.wall({right, -1.0}, {right, right_front}, 0.0, height, paint, {set_back_door(1.0 + dice.between(2.0, 3.0), dice)});
  b.wall({right, right_front}, {passage[1], right_front}, 0.0, height, other,
         {set_back_door(dice.between(0.45, 0.55) * (right - passage[1]), dice)});
  b.wall({passage[1], right_front}, {passage[1], end}, 0.0, height, paint, {set_back_door(dice.between(0.9, 1.6), dice)});
  b.wall({passage[1], end}, {passage[0], end}, 0.0, height, accent);
  b.wall({passage[0], end}, {passage[0], left_front}, 0.0, height, paint);
  b.wall({passage[0], left_front}, {left, left_front}, 0.0, height, other,
         {set_back_door(dice.between(0.45, 0.55) * (passage[0] - left), dice)});
  b.wall({left, left_front}, {left, -1.0}, 0.0, height, paint);

  // A square pillar on one side, a round one on the other.
  const double side = dice.sign();
  const double square_y = dice.between(2.8, 3.8);
  const double round_y = dice.between(2.6, 3.9);
  const double square = dice.between(0.30, 0.45);
  b.fixture();
  b.box(standing(side * dice.between(1.2, 1.6), square_y, 0.0, 0.0), {square, square, height}, ceiling_paint());
  b.fixture();
  b.cylinder(standing(-side * dice.between(1.3, 1.7), round_y, 0.0, 0.0), dice.between(0.15, 0.25), height, metal());

  const double table_height = dice.between(0.70, 0.76);
  const Isometry3d table_at = standing(dice.between(-0.25, 0.25), dice.between(1.9, 2.2), 0.0, dice.between(-0.4, 0.4));
  table(b, table_at, dice.between(1.0, 1.3), 0.7, table_height);
  if (dice.chance(0.6)) carton(b, on(table_at, dice.between(-0.2, 0.2), 0.0, table_height), dice, 0.25, 0.35);
  if (dice.chance(0.5)) bin(b, standing(side * 0.8, square_y + 0.5, 0.0, 0.0), dice);

  Stage stage{.scene = b.finish()};
  stage.camera = {dice.between(-0.3, 0.3), dice.between(-0.2, 0.2), dice.between(1.4, 1.65)};
  stage.target = {dice.between(-0.2, 0.2), 4.0, dice.between(0.45, 0.7)};
  stage.sway = {0.25, 0.3, 0.05};
  stage.scene.lamp = {0.3 * side, 2.6, height - 0.3};
  return stage;
}

struct NamedScene {
  std::string_view name;
  BuildScene build;
};
constexpr std::array<NamedScene, 9> kScenes{
    NamedScene{"empty_room", empty_room}, NamedScene{"desk", desk}, NamedScene{"stairs", stairs},
    NamedScene{"corridor", corridor},     NamedScene{"kerb", kerb}, NamedScene{"office", office},
    NamedScene{"boxes", boxes},           NamedScene{"hall", hall}, NamedScene{"curved", curved}};

}  // namespace

BuildScene find_scene(std::string_view name) {
  for (const NamedScene& scene : kScenes) {
    if (scene.name == name) return scene.build;
  }
  return nullptr;
}

Eigen::Matrix3d facing(const Stage& stage) {
  Vector3d ahead = stage.target - stage.camera;
  ahead.z() = 0.0;
  ahead.normalize();
  Eigen::Matrix3d axes;
  axes << Vector3d(ahead.y(), -ahead.x(), 0.0), ahead, Vector3d::UnitZ();
  return axes;
}

Isometry3d looking(const Vector3d& from, const Vector3d& to) {
  const Vector3d forward = (to - from).normalized();
  const Vector3d right = forward.cross(Vector3d::UnitZ()).normalized();
  Isometry3d pose = Isometry3d::Identity();
  pose.linear() << right, forward.cross(right), forward;
  pose.translation() = from;
  return pose;
}

Isometry3d camera_pose(const Stage& stage, std::uint64_t seed, int frame) {
  constexpr double kFramesPerRound = 240.0;  // at 30 frames per second a round takes 8 s
  constexpr double kTremor_m = 0.0015;       // of a hand
  constexpr double kTremor_rad = degrees(0.1);
  constexpr double kMaxRoll_rad = degrees(4.0);

  Dice path(seed, stream_index(Purpose::path));
  Dice tremor(seed, stream_index(Purpose::tremor, frame));
  const double turn = 2.0 * pi * frame / kFramesPerRound;
  const auto swing = [&](double harmonic) { return std::sin(harmonic * turn + path.between(0.0, 2.0 * pi)); };

  const Eigen::Matrix3d axes = facing(stage);
  Vector3d position = stage.camera;
  position += stage.sway.x() * swing(1.0) * axes.col(0);
  position += stage.sway.y() * swing(1.0) * axes.col(1);
  position += stage.sway.z() * swing(2.0) * axes.col(2);
  for (double& coordinate : position) coordinate += kTremor_m * tremor.normal();

  const Isometry3d pose = looking(position, stage.target);
  const double roll = kMaxRoll_rad * swing(1.0) + kTremor_rad * tremor.normal();
  const double pitch = kTremor_rad * tremor.normal();
  const double yaw = kTremor_rad * tremor.normal();
  return pose * Eigen::AngleAxisd(roll, Vector3d::UnitZ()) * Eigen::AngleAxisd(pitch, Vector3d::UnitX()) *
         Eigen::AngleAxisd(yaw, Vector3d::UnitY());
}

}  // namespace detail

std::span<const std::string_view> scene_names() {
  static constexpr auto kNames = [] {
    std::array<std::string_view, detail::kScenes.size()> names;
    for (std::size_t i = 0; i < names.size(); ++i) names[i] = detail::kScenes[i].name;
    return names;
  }();
  return kNames;
}

}  // namespace fransac::synth
