// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "commands.hpp"
#include "errors.hpp"
#include "fransac/io/dataset.hpp"
#include "fransac/io/file.hpp"
#include "fransac/synth/synth.hpp"
#include "options.hpp"
#include "output.hpp"
#include "progress.hpp"
#include "run_files.hpp"

namespace fransac::cli {
namespace {

namespace fs = std::filesystem;

struct SynthCommand {
  std::string folder;
  synth::SynthOptions options;  // its defaults are the command's
  int frames = 1;
  int width = options.camera.width;
  int height = options.camera.height;
};

/// "sensor" in dataset.json: the principle of measurement.
const char* principle(synth::Sensor sensor) {
  switch (sensor) {
    case synth::Sensor::none: return "none";
    case synth::Sensor::kinect1: return "structured_light";
    case synth::Sensor::stereo: return "stereo";
    case synth::Sensor::tof: return "time_of_flight";
  }
  return "none";
}

std::vector<std::string> scene_words() {
  const auto names = synth::scene_names();
  std::vector<std::string> words(names.begin(), names.end());
  words.emplace_back("all");
  return words;
}

/// The label of the floor: the largest level plane near the height that scenes are built from, z = 0; 0 when none is seen.
int floor_label(const synth::SynthFrame& frame) {
  constexpr double kRounding = 1e-6;
  constexpr double kKerb_m = 0.2;  // of a street and its pavement the larger one
  for (const auto& [label, plane] : frame.true_planes) {
    const Eigen::Vector3d up = frame.T_world_camera.linear() * plane.normal;
    const double height_m = up.dot(frame.T_world_camera.translation()) - plane.d;
    if (up.z() > 1.0 - kRounding && std::abs(height_m) < kKerb_m) return label;
  }
  return 0;
}

void write_synth_frame(const fs::path& folder, synth::Motion motion, synth::SynthFrame frame) {
  const int width = frame.camera.width;
  const int height = frame.camera.height;
  const int floor = floor_label(frame);
  check(io::write_frame(folder, {.camera = frame.camera,
                                 .depth = {width, height, 1, std::move(frame.depth)},
                                 .labels = io::LabelImage{width, height, 1, std::move(frame.labels)},
                                 .objects = io::ObjectImage{width, height, 1, std::move(frame.objects)},
                                 .colour = io::ColourImage{width, height, 3, std::move(frame.colour)},
                                 .label_scope = motion == synth::Motion::walk ? io::LabelScope::sequence : io::LabelScope::frame,
                                 .true_planes = std::move(frame.true_planes),
                                 .floor = floor,
                                 .true_objects = std::move(frame.true_objects),
                                 .T_world_camera = frame.T_world_camera}));
}

/// The lists that make a folder of frames a TUM RGB-D sequence with its camera's path.
class SequenceLists {
 public:
  void add(const std::string& frame_folder, int frame, const Eigen::Isometry3d& pose) {
    const std::string time = fmt::format("{:.6f}", frame / synth::kFrameRate_hz);
    depth_ += fmt::format("{} {}/depth.png\n", time, frame_folder);
    colour_ += fmt::format("{} {}/rgb.png\n", time, frame_folder);
    const Eigen::Vector3d t = pose.translation();
    const Eigen::Quaterniond q(pose.linear());
    poses_ += fmt::format("{} {:.9f} {:.9f} {:.9f} {:.9f} {:.9f} {:.9f} {:.9f}\n", time, t.x(), t.y(), t.z(), q.x(), q.y(), q.z(),
                          q.w());
  }

  void write(const fs::path& folder) const {
    check(io::write_file(folder / "rgb.txt", colour_));
    check(io::write_file(folder / "groundtruth.txt", poses_));
    check(io::write_file(folder / "depth.txt", depth_));
  }

 private:
  std::string depth_ = "# timestamp filename\n";
  std::string colour_ = "# timestamp filename\n";
  std::string poses_ = "# timestamp tx ty tz qx qy qz qw (camera to world; metres)\n";
};

void run_synth(const SynthCommand& command) {
  if (command.options.motion == synth::Motion::walk && command.options.scene == "all") {
    throw UsageError("--motion walk makes a sequence of one scene: choose one with --scene, not all");
  }
  RunFiles().writes_folder("OUT_DIR", command.folder);
  std::vector<std::string> scenes{command.options.scene};
  if (command.options.scene == "all") scenes.assign(synth::scene_names().begin(), synth::scene_names().end());

  io::OutputFolder output = unwrap(io::OutputFolder::create(command.folder));
  Progress progress(scenes.size() * static_cast<std::size_t>(command.frames));
  synth::SynthOptions options = command.options;
  options.camera = synth::resized(options.camera, command.width, command.height);
  SequenceLists lists;
  for (const std::string& scene : scenes) {
    for (options.frame = 0; options.frame < command.frames; ++options.frame) {
      options.scene = scene;
      // Numbers of equal length, so that frames sort by name in their order.
      const auto digits = std::to_string(command.frames - 1).size();
      const std::string name = fmt::format("{}_{}_{:0{}}", scene, options.seed, options.frame, digits);
      progress.step(name);
      synth::SynthFrame frame = unwrap(synth::render(options));
      lists.add(name, options.frame, frame.T_world_camera);
      write_synth_frame(output.path() / name, options.motion, std::move(frame));
    }
  }
  check(io::write_dataset_json(output.path(), io::Truth::planes, principle(options.sensor)));
  if (options.motion == synth::Motion::walk) lists.write(output.path());
  check(output.commit());
}

}  // namespace

Command synth_command() {
  auto request = std::make_shared<SynthCommand>();
  synth::SynthOptions& options = request->options;
  Command command{.name = "synth", .help = "render depth frames with exact truth"};
  add_input(command, "OUT_DIR", request->folder, "folder to make; may exist if it is empty");
  add_choice(command, "--scene", scene_words(), options.scene, "what is seen",
             [&options](std::size_t scene) { options.scene = scene_words()[scene]; });
  add_choice(command, "--noise", options.sensor, "how depth is measured");
  add_choice(command, "--motion", options.motion, "how the camera moves: about a spot, or on a smooth round as one sequence");
  add_count(command, "--frames", request->frames, 1, 100000, "frames per scene");
  add_seed(command, options.seed, "seed of the scene's objects and the noise");
  add_count(command, "--width", request->width, 16, kMaxImageSide, "columns; the field of view stays");
  add_count(command, "--height", request->height, 16, kMaxImageSide, "rows; the field of view stays");
  command.examples = {{"--scene", "steps --scene stairs"},
                      {"--noise", "far --noise stereo"},
                      {"--motion", "round --motion walk --frames 10"},
                      {"--frames", "three --frames 3"},
                      {"--seed", "seventh --seed 7"}};
  command.footer =
      "Writes OUT_DIR/<scene>_<seed>_<frame>/ with depth.png, camera.json, labels.png, objects.png, rgb.png and truth.json, and "
      "OUT_DIR/dataset.json; truth.json has the planes, the objects and which label is the floor.\n"
      "--motion walk: 1 to 3 cm and 0.3 to 1 degree a frame; a label is the same plane in all frames; depth.txt, rgb.txt and "
      "groundtruth.txt (poses, camera to world) make OUT_DIR a TUM RGB-D sequence at 30 frames a second.\n"
      "Nothing is ever overwritten; OUT_DIR is there, or filled, when all is done; a run that fails or is interrupted leaves "
      "nothing behind.";
  command.run = [request] { run_synth(*request); };
  return command;
}

}  // namespace fransac::cli
