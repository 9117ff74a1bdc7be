// SPDX-License-Identifier: Apache-2.0
// Calibration from a few small frames of any numbers, with any options: a valid sensor that survives a round trip as
// sensor.json, the same on any number of threads, or an error.
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "draw.hpp"
#include "fransac/calibrate/calibrate.hpp"
#include "fransac/io/sensor_json.hpp"
#include "require.hpp"

namespace {

using namespace fransac;
using namespace fransac::fuzz;

CalibrateOptions draw_calibrate_options(Bytes& bytes) {
  CalibrateOptions options;
  DrawOption{bytes}({}, options.kind);
  options.distortion = bytes.ConsumeBool();
  if (bytes.ConsumeBool()) options.max_bend_m = draw_seldom(bytes) ? draw_any(bytes) : draw_number(bytes, 0.0, 1.0);
  if (bytes.ConsumeBool()) options.min_share = draw_seldom(bytes) ? draw_any(bytes) : draw_number(bytes, 0.0, 1.0);
  options.saturated = draw_seldom(bytes) ? bytes.ConsumeIntegral<int>() : bytes.ConsumeIntegralInRange(0, 65535);
  return options;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  Bytes bytes(data, size);
  CalibrateOptions options = draw_calibrate_options(bytes);
  std::vector<DrawnDepth> images;
  for (int n = bytes.ConsumeIntegralInRange(0, 4); n > 0; --n) {
    images.push_back(draw_depth(bytes, images.empty() ? std::nullopt : std::optional(images.front().camera)));
  }
  std::vector<CalibrationFrame> frames;
  for (const DrawnDepth& image : images) frames.push_back({image.view, image.camera});
  const Result<SensorCalibration> found = calibrate(frames, options);
  if (!found) return require_message(found.error()), 0;
  require(validate(options).ok() && validate(found->sensor).ok());
  require(found->views <= found->frames && found->frames <= frames.size());
  for (const NoiseAtDepth& noise : found->noise) require(noise.z_m > 0.0 && std::isfinite(noise.sigma_m) && noise.sigma_m >= 0.0);
  for (const Bend& bend : {found->before, found->after}) require(bend.rms_m >= 0.0 && std::isfinite(bend.most_m));
  const std::string text = io::sensor_to_json(found->sensor);
  const auto read = io::parse_sensor_json(text, "sensor.json");
  require(read && io::sensor_to_json(*read) == text);
  options.threads = 2;
  const Result<SensorCalibration> again = calibrate(frames, options);
  require(again && io::sensor_to_json(again->sensor) == text && again->planes == found->planes);
  return 0;
}
