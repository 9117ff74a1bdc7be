// SPDX-License-Identifier: Apache-2.0
#include "depth_stream.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <istream>
#include <sstream>
#include <string>

#include "errors.hpp"
#include "fransac/core/printable.hpp"

namespace fransac::cli {
namespace {

static_assert(std::endian::native == std::endian::little, "the stream's values are read as they are in memory");

constexpr const char* kForm = "fransac-depth 1 WIDTH HEIGHT uint16|float32 METRES_PER_UNIT FX FY CX CY";

std::string read_line(std::istream& in) {
  constexpr std::size_t kLongest = 1024;  // a stream of something else has no end of line
  std::string line;
  for (int c = in.get(); c != '\n' && c != std::istream::traits_type::eof() && line.size() < kLongest; c = in.get()) {
    line.push_back(static_cast<char>(c));
  }
  return line;
}

}  // namespace

DepthStream::DepthStream(std::istream& in, const io::ReadLimits& limits) : in_(in) {
  std::istringstream line(read_line(in));
  std::string name;
  std::string format;
  int version = 0;
  double metres_per_unit = 0.0;
  line >> name >> version >> camera_.width >> camera_.height >> format >> metres_per_unit >> camera_.fx >> camera_.fy >>
      camera_.cx >> camera_.cy;
  std::string rest;
  if (!line || (line >> rest) || name != "fransac-depth" || version != 1) {
    throw Failure(fmt::format("standard input: the first line is not \"{}\"", kForm));
  }
  if (format != "uint16" && format != "float32") {
    throw Failure(fmt::format("standard input: {} is neither uint16 nor float32", quoted_text(format)));
  }
  format_ = format == "uint16" ? DepthFormat::uint16 : DepthFormat::float32;
  if (!(metres_per_unit > 0.0) || (format_ == DepthFormat::float32 && metres_per_unit != 1.0)) {
    throw Failure("standard input: METRES_PER_UNIT must be positive, and 1 for float32");
  }
  camera_.depth_scale = 1.0 / metres_per_unit;
  if (const Status status = validate(camera_); !status) {
    throw Failure(fmt::format("standard input: {}", status.error().message));
  }
  if (pixels() > limits.max_size) {
    throw Failure(fmt::format("standard input: {}x{} pixels: more than the limit of {} (--max-size)", camera_.width,
                              camera_.height, limits.max_size));
  }
}

bool DepthStream::read_exactly(void* data, std::size_t bytes) {
  in_.read(static_cast<char*>(data), static_cast<std::streamsize>(bytes));
  return in_.gcount() == static_cast<std::streamsize>(bytes);
}

template <class Value>
bool DepthStream::read_values(std::vector<Value>& values, std::size_t count) {
  constexpr std::size_t kPiece = std::size_t{1} << 22;  // a stream that says too large a size takes no memory for it
  for (std::size_t done = 0; done < count;) {
    const std::size_t piece = std::min(kPiece, count - done);
    values.resize(std::max(values.size(), done + piece));
    if (!read_exactly(values.data() + done, piece * sizeof(Value))) return false;
    done += piece;
  }
  return true;
}

bool DepthStream::read(StreamFrame& frame) {
  if (in_.peek() == std::istream::traits_type::eof()) return false;
  const bool whole = read_exactly(&frame.timestamp_s, sizeof frame.timestamp_s) &&
                     (format_ == DepthFormat::uint16 ? read_values(frame.units, pixels()) : read_values(frame.metres, pixels()));
  if (!whole) throw Failure(fmt::format("standard input: ends within frame {}", frames_));
  ++frames_;
  return true;
}

DepthView DepthStream::view(const StreamFrame& frame) const {
  if (format_ == DepthFormat::float32) return DepthView::from_float(frame.metres.data(), camera_.width, camera_.height);
  return DepthView::from_uint16(frame.units.data(), camera_.width, camera_.height, camera_.depth_scale);
}

}  // namespace fransac::cli
