// SPDX-License-Identifier: Apache-2.0
/// Disjoint sets as a forest (Galler & Fischer 1964, with the halving of paths of Tarjan & van Leeuwen 1984): `parents[i]` leads
/// to the least number of i's set, which is its own parent and goes for the set.
#pragma once

#include <algorithm>

namespace fransac {

/// The least number of the set that `i` belongs to.
template <class Index>
Index root_of(Index* parents, Index i) {
  while (parents[i] != i) i = parents[i] = parents[parents[i]];
  return i;
}

/// Makes one set of those that have the roots `a` and `b`.
template <class Index>
void join_roots(Index* parents, Index a, Index b) {
  const auto [low, high] = std::minmax(a, b);
  parents[high] = low;
}

}  // namespace fransac
