// SPDX-License-Identifier: Apache-2.0
// A small depth image of any numbers: `cells` ends in an error or in labels and planes that fit each other. The first bytes
// choose the size, the type, the sensor and the camera; the rest are the pixels, over and over where they are too few.
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <vector>

#include "fransac/core/labels.hpp"
#include "fransac/planes/segment.hpp"

namespace {

using namespace fransac;

constexpr std::size_t kHead = 5;

void require(bool holds) {
  if (!holds) __builtin_trap();
}

void check(const Segmentation& s, const DepthView& depth) {
  require(s.labels.size() == depth.size() && s.width == depth.width() && s.height == depth.height());
  std::array<std::uint64_t, 256> pixels{};
  std::size_t i = 0;
  for (int v = 0; v < depth.height(); ++v) {
    for (int u = 0; u < depth.width(); ++u, ++i) {
      const std::uint8_t label = s.labels[i];
      ++pixels[label];
      const bool saturated = depth.format() == DepthFormat::uint16 && s.saturated != 0 && depth.row_uint16(v)[u] == s.saturated;
      require((label == kLabelNoDepth) == (saturated || depth.metres(u, v) == 0.0F));
      require(label == kLabelNoPlane || label <= s.planes.size());
      require((label == kLabelNoDepth || label == kLabelNoPlane) == std::isnan(s.residuals_m[i]));
    }
  }
  for (std::size_t k = 0; k < s.planes.size(); ++k) {
    const PlaneSegment& p = s.planes[k];
    require(p.id == static_cast<int>(k) + kLabelFirst && p.inliers == pixels[k + kLabelFirst] && p.inliers > 0);
    require(std::abs(p.plane.normal.norm() - 1.0) < 1e-6 && std::isfinite(p.plane.d) && p.plane.d >= 0.0);
    require(std::isfinite(p.rms_m) && std::isfinite(p.area_m2) && p.area_m2 >= 0.0);
    require(p.centroid.allFinite() && p.covariance.allFinite());
  }
}

template <class Raw>
std::vector<Raw> pixels_of(const std::uint8_t* data, std::size_t size, std::size_t count) {
  std::vector<Raw> pixels(count);
  auto* const bytes = reinterpret_cast<std::uint8_t*>(pixels.data());
  for (std::size_t i = 0; i < count * sizeof(Raw) && size > 0; ++i) bytes[i] = data[i % size];
  return pixels;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size < kHead) return 0;
  const int width = 1 + data[0] % 64;
  const int height = 1 + data[1] % 64;
  const auto count = static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
  const double focal = std::exp2(data[3] % 16);
  const Camera camera{width, height, focal, focal * (1.0 + data[4] / 256.0), data[4] % 64 - 0.5, 0.5 * height, 5000.0};
  SegmentOptions options;
  options.method = Method::cells;
  options.cells.residuals = true;
  options.sensor.kind = static_cast<SensorKind>(data[2] / 2 % 5);
  options.threads = 1 + data[2] / 16 % 2;
  const std::uint8_t* const rest = data + kHead;
  const auto run = [&](const DepthView& depth) {
    const Result<Segmentation> s = segment(depth, camera, options);
    if (s) check(*s, depth);
    require(s || !s.error().message.empty());
  };
  if (data[2] % 2 == 0) {
    const auto pixels = pixels_of<std::uint16_t>(rest, size - kHead, count);
    run(DepthView::from_uint16(pixels.data(), width, height, 5000.0));
  } else {
    const auto pixels = pixels_of<float>(rest, size - kHead, count);
    run(DepthView::from_float(pixels.data(), width, height));
  }
  return 0;
}
