// SPDX-License-Identifier: Apache-2.0
// The planes of a depth image, and a picture of them: 01_segment DEPTH PICTURE.png
#include <cstdio>
#include <fransac/fransac.hpp>
#include <fransac/io/dataset.hpp>
#include <fransac/io/image.hpp>
#include <fransac/io/overlay.hpp>

namespace io = fransac::io;

int fail(const fransac::Error& error) { return std::fprintf(stderr, "%s\n", error.message.c_str()), 1; }

int main(int argc, char** argv) {
  if (argc != 3) return std::fprintf(stderr, "usage: 01_segment DEPTH PICTURE.png\n"), 2;
  const auto files = io::list_frames(argv[1]);
  if (!files) return fail(files.error());
  const auto frame = io::load_frame(files->frames.front());
  if (!frame) return fail(frame.error());

  const auto found = fransac::segment(frame->view(), frame->camera);
  if (!found) return fail(found.error());
  for (const auto& plane : found->planes) {
    std::printf("plane %d: %s, %.2f m2, %.2f m away\n", plane.id, fransac::enum_name(plane.kind).data(), plane.area_m2,
                plane.plane.d);
  }
  const auto written = io::write_png(argv[2], io::overlay(frame->view(), found->labels, nullptr));
  return written ? 0 : fail(written.error());
}
