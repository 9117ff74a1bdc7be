// SPDX-License-Identifier: Apache-2.0
/// Rows of a depth image as kernels want them.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <type_traits>

#include "fransac/core/aligned.hpp"
#include "fransac/core/camera.hpp"
#include "fransac/core/depth_image.hpp"
#include "fransac/filter/pass_through.hpp"
#include "kernels/rows.h"

namespace fransac {

/// Calls function(Raw{}) with the type of the image's raw values.
template <class Function>
decltype(auto) with_raw_type(DepthFormat format, Function&& function) {
  return format == DepthFormat::uint16 ? function(std::uint16_t{}) : function(float{});
}

/// Memory for one row. One per thread.
struct DepthRowBuffer {
  AlignedVector<std::uint16_t> units[2];
  AlignedVector<float> metres[2];

  template <class Raw>
  Raw* get(std::size_t which, std::size_t size) {
    if constexpr (std::is_same_v<Raw, float>) {
      metres[which].resize(size);
      return metres[which].data();
    } else {
      units[which].resize(size);
      return units[which].data();
    }
  }
};

/// The rows of a depth image in whole blocks: 0 is no measurement, and so is what limits do not keep.
template <class Raw>
class DepthRows {
 public:
  /// `view` and `camera` must be valid and outlive this. `limits` null: all is kept.
  DepthRows(const DepthView& view, const Camera& camera, const AxisLimits* limits)
      : view_(&view), camera_(&camera), limits_(limits), width_(static_cast<std::size_t>(view.width())) {
    if (limits != nullptr && is_range()) set_range(LocalLimits(*limits));
  }

  struct Row {
    const Raw* measured;
    const Raw* kept;
  };
  [[nodiscard]] const DepthView& view() const { return *view_; }
  [[nodiscard]] const Camera& camera() const { return *camera_; }
  [[nodiscard]] int height() const { return view_->height(); }
  [[nodiscard]] std::size_t width() const { return width_; }
  /// Values in a row of whole blocks.
  [[nodiscard]] std::size_t padded_width() const { return (width_ + kernels::kBlock - 1) / kernels::kBlock * kernels::kBlock; }
  /// Whether row(v).kept is the image's own memory, whole blocks of it, and needs no buffer.
  [[nodiscard]] bool stays_in_place() const {
    return !std::is_same_v<Raw, float> && limits_ == nullptr && padded_width() == width_;
  }
  /// The largest raw value that can be kept.
  [[nodiscard]] Raw largest_kept() const { return max_; }

  /// Row v; valid until the buffer's next use.
  [[nodiscard]] Row row(int v, DepthRowBuffer& buffer) const {
    const Raw* const measured = measured_row(v, buffer);
    if (limits_ == nullptr) return {measured, measured};
    Raw* const kept = buffer.get<Raw>(1, padded_width());
    if (is_range()) {
      kernels::row_kernels<Raw>().keep_range(measured, padded_width(), min_, max_, kept);
    } else {
      const LocalLimits local(*limits_);
      for (std::size_t u = 0; u < padded_width(); ++u) kept[u] = kept_by_coordinate(local, u, ray_y(v), measured[u]);
    }
    return {measured, kept};
  }
  /// How many values of a row are measurements.
  [[nodiscard]] std::size_t count(const Raw* values) const {
    return kernels::row_kernels<Raw>().count_measured(values, padded_width());
  }

  /// One pixel of row(v).kept.
  [[nodiscard]] Raw kept_at(std::uint32_t u, int v) const {
    Raw raw{};
    if constexpr (std::is_same_v<Raw, float>) {
      raw = view_->metres(static_cast<int>(u), v);
    } else {
      raw = view_->row_uint16(v)[u];
    }
    if (limits_ == nullptr) return raw;
    if (is_range()) return raw >= min_ && raw <= max_ ? raw : Raw{0};
    return kept_by_coordinate(LocalLimits(*limits_), u, ray_y(v), raw);
  }

 private:
  static constexpr Raw kMostRaw = std::is_same_v<Raw, float> ? static_cast<Raw>(kMaxDepth_m) : static_cast<Raw>(0xFFFF);

  /// Whether the limits are an interval of raw values.
  [[nodiscard]] bool is_range() const { return limits_->axis == Axis::z && !limits_->outside; }

  void set_range(const LocalLimits& local) {
    if constexpr (std::is_same_v<Raw, float>) {
      min_ = local.min;
      max_ = std::min(local.max, kMostRaw);
      if (!(min_ <= max_ && max_ >= 0.0F)) {  // nothing: both limits may lie between the same two floats, or behind the camera
        min_ = 1.0F;
        max_ = 0.0F;
      }
    } else {
      // The raw values whose depth, rounded as everywhere, lies within the limits.
      const float scale = view_->metres_per_unit();
      const std::uint32_t first = first_unit([&](std::uint32_t raw) { return static_cast<float>(raw) * scale >= local.min; });
      const std::uint32_t end = first_unit([&](std::uint32_t raw) { return static_cast<float>(raw) * scale > local.max; });
      min_ = static_cast<Raw>(first < end ? first : 1);
      max_ = static_cast<Raw>(first < end ? end - 1 : 0);
    }
  }

  /// The smallest 16-bit value with a property that all larger ones have, too; 2^16 without any.
  template <class Property>
  static std::uint32_t first_unit(const Property& property) {
    std::uint32_t low = 0;
    for (std::uint32_t high = 0x10000; low < high;) {
      const std::uint32_t middle = (low + high) / 2;
      if (property(middle)) {
        high = middle;
      } else {
        low = middle + 1;
      }
    }
    return low;
  }

  const Raw* measured_row(int v, DepthRowBuffer& buffer) const {
    if constexpr (std::is_same_v<Raw, float>) {
      const float* const row = view_->row_float(v);
      float* const out = buffer.get<float>(0, padded_width());
      std::transform(row, row + width_, out, [](float z) { return z > 0.0F && z <= kMaxDepth_m ? z : 0.0F; });
      std::fill(out + width_, out + padded_width(), 0.0F);
      return out;
    } else {
      const std::uint16_t* const row = view_->row_uint16(v);
      if (padded_width() == width_) return row;
      std::uint16_t* const out = buffer.get<std::uint16_t>(0, padded_width());
      std::copy(row, row + width_, out);
      std::fill(out + width_, out + padded_width(), std::uint16_t{0});
      return out;
    }
  }

  /// The way of limits along x or y, or of what lies outside them.
  [[nodiscard]] Raw kept_by_coordinate(const LocalLimits& local, std::size_t u, float ray_y, Raw raw) const {
    const float z = static_cast<float>(raw) * view_->metres_per_unit();
    const auto ray_x = [&] {
      return (static_cast<float>(u) - static_cast<float>(camera_->cx)) * static_cast<float>(1.0 / camera_->fx);
    };
    const float ray = limits_->axis == Axis::x ? ray_x() : limits_->axis == Axis::y ? ray_y : 1.0F;
    return local.keeps(z * ray) ? raw : Raw{0};
  }

  [[nodiscard]] float ray_y(int v) const { return static_cast<float>((v - camera_->cy) / camera_->fy); }

  const DepthView* view_;
  const Camera* camera_;
  const AxisLimits* limits_;
  std::size_t width_;
  Raw min_ = 0;
  Raw max_ = kMostRaw;
};

}  // namespace fransac
