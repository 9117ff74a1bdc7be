// SPDX-License-Identifier: Apache-2.0
/// Options, depth images and clouds out of a fuzzer's bytes. Where the bytes end, all that is drawn is ordinary.
#pragma once

#include <fuzzer/FuzzedDataProvider.h>

#include <Eigen/Core>
#include <algorithm>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <limits>
#include <optional>
#include <type_traits>
#include <vector>

#include "fransac/core/camera.hpp"
#include "fransac/core/depth_image.hpp"
#include "fransac/core/point_cloud.hpp"
#include "fransac/core/random.hpp"
#include "fransac/planes/options.hpp"

namespace fransac::fuzz {

using Bytes = FuzzedDataProvider;

/// One time in sixteen.
inline bool draw_seldom(Bytes& bytes) { return bytes.ConsumeIntegralInRange(0, 15) == 15; }

/// Any number at all, those that are none included.
inline double draw_any(Bytes& bytes) {
  using Limits = std::numeric_limits<double>;
  if (bytes.ConsumeBool()) return std::bit_cast<double>(bytes.ConsumeIntegral<std::uint64_t>());
  return bytes.PickValueInArray({0.0, -0.0, 1.0, -1.0, 1e-300, 1e-9, 1e6, 1e30, 1e300, Limits::quiet_NaN(), Limits::infinity(),
                                 -Limits::infinity(), Limits::max(), Limits::lowest(), Limits::denorm_min()});
}

/// A number from `min` to `max`, of any order of magnitude above `min`.
inline double draw_number(Bytes& bytes, double min, double max) {
  const double share = std::pow(10.0, -bytes.ConsumeIntegralInRange(0, 5));
  return min + (max - min) * share * bytes.ConsumeProbability<double>();
}

inline Eigen::Vector3d draw_vector(Bytes& bytes, double reach) {
  const auto number = [&] { return bytes.ConsumeFloatingPointInRange(-reach, reach); };
  const double x = number();
  const double y = number();
  return {x, y, number()};
}
inline Eigen::Vector3d draw_any_vector(Bytes& bytes) {
  const double x = draw_any(bytes);
  const double y = draw_any(bytes);
  return {x, y, draw_any(bytes)};
}

/// Draws the value of an option: mostly in its range, as far as ten, else anything.
struct DrawOption {
  Bytes& bytes;

