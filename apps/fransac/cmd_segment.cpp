// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <limits>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "commands.hpp"
#include "errors.hpp"
#include "fransac/core/printable.hpp"
#include "fransac/filter/correct.hpp"
#include "fransac/filter/deproject.hpp"
#include "fransac/io/overlay.hpp"
#include "fransac/obstacles/obstacles.hpp"
#include "fransac/planes/outline.hpp"
#include "fransac/version.hpp"
#include "geometry_json.hpp"
#include "grid_output.hpp"
#include "inputs.hpp"
#include "obstacle_output.hpp"
#include "options.hpp"
#include "output.hpp"
#include "progress.hpp"
#ifdef FRANSAC_HAS_CLOUD_IO
#include "fransac/io/cloud_file.hpp"
#endif

namespace fransac::cli {
namespace {

namespace fs = std::filesystem;

/// A kind of output and what the user called it: a file, or a folder with one file per frame.
struct Output {
  const char* option;
  const char* extension;                        ///< Of the files in a folder.
  std::initializer_list<const char*> accepted;  ///< What a single file's name may end in; empty: anything.
  std::string path;                             ///< Empty: not asked for.

  [[nodiscard]] bool asked() const { return !path.empty(); }
  [[nodiscard]] bool to_stdout() const { return path == "-"; }
};

constexpr auto kPicture = {".png"};
constexpr auto kCloud = {".pcd", ".ply"};

/// Units of a cloud's coordinates, and what they are in metres.
constexpr std::array<std::pair<const char*, double>, 5> kUnits{
    {{"m", 1.0}, {"cm", 0.01}, {"mm", 0.001}, {"in", 0.0254}, {"ft", 0.3048}}};

struct SegmentCommand {
  std::string input;
  InputOptions inputs;
  std::optional<double> metres_per_unit;  ///< Of a cloud's coordinates.
  Output labels{"--labels", ".png", kPicture, {}};
  Output json{"--json", ".json", {}, {}};
  Output overlay{"--overlay", ".png", kPicture, {}};
  Output cloud{"--cloud", ".ply", kCloud, {}};
  Output obstacle_labels{"--obstacle-labels", ".png", kPicture, {}};
  bool outlines = false;
  SegmentOptions options;
  ObstacleRequest obstacles;
  GridRequest grid;

