// SPDX-License-Identifier: Apache-2.0
/// Command line flags and JSON made from `for_each_option`, `for_each_obstacle_option` and `for_each_track_option`, so that
/// names, ranges, help texts and defaults stand once.
#pragma once

#include <CLI/CLI.hpp>
#include <charconv>
#include <filesystem>
#include <iterator>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "definition.hpp"
#include "errors.hpp"
#include "fransac/eval/hoover.hpp"
#include "fransac/io/limits.hpp"
#include "fransac/obstacles/obstacles.hpp"
#include "fransac/planes/options.hpp"
#include "fransac/track/tracker.hpp"
#include "run_files.hpp"

namespace fransac::cli {

/// An enum whose values have names.
template <class T>
concept Named = requires {
  EnumNames<T>::values;
};

template <Named Enum>
std::vector<std::string> enum_words() {
  return {std::begin(EnumNames<Enum>::values), std::end(EnumNames<Enum>::values)};
}

/// "a, b, c"
template <Named Enum>
std::string enum_list() {
  return joined(enum_words<Enum>(), ", ");
}

template <Named Enum>
std::optional<Enum> enum_from_name(std::string_view name) {
  int value = 0;
  for (const std::string_view known : EnumNames<Enum>::values) {
    if (known == name) return static_cast<Enum>(value);
    ++value;
  }
  return std::nullopt;
}

/// The whole text as a number; nothing when it is none or does not fit.
template <class Number>
std::optional<Number> parse_number(std::string_view text) {
  Number number{};
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (error != std::errc{} || end != text.data() + text.size()) return std::nullopt;
  return number;
}

/// Adds "--name N", a whole number within [min, max], to a command.
void add_count(CLI::App& app, const std::string& name, int& value, int min, int max, const std::string& help);
/// How inputs are read, and the files of a run.
struct InputOptions {
  std::optional<std::filesystem::path> camera;  ///< For all frames, instead of their own: a file, or a name of the TUM benchmark.
  std::optional<double> depth_scale;            ///< Raw units per metre, instead of the cameras'.
  int max_size = static_cast<int>(io::ReadLimits{}.max_size);
  RunFiles files;

  [[nodiscard]] io::ReadLimits limits() const { return {static_cast<std::size_t>(max_size)}; }
};
/// Adds "--camera FILE|NAME", "--depth-scale X" and "--max-size N".
void add_input_options(CLI::App& app, InputOptions& inputs);
/// Adds "--seed N".
void add_seed(CLI::App& app, std::uint64_t& value, const std::string& help);

/// Adds an option that names something to write: not empty.
void add_output(CLI::App& app, const std::string& name, std::string& value, const std::string& help,
                const std::string& type_name);
/// Adds an option for results as a document: a file, or '-' for standard output.
void add_document(CLI::App& app, const std::string& name, std::string& value);

/// Adds a flag for each option of `options`; a sensor.json that is read is noted in `files`. With `several_methods`, "--method"
/// takes a comma-separated list into it instead and `options.method` is left alone.
void add_segment_options(CLI::App& app, SegmentOptions& options, RunFiles& files, std::vector<Method>* several_methods = nullptr);

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
/// Adds "--hoover TOLERANCE"; where the value is left out, main() puts the default in. `request` must outlive the parsing.
void add_hoover(CLI::App& app, HooverRequest& request);

/// "auto", "floor", "table" or a plane's label.
std::string support_text(const SupportChoice& support);
/// The help's group of options that mean nothing without "--obstacles".
inline constexpr const char* kObstacleGroup = "Obstacles";
/// Adds "--obstacles", "--support" and a flag for each other option; without the first, an option of the group is refused. Both
/// `app` and `request` must outlive the parsing.
void add_obstacle_options(CLI::App& app, ObstacleRequest& request, const std::string& help);

/// Adds a flag for each option of the tracker.
void add_track_options(CLI::App& app, TrackOptions& options);

/// Which methods run, how often and with which options: what the commands that compare methods have in common.
struct Runs {
  explicit Runs(int times, std::vector<Method> compared = {Method::automatic}) : methods(std::move(compared)), repeat(times) {}

  std::vector<Method> methods;
  int repeat;
  InputOptions inputs;
  SegmentOptions options;  ///< Of all methods; its own method means nothing.
  ObstacleRequest obstacles;
  HooverRequest hoover;

  [[nodiscard]] SegmentOptions options_of(Method method) const;
};

/// Adds "--repeat", the input options, "--method" and the segment options.
void add_runs(CLI::App& app, Runs& runs, int max_repeat, const std::string& repeat_help);

/// Checks what single flags cannot, for example that limits are in order. Throws UsageError.
void check_options(const SegmentOptions& options);
void check_options(const ObstacleOptions& options);
void check_options(const TrackOptions& options);

/// All option values by name; null where the method decides.
nlohmann::ordered_json options_to_json(const SegmentOptions& options);
nlohmann::ordered_json options_to_json(const ObstacleOptions& options);

}  // namespace fransac::cli
