// SPDX-License-Identifier: Apache-2.0
/// What is segmented.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "fransac/core/camera.hpp"
#include "fransac/io/dataset.hpp"
#include "peer.hpp"

namespace fransac::bench {

/// A depth frame or a cloud in memory, with its truth.
struct Scene {
  std::string dataset;
  std::string name;
  Camera camera;  ///< Of a cloud: width is the number of points, height 1.
  std::vector<std::uint16_t> depth;
  std::vector<float> points;
  std::vector<std::uint8_t> truth;     ///< One label per pixel or point; empty where nothing is known.
  std::vector<std::uint16_t> objects;  ///< One id per pixel, 0 is none; empty where nothing is known.
  bool dominant = false;               ///< Whether label 1 of the truth is the plane with the most pixels.
  bool all_planes = false;             ///< Whether the truth holds every plane.
  double plane[4] = {0.0, 0.0, -1.0, 1.0};

  [[nodiscard]] Frame frame() const;
};

/// Frames of a folder, at most `max_frames` of them (0: all). Throws cli::Failure, as the others.
std::vector<Scene> load_dataset(const std::filesystem::path& folder, std::size_t max_frames);
/// Rendered scenes as a Kinect sees them: every kind of room, two of each.
std::vector<Scene> synth_dataset(std::size_t max_frames);
/// One scene seen by cameras of the same field of view: 80x60 to 640x480, then 1280x960 and 1920x1080.
std::vector<Scene> synth_resolutions();
/// A room at one resolution.
Scene synth_desk(int width, int height);
/// A floor of 4 m x 4 m with 60 % of the points, a wall 2.5 m high with 20 %, the rest on 60 balls; 3 mm of noise. All points are
/// on surfaces, as a sensor's are: among ten million, points anywhere in the room would fill every leaf of a voxel grid.
Scene synth_cloud(std::size_t points);

}  // namespace fransac::bench
