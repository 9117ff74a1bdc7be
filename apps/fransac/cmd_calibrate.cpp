// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "commands.hpp"
#include "errors.hpp"
#include "fransac/calibrate/calibrate.hpp"
#include "fransac/io/sensor_json.hpp"
#include "inputs.hpp"
#include "options.hpp"
#include "output.hpp"
#include "progress.hpp"

namespace fransac::cli {
namespace {

struct CalibrateCommand {
  std::vector<std::string> names;
  InputOptions inputs;
  int max_frames = 100;
  std::string out;
  CalibrateOptions options;
};

/// A frame's name and content.
using NamedFrame = std::pair<std::string, io::Frame>;

/// At most `max_frames` of all inputs' frames, evenly spaced.
std::vector<NamedFrame> load_frames(CalibrateCommand& command) {
  std::vector<std::pair<std::string, io::FrameFiles>> files;
  for (const std::string& name : command.names) {
    const Input input = open_input(name, command.inputs);
    if (input.is_cloud()) throw UsageError(fmt::format("{}: is a point cloud; a sensor is calibrated from depth images", name));
    for (std::size_t i = 0; i < input.size(); ++i) files.emplace_back(input.name_of(i), input.frames[i]);
  }
  command.inputs.files.writes_document("--out", command.out);
  const std::size_t count = std::min(files.size(), static_cast<std::size_t>(command.max_frames));
  std::vector<NamedFrame> frames;
  Progress progress(count);
  Doubts doubts;
  for (std::size_t i = 0; i < count; ++i) {
    const auto& [name, frame] = files[i * files.size() / count];
    progress.step(name);
    frames.emplace_back(name, unwrap(io::load_frame(frame)));
    doubts.look_at(frame, frames.back().second, progress);
    const Camera& camera = frames.back().second.camera;
    const Camera& first = frames.front().second.camera;
    if (camera.width == first.width && camera.height == first.height) continue;
    throw Failure(fmt::format("{}: has {} x {} pixels, {} has {} x {}; a sensor is calibrated from images of one size", name,
                              camera.width, camera.height, frames.front().first, first.width, first.height));
  }
  return frames;
}

std::string file_text(const SensorCalibration& found) {
  using Evidence = std::pair<std::string_view, double>;
  const std::vector<Evidence> evidence{{"frames", static_cast<double>(found.frames)}, {"views", static_cast<double>(found.views)},
                                       {"planes", static_cast<double>(found.planes)}, {"min_depth_m", found.noise.front().z_m},
                                       {"max_depth_m", found.noise.back().z_m},       {"bend_rms_before_m", found.before.rms_m},
                                       {"bend_rms_after_m", found.after.rms_m},       {"bend_95_before_m", found.before.most_m},
                                       {"bend_95_after_m", found.after.most_m}};
  return io::sensor_to_json(found.sensor, evidence);
}

std::string table_text(const SensorCalibration& found) {
  const SensorOptions& sensor = found.sensor;
  const DepthNoise law{*sensor.constant_m, *sensor.linear, *sensor.quadratic_per_m};
  Table table({"depth [m]", "pixel noise [mm]", "law [mm]", "windows"});
  for (const NoiseAtDepth& bin : found.noise) {
    table.add({fmt::format("{:.2f}", bin.z_m), fmt::format("{:.2f}", 1e3 * bin.sigma_m),
               fmt::format("{:.2f}", 1e3 * law.sigma_m(bin.z_m)), fmt::format("{}", bin.windows)});
  }
  const auto counted = [](std::size_t n, const char* what) { return fmt::format("{} {}{}", n, what, n == 1 ? "" : "s"); };
  std::string text = fmt::format("{} in {}, {}\n\n{}\n", counted(found.planes, "plane"), counted(found.frames, "frame"),
                                 counted(found.views, "view"), table.text());
  text += fmt::format("sensor: {}; law: constant {:.3g} m, linear {:.3g}, quadratic {:.3g} per m; slow noise {:.2f} of it\n",
                      enum_name(sensor.kind), law.constant_m, law.linear, law.quadratic_per_m, *sensor.slow);
  text += fmt::format("planes are bent by {:.2f} mm r.m.s., 95 % by less than {:.2f} mm\n", 1e3 * found.before.rms_m,
                      1e3 * found.before.most_m);
  if (sensor.distortion.empty()) return text + "no distortion was found that holds for views that did not take part\n";
  return text + fmt::format("corrected, on views that did not take part: {:.2f} mm r.m.s., 95 % by less than {:.2f} mm\n",
                            1e3 * found.after.rms_m, 1e3 * found.after.most_m);
}

void run_calibrate(CalibrateCommand& command) {
  const std::vector<NamedFrame> loaded = load_frames(command);
  std::vector<CalibrationFrame> frames;
  frames.reserve(loaded.size());
  for (const auto& [name, frame] : loaded) frames.push_back({frame.view(), frame.camera});
  const SensorCalibration found = unwrap(calibrate(frames, command.options));
  write_results({{command.out, [&] { return file_text(found); }}}, [&] { return table_text(found); });
}

}  // namespace

Command calibrate_command() {
  auto request = std::make_shared<CalibrateCommand>();
  Command command{.name = "calibrate", .help = "a sensor's noise, and the distortion that bends planes, from frames"};
  add_inputs(command, "FRAMES", request->names, "depth images, folders of frames, TUM RGB-D sequences; of one camera");
  add_output(command, "--out", request->out, "FILE|-", "the sensor.json to write; '-' is standard output, instead of the table")
      .alias = "--json";
  add_choice(command, "--sensor", request->options.kind, "how it measures; auto: what the law of its noise looks like");
  add_input_options(command, request->inputs);
  Option& distortion =
      add_flag(command, "--distortion", request->options.distortion, "look for the distortion that bends planes");
  distortion.negatable = true;
  distortion.notes = "default: on";
  add_count(command, "--max-frames", request->max_frames, 1, 10000, "frames to use, evenly spaced");
  add_count(command, "--saturated", request->options.saturated, 0, 65535,
            "raw value that means no measurement beside 0; 0: none");
  add_count(command, "--threads", request->options.threads, 0, 1024, "threads to use, 0 for all cores; never changes the answer");
  command.examples = {{"--out", "rooms --out sensor.json"}, {"--sensor", "rooms --sensor stereo"}};
  command.footer =
      "Frames should show large planes all over the image: a wall or a floor at a few distances, or any rooms.\n"
      "sensor.json is for segment, track, evaluate, report and bench --sensor sensor.json, which correct depth by it first.\n"
      "The distortion is only believed if what some views show corrects others: three different ones at least, better ten.";
  command.run = [request] { run_calibrate(*request); };
  return command;
}

}  // namespace fransac::cli
