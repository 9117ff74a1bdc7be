// SPDX-License-Identifier: Apache-2.0
/// What a page shows of a sequence, gathered while its frames pass by.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "../sequence.hpp"
#include "html.hpp"
#include "plots.hpp"

namespace fransac::cli::report {

/// However long a sequence is, its page has no more pictures, columns of time, rows and points than these.
inline constexpr std::size_t kMostThumbnails = 24;
inline constexpr std::size_t kMostColumns = 200;
inline constexpr std::size_t kMostRows = 40;
inline constexpr std::size_t kMostPathPoints = 400;
inline constexpr std::size_t kMostErrors = 10;

/// `wanted` of `count` places, or all: evenly spaced, the first and the last among them.
std::vector<std::size_t> evenly_chosen(std::size_t count, std::size_t wanted);

/// A plane or an object by its id.
struct Seen {
  std::size_t frames = 0;
  std::size_t first = 0;  ///< Frames' numbers.
  std::size_t last = 0;
  double weight = 0.0;                                         ///< Over the frames: a plane's m², an object's pixels.
  Eigen::Vector3d box = Eigen::Vector3d::Zero();               ///< Of an object, over the frames: length, width, height.
  std::map<std::string_view, std::size_t> kinds;               ///< In how many frames it was what.
  std::vector<std::pair<std::uint32_t, std::uint32_t>> spans;  ///< Columns of time with the number of its frames in each.

  [[nodiscard]] std::string_view kind() const;  ///< The most frequent.
};

/// Where the camera went.
struct CameraPath {
  std::vector<Dot> points;   ///< From above, metres: to the right and ahead of the first frame's camera.
  std::vector<Arrow> views;  ///< Where it looked.
  bool up_is_known = false;  ///< Else the first frame's camera is taken to be level.
  std::size_t guessed = 0;   ///< Frames in which no plane told where it was.
};

struct SequenceReport {
  std::string name;
  std::size_t frames = 0;
  std::optional<double> duration_s;
  bool with_objects = false;
  FollowTotals totals;
  std::vector<double> work_ms;      ///< Of each frame that was followed.
  std::vector<std::string> errors;  ///< Of the first skipped frames.
  std::map<int, Seen> planes;       ///< By id.
  std::map<int, Seen> objects;
  std::vector<Picture> plane_pictures;
  std::vector<Picture> object_pictures;
  CameraPath path;
  std::vector<std::size_t> usable;  ///< Numbers of the frames that were followed.

  [[nodiscard]] std::size_t columns() const { return frames < kMostColumns ? frames : kMostColumns; }
  [[nodiscard]] std::size_t column_of(std::size_t frame) const { return frame * columns() / frames; }
  /// How many frames a column stands for.
  [[nodiscard]] std::size_t frames_in(std::size_t column) const;
};

/// Follows a sequence and draws some of its frames, `width` pixels wide at most. Throws Failure.
SequenceReport watch_sequence(const std::string& name, const std::vector<io::FrameFiles>& frames, const FollowRequest& request,
                              int width);

}  // namespace fransac::cli::report
