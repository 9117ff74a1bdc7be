// SPDX-License-Identifier: Apache-2.0
#include "checks.hpp"

#include <fmt/format.h>

#include <cctype>

#include "../errors.hpp"
#include "fransac/core/printable.hpp"

namespace fransac::cli {
namespace {

namespace fs = std::filesystem;

bool has_extension(const fs::path& path, std::initializer_list<const char*> extensions) {
  std::string extension = path.extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(), [](unsigned char c) { return std::tolower(c); });
  return std::find(extensions.begin(), extensions.end(), extension) != extensions.end();
}

void check_folder(const Output& output, const Input& input, RunFiles& files) {
  if (has_extension(output.path, {".png", ".json", ".ply", ".pcd"}) && !fs::is_directory(output.path)) {
    throw UsageError(fmt::format("{}: {} holds several frames, so this names a folder, not a file", output.option, input.name));
  }
  files.writes_folder(output.option, output.path);
}

/// A file's name says its format; devices and pipes have no such name, and a cloud's format is known by nothing else.
void check_name(const SegmentRequest& request, const Output& output) {
  if (output.accepted.size() == 0 || has_extension(output.path, output.accepted)) return;
  const bool special = fs::exists(output.path) && !fs::is_regular_file(output.path);
  if (special && &output != &request.cloud) return;
  throw UsageError(fmt::format("{}: '{}' must end in {}", output.option, output.path, fmt::join(output.accepted, " or ")));
}

void note_files(const SegmentRequest& request, const Output& output, const Input& input, std::size_t i, RunFiles& files) {
  const fs::path file = output.file(input, i);
  if (&output != &request.grid) return files.writes(output.option, file);
  for (const char* const suffix : {".pgm", ".yaml"}) files.writes(output.option, fs::path(file) += suffix);
}

}  // namespace

void check_request(const SegmentRequest& request) {
  for (const Output* output : request.outputs()) {
    if (output->to_stdout() && output != &request.json) {
      throw UsageError(fmt::format("{}: only --json can go to standard output", output->option));
    }
  }
  if (request.outlines && !request.json.asked()) throw UsageError("--outlines: outlines are part of --json, which is missing");
  check_options(request.options);
  check_options(request.obstacles.options);
  if (!request.grid.asked()) return;
  if (const Status status = validate(request.occupancy); !status) {
    throw UsageError(fmt::format("--grid: {}", status.error().message));
  }
}

void check_outputs(SegmentRequest& request, const Input& input) {
  if (request.metres_per_unit && !input.is_cloud()) {
    throw UsageError(fmt::format(
        "--unit: {} is no point cloud; a depth image's unit is --depth-scale, or its camera's depth_scale", input.name));
  }
  for (const io::FrameFiles& frame : input.frames) {
    if (input.is_folder_of_frames() && fs::path(frame.name).filename() != frame.name) {
      throw Failure(fmt::format("{}: the frame name {} is no file name", input.name, quoted_text(frame.name)));
    }
  }
  for (const Output* output : request.outputs()) {
    if (!output->asked() || output->to_stdout()) continue;
    if (input.is_folder_of_frames()) {
      check_folder(*output, input, request.inputs.files);
    } else {
      check_name(request, *output);
    }
    for (std::size_t i = 0; i < input.size(); ++i) note_files(request, *output, input, i, request.inputs.files);
  }
}

void check_content(const SegmentRequest& request, const Content& content) {
  const auto* cloud = std::get_if<PointCloud>(&content);
  if (cloud != nullptr && request.outlines) throw UsageError("--outlines needs a depth image");
  if (cloud != nullptr && request.grid.asked()) throw UsageError("--grid needs a depth image");
  if (cloud == nullptr || (cloud->organised() && cloud->width <= kMaxImageSide && cloud->height <= kMaxImageSide)) return;
  for (const Output* output : {&request.labels, &request.overlay, &request.obstacle_labels}) {
    if (output->asked()) throw UsageError(fmt::format("{} needs an organised cloud; use --cloud", output->option));
  }
}

}  // namespace fransac::cli
