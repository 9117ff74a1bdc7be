// SPDX-License-Identifier: Apache-2.0
#include "fransac/filter/correct.hpp"

#include <algorithm>
#include <cstddef>
#include <limits>

#include "core/caught.hpp"

namespace fransac {
namespace {

/// What q is multiplied by, from a times depth and b.
float factor(const DistortionRow& row, float x, float z) {
  float offset = row.offset_per_m.back();
  float gain = row.gain.back();
  for (std::size_t k = row.gain.size() - 1; k-- > 0;) {
    offset = offset * x + row.offset_per_m[k];
    gain = gain * x + row.gain[k];
  }
  constexpr float kMost = 2.0F;
  return std::min(std::max(1.0F + gain + offset * z, 1.0F / kMost), kMost);
}

/// Calls correct_row(v, row, x0, step): x of pixel u is x0 + step u.
template <class CorrectRow>
void for_each_row(const DepthView& depth, const Distortion& distortion, CorrectRow&& correct_row) {
  const float step = 2.0F / static_cast<float>(depth.width());
  for (int v = 0; v < depth.height(); ++v) {
    correct_row(v, distortion_row(distortion, (2.0 * v + 1.0) / depth.height() - 1.0), 0.5F * step - 1.0F, step);
  }
}

void correct_units(const DepthView& depth, const Distortion& distortion, int saturated, std::uint16_t* out) {
  constexpr auto kMostUnits = static_cast<float>(std::numeric_limits<std::uint16_t>::max());
  const auto width = static_cast<std::size_t>(depth.width());
  const float scale = depth.metres_per_unit();
  const auto kept = static_cast<std::uint16_t>(saturated);  // where there is none: 0, which is kept anyway
  const auto beside = static_cast<std::uint16_t>(kept == 1 ? 2 : kept - 1);
  for_each_row(depth, distortion, [&](int v, const DistortionRow& row, float x0, float step) {
    const std::uint16_t* const in = depth.row_uint16(v);
    for (std::size_t u = 0; u < width; ++u) {
      const auto raw = static_cast<float>(in[u]);
      const float corrected = raw / factor(row, x0 + step * static_cast<float>(u), scale * raw);
      auto units = static_cast<std::uint16_t>(static_cast<std::int32_t>(std::min(std::max(corrected, 1.0F), kMostUnits) + 0.5F));
      if (units == kept) units = beside;  // is a measurement still
      out[u] = in[u] == 0 || in[u] == kept ? in[u] : units;
    }
    out += width;
  });
}

void correct_metres(const DepthView& depth, const Distortion& distortion, float* out) {
  constexpr float kLeast_m = std::numeric_limits<float>::denorm_min();  // is a measurement still, as is the largest depth
  const auto width = static_cast<std::size_t>(depth.width());
  for_each_row(depth, distortion, [&](int v, const DistortionRow& row, float x0, float step) {
    const float* const in = depth.row_float(v);
    for (std::size_t u = 0; u < width; ++u) {
      const float z = in[u];
      const bool measured = z > 0.0F && z <= kMaxDepth_m;
      const float corrected = z / factor(row, x0 + step * static_cast<float>(u), z);
      out[u] = measured ? std::min(std::max(corrected, kLeast_m), kMaxDepth_m) : z;
    }
    out += width;
  });
}

}  // namespace

bool without_saturated(const DepthView& depth, int saturated, CorrectedDepth& result) {
  if (saturated == 0 || depth.format() != DepthFormat::uint16) return false;
  const auto value = static_cast<std::uint16_t>(saturated);
  const auto width = static_cast<std::size_t>(depth.width());
  bool any = false;
  for (int v = 0; v < depth.height() && !any; ++v) {
    const std::uint16_t* const row = depth.row_uint16(v);
    std::uint16_t found = 0;  // without a branch and as narrow as the values, so that it is vector code
    for (std::size_t u = 0; u < width; ++u)
      found = static_cast<std::uint16_t>(found | static_cast<std::uint16_t>(row[u] == value));
    any = found != 0;
  }
  if (!any) return false;
  result.units.resize(depth.size());
  std::uint16_t* out = result.units.data();
  for (int v = 0; v < depth.height(); ++v, out += width) {
    const std::uint16_t* const row = depth.row_uint16(v);
    std::replace_copy(row, row + width, out, value, std::uint16_t{0});
  }
  result.view = depth.in_memory(result.units.data(), depth.width() * static_cast<std::ptrdiff_t>(sizeof(std::uint16_t)));
  return true;
}

Status correct(const DepthView& depth, const Distortion& distortion, int saturated, CorrectedDepth& result) try {
  if (Status status = validate(distortion); !status) return status;
  if (Status status = check_shape(distortion, depth.width(), depth.height()); !status) return status;
  if (depth.format() == DepthFormat::uint16) {
    result.units.resize(depth.size());
    correct_units(depth, distortion, saturated, result.units.data());
    result.view = depth.in_memory(result.units.data(), depth.width() * static_cast<std::ptrdiff_t>(sizeof(std::uint16_t)));
  } else {
    result.metres.resize(depth.size());
    correct_metres(depth, distortion, result.metres.data());
    result.view = depth.in_memory(result.metres.data(), depth.width() * static_cast<std::ptrdiff_t>(sizeof(float)));
  }
  return {};
} catch (const std::exception& exception) {
  return caught(exception, "depth image");
}

}  // namespace fransac
