// SPDX-License-Identifier: Apache-2.0
// Only in builds with FRANSAC_TUNABLE; else the constants are known when the engine is compiled.
#include "planes/cells/constants.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdlib>
#include <string>
#include <system_error>

#include "fransac/planes/tuning.hpp"

namespace fransac::cells {
namespace {

constexpr std::string_view kVariable = "FRANSAC_CELLS_TUNE";

constexpr auto kMembers = std::to_array<double Constants::*>({
#define FRANSAC_CELLS_POINTER(name, value) &Constants::name,
    FRANSAC_CELLS_CONSTANTS(FRANSAC_CELLS_POINTER)
#undef FRANSAC_CELLS_POINTER
});

Error wrong(std::string_view part, std::string_view why) {
  return {ErrorCode::invalid_argument, std::string(kVariable) + ": '" + std::string(part) + "': " + std::string(why)};
}

/// Multiplies the constant that "name=factor" names.
Status tune(std::string_view part, Constants& constants) {
  const std::size_t sign = part.find('=');
  if (sign == std::string_view::npos) return wrong(part, "not name=factor");
  const auto name = std::find(kConstantNames.begin(), kConstantNames.end(), part.substr(0, sign));
  if (name == kConstantNames.end()) return wrong(part, "no such constant");
  const std::string_view number = part.substr(sign + 1);
  double factor = 0.0;
  const auto [end, error] = std::from_chars(number.data(), number.data() + number.size(), factor);
  if (error != std::errc{} || end != number.data() + number.size() || !std::isfinite(factor) || !(factor > 0.0)) {
    return wrong(part, "the factor must be a positive number");
  }
  constants.*kMembers[static_cast<std::size_t>(name - kConstantNames.begin())] *= factor;
  return {};
}

struct Tuning {
  Constants constants;
  Status status;
};

Tuning tuning_of(std::string_view text) {
  Tuning tuning;
  while (!text.empty()) {
    const std::size_t comma = std::min(text.find(','), text.size());
    if (Status status = tune(text.substr(0, comma), tuning.constants); !status) return {Constants{}, std::move(status)};
    text.remove_prefix(std::min(comma + 1, text.size()));
  }
  return tuning;
}

// Read before main; whatever uses the constants is called later.
const Tuning kTuning = [] {
  const char* const text = std::getenv(kVariable.data());
  return tuning_of(text == nullptr ? "" : text);
}();

}  // namespace

const Constants kConstants = kTuning.constants;

}  // namespace fransac::cells

namespace fransac {

std::span<const std::string_view> tunable_constants() { return cells::kConstantNames; }

const Status& tuning_status() { return cells::kTuning.status; }

}  // namespace fransac
