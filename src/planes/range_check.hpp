// SPDX-License-Identifier: Apache-2.0
/// Whether options are in their ranges, for every table of options.
#pragma once

#include <Eigen/Core>
#include <cmath>
#include <optional>
#include <string>
#include <type_traits>

#include "core/number_text.hpp"
#include "fransac/core/point_cloud.hpp"
#include "fransac/planes/options.hpp"

namespace fransac {

/// Visits a table of options; `status` tells of the first that is out of its range.
struct RangeCheck {
  Status status;

  /// As messages name it: "threshold", "sensor-param baseline".
  static std::string full_name(const OptionInfo& info) {
    return info.parameter_of.empty() ? std::string(info.name) : std::string(info.parameter_of) + " " + std::string(info.name);
  }

  template <class T>
  void operator()(const OptionInfo& info, const std::optional<T>& value) {
    if (value) (*this)(info, *value);
  }
  void operator()(const OptionInfo& info, const Eigen::Vector3d& vector) {
    if (!status) return;
    if (is_position(info)) {
      status = validate_position(vector, full_name(info));
    } else if (!vector.allFinite() || vector.isZero(0.0)) {
      status = Error{ErrorCode::invalid_argument, full_name(info) + ": must be finite and not zero"};
    }
  }
  template <class T>
  void operator()(const OptionInfo& info, const T& value) {
    if (!status) return;
    if constexpr (std::is_enum_v<T>) {
      const auto number_of_values = static_cast<int>(std::size(EnumNames<T>::values));
      if (static_cast<int>(value) < 0 || static_cast<int>(value) >= number_of_values) {
        status = Error{ErrorCode::invalid_argument, full_name(info) + ": not a value of its enumeration"};
      }
    } else if constexpr (!std::is_same_v<T, bool>) {
      if (!in_range(info, static_cast<double>(value))) {
        status = Error{ErrorCode::invalid_argument,
                       full_name(info) + ": must be " + range_text(info) + ", is " + number_text(static_cast<double>(value))};
      }
    }
  }

 private:
  /// "between 0 and 1 (exclusive)", "above 0 m", …
  static std::string range_text(const OptionInfo& info) {
    const std::string unit = info.unit.empty() ? "" : " " + std::string(info.unit);
    if (std::isfinite(info.min) && std::isfinite(info.max) && info.max < 1e6) {
      return "between " + number_text(info.min) + " and " + number_text(info.max) + (info.open_min ? ", both excluded" : "") +
             unit;
    }
    if (std::isfinite(info.min)) return (info.open_min ? "finite and above " : "at least ") + number_text(info.min) + unit;
    return "a finite number" + unit;
  }

  static bool in_range(const OptionInfo& info, double value) {
    const bool above = info.open_min ? value > info.min : value >= info.min;
    const bool below = info.open_max ? value < info.max : value <= info.max;
    return above && below;  // false for NaN
  }
};

}  // namespace fransac
