// SPDX-License-Identifier: Apache-2.0
#include "fransac/synth/synth.hpp"

#include <algorithm>
#include <cmath>
#include <exception>
#include <new>
#include <numeric>
#include <optional>

#include "core/caught.hpp"
#include "fransac/core/labels.hpp"
#include "fransac/core/printable.hpp"
#include "synth/picture.hpp"
#include "synth/scenes.hpp"
#include "synth/sensors.hpp"
#include "synth/things.hpp"
#include "synth/walk.hpp"

namespace fransac::synth {
namespace {

std::size_t index(int i) { return static_cast<std::size_t>(i); }

Status check(const SynthOptions& options) {
  const auto error = [](std::string message) { return Error{ErrorCode::invalid_argument, std::move(message)}; };
  if (detail::find_scene(options.scene) == nullptr) {
    std::string known;
    for (const std::string_view name : scene_names()) known.append(known.empty() ? "" : ", ").append(name);
    return error("unknown scene " + quoted_text(options.scene) + "; known scenes: " + known);
  }
  if (Status status = validate(options.camera); !status) return status;
  if (index(options.camera.width) * index(options.camera.height) > kMaxPixels) {
    return error("camera: rendered frames have at most " + std::to_string(kMaxPixels) + " pixels");
  }
  if (options.frame < 0) return error("frame number must not be negative");
  if (options.sensor < Sensor::none || options.sensor > Sensor::tof) return error("unknown sensor");
  if (options.motion < Motion::sway || options.motion > Motion::walk) return error("unknown motion");
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

// Planes by their square metres, most first.
std::vector<int> by_size(const std::vector<Visible>& visible) {
  std::vector<int> order(visible.size());
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(),
                   [&](int a, int b) { return visible[index(a)].square_metres > visible[index(b)].square_metres; });
  return order;
}

// The planes as a whole walk sees them, those that it sees most of first.
std::vector<int> by_size_on(const detail::Walk& walk, const detail::Scene& world, const Camera& camera) {
  constexpr int kViews = 16;
  constexpr int kSide_px = 48;  // enough to see of each plane that is ever judged some pixels
  const double shrink = static_cast<double>(kSide_px) / std::max(camera.width, camera.height);
  const auto side = [&](int pixels) { return std::clamp(static_cast<int>(pixels * shrink), 1, pixels); };
  const Camera coarse = resized(camera, side(camera.width), side(camera.height));
  const std::vector<char> judged(index(coarse.width) * index(coarse.height), 1);
  std::vector<Visible> sum;
  for (int i = 0; i < kViews; ++i) {
    detail::Scene scene = world;
    scene.move_to(walk.view(i, kViews).inverse());
    const detail::Raster raster = detail::rasterise(scene, coarse);
    const std::vector<Visible> visible = visible_planes(scene, raster, planes_seen(scene, raster), judged, coarse);
    sum.resize(visible.size());
    for (std::size_t p = 0; p < sum.size(); ++p) sum[p].square_metres += visible[p].square_metres;
  }
  return by_size(sum);
}

// Drops what is too small to be judged.
std::vector<int> judged_planes(std::vector<int> order, const std::vector<Visible>& visible, std::size_t pixels) {
  const auto least = static_cast<std::size_t>(std::ceil(kMinPlaneShare * static_cast<double>(pixels)));
  std::erase_if(order, [&](int plane) { return visible[index(plane)].core_pixels < std::max<std::size_t>(least, 1); });
  return order;
}

// Labels 1, 2, 3 … in an order of planes; planes beyond the last label have none (0).
std::vector<int> numbered(const std::vector<int>& order, std::size_t planes) {
  std::vector<int> label_of_plane(planes, kLabelNoDepth);
  const std::size_t count = std::min(order.size(), index(kMaxPlanes));
  for (std::size_t rank = 0; rank < count; ++rank) label_of_plane[index(order[rank])] = kLabelFirst + static_cast<int>(rank);
  return label_of_plane;
}

// The label of each plane that is judged in this frame, else 0: ranked by what the frame sees, or by `constant_order`, in which
// planes keep their places from frame to frame.
std::vector<int> label_planes(const std::vector<Visible>& visible, std::size_t pixels,
                              const std::optional<std::vector<int>>& constant_order) {
  const std::vector<int> judged = judged_planes(by_size(visible), visible, pixels);
  if (!constant_order) return numbered(judged, visible.size());
  std::vector<int> labels(visible.size(), kLabelNoDepth);
  const std::vector<int> constant = numbered(*constant_order, visible.size());
  for (const int plane : judged) labels[index(plane)] = constant[index(plane)];
  return labels;
}

void add_planes(const detail::Scene& scene, const detail::Raster& raster, const detail::Measurement& measured,
                const std::optional<std::vector<int>>& constant_order, SynthFrame& frame) {
  const std::vector<int> plane = planes_seen(scene, raster);
  std::vector<char> judged(plane.size());
  for (std::size_t i = 0; i < judged.size(); ++i) {
    judged[i] = frame.depth[i] != 0 && (measured.mixed.empty() || measured.mixed[i] == 0) ? 1 : 0;
  }
  const std::vector<int> label_of_plane =
      label_planes(visible_planes(scene, raster, plane, judged, frame.camera), plane.size(), constant_order);
  for (std::size_t p = 0; p < label_of_plane.size(); ++p) {
    if (label_of_plane[p] != kLabelNoDepth) frame.true_planes.emplace_back(label_of_plane[p], scene.planes[p]);
  }
  std::sort(frame.true_planes.begin(), frame.true_planes.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
  frame.labels.resize(plane.size());
  for (std::size_t i = 0; i < plane.size(); ++i) {
    if (judged[i] == 0) continue;
    frame.labels[i] = plane[i] < 0 ? kLabelNoPlane : static_cast<std::uint8_t>(label_of_plane[index(plane[i])]);
  }
}

void add_objects(const detail::Scene& scene, const detail::Raster& raster, SynthFrame& frame) {
  std::vector<std::uint16_t> id_of_primitive(scene.primitives.size(), 0);
  for (const detail::Object& object : scene.objects) {
    std::fill(id_of_primitive.begin() + object.first, id_of_primitive.begin() + object.last,
              static_cast<std::uint16_t>(object.id));
  }
  frame.true_objects = detail::things_of(scene);
  std::vector<char> seen(frame.true_objects.size() + 1, 0);  // ids are 1, 2, 3 …
  frame.objects.resize(frame.depth.size());
  for (std::size_t i = 0; i < frame.objects.size(); ++i) {
    if (frame.depth[i] == 0 || raster.primitive[i] < 0) continue;
    frame.objects[i] = id_of_primitive[index(raster.primitive[i])];
    seen[frame.objects[i]] = 1;
  }
  std::erase_if(frame.true_objects, [&](const TrueObject& object) { return seen[index(object.id)] == 0; });
}

}  // namespace

Camera resized(Camera camera, int width, int height) {
  const double sx = static_cast<double>(width) / camera.width;
  const double sy = static_cast<double>(height) / camera.height;
  camera.fx *= sx;
  camera.fy *= sy;
  // (0, 0) is the centre of a pixel, hence the halves.
  camera.cx = (camera.cx + 0.5) * sx - 0.5;
  camera.cy = (camera.cy + 0.5) * sy - 0.5;
  camera.width = width;
  camera.height = height;
  return camera;
}

Result<SynthFrame> render(const SynthOptions& options) try {
  if (const Status status = check(options); !status) return status.error();
  detail::Stage stage = detail::find_scene(options.scene)(options.seed);
  SynthFrame frame;
  std::optional<std::vector<int>> constant_order;
  if (options.motion == Motion::walk) {
    const detail::Walk walk(stage, options.seed);
    frame.T_world_camera = walk.pose(options.frame);
    constant_order = by_size_on(walk, stage.scene, options.camera);
  } else {
    frame.T_world_camera = detail::camera_pose(stage, options.seed, options.frame);
  }
  stage.scene.move_to(frame.T_world_camera.inverse());
  const detail::Raster raster = detail::rasterise(stage.scene, options.camera);
  const detail::Measurement measured =
      detail::measure(options.sensor, stage.scene, options.camera, raster, options.seed, options.frame);
  frame.camera = options.camera;
  frame.depth = raw_units(measured.depth_m, options.camera.depth_scale);
  frame.exact_depth_m.assign(raster.depth_m.begin(), raster.depth_m.end());
  frame.colour = detail::paint(stage.scene, options.camera, raster);
  add_planes(stage.scene, raster, measured, constant_order, frame);
  add_objects(stage.scene, raster, frame);
  return frame;
} catch (const std::exception& exception) {
  return caught(exception, [&] { return "scene \"" + options.scene + "\""; });
}

}  // namespace fransac::synth
