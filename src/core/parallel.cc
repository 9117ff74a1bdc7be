// SPDX-License-Identifier: Apache-2.0
#include "fransac/core/parallel.hpp"

#include <pthread.h>
#include <tbb/info.h>
#include <tbb/parallel_pipeline.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <exception>
#include <latch>
#include <memory>
#include <mutex>
#include <optional>
#include <thread>
#include <utility>
#include <vector>

namespace fransac {
namespace {

/// TBB takes some microseconds to tell.
int cores() {
  static const int count = tbb::info::default_concurrency();
  return count;
}

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

/// Threads that take indices from one that has some. Nobody waits for a thread that has not come yet: the caller takes indices
/// like the others, and waits only for those that others have begun.
class Team : public std::enable_shared_from_this<Team> {
 public:
  void run(int threads, std::size_t n, IndexFunction body) {
    const AwakeThreads awake(threads);
    for (std::size_t first = 0; first < n; first += kMostIndices) run_some(first, std::min(n - first, kMostIndices), body);
  }

  /// Until it is closed as often, helpers look for work, and find it within a microsecond. Where one cannot be had, the others do
  /// its work.
  void open(int threads) {
    if (opened_++ > 0) return;
    is_open_.store(true, std::memory_order_relaxed);
    for (int helpers = helpers_.load(std::memory_order_relaxed); helpers < threads - 1; ++helpers) {
      helpers_.fetch_add(1, std::memory_order_relaxed);
      try {
        start([team = shared_from_this()] { team->help(); });
      } catch (...) {
        helpers_.fetch_sub(1, std::memory_order_relaxed);
        return;
      }
    }
  }
  void close() {
    if (--opened_ == 0) is_open_.store(false, std::memory_order_relaxed);
  }

  /// Whether this thread is at work on an index: what it has in parallel then is done in order.
  static bool is_at_work() { return at_work_; }

 private:
  static constexpr std::uint64_t kMostIndices = (1U << 20) - 1;
  static constexpr int kIndexBits = 20;

  /// A word holds what there is to do: how many times there was something, how many indices, and which is next.
  void run_some(std::size_t first, std::uint64_t n, IndexFunction body) {
    body_.emplace(body);
    first_ = first;
    done_.store(0, std::memory_order_relaxed);
    ++times_;
    work_.store(times_ << (2 * kIndexBits) | n << kIndexBits, std::memory_order_release);
    while (take_one()) {
    }
    for (int waited = 0; done_.load(std::memory_order_acquire) < n; ++waited) pause(waited);
    if (error_) std::rethrow_exception(std::exchange(error_, nullptr));
  }

  bool take_one() {
    constexpr std::uint64_t kMask = (std::uint64_t{1} << kIndexBits) - 1;
    std::uint64_t work = work_.load(std::memory_order_acquire);
    do {
      if ((work & kMask) >= (work >> kIndexBits & kMask)) return false;
    } while (!work_.compare_exchange_weak(work, work + 1, std::memory_order_acq_rel, std::memory_order_acquire));
    at_work_ = true;
    try {
      (*body_)(first_ + static_cast<std::size_t>(work & kMask));
    } catch (...) {
      const std::lock_guard lock(error_mutex_);
      error_ = std::current_exception();
    }
    at_work_ = false;
    done_.fetch_add(1, std::memory_order_acq_rel);
    return true;
  }

  /// Stays a little longer than it must: the next frame of a stream that is done as fast as can be finds it awake.
  void help() {
    using Clock = std::chrono::steady_clock;
    constexpr std::chrono::microseconds kLinger(200);
    Clock::time_point since = Clock::now();
    for (int waited = 0; is_open_.load(std::memory_order_relaxed) || Clock::now() - since < kLinger; ++waited) {
      if (take_one()) {
        waited = 0;
      } else {
        pause(waited);
      }
      if (is_open_.load(std::memory_order_relaxed)) since = Clock::now();
    }
    helpers_.fetch_sub(1, std::memory_order_release);
  }

  /// Another thread that needs the core gets it.
  static void pause(int waited) {
    constexpr int kOften = 1000;
    if (waited < kOften) {
      relax();
    } else {
      std::this_thread::yield();
    }
  }

  /// Says to the core that this thread waits.
  static void relax() {
#if defined(__x86_64__) || defined(__i386__)
    __builtin_ia32_pause();
#elif defined(__aarch64__)
    asm volatile("yield");                                                 // NOLINT(hicpp-no-assembler)
#endif
  }

  /// On one of TBB's threads, which it makes once and shares among all who call it.
  template <class Function>
  static void start(Function function) {
#ifdef __SANITIZE_THREAD__
    std::thread(function).detach();  // the thread sanitizer does not see how TBB, built without it, passes work on
#else
    static tbb::task_arena& arena = *new tbb::task_arena(cores() - 1, 0);  // helpers may outlive statics
    arena.enqueue(function);
#endif
  }

  std::atomic<std::uint64_t> work_{0};
  std::atomic<std::uint64_t> done_{0};
  std::atomic<int> helpers_{0};  ///< Started, and not gone.
  std::atomic<bool> is_open_{false};
  int opened_ = 0;  ///< Times; of the owner's thread.
  std::uint64_t times_ = 0;
  std::optional<IndexFunction> body_;
  std::size_t first_ = 0;
  std::mutex error_mutex_;
  std::exception_ptr error_;
  inline static thread_local bool at_work_ = false;
};

/// A thread's own.
Team& team() {
  thread_local const std::shared_ptr<Team> team = std::make_shared<Team>();
  return *team;
}

/// How many threads may work together. An arena of more threads than TBB has makes it print a warning.
int count_of(int threads) {
  if (threads == 1) return 1;
  const int count = std::min(resolve_threads(threads), cores());
  return count > 1 && !Team::is_at_work() && can_make_threads(count - 1) ? count : 1;
}

void run_one_by_one(IndexPredicate next, std::span<const PipelineStage> stages) {
  while (next(0)) {
    for (const PipelineStage& stage : stages) stage.run(0);
  }
}

}  // namespace

int resolve_threads(int threads) { return threads > 0 ? threads : cores(); }

void parallel_for(int threads, std::size_t n, IndexFunction body) {
  const int count = n > 1 ? count_of(threads) : 1;
  if (count == 1) {
    for (std::size_t i = 0; i < n; ++i) body(i);
  } else {
    team().run(count, n, body);
  }
}

AwakeThreads::AwakeThreads(int threads) {
  const int count = count_of(threads);
  is_open_ = count > 1;
  if (is_open_) team().open(count);
}

AwakeThreads::~AwakeThreads() {
  if (is_open_) team().close();
}

void run_pipeline(int threads, std::size_t slots, IndexPredicate next, std::span<const PipelineStage> stages) {
  const int count = std::min(resolve_threads(threads), cores());
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