  [[nodiscard]] std::array<const Output*, 5> outputs() const { return {&labels, &obstacle_labels, &overlay, &cloud, &json}; }
  [[nodiscard]] bool asks_for_output() const {
    const auto all = outputs();
    return grid.asked() || std::any_of(all.begin(), all.end(), [](const Output* output) { return output->asked(); });
  }
};

/// What a frame or cloud holds; the obstacles are empty unless they are asked for.
struct Found {
  Segmentation segmentation;
  Obstacles obstacles;
};

bool has_extension(const fs::path& path, std::initializer_list<const char*> extensions) {
  std::string extension = path.extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(), [](unsigned char c) { return std::tolower(c); });
  return std::find(extensions.begin(), extensions.end(), extension) != extensions.end();
}

fs::path output_file(const Output& output, const Input& input, std::size_t i) {
  return input.is_folder_of_frames() ? fs::path(output.path) / (input.frames[i].name + output.extension) : fs::path(output.path);
}

/// Of a folder of frames each frame's name, in the folder that an option names.
fs::path grid_base(const GridRequest& request, const Input& input, std::size_t i) {
  return input.is_folder_of_frames() ? fs::path(request.base) / input.frames[i].name : fs::path(request.base);
}

void check_folder(const char* option, const std::string& folder, const Input& input, RunFiles& files) {
  if (has_extension(folder, {".png", ".json", ".ply", ".pcd"}) && !fs::is_directory(folder)) {
    throw UsageError(fmt::format("{}: {} holds several frames, so this names a folder, not a file", option, input.name));
  }
  files.writes_folder(option, folder);
}

/// Refuses outputs that could not be written, that would replace an input, or that would replace each other; before any
/// work is done.
void check_outputs(SegmentCommand& command, const Input& input) {
  if (input.is_folder_of_frames() && command.grid.asked()) command.inputs.files.writes_folder("--grid-out", command.grid.base);
  for (std::size_t i = 0; i < input.size(); ++i) {
    if (input.is_folder_of_frames() && fs::path(input.frames[i].name).filename() != input.frames[i].name) {
      throw Failure(fmt::format("{}: the frame name {} is no file name", input.name, quoted_text(input.frames[i].name)));
    }
    if (command.grid.asked()) check_place(grid_base(command.grid, input, i), command.inputs.files);
  }
  for (const Output* output : command.outputs()) {
    if (!output->asked() || output->to_stdout()) continue;
    if (input.is_folder_of_frames()) check_folder(output->option, output->path, input, command.inputs.files);
    for (std::size_t i = 0; i < input.size(); ++i) command.inputs.files.writes(output->option, output_file(*output, input, i));
  }
}

/// What cannot be asked for at all, known without looking at the input's content.
void check_usage(const SegmentCommand& command) {
  for (const Output* output : command.outputs()) {
    if (output->to_stdout() && output != &command.json) {
      throw UsageError(fmt::format("{}: only --json can go to standard output", output->option));
    }
  }
  if (command.outlines && !command.json.asked()) throw UsageError("--outlines: outlines are part of --json, which is missing");
#ifndef FRANSAC_HAS_CLOUD_IO
  if (command.cloud.asked())
    throw UsageError("--cloud: this fransac was built without support for point clouds (FRANSAC_BUILD_CLOUD_IO)");
#endif
}

/// A file's name says its format; devices and pipes have no such name, and a cloud's format is known by nothing else.
void check_names(const SegmentCommand& command, const Input& input) {
  if (input.is_folder_of_frames()) return;
  for (const Output* output : command.outputs()) {
    if (!output->asked() || output->accepted.size() == 0 || has_extension(output->path, output->accepted)) continue;
    const bool special = fs::exists(output->path) && !fs::is_regular_file(output->path);
    if (special && output != &command.cloud) continue;
    throw UsageError(fmt::format("{}: '{}' must end in {}", output->option, output->path, fmt::join(output->accepted, " or ")));
  }
}

/// Images of labels need rows and columns; outlines and maps need a camera, whose rays say what is free.
void check_organised(const SegmentCommand& command, const Content& content) {
  const auto* cloud = std::get_if<PointCloud>(&content);
  if (cloud != nullptr && command.outlines) throw UsageError("--outlines needs a depth image");
  if (cloud != nullptr && command.grid.asked()) throw UsageError("--grid needs a depth image");
  if (cloud == nullptr || (cloud->organised() && cloud->width <= kMaxImageSide && cloud->height <= kMaxImageSide)) return;
  for (const Output* output : {&command.labels, &command.overlay, &command.obstacle_labels}) {
    if (output->asked()) throw UsageError(fmt::format("{} needs an organised cloud; use --cloud", output->option));
  }
}

/// A cloud's distance from its origin of coordinates as a depth image, to be shaded.
std::vector<float> distances(const PointCloud& cloud) {
  std::vector<float> metres(cloud.size(), 0.0F);
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    if (cloud.finite(i)) metres[i] = static_cast<float>(cloud.point(i).norm());
  }
  return metres;
}

io::ColourImage picture_of(const SegmentCommand& command, const DepthView& view, const Found& found,
                           const io::ColourImage* background) {
  if (command.obstacles.asked) return obstacle_overlay(view, found.segmentation.labels, found.obstacles.labels, background);
  return io::overlay(view, found.segmentation.labels, background);
}

io::ColourImage overlay_of(const SegmentCommand& command, const Input& input, std::size_t i, const Content& content,
                           const Found& found) {
  if (const auto* cloud = std::get_if<PointCloud>(&content)) {
    const std::vector<float> metres = distances(*cloud);
    return picture_of(command, DepthView::from_float(metres.data(), cloud->width, cloud->height), found, nullptr);
  }
  std::optional<io::ColourImage> colour;
  if (input.frames[i].colour) colour = unwrap(io::read_colour_image(*input.frames[i].colour, input.limits));
  return picture_of(command, std::get<io::Frame>(content).view(), found, colour ? &*colour : nullptr);
}

