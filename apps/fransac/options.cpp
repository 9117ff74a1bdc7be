// SPDX-License-Identifier: Apache-2.0
#include "options.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <type_traits>

#include "errors.hpp"
#include "fransac/core/point_cloud.hpp"
#include "fransac/io/sensor_json.hpp"
#include "numbers.hpp"

namespace fransac::cli {
namespace {

/// The help's group of an option, by the methods that use it.
const char* group_of(UsedBy users) {
  switch (users) {
    case UsedBy::cells: return "Of the method cells";
    case UsedBy::ransac: return "Of the methods fransac, voxel-ransac, rransac and ransac";
    case UsedBy::voxel_grid: return "Of the methods fransac and voxel-ransac";
    case UsedBy::all: break;
  }
  return "Of all methods";
}
constexpr const char* kTrackGroup = "Tracking";
constexpr const char* kObstacles = "--obstacles";
constexpr std::string_view kPlanes = "planes";  // the one option with a word, 'all', for a number: 0
constexpr std::string_view kMethod = "method";
constexpr std::string_view kSensor = "sensor";  // the one enum that a file can stand for
constexpr std::string_view kSensorParam = "sensor-param";

template <class T>
struct IsOptional : std::false_type {};
template <class T>
struct IsOptional<std::optional<T>> : std::true_type {};

/// "0 to 1024", "> 0", "> 0 and < 1" or nothing; a bound that the type has anyway is not worth a word.
std::string range_text(const OptionInfo& info) {
  const bool has_min = std::isfinite(info.min);
  const bool has_max = std::isfinite(info.max) && info.max < std::numeric_limits<int>::max();
  if (has_min && has_max && !info.open_min && !info.open_max) return fmt::format("{} to {}", info.min, info.max);
  std::string text;
  if (has_min) text += fmt::format("{} {}", info.open_min ? ">" : ">=", info.min);
  if (has_max) text += fmt::format("{}{} {}", has_min ? " and " : "", info.open_max ? "<" : "<=", info.max);
  return text;
}

bool in_range(const OptionInfo& info, double value) {
  return (info.open_min ? value > info.min : value >= info.min) && (info.open_max ? value < info.max : value <= info.max);
}

template <class T>
std::string value_text(const T& value) {
  if constexpr (std::is_same_v<T, std::optional<Eigen::Vector3d>>) {
    return value ? fmt::format("{},{},{}", value->x(), value->y(), value->z()) : "none";
  } else if constexpr (IsOptional<T>::value) {
    return value ? value_text(*value) : "the method decides";
  } else if constexpr (Named<T>) {
    return std::string(enum_name(value));
  } else if constexpr (std::is_same_v<T, bool>) {
    return value ? "on" : "off";
  } else {
    return fmt::format("{}", value);
  }
}

/// What a value must be, for help and errors: "a number > 0", "one of pixels, leaves".
template <class T>
std::string expected_text(const OptionInfo& info, const T& value) {
  if constexpr (IsOptional<T>::value) {
    return expected_text(info, typename T::value_type{});
  } else if constexpr (std::is_same_v<T, Eigen::Vector3d>) {
    return is_position(info) ? "a position x,y,z" : "a direction x,y,z, not all 0";
  } else if constexpr (Named<T>) {
    return "one of " + joined(enum_words<T>());
  } else {
    (void)value;
    const std::string range = range_text(info);
    const char* const kind = std::is_floating_point_v<T> ? "a number"
                             : std::is_signed_v<T>       ? "a whole number"
                                                         : "a whole number >= 0";
    return range.empty() ? kind : fmt::format("{} {}", kind, range);
  }
}

/// The parts between commas.
std::vector<std::string> split(const std::string& text) {
  std::vector<std::string> parts(1);
  for (const char c : text) c == ',' ? parts.emplace_back() : parts.back() += c;
  return parts;
}

/// Three numbers, separated by commas.
std::optional<Eigen::Vector3d> parse_vector(const std::string& text) {
  const std::vector<std::string> parts = split(text);
  if (parts.size() != 3) return std::nullopt;
  Eigen::Vector3d vector;
  for (int i = 0; i < 3; ++i) {
    const auto number = parse_number<double>(parts[static_cast<std::size_t>(i)]);
    if (!number) return std::nullopt;
    vector[i] = *number;
  }
  return vector;
}

/// Reads a value; false when it is none or outside its range.
template <class T>
bool read_value(const OptionInfo& info, const std::string& text, T& value) {
  if constexpr (IsOptional<T>::value) {
    typename T::value_type inner{};
    if (!read_value(info, text, inner)) return false;
    value = inner;
    return true;
  } else if constexpr (std::is_same_v<T, Eigen::Vector3d>) {
    const auto vector = parse_vector(text);
    if (!vector) return false;
    const bool valid =
        is_position(info) ? validate_position(*vector, info.name).ok() : vector->allFinite() && !vector->isZero(0.0);
    if (!valid) return false;
    value = *vector;
    return true;
  } else if constexpr (Named<T>) {
    const auto named = enum_from_name<T>(text);
    value = named.value_or(value);
    return named.has_value();
  } else {
    const auto number = parse_number<T>(text);
    if (!number || !in_range(info, static_cast<double>(*number))) return false;
    value = *number;
    return true;
  }
}

template <class T>
inline constexpr bool kIsFlag = std::is_same_v<T, bool> || std::is_same_v<T, std::optional<bool>>;

/// The names of a value that has some.
template <class T>
std::vector<std::string> value_words() {
  if constexpr (IsOptional<T>::value) {
    return value_words<typename T::value_type>();
  } else if constexpr (Named<T>) {
    return enum_words<T>();
  } else {
    return {};
  }
}

template <class T>
const char* type_name() {
  if constexpr (IsOptional<T>::value) {
    return type_name<typename T::value_type>();
  } else {
    return Named<T> ? "NAME" : std::is_same_v<T, Eigen::Vector3d> ? "X,Y,Z" : "N";
  }
}

/// "unit; range; default: …"
std::string notes(const OptionInfo& info, const std::string& expected, const std::string& default_text) {
  std::string text;
  for (const std::string& note : {std::string(info.unit), expected}) {
    if (!note.empty()) text += note + "; ";
  }
  return fmt::format("{}default: {}", text, default_text);
}

/// An option of a group without what takes its value.
Option described(const OptionInfo& info, const char* group, const std::string& expected, const std::string& default_text) {
  return {.name = fmt::format("--{}", info.name),
          .help = std::string(info.help),
          .notes = notes(info, expected, default_text),
          .group = group};
}

/// Takes a value of a type that read_value() knows.
template <class T>
std::function<void(const std::string&)> taker(T& value, const OptionInfo& info, const std::string& expected) {
  return [&value, info, expected](const std::string& text) {
    if (!read_value(info, text, value)) reject(expected, text);
  };
}

/// An option that is no option of the library.
template <class T>
void add_number(Command& command, const std::string& name, T& value, const OptionInfo& info) {
  const std::string expected = expected_text(info, value);
  command.add({.name = name,
               .value = type_name<T>(),
               .help = std::string(info.help),
               .notes = notes(info, expected, value_text(value)),
               .take = taker(value, info, expected)});
}

struct AddOption {
  Command& command;
  const char* group;

