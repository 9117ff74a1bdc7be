// SPDX-License-Identifier: Apache-2.0
// Planes that keep their numbers while the camera moves, and its path: 04_track FOLDER
#include <cstdio>
#include <fransac/fransac.hpp>
#include <fransac/io/dataset.hpp>
#include <fransac/track/tracker.hpp>
#include <optional>

namespace io = fransac::io;

int fail(const fransac::Error& error) { return std::fprintf(stderr, "%s\n", error.message.c_str()), 1; }

int main(int argc, char** argv) {
  if (argc != 2) return std::fprintf(stderr, "usage: 04_track FOLDER\n"), 2;
  const auto files = io::list_frames(argv[1]);
  if (!files) return fail(files.error());
  fransac::Tracker tracker;
  fransac::TrackedFrame tracked;
  for (const auto& file : files->frames) {
    const auto frame = io::load_frame(file);
    if (!frame) return fail(frame.error());
    const auto found = fransac::segment(frame->view(), frame->camera);
    if (!found) return fail(found.error());
    const auto followed = tracker.update(*found, nullptr, std::nullopt, tracked);
    if (!followed) return fail(followed.error());
    const auto at = tracked.T_world_camera.translation();
    std::printf("%s: camera at %.3f %.3f %.3f, planes", frame->name.c_str(), at.x(), at.y(), at.z());
    for (const auto& plane : tracked.planes) std::printf(" %d", plane.id);
    std::printf("\n");
  }
  return 0;
}
