// SPDX-License-Identifier: Apache-2.0
/// What a measured time depends on.
#pragma once

#include <fstream>
#include <string>
#include <thread>

namespace fransac::cli {

struct Machine {
  std::string cpu;
  unsigned cores = 0;
  std::string compiler;
  std::string build_type;
};

inline std::string cpu_model() {
  std::ifstream file("/proc/cpuinfo");
  for (std::string line; std::getline(file, line);) {
    const std::size_t colon = line.find(": ");
    if (line.starts_with("model name") && colon != std::string::npos) return line.substr(colon + 2);
  }
  return "unknown";
}

inline Machine this_machine() {
#ifdef __clang__
  const char* const compiler = "clang " __clang_version__;
#else
  const char* const compiler = "gcc " __VERSION__;
#endif
  return {cpu_model(), std::thread::hardware_concurrency(), compiler, FRANSAC_BUILD_TYPE};
}

}  // namespace fransac::cli
