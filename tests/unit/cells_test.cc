// SPDX-License-Identifier: Apache-2.0
// The method `cells` on depth images whose planes are known exactly: what is found, what is said of it, and what options do.
#include "cells.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <limits>
#include <numbers>
#include <numeric>
#include <set>

#include "fransac/core/random.hpp"
#include "fransac/planes/segment.hpp"
#include "support.hpp"

namespace fransac {
namespace {

using testing::cells;
using testing::cells_options;
using testing::expect_same;
using testing::expect_sane;
using testing::FloatImage;
using testing::kinect;

constexpr double kDegree = std::numbers::pi / 180.0;
constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();
constexpr float kInf = std::numeric_limits<float>::infinity();

/// The plane through (0, 0, z) that is turned away from the camera by so much about the y axis, and then about the x axis.
Plane tilted(double z, double yaw_deg, double pitch_deg = 0.0) {
  const Eigen::Vector3d normal(std::sin(yaw_deg * kDegree), std::cos(yaw_deg * kDegree) * std::sin(pitch_deg * kDegree),
                               -std::cos(yaw_deg * kDegree) * std::cos(pitch_deg * kDegree));
  return *make_plane(normal, -normal.z() * z);
}

struct Box {
  int left, top, right, bottom;  ///< The last two are not inside.
};

/// A picture of planes; those drawn later hide the others where they are nearer.
struct Scene {
  explicit Scene(const Camera& camera) : image(camera), truth(image.metres.size(), 0) {}

  void draw(const Plane& plane, Box box, bool in_front = false) {
    planes.push_back(plane);
    for (int v = box.top; v < box.bottom; ++v) {
      for (int u = box.left; u < box.right; ++u) {
        const auto z = static_cast<float>(testing::depth_on(plane, image.camera, u, v));
        if (!(z > 0.0F) || (in_front && image.at(u, v) > 0.0F && image.at(u, v) <= z)) continue;
        image.at(u, v) = z;
        truth[at(u, v)] = static_cast<std::uint8_t>(planes.size());
      }
    }
  }
  void draw(const Plane& plane) { draw(plane, {0, 0, image.camera.width, image.camera.height}, true); }
  void remove(Box box) {
    for (int v = box.top; v < box.bottom; ++v) {
      for (int u = box.left; u < box.right; ++u) {
        image.at(u, v) = 0.0F;
        truth[at(u, v)] = 0;
      }
    }
  }
  [[nodiscard]] std::size_t at(int u, int v) const {
    return static_cast<std::size_t>(v) * static_cast<std::size_t>(image.camera.width) + static_cast<std::size_t>(u);
  }
  /// Whether the truth is the same for some pixels in all directions.
  [[nodiscard]] bool away_from_edges(int u, int v) const {
    constexpr int kPixels = 3;
    for (int y = std::max(0, v - kPixels); y <= std::min(image.camera.height - 1, v + kPixels); ++y) {
      for (int x = std::max(0, u - kPixels); x <= std::min(image.camera.width - 1, u + kPixels); ++x) {
        if (truth[at(x, y)] != truth[at(u, v)]) return false;
      }
    }
    return true;
  }