  template <class T>
  void operator()(const OptionInfo& info, std::optional<T>& value) const {
    value.emplace();
    (*this)(info, *value);
    if (draw_seldom(bytes)) value.reset();
  }
  void operator()(const OptionInfo& /*info*/, Eigen::Vector3d& value) const {
    value = draw_seldom(bytes) ? draw_any_vector(bytes) : draw_vector(bytes, 10.0);
  }
  template <class T>
  void operator()(const OptionInfo& info, T& value) const {
    constexpr double kFar = 10.0;
    const bool any = draw_seldom(bytes);
    if constexpr (std::is_same_v<T, bool>) {
      value = any != bytes.ConsumeBool();
    } else if constexpr (std::is_enum_v<T>) {
      const auto names = static_cast<int>(std::size(EnumNames<T>::values));
      value = static_cast<T>(any ? bytes.ConsumeIntegral<int>() : bytes.ConsumeIntegralInRange(0, names - 1));
    } else if constexpr (std::is_integral_v<T>) {
      const auto min = static_cast<T>(std::max(info.min, 0.0));
      value = any ? bytes.ConsumeIntegral<T>() : bytes.ConsumeIntegralInRange<T>(min, min + T{255});
    } else {
      value = any ? draw_any(bytes) : draw_number(bytes, std::max(info.min, -kFar), std::min(info.max, kFar));
    }
  }
};

/// Changes some of the options that `for_each(visit)` visits.
template <class ForEach>
void draw_options(Bytes& bytes, const ForEach& for_each) {
  int options = 0;
  for_each([&](const OptionInfo&, auto&) { ++options; });
  for (int n = bytes.ConsumeIntegralInRange(0, 8); n > 0; --n) {
    int before = bytes.ConsumeIntegralInRange(0, options - 1);
    for_each([&](const OptionInfo& info, auto& value) {
      if (before-- == 0) DrawOption{bytes}(info, value);
    });
  }
}

/// Options of segment() that do not ask for hours of work.
inline SegmentOptions draw_segment_options(Bytes& bytes) {
  SegmentOptions options;
  DrawOption{bytes}({}, options.method);
  draw_options(bytes, [&](const auto& visit) { for_each_option(options, visit); });
  if (draw_seldom(bytes)) {
    Distortion& field = options.sensor.distortion;
    field.width = field.height = bytes.ConsumeIntegralInRange(-1, 64);
    for (double& term : field.offset_per_m) term = draw_seldom(bytes) ? draw_any(bytes) : draw_number(bytes, -1.0, 1.0);
  }
  constexpr int kIterations = 64;
  constexpr int kThreads = 2;
  if (options.ransac.max_iterations > kIterations) options.ransac.max_iterations = kIterations;
  if (options.threads >= 0 && options.threads <= 1024) options.threads %= kThreads + 1;
  return options;
}

/// A depth image and its camera.
struct DrawnDepth {
  Camera camera;
  DepthView view;
  std::vector<std::uint16_t> units;  ///< Of the view, or
  std::vector<float> metres;         ///< these.
};

/// Up to 48 x 48 pixels: rectangles of planes, noise, and pixels of any bytes. Seldom the camera is no camera. `like`: of a
/// camera of the same size.
inline DrawnDepth draw_depth(Bytes& bytes, const std::optional<Camera>& like = std::nullopt) {
  DrawnDepth drawn;
  constexpr int kMost = 48;
  const int width = like ? std::clamp(like->width, 1, kMost) : bytes.ConsumeIntegralInRange(1, kMost);
  const int height = like ? std::clamp(like->height, 1, kMost) : bytes.ConsumeIntegralInRange(1, kMost);
  const int stride = width + bytes.ConsumeIntegralInRange(0, 2);
  const double focal = std::exp2(bytes.ConsumeFloatingPointInRange(4.0, 12.0));
  const double scale = bytes.PickValueInArray({1000.0, 5000.0, 1.0, 100.0, 1e6});
  Camera& camera = drawn.camera;
  camera = {width, height, focal, focal, 0.5 * width - 0.5, 0.5 * height - 0.5, scale};
  if (bytes.ConsumeBool()) camera.cy = bytes.ConsumeFloatingPointInRange(-200.0, 200.0);
  if (draw_seldom(bytes)) {
    double* const field = bytes.PickValueInArray({&camera.fx, &camera.fy, &camera.cx, &camera.cy});
    *field = draw_any(bytes);
  }
  if (draw_seldom(bytes)) camera.width += bytes.ConsumeIntegralInRange(-2, 2);

  std::vector<double> z(static_cast<std::size_t>(stride) * static_cast<std::size_t>(height));
  const auto at = [&](int u, int v) -> double& { return z[static_cast<std::size_t>(v * stride + u)]; };
  for (int n = bytes.ConsumeIntegralInRange(0, 6); n > 0; --n) {
    const int u0 = bytes.ConsumeIntegralInRange(0, width - 1);
    const int v0 = bytes.ConsumeIntegralInRange(0, height - 1);
    const int u1 = width - bytes.ConsumeIntegralInRange(0, width - 1);
    const int v1 = height - bytes.ConsumeIntegralInRange(0, height - 1);
    const double q = bytes.ConsumeFloatingPointInRange(0.1, 3.0);  // inverse depth is affine on a plane
    const double du = bytes.ConsumeBool() ? bytes.ConsumeFloatingPointInRange(-0.05, 0.05) : 0.0;
    const double dv = bytes.ConsumeBool() ? bytes.ConsumeFloatingPointInRange(-0.05, 0.05) : 0.0;
    for (int v = v0; v < v1; ++v) {
      for (int u = u0; u < u1; ++u) at(u, v) = 1.0 / (q + du * u + dv * v);
    }
  }
  if (bytes.ConsumeBool()) {
    const double sigma = draw_number(bytes, 0.0, 0.1);
    RandomStream random(bytes.ConsumeIntegral<std::uint8_t>(), 0);
    for (double& value : z) value += sigma * random.normal();
  }
  const auto lay_bytes = [&](auto& pixels) {
    using Raw = typename std::decay_t<decltype(pixels)>::value_type;
    const std::size_t first = bytes.ConsumeIntegralInRange<std::size_t>(0, pixels.size() - 1);
    const std::size_t room = (pixels.size() - first) * sizeof(Raw);
    const auto laid =
        bytes.ConsumeBytes<std::uint8_t>(bytes.ConsumeIntegralInRange<std::size_t>(0, std::min<std::size_t>(room, 256)));
    if (!laid.empty()) std::memcpy(pixels.data() + first, laid.data(), laid.size());
  };
  if (bytes.ConsumeBool()) {
    drawn.metres.assign(z.begin(), z.end());
    lay_bytes(drawn.metres);
    drawn.view = DepthView::from_float(drawn.metres.data(), width, height, stride * static_cast<std::ptrdiff_t>(sizeof(float)));
  } else {
    for (const double value : z) drawn.units.push_back(static_cast<std::uint16_t>(std::clamp(value * scale, 0.0, 65535.0)));
    lay_bytes(drawn.units);
    drawn.view = DepthView::from_uint16(drawn.units.data(), width, height, scale,
                                        stride * static_cast<std::ptrdiff_t>(sizeof(std::uint16_t)));
  }
  return drawn;
}

/// The points of a depth image, organised or not, here and there moved, some of them anywhere; seldom of a wrong size.
inline PointCloud draw_cloud(Bytes& bytes, const DrawnDepth& drawn) {
  PointCloud cloud;
  const DepthView& depth = drawn.view;
  const Camera& camera = drawn.camera;
  cloud.resize(depth.size());
  cloud.width = depth.width();
  cloud.height = depth.height();
  const Eigen::Vector3d shift = bytes.ConsumeBool() ? draw_vector(bytes, 5.0) : Eigen::Vector3d::Zero();
  for (int v = 0; v < depth.height(); ++v) {
    for (int u = 0; u < depth.width(); ++u) {
      const auto z = static_cast<double>(depth.metres(u, v));
      if (z == 0.0) continue;
      const Eigen::Vector3d point(z * (u - camera.cx) / camera.fx, z * (v - camera.cy) / camera.fy, z);
      cloud.set(static_cast<std::size_t>(v * depth.width() + u), (point + shift).cast<float>());
    }
  }
  if (bytes.ConsumeBool()) {
    cloud.width = static_cast<int>(cloud.size());
    cloud.height = 1;
  }
  for (int n = bytes.ConsumeIntegralInRange(0, 8); n > 0; --n) {
    const std::size_t i = bytes.ConsumeIntegralInRange<std::size_t>(0, cloud.size() - 1);
    const Eigen::Vector3d point = bytes.ConsumeBool() ? draw_vector(bytes, 100.0) : draw_any_vector(bytes);
    cloud.set(i, point.cwiseMax(-1e38).cwiseMin(1e38).cast<float>());
  }
  if (draw_seldom(bytes)) cloud.origin = bytes.ConsumeBool() ? draw_vector(bytes, 1e7) : draw_any_vector(bytes);
  if (draw_seldom(bytes)) cloud.sensor_position = bytes.ConsumeBool() ? draw_vector(bytes, 5.0) : draw_any_vector(bytes);
  if (draw_seldom(bytes)) cloud.height = bytes.ConsumeIntegral<int>();
  return cloud;
}

}  // namespace fransac::fuzz
