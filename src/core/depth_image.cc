// SPDX-License-Identifier: Apache-2.0
#include "fransac/core/depth_image.hpp"

#include <cmath>
#include <limits>

#include "core/caught.hpp"
#include "fransac/core/camera.hpp"

namespace fransac {

DepthView DepthView::from_uint16(const std::uint16_t* data, int width, int height, double depth_scale,
                                 std::ptrdiff_t row_stride_bytes) {
  DepthView view;
  view.data_ = reinterpret_cast<const std::byte*>(data);
  view.width_ = width;
  view.height_ = height;
  view.row_stride_bytes_ = row_stride_bytes != 0 ? row_stride_bytes : static_cast<std::ptrdiff_t>(sizeof(std::uint16_t)) * width;
  view.metres_per_unit_ = static_cast<float>(1.0 / depth_scale);
  view.format_ = DepthFormat::uint16;
  return view;
}

DepthView DepthView::from_float(const float* data, int width, int height, std::ptrdiff_t row_stride_bytes) {
  DepthView view;
  view.data_ = reinterpret_cast<const std::byte*>(data);
  view.width_ = width;
  view.height_ = height;
  view.row_stride_bytes_ = row_stride_bytes != 0 ? row_stride_bytes : static_cast<std::ptrdiff_t>(sizeof(float)) * width;
  view.format_ = DepthFormat::float32;
  return view;
}

DepthView DepthView::in_memory(const void* data, std::ptrdiff_t row_stride_bytes) const {
  DepthView view = *this;
  view.data_ = static_cast<const std::byte*>(data);
  view.row_stride_bytes_ = row_stride_bytes;
  return view;
}

float DepthView::metres(int u, int v) const {
  if (format_ == DepthFormat::uint16) return static_cast<float>(row_uint16(v)[u]) * metres_per_unit_;
  const float z = row_float(v)[u];
  return z > 0.0F && z <= kMaxDepth_m ? z : 0.0F;  // false for NaN
}

Status validate(const DepthView& depth) try {
  const auto error = [](const char* message) { return Error{ErrorCode::invalid_argument, message}; };
  if (depth.width() < 1 || depth.width() > kMaxImageSide) return error("depth image: width must be between 1 and 32768 pixels");
  if (depth.height() < 1 || depth.height() > kMaxImageSide)
    return error("depth image: height must be between 1 and 32768 pixels");
  if (depth.row_uint16(0) == nullptr) return error("depth image: data is null");
  const auto value_size =
      static_cast<std::ptrdiff_t>(depth.format() == DepthFormat::uint16 ? sizeof(std::uint16_t) : sizeof(float));
  const std::ptrdiff_t stride = depth.row_stride_bytes();
  const std::ptrdiff_t row_size = value_size * depth.width();
  if (-row_size < stride && stride < row_size) return error("depth image: row stride is shorter than a row");
  if (stride % value_size != 0) return error("depth image: row stride is not a multiple of the value's size");
  constexpr float kLargestRaw = std::numeric_limits<std::uint16_t>::max();
  if (!std::isfinite(depth.metres_per_unit() * kLargestRaw) || depth.metres_per_unit() <= 0.0F) {
    return error("depth image: depth scale must be a positive number of units per metre");
  }
  return {};
} catch (const std::exception& exception) {
  return caught(exception, "depth image");
}

}  // namespace fransac