#ifdef FRANSAC_HAS_CLOUD_IO
/// The labels of a cloud's points from those of the pixels that they were; none stay none.
template <class Label>
std::vector<Label> labels_of_points(const PointCloud& cloud, const std::vector<Label>& of_pixels) {
  std::vector<Label> labels(of_pixels.empty() ? 0 : cloud.size());
  for (std::size_t p = 0; p < labels.size(); ++p) labels[p] = of_pixels[cloud.source_of(p)];
  return labels;
}
#endif

/// Empty in a build without clouds, which refuses --cloud.
std::string encode_cloud([[maybe_unused]] const fs::path& file, [[maybe_unused]] const Content& content,
                         [[maybe_unused]] const Found& found, [[maybe_unused]] int saturated) {
#ifdef FRANSAC_HAS_CLOUD_IO
  const auto& labels = found.segmentation.labels;
  const auto& ids = found.obstacles.labels;
  if (const auto* cloud = std::get_if<PointCloud>(&content)) {
    return unwrap(io::encode_cloud(file, *cloud, labels, io::CloudEncoding::binary, ids));
  }
  const auto& frame = std::get<io::Frame>(content);
  PointCloud cloud;
  CorrectedDepth corrected;
  const Distortion& distortion = found.segmentation.distortion;
  if (!distortion.empty()) check(correct(frame.view(), distortion, saturated, corrected));
  deproject(distortion.empty() ? frame.view() : corrected.view, frame.camera, cloud);
  return unwrap(
      io::encode_cloud(file, cloud, labels_of_points(cloud, labels), io::CloudEncoding::binary, labels_of_points(cloud, ids)));
#else
  return {};
#endif
}

nlohmann::ordered_json evidence_to_json(const PlaneEvidence& evidence) {
  return {{"share", evidence.share},
          {"turn_rad", evidence.turn_rad},
          {"turn_sigma_rad", evidence.turn_sigma_rad},
          {"smooth_border", evidence.smooth_border}};
}

nlohmann::ordered_json plane_to_json(const PlaneSegment& segment, Method method) {
  const bool cells = method == Method::cells;  // the others know no evidence and no covariance
  return {{"id", segment.id},
          {"normal", vector_to_json(segment.plane.normal)},
          {"d", segment.plane.d},
          {"inliers", segment.inliers},
          {"support", segment.support},
          {"rms_m", segment.rms_m},
          {"area_m2", segment.area_m2},
          {"confidence", segment.confidence},
          {"evidence", cells ? evidence_to_json(segment.evidence) : nullptr},
          {"centroid", segment.centroid.isZero(0.0) ? nullptr : vector_to_json(segment.centroid)},
          {"kind", enum_name(segment.kind)},
          {"covariance", cells ? matrix_to_json(segment.covariance) : nullptr},
          {"iterations", segment.iterations},
          {"stop_reason", to_string(segment.stop_reason)}};
}

nlohmann::ordered_json noise_to_json(const DepthNoise& noise) {
  return {{"constant_m", noise.constant_m}, {"linear", noise.linear}, {"quadratic_per_m", noise.quadratic_per_m}};
}

nlohmann::ordered_json timing_to_json(const Timing& timing) {
  nlohmann::ordered_json json;
  for (std::size_t stage = 0; stage < timing.stage_ms.size(); ++stage) {
    json[std::string(EnumNames<Stage>::values[stage])] = timing.stage_ms[stage];
  }
  json["total"] = timing.total_ms;
  return json;
}

