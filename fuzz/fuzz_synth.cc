// SPDX-License-Identifier: Apache-2.0
// A rendered frame of any scene, camera, sensor, seed and frame number: an error, or depth, labels, objects and planes that fit
// each other and the noise-free depth, the same every time.
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "draw.hpp"
#include "fransac/core/labels.hpp"
#include "fransac/synth/synth.hpp"
#include "require.hpp"

namespace {

using namespace fransac;
using namespace fransac::fuzz;

/// Small, for a pixel costs a ray; mostly a camera that looks ahead.
Camera draw_camera(Bytes& bytes) {
  constexpr int kMost = 24;
  const auto seldom_any = [&](double value) { return draw_seldom(bytes) ? draw_any(bytes) : value; };
  Camera camera;
  camera.width = bytes.ConsumeIntegralInRange(1, kMost);
  camera.height = bytes.ConsumeIntegralInRange(1, kMost);
  camera.fx = seldom_any(camera.width * std::exp2(bytes.ConsumeFloatingPointInRange(-4.0, 12.0)));
  camera.fy = bytes.ConsumeBool() ? camera.fx : seldom_any(std::exp2(bytes.ConsumeFloatingPointInRange(-4.0, 20.0)));
  camera.cx = seldom_any(bytes.ConsumeBool() ? 0.5 * camera.width - 0.5 : bytes.ConsumeFloatingPointInRange(-1e6, 1e6));
  camera.cy = seldom_any(bytes.ConsumeBool() ? 0.5 * camera.height - 0.5 : bytes.ConsumeFloatingPointInRange(-1e6, 1e6));
  camera.depth_scale = seldom_any(bytes.PickValueInArray({1000.0, 5000.0, 1.0, 1e6}));
  if (!draw_seldom(bytes)) return camera;
  // Never a size that is accepted and takes minutes.
  int& side = bytes.ConsumeBool() ? camera.width : camera.height;
  side = bytes.PickValueInArray({0, -1, kMaxImageSide + 1, bytes.ConsumeIntegralInRange(-1000000, 0)});
  return camera;
}

synth::SynthOptions draw_synth_options(Bytes& bytes) {
  synth::SynthOptions options;
  options.scene =
      std::string(synth::scene_names()[bytes.ConsumeIntegralInRange<std::size_t>(0, synth::scene_names().size() - 1)]);
  DrawOption{bytes}({}, options.sensor);
  DrawOption{bytes}({}, options.motion);
  options.seed = bytes.ConsumeBool() ? bytes.ConsumeIntegral<std::uint64_t>() : bytes.ConsumeIntegral<std::uint8_t>();
  options.frame = draw_seldom(bytes) ? bytes.ConsumeIntegral<int>() : bytes.ConsumeIntegralInRange(0, 1000);
  options.camera = draw_camera(bytes);
  if (draw_seldom(bytes)) options.scene = bytes.ConsumeRandomLengthString(5000);
  return options;
}

bool is_valid(const synth::SynthOptions& options) {
  const auto names = synth::scene_names();
  const auto known = [](auto value) {
    const int i = static_cast<int>(value);
    return i >= 0 && i < static_cast<int>(std::size(EnumNames<decltype(value)>::values));
  };
  return std::find(names.begin(), names.end(), options.scene) != names.end() && validate(options.camera) && options.frame >= 0 &&
         known(options.sensor) && known(options.motion);
}

void check_planes(const synth::SynthFrame& frame, const std::vector<std::size_t>& pixels) {
  int last = kLabelNoDepth;
  for (const auto& [label, plane] : frame.true_planes) {
    require(label > last && label <= kMaxPlanes && pixels[static_cast<std::size_t>(label)] > 0);
    require(std::abs(plane.normal.norm() - 1.0) < 1e-6 && std::isfinite(plane.d) && plane.d >= 0.0);
    last = label;
  }
  const auto with_label = std::count_if(pixels.begin() + kLabelFirst, pixels.begin() + kLabelFirst + kMaxPlanes,
                                        [](std::size_t count) { return count > 0; });
  require(static_cast<std::size_t>(with_label) == frame.true_planes.size());
}

void check_objects(const synth::SynthFrame& frame, const std::vector<std::size_t>& pixels) {
  std::size_t seen = 0;
  int last = 0;
  for (const TrueObject& object : frame.true_objects) {
    require(object.id > last && pixels[static_cast<std::size_t>(object.id)] > 0);
    const OrientedBox& box = object.box;
    require(box.centre.allFinite() && box.size.allFinite() && (box.size.array() > 0.0).all());
    require(std::abs(box.along.norm() - 1.0) < 1e-6 && std::abs(box.up.norm() - 1.0) < 1e-6);
    require(object.highest_m >= object.lowest_m && std::isfinite(object.highest_m));
    seen += pixels[static_cast<std::size_t>(object.id)];
    last = object.id;
  }
  require(seen + pixels[0] == frame.objects.size());
}

/// On the pixel's ray, a labelled pixel's noise-free depth lies on its plane, to within what a float holds.
void check_on_plane(const synth::SynthFrame& frame) {
  std::size_t i = 0;
  for (int v = 0; v < frame.camera.height; ++v) {
    for (int u = 0; u < frame.camera.width; ++u, ++i) {
      for (const auto& [label, plane] : frame.true_planes) {
        if (frame.labels[i] != label) continue;
        const auto z = static_cast<double>(frame.exact_depth_m[i]);
        const Eigen::Vector3d ray((u - frame.camera.cx) / frame.camera.fx, (v - frame.camera.cy) / frame.camera.fy, 1.0);
        require(z > 0.0 && std::abs(plane.signed_distance(z * ray)) <= 1e-6 * (1.0 + z * ray.norm()));
      }
    }
  }
}

void check(const synth::SynthFrame& frame, const synth::SynthOptions& options) {
  const Camera& camera = options.camera;
  const auto size = static_cast<std::size_t>(camera.width) * static_cast<std::size_t>(camera.height);
  require(frame.depth.size() == size && frame.exact_depth_m.size() == size && frame.labels.size() == size);
  require(frame.objects.size() == size && frame.colour.size() == 3 * size);
  std::vector<std::size_t> of_label(256);
  std::vector<std::size_t> of_object(std::size_t{1} << 16);
  for (std::size_t i = 0; i < size; ++i) {
    require(std::isfinite(frame.exact_depth_m[i]) && frame.exact_depth_m[i] >= 0.0F);
    require(frame.depth[i] != 0 || (frame.labels[i] == kLabelNoDepth && frame.objects[i] == 0));
    require(options.sensor != synth::Sensor::none || frame.depth[i] == 0 || frame.exact_depth_m[i] > 0.0F);
    ++of_label[frame.labels[i]];
    ++of_object[frame.objects[i]];
  }
  check_planes(frame, of_label);
  check_objects(frame, of_object);
  check_on_plane(frame);
  require(frame.T_world_camera.matrix().allFinite());
  const Eigen::Matrix3d rotation = frame.T_world_camera.linear();
  require((rotation.transpose() * rotation).isIdentity(1e-9) && rotation.determinant() > 0.0);
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  Bytes bytes(data, size);
  const synth::SynthOptions options = draw_synth_options(bytes);
  const Result<synth::SynthFrame> frame = synth::render(options);
  require(frame.ok() == is_valid(options));
  if (!frame) return require_message(frame.error()), 0;
  check(*frame, options);
  const Result<synth::SynthFrame> again = synth::render(options);
  require(again && again->depth == frame->depth && again->labels == frame->labels && again->colour == frame->colour);
  require(again->objects == frame->objects && again->exact_depth_m == frame->exact_depth_m);
  require(again->T_world_camera.matrix() == frame->T_world_camera.matrix());
  return 0;
}
