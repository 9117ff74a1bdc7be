// SPDX-License-Identifier: Apache-2.0
/// What commands are asked for, and the options that several of them share: made from `for_each_option`,
/// `for_each_obstacle_option` and `for_each_track_option`, so that names, ranges, help texts and defaults stand once.
#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "command.hpp"
#include "fransac/eval/hoover.hpp"
#include "fransac/io/limits.hpp"
#include "fransac/obstacles/obstacles.hpp"
#include "fransac/planes/options.hpp"
#include "fransac/track/tracker.hpp"
#include "run_files.hpp"

namespace fransac::cli {

/// How inputs are read, and the files of a run.
struct InputOptions {
  std::optional<std::filesystem::path> camera;  ///< For all frames, instead of their own: a file, or a name of the TUM benchmark.
  std::optional<double> depth_scale;            ///< Raw units per metre, instead of the cameras'.
  int max_size = static_cast<int>(io::ReadLimits{}.max_size);
  RunFiles files;

  [[nodiscard]] io::ReadLimits limits() const { return {static_cast<std::size_t>(max_size)}; }
};
/// Adds "--camera FILE|NAME", "--depth-scale X" and "--max-size N".
void add_input_options(Command& command, InputOptions& inputs);
/// Adds "--name N", a whole number within [min, max].
void add_count(Command& command, const std::string& name, int& value, int min, int max, const std::string& help);
/// Adds "--seed N".
void add_seed(Command& command, std::uint64_t& value, const std::string& help);

/// Adds a flag for each option of `options`; a sensor.json that is read is noted in `files`. With `several_methods`, "--method"
/// takes a comma-separated list into it instead and `options.method` is left alone.
void add_segment_options(Command& command, SegmentOptions& options, RunFiles& files,
                         std::vector<Method>* several_methods = nullptr);

/// Whether obstacles are asked for, and how they are found.
struct ObstacleRequest {
  bool asked = false;
  ObstacleOptions options;
};

/// Whether regions are classified in the manner of Hoover et al. (1996), and at which tolerance.
struct HooverRequest {
  bool asked = false;
  double tolerance = eval::kHooverTolerance;
  bool curve = false;  ///< At many tolerances, too; then of frames that have images of true regions, asked or not.
};
/// Adds "--hoover [TOLERANCE]".
void add_hoover(Command& command, HooverRequest& request);

/// "auto", "floor", "table" or a plane's label.
std::string support_text(const SupportChoice& support);
/// The help's group of options that mean nothing without "--obstacles".
inline constexpr const char* kObstacleGroup = "Obstacles";
/// Adds "--obstacles", "--support" and a flag for each other option; without the first, an option of the group is refused.
void add_obstacle_options(Command& command, ObstacleRequest& request, const std::string& help);
/// Makes what joined the group since need "--obstacles", too.
void need_obstacles(Command& command);

/// Adds a flag for each option of the tracker.
void add_track_options(Command& command, TrackOptions& options);

/// Which methods run, how often and with which options: what the commands that compare methods have in common.
struct Runs {
  explicit Runs(int times, std::vector<Method> compared = {Method::automatic}) : methods(std::move(compared)), repeat(times) {}

  std::vector<Method> methods;
  int repeat;
  InputOptions inputs;
  SegmentOptions options;  ///< Of all methods that know them; its own method means nothing.
  ObstacleRequest obstacles;
  HooverRequest hoover;

  [[nodiscard]] SegmentOptions options_of(Method method) const;
};

/// Adds "--repeat", the input options, "--method" and the segment options.
void add_runs(Command& command, Runs& runs, int max_repeat, const std::string& repeat_help);

/// Checks what single flags cannot, for example that limits are in order. Throws UsageError.
void check_options(const SegmentOptions& options);
/// Options that mean nothing to some of the methods are theirs by default; to none of them: an error.
void check_options(const Runs& runs);
void check_options(const ObstacleOptions& options);
void check_options(const TrackOptions& options);

/// All option values by name; null where the method decides.
nlohmann::ordered_json options_to_json(const SegmentOptions& options);
nlohmann::ordered_json options_to_json(const ObstacleOptions& options);

}  // namespace fransac::cli
