// SPDX-License-Identifier: Apache-2.0
// Frames from a pipe: any bytes are a valid camera and whole frames, no more than the bytes hold, or a message that names
// standard input.
#include <cstddef>
#include <cstdint>
#include <sstream>
#include <string>

#include "depth_stream.hpp"
#include "errors.hpp"
#include "require.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace fransac;
  using namespace fransac::fuzz;
  const io::ReadLimits limits{1 << 16};
  std::istringstream in(std::string(reinterpret_cast<const char*>(data), size));
  try {
    cli::DepthStream stream(in, limits);
    const Camera& camera = stream.camera();
    require(validate(camera).ok());
    const auto pixels = static_cast<std::size_t>(camera.width) * static_cast<std::size_t>(camera.height);
    require(pixels <= limits.max_size);
    cli::StreamFrame frame;
    for (std::size_t frames = 1; stream.read(frame); ++frames) {
      require(validate(stream.view(frame)).ok() && frame.units.size() + frame.metres.size() == pixels);
      require(frames * pixels * sizeof(std::uint16_t) <= size);
    }
  } catch (const cli::Failure& failure) {
    require_message({ErrorCode::format, failure.what()}, "standard input: ");
  }
  return 0;
}
