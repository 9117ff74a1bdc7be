// SPDX-License-Identifier: Apache-2.0
#include "fransac/planes/options.hpp"

#include <array>
#include <cmath>
#include <cstdio>
#include <string>
#include <type_traits>

namespace fransac {
namespace {

std::string number(double value) {
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), "%g", value);
  return text.data();
}

/// "between 0 and 1 (exclusive)", "above 0 m", …
std::string range_text(const OptionInfo& info) {
  const std::string unit = info.unit.empty() ? "" : " " + std::string(info.unit);
  if (std::isfinite(info.min) && std::isfinite(info.max) && info.max < 1e6) {
    return "between " + number(info.min) + " and " + number(info.max) + (info.open_min ? ", both excluded" : "") + unit;
  }
  if (std::isfinite(info.min)) return (info.open_min ? "finite and above " : "at least ") + number(info.min) + unit;
  return "a finite number" + unit;
}

bool in_range(const OptionInfo& info, double value) {
  const bool above = info.open_min ? value > info.min : value >= info.min;
  const bool below = info.open_max ? value < info.max : value <= info.max;
  return above && below;  // false for NaN
}

struct RangeCheck {
  Status status;

  template <class T>
  void operator()(const OptionInfo& info, const std::optional<T>& value) {
    if (value) (*this)(info, *value);
  }
  template <class T>
  void operator()(const OptionInfo& info, const T& value) {
    if (!status) return;
    if constexpr (std::is_enum_v<T>) {
      const auto number_of_values = static_cast<int>(std::size(EnumNames<T>::values));
      if (static_cast<int>(value) < 0 || static_cast<int>(value) >= number_of_values) {
        status = Error{ErrorCode::invalid_argument, std::string(info.name) + ": not a value of its enumeration"};
      }
    } else if constexpr (!std::is_same_v<T, bool>) {
      if (!in_range(info, static_cast<double>(value))) {
        status = Error{ErrorCode::invalid_argument,
                       std::string(info.name) + ": must be " + range_text(info) + ", is " + number(static_cast<double>(value))};
      }
    }
  }
};

}  // namespace

Status validate(const SegmentOptions& options) {
  RangeCheck check;
  for_each_option(options, check);
  if (!check.status) return check.status;
  const AxisLimits& limits = options.pass_through.limits;
  if (!(limits.min_m < limits.max_m)) {
    return Error{ErrorCode::invalid_argument,
                 "pass-through-min: must be below pass-through-max (" + number(limits.max_m) + " m), is " + number(limits.min_m)};
  }
  return {};
}

}  // namespace fransac
