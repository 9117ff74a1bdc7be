// SPDX-License-Identifier: Apache-2.0
// The help of the commands says the defaults that the options have.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <array>
#include <cstdio>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <type_traits>

#include "fransac/obstacles/obstacles.hpp"
#include "fransac/planes/options.hpp"
#include "fransac/track/tracker.hpp"

namespace fransac {
namespace {

std::string output_of(const std::string& arguments) {
  const std::unique_ptr<FILE, int (*)(FILE*)> pipe(popen(fmt::format("'{}' {}", FRANSAC_APP, arguments).c_str(), "r"), pclose);
  std::string output;
  std::array<char, 4096> buffer{};
  for (std::size_t size = 0; (size = fread(buffer.data(), 1, buffer.size(), pipe.get())) > 0;) output.append(buffer.data(), size);
  return output;
}

std::string default_text(bool value) { return value ? "on" : "off"; }
template <class T>
std::string default_text(const T& value) {
  if constexpr (std::is_enum_v<T>) {
    return std::string(enum_name(value));
  } else {
    return fmt::format("{}", value);
  }
}
std::string default_text(const std::optional<Eigen::Vector3d>& /*unset*/) { return "none"; }
template <class T>
std::string default_text(const std::optional<T>& value) {
  return value ? default_text(*value) : "the method decides";
}

/// The help from an option's name to the end of its default.
std::string entry_of(const std::string& help, std::string_view name) {
  const std::string wanted = fmt::format("\n  --{}", name);
  std::size_t begin = help.find(wanted);
  while (begin != std::string::npos && help.find_first_of(", \n", begin + wanted.size()) != begin + wanted.size()) {
    begin = help.find(wanted, begin + 1);  // that was a longer name
  }
  EXPECT_NE(begin, std::string::npos) << "the option is not in the help by its name";
  return begin == std::string::npos ? "" : help.substr(begin, help.find(']', begin) - begin + 1);
}

TEST(Help, SegmentShowsEveryOptionWithItsDefaultUnitAndText) {
  const std::string help = output_of("segment --help");
  SegmentOptions options;
  for_each_option(options, [&](const OptionInfo& info, const auto& value) {
    SCOPED_TRACE(std::string(info.name));
    if (!info.parameter_of.empty()) {
      EXPECT_NE(entry_of(help, info.parameter_of).find(std::string(info.name) + ": "), std::string::npos);
      return;
    }
    const std::string entry = entry_of(help, info.name);
    EXPECT_NE(entry.find(fmt::format("default: {}]", default_text(value))), std::string::npos) << entry;
    EXPECT_NE(entry.find(info.help.substr(0, 20)), std::string::npos) << entry;
    if (info.unit == "m") {
      EXPECT_NE(entry.find("[m; "), std::string::npos) << entry;
    }
  });
}

TEST(Help, EveryCommandThatSegmentsTakesTheSameOptions) {
  for (const char* command : {"evaluate", "report", "bench"}) {
    const std::string help = output_of(fmt::format("{} --help", command));
    SegmentOptions options;
    for_each_option(options, [&](const OptionInfo& info, const auto& value) {
      if (std::string_view(command) == "report" && info.name == "method") return;  // the paper's four
      SCOPED_TRACE(fmt::format("{} {}", command, info.name));
      if (!info.parameter_of.empty()) return;
      EXPECT_NE(entry_of(help, info.name).find(fmt::format("default: {}]", default_text(value))), std::string::npos);
    });
  }
}

TEST(Help, CommandsThatFindObstaclesShowTheirOptionsWithDefaultUnitAndText) {
  for (const char* command : {"segment", "evaluate", "track", "report"}) {
    const std::string help = output_of(fmt::format("{} --help", command));
    EXPECT_NE(entry_of(help, "support").find("default: auto]"), std::string::npos);
    ObstacleOptions options;
    for_each_obstacle_option(options, [&](const OptionInfo& info, const auto& value) {
      SCOPED_TRACE(fmt::format("{} {}", command, info.name));
      const std::string entry = entry_of(help, info.name);
      EXPECT_NE(entry.find(fmt::format("[{}; ", info.unit)), std::string::npos) << entry;
      EXPECT_NE(entry.find(fmt::format("default: {}]", value)), std::string::npos) << entry;
      EXPECT_NE(entry.find(info.help.substr(0, 20)), std::string::npos) << entry;
    });
  }
}

TEST(Help, CommandsThatFollowSequencesShowTheTrackersOptionsWithDefaultUnitAndText) {
  for (const char* command : {"track", "report"}) {
    const std::string help = output_of(fmt::format("{} --help", command));
    TrackOptions options;
    for_each_track_option(options, [&](const OptionInfo& info, const auto& value) {
      SCOPED_TRACE(fmt::format("{} {}", command, info.name));
      const std::string entry = entry_of(help, info.name);
      EXPECT_NE(entry.find(fmt::format("[{}; ", info.unit)), std::string::npos) << entry;
      EXPECT_NE(entry.find(fmt::format("default: {}]", value)), std::string::npos) << entry;
      EXPECT_NE(entry.find(info.help.substr(0, 20)), std::string::npos) << entry;
    });
  }
}

}  // namespace
}  // namespace fransac