nlohmann::ordered_json to_json(const SegmentCommand& command, const Input& input, std::size_t i, const Content& content,
                               const Found& found) {
  const Segmentation& segmentation = found.segmentation;
  nlohmann::ordered_json json;
  json["input"] = input.name_of(i);
  if (input.is_folder_of_frames()) json["frame"] = input.frames[i].name;
  json["method"] = enum_name(segmentation.method);
  json["seed"] = command.options.seed;
  json["width"] = segmentation.width;
  json["height"] = segmentation.height;
  json["planes"] = nlohmann::ordered_json::array();
  for (const PlaneSegment& plane : segmentation.planes) json["planes"].push_back(plane_to_json(plane, segmentation.method));
  if (command.obstacles.asked) json["obstacles"] = obstacles_to_json(segmentation, found.obstacles);
  if (command.outlines) {
    const Camera& camera = std::get<io::Frame>(content).camera;
    const auto of_planes = outlines(segmentation, camera);
    for (std::size_t p = 0; p < of_planes.size(); ++p) json["planes"][p]["outlines"] = outlines_to_json(of_planes[p]);
    if (command.obstacles.asked) add_outlines(json["obstacles"], found.obstacles, of_planes, camera);
  }
  json["up"] = segmentation.up ? vector_to_json(*segmentation.up) : nullptr;
  json["up_source"] = enum_name(segmentation.up_source);
  json["up_sigma_rad"] =
      segmentation.up_source == UpSource::estimated ? nlohmann::ordered_json(segmentation.up_sigma_rad) : nullptr;
  json["sensor_position"] = segmentation.sensor_position ? vector_to_json(*segmentation.sensor_position) : nullptr;
  const bool cells = segmentation.method == Method::cells;  // the others know no errors of the sensor
  json["noise"] = cells ? noise_to_json(segmentation.noise) : nullptr;
  json["slow_noise"] = cells ? noise_to_json(segmentation.slow_noise) : nullptr;
  json["bias_m"] = cells ? nlohmann::ordered_json(segmentation.bias_m) : nullptr;
  json["corrected"] = !segmentation.distortion.empty();
  json["iterations"] = segmentation.iterations;
  json["stop_reason"] = to_string(segmentation.stop_reason);
  json["timing_ms"] = timing_to_json(segmentation.timing);
  json["valid_points"] = segmentation.valid_points;
  json["sampled_points"] = segmentation.sampled_points;
  json["rejected"] = segmentation.rejected;
  json["degenerate_samples"] = segmentation.degenerate;
  json["options"] = options_to_json(with_defaults(command.options, segmentation.method));
  if (command.obstacles.asked) json["options"].update(options_to_json(command.obstacles.options));
  json["fransac_version"] = kVersion;
  return json;
}

/// Extent and spacing of a cloud, metres: what tells a user that the threshold or the unit is wrong.
struct CloudScale {
  double extent_m = 0.0;   ///< Diagonal of the bounding box.
  double spacing_m = 0.0;  ///< Median distance to the nearest other point, over some points.
};

CloudScale scale_of(const PointCloud& cloud) {
  constexpr std::size_t kProbes = 101;
  std::vector<std::size_t> finite;
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    if (cloud.finite(i)) finite.push_back(i);
  }
  if (finite.size() < 2) return {};
  Eigen::Vector3d low = cloud.local(finite[0]);
  Eigen::Vector3d high = low;
  for (const std::size_t i : finite) {
    low = low.cwiseMin(cloud.local(i));
    high = high.cwiseMax(cloud.local(i));
  }
  std::vector<double> nearest;
  for (std::size_t probe = 0; probe < kProbes; ++probe) {
    const std::size_t i = finite[probe * finite.size() / kProbes];
    double best = std::numeric_limits<double>::infinity();
    for (const std::size_t j : finite) {
      if (j != i) best = std::min(best, (cloud.local(i) - cloud.local(j)).squaredNorm());
    }
    nearest.push_back(std::sqrt(best));
  }
  std::nth_element(nearest.begin(), nearest.begin() + kProbes / 2, nearest.end());
  return {(high - low).norm(), nearest[kProbes / 2]};
}

/// The options by which the user left planes out.
std::string chosen_limits(const CellsOptions& cells) {
  std::vector<std::string> names;
  if (cells.parallel_to) names.emplace_back("--parallel-to");
  if (cells.perpendicular_to) names.emplace_back("--perpendicular-to");
  if (cells.min_area_m2 > 0.0) names.emplace_back("--min-area");
  if (cells.min_confidence > CellsOptions{}.min_confidence) names.emplace_back("--min-confidence");
  return joined(names, " and ");
}

