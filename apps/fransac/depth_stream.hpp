// SPDX-License-Identifier: Apache-2.0
/// Raw depth frames from a pipe. A line of text, then frames:
///
///   fransac-depth 1 WIDTH HEIGHT uint16|float32 METRES_PER_UNIT FX FY CX CY\n
///
/// Each frame is a timestamp in seconds (a 64-bit float) and HEIGHT rows of WIDTH values; all little-endian. METRES_PER_UNIT is 1
/// for float32, whose values are metres.
#pragma once

#include <cstddef>
#include <cstdint>
#include <iosfwd>
#include <vector>

#include "fransac/core/camera.hpp"
#include "fransac/core/depth_image.hpp"
#include "fransac/io/limits.hpp"

namespace fransac::cli {

struct StreamFrame {
  double timestamp_s = 0.0;
  std::vector<std::uint16_t> units;  ///< One of the two is empty.
  std::vector<float> metres;
};

class DepthStream {
 public:
  /// Reads the header. Throws Failure, as read(); frames of more pixels than `limits` allow are refused.
  DepthStream(std::istream& in, const io::ReadLimits& limits);
  [[nodiscard]] const Camera& camera() const { return camera_; }
  /// False at the end. A stream that ends within a frame is a Failure.
  bool read(StreamFrame& frame);
  [[nodiscard]] DepthView view(const StreamFrame& frame) const;

 private:
  /// Of a frame.
  [[nodiscard]] std::size_t pixels() const {
    return static_cast<std::size_t>(camera_.width) * static_cast<std::size_t>(camera_.height);
  }
  bool read_exactly(void* data, std::size_t bytes);
  template <class Value>
  bool read_values(std::vector<Value>& values, std::size_t count);

  std::istream& in_;
  Camera camera_;
  DepthFormat format_ = DepthFormat::uint16;
  std::size_t frames_ = 0;
};

}  // namespace fransac::cli
