// SPDX-License-Identifier: Apache-2.0
/// What is known of a sensor as JSON.
#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <utility>

#include "fransac/core/result.hpp"
#include "fransac/core/sensor.hpp"

namespace fransac::io {

/// Reads {"type": "fransac-sensor", "version": 1, "kind", "noise", "slow", "bias_m", "distortion"}, as docs/calibration.md
/// describes them. The first three are required; what else is missing, or null, follows from the kind; unknown keys are ignored.
/// Errors (format) name the file and the missing or wrong field.
Result<SensorOptions> read_sensor_json(const std::filesystem::path& file);
/// The same from memory; `name` stands for the file in messages.
Result<SensorOptions> parse_sensor_json(std::string_view text, const std::string& name);
/// The text of a sensor.json; what is not set is null. `evidence`: numbers by name, finite, that say what it comes from.
std::string sensor_to_json(const SensorOptions& sensor, std::span<const std::pair<std::string_view, double>> evidence = {});

}  // namespace fransac::io
