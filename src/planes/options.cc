// SPDX-License-Identifier: Apache-2.0
#include "fransac/planes/options.hpp"

#include <string>

#include "core/caught.hpp"
#include "core/number_text.hpp"
#include "planes/methods.hpp"
#include "planes/range_check.hpp"

namespace fransac {
namespace {

/// The first option that was set but that only `cells` knows; empty: there is none.
std::string_view option_of_cells(const CellsOptions& cells) {
  if (cells.parallel_to) return "parallel-to";
  if (cells.perpendicular_to) return "perpendicular-to";
  if (cells.residuals) return "residuals";
  if (cells.min_confidence != CellsOptions{}.min_confidence) return "min-confidence";
  return {};
}

}  // namespace

const AxisLimits* limits_of(const SegmentOptions& options, Method method, bool depth_image) {
  const bool chosen = options.pass_through.limits != AxisLimits{};
  // A cloud's axes mean nothing by themselves.
  const bool by_method = parts_of(method).pass_through && depth_image;
  return options.pass_through.use.value_or(chosen || by_method) ? &options.pass_through.limits : nullptr;
}

Status validate(const SegmentOptions& options) try {
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
} catch (const std::exception& exception) {
  return caught(exception, "options");
}

}  // namespace fransac
