// SPDX-License-Identifier: Apache-2.0
#include "fransac/synth/synth.hpp"

#include <algorithm>
#include <cmath>
#include <exception>
#include <new>
#include <numeric>

#include "fransac/core/labels.hpp"
#include "synth/picture.hpp"
#include "synth/scenes.hpp"
#include "synth/sensors.hpp"

namespace fransac::synth {
namespace {

std::size_t index(int i) { return static_cast<std::size_t>(i); }

Status check(const SynthOptions& options) {
  const auto error = [](std::string message) { return Error{ErrorCode::invalid_argument, std::move(message)}; };
  if (detail::find_scene(options.scene) == nullptr) {
    std::string known;
    for (const std::string_view name : scene_names()) known.append(known.empty() ? "" : ", ").append(name);
    return error("unknown scene \"" + options.scene + "\"; known scenes: " + known);
  }
  if (Status status = validate(options.camera); !status) return status;
  if (index(options.camera.width) * index(options.camera.height) > kMaxPixels) {
    return error("camera: rendered frames have at most " + std::to_string(kMaxPixels) + " pixels");
  }
  if (options.frame < 0) return error("frame number must not be negative");
  if (options.sensor < Sensor::none || options.sensor > Sensor::tof) return error("unknown sensor");
  return {};
}

std::vector<std::uint16_t> raw_units(const std::vector<double>& depth_m, double depth_scale) {
  std::vector<std::uint16_t> raw(depth_m.size());
  std::transform(depth_m.begin(), depth_m.end(), raw.begin(), [&](double z) {
    const double units = std::round(z * depth_scale);
    return units <= 65535.0 ? static_cast<std::uint16_t>(units) : std::uint16_t{0};
  });
  return raw;
}

// The planes that pixels see, by index into scene.planes; -1 where there is none.
std::vector<int> planes_seen(const detail::Scene& scene, const detail::Raster& raster) {
  std::vector<int> plane(raster.face.size());
  std::transform(raster.face.begin(), raster.face.end(), plane.begin(),
                 [&](int face) { return face < 0 ? -1 : scene.plane_of_face[index(face)]; });
  return plane;
}

// Whether the window around a pixel lies in the image and sees one plane only.
bool is_core(const std::vector<int>& plane, const Camera& camera, int u, int v) {
  constexpr int kReach = kCoreWindow_px / 2;
  if (u < kReach || v < kReach || u + kReach >= camera.width || v + kReach >= camera.height) return false;
  const int own = plane[index(v) * index(camera.width) + index(u)];
  for (int y = v - kReach; y <= v + kReach; ++y) {
    const auto row = plane.begin() + static_cast<std::ptrdiff_t>(y) * camera.width;
    if (std::any_of(row + (u - kReach), row + (u + kReach + 1), [&](int p) { return p != own; })) return false;
  }
  return true;
}

// Square metres and core pixels of each plane, over the pixels that measured it.
struct Visible {
  double square_metres = 0.0;
  std::size_t core_pixels = 0;
};

// A pixel's footprint on the plane n.p + d = 0 at depth z is z^3 / (|d| fx fy).
std::vector<Visible> visible_planes(const detail::Scene& scene, const detail::Raster& raster, const std::vector<int>& plane,
                                    const std::vector<char>& judged, const Camera& camera) {
  std::vector<Visible> visible(scene.planes.size());
  std::size_t i = 0;
  for (int v = 0; v < camera.height; ++v) {
    for (int u = 0; u < camera.width; ++u, ++i) {
      if (judged[i] == 0 || plane[i] < 0) continue;
      Visible& seen = visible[index(plane[i])];
      const double z = raster.depth_m[i];
      seen.square_metres += z * z * z / (scene.planes[index(plane[i])].d * camera.fx * camera.fy);
      if (is_core(plane, camera, u, v)) ++seen.core_pixels;
    }
  }
  return visible;
}

// Planes that are large enough to be judged, most square metres first.
std::vector<int> ranked(const std::vector<Visible>& visible, std::size_t pixels) {
  const auto least = static_cast<std::size_t>(std::ceil(kMinPlaneShare * static_cast<double>(pixels)));
  std::vector<int> order;
  for (std::size_t i = 0; i < visible.size(); ++i) {
    if (visible[i].core_pixels >= std::max<std::size_t>(least, 1)) order.push_back(static_cast<int>(i));
  }
  std::stable_sort(order.begin(), order.end(),
                   [&](int a, int b) { return visible[index(a)].square_metres > visible[index(b)].square_metres; });
  if (order.size() > index(kMaxPlanes)) order.resize(index(kMaxPlanes));
  return order;
}

void add_truth(const detail::Scene& scene, const detail::Raster& raster, const detail::Measurement& measured, SynthFrame& frame) {
  const std::vector<int> plane = planes_seen(scene, raster);
  std::vector<char> judged(plane.size());
  for (std::size_t i = 0; i < judged.size(); ++i) {
    judged[i] = frame.depth[i] != 0 && (measured.mixed.empty() || measured.mixed[i] == 0) ? 1 : 0;
  }
  const std::vector<int> order = ranked(visible_planes(scene, raster, plane, judged, frame.camera), plane.size());
  std::vector<std::uint8_t> label_of_plane(scene.planes.size(), kLabelNoDepth);  // 0: too small to be judged
  for (std::size_t rank = 0; rank < order.size(); ++rank) {
    const int label = kLabelFirst + static_cast<int>(rank);
    label_of_plane[index(order[rank])] = static_cast<std::uint8_t>(label);
    frame.true_planes.emplace_back(label, scene.planes[index(order[rank])]);
  }
  frame.labels.resize(plane.size());
  for (std::size_t i = 0; i < plane.size(); ++i) {
    if (judged[i] != 0) frame.labels[i] = plane[i] < 0 ? kLabelNoPlane : label_of_plane[index(plane[i])];
  }
}

}  // namespace

Result<SynthFrame> render(const SynthOptions& options) {
  if (const Status status = check(options); !status) return status.error();
  try {
    detail::Stage stage = detail::find_scene(options.scene)(options.seed);
    stage.scene.move_to(detail::camera_pose(stage, options.seed, options.frame).inverse());
    const detail::Raster raster = detail::rasterise(stage.scene, options.camera);
    const detail::Measurement measured =
        detail::measure(options.sensor, stage.scene, options.camera, raster, options.seed, options.frame);
    SynthFrame frame;
    frame.camera = options.camera;
    frame.depth = raw_units(measured.depth_m, options.camera.depth_scale);
    frame.exact_depth_m.assign(raster.depth_m.begin(), raster.depth_m.end());
    frame.colour = detail::paint(stage.scene, options.camera, raster);
    add_truth(stage.scene, raster, measured, frame);
    return frame;
  } catch (const std::exception& e) {
    return Error{ErrorCode::out_of_memory, "scene \"" + options.scene + "\": " + e.what()};
  }
}

}  // namespace fransac::synth
