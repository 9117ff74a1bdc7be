// SPDX-License-Identifier: Apache-2.0
#include "../errors.hpp"
#include "fransac/io/ros_map.hpp"
#include "writers.hpp"

namespace fransac::cli {
namespace {

namespace fs = std::filesystem;

io::LabelImage labels_of(const Segmentation& found) { return {found.width, found.height, 1, found.labels}; }
io::ObjectImage labels_of(const Obstacles& found) { return {found.width, found.height, 1, found.labels}; }

/// BASE.pgm and BASE.yaml, as ROS's map_server reads them.
void write_map(const fs::path& base, const OccupancyGrid& grid, Outputs& outputs) {
  const io::RosMap map = unwrap(io::encode_ros_map(base, grid));
  outputs.write(fs::path(base) += ".pgm", map.pgm);
  outputs.write(fs::path(base) += ".yaml", map.yaml);
}

}  // namespace

void write_outputs(const SegmentRequest& request, const Input& input, std::size_t i, const SegmentResult& result) {
  Outputs outputs;
  const auto write = [&](const Output& output, const auto& encode) {
    if (!output.asked() || output.to_stdout()) return;
    if (input.is_folder_of_frames()) outputs.make_folder(output.path);
    const fs::path file = output.file(input, i);
    outputs.write(file, encode(file));
  };
  write(request.labels, [&](const fs::path&) { return unwrap(io::encode_png(labels_of(result.segmentation))); });
  write(request.obstacle_labels, [&](const fs::path&) { return unwrap(io::encode_png(labels_of(*result.obstacles))); });
  write(request.overlay, [&](const fs::path&) { return unwrap(io::encode_png(*result.overlay)); });
  write(request.cloud, [&](const fs::path& file) { return encode_points(file, result); });
  if (request.grid.asked()) {
    if (input.is_folder_of_frames()) outputs.make_folder(request.grid.path);
    write_map(request.grid.file(input, i), *result.grid, outputs);
  }
  const bool line = request.json.to_stdout() && input.is_folder_of_frames();
  const auto json = [&](const fs::path&) { return to_text(to_json(request, result), line ? -1 : 2); };
  if (request.json.to_stdout()) write_stdout(json({}));
  write(request.json, json);
  outputs.commit();
}

}  // namespace fransac::cli