/// Why there may be no plane and what to try.
void explain_no_planes(const std::string& name, const Content& content, const SegmentOptions& options,
                       const Segmentation& segmentation) {
  const double min_support = *with_defaults(options, segmentation.method).min_support;
  const bool cells = segmentation.method == Method::cells;  // it knows no threshold
  const std::string threshold = cells ? "" : fmt::format("a larger --threshold (now {:g} m) or ", options.ransac.threshold_m);
  log(fmt::format(
      "{}: no plane has the minimum support of {:g} % of the {} sampled points; try {}a smaller --min-support (now {:g})", name,
      100.0 * min_support, segmentation.sampled_points, threshold, min_support));
  const std::string limits = chosen_limits(options.cells);
  if (!limits.empty()) log(fmt::format("{}: {} may have left planes out", name, limits));
  const auto* cloud = std::get_if<PointCloud>(&content);
  if (cloud == nullptr || cells) return;
  const CloudScale scale = scale_of(*cloud);
  if (scale.spacing_m <= options.ransac.threshold_m) return;
  log(fmt::format(
      "{}: its points are typically {:.4g} m apart (extent {:.4g} m), more than the threshold: if its unit is not metres, say so "
      "with --unit; if it is this coarse, choose --threshold and --leaf-size to match",
      name, scale.spacing_m, scale.extent_m));
}

std::string normal_text(const Eigen::Vector3d& n) { return fmt::format("({:+.4f}, {:+.4f}, {:+.4f})", n.x(), n.y(), n.z()); }

Table plane_table(const Input& input) {
  std::vector<std::string> headings{"plane",   "<normal",  "d [m]",     input.is_cloud() ? "points" : "pixels",
                                    "support", "rms [mm]", "area [m2]", "confidence",
                                    "<kind"};
  if (input.is_folder_of_frames()) headings.insert(headings.begin(), "<frame");
  return Table(std::move(headings));
}

void add_planes(Table& table, const Input& input, std::size_t i, const Segmentation& segmentation) {
  const bool judged = segmentation.method == Method::cells;  // the others do not judge
  for (const PlaneSegment& segment : segmentation.planes) {
    std::vector<std::string> cells{fmt::format("{}", segment.id),
                                   normal_text(segment.plane.normal),
                                   fmt::format("{:.4f}", segment.plane.d),
                                   fmt::format("{}", segment.inliers),
                                   fmt::format("{}", segment.support),
                                   fmt::format("{:.2f}", 1e3 * segment.rms_m),
                                   fmt::format("{:.3f}", segment.area_m2),
                                   judged ? fmt::format("{:.2f}", segment.confidence) : "",
                                   segment.kind == PlaneKind::unknown ? "" : std::string(enum_name(segment.kind))};
    if (input.is_folder_of_frames()) cells.insert(cells.begin(), input.frames[i].name);
    table.add(std::move(cells));
  }
}

/// All of a frame's outputs or, when one fails, none.
void write_outputs(const SegmentCommand& command, const Input& input, std::size_t i, const Content& content, const Found& found) {
  const Segmentation& segmentation = found.segmentation;
  const Obstacles& obstacles = found.obstacles;
  Outputs outputs;
  const auto write = [&](const Output& output, const auto& encode) {
    if (!output.asked()) return;
    if (input.is_folder_of_frames()) outputs.make_folder(output.path);
    const fs::path file = output_file(output, input, i);
    outputs.write(file, encode(file));
  };
  write(command.labels, [&](const fs::path&) {
    return unwrap(io::encode_png(io::LabelImage{segmentation.width, segmentation.height, 1, segmentation.labels}));
  });
  write(command.obstacle_labels, [&](const fs::path&) {
    return unwrap(io::encode_png(io::ObjectImage{obstacles.width, obstacles.height, 1, obstacles.labels}));
  });
  write(command.overlay, [&](const fs::path&) { return unwrap(io::encode_png(overlay_of(command, input, i, content, found))); });
  write(command.cloud, [&](const fs::path& file) { return encode_cloud(file, content, found, command.options.saturated); });
  if (command.grid.asked()) {
    if (input.is_folder_of_frames()) outputs.make_folder(command.grid.base);
    write_grid(command.grid, grid_base(command.grid, input, i), std::get<io::Frame>(content), segmentation, obstacles, outputs);
  }
  const bool line = command.json.to_stdout() && input.is_folder_of_frames();
  const auto json = [&](const fs::path&) { return to_text(to_json(command, input, i, content, found), line ? -1 : 2); };
  command.json.to_stdout() ? write_stdout(json({})) : write(command.json, json);
  outputs.commit();
}

