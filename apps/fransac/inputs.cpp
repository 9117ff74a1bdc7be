// SPDX-License-Identifier: Apache-2.0
#include "inputs.hpp"

#include <fmt/format.h>

#include "errors.hpp"
#ifdef FRANSAC_HAS_CLOUD_IO
#include "fransac/io/cloud_file.hpp"
#endif

namespace fransac::cli {
namespace {

PointCloud load_cloud(const std::string& file) {
#ifdef FRANSAC_HAS_CLOUD_IO
  return unwrap(io::read_cloud(file));
#else
  throw Failure(fmt::format("{}: this fransac was built without support for point clouds (FRANSAC_BUILD_CLOUD_IO)", file));
#endif
}

}  // namespace

Input open_input(const std::string& name, const CameraFile& camera_file) {
  Input input{name, unwrap(io::detect_kind(name)), {}};
  if (input.is_cloud() && camera_file) throw UsageError(fmt::format("--camera: {} is a point cloud and needs no camera", name));
  if (!input.is_cloud()) input.frames = unwrap(io::list_frames(name)).frames;
  return input;
}

Content load(const Input& input, std::size_t i, const CameraFile& camera_file) {
  if (input.is_cloud()) return load_cloud(input.name);
  return unwrap(io::load_frame(input.frames[i], camera_file));
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
