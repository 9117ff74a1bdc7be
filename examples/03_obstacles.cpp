// SPDX-License-Identifier: Apache-2.0
// What stands on the floor or falls away from it, nearest first: 03_obstacles DEPTH
#include <cstdio>
#include <fransac/fransac.hpp>
#include <fransac/io/dataset.hpp>
#include <fransac/obstacles/obstacles.hpp>

namespace io = fransac::io;

int fail(const fransac::Error& error) { return std::fprintf(stderr, "%s\n", error.message.c_str()), 1; }

int main(int argc, char** argv) {
  if (argc != 2) return std::fprintf(stderr, "usage: 03_obstacles DEPTH\n"), 2;
  const auto files = io::list_frames(argv[1]);
  if (!files) return fail(files.error());
  const auto frame = io::load_frame(files->frames.front());
  if (!frame) return fail(frame.error());
  const auto planes = fransac::segment(frame->view(), frame->camera);
  if (!planes) return fail(planes.error());
  const auto found = fransac::find_obstacles(frame->view(), frame->camera, *planes);
  if (!found) return fail(found.error());
  if (found->support.empty()) return std::printf("no floor is seen: stop\n"), 0;
  for (const auto& obstacle : found->obstacles) {
    const auto& box = obstacle.box;
    std::printf("%s: %.2f m ahead, %.2f m to the left, %.2f x %.2f x %.2f m\n", fransac::enum_name(obstacle.kind).data(),
                box.centre.x(), box.centre.y(), box.size.x(), box.size.y(), box.size.z());
  }
  return 0;
}