  template <class T>
  void operator()(const OptionInfo& info, T& value) const {
    const std::string expected = kIsFlag<T> ? "" : expected_text(info, value);
    Option option = described(info, group, expected, value_text(value));
    if constexpr (kIsFlag<T>) {
      option.negatable = true;
      option.take = [&value](const std::string& text) { value = text == "on"; };
    } else {
      option.value = type_name<T>();
      option.words = value_words<T>();
      option.take = taker(value, info, expected);
    }
    command.add(std::move(option));
  }
};

/// "--planes N|all": 0 means all in the options, but nobody asks for 0 planes.
void add_planes(Command& command, OptionInfo info, std::optional<int>& value) {
  info.min = 1;
  const std::string expected = expected_text(info, value) + ", or 'all'";
  const auto take = [&value, info, expected](const std::string& text) {
    if (text == "all") {
      value = 0;
    } else if (!read_value(info, text, value)) {
      reject(expected, text);
    }
  };
  info.unit = "";
  Option& option = command.add(described(info, group_of(info.used_by), expected, value_text(value)));
  option.value = "N|all";
  option.words = {"all"};
  option.take = take;
}

/// "--sensor NAME|FILE": a kind, or all that a sensor.json says.
void add_sensor(Command& command, const OptionInfo& info, SensorOptions& sensor, RunFiles& files) {
  const std::string expected = expected_text(info, sensor.kind) + ", or a sensor.json of fransac calibrate";
  Option& option = command.add(described(info, group_of(info.used_by), expected, value_text(sensor.kind)));
  option.value = "NAME|FILE";
  option.words = enum_words<SensorKind>();
  option.take = [&sensor, &files, expected](const std::string& text) {
    const std::filesystem::path file(text);
    if (const auto kind = enum_from_name<SensorKind>(text)) {
      sensor = {.kind = *kind};
    } else if (file.extension() == ".json" || std::filesystem::is_regular_file(file)) {
      files.reads(file);
      sensor = unwrap(io::read_sensor_json(file));
    } else {
      reject(expected, text);
    }
  };
}

/// Reads "NAME=VALUE" into the parameter of that name; `given` are those of the same command line so far.
void set_parameter(const std::string& text, SensorOptions& sensor, std::vector<std::string>& given) {
  const std::size_t equals = text.find('=');
  const std::string name = text.substr(0, equals);
  std::string known;
  bool found = false;
  for_each_parameter(sensor, [&](const SensorParameter& parameter, std::optional<double>& value) {
    known += (known.empty() ? "" : ", ") + std::string(parameter.name);
    if (name != parameter.name) return;
    found = true;
    const OptionInfo info{.name = parameter.name, .unit = {}, .help = {}, .min = parameter.min, .max = parameter.max};
    const std::string number = equals == std::string::npos ? "" : text.substr(equals + 1);
    if (!read_value(info, number, value)) reject(fmt::format("{}={}", name, expected_text(info, value)), text);
  });
  if (!found) reject("NAME=VALUE with a name out of " + known, text);
  if (std::find(given.begin(), given.end(), name) != given.end()) throw InvalidValue{fmt::format("'{}' is given twice", name)};
  given.push_back(name);
}

/// "--sensor-param NAME=VALUE", once for each.
void add_sensor_parameters(Command& command, SensorOptions& sensor) {
  Option option{.name = fmt::format("--{}", kSensorParam),
                .value = "NAME=VALUE",
                .notes = "default: by the kind of sensor",
                .group = group_of(UsedBy::cells),
                .repeated = true};
  std::string names;
  for_each_parameter(sensor, [&](const SensorParameter& parameter, const auto& /*value*/) {
    const std::string range = fmt::format("{}, {} to {}", parameter.unit, parameter.min, parameter.max);
    names += fmt::format("{}{}: {} ({})", names.empty() ? "" : "; ", parameter.name, parameter.help, range);
    option.words.push_back(fmt::format("{}=", parameter.name));
  });
  option.help = "a number of the sensor, once for each: " + names;
  option.take = [&sensor, given = std::vector<std::string>()](const std::string& text) mutable {
    set_parameter(text, sensor, given);
  };
  command.add(std::move(option));
}

/// "--method M,M,...": several at once.
void add_methods(Command& command, const OptionInfo& info, std::vector<Method>& methods) {
  const std::string known = joined(enum_words<Method>());
  std::vector<std::string> defaults;
  for (const Method method : methods) defaults.emplace_back(enum_name(method));
  const auto take = [&methods, known](const std::string& text) {
    methods.clear();
    for (const std::string& name : split(text)) {
      const auto method = enum_from_name<Method>(name);
      if (!method) reject("a comma-separated list of " + known, name);
      if (std::find(methods.begin(), methods.end(), *method) != methods.end()) {
        throw InvalidValue{fmt::format("'{}' is named twice", name)};
      }
      methods.push_back(*method);
    }
  };
  command.add({.name = fmt::format("--{}", info.name),
               .value = "M,M,...",
               .help = "methods, separated by commas, out of " + known,
               .notes = "default: " + joined(defaults, ","),
               .words = enum_words<Method>(),
               .take = take});
}

/// "auto", "floor", "table" or a plane's label.
std::optional<SupportChoice> parse_support(const std::string& text) {
  const auto kind = enum_from_name<SupportKind>(text);
  if (kind && kind != SupportKind::plane) return SupportChoice{.kind = *kind};
  const auto label = parse_number<int>(text);
  if (!label || *label < kLabelFirst || *label > kMaxPlanes) return std::nullopt;
  return SupportChoice{.kind = SupportKind::plane, .plane = *label};
}

std::vector<std::string> support_words() {
  std::vector<std::string> words = enum_words<SupportKind>();
  words.erase(words.begin() + static_cast<int>(SupportKind::plane));  // named by its number
  return words;
}

void add_support(Command& command, SupportChoice& support) {
  const std::string expected = fmt::format("auto, floor, table or a plane's label, 1 to {}", kMaxPlanes);
  const auto take = [&support, expected](const std::string& text) {
    const auto choice = parse_support(text);
    if (!choice) reject(expected, text);
    support = *choice;
  };
  command.add({.name = "--support",
               .value = "NAME|N",
               .help =
                   "the plane that obstacles are above or below; auto: the floor, else as table; table: the surface that things "
                   "stand on; where up is not known neither is found",
               .notes = fmt::format("{}; default: {}", expected, support_text(support)),
               .words = support_words(),
               .group = kObstacleGroup,
               .take = take});
}

template <class Options>
void check_valid(const Options& options) {
  if (const Status status = validate(options); !status) throw UsageError(status.error().message);
}

struct ToJson {
  nlohmann::ordered_json& json;

