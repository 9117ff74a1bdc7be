// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "commands.hpp"
#include "errors.hpp"
#include "fransac/io/dataset.hpp"
#include "fransac/synth/synth.hpp"
#include "options.hpp"
#include "output.hpp"
#include "progress.hpp"

namespace fransac {

template <>
struct EnumNames<synth::Sensor> {
  static constexpr std::string_view values[] = {"none", "kinect1", "stereo", "tof"};
};

namespace cli {
namespace {

namespace fs = std::filesystem;

struct SynthCommand {
  fs::path folder;
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

std::string scene_list() {
  std::string list;
  for (const std::string_view name : synth::scene_names()) list += std::string(name) + ", ";
  return list + "all";
}

/// The same field of view on another number of pixels; (0, 0) is the centre of a pixel, hence the halves.
Camera scaled(Camera camera, int width, int height) {
  const double sx = static_cast<double>(width) / camera.width;
  const double sy = static_cast<double>(height) / camera.height;
  camera.fx *= sx;
  camera.fy *= sy;
  camera.cx = (camera.cx + 0.5) * sx - 0.5;
  camera.cy = (camera.cy + 0.5) * sy - 0.5;
  camera.width = width;
  camera.height = height;
  return camera;
}

void write_synth_frame(const fs::path& folder, synth::SynthFrame frame) {
  const int width = frame.camera.width;
  const int height = frame.camera.height;
  check(io::write_frame(folder, {.camera = frame.camera,
                                 .depth = {width, height, 1, std::move(frame.depth)},
                                 .labels = io::LabelImage{width, height, 1, std::move(frame.labels)},
                                 .colour = io::ColourImage{width, height, 3, std::move(frame.colour)},
                                 .true_planes = std::move(frame.true_planes)}));
}

void run_synth(const SynthCommand& command) {
  check_output_folder("OUT_DIR", command.folder);
  if (fs::exists(command.folder) && !fs::is_empty(command.folder)) {
    throw Failure(fmt::format("OUT_DIR: '{}' is not empty; choose a new folder", command.folder.string()));
  }
  std::vector<std::string> scenes{command.options.scene};
  if (command.options.scene == "all") scenes.assign(synth::scene_names().begin(), synth::scene_names().end());

  Unfinished output;
  output.make_folder(command.folder);
  Progress progress(scenes.size() * static_cast<std::size_t>(command.frames));
  synth::SynthOptions options = command.options;
  options.camera = scaled(options.camera, command.width, command.height);
  for (const std::string& scene : scenes) {
    for (options.frame = 0; options.frame < command.frames; ++options.frame) {
      options.scene = scene;
      // Numbers of equal length, so that frames sort by name in their order.
      const auto digits = std::to_string(command.frames - 1).size();
      const std::string name = fmt::format("{}_{}_{:0{}}", scene, options.seed, options.frame, digits);
      progress.step(name);
      write_synth_frame(output.add(command.folder / name), unwrap(synth::render(options)));
    }
  }
  output.add(command.folder / "dataset.json");
  check(io::write_dataset_json(command.folder, io::Truth::planes, principle(options.sensor)));
  output.finish();
}

void check_scene(const std::string& scene) {
  const auto known = synth::scene_names();
  if (scene == "all" || std::find(known.begin(), known.end(), scene) != known.end()) return;
  throw CLI::ValidationError("--scene", fmt::format("expected one of {}, not '{}'", scene_list(), scene));
}

}  // namespace

Command add_synth(CLI::App& parent) {
  CLI::App* app = parent.add_subcommand("synth", "render depth frames with exact truth");
  auto command = std::make_shared<SynthCommand>();
  synth::SynthOptions& options = command->options;
  app->add_option("OUT_DIR", command->folder, "folder to make; may exist if it is empty")->required();
  app->add_option_function<std::string>(
         "--scene",
         [&options](const std::string& scene) {
           check_scene(scene);
           options.scene = scene;
         },
         fmt::format("what is seen [one of {}; default: {}]", scene_list(), options.scene))
      ->type_name("NAME");
  app->add_option_function<std::string>(
         "--noise",
         [&options](const std::string& name) {
           const auto sensor = enum_from_name<synth::Sensor>(name);
           if (!sensor) {
             throw CLI::ValidationError("--noise", fmt::format("expected one of {}, not '{}'", enum_list<synth::Sensor>(), name));
           }
           options.sensor = *sensor;
         },
         fmt::format("how depth is measured [one of {}; default: {}]", enum_list<synth::Sensor>(), enum_name(options.sensor)))
      ->type_name("NAME");
  add_count(*app, "--frames", command->frames, 1, 100000, "frames per scene");
  add_seed(*app, options.seed, "seed of the scene's objects and the noise");
  add_count(*app, "--width", command->width, 16, kMaxImageSide, "columns; the field of view stays");
  add_count(*app, "--height", command->height, 16, kMaxImageSide, "rows; the field of view stays");
  app->footer(
      "Writes OUT_DIR/<scene>_<seed>_<frame>/ with depth.png, camera.json, labels.png, rgb.png and truth.json, and "
      "OUT_DIR/dataset.json.\n"
      "Nothing is ever overwritten; a run that fails leaves nothing behind; one ended by a signal leaves the "
      "frames done by then.");
  return {app, [command] { run_synth(*command); }};
}

}  // namespace cli
}  // namespace fransac
