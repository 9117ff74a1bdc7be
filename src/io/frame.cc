// SPDX-License-Identifier: Apache-2.0
#include <cstdint>
#include <system_error>
#include <utility>

#include "fransac/io/camera_file.hpp"
#include "fransac/io/dataset.hpp"
#include "fransac/io/file.hpp"
#include "io/depth_reader.h"
#include "io/guard.h"
#include "io/read_text.h"
#include "io/truth_json.h"

namespace fransac::io {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kMaxTruthBytes = std::size_t{1} << 20;  // 254 planes

std::string size_text(int width, int height) { return std::to_string(width) + "x" + std::to_string(height); }

Result<Camera> read_pinhole(const fs::path& file) {
  const Result<CameraFile> read = read_camera_file(file);
  if (!read) return read.error();
  return pinhole_of(*read, file.string());
}

/// A known camera that delivers images of another size with the same aspect ratio; otherwise the camera as it is.
Camera resized(const Camera& camera, int width, int height) {
  if (std::int64_t{camera.width} * height != std::int64_t{camera.height} * width) return camera;
  const double scale = static_cast<double>(width) / camera.width;
  // Pixel centres are at whole numbers.
  const auto centre = [&](double c) { return (c + 0.5) * scale - 0.5; };
  return {width, height, scale * camera.fx, scale * camera.fy, centre(camera.cx), centre(camera.cy), camera.depth_scale};
}

Result<Camera> camera_of(const FrameFiles& files, const std::optional<fs::path>& camera_file, const DepthView& depth) {
  const std::optional<fs::path>& source = camera_file ? camera_file : files.camera_file;
  if (!source && !files.camera) {
    const std::string searched =
        files.timestamp_s ? "camera.json or camera.yaml in the sequence's folder, which is not named after freiburg1..3"
                          : printable((files.depth.parent_path() / "camera.json").native()) + " or camera.yaml";
    return file_error(
        ErrorCode::no_data, files.depth.native(),
        "no camera: there is no " + searched + ", and none was given (--camera FILE, or a preset such as --camera kinect1)");
  }
  Result<Camera> camera = source ? read_pinhole(*source) : resized(*files.camera, depth.width(), depth.height());
  if (camera && (camera->width != depth.width() || camera->height != depth.height())) {
    return format_error(source.value_or(files.depth).native(), "the camera is for " + size_text(camera->width, camera->height) +
                                                                   " pixels, but " + printable(files.depth.native()) + " has " +
                                                                   size_text(depth.width(), depth.height()));
  }
  return camera;
}

/// Loads an image of the depth image's size with `read`, where there is one.
template <class Image>
Status load_image(const std::optional<fs::path>& file, Result<Image> (*read)(const fs::path&, const ReadLimits&),
                  const FrameFiles& files, const DepthView& depth, std::optional<Image>& loaded) {
  if (!file) return {};
  Result<Image> image = read(*file, files.limits);
  if (!image) return image.error();
  if (image->width != depth.width() || image->height != depth.height()) {
    return format_error(file->native(), "has " + size_text(image->width, image->height) + " pixels, but " +
                                            printable(files.depth.native()) + " has " + size_text(depth.width(), depth.height()));
  }
  loaded = *std::move(image);
  return {};
}

Status load_truth(const FrameFiles& files, Frame& frame) {
  if (!files.truth) return {};
  Result<TruthJson> truth = read_text(*files.truth, kMaxTruthBytes, &parse_truth_json);
  if (!truth) return truth.error();
  frame.true_planes = std::move(truth->planes);
  if (truth->floor) frame.floor = truth->floor;
  return {};
}

/// The frame's values taken for what the user says that they are.
Status rescale(const FrameFiles& files, Frame& frame) {
  frame.camera.depth_scale = *files.depth_scale;
  const auto scale = static_cast<float>(*files.depth_scale);
  for (float& metres : frame.metres.pixels) metres /= scale;
  Status status = validate(frame.camera);
  if (status) return status;
  return file_error(ErrorCode::invalid_argument, files.depth.native(), status.error().message);
}

/// Everything that could be refused, before the first file is written.
Status check_frame(const fs::path& folder, const FrameToWrite& frame) {
  const auto refuse = [&](const std::string& what) { return file_error(ErrorCode::invalid_argument, folder.native(), what); };
  const auto fits = [&](const auto& image, int channels) {
    return image.width == frame.camera.width && image.height == frame.camera.height && image.channels == channels &&
           image.pixels.size() == image.size() * static_cast<std::size_t>(channels);
  };
  if (const Status status = validate(frame.camera); !status) return refuse(status.error().message);
  if (!fits(frame.depth, 1)) return refuse("depth has not the camera's size");
  if (frame.labels && !fits(*frame.labels, 1)) return refuse("labels have not the camera's size");
  if (frame.objects && !fits(*frame.objects, 1)) return refuse("objects have not the camera's size");
  if (frame.colour && !fits(*frame.colour, 3)) return refuse("colour has not the camera's size or not three channels");
  return {};
}

Status write_frame_files(const fs::path& folder, const FrameToWrite& frame) {
  if (Status status = check_frame(folder, frame); !status) return status;
  std::error_code error;
  fs::create_directories(folder, error);
  if (error) return file_error(ErrorCode::io, folder.native(), error.message());
  if (Status status = write_png(folder / "depth.png", frame.depth); !status) return status;
  if (Status status = write_file(folder / "camera.json", camera_to_json(frame.camera)); !status) return status;
  if (frame.labels) {
    if (Status status = write_png(folder / "labels.png", *frame.labels); !status) return status;
  }
  if (frame.objects) {
    if (Status status = write_object_png(folder / "objects.png", *frame.objects); !status) return status;
  }
  if (frame.colour) {
    if (Status status = write_png(folder / "rgb.png", *frame.colour); !status) return status;
  }
  if (frame.true_planes.empty() && frame.true_objects.empty() && !frame.floor && !frame.T_world_camera) return {};
  return write_file(folder / "truth.json", truth_to_json(frame));
}

}  // namespace

