// SPDX-License-Identifier: Apache-2.0
/// The one place where threads are made.
#pragma once

#include <cstddef>
#include <memory>
#include <span>
#include <type_traits>

namespace fransac {

/// A reference to a callable of a `std::size_t`: no allocation, valid while the callable lives.
template <class Result>
class IndexCallable {
 public:
  /// Refers to `function`, which must outlive this.
  template <class F, class = std::enable_if_t<!std::is_same_v<std::decay_t<F>, IndexCallable>>>
  IndexCallable(F&& function)  // NOLINT(google-explicit-constructor,bugprone-forwarding-reference-overload)
      : object_(const_cast<void*>(static_cast<const void*>(std::addressof(function)))),
        call_([](void* object, std::size_t i) -> Result { return (*static_cast<std::remove_reference_t<F>*>(object))(i); }) {}
  Result operator()(std::size_t i) const { return call_(object_, i); }  ///< Calls it.

 private:
  void* object_;
  Result (*call_)(void*, std::size_t);
};
/// Does something with an index.
using IndexFunction = IndexCallable<void>;
/// Says something of an index.
using IndexPredicate = IndexCallable<bool>;

/// Calls `body(i)` for i in [0, n), on up to `threads` threads (0: all cores, 1: here, in order). Returns when all are
/// done. What `body` computes must depend on i only; then the number of threads changes nothing but time. Where the system makes
/// no more threads it works here, in order.
void parallel_for(int threads, std::size_t n, IndexFunction body);

/// While one lives, the threads that help its thread's calls of parallel_for stay awake: they find work within a microsecond,
/// where waking them takes some tens, and keep a core busy meanwhile.
class AwakeThreads {
 public:
  explicit AwakeThreads(int threads);  ///< As many as in those calls.
  ~AwakeThreads();
  AwakeThreads(const AwakeThreads&) = delete;
  AwakeThreads& operator=(const AwakeThreads&) = delete;

 private:
  bool is_open_;
};

/// One step of what is done to every item of a stream.
struct PipelineStage {
  IndexFunction run;             ///< Of a slot.
  bool several_at_once = false;  ///< Whether items may overtake each other here; else one after the other, in order.
};

/// Takes items through stages, several on their way at once, on up to `threads` threads (0: all cores, 1: here, one by one).
/// `next` puts the next item into a slot, [0, slots), and says whether there was one. No more than `slots` are on their way, so
/// that a slow stage slows `next` down. The last stage must be in order. An exception ends it and is thrown on.
void run_pipeline(int threads, std::size_t slots, IndexPredicate next, std::span<const PipelineStage> stages);

/// The number of threads that `threads` stands for: itself, or the number of cores for 0.
int resolve_threads(int threads);

}  // namespace fransac