  template <class T>
  void operator()(const OptionInfo& info, const T& value) const {
    nlohmann::ordered_json& options = info.parameter_of.empty() ? json : json[std::string(info.parameter_of)];
    nlohmann::ordered_json& slot = options[std::string(info.name)];
    if constexpr (IsOptional<T>::value) {
      if (value) (*this)(info, *value);
    } else if constexpr (std::is_same_v<T, Eigen::Vector3d>) {
      slot = {value.x(), value.y(), value.z()};
    } else if constexpr (Named<T>) {
      slot = enum_name(value);
    } else {
      slot = value;
    }
    if (info.name == kPlanes && slot == 0) slot = "all";
  }
};

}  // namespace

std::string support_text(const SupportChoice& support) {
  return support.kind == SupportKind::plane ? fmt::format("{}", support.plane) : std::string(enum_name(support.kind));
}

void add_input_options(Command& command, InputOptions& inputs) {
  command.add({.name = "--camera",
               .value = "FILE|NAME",
               .help =
                   "intrinsics instead of the frames' own: a camera.json, ROS's, Open3D's, RealSense's or ORB-SLAM's file, or "
                   "a preset: kinect1, or freiburg1, freiburg2, freiburg3 of the TUM benchmark",
               .words = {"kinect1", "freiburg1", "freiburg2", "freiburg3"},
               .take = [&inputs](const std::string& text) { inputs.camera = text; }});
  const OptionInfo scale{"depth-scale", "", "raw units of depth per metre, instead of what cameras say: 1000 for millimetres",
                         1.0, 1e6};
  const std::string expected = expected_text(scale, inputs.depth_scale);
  command.add({.name = "--depth-scale",
               .value = "X",
               .help = std::string(scale.help),
               .notes = expected,
               .take = taker(inputs.depth_scale, scale, expected)});
  add_count(
      command, "--max-size", inputs.max_size, 1, std::numeric_limits<int>::max(),
      fmt::format("largest image or cloud that is read, in pixels or points; compressed clouds may expand to {} bytes for each",
                  io::ReadLimits{1}.max_decoded_bytes()));
}

void add_count(Command& command, const std::string& name, int& value, int min, int max, const std::string& help) {
  add_number(command, name, value, {.help = help, .min = static_cast<double>(min), .max = static_cast<double>(max)});
}

void add_seed(Command& command, std::uint64_t& value, const std::string& help) {
  add_number(command, "--seed", value, {.help = help});
}

void add_segment_options(Command& command, SegmentOptions& options, RunFiles& files, std::vector<Method>* several_methods) {
  for_each_option(options, [&](const OptionInfo& info, auto& value) {
    if constexpr (std::is_same_v<std::decay_t<decltype(value)>, std::optional<int>>) {
      if (info.name == kPlanes) return add_planes(command, info, value);
    }
    if (info.parameter_of == kSensorParam) return;
    if (info.name == kSensor) return add_sensor(command, info, options.sensor, files);
    if (info.name == kMethod && several_methods != nullptr) return add_methods(command, info, *several_methods);
    AddOption{command, group_of(info.used_by)}(info, value);
  });
  add_sensor_parameters(command, options.sensor);
}

void add_obstacle_options(Command& command, ObstacleRequest& request, const std::string& help) {
  add_flag(command, kObstacles, request.asked, help).group = kObstacleGroup;
  add_support(command, request.options.support);
  for_each_obstacle_option(request.options, AddOption{command, kObstacleGroup});
  need_obstacles(command);
}

void need_obstacles(Command& command) {
  for (Option& option : command.options) {
    if (option.group == kObstacleGroup && option.name != kObstacles && option.needs.empty()) option.needs = {kObstacles};
  }
}

void add_hoover(Command& command, HooverRequest& request) {
  const OptionInfo info{.name = "hoover",
                        .unit = "",
                        .help =
                            "classify regions as Hoover et al. (1996) do: correct, over-, under-segmented, missed, noise; "
                            "TOLERANCE is the share of each other that regions must hold",
                        .min = 0.5,
                        .max = 1.0,
                        .open_min = true};
  const std::string expected = expected_text(info, request.tolerance);
  const auto take = [&request, read = taker(request.tolerance, info, expected)](const std::string& text) {
    request.asked = true;
    read(text);
  };
  Option option = described(info, "", expected, value_text(request.tolerance));
  option.value = "[TOLERANCE]";
  option.left_out = value_text(request.tolerance);
  option.take = take;
  command.add(std::move(option));
}

void add_track_options(Command& command, TrackOptions& options) {
  for_each_track_option(options, AddOption{command, kTrackGroup});
}

SegmentOptions Runs::options_of(Method method) const {
  SegmentOptions chosen = used_by(options, method);
  chosen.method = method;
  return chosen;
}

void add_runs(Command& command, Runs& runs, int max_repeat, const std::string& repeat_help) {
  add_count(command, "--repeat", runs.repeat, 1, max_repeat, repeat_help);
  add_input_options(command, runs.inputs);
  add_segment_options(command, runs.options, runs.inputs.files, &runs.methods);
}

void check_options(const Runs& runs) {
  check_valid(runs.options);
  static const SegmentOptions kDefaults;
  const auto check = [&](const OptionInfo& info, const auto& value, const auto& by_default) {
    const auto uses_it = [&](Method method) { return uses(method, info, runs.options); };
    if (value == by_default || std::any_of(runs.methods.begin(), runs.methods.end(), uses_it)) return;
    throw UsageError(fmt::format("--{}: means nothing to any method of --method", info.name));
  };
  for_each_option_of(check, runs.options, kDefaults);
}
void check_options(const SegmentOptions& options) { check_valid(options); }
void check_options(const ObstacleOptions& options) { check_valid(options); }
void check_options(const TrackOptions& options) { check_valid(options); }

nlohmann::ordered_json options_to_json(const SegmentOptions& options) {
  nlohmann::ordered_json json = nlohmann::ordered_json::object();
  for_each_option(options, ToJson{json});
  return json;
}

nlohmann::ordered_json options_to_json(const ObstacleOptions& options) {
  nlohmann::ordered_json json;
  json["support"] = support_text(options.support);
  for_each_obstacle_option(options, ToJson{json});
  return json;
}

}  // namespace fransac::cli
