// SPDX-License-Identifier: Apache-2.0
#include "fransac/core/parallel.hpp"

#include <pthread.h>
#include <tbb/info.h>
#include <tbb/parallel_for.h>
#include <tbb/parallel_pipeline.h>
#include <tbb/partitioner.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <atomic>
#include <latch>
#include <optional>
#include <vector>
#ifdef __SANITIZE_THREAD__
#include <thread>
#endif

namespace fransac {
namespace {

/// Whether so many threads can be made beside this one. TBB throws, or ends the program, where it cannot make its own, and does
/// so with tasks on their way; so they are made first to see. Once made, TBB keeps them: only more than ever before are tried.
bool can_make_threads(int count) {
  static std::atomic<int> most_made{0};
  if (count <= most_made.load(std::memory_order_relaxed)) return true;
  std::latch all_made(1);
  std::vector<pthread_t> threads(static_cast<std::size_t>(count));
  const auto wait = [](void* latch) -> void* {
    static_cast<std::latch*>(latch)->wait();
    return nullptr;
  };
  std::size_t started = 0;
  while (started < threads.size() && ::pthread_create(&threads[started], nullptr, wait, &all_made) == 0) ++started;
  all_made.count_down();
  for (std::size_t i = 0; i < started; ++i) ::pthread_join(threads[i], nullptr);
  const bool made = started == threads.size();
  if (made) most_made.store(count, std::memory_order_relaxed);
  return made;
}

#ifdef __SANITIZE_THREAD__
// The thread sanitizer does not see how TBB, which is built without it, passes work from thread to thread, and reports
// each time that it does. Plain threads in its place let it watch the bodies.
void run_parallel(int threads, std::size_t n, IndexFunction body) {
  std::atomic<std::size_t> next{0};
  const auto work = [&] {
    for (std::size_t i = next++; i < n; i = next++) body(i);
  };
  std::vector<std::jthread> helpers;
  for (int t = 1; t < threads; ++t) helpers.emplace_back(work);
  work();
}
#else
void run_parallel(int threads, std::size_t n, IndexFunction body) {
  // Kept from call to call: waking an arena takes some microseconds, making one some tens. Not while it is at work: a call from
  // within a body runs in the arena that it finds itself in.
  thread_local std::optional<tbb::task_arena> arena;
  thread_local bool busy = false;
  const auto run = [&] {
    tbb::parallel_for(
        std::size_t{0}, n, [&](std::size_t i) { body(i); }, tbb::simple_partitioner());
  };
  if (busy) return run();
  if (!arena || arena->max_concurrency() != threads) arena.emplace(threads);
  busy = true;
  try {
    arena->execute(run);
  } catch (...) {
    busy = false;
    throw;
  }
  busy = false;
}
#endif

void run_one_by_one(IndexPredicate next, std::span<const PipelineStage> stages) {
  while (next(0)) {
    for (const PipelineStage& stage : stages) stage.run(0);
  }
}

}  // namespace

int resolve_threads(int threads) { return threads > 0 ? threads : tbb::info::default_concurrency(); }

void parallel_for(int threads, std::size_t n, IndexFunction body) {
  // An arena of more threads than TBB has makes it print a warning.
  const int count = std::min(resolve_threads(threads), tbb::info::default_concurrency());
  if (count == 1 || n <= 1 || !can_make_threads(count - 1)) {
    for (std::size_t i = 0; i < n; ++i) body(i);
    return;
  }
  run_parallel(count, n, body);
}

void run_pipeline(int threads, std::size_t slots, IndexPredicate next, std::span<const PipelineStage> stages) {
  const int count = std::min(resolve_threads(threads), tbb::info::default_concurrency());
#ifdef __SANITIZE_THREAD__
  constexpr bool kWatched = true;  // see run_parallel
#else
  constexpr bool kWatched = false;
#endif
  if (count == 1 || slots <= 1 || kWatched || !can_make_threads(count - 1)) return run_one_by_one(next, stages);
  // Items leave in the order in which they came and no more than `slots` are on their way: the slot of the one that came `slots`
  // items ago is free.
  std::size_t items = 0;
  tbb::filter<void, std::size_t> chain(tbb::filter_mode::serial_in_order, [&](tbb::flow_control& control) {
    const std::size_t slot = items++ % slots;
    if (!next(slot)) control.stop();
    return slot;
  });
  for (const PipelineStage& stage : stages) {
    chain &= tbb::filter<std::size_t, std::size_t>(
        stage.several_at_once ? tbb::filter_mode::parallel : tbb::filter_mode::serial_in_order, [&stage](std::size_t slot) {
          stage.run(slot);
          return slot;
        });
  }
  const tbb::filter<std::size_t, void> end(tbb::filter_mode::serial_in_order, [](std::size_t /*slot*/) {});
  tbb::task_arena arena(count);
  arena.execute([&] { tbb::parallel_pipeline(slots, chain & end); });
}

}  // namespace fransac
