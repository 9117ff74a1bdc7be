// SPDX-License-Identifier: Apache-2.0
/// The one place where threads are made.
#pragma once

#include <cstddef>
#include <memory>
#include <type_traits>

namespace fransac {

/// A reference to a callable `void(std::size_t)`: no allocation, valid while the callable lives.
class IndexFunction {
 public:
  template <class F, class = std::enable_if_t<!std::is_same_v<std::decay_t<F>, IndexFunction>>>
  IndexFunction(F&& function)  // NOLINT(google-explicit-constructor,bugprone-forwarding-reference-overload)
      : object_(const_cast<void*>(static_cast<const void*>(std::addressof(function)))),
        call_([](void* object, std::size_t i) { (*static_cast<std::remove_reference_t<F>*>(object))(i); }) {}
  void operator()(std::size_t i) const { call_(object_, i); }

 private:
  void* object_;
  void (*call_)(void*, std::size_t);
};

/// Calls `body(i)` for i in [0, n), on up to `threads` threads (0: all cores, 1: here, in order). Returns when all are
/// done. What `body` computes must depend on i only; then the number of threads changes nothing but time.
void parallel_for(int threads, std::size_t n, IndexFunction body);

/// The number of threads that `threads` stands for: itself, or the number of cores for 0.
int resolve_threads(int threads);

}  // namespace fransac
