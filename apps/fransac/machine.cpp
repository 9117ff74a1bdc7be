// SPDX-License-Identifier: Apache-2.0
#include "machine.hpp"

#include <fmt/format.h>

#include <fstream>
#include <thread>

#include "fransac/planes/segment.hpp"
#include "fransac/version.hpp"

namespace fransac::cli {
namespace {

std::string cpu_model() {
  std::ifstream file("/proc/cpuinfo");
  for (std::string line; std::getline(file, line);) {
    const std::size_t colon = line.find(": ");
    if (line.starts_with("model name") && colon != std::string::npos) return line.substr(colon + 2);
  }
  return "unknown";
}

}  // namespace

Machine this_machine() {
#ifdef __clang__
  const char* const compiler = "clang " __clang_version__;
#else
  const char* const compiler = "gcc " __VERSION__;
#endif
  return {cpu_model(), std::thread::hardware_concurrency(), compiler, FRANSAC_BUILD_TYPE};
}

std::string to_text(const Machine& machine) {
  return fmt::format("{}, {} cores, {}, {}, {} build, fransac {}", machine.cpu, machine.cores, instruction_set(),
                     machine.compiler, machine.build_type, kVersion);
}

nlohmann::ordered_json to_json(const Machine& machine) {
  return {{"cpu", machine.cpu},           {"cores", machine.cores},           {"instruction_set", instruction_set()},
          {"compiler", machine.compiler}, {"build_type", machine.build_type}, {"fransac_version", kVersion}};
}

}  // namespace fransac::cli
