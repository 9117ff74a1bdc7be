// SPDX-License-Identifier: Apache-2.0
/// Calibration on real frames: what some frames of a camera show makes planes of its other frames flatter.
#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <vector>

#include "fransac/calibrate/calibrate.hpp"
#include "fransac/core/labels.hpp"
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

/// How much true planes are bent: the root mean square of the smooth part, a polynomial of the fourth degree, of what is left
/// beside the plane; metres.
struct Bent {
  double squares = 0.0;
  double blocks = 0.0;

  void add(const DepthView& depth, const io::LabelImage& labels, int label) {
    constexpr int kBlock = 8;
    constexpr int kPlane = 3;
    constexpr int kSmooth = 12;  // terms of degree 2 to 4
    std::vector<double> q;
    std::vector<Eigen::Matrix<double, 1, kPlane + kSmooth>> rows;
    for (int v0 = 0; v0 + kBlock <= depth.height(); v0 += kBlock) {
      for (int u0 = 0; u0 + kBlock <= depth.width(); u0 += kBlock) {
        double sum = 0.0;
        int count = 0;
        for (int i = 0; i < kBlock * kBlock; ++i) {
          const int u = u0 + i % kBlock;
          const int v = v0 + i / kBlock;
          const double z = static_cast<double>(depth.metres(u, v));
          if (labels.pixels[static_cast<std::size_t>(v * depth.width() + u)] != label || !(z > 0.0)) continue;
          sum += 1.0 / z;
          ++count;
        }
        if (count < 58) continue;  // nine tenths
        const double x = (2.0 * u0 + kBlock) / depth.width() - 1.0;
        const double y = (2.0 * v0 + kBlock) / depth.height() - 1.0;
        const auto terms = distortion_terms(x, y);
        rows.emplace_back();
        rows.back() << 1.0, x, y, Eigen::Map<const Eigen::Matrix<double, 1, kSmooth>>(terms.data());
        q.push_back(sum / count);
      }
    }
    if (q.size() < 150) return;
    // Blocks that objects reach into count for little (Cauchy's weights).
    Eigen::VectorXd weights = Eigen::VectorXd::Ones(static_cast<Eigen::Index>(q.size()));
    Eigen::MatrixXd design(weights.size(), kPlane + kSmooth);
    for (Eigen::Index i = 0; i < design.rows(); ++i) design.row(i) = rows[static_cast<std::size_t>(i)];
    const Eigen::Map<const Eigen::VectorXd> measured(q.data(), weights.size());
    const auto fitted = [&](Eigen::Index columns, const Eigen::VectorXd& values) -> Eigen::VectorXd {
      const auto part = design.leftCols(columns);
      Eigen::MatrixXd normal = part.transpose() * weights.asDiagonal() * part;
      normal.diagonal().array() += 1e-6 * static_cast<double>(q.size());
      return part * normal.ldlt().solve(part.transpose() * weights.asDiagonal() * values);
    };
    Eigen::VectorXd left;
    for (int round = 0; round < 8; ++round) {
      left = measured - fitted(kPlane, measured);
      std::vector<double> sizes(q.size());
      for (std::size_t i = 0; i < q.size(); ++i) sizes[i] = std::abs(left[static_cast<Eigen::Index>(i)]);
      std::nth_element(sizes.begin(), sizes.begin() + static_cast<std::ptrdiff_t>(q.size() / 2), sizes.end());
      const double scale = 2.0 * 1.4826 * sizes[q.size() / 2] + 1e-9;
      weights = (1.0 + (left.array() / scale).square()).square().inverse().matrix();
    }
    const Eigen::VectorXd metres = (fitted(design.cols(), left).array() / measured.array().square()).matrix();
    squares += metres.squaredNorm();
    blocks += static_cast<double>(q.size());
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
    ::testing::Test::RecordProperty(std::string("before_mm_") + std::to_string(part), std::to_string(1e3 * before.rms_m()));
    ::testing::Test::RecordProperty(std::string("after_mm_") + std::to_string(part), std::to_string(1e3 * after.rms_m()));
    EXPECT_LT(after.rms_m(), most_share * before.rms_m())
        << "before " << 1e3 * before.rms_m() << " mm, after " << 1e3 * after.rms_m() << " mm";
  }
}

TEST(CalibrateData, HalfOfAKinectsTablesHalveTheBendOfTheOthers) { expect_flatter("mosd", 0.5); }
TEST(CalibrateData, HalfOfAScannersBlocksHalveTheBendOfTheOthers) { expect_flatter("segcomp_abw", 0.5); }

}  // namespace
}  // namespace fransac
