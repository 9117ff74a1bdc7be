// SPDX-License-Identifier: Apache-2.0
#include "fransac/core/parallel.hpp"

#include <tbb/info.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <algorithm>

namespace fransac {

int resolve_threads(int threads) { return threads > 0 ? threads : tbb::info::default_concurrency(); }

void parallel_for(int threads, std::size_t n, IndexFunction body) {
  // An arena of more threads than TBB has makes it print a warning.
  const int count = std::min(resolve_threads(threads), tbb::info::default_concurrency());
  if (count == 1 || n <= 1) {
    for (std::size_t i = 0; i < n; ++i) body(i);
    return;
  }
  tbb::task_arena arena(count);
  arena.execute([&] { tbb::parallel_for(std::size_t{0}, n, [&](std::size_t i) { body(i); }); });
}

}  // namespace fransac
