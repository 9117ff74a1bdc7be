// SPDX-License-Identifier: Apache-2.0
// Loops on several threads: every index once, on as many threads as there are, whatever came before.
#include "fransac/core/parallel.hpp"

#include <gtest/gtest.h>

#include <atomic>
#include <stdexcept>
#include <thread>
#include <vector>

namespace fransac {
namespace {

void expect_each_once(int threads, std::size_t n) {
  std::vector<std::atomic<int>> times(n);
  parallel_for(threads, n, [&](std::size_t i) { ++times[i]; });
  for (std::size_t i = 0; i < n; ++i) ASSERT_EQ(times[i].load(), 1) << i << " of " << n << ", threads " << threads;
}

TEST(Parallel, DoesEveryIndexOnce) {
  for (const int threads : {0, 1, 2, 3, 7}) {
    for (const std::size_t n : {0U, 1U, 2U, 15U, 1000U}) expect_each_once(threads, n);
  }
}

/// More than what the word that hands indices out has room for.
TEST(Parallel, DoesMillionsOfIndices) { expect_each_once(2, (std::size_t{1} << 21) + 3); }

TEST(Parallel, DoesThemWhileThreadsAreAwake) {
  const AwakeThreads awake(2);
  const AwakeThreads again(0);
  for (std::size_t n = 0; n < 300; ++n) expect_each_once(2, n);
}

TEST(Parallel, DoesWhatIsWithinAnIndex) {
  std::vector<std::atomic<int>> times(20 * 30);
  parallel_for(0, 20, [&](std::size_t i) {
    const AwakeThreads awake(0);
    parallel_for(0, 30, [&](std::size_t k) { ++times[30 * i + k]; });
  });
  for (const std::atomic<int>& count : times) EXPECT_EQ(count.load(), 1);
}

/// The first is thrown on when all have ended, and the next loop is as if nothing had been.
TEST(Parallel, ThrowsWhatAnIndexThrows) {
  for (const int threads : {1, 2, 0}) {
    EXPECT_THROW(parallel_for(threads, 100,
                              [](std::size_t i) {
                                if (i % 10 == 3) throw std::runtime_error("no");
                              }),
                 std::runtime_error);
    expect_each_once(threads, 100);
  }
}

/// Each thread of a program has helpers of its own, and no loop waits for those of another.
TEST(Parallel, SeveralThreadsAtOnce) {
  std::atomic<std::size_t> done{0};
  std::vector<std::thread> callers;
  for (int k = 0; k < 4; ++k) {
    callers.emplace_back([&] {
      const AwakeThreads awake(2);
      for (int times = 0; times < 200; ++times) parallel_for(2, 17, [&](std::size_t) { ++done; });
    });
  }
  for (std::thread& caller : callers) caller.join();
  EXPECT_EQ(done.load(), std::size_t{4 * 200 * 17});
}

}  // namespace
}  // namespace fransac
