// SPDX-License-Identifier: Apache-2.0
#include "inputs.hpp"

#include <fmt/format.h>

#include "errors.hpp"
#include "fransac/io/camera_json.hpp"
#ifdef FRANSAC_HAS_CLOUD_IO
#include "fransac/io/cloud_file.hpp"
#endif

namespace fransac::cli {
namespace {

PointCloud load_cloud(const std::string& file, [[maybe_unused]] double metres_per_unit) {
#ifdef FRANSAC_HAS_CLOUD_IO
  return unwrap(io::read_cloud(file, metres_per_unit));
#else
  throw Failure(fmt::format(
      "{}: this fransac was built without support for point clouds: it needs PCL's io library (scripts/bootstrap cloud) and "
      "-DFRANSAC_BUILD_CLOUD_IO=ON",
      file));
#endif
}

}  // namespace

Input open_input(const std::string& name, const CameraFile& camera_file) {
  Input input{name, unwrap(io::detect_kind(name)), {}};
  if (input.is_cloud() && camera_file) throw UsageError(fmt::format("--camera: {} is a point cloud and needs no camera", name));
  if (!input.is_cloud()) input.frames = unwrap(io::list_frames(name)).frames;
  use_camera(camera_file, input.frames);
  return input;
}

void use_camera(const CameraFile& camera, std::vector<io::FrameFiles>& frames) {
  if (!camera) return;
  const std::optional<Camera> known = std::filesystem::exists(*camera) ? std::nullopt : io::tum_camera(camera->string());
  for (io::FrameFiles& frame : frames) {
    frame.camera = known;
    frame.camera_file = known ? std::nullopt : camera;
  }
}

Content load(const Input& input, std::size_t i) {
  if (input.is_cloud()) return load_cloud(input.name, input.metres_per_unit);
  return unwrap(io::load_frame(input.frames[i]));
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
