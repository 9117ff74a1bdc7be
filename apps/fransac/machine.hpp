// SPDX-License-Identifier: Apache-2.0
/// What times were measured on.
#pragma once

#include <nlohmann/json.hpp>
#include <string>

namespace fransac::cli {

struct Machine {
  std::string cpu;
  unsigned cores = 0;
  std::string compiler;
  std::string build_type;
};

Machine this_machine();

/// "CPU, 2 cores, gcc 12, Release build, fransac VERSION"
std::string to_text(const Machine& machine);
nlohmann::ordered_json to_json(const Machine& machine);

}  // namespace fransac::cli
