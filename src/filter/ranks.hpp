// SPDX-License-Identifier: Apache-2.0
/// Places of numbers in order.
#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>

#include "fransac/core/aligned.hpp"

namespace fransac {

/// A set of whole numbers that says of each how many are smaller: a bit for each number, and a count for each word of bits.
class Ranks {
 public:
  /// Forgets all; numbers will be below `end`.
  void restart(std::size_t end) {
    words_.assign(end / kBits + 1, 0);
    before_.resize(words_.size());
  }
  void add(std::uint32_t number) { words_[number / kBits] |= std::uint64_t{1} << number % kBits; }
  /// After the last was added.
  void count_up() {
    std::uint32_t before = 0;
    for (std::size_t i = 0; i < words_.size(); ++i) {
      before_[i] = before;
      before += static_cast<std::uint32_t>(std::popcount(words_[i]));
    }
  }
  /// Of a number that is in the set.
  [[nodiscard]] std::uint32_t of(std::uint32_t number) const {
    const std::uint64_t smaller = words_[number / kBits] & ((std::uint64_t{1} << number % kBits) - 1);
    return before_[number / kBits] + static_cast<std::uint32_t>(std::popcount(smaller));
  }

 private:
  static constexpr std::uint32_t kBits = 64;
  AlignedVector<std::uint64_t> words_;
  AlignedVector<std::uint32_t> before_;
};

}  // namespace fransac
