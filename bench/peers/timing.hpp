// SPDX-License-Identifier: Apache-2.0
/// Who is timed on what, and how.
#pragma once

#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "fransac/eval/metrics.hpp"
#include "peer.hpp"
#include "roster.hpp"
#include "scenes.hpp"

namespace fransac::bench {

struct Contestant {
  const Entry* entry = nullptr;
  Peer* peer = nullptr;  ///< Null when its library was not found.
  int threads = 1;
};

/// One contestant on one scene.
struct Row {
  std::string suite;
  const Entry* entry = nullptr;
  int threads = 1;
  std::string dataset;
  std::string scene;
  int width = 0;
  int height = 0;
  std::size_t points = 0;  ///< Measured pixels, or points of a cloud.
  std::vector<double> times_ms;
  std::vector<std::pair<std::string, double>> stages_ms;  ///< Medians.
  int planes = 0;
  std::size_t inliers = 0;
  std::size_t leaves = 0;
  std::optional<eval::Detection> dominant;         ///< The largest plane found against the truth's label 1.
  std::optional<double> best_f1;                   ///< The found plane that overlaps it most.
  std::optional<double> matched_f1;                ///< The first plane found against the true plane that it fits best.
  std::optional<eval::InstanceMetrics> instances;  ///< Of those that return every plane, where the truth holds every plane.
  std::optional<eval::ObjectMetrics> objects;      ///< Of those that return objects, where they are known.
  std::string note;                                ///< Why there are no times, or fewer.
};

struct TimingOptions {
  int repeat = 20;
  double max_seconds_per_row = 3.0;  ///< No further repetition beyond it.
  bool cpu_time = false;             ///< The thread's processor time instead of the clock on the wall.
  double max_seconds_per_run = 5.0;  ///< Who takes longer is not timed.
  bool scenes_stand_alone = false;   ///< Scenes are sizes: who fails on one may be timed on the others.
  std::filesystem::path overlays;    ///< Folder for pictures of everybody's labels; empty: none.
};

/// A peer whose mean F1 over the frames whose dominant plane is known is lower is not timed there: it is used wrongly, or broken.
inline constexpr double kSaneF1 = 0.8;

/// First everybody answers every scene once, and is checked; then, scene by scene, they take turns `repeat` times, so that a
/// machine that slows down or speeds up does so for all of them. A turn is one run that is not timed, unless it takes long enough
/// to fill the caches on its own account, and one that is.
std::vector<Row> time_suite(const std::string& suite, std::span<const Scene> scenes, std::span<const Contestant> contestants,
                            const TimingOptions& options);

}  // namespace fransac::bench
