// SPDX-License-Identifier: Apache-2.0
/// A view of a depth image in somebody else's memory.
#pragma once

#include <cstddef>
#include <cstdint>

#include "fransac/core/result.hpp"

namespace fransac {

/// What the values of a depth image mean.
enum class DepthFormat {
  uint16,   ///< Raw units; metres = value / depth_scale; 0 is no measurement.
  float32,  ///< Metres; 0, negative, NaN and values above kMaxDepth_m are no measurement.
};

/// No depth camera sees farther, metres; larger values in float images (infinity among them) are no measurement.
inline constexpr float kMaxDepth_m = 1e5F;

/// A read-only view of a depth image (z along the optical axis, not range). It owns nothing.
class DepthView {
 public:
  /// An empty view, which is not valid.
  DepthView() = default;

  /// `data` holds `height` rows of `width` values; `row_stride_bytes` 0 means rows without gaps.
  static DepthView from_uint16(const std::uint16_t* data, int width, int height, double depth_scale,
                               std::ptrdiff_t row_stride_bytes = 0);
  /// The same for values in metres.
  static DepthView from_float(const float* data, int width, int height, std::ptrdiff_t row_stride_bytes = 0);

  /// An image of the same size, format and scale in other memory.
  [[nodiscard]] DepthView in_memory(const void* data, std::ptrdiff_t row_stride_bytes) const;

  [[nodiscard]] DepthFormat format() const { return format_; }  ///< What the values mean.
  [[nodiscard]] int width() const { return width_; }            ///< Columns, pixels.
  [[nodiscard]] int height() const { return height_; }          ///< Rows, pixels.
  /// Pixels.
  [[nodiscard]] std::size_t size() const { return static_cast<std::size_t>(width_) * static_cast<std::size_t>(height_); }
  [[nodiscard]] std::ptrdiff_t row_stride_bytes() const { return row_stride_bytes_; }  ///< From one row to the next.
  /// Metres per raw unit (1 for float32).
  [[nodiscard]] float metres_per_unit() const { return metres_per_unit_; }

  /// Row v of a uint16 image, raw units.
  [[nodiscard]] const std::uint16_t* row_uint16(int v) const { return reinterpret_cast<const std::uint16_t*>(row(v)); }
  /// Row v of a float32 image, metres.
  [[nodiscard]] const float* row_float(int v) const { return reinterpret_cast<const float*>(row(v)); }

  /// Depth in metres at a pixel, 0 where nothing was measured. For single look-ups; loops read rows.
  [[nodiscard]] float metres(int u, int v) const;

 private:
  [[nodiscard]] const std::byte* row(int v) const { return data_ + static_cast<std::ptrdiff_t>(v) * row_stride_bytes_; }

  const std::byte* data_ = nullptr;
  std::ptrdiff_t row_stride_bytes_ = 0;
  int width_ = 0;
  int height_ = 0;
  float metres_per_unit_ = 1.0F;
  DepthFormat format_ = DepthFormat::uint16;
};

/// Checks pointer, sizes (1..kMaxImageSide), stride (at least one row, a multiple of the value's size) and scale.
Status validate(const DepthView& depth);

}  // namespace fransac
