// SPDX-License-Identifier: Apache-2.0
/// OpenCV's rgbd::RgbdPlane as packaged, with its own block size, without normals (faster) and with them.
/// Labels: its mask.
#include <opencv2/core.hpp>
#include <opencv2/rgbd/depth.hpp>

#include "labelling.hpp"

namespace fransac::bench {
namespace {

class OpencvRgbdPlane final : public Peer {
 public:
  explicit OpencvRgbdPlane(bool normals) : with_normals_(normals) { planes_from_.setThreshold(kThreshold_m); }

  [[nodiscard]] std::string id() const override { return with_normals_ ? "opencv-rgbdplane-normals" : "opencv-rgbdplane"; }

  void load(const Frame& frame) override {
    labels_.resize(frame.size());
    camera_ = (cv::Mat_<float>(3, 3) << frame.fx, 0, frame.cx, 0, frame.fy, frame.cy, 0, 0, 1);
    if (!with_normals_) return;
    normals_from_ = cv::makePtr<cv::rgbd::RgbdNormals>(frame.height, frame.width, CV_32F, camera_);
    normals_from_->initialize();
  }

  bool run(const Frame& frame, Answer& answer) override {
    // OpenCV has no read-only view of somebody's memory; it only reads.
    const cv::Mat raw(frame.height, frame.width, CV_16U, const_cast<std::uint16_t*>(frame.depth));
    cv::rgbd::rescaleDepth(raw, CV_32F, depth_, frame.depth_scale);
    cv::rgbd::depthTo3d(depth_, camera_, points_);
    if (with_normals_) {
      (*normals_from_)(points_, normals_);
      planes_from_(points_, normals_, mask_, coefficients_);
    } else {
      planes_from_(points_, mask_, coefficients_);
    }
    if (coefficients_.empty()) return false;

    for (int v = 0; v < frame.height; ++v) {
      const std::uint8_t* const row = mask_.ptr<std::uint8_t>(v);
      for (int u = 0; u < frame.width; ++u) {
        const std::size_t i = static_cast<std::size_t>(v) * static_cast<std::size_t>(frame.width) + static_cast<std::size_t>(u);
        labels_[i] = frame.depth[i] == 0 ? kNoDepth : row[u] < kNoPlane - 1 ? static_cast<std::uint8_t>(row[u] + 1) : kNoPlane;
      }
    }
    const std::vector<std::uint8_t> mask_order = labels_;
    const std::vector<std::size_t> sizes = order_by_size(labels_);
    if (sizes.empty()) return false;
    std::size_t first = 0;
    while (labels_[first] != kFirstPlane) ++first;
    const cv::Vec4f plane = coefficients_.at(static_cast<std::size_t>(mask_order[first] - 1));
    for (int i = 0; i < 4; ++i) answer.plane[i] = static_cast<double>(plane[i]);
    answer.planes = static_cast<int>(sizes.size());
    answer.inliers = sizes.front();
    answer.labels = labels_.data();
    return true;
  }

 private:
  bool with_normals_;
  cv::Mat camera_;
  cv::Mat depth_;
  cv::Mat points_;
  cv::Mat normals_;
  cv::Mat mask_;
  std::vector<cv::Vec4f> coefficients_;
  cv::Ptr<cv::rgbd::RgbdNormals> normals_from_;
  cv::rgbd::RgbdPlane planes_from_;
  std::vector<std::uint8_t> labels_;
};

}  // namespace

void add_opencv(Party& party) {
  cv::setNumThreads(1);
  party.peers.push_back(std::make_unique<OpencvRgbdPlane>(false));
  party.peers.push_back(std::make_unique<OpencvRgbdPlane>(true));
  party.versions.emplace_back("opencv", CV_VERSION);
}

}  // namespace fransac::bench
