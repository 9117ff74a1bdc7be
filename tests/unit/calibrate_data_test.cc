// SPDX-License-Identifier: Apache-2.0
/// Calibration on real frames: what some frames of a camera show makes planes of its other frames flatter.
#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <cmath>
#include <filesystem>
#include <vector>

#include "fransac/calibrate/calibrate.hpp"
#include "fransac/filter/correct.hpp"
#include "fransac/io/dataset.hpp"

namespace fransac {
namespace {

std::vector<io::Frame> load(const char* dataset) {
  std::vector<io::Frame> frames;
  const std::filesystem::path folder = std::filesystem::path(FRANSAC_DATA_DIR) / dataset;
  if (!std::filesystem::exists(folder)) return frames;
  const auto listed = io::list_frames(folder);
  EXPECT_TRUE(listed);
  for (const io::FrameFiles& files : listed->frames) {
    auto frame = io::load_frame(files);
    EXPECT_TRUE(frame) << (frame ? "" : frame.error().message);
    frames.push_back(std::move(*frame));
  }
  return frames;
}

/// Sum and number of squared means over blocks of 32 x 32 pixels of the difference, metres, of true planes from their best plane.
struct Bent {
  double squares = 0.0;
  double blocks = 0.0;

  void add(const DepthView& depth, const io::LabelImage& labels, int label) {
    constexpr int kBlock = 32;
    const auto each = [&](int u0, int v0, int width, int height, auto&& visit) {
      for (int v = v0; v < v0 + height; ++v) {
        for (int u = u0; u < u0 + width; ++u) {
          const double z = static_cast<double>(depth.metres(u, v));
          if (labels.pixels[static_cast<std::size_t>(v * depth.width() + u)] == label && z > 0.0) visit(u, v, 1.0 / z);
        }
      }
    };
    Eigen::Matrix3d normal = Eigen::Matrix3d::Zero();
    Eigen::Vector3d right = Eigen::Vector3d::Zero();
    each(0, 0, depth.width(), depth.height(), [&](int u, int v, double q) {
      const Eigen::Vector3d a(1.0, u, v);
      normal += a * a.transpose();
      right += q * a;
    });
    const Eigen::Vector3d plane = normal.ldlt().solve(right);
    for (int v0 = 0; v0 + kBlock <= depth.height(); v0 += kBlock) {
      for (int u0 = 0; u0 + kBlock <= depth.width(); u0 += kBlock) {
        double sum = 0.0;
        double count = 0.0;
        each(u0, v0, kBlock, kBlock, [&](int u, int v, double q) {
          sum += (q - plane.dot(Eigen::Vector3d(1.0, u, v))) / (q * q);
          count += 1.0;
        });
        if (count < 0.8 * kBlock * kBlock) continue;
        squares += (sum / count) * (sum / count);
        blocks += 1.0;
      }
    }
  }
  [[nodiscard]] double rms_m() const { return std::sqrt(squares / blocks); }
};

/// Labels with many pixels.
std::vector<int> large_planes(const io::LabelImage& labels) {
  std::vector<std::size_t> pixels(256);
  for (const std::uint8_t label : labels.pixels) ++pixels[label];
  std::vector<int> large;
  for (int label = kLabelFirst; label <= kMaxPlanes; ++label) {
    if (pixels[static_cast<std::size_t>(label)] > labels.pixels.size() / 30) large.push_back(label);
  }
  return large;
}

/// The bend of true planes in frames that take no part in the calibration, before and after correction.
void expect_flatter(const char* dataset, double most_share) {
  const std::vector<io::Frame> frames = load(dataset);
  if (frames.empty()) GTEST_SKIP() << "no " << dataset;
  for (const std::size_t part : {0U, 1U}) {
    std::vector<CalibrationFrame> shown;
    for (std::size_t i = part; i < frames.size(); i += 2) shown.push_back({frames[i].view(), frames[i].camera});
    const auto found = calibrate(shown);
    ASSERT_TRUE(found) << found.error().message;
    ASSERT_FALSE(found->sensor.distortion.empty());
    Bent before;
    Bent after;
    for (std::size_t i = 1 - part; i < frames.size(); i += 2) {
      CorrectedDepth corrected;
      ASSERT_TRUE(correct(frames[i].view(), found->sensor.distortion, 65535, corrected));
      for (const int label : large_planes(*frames[i].labels)) {
        before.add(frames[i].view(), *frames[i].labels, label);
        after.add(corrected.view, *frames[i].labels, label);
      }
    }
    RecordProperty(std::string("before_mm_") + std::to_string(part), std::to_string(1e3 * before.rms_m()));
    RecordProperty(std::string("after_mm_") + std::to_string(part), std::to_string(1e3 * after.rms_m()));
    EXPECT_LT(after.rms_m(), most_share * before.rms_m())
        << "before " << 1e3 * before.rms_m() << " mm, after " << 1e3 * after.rms_m() << " mm";
  }
}

TEST(CalibrateData, HalfOfAKinectsTablesHalveTheBendOfTheOthers) { expect_flatter("mosd", 0.5); }
TEST(CalibrateData, HalfOfAScannersBlocksHalveTheBendOfTheOthers) { expect_flatter("segcomp_abw", 0.5); }

}  // namespace
}  // namespace fransac