  FloatImage image;
  std::vector<std::uint8_t> truth;
  std::vector<Plane> planes;
};

/// Each plane is found once, with these coefficients, and labels are the truth's away from edges.
void expect_found(const Scene& scene, const Segmentation& s, double angle_rad = 1e-4, double offset_m = 1e-4) {
  expect_sane(s, scene.image.view());
  ASSERT_EQ(s.planes.size(), scene.planes.size());
  std::array<std::uint8_t, 256> label_of{};
  for (std::size_t k = 0; k < scene.planes.size(); ++k) {
    const auto found = std::min_element(s.planes.begin(), s.planes.end(), [&](const PlaneSegment& a, const PlaneSegment& b) {
      const auto off = [&](const PlaneSegment& x) {
        return (x.plane.normal - scene.planes[k].normal).norm() + std::abs(x.plane.d - scene.planes[k].d);
      };
      return off(a) < off(b);
    });
    EXPECT_LE(angle_between(found->plane, scene.planes[k]), angle_rad) << "plane " << k + 1;
    EXPECT_NEAR(found->plane.d, scene.planes[k].d, offset_m) << "plane " << k + 1;
    label_of[k + 1] = static_cast<std::uint8_t>(found->id);
  }
  std::size_t wrong = 0;
  for (int v = 0; v < s.height; ++v) {
    for (int u = 0; u < s.width; ++u) {
      if (scene.away_from_edges(u, v) && s.labels[scene.at(u, v)] != label_of[scene.truth[scene.at(u, v)]]) ++wrong;
    }
  }
  EXPECT_EQ(wrong, 0U);
}

// ---- planes, exactly ----

TEST(Cells, OnePlane) {
  for (const double yaw : {0.0, 30.0, -50.0}) {
    SCOPED_TRACE(yaw);
    Scene scene(kinect());
    scene.draw(tilted(1.5, yaw, 20.0));
    const Segmentation s = cells(scene.image.view(), scene.image.camera);
    expect_found(scene, s, 1e-5, 1e-5);
    EXPECT_EQ(s.planes[0].inliers, scene.image.metres.size());
    EXPECT_LT(s.planes[0].rms_m, 1e-5);
  }
}

TEST(Cells, APlaneUpToItsHorizon) {
  Scene scene(kinect());
  scene.draw(*make_plane({0.0, -1.0, 0.0}, 1.2));
  const Segmentation s = cells(scene.image.view(), scene.image.camera);
  expect_sane(s, scene.image.view());
  ASSERT_EQ(s.planes.size(), 1U);
  EXPECT_LE(angle_between(s.planes[0].plane, scene.planes[0]), 1e-4);
  EXPECT_NEAR(s.planes[0].plane.d, 1.2, 1e-3);
}

TEST(Cells, ThreePlanesOfACorner) {
  Scene scene(kinect());
  scene.draw(*make_plane({0.0, -1.0, -0.2}, 1.2));
  scene.draw(tilted(2.5, 50.0));
  scene.draw(tilted(2.5, -40.0));
  expect_found(scene, cells(scene.image.view(), scene.image.camera));
}

TEST(Cells, AnIslandInAHole) {
  // What is behind is seen through a window, all around a board, and on both sides of a frame.
  Scene scene(kinect());
  scene.draw(tilted(3.0, 10.0));
  scene.draw(tilted(1.5, -5.0), {150, 100, 500, 400});
  for (int v = 180; v < 320; ++v) {
    for (int u = 240; u < 420; ++u) {
      scene.image.at(u, v) = static_cast<float>(testing::depth_on(scene.planes[0], scene.image.camera, u, v));
      scene.truth[scene.at(u, v)] = 1;
    }
  }
  scene.remove({300, 220, 340, 260});
  expect_found(scene, cells(scene.image.view(), scene.image.camera));
}

TEST(Cells, APlaneOnBothSidesOfWhatHidesIt) {
  Scene scene(kinect());
  scene.draw(tilted(2.0, 5.0));
  scene.draw(tilted(1.0, 0.0), {280, 0, 360, 480});
  expect_found(scene, cells(scene.image.view(), scene.image.camera));
}

TEST(Cells, AStepOfThreeCentimetres) {
  Scene scene(kinect());
  scene.draw(tilted(1.0, 0.0));
  scene.draw(tilted(0.97, 0.0), {200, 150, 420, 330});
  expect_found(scene, cells(scene.image.view(), scene.image.camera));
}

TEST(Cells, FarWallsThatMeetAtASmallAngleStayTwo) {
  Scene scene(kinect());
  scene.draw(tilted(4.5, -6.0));
  scene.draw(tilted(4.5, 6.0));
  RandomStream random(0, 0);
  for (float& z : scene.image.metres) z += static_cast<float>(kKinectNoise_per_m * random.normal()) * z * z;
  const Segmentation s = cells(scene.image.view(), scene.image.camera);
  ASSERT_EQ(s.planes.size(), 2U);
  EXPECT_NEAR(std::acos(s.planes[0].plane.normal.dot(s.planes[1].plane.normal)), 12.0 * kDegree, kDegree);
}

TEST(Cells, NoiseIsNotTakenForPrecisionWhereNeighbouringPixelsErrAlike) {
  // Windows of disparity that are wider than a pixel of this camera is high.
  Camera camera = kinect(160);
  camera.height = 480;
  camera.fy *= 4.0;
  camera.cy = 239.5;
  const Result<synth::SynthFrame> frame = synth::render({.scene = "desk", .seed = 1, .camera = camera});
  ASSERT_TRUE(frame);
  const Segmentation s = cells(testing::view_of(*frame), camera);
  EXPECT_GT(s.noise.sigma_m(1.0), 0.5 * kKinectNoise_per_m);
}

TEST(Cells, ACreaseOfTenDegrees) {
  Scene scene(kinect());
  scene.draw(tilted(1.5, -5.0));
  scene.draw(tilted(1.5, 5.0));
  expect_found(scene, cells(scene.image.view(), scene.image.camera));
}

TEST(Cells, QuantisedDepth) {
  Scene scene(kinect());
  scene.draw(tilted(1.5, -30.0, 10.0));
  scene.draw(tilted(1.5, 40.0, 10.0));
  std::vector<std::uint16_t> units;
  for (const float z : scene.image.metres) units.push_back(static_cast<std::uint16_t>(std::lround(1000.0F * z)));
  const Segmentation s = cells(DepthView::from_uint16(units.data(), 640, 480, 1000.0), scene.image.camera);
  expect_found(scene, s, 0.05 * kDegree, 1e-3);
}

TEST(Cells, SizesThatAreNoMultipleOfACell) {
  for (const auto& [width, height] : {std::pair{641, 481}, {639, 479}, {100, 75}, {37, 29}, {8, 640}, {17, 8}}) {
    SCOPED_TRACE(::testing::Message() << width << " x " << height);
    Scene scene(kinect(width, height));
    scene.draw(tilted(1.2, 15.0, 15.0));
    const Segmentation s = cells(scene.image.view(), scene.image.camera);
    expect_sane(s, scene.image.view());
    if (width < 24 || height < 24) continue;  // fewer than three cells: too little to call a plane
    expect_found(scene, s, 1e-4, 1e-4);
    EXPECT_EQ(s.planes[0].inliers, scene.image.metres.size());
  }
}

// ---- what is said of a plane ----

Scene room() {
  Scene scene(kinect());
  scene.draw(*make_plane({0.0, -1.0, 0.0}, 1.3));
  scene.draw(tilted(3.0, 25.0));
  scene.draw(tilted(1.4, -10.0), {350, 120, 520, 300}, true);
  RandomStream random = testing::test_random();
  for (float& z : scene.image.metres) z *= static_cast<float>(1.0 + 1e-3 * static_cast<double>(z) * random.normal());
  return scene;
}

TEST(CellsEvidence, IsThatOfTheLabels) {
  const Scene scene = room();
  const Camera& camera = scene.image.camera;
  SegmentOptions options = cells_options();
  options.cells.residuals = true;
  const Segmentation s = cells(scene.image.view(), camera, options);
  expect_sane(s, scene.image.view());
  ASSERT_EQ(s.planes.size(), 3U);
  ASSERT_EQ(s.residuals_m.size(), s.labels.size());
  std::vector<double> squares(3), areas(3);
  std::vector<Eigen::Vector3d> sums(3, Eigen::Vector3d::Zero());
  for (int v = 0; v < s.height; ++v) {
    for (int u = 0; u < s.width; ++u) {
      const std::size_t i = scene.at(u, v);
      if (s.labels[i] == kLabelNoPlane || s.labels[i] == kLabelNoDepth) {
        EXPECT_TRUE(std::isnan(s.residuals_m[i]));
        continue;
      }
      const std::size_t k = s.labels[i] - 1U;
      const Plane& plane = s.planes[k].plane;
      const Eigen::Vector3d ray = testing::ray(camera, u, v);
      const double off = plane.signed_distance(static_cast<double>(scene.image.metres[i]) * ray);
      ASSERT_NEAR(static_cast<double>(s.residuals_m[i]), off, 1e-6);
      const double z = testing::depth_on(plane, camera, u, v);
      squares[k] += off * off;
      sums[k] += z * ray;
      areas[k] += z * z / (camera.fx * camera.fy * std::abs(plane.normal.dot(ray)));
    }
  }
  for (std::size_t k = 0; k < 3; ++k) {
    SCOPED_TRACE(k + 1);
    const auto n = static_cast<double>(s.planes[k].inliers);
    EXPECT_NEAR(s.planes[k].rms_m, std::sqrt(squares[k] / n), 1e-3 * s.planes[k].rms_m);
    // Pixels count at their cell's centre, those of a cell at an edge at its mean depth.
    EXPECT_NEAR(s.planes[k].area_m2, areas[k], 0.01 * areas[k]);
    EXPECT_LT((s.planes[k].centroid - sums[k] / n).norm(), 0.003 * s.planes[k].centroid.z());
    EXPECT_NEAR(s.planes[k].plane.signed_distance(s.planes[k].centroid), 0.0, 0.01);
  }
}

TEST(CellsEvidence, CountsPixels) {
  const Scene scene = room();
  const Segmentation s = cells(scene.image.view(), scene.image.camera);
  EXPECT_EQ(s.method, Method::cells);
  EXPECT_EQ(s.valid_points, scene.image.metres.size() -
                                static_cast<std::size_t>(std::count(scene.image.metres.begin(), scene.image.metres.end(), 0.0F)));
  EXPECT_EQ(s.sampled_points, s.valid_points);
  EXPECT_TRUE(s.residuals_m.empty());
}

/// Independent errors of inverse depth.
void add_noise(double sigma_q, RandomStream& random, FloatImage& image) {
  for (float& z : image.metres) {
    if (z > 0.0F) z = static_cast<float>(1.0 / (1.0 / static_cast<double>(z) + sigma_q * random.normal()));
  }
}

TEST(CellsEvidence, CovarianceIsThatOfIndependentErrors) {
  constexpr int kRuns = 60;
  const Camera camera = kinect(160, 120);
  const Plane truth = tilted(1.5, 30.0, -10.0);
  std::vector<Eigen::Vector4d> errors;
  Eigen::Matrix4d said = Eigen::Matrix4d::Zero();
  for (int run = 0; run < kRuns; ++run) {
    RandomStream random = testing::test_random(static_cast<std::uint64_t>(run));
    FloatImage image(camera);
    image.draw(truth);
    add_noise(1.425e-3, random, image);
    const Segmentation s = cells(image.view(), camera);
    ASSERT_EQ(s.planes.size(), 1U);
    errors.emplace_back();
    errors.back() << s.planes[0].plane.normal - truth.normal, s.planes[0].plane.d - truth.d;
    said += s.planes[0].covariance / kRuns;
  }
  Eigen::Matrix4d seen = Eigen::Matrix4d::Zero();
  for (const Eigen::Vector4d& e : errors) seen += e * e.transpose() / kRuns;
  // In the three directions in which a plane can be off.
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix4d> axes(said);
  const Eigen::Matrix<double, 4, 3> basis = axes.eigenvectors().rightCols<3>();
  const Eigen::GeneralizedSelfAdjointEigenSolver<Eigen::Matrix3d> ratio(basis.transpose() * seen * basis,
                                                                        basis.transpose() * said * basis);
  EXPECT_LT(std::sqrt(ratio.eigenvalues()[2]), 3.0) << "errors in sigmas";
  EXPECT_GT(std::sqrt(ratio.eigenvalues()[0]), 1.0 / 3.0) << "errors in sigmas";
}

// ---- options ----

/// A small near board (most pixels) before a far wall (most square metres).
Scene board_and_wall() {
  Scene scene(kinect());
  scene.draw(tilted(4.0, 0.0));
  scene.draw(tilted(1.0, 5.0), {0, 0, 500, 480});
  return scene;
}

TEST(CellsOptions, OrderByAreaOrSupport) {
  const Scene scene = board_and_wall();
  SegmentOptions options = cells_options();
  const Segmentation by_area = cells(scene.image.view(), scene.image.camera, options);
  ASSERT_EQ(by_area.planes.size(), 2U);
  EXPECT_NEAR(by_area.planes[0].plane.d, 4.0, 1e-3);
  EXPECT_EQ(by_area.labels.back(), 1);
  options.order = PlaneOrder::support;
  const Segmentation by_support = cells(scene.image.view(), scene.image.camera, options);
  ASSERT_EQ(by_support.planes.size(), 2U);
  EXPECT_NEAR(by_support.planes[1].plane.d, 4.0, 1e-3);
  EXPECT_EQ(by_support.labels.back(), 2);
  EXPECT_GT(by_support.planes[0].inliers, by_support.planes[1].inliers);
}

/// Of the two planes the second one is left out.
void expect_first_only(const Segmentation& s, const Scene& scene) {
  expect_sane(s, scene.image.view());
  ASSERT_EQ(s.planes.size(), 1U);
  EXPECT_EQ(s.planes[0].id, 1);
  EXPECT_EQ(std::set<int>(s.labels.begin(), s.labels.end()), (std::set<int>{1, kLabelNoPlane}));
}

/// A wall 1 m away beside a larger one far away, with a Kinect's noise.
Scene near_and_far(double far_m) {
  Scene scene(kinect());
  scene.draw(tilted(1.0, 0.0), {0, 0, 200, 480});
  scene.draw(tilted(far_m, 0.0), {200, 0, 640, 480});
  RandomStream random = testing::test_random();
  for (float& z : scene.image.metres) z = 1.0F / (1.0F / z + static_cast<float>(kKinectNoise_per_m * random.normal()));
  return scene;
}

/// So far away that depth is known worse than to 10 cm, a few pixels span metres: what is near and certain comes first.
TEST(CellsOptions, ByAreaPlanesOfUncertainDepthComeLast) {
  constexpr double kFar_m = 9.0;
  const Scene scene = near_and_far(kFar_m);
  SegmentOptions options = cells_options();
  const Segmentation by_area = cells(scene.image.view(), scene.image.camera, options);
  ASSERT_EQ(by_area.planes.size(), 2U);
  EXPECT_NEAR(by_area.planes[0].plane.d, 1.0, 0.01);
  EXPECT_GT(by_area.planes[1].area_m2, 50.0 * by_area.planes[0].area_m2);
  options.order = PlaneOrder::support;
  const Segmentation by_support = cells(scene.image.view(), scene.image.camera, options);
  ASSERT_EQ(by_support.planes.size(), 2U);
  EXPECT_NEAR(by_support.planes[0].plane.d, kFar_m, 0.1);
}

/// Depth that is not known to 20 cm says nothing of planes: a Kinect's beyond 12 m.
TEST(Cells, NoPlaneWhereDepthIsNotKnown) {
  const Scene scene = near_and_far(15.0);
  const Segmentation s = cells(scene.image.view(), scene.image.camera);
  ASSERT_EQ(s.planes.size(), 1U);
  EXPECT_NEAR(s.planes[0].plane.d, 1.0, 0.01);
}

TEST(CellsOptions, SmallPlanesAreLeftOut) {
  Scene scene(kinect());
  scene.draw(tilted(2.0, 0.0));
  scene.draw(tilted(1.0, 0.0), {200, 200, 328, 296});  // 0.04 of the image, 0.045 m^2
  ASSERT_EQ(cells(scene.image.view(), scene.image.camera).planes.size(), 2U);
  SegmentOptions options = cells_options();
  options.min_support = 0.045;
  expect_first_only(cells(scene.image.view(), scene.image.camera, options), scene);
  options.min_support = 0.035;
  EXPECT_EQ(cells(scene.image.view(), scene.image.camera, options).planes.size(), 2U);
  options = cells_options();
  options.cells.min_area_m2 = 0.05;
  expect_first_only(cells(scene.image.view(), scene.image.camera, options), scene);
  options.cells.min_area_m2 = 0.04;
  EXPECT_EQ(cells(scene.image.view(), scene.image.camera, options).planes.size(), 2U);
}

TEST(CellsOptions, MaxPlanes) {
  const Scene scene = board_and_wall();
  SegmentOptions options = cells_options();
  options.max_planes = 1;
  const Segmentation s = cells(scene.image.view(), scene.image.camera, options);
  expect_first_only(s, scene);
  EXPECT_NEAR(s.planes[0].plane.d, 4.0, 1e-3);
}

TEST(CellsOptions, OnlyPlanesOfADirection) {
  const Scene scene = room();                  // a floor and two walls
  const Eigen::Vector3d down(0.0, 2.0, 0.24);  // to within 7 degrees
  SegmentOptions options = cells_options();
  options.cells.parallel_to = down;
  Segmentation s = cells(scene.image.view(), scene.image.camera, options);
  expect_sane(s, scene.image.view());
  ASSERT_EQ(s.planes.size(), 1U);
  EXPECT_GT(std::abs(s.planes[0].plane.normal.y()), 0.99);
  options.cells.prior_angle_deg = 5.0;
  s = cells(scene.image.view(), scene.image.camera, options);
  EXPECT_TRUE(s.planes.empty());
  options = cells_options();
  options.cells.perpendicular_to = down;
  s = cells(scene.image.view(), scene.image.camera, options);
  expect_sane(s, scene.image.view());
  ASSERT_EQ(s.planes.size(), 2U);
  for (const PlaneSegment& plane : s.planes) EXPECT_LT(std::abs(plane.plane.normal.y()), 0.01);
}

/// A strip one cell wide has no block of cells that a search could start from. A plane that is expected there needs none.
TEST(CellsOptions, AnExpectedPlaneIsSeenInAStripOfOneCell) {
  constexpr int kCell_px = 4;  // of exact depth
  Scene scene(kinect());
  scene.draw(tilted(1.5, 20.0, 10.0), {320, 0, 320 + kCell_px, 480});
  Workspace workspace;
  Segmentation s;
  ASSERT_TRUE(segment(scene.image.view(), scene.image.camera, cells_options(), workspace, s));
  EXPECT_TRUE(s.planes.empty());
  PlaneSegment expected{.plane = scene.planes[0]};
  expected.centroid =
      testing::depth_on(expected.plane, scene.image.camera, 322, 240) * testing::ray(scene.image.camera, 322, 240);
  workspace.expect({&expected, 1});
  ASSERT_TRUE(segment(scene.image.view(), scene.image.camera, cells_options(), workspace, s));
  ASSERT_EQ(s.planes.size(), 1U);
  EXPECT_LE(angle_between(s.planes[0].plane, scene.planes[0]), 1e-3);
  // Nothing is seen where the camera does not look, or looks at something else.
  for (const double factor : {-1.0, 0.0, 1.1}) {
    PlaneSegment elsewhere = expected;
    elsewhere.plane.d *= factor;
    elsewhere.centroid *= factor;
    workspace.expect({&elsewhere, 1});
    ASSERT_TRUE(segment(scene.image.view(), scene.image.camera, cells_options(), workspace, s));
    EXPECT_TRUE(s.planes.empty()) << factor;
  }
}

TEST(CellsOptions, PassThrough) {
  const Scene scene = board_and_wall();
  SegmentOptions options = cells_options();
  options.pass_through.limits.max_m = 2.0;
  const Segmentation s = cells(scene.image.view(), scene.image.camera, options);
  expect_sane(s, scene.image.view());
  ASSERT_EQ(s.planes.size(), 1U);
  EXPECT_NEAR(s.planes[0].plane.d, scene.planes[1].d, 1e-4);
  EXPECT_EQ(s.valid_points, scene.image.metres.size());
  EXPECT_EQ(s.sampled_points, 500U * 480U);
  for (std::size_t i = 0; i < s.labels.size(); ++i) ASSERT_EQ(s.labels[i], scene.truth[i] == 2 ? 1 : kLabelNoPlane) << i;
}

TEST(CellsOptions, Up) {
  const Scene scene = room();
  SegmentOptions options = cells_options();
  options.up = Eigen::Vector3d(0.0, -3.0, 0.0);
  Segmentation s = cells(scene.image.view(), scene.image.camera, options);
  EXPECT_EQ(s.up_source, UpSource::given);
  ASSERT_TRUE(s.up);
  EXPECT_EQ(*s.up, Eigen::Vector3d(0.0, -1.0, 0.0));
  std::multiset<PlaneKind> kinds;
  for (const PlaneSegment& plane : s.planes) kinds.insert(plane.kind);
  EXPECT_EQ(kinds, (std::multiset<PlaneKind>{PlaneKind::floor, PlaneKind::wall, PlaneKind::wall}));
  options.up.reset();
  s = cells(scene.image.view(), scene.image.camera, options);
  EXPECT_EQ(s.up_source, UpSource::estimated);
  ASSERT_TRUE(s.up);
  EXPECT_LT(s.up->y(), -0.98);
}

TEST(CellsOptions, AutomaticIsCells) {
  const Scene scene = room();
  const Result<Segmentation> s = segment(scene.image.view(), scene.image.camera);
  ASSERT_TRUE(s);
  EXPECT_EQ(s->method, Method::cells);
  EXPECT_EQ(s->planes.size(), 3U);
}

// ---- images ----

/// The scene in 16 bits, and the same depths as floats.
struct BothFormats {
  explicit BothFormats(const Scene& scene) {
    for (const float z : scene.image.metres) {
      units.push_back(static_cast<std::uint16_t>(std::lround(5000.0F * z)));
      metres.push_back(static_cast<float>(units.back()) / 5000.0F);
    }
  }
  std::vector<std::uint16_t> units;
  std::vector<float> metres;
};

TEST(CellsImages, SixteenBitsAndFloatsGiveTheSameAnswer) {
  const Scene scene = room();
  const BothFormats both(scene);
  const Segmentation a = cells(DepthView::from_uint16(both.units.data(), 640, 480, 5000.0), scene.image.camera);
  const Segmentation b = cells(DepthView::from_float(both.metres.data(), 640, 480), scene.image.camera);
  testing::expect_same_to_rounding(a, b, 1e-6);
}

TEST(CellsImages, WhatIsBetweenRowsDoesNotMatter) {
  const Scene scene = room();
  const BothFormats both(scene);
  for (const std::size_t stride : {640U, 641U, 648U, 704U}) {
    SCOPED_TRACE(stride);
    std::vector<std::uint16_t> units(stride * 480, 1234);
    std::vector<float> metres(stride * 480, 0.9F);
    for (std::size_t v = 0; v < 480; ++v) {
      std::memcpy(&units[v * stride], &both.units[v * 640], 640 * sizeof(std::uint16_t));
      std::memcpy(&metres[v * stride], &both.metres[v * 640], 640 * sizeof(float));
    }
    const auto bytes = [&](std::size_t size) { return static_cast<std::ptrdiff_t>(stride * size); };
    expect_same(cells(DepthView::from_uint16(units.data(), 640, 480, 5000.0, bytes(2)), scene.image.camera),
                cells(DepthView::from_uint16(both.units.data(), 640, 480, 5000.0), scene.image.camera));
    expect_same(cells(DepthView::from_float(metres.data(), 640, 480, bytes(4)), scene.image.camera),
                cells(DepthView::from_float(both.metres.data(), 640, 480), scene.image.camera));
  }
}

TEST(CellsImages, OfAnySize) {
  for (const auto& [width, height] : {std::pair{1, 1}, {2, 2}, {8, 8}, {1, 640}, {640, 1}, {7, 9}, {16, 16}, {9, 200}}) {
    SCOPED_TRACE(::testing::Message() << width << " x " << height);
    FloatImage image(kinect(width, height));
    image.camera.fx = image.camera.fy = 500.0;
    image.draw(tilted(1.0, 5.0));
    const Result<Segmentation> s = segment(image.view(), image.camera, cells_options());
    if (width * height < 3) {
      ASSERT_FALSE(s);
      EXPECT_EQ(s.error().code, ErrorCode::no_data);
      continue;
    }
    ASSERT_TRUE(s) << s.error().message;
    expect_sane(*s, image.view());
  }
}

TEST(CellsImages, WithoutMeasurements) {
  FloatImage image(kinect(80, 60));
  Result<Segmentation> s = segment(image.view(), image.camera, cells_options());
  ASSERT_FALSE(s);
  EXPECT_EQ(s.error().code, ErrorCode::no_data);
  image.at(40, 30) = 1.0F;
  s = segment(image.view(), image.camera, cells_options());
  ASSERT_FALSE(s);
  EXPECT_EQ(s.error().code, ErrorCode::no_data);
  image.at(41, 30) = image.at(40, 31) = 1.0F;
  s = segment(image.view(), image.camera, cells_options());
  ASSERT_TRUE(s) << s.error().message;
  EXPECT_TRUE(s->planes.empty());
  expect_sane(*s, image.view());
}

TEST(CellsImages, WhatIsNotFiniteWasNotMeasured) {
  Scene scene(kinect());
  scene.draw(tilted(1.5, 20.0));
  const float bad[] = {kNaN, kInf, -kInf, -1.0F, 0.0F, std::numeric_limits<float>::max()};
  RandomStream random = testing::test_random();
  Scene holes = scene;
  for (std::size_t i = 0; i < scene.image.metres.size(); ++i) {
    if (random.below(5) != 0) continue;
    scene.image.metres[i] = bad[random.below(6)];
    holes.image.metres[i] = 0.0F;
  }
  const Segmentation s = cells(scene.image.view(), scene.image.camera);
  expect_sane(s, scene.image.view());
  ASSERT_EQ(s.planes.size(), 1U);
  EXPECT_LE(angle_between(s.planes[0].plane, scene.planes[0]), 1e-4);
  expect_same(s, cells(holes.image.view(), scene.image.camera));
}

TEST(CellsImages, AsFarAsSixteenBitsReach) {
  constexpr std::uint16_t kFarthest = 65534;  // 65535 says that nothing was measured
  const std::vector<std::uint16_t> far(640 * 480, kFarthest);
  for (const double scale : {1000.0, 5000.0, 1.0}) {
    SCOPED_TRACE(scale);
    const DepthView depth = DepthView::from_uint16(far.data(), 640, 480, scale);
    const Segmentation s = cells(depth, kinect());
    expect_sane(s, depth);
    if (scale == 1.0) {  // 65 km: no sensor knows depth there well enough for a plane
      EXPECT_TRUE(s.planes.empty());
      continue;
    }
    ASSERT_EQ(s.planes.size(), 1U);
    EXPECT_NEAR(s.planes[0].plane.d, kFarthest / scale, 1e-4 * kFarthest / scale);
    EXPECT_EQ(s.planes[0].inliers, far.size());
  }
}

TEST(CellsImages, RandomDepthIsNoPlane) {
  RandomStream random = testing::test_random();
  std::vector<std::uint16_t> noise(640 * 480);
  const DepthView depth = DepthView::from_uint16(noise.data(), 640, 480, 5000.0);
  for (const std::uint32_t range : {65536U, 5000U, 500U}) {
    SCOPED_TRACE(range);
    for (std::uint16_t& raw : noise)
      raw = static_cast<std::uint16_t>(std::min(65534U, 5000U + static_cast<std::uint32_t>(random.below(range))));
    const Segmentation s = cells(depth, kinect());
    expect_sane(s, depth);
    EXPECT_TRUE(s.planes.empty());
  }
}

/// Squares of one cell are no planes: none has a neighbour on its plane. Of larger ones, which measure three cells and more, the
/// far ones are one plane, which the near ones hide; these are several, because the camera sees past them.
TEST(CellsImages, ACheckerboardOfTwoDepths) {
  constexpr float kNear = 1.0F;
  constexpr float kFar = 1.5F;
  for (const int square : {1, 2, 4, 8, 24, 32, 64}) {
    SCOPED_TRACE(square);
    FloatImage image(kinect());
    for (int v = 0; v < 480; ++v) {
      for (int u = 0; u < 640; ++u) image.at(u, v) = (u / square + v / square) % 2 == 0 ? kNear : kFar;
    }
    const Segmentation s = cells(image.view(), image.camera);
    expect_sane(s, image.view());
    if (square <= 8) {
      EXPECT_TRUE(s.planes.empty());
      continue;
    }
    ASSERT_GT(s.planes.size(), 2U);
    EXPECT_EQ(s.planes[0].inliers, s.labels.size() / 2);
    std::size_t on_planes = 0;
    for (const PlaneSegment& plane : s.planes) {
      EXPECT_NEAR(plane.plane.normal.z(), -1.0, 1e-6) << plane.id;
      EXPECT_NEAR(plane.plane.d, static_cast<double>(plane.id == 1 ? kFar : kNear), 1e-6) << plane.id;
      on_planes += plane.inliers;
    }
    EXPECT_GE(on_planes, s.labels.size() * 99 / 100);
    for (std::size_t i = 0; i < s.labels.size(); ++i) {
      ASSERT_TRUE(s.labels[i] == kLabelNoPlane || (s.labels[i] == 1) == (image.metres[i] == kFar)) << i;
    }
  }
}

/// The segmentation where there should be one; else no planes, after a look at the error.
Segmentation expect_answer(const FloatImage& image, const Camera& camera, ErrorCode code, const std::string& word) {
  Result<Segmentation> s = segment(image.view(), camera, cells_options());
  if (word.empty()) {
    EXPECT_TRUE(s) << s.error().message;
    if (!s) return {};
    expect_sane(*s, image.view());
    return *std::move(s);
  }
  EXPECT_FALSE(s) << word;
  if (s) return {};
  EXPECT_EQ(s.error().code, code);
  EXPECT_THAT(s.error().message, ::testing::HasSubstr(word));
  return {};
}

TEST(CellsImages, HostileDepthIsNotMeasuredOrInNoPlane) {
  constexpr float kHuge = std::numeric_limits<float>::max();
  constexpr float kTiny = std::numeric_limits<float>::denorm_min();
  constexpr float kOfSensors = 0.01F;  // metres: nearer than any sensor sees
  FloatImage image(testing::small_camera(96, 72));
  const float measured[] = {9e4F, 2.0F, 1.001F, 1.0F, 1e-10F, 1e-30F, 1e-38F, kTiny};
  for (const float z : measured) {
    SCOPED_TRACE(z);
    std::fill(image.metres.begin(), image.metres.end(), z);
    const Segmentation s = expect_answer(image, image.camera, {}, "");
    EXPECT_EQ(s.valid_points, image.metres.size());
    if (z < kOfSensors || z > 9e3F) continue;
    ASSERT_EQ(s.planes.size(), 1U);
    EXPECT_NEAR(s.planes[0].plane.d, static_cast<double>(z), 1e-6);
  }
  const float unmeasured[] = {kHuge, 1e30F, 1e10F, 0.0F, -1.0F, kNaN};
  for (const float z : unmeasured) {
    SCOPED_TRACE(z);
    std::fill(image.metres.begin(), image.metres.end(), z);
    expect_answer(image, image.camera, ErrorCode::no_data, "there are 0 with a measurement");
  }
  RandomStream random = testing::test_random();
  for (int run = 0; run < 10; ++run) {
    std::size_t count = 0;
    for (float& z : image.metres) {
      const bool is_measured = random.below(2) == 0;
      z = is_measured ? measured[random.below(std::size(measured))] : unmeasured[random.below(std::size(unmeasured))];
      count += is_measured ? 1U : 0U;
    }
    const Segmentation s = expect_answer(image, image.camera, {}, "");
    EXPECT_EQ(s.valid_points, count);
    EXPECT_TRUE(s.planes.empty());
  }
}

TEST(CellsImages, HostileCamerasAreErrors) {
  FloatImage image(testing::small_camera(96, 72));
  image.draw(tilted(1.0, 20.0));
  for (const double extreme : {1e-300, 1e-40, 1e-10, 0.0, -70.0, 1e10, 1e300, std::nan("")}) {
    SCOPED_TRACE(extreme);
    Camera camera = image.camera;
    camera.fx = extreme;
    expect_answer(image, camera, ErrorCode::invalid_argument, "\"fx\"");
    camera = image.camera;
    camera.fy = extreme;
    expect_answer(image, camera, ErrorCode::invalid_argument, "\"fy\"");
  }
  for (const double extreme : {-1e10, 1e10, 1e300, std::nan("")}) {
    SCOPED_TRACE(extreme);
    Camera camera = image.camera;
    camera.cx = extreme;
    expect_answer(image, camera, ErrorCode::invalid_argument, "\"cx\"");
    camera = image.camera;
    camera.cy = extreme;
    expect_answer(image, camera, ErrorCode::invalid_argument, "\"cy\"");
  }
  // Within what is allowed, however unlikely, an answer.
  for (const double focal : {0.1, 1e6}) {
    Camera camera = image.camera;
    camera.fx = camera.fy = focal;
    expect_answer(image, camera, {}, "");
  }
}

}  // namespace
}  // namespace fransac
