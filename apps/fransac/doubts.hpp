// SPDX-License-Identifier: Apache-2.0
/// What is unlikely about a camera and about the unit of depth.
#pragma once

#include <set>
#include <string>
#include <vector>

#include "fransac/io/dataset.hpp"
#include "progress.hpp"

namespace fransac::cli {

/// Says once, on stderr, what a user should look at: a field of view outside 10 to 150 degrees, a principal point outside the
/// image, a median depth beyond 50 m or below 5 cm.
class Doubts {
 public:
  void look_at(const io::FrameFiles& files, const io::Frame& frame, Progress& progress);
  /// The same of frames that are in no file; `name` stands for them.
  void look_at(const std::string& name, const Camera& camera, const DepthView& depth, Progress& progress);

 private:
  void look_at_camera(const std::string& name, const Camera& camera, Progress& progress);
  void look_at_depth(const std::string& name, const std::string& source, const Camera& camera, const DepthView& depth,
                     Progress& progress);

  std::set<std::string> cameras_;  ///< That were looked at.
  bool unit_said_ = false;
};

}  // namespace fransac::cli
