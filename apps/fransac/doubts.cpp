// SPDX-License-Identifier: Apache-2.0
#include "doubts.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

#include "fransac/core/printable.hpp"
#include "output.hpp"

namespace fransac::cli {
namespace {

constexpr double kMinFieldOfView_deg = 10.0;
constexpr double kMaxFieldOfView_deg = 150.0;
constexpr float kMinMedian_m = 0.05F;
constexpr float kMaxMedian_m = 50.0F;

double field_of_view_deg(int pixels, double focal_length_px) {
  return 2.0 * std::atan(0.5 * pixels / focal_length_px) * 180.0 / std::numbers::pi;
}

/// Of some pixels all over the image; nothing where none was measured.
std::optional<float> median_depth_m(const DepthView& depth) {
  constexpr int kPerSide = 64;
  std::vector<float> metres;
  const auto at = [](int i, int size) { return static_cast<int>((2 * i + 1) * static_cast<long>(size) / (2 * kPerSide)); };
  for (int j = 0; j < kPerSide; ++j) {
    for (int i = 0; i < kPerSide; ++i) {
      const float value = depth.metres(at(i, depth.width()), at(j, depth.height()));
      if (value > 0.0F) metres.push_back(value);
    }
  }
  if (metres.empty()) return std::nullopt;
  const auto middle = metres.begin() + static_cast<std::ptrdiff_t>(metres.size() / 2);
  std::nth_element(metres.begin(), middle, metres.end());
  return *middle;
}

void say(const std::string& text, Progress& progress) {
  progress.clear();
  log(text);
}

}  // namespace

void Doubts::look_at_camera(const std::string& name, const Camera& camera, Progress& progress) {
  if (!cameras_.insert(name).second) return;
  const double wide = field_of_view_deg(camera.width, camera.fx);
  if (wide < kMinFieldOfView_deg || wide > kMaxFieldOfView_deg) {
    say(fmt::format(
            "{}: fx of {:g} for {} columns is a field of view of {:.3g} degrees; is it of another image, or in another unit?",
            name, camera.fx, camera.width, wide),
        progress);
  }
  const auto is_outside = [](double centre, int size) { return centre < -0.5 || centre > size - 0.5; };
  if (is_outside(camera.cx, camera.width) || is_outside(camera.cy, camera.height)) {
    say(fmt::format("{}: cx, cy of {:g}, {:g} lie outside the {}x{} pixels; are they of another image?", name, camera.cx,
                    camera.cy, camera.width, camera.height),
        progress);
  }
}

void Doubts::look_at_depth(const std::string& name, const std::string& source, const Camera& camera, const DepthView& depth,
                           Progress& progress) {
  if (unit_said_) return;
  const std::optional<float> median = median_depth_m(depth);
  if (!median || (*median >= kMinMedian_m && *median <= kMaxMedian_m)) return;
  unit_said_ = true;
  const std::string taken =
      depth.format() == DepthFormat::float32
          ? std::string("values are taken for metres")
          : fmt::format("{:g} raw units are taken for a metre (depth_scale of {})", camera.depth_scale, source);
  say(fmt::format("{}: the median depth is {:.3g} m: {}; if that is wrong, say so with --depth-scale", name, *median, taken),
      progress);
}

void Doubts::look_at(const io::FrameFiles& files, const io::Frame& frame, Progress& progress) {
  const std::string depth = printable(files.depth.string());
  const std::string camera = files.camera_file ? printable(files.camera_file->string()) : "the camera";
  look_at_camera(files.camera_file ? camera : depth, frame.camera, progress);
  look_at_depth(depth, camera, frame.camera, frame.view(), progress);
}

void Doubts::look_at(const std::string& name, const Camera& camera, const DepthView& depth, Progress& progress) {
  look_at_camera(name, camera, progress);
  look_at_depth(name, name, camera, depth, progress);
}

}  // namespace fransac::cli
