// SPDX-License-Identifier: Apache-2.0
/// Sums that do not depend on the number of threads.
#pragma once

#include <cstddef>
#include <vector>

#include "fransac/core/parallel.hpp"

namespace fransac {

/// part(0) + part(1) + … + part(n - 1), added up in this order on any number of threads. `Sum{}` is zero.
template <class Sum, class Part>
Sum parallel_sum(int threads, std::size_t n, const Part& part) {
  Sum sum{};
  if (n <= 1 || resolve_threads(threads) == 1) {
    for (std::size_t i = 0; i < n; ++i) sum += part(i);
    return sum;
  }
  std::vector<Sum> parts(n);
  parallel_for(threads, n, [&](std::size_t i) { parts[i] = part(i); });
  for (const Sum& p : parts) sum += p;
  return sum;
}

}  // namespace fransac
