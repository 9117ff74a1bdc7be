// SPDX-License-Identifier: Apache-2.0
/// Camera intrinsics as files.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

#include "fransac/core/camera.hpp"
#include "fransac/core/lens.hpp"
#include "fransac/core/result.hpp"

namespace fransac::io {

/// What a camera's file says.
struct CameraFile {
  Camera camera;             ///< Its depth_scale is 1000 where the file has none.
  std::optional<Lens> lens;  ///< Nothing for a pinhole; coefficients that are all zero are none.

  bool operator==(const CameraFile&) const = default;
};

/// Reads the intrinsics that a file holds as JSON or YAML. Which kind it is, is found from its fields:
/// - camera.json: width, height, fx, fy, cx, cy;
/// - ROS: a calibration (image_width, image_height, camera_matrix, distortion_model, distortion_coefficients) or the message
///   sensor_msgs/CameraInfo (width, height, K or k, D or d, distortion_model), the first of several;
/// - Open3D: width, height, intrinsic_matrix, also within "intrinsic" or a trajectory's "parameters";
/// - RealSense: width, height, fx, fy, ppx, ppy, model, coeffs;
/// - ORB-SLAM: Camera.fx or Camera1.fx and so on, DepthMapFactor; OpenCV's header "%YAML:1.0".
///
/// depth_scale is optional in all but the last; unknown fields are ignored. Errors name the file and the missing or wrong field,
/// or say what was looked for; a distortion model that is none of LensModel's and not all zero is one, so are binning and regions
/// of interest.
Result<CameraFile> read_camera_file(const std::filesystem::path& file);
/// The same from memory; `name` stands for the file in messages.
Result<CameraFile> parse_camera_file(std::string_view text, const std::string& name);
/// The camera of a file without lens distortion; with one an error that names `name` and the model.
Result<Camera> pinhole_of(const CameraFile& file, const std::string& name);
/// The text of a camera.json.
std::string camera_to_json(const Camera& camera);

/// The intrinsics that the TUM RGB-D benchmark publishes for its recordings: "freiburg1", "freiburg2", "freiburg3"
/// (short: "fr1", …), depth scale 5000. Nothing for another name.
/// Source: Sturm et al., "A Benchmark for the Evaluation of RGB-D SLAM Systems", IROS 2012, and the benchmark's file-format page.
std::optional<Camera> tum_camera(std::string_view name);

/// Nominal intrinsics by name: "kinect1" (640x480, millimetres), and tum_camera's. A calibration of the device itself is better.
/// Nothing for another name.
std::optional<Camera> camera_preset(std::string_view name);

}  // namespace fransac::io
