// SPDX-License-Identifier: Apache-2.0
// Where the system makes no more threads, work that was to be shared is done by the one that asked. In a process of its own, for
// the limit cannot be taken back.
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <unistd.h>

#include <atomic>
#include <cstdlib>
#include <system_error>
#include <thread>

#include "fransac/core/parallel.hpp"
#include "support.hpp"

namespace fransac {
namespace {

constexpr int kThreads = 16;

enum Outcome { kDone, kNoLimit, kWrong };

/// The superuser's threads are not counted.
bool forbid_threads() {
  constexpr uid_t kNobody = 65534;
  const rlimit none{0, 0};
  if (::setrlimit(RLIMIT_NPROC, &none) != 0) return false;
  if (::geteuid() == 0 && ::setuid(kNobody) != 0) return false;
  try {
    std::thread([] {}).join();
  } catch (const std::system_error&) {
    return true;
  }
  return false;
}

bool segments() {
  testing::FloatImage image(testing::small_camera());
  image.draw(Plane{Eigen::Vector3d(0.0, 0.0, -1.0), 2.0});
  for (const Method method : {Method::cells, Method::fransac, Method::ransac}) {
    SegmentOptions options;
    options.method = method;
    options.threads = kThreads;
    const Result<Segmentation> found = segment(image.view(), image.camera, options);
    if (!found || found->planes.size() != 1) return false;
  }
  return true;
}

bool runs_in_parallel_and_in_a_pipeline() {
  std::atomic<int> done{0};
  parallel_for(kThreads, 100, [&](std::size_t) { ++done; });
  int left = 100;
  const auto count = [&](std::size_t) { ++done; };
  const PipelineStage stages[] = {{count, true}, {count, false}};
  run_pipeline(
      kThreads, 8, [&](std::size_t) { return left-- > 0; }, stages);
  return done == 300;
}

TEST(NoThreads, WorkIsDoneByTheOneThatAsked) {
  GTEST_FLAG_SET(death_test_style, "threadsafe");
  EXPECT_EXIT(
      {
        const bool limited = forbid_threads();
        const bool right = runs_in_parallel_and_in_a_pipeline() && segments();
        std::_Exit(!right ? kWrong : limited ? kDone : kNoLimit);
      },
      ([](int status) {
        if (!WIFEXITED(status)) return false;
        if (WEXITSTATUS(status) == kNoLimit) std::fputs("no limit of threads here\n", stderr);
        return WEXITSTATUS(status) == kDone || WEXITSTATUS(status) == kNoLimit;
      }),
      "");
}

}  // namespace
}  // namespace fransac