/// What a run keeps from frame to frame.
struct SegmentRun {
  const SegmentCommand& command;
  const Input& input;
  Table table = plane_table(input);
  Table supports_table = support_table(input.is_folder_of_frames());
  Table obstacles_table = obstacle_table(input.is_folder_of_frames(), input.is_cloud());
  Progress progress = Progress(input.size());
  Doubts doubts{};
  Workspace workspace{};
  ObstacleWorkspace obstacle_workspace{};
  Found found{};
  bool any_planes = false;
  std::size_t failed = 0;

  void frame(std::size_t i) {
    progress.step(input.name_of(i));
    const Content content = load(input, i, doubts, progress);
    check_organised(command, content);
    segment(input.name_of(i), content, command.options, workspace, found.segmentation);
    if (command.obstacles.asked) find(i, content);
    write_outputs(command, input, i, content, found);
    any_planes = any_planes || !found.segmentation.planes.empty();
    if (!command.asks_for_output()) add_rows(i);
    explain(i, content);
  }

  void find(std::size_t i, const Content& content) {
    const auto* const cloud = std::get_if<PointCloud>(&content);
    const Status status = cloud != nullptr ? find_in(*cloud) : find_in(std::get<io::Frame>(content));
    if (!status) throw Failure(fmt::format("{}: {}", input.name_of(i), status.error().message));
  }

  Status find_in(const io::Frame& frame) {
    const AxisLimits* const limits = limits_of(command.options, found.segmentation.method, true);
    return find_obstacles(frame.view(), frame.camera, found.segmentation, command.obstacles.options, limits, obstacle_workspace,
                          found.obstacles);
  }

  Status find_in(const PointCloud& cloud) {
    const AxisLimits* const limits = limits_of(command.options, found.segmentation.method, false);
    Result<Obstacles> obstacles = find_obstacles(cloud, found.segmentation, command.obstacles.options, limits);
    if (!obstacles) return obstacles.error();
    found.obstacles = std::move(*obstacles);
    return {};
  }

  void add_rows(std::size_t i) {
    add_planes(table, input, i, found.segmentation);
    const auto frame = input.is_folder_of_frames() ? std::optional(input.frames[i].name) : std::nullopt;
    if (!command.obstacles.asked) return;
    add_support(supports_table, frame, found.segmentation, found.obstacles);
    add_obstacles(obstacles_table, frame, found.obstacles);
  }

  /// What was looked for in vain, and what is in doubt.
  void explain(std::size_t i, const Content& content) {
    progress.clear();
    if (found.segmentation.planes.empty()) explain_no_planes(input.name_of(i), content, command.options, found.segmentation);
    if (!command.obstacles.asked) return;
    const std::string warning = support_warning(command.obstacles.options.support, found.segmentation, found.obstacles);
    if (!warning.empty()) log(fmt::format("{}: {}", input.name_of(i), warning));
  }

  [[nodiscard]] std::string text() const {
    return table.text() + (command.obstacles.asked ? "\n" + supports_table.text() + "\n" + obstacles_table.text() : "");
  }

  /// A bad frame among several does not stop the others; a standard output that is gone does.
  void frame_of_many(std::size_t i) try { frame(i); } catch (const StdoutFailure&) {
    throw;
  } catch (const Failure& error) {
    progress.clear();
    log(error.what());
    ++failed;
  }
};

