// SPDX-License-Identifier: Apache-2.0
// Frame after frame in the same memory: 02_stream FOLDER
#include <cstdio>
#include <fransac/fransac.hpp>
#include <fransac/io/dataset.hpp>

namespace io = fransac::io;

int fail(const fransac::Error& error) { return std::fprintf(stderr, "%s\n", error.message.c_str()), 1; }

int main(int argc, char** argv) {
  if (argc != 2) return std::fprintf(stderr, "usage: 02_stream FOLDER\n"), 2;
  const auto files = io::list_frames(argv[1]);
  if (!files) return fail(files.error());
  io::LoadWorkspace decoding;
  io::Frame frame;
  fransac::SegmentOptions options;
  fransac::Workspace workspace;
  fransac::Segmentation found;
  for (const auto& file : files->frames) {
    if (const auto loaded = io::load_frame(file, {}, decoding, frame); !loaded) return fail(loaded.error());
    const auto segmented = fransac::segment(frame.view(), frame.camera, options, workspace, found);
    if (!segmented) return fail(segmented.error());
    std::printf("%s: %zu planes in %.2f ms\n", frame.name.c_str(), found.planes.size(), found.timing.total_ms);
  }
  return 0;
}
