// SPDX-License-Identifier: Apache-2.0
/// Camera intrinsics as JSON.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

#include "fransac/core/camera.hpp"
#include "fransac/core/result.hpp"

namespace fransac::io {

/// Reads {"width","height","fx","fy","cx","cy","depth_scale"}; all but depth_scale (default 1000) are required; unknown
/// keys are ignored. Errors name the file and the missing or wrong field.
Result<Camera> read_camera_json(const std::filesystem::path& file);
/// The same from memory; `name` stands for the file in messages.
Result<Camera> parse_camera_json(std::string_view text, const std::string& name);
/// The text of a camera.json.
std::string camera_to_json(const Camera& camera);

/// The intrinsics that the TUM RGB-D benchmark publishes for its recordings: "freiburg1", "freiburg2", "freiburg3"
/// (short: "fr1", …), depth scale 5000. Nothing for another name.
/// Source: Sturm et al., "A Benchmark for the Evaluation of RGB-D SLAM Systems", IROS 2012, and the benchmark's file-format page.
std::optional<Camera> tum_camera(std::string_view name);

}  // namespace fransac::io