struct LoadWorkspace::Implementation {
  DepthReader reader;
};

LoadWorkspace::LoadWorkspace() noexcept = default;
LoadWorkspace::LoadWorkspace(LoadWorkspace&&) noexcept = default;
LoadWorkspace& LoadWorkspace::operator=(LoadWorkspace&&) noexcept = default;
LoadWorkspace::~LoadWorkspace() = default;

Status load_frame(const FrameFiles& files, const std::optional<fs::path>& camera_file, LoadWorkspace& workspace, Frame& frame) {
  return guarded(files.depth.native(), [&]() -> Status {
    if (workspace.implementation_ == nullptr) workspace.implementation_ = std::make_unique<LoadWorkspace::Implementation>();
    RawDepth depth{std::move(frame.depth), std::move(frame.metres)};
    Status status = read_depth_image(files.depth, files.limits, workspace.implementation_->reader, depth);
    if (!status) return status;
    frame = {files.name, {}, std::move(depth.units), {}, {}, {}, {}, files.floor, std::move(depth.metres)};
    const DepthView view = frame.view();
    const Result<Camera> camera = camera_of(files, camera_file, view);
    if (!camera) return camera.error();
    frame.camera = *camera;
    if (files.depth_scale) status = rescale(files, frame);
    if (status) status = load_image(files.labels, &read_label_png, files, view, frame.labels);
    if (status) status = load_image(files.objects, &read_object_png, files, view, frame.objects);
    if (status) status = load_image(files.regions, &read_label_png, files, view, frame.regions);
    if (status) status = load_truth(files, frame);
    return status;
  });
}

Result<Frame> load_frame(const FrameFiles& files, const std::optional<fs::path>& camera_file) {
  return guarded(files.depth.native(), [&]() -> Result<Frame> {
    LoadWorkspace workspace;
    Frame frame;
    if (Status status = load_frame(files, camera_file, workspace, frame); !status) return status.error();
    return frame;
  });
}

Status write_frame(const fs::path& folder, const FrameToWrite& frame) {
  return guarded(folder.native(), [&] { return write_frame_files(folder, frame); });
}

}  // namespace fransac::io
