// SPDX-License-Identifier: Apache-2.0
/// What the machine allows: plain loops, compiled for it, into memory that is warm.
#include <cmath>
#include <cstring>

#include "labelling.hpp"

namespace fransac::bench {
namespace {

/// Copying the depth frame.
class CopyFloor final : public Peer {
 public:
  [[nodiscard]] std::string id() const override { return "floor-copy"; }
  void load(const Frame& frame) override { copy_.resize(frame.size()); }
  bool run(const Frame& frame, Answer& /*answer*/) override {
    std::memcpy(copy_.data(), frame.depth, frame.size() * sizeof(std::uint16_t));
    return true;
  }

 private:
  std::vector<std::uint16_t> copy_;
};

void deproject(const Frame& frame, const float* __restrict ray_x, float* __restrict x, float* __restrict y, float* __restrict z) {
  const auto scale = static_cast<float>(1.0 / frame.depth_scale);
  const auto width = static_cast<std::size_t>(frame.width);
  for (int v = 0; v < frame.height; ++v) {
    const auto ray_y = static_cast<float>((v - frame.cy) / frame.fy);
    const std::size_t row = static_cast<std::size_t>(v) * width;
    for (std::size_t u = 0; u < width; ++u) {
      const float depth = static_cast<float>(frame.depth[row + u]) * scale;
      x[row + u] = depth * ray_x[u];
      y[row + u] = depth * ray_y;
      z[row + u] = depth;
    }
  }
}

/// x, y and z of every pixel as three arrays.
class DeprojectFloor final : public Peer {
 public:
  [[nodiscard]] std::string id() const override { return "floor-deproject"; }
  void load(const Frame& frame) override {
    for (auto* values : {&x_, &y_, &z_}) values->resize(frame.size());
    ray_x_.clear();
    for (int u = 0; u < frame.width; ++u) ray_x_.push_back(static_cast<float>((u - frame.cx) / frame.fx));
  }
  bool run(const Frame& frame, Answer& /*answer*/) override {
    deproject(frame, ray_x_.data(), x_.data(), y_.data(), z_.data());
    return true;
  }

 private:
  std::vector<float> ray_x_;
  std::vector<float> x_;
  std::vector<float> y_;
  std::vector<float> z_;
};

/// n . r of a pixel's ray is a ramp along its row: a label takes one addition and one multiply-add.
void label(const Frame& frame, const float* __restrict column, std::uint8_t* __restrict labels) {
  const auto d = static_cast<float>(frame.plane[3]);
  const auto threshold = static_cast<float>(kThreshold_m);
  const auto width = static_cast<std::size_t>(frame.width);
  for (int v = 0; v < frame.height; ++v) {
    const auto row_part = static_cast<float>((frame.plane[1] * (v - frame.cy) / frame.fy + frame.plane[2]) / frame.depth_scale);
    const std::uint16_t* const depth = frame.depth + static_cast<std::size_t>(v) * width;
    std::uint8_t* const out = labels + static_cast<std::size_t>(v) * width;
    for (std::size_t u = 0; u < width; ++u) {
      const float distance = std::abs(static_cast<float>(depth[u]) * (column[u] + row_part) + d);
      const std::int32_t on_plane = distance <= threshold ? kFirstPlane : kNoPlane;
      const std::int32_t measured = depth[u] == 0 ? kNoDepth : kNoPlane;
      out[u] = static_cast<std::uint8_t>(on_plane & measured);
    }
  }
}

/// Labels of one known plane, from raw depth.
class LabelFloor final : public Peer {
 public:
  [[nodiscard]] std::string id() const override { return "floor-label"; }
  void load(const Frame& frame) override {
    labels_.resize(frame.size());
    column_.clear();
    for (int u = 0; u < frame.width; ++u) {
      column_.push_back(static_cast<float>(frame.plane[0] * (u - frame.cx) / frame.fx / frame.depth_scale));
    }
  }
  bool run(const Frame& frame, Answer& answer) override {
    label(frame, column_.data(), labels_.data());
    answer.labels = labels_.data();
    answer.planes = 1;
    return true;
  }

 private:
  std::vector<float> column_;
  std::vector<std::uint8_t> labels_;
};

}  // namespace

void add_floors(Party& party) {
  party.peers.push_back(std::make_unique<CopyFloor>());
  party.peers.push_back(std::make_unique<DeprojectFloor>());
  party.peers.push_back(std::make_unique<LabelFloor>());
}

}  // namespace fransac::bench
