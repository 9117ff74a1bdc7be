// SPDX-License-Identifier: Apache-2.0
#include "inputs.hpp"

#include <fmt/format.h>

#include "errors.hpp"
#include "fransac/io/camera_file.hpp"
#include "fransac/io/cloud_file.hpp"

namespace fransac::cli {
Input open_input(const std::string& name, InputOptions& options) {
  Input input{name, unwrap(io::detect_kind(name)), {}, options.limits()};
  if (!input.is_cloud()) {
    input.frames = open_frames(name, options).frames;
    return input;
  }
  if (options.camera) throw UsageError(fmt::format("--camera: {} is a point cloud and needs no camera", name));
  if (options.depth_scale) throw UsageError(fmt::format("--depth-scale: {} is a point cloud; its unit is --unit", name));
  options.files.reads(name);
  return input;
}

io::Dataset open_frames(const std::string& name, InputOptions& options) {
  io::Dataset dataset = unwrap(io::list_frames(name));
  options.files.reads(dataset);
  const auto& camera = options.camera;
  const bool is_file = camera && std::filesystem::exists(*camera);
  const std::optional<Camera> known = camera && !is_file ? io::camera_preset(camera->string()) : std::nullopt;
  if (is_file) options.files.reads(*camera);
  for (io::FrameFiles& frame : dataset.frames) {
    frame.limits = options.limits();
    frame.depth_scale = options.depth_scale;
    if (!camera) continue;
    frame.camera = known;
    frame.camera_file = known ? std::nullopt : camera;
  }
  return dataset;
}

Content load(const Input& input, std::size_t i, Doubts& doubts, Progress& progress) {
  if (input.is_cloud()) return unwrap(io::read_cloud(input.name, input.metres_per_unit, input.limits));
  io::Frame frame = unwrap(io::load_frame(input.frames[i]));
  doubts.look_at(input.frames[i], frame, progress);
  return frame;
}

void segment(const std::string& name, const Content& content, const SegmentOptions& options, Workspace& workspace,
             Segmentation& segmentation) {
  const auto run = [&]() -> Status {
    if (const auto* cloud = std::get_if<PointCloud>(&content)) return fransac::segment(*cloud, options, workspace, segmentation);
    const auto& frame = std::get<io::Frame>(content);
    return fransac::segment(frame.view(), frame.camera, options, workspace, segmentation);
  };
  if (const Status status = run(); !status) throw Failure(fmt::format("{}: {}", name, status.error().message));
}

}  // namespace fransac::cli
