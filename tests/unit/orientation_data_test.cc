// SPDX-License-Identifier: Apache-2.0
/// Up directions of real and rendered frames, from their annotated planes.
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <filesystem>
#include <map>
#include <numbers>
#include <vector>

#include "fransac/io/dataset.hpp"
#include "fransac/planes/orientation.hpp"
#include "fransac/sac/plane_problem.hpp"
#include "support.hpp"

namespace fransac {
namespace {

/// Least-squares planes of the labels, with their visible area and centroid.
std::vector<PlaneSegment> annotated_planes(const io::Frame& frame) {
  struct Sums {
    sac::Moments moments;
    double cubes = 0.0;
  };
  const DepthView view = frame.view();
  std::map<int, Sums> sums;
  for (int v = 0; v < view.height(); ++v) {
    for (int u = 0; u < view.width(); ++u) {
      const int label = frame.labels->pixels[static_cast<std::size_t>(v * view.width() + u)];
      const auto z = static_cast<double>(view.metres(u, v));
      if (label < kLabelFirst || label > kMaxPlanes || z <= 0.0) continue;
      sums[label].moments.add(z * testing::ray(frame.camera, u, v));
      sums[label].cubes += z * z * z;
    }
  }
  std::vector<PlaneSegment> planes;
  for (const auto& [label, sum] : sums) {
    const auto fit = sac::fit_plane(sum.moments);
    if (!fit) continue;
    PlaneSegment& segment = planes.emplace_back();
    segment.id = label;
    segment.plane = fit->plane;
    segment.centroid = sum.moments.sum / static_cast<double>(sum.moments.count);
    segment.area_m2 = sum.cubes / (frame.camera.fx * frame.camera.fy * segment.plane.d);
  }
  return planes;
}

/// Calls visit(frame, its annotated planes) for every frame of a data set. Returns whether the data are there.
template <class Visitor>
bool for_each_frame(const char* dataset, const Visitor& visit) {
  const std::filesystem::path folder = std::filesystem::path(FRANSAC_DATA_DIR) / dataset;
  if (!std::filesystem::exists(folder)) return false;
  const auto frames = io::list_frames(folder);
  EXPECT_TRUE(frames.ok()) << folder;
  for (const io::FrameFiles& files : frames->frames) {
    const auto frame = io::load_frame(files);
    EXPECT_TRUE(frame.ok()) << files.name;
    SCOPED_TRACE(files.name);
    visit(*frame, annotated_planes(*frame));
  }
  return true;
}

double degrees_between(const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
  return std::atan2(a.cross(b).norm(), a.dot(b)) * 180.0 / std::numbers::pi;
}

TEST(Orientation, FloorsOfRealRooms) {
  const bool there = for_each_frame("tum", [](const io::Frame& frame, std::vector<PlaneSegment> planes) {
    const auto up = estimate_up(planes);
    ASSERT_TRUE(up.has_value());
    // The first label is the floor; its coefficients were found by other means.
    for (const auto& [label, plane] : frame.true_planes) {
      if (label != 1) continue;
      EXPECT_LT(degrees_between(up->direction, plane.normal), 5.0);
    }
    classify(up->direction, planes);
    EXPECT_EQ(planes[0].kind, PlaneKind::floor);
    EXPECT_EQ(std::count_if(planes.begin(), planes.end(), [](const auto& s) { return s.kind == PlaneKind::floor; }), 1);
  });
  if (!there) GTEST_SKIP() << "no data in " << FRANSAC_DATA_DIR;
}

TEST(Orientation, FloorAndCeilingOfARenderedRoom) {
  const bool there = for_each_frame("icl_nuim", [](const io::Frame&, std::vector<PlaneSegment> planes) {
    const auto up = estimate_up(planes);
    ASSERT_TRUE(up.has_value());
    EXPECT_LT(degrees_between(up->direction, -Eigen::Vector3d::UnitY()), 0.5);
    classify(up->direction, planes);
    const auto kind_of = [&](int id) {
      return std::find_if(planes.begin(), planes.end(), [id](const PlaneSegment& s) { return s.id == id; })->kind;
    };
    EXPECT_EQ(kind_of(1), PlaneKind::wall);
    EXPECT_EQ(kind_of(2), PlaneKind::wall);
    EXPECT_EQ(kind_of(3), PlaneKind::ceiling);
    EXPECT_EQ(kind_of(5), PlaneKind::horizontal);
    EXPECT_EQ(kind_of(7), PlaneKind::floor);
  });
  if (!there) GTEST_SKIP() << "no data in " << FRANSAC_DATA_DIR;
}

TEST(Orientation, TablesAlone) {
  const bool there = for_each_frame("mosd", [](const io::Frame&, const std::vector<PlaneSegment>& planes) {
    const auto up = estimate_up(planes);
    ASSERT_TRUE(up.has_value());
    EXPECT_LT(degrees_between(up->direction, planes[0].plane.normal), 0.1);
  });
  if (!there) GTEST_SKIP() << "no data in " << FRANSAC_DATA_DIR;
}

}  // namespace
}  // namespace fransac
