// SPDX-License-Identifier: Apache-2.0
// Real frames made into organised clouds, as PCL's grabbers write them, and back.
#include <gtest/gtest.h>

#include <cstddef>
#include <filesystem>
#include <limits>
#include <string>

#include "fransac/filter/organised.hpp"
#include "fransac/io/dataset.hpp"
#include "support.hpp"

namespace fransac {
namespace {

PointCloud organised_cloud(const io::Frame& frame) {
  constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();
  const DepthView depth = frame.view();
  const Camera& c = frame.camera;
  PointCloud cloud;
  cloud.resize(depth.size());
  cloud.width = depth.width();
  cloud.height = depth.height();
  std::size_t i = 0;
  for (int v = 0; v < depth.height(); ++v) {
    for (int u = 0; u < depth.width(); ++u, ++i) {
      // In floats throughout, as programs do.
      const float z = depth.metres(u, v);
      const float x = z * (static_cast<float>(u) - static_cast<float>(c.cx)) / static_cast<float>(c.fx);
      const float y = z * (static_cast<float>(v) - static_cast<float>(c.cy)) / static_cast<float>(c.fy);
      cloud.set(i, z > 0.0F ? Eigen::Vector3f(x, y, z) : Eigen::Vector3f::Constant(kNaN));
    }
  }
  return cloud;
}

TEST(OrganisedData, RealFramesComeBack) {
  const std::filesystem::path data(FRANSAC_DATA_DIR);
  if (!std::filesystem::exists(data)) GTEST_SKIP() << "no " << data;
  for (const char* name : {"tum/scene2", "tum/scene6", "mosd/learn07", "icl_nuim/living_room_0000"}) {
    SCOPED_TRACE(name);
    const auto dataset = io::list_frames(data / name);
    ASSERT_TRUE(dataset) << dataset.error().message;
    const auto frame = io::load_frame(dataset->frames.front());
    ASSERT_TRUE(frame) << frame.error().message;
    OrganisedDepth found;
    const Status status = organised_depth(organised_cloud(*frame), found);
    ASSERT_TRUE(status) << status.error().message;
    EXPECT_NEAR(found.camera.fx, frame->camera.fx, 1e-3);
    EXPECT_NEAR(found.camera.fy, frame->camera.fy, 1e-3);
    EXPECT_NEAR(found.camera.cx, frame->camera.cx, 1e-3);
    EXPECT_NEAR(found.camera.cy, frame->camera.cy, 1e-3);
    EXPECT_LT(found.max_px, 1e-3);
    const DepthView depth = frame->view();
    std::size_t i = 0;
    for (int v = 0; v < depth.height(); ++v) {
      for (int u = 0; u < depth.width(); ++u) ASSERT_EQ(found.metres[i++], depth.metres(u, v));
    }
  }
}

}  // namespace
}  // namespace fransac
