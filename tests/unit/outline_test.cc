// SPDX-License-Identifier: Apache-2.0
#include "fransac/planes/outline.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <chrono>
#include <limits>
#include <string>
#include <vector>

#include "outlines.hpp"
#include "support.hpp"

namespace fransac {
namespace {

using testing::area_px;
using ::testing::ElementsAre;
using ::testing::IsEmpty;
using testing::kExact;
using testing::label_image;
using ::testing::SizeIs;

std::vector<Outline> of_first(const std::vector<std::string>& rows, const OutlineOptions& options = kExact) {
  const Segmentation s = label_image(rows);
  return outlines(s, testing::small_camera(s.width, s.height), 1, options);
}

TEST(Outline, OnePixelIsASquareAnticlockwiseAsDisplayed) {
  const std::vector<Outline> parts = of_first({"...", ".1.", "..."});
  ASSERT_THAT(parts, SizeIs(1));
  EXPECT_THAT(parts[0].holes, IsEmpty());
  // Top left, bottom left, bottom right, top right: v points down.
  EXPECT_THAT(parts[0].outer.pixels, ElementsAre(Eigen::Vector2d(0.5, 0.5), Eigen::Vector2d(0.5, 1.5), Eigen::Vector2d(1.5, 1.5),
                                                 Eigen::Vector2d(1.5, 0.5)));
}

TEST(Outline, TheWholeImageEndsHalfAPixelBeyondItsPixels) {
  const std::vector<Outline> parts = of_first({"111", "111"});
  ASSERT_THAT(parts, SizeIs(1));
  EXPECT_THAT(parts[0].outer.pixels, ElementsAre(Eigen::Vector2d(-0.5, -0.5), Eigen::Vector2d(-0.5, 1.5),
                                                 Eigen::Vector2d(2.5, 1.5), Eigen::Vector2d(2.5, -0.5)));
}

TEST(Outline, AHoleTurnsTheOtherWayRound) {
  const std::vector<Outline> parts = of_first({"1111", "1..1", "1111"});
  ASSERT_THAT(parts, SizeIs(1));
  EXPECT_EQ(area_px(parts[0].outer), -12.0);
  ASSERT_THAT(parts[0].holes, SizeIs(1));
  EXPECT_EQ(area_px(parts[0].holes[0]), 2.0);
  EXPECT_THAT(parts[0].holes[0].pixels, SizeIs(4));
}

TEST(Outline, PixelsThatMeetAtACornerArePartsOfTheirOwn) {
  EXPECT_THAT(of_first({"1.", ".1"}), SizeIs(2));
  EXPECT_THAT(of_first({".1", "1."}), SizeIs(2));
}

TEST(Outline, HolesThatMeetAtACornerAreOne) {
  const std::vector<Outline> parts = of_first({"11111", "11.11", "1.111", "11111"});
  ASSERT_THAT(parts, SizeIs(1));
  ASSERT_THAT(parts[0].holes, SizeIs(1));
  EXPECT_EQ(area_px(parts[0].holes[0]), 2.0);
}

TEST(Outline, APartMayTouchItselfAtACorner) {
  // The pixel in the middle hangs together with the notch by its corner: no hole, the outer ring passes that corner twice.
  const std::vector<Outline> parts = of_first({"1111", "1.11", "11.1", "11.1"});
  ASSERT_THAT(parts, SizeIs(1));
  EXPECT_EQ(area_px(parts[0].outer), -13.0);
  EXPECT_THAT(parts[0].holes, IsEmpty());
}

TEST(Outline, AnIslandInAHoleIsAPartAndOtherLabelsAreHoles) {
  const std::vector<std::string> rows{"11111", "12221", "12121", "12221", "11111"};
  const Segmentation s = label_image(rows);
  const auto all = outlines(s, testing::small_camera(5, 5), kExact);
  ASSERT_THAT(all, SizeIs(2));
  ASSERT_THAT(all[0], SizeIs(2));
  EXPECT_EQ(area_px(all[0][0].outer), -25.0);
  ASSERT_THAT(all[0][0].holes, SizeIs(1));
  EXPECT_EQ(area_px(all[0][0].holes[0]), 9.0);
  EXPECT_EQ(area_px(all[0][1].outer), -1.0);
  ASSERT_THAT(all[1], SizeIs(1));
  EXPECT_EQ(area_px(all[1][0].outer), -9.0);
  ASSERT_THAT(all[1][0].holes, SizeIs(1));
}

TEST(Outline, PartsWithMostPixelsComeFirst) {
  // The frame encloses more than the block but has fewer pixels.
  const std::vector<Outline> parts = of_first({"1.11111.111", "1.1...1.111", "..1...1.111", "..1...1.111", "..11111.111"});
  ASSERT_THAT(parts, SizeIs(3));
  EXPECT_THAT(parts[0].holes, SizeIs(1));  // 16 pixels
  EXPECT_EQ(area_px(parts[1].outer), -15.0);
  EXPECT_EQ(area_px(parts[2].outer), -2.0);
}

TEST(Outline, SmallPartsAndHolesAreLeftOut) {
  const std::vector<std::string> rows{"11111.1", "1.111.1", "11111..", "11..1..", "11111.1"};
  const std::vector<Outline> two = of_first(rows, {0.0, 2});
  ASSERT_THAT(two, SizeIs(2));
  EXPECT_THAT(two[0].holes, SizeIs(1));
  EXPECT_THAT(two[1].outer.pixels, SizeIs(4));
  const std::vector<Outline> three = of_first(rows, {0.0, 3});
  ASSERT_THAT(three, SizeIs(1));
  EXPECT_THAT(three[0].holes, IsEmpty());
  EXPECT_THAT(of_first(rows, {0.0, 23}), IsEmpty());
  EXPECT_THAT(of_first(rows, {0.0, -5}), SizeIs(3));
}

TEST(Outline, OnePlaneIsWhatItIsAmongAll) {
  const Segmentation s = label_image({"112233", "112213", "111111"});
  const Camera camera = testing::small_camera(6, 3);
  const auto all = outlines(s, camera, kExact);
  for (const PlaneSegment& segment : s.planes) {
    const std::vector<Outline> one = outlines(s, camera, segment.id, kExact);
    const std::vector<Outline>& same = all[static_cast<std::size_t>(segment.id - 1)];
    ASSERT_EQ(one.size(), same.size());
    for (std::size_t i = 0; i < one.size(); ++i) {
      EXPECT_EQ(one[i].outer.pixels, same[i].outer.pixels);
      EXPECT_EQ(one[i].outer.points, same[i].outer.points);
    }
  }
}

TEST(Outline, NothingOfWhatIsNotThere) {
  Segmentation s = label_image({"11", "11"});
  const Camera camera = testing::small_camera(2, 2);
  EXPECT_THAT(outlines(s, camera, 2, kExact), IsEmpty());
  EXPECT_THAT(outlines(s, camera, 0, kExact), IsEmpty());
  EXPECT_THAT(outlines(s, camera, 255, kExact), IsEmpty());
  EXPECT_THAT(outlines(s, camera, -1, kExact), IsEmpty());
  EXPECT_THAT(outlines(s, testing::small_camera(4, 1), 1, kExact), IsEmpty());
  EXPECT_THAT(outlines(Segmentation{}, camera, kExact), IsEmpty());
  s.labels.pop_back();
  EXPECT_THAT(outlines(s, camera, kExact), ElementsAre(IsEmpty()));
  s.planes[0].id = 255;  // no plane's label
  s.labels.assign(4, 255);
  EXPECT_THAT(outlines(s, camera, kExact), ElementsAre(IsEmpty()));
}

TEST(Outline, StairsOfADiagonalBecomeALine) {
  std::vector<std::string> rows(20, std::string(20, '.'));
  for (std::size_t v = 0; v < 20; ++v) rows[v].replace(0, v + 1, std::string(v + 1, '1'));
  EXPECT_THAT(of_first(rows)[0].outer.pixels, SizeIs(42));
  const std::vector<Outline> simple = of_first(rows, {1.0, 1});
  ASSERT_THAT(simple, SizeIs(1));
  EXPECT_THAT(simple[0].outer.pixels, SizeIs(::testing::Le(4U)));
  EXPECT_LT(area_px(simple[0].outer), 0.0);
}

TEST(Outline, ARingThatWouldCollapseStays) {
  const std::vector<std::string> strip{std::string(100, '1')};
  for (const double tolerance : {1.0, 50.0, 1e9, std::numeric_limits<double>::infinity()}) {
    const std::vector<Outline> parts = of_first(strip, {tolerance, 1});
    ASSERT_THAT(parts, SizeIs(1));
    EXPECT_GE(parts[0].outer.pixels.size(), 3U);
    EXPECT_LT(area_px(parts[0].outer), 0.0);
  }
  EXPECT_THAT(of_first(strip, {std::numeric_limits<double>::quiet_NaN(), 1})[0].outer.pixels, SizeIs(4));
}

TEST(Outline, CornersLieOnThePlaneWithTheNormalToTheirLeft) {
  Segmentation s = label_image(std::vector<std::string>(60, std::string(80, '1')));
  s.planes[0].plane = *make_plane({0.1, -0.8, -0.6}, 1.5);
  const Camera camera = testing::small_camera();
  const std::vector<Outline> parts = outlines(s, camera, 1);
  ASSERT_THAT(parts, SizeIs(1));
  const Ring& ring = parts[0].outer;
  ASSERT_THAT(ring.points, SizeIs(4));
  Eigen::Vector3d doubled_area = Eigen::Vector3d::Zero();
  for (std::size_t i = 0; i < 4; ++i) {
    const Eigen::Vector3d& p = ring.points[i];
    EXPECT_GT(p.z(), 0.0);
    EXPECT_NEAR(s.planes[0].plane.signed_distance(p), 0.0, 1e-12 * p.norm());
    EXPECT_NEAR(p.x() / p.z() * camera.fx + camera.cx, ring.pixels[i].x(), 1e-9);
    EXPECT_NEAR(p.y() / p.z() * camera.fy + camera.cy, ring.pixels[i].y(), 1e-9);
    doubled_area += p.cross(ring.points[(i + 1) % 4]);
  }
  EXPECT_GT(doubled_area.dot(s.planes[0].plane.normal), 0.0);
}

TEST(Outline, BeyondTheHorizonCornersGetADepthBeforeIt) {
  Segmentation s = label_image(std::vector<std::string>(60, std::string(80, '1')));
  const Camera camera = testing::small_camera();
  s.planes[0].plane = *make_plane({0.0, -1.0, 0.0}, 1.5);  // the horizon crosses the image at cy
  const double deepest = 1.5 * camera.fy;
  const std::vector<Outline> parts = outlines(s, camera, 1);
  ASSERT_THAT(parts, SizeIs(1));
  ASSERT_THAT(parts[0].outer.points, SizeIs(4));
  for (const Eigen::Vector3d& p : parts[0].outer.points) {
    EXPECT_GT(p.z(), 0.0);
    EXPECT_LE(p.z(), deepest * (1.0 + 1e-12));
  }
  // Through the camera, behind it, far away: finite all the same.
  for (const Plane& plane : {Plane{{0.0, -1.0, 0.0}, 0.0}, Plane{{0.0, 0.0, 1.0}, 2.0}, Plane{{0.0, 0.0, -1.0}, 1e300}}) {
    s.planes[0].plane = plane;
    const std::vector<Outline> hostile = outlines(s, camera, 1);
    for (const Eigen::Vector3d& p : hostile[0].outer.points) {
      EXPECT_TRUE(p.allFinite());
      EXPECT_GE(p.z(), 0.0);
      EXPECT_LE(p.z(), static_cast<double>(kMaxDepth_m));
    }
  }
}

/// A comb of one-pixel teeth whose tips rise by a pixel every few teeth: Douglas and Peucker's worst case.
Segmentation comb(int width, int height) {
  std::vector<std::string> rows(static_cast<std::size_t>(height), std::string(static_cast<std::size_t>(width), '1'));
  for (int u = 1; u < width; u += 2) {
    const int tip = (width - u) * (height - 2) / width;
    for (int v = 0; v <= tip; ++v) rows[static_cast<std::size_t>(v)][static_cast<std::size_t>(u)] = '.';
  }
  return label_image(rows);
}

TEST(Outline, HostileImagesTakeNoLongerThanOthers) {
  std::vector<std::string> board(600, std::string(800, '1'));
  for (std::size_t v = 0; v < 600; ++v) {
    for (std::size_t u = v % 2; u < 800; u += 2) board[v][u] = '2';
  }
  const auto squares = outlines(label_image(board), testing::small_camera(800, 600), kExact);
  EXPECT_THAT(squares[0], SizeIs(240000));
  EXPECT_THAT(squares[1], SizeIs(240000));
  EXPECT_THAT(outlines(label_image(board), testing::small_camera(800, 600)), ElementsAre(IsEmpty(), IsEmpty()));

  // 60,000 corners: their square would take seconds.
  const auto start = std::chrono::steady_clock::now();
  const auto teeth = outlines(comb(30000, 64), testing::small_camera(30000, 64));
  EXPECT_LT(std::chrono::steady_clock::now() - start, std::chrono::seconds(2));
  ASSERT_THAT(teeth[0], SizeIs(1));
}

}  // namespace
}  // namespace fransac
