// SPDX-License-Identifier: Apache-2.0
#include "fransac/planes/options.hpp"

#include <cmath>
#include <string>
#include <type_traits>

#include "core/number_text.hpp"
#include "planes/methods.hpp"

namespace fransac {
namespace {

/// As messages name it: "threshold", "sensor-param baseline".
std::string full_name(const OptionInfo& info) {
  return info.parameter_of.empty() ? std::string(info.name) : std::string(info.parameter_of) + " " + std::string(info.name);
}

/// "between 0 and 1 (exclusive)", "above 0 m", …
std::string range_text(const OptionInfo& info) {
  const std::string unit = info.unit.empty() ? "" : " " + std::string(info.unit);
  if (std::isfinite(info.min) && std::isfinite(info.max) && info.max < 1e6) {
    return "between " + number_text(info.min) + " and " + number_text(info.max) + (info.open_min ? ", both excluded" : "") + unit;
  }
  if (std::isfinite(info.min)) return (info.open_min ? "finite and above " : "at least ") + number_text(info.min) + unit;
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
  void operator()(const OptionInfo& info, const Eigen::Vector3d& direction) {
    if (!status || (direction.allFinite() && !direction.isZero(0.0))) return;
    status = Error{ErrorCode::invalid_argument, full_name(info) + ": must be finite and not zero"};
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
};

/// The first option that was set but that only `cells` knows; empty: there is none.
std::string_view option_of_cells(const CellsOptions& cells) {
  if (cells.parallel_to) return "parallel-to";
  if (cells.perpendicular_to) return "perpendicular-to";
  if (cells.residuals) return "residuals";
  if (cells.up) return "up";
  return {};
}

}  // namespace

const AxisLimits* limits_of(const SegmentOptions& options, Method method, bool depth_image) {
  const bool chosen = options.pass_through.limits != AxisLimits{};
  // A cloud's axes mean nothing by themselves.
  const bool by_method = parts_of(method).pass_through && depth_image;
  return options.pass_through.use.value_or(chosen || by_method) ? &options.pass_through.limits : nullptr;
}

Status validate(const SegmentOptions& options) {
  RangeCheck check;
  for_each_option(options, check);
  if (!check.status) return check.status;
  const AxisLimits& limits = options.pass_through.limits;
  if (!(limits.min_m < limits.max_m)) {
    return Error{ErrorCode::invalid_argument, "pass-through-min: must be below pass-through-max (" + number_text(limits.max_m) +
                                                  " m), is " + number_text(limits.min_m)};
  }
  if (Status status = validate(options.sensor); !status)
    return Error{status.error().code, "sensor-param " + status.error().message};
  const bool may_be_cells = options.method == Method::automatic || options.method == Method::cells;
  if (const std::string_view name = option_of_cells(options.cells); !name.empty() && !may_be_cells) {
    return Error{ErrorCode::invalid_argument,
                 std::string(name) + ": means nothing to method " + std::string(enum_name(options.method)) + ", only to cells"};
  }
  return {};
}

}  // namespace fransac
