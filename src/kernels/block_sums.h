// SPDX-License-Identifier: Apache-2.0
// Sums as kernels add them up, for their scalar twins: by a value's place in its block, and then the two halves of the places,
// again and again. Whatever the width of a vector, it is a part of a block, so that all instruction sets add in this order.
#pragma once

#include <array>
#include <cstddef>

namespace fransac::kernels {

/// Adds up the places' sums, which it changes. `N` is a power of two.
template <std::size_t N, class Number>
Number total_of_places(Number* places) {
  for (std::size_t half = N / 2; half > 0; half /= 2) {
    for (std::size_t i = 0; i < half; ++i) places[i] += places[i + half];
  }
  return places[0];
}

namespace ref {

template <class Number, std::size_t N>
class BlockSum {
 public:
  void add(std::size_t i, Number value) { places_[i % N] += value; }
  [[nodiscard]] Number total() const {
    std::array<Number, N> places = places_;
    return total_of_places<N>(places.data());
  }

 private:
  std::array<Number, N> places_{};
};

}  // namespace ref
}  // namespace fransac::kernels