void run_segment(SegmentCommand& command) {
  check_usage(command);
  check_options(command.options);
  check_options(command.obstacles.options);
  check_options(command.grid);
  Input input = open_input(command.input, command.inputs);
  if (command.metres_per_unit && !input.is_cloud()) {
    throw UsageError(fmt::format(
        "--unit: {} is no point cloud; a depth image's unit is --depth-scale, or its camera's depth_scale", input.name));
  }
  input.metres_per_unit = command.metres_per_unit.value_or(1.0);
  check_names(command, input);
  check_outputs(command, input);

  SegmentRun run{command, input};
  for (std::size_t i = 0; i < input.size(); ++i) input.is_folder_of_frames() ? run.frame_of_many(i) : run.frame(i);
  run.progress.clear();
  if (!command.asks_for_output() && (run.any_planes || command.obstacles.asked)) write_stdout(run.text());
  if (run.failed > 0) throw Failure(fmt::format("{}: {} of {} frames failed", input.name, run.failed, input.size()));
}

void add_unit(Command& command, std::optional<double>& metres_per_unit) {
  std::vector<std::string> names;
  for (const auto& [name, metres] : kUnits) names.emplace_back(name);
  add_choice(command, "--unit", names, names.front(), "unit of a point cloud's coordinates",
             [&metres_per_unit](std::size_t unit) { metres_per_unit = kUnits[unit].second; });
}

}  // namespace

Command segment_command() {
  auto request = std::make_shared<SegmentCommand>();
  Command command{.name = "segment", .help = "find planes in a depth frame, a folder of frames or a point cloud"};
  add_input(command, "INPUT", request->input,
            "a depth image (PNG, TIFF, PGM or NPY, with its camera beside it), a frame folder, a folder of frames, a TUM "
            "RGB-D sequence, a PCD, PLY or XYZ file");
  add_input_options(command, request->inputs);
  add_unit(command, request->metres_per_unit);
  add_output(command, "--labels", request->labels.path, "FILE",
             "label image: 8-bit PNG, 0 no depth, 1, 2, ... planes, 255 on no plane");
  add_output(command, "--json", request->json.path, "FILE|-", "planes, obstacles, evidence and timing; '-' is standard output");
  add_flag(command, "--outlines", request->outlines,
           "the planes', drops' and free space's outlines in --json: polygons with holes, in pixels and on the plane in metres "
           "(depth images)");
  add_output(command, "--overlay", request->overlay.path, "FILE", "picture of the planes, or of the obstacles: PNG");
  add_output(command, "--cloud", request->cloud.path, "FILE",
             "coloured points with labels, and with --obstacles their numbers: .pcd or .ply");
  add_segment_options(command, request->options, request->inputs.files);
  add_obstacle_options(command, request->obstacles,
                       "find what stands on or hangs above a plane, in depth images also what falls away from it");
  add_output(command, "--obstacle-labels", request->obstacle_labels.path, "FILE",
             "which obstacle each pixel is on: 16-bit PNG, 0 none, else the number in table and --json (clouds without rows "
             "and columns: the field obstacle of --cloud)")
      .group = kObstacleGroup;
  add_grid_options(command, request->grid);
  need_obstacles(command);
  command.examples = {{"--camera", "depth.png --camera camera.json"},
                      {"--overlay", "desk --overlay planes.png"},
                      {"--json", "desk --json -"},
                      {"--labels", "desk --labels labels.png"},
                      {"--cloud", "desk --cloud planes.ply"},
                      {"--obstacles", "desk --obstacles"},
                      {"--up", "desk --up 0,-1,0"},
                      {"--method", "desk --method fransac"},
                      {"--planes", "scan.pcd --planes all"},
                      {"--threshold", "scan.pcd --threshold 0.02"}};
  command.footer =
      "Without any output file a table of the planes, and of the obstacles, is printed.\n"
      "For a folder of frames or a sequence, the outputs name folders (made when missing): one file per frame, named after it "
      "(clouds: .ply);\n"
      "--json - then prints one document per line. A frame that fails is named on standard error, the others are done, and the "
      "exit code is 1\n"
      "at the end. A frame without a plane of the minimum support is no error: its list of "
      "planes is empty.";
  command.run = [request] { run_segment(*request); };
  return command;
}

}  // namespace fransac::cli
