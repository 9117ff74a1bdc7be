// SPDX-License-Identifier: Apache-2.0
#include "fransac/io/dataset.hpp"

#include <algorithm>
#include <system_error>
#include <utility>

#include "fransac/io/camera_file.hpp"
#include "fransac/io/file.hpp"
#include "io/dataset_json.h"
#include "io/detect.h"
#include "io/guard.h"
#include "io/read_text.h"
#include "io/tum_list.h"

namespace fransac::io {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kMaxListBytes = std::size_t{1} << 26;  // a million images
constexpr std::size_t kMaxJsonBytes = std::size_t{1} << 20;  // dataset.json: two words

std::optional<fs::path> if_file(const fs::path& path) { return is_file(path) ? std::optional(path) : std::nullopt; }

/// The last part of a path that may end in a separator or in dots.
std::string folder_name(const fs::path& folder) {
  const fs::path whole = fs::absolute(folder).lexically_normal();
  return (whole.has_filename() ? whole : whole.parent_path()).filename().string();
}

std::optional<fs::path> colour_in(const fs::path& folder) {
  for (const char* name : {"rgb.png", "rgb.jpg", "rgb.jpeg"}) {
    if (is_file(folder / name)) return folder / name;
  }
  return std::nullopt;
}

std::optional<fs::path> camera_in(const fs::path& folder) {
  for (const char* name : {"camera.json", "camera.yaml", "camera.yml"}) {
    if (is_file(folder / name)) return folder / name;
  }
  return std::nullopt;
}

/// A depth image with all that lies beside it.
FrameFiles frame_in(const fs::path& folder, const fs::path& depth, std::string name) {
  FrameFiles frame;
  frame.name = std::move(name);
  frame.depth = depth;
  frame.colour = colour_in(folder);
  frame.labels = if_file(folder / "labels.png");
  frame.objects = if_file(folder / "objects.png");
  frame.regions = if_file(folder / "gt_seg.png");
  frame.truth = if_file(folder / "truth.json");
  frame.camera_file = camera_in(folder);
  return frame;
}

Result<std::vector<fs::path>> depth_images_in(const fs::path& folder) {
  Result<std::vector<fs::path>> entries = sorted_entries(folder);
  if (entries) std::erase_if(*entries, [](const fs::path& entry) { return !is_depth_image(entry); });
  return entries;
}

/// One image among many of a folder: of what lies there only the camera is its own.
FrameFiles frame_among_many(const fs::path& depth, const std::optional<fs::path>& camera_file) {
  FrameFiles frame;
  frame.name = depth.stem().string();
  frame.depth = depth;
  frame.camera_file = camera_file;
  return frame;
}

/// Truth and sensor from the first dataset.json among `folders`; without one, labels are taken for all planes.
Status describe(Dataset& dataset, std::initializer_list<fs::path> folders) {
  for (const fs::path& folder : folders) {
    if (!is_file(folder / "dataset.json")) continue;
    dataset.files.push_back(folder / "dataset.json");
    Result<DatasetJson> json = read_text(dataset.files.back(), kMaxJsonBytes, &parse_dataset_json);
    if (!json) return json.error();
    dataset.truth = json->truth;
    dataset.sensor = std::move(json->sensor);
    for (FrameFiles& frame : dataset.frames) frame.floor = json->floor;
    return {};
  }
  const bool labelled =
      std::any_of(dataset.frames.begin(), dataset.frames.end(), [](const auto& f) { return f.labels.has_value(); });
  dataset.truth = labelled ? Truth::planes : Truth::none;
  return {};
}

Status list_depth_image(const fs::path& file, Dataset& dataset) {
  const fs::path folder = file.parent_path().empty() ? fs::path(".") : file.parent_path();
  const bool named_depth = is_named_depth(file);
  const Result<std::vector<fs::path>> images = named_depth ? std::vector{file} : depth_images_in(folder);
  if (!images) return images.error();
  const std::optional<fs::path> camera_file = camera_in(folder);
  dataset.frames.push_back(images->size() <= 1 ? frame_in(folder, file, named_depth ? dataset.name : file.stem().string())
                                               : frame_among_many(file, camera_file));
  if (!camera_file && is_tum_sequence(folder / "..")) {  // an image of a TUM sequence
    dataset.frames[0].camera_file = camera_in(folder / "..");
    dataset.frames[0].camera = tum_camera(folder_name(folder / ".."));
  }
  return describe(dataset, {folder, folder / ".."});
}

Status list_frame(const fs::path& folder, Dataset& dataset) {
  dataset.frames.push_back(frame_in(folder, depth_in(folder).value_or(folder / "depth.png"), dataset.name));
  return describe(dataset, {folder, folder / ".."});
}

Status list_dataset(const fs::path& folder, Dataset& dataset) {
  const Result<std::vector<fs::path>> entries = sorted_entries(folder);
  if (!entries) return entries.error();
  for (const fs::path& entry : *entries) {
    if (const auto depth = depth_in(entry)) dataset.frames.push_back(frame_in(entry, *depth, entry.filename().string()));
  }
  if (dataset.frames.empty()) {
    const std::optional<fs::path> camera_file = camera_in(folder);
    for (const fs::path& entry : *entries) {
      if (is_depth_image(entry)) dataset.frames.push_back(frame_among_many(entry, camera_file));
    }
  }
  return describe(dataset, {folder});
}

/// A depth image of a sequence, and its picture where it has one.
struct TumFrame {
  TumEntry depth;
  std::optional<std::string> colour;
};

Result<std::vector<TumFrame>> tum_frames_of_associations(const fs::path& folder) {
  Result<std::vector<TumPair>> pairs = read_text(folder / kTumAssociations, kMaxListBytes, &parse_tum_associations);
  if (!pairs) return pairs.error();
  std::vector<TumFrame> frames;
  for (TumPair& pair : *pairs) frames.push_back({std::move(pair.depth), std::move(pair.colour.file)});
  return frames;
}

/// From depth.txt and rgb.txt, else from associations.txt.
Result<std::vector<TumFrame>> tum_frames(const fs::path& folder) {
  if (!is_file(folder / "depth.txt")) return tum_frames_of_associations(folder);
  Result<std::vector<TumEntry>> depth = read_text(folder / "depth.txt", kMaxListBytes, &parse_tum_list);
  if (!depth) return depth.error();
  const Result<std::vector<TumEntry>> colour =
      is_file(folder / "rgb.txt") ? read_text(folder / "rgb.txt", kMaxListBytes, &parse_tum_list) : std::vector<TumEntry>{};
  if (!colour) return colour.error();
  std::vector<TumFrame> frames;
  for (TumEntry& entry : *depth) {
    const TumEntry* const picture = nearest_entry(*colour, entry.time_s);
    frames.push_back({std::move(entry), picture != nullptr ? std::optional(picture->file) : std::nullopt});
  }
  return frames;
}

/// What lies beside such a depth image is its own.
bool is_depth_of_its_folder(const TumEntry& entry) {
  const fs::path file(entry.file);
  return file.has_parent_path() && is_named_depth(file);
}

Status list_tum(const fs::path& folder, Dataset& dataset) {
  for (const char* const name : {"depth.txt", "rgb.txt", kTumAssociations, "groundtruth.txt"}) {
    if (is_file(folder / name)) dataset.files.push_back(folder / name);
  }
  const Result<std::vector<TumFrame>> frames = tum_frames(folder);
  if (!frames) return frames.error();
  for (const TumFrame& listed : *frames) {
    const fs::path file = folder / listed.depth.file;
    FrameFiles frame =
        is_depth_of_its_folder(listed.depth) ? frame_in(file.parent_path(), file, {}) : frame_among_many(file, std::nullopt);
    frame.name = listed.depth.timestamp;
    if (listed.colour) frame.colour = folder / *listed.colour;
    if (!frame.camera_file) frame.camera_file = camera_in(folder);
    frame.camera = tum_camera(dataset.name);
    frame.timestamp_s = listed.depth.time_s;
    dataset.frames.push_back(std::move(frame));
  }
  return describe(dataset, {folder});
}

Status list_kind(const fs::path& input, Dataset& dataset) {
  switch (dataset.kind) {
    case InputKind::depth_image: return list_depth_image(input, dataset);
    case InputKind::frame: return list_frame(input, dataset);
    case InputKind::dataset: return list_dataset(input, dataset);
    case InputKind::tum_sequence: return list_tum(input, dataset);
    case InputKind::pcd:
    case InputKind::ply:
    case InputKind::xyz: break;
  }
  return file_error(ErrorCode::invalid_argument, input.native(), "a point cloud, which has no depth frames");
}

}  // namespace

Result<Dataset> list_frames(const fs::path& input) {
  return guarded(input.native(), [&]() -> Result<Dataset> {
    const Result<InputKind> kind = detect_kind(input);
    if (!kind) return kind.error();
    Dataset dataset;
    dataset.kind = *kind;
    dataset.name = folder_name(*kind == InputKind::depth_image ? fs::absolute(input).parent_path() : input);
    if (const Status status = list_kind(input, dataset); !status) return status.error();
    if (dataset.frames.empty()) return file_error(ErrorCode::no_data, input.native(), "holds no frame");
    return dataset;
  });
}

Status write_dataset_json(const fs::path& folder, Truth truth, const std::string& sensor) {
  return guarded(folder.native(), [&] { return write_file(folder / "dataset.json", dataset_to_json({truth, sensor, {}})); });
}

}  // namespace fransac::io
