// SPDX-License-Identifier: Apache-2.0
/// Numbers for the leaves of a grid.
#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <optional>

#include "fransac/core/aligned.hpp"

namespace fransac {

/// Leaf numbers by key, counted from 0 in the order in which keys are first seen: a flat table with open addressing. Keys hold
/// the index along x in their lowest bits; eight neighbours along x share a cache line or two, because the next leaf that a
/// row of pixels enters is mostly the next one along x.
///
/// Slots of an earlier frame are told by their stamp, so nothing is cleared between frames.
template <class Key>
class LeafTable {
 public:
  LeafTable() { slots_.assign(std::size_t{1} << 8, Slot{}); }

  /// Forgets all keys.
  void restart() {
    constexpr std::uint32_t kMostStamps = std::uint32_t{1} << 31;
    base_ += size_;
    size_ = 0;
    if (base_ < kMostStamps) return;
    slots_.assign(slots_.size(), Slot{});
    base_ = 1;
  }

  [[nodiscard]] std::uint32_t size() const { return size_; }

  [[nodiscard]] std::optional<std::uint32_t> number_of(Key key) const {
    const Slot& slot = slots_[find(key)];
    if (!live(slot)) return std::nullopt;
    return slot.stamp - base_;
  }

  std::uint32_t find_or_add(Key key) {
    if (4 * std::size_t{size_} >= slots_.size()) grow();
    Slot& slot = slots_[find(key)];
    // Whether a leaf is new cannot be predicted, so it is no branch.
    const bool is_new = !live(slot);
    const std::uint32_t stamp = is_new ? base_ + size_ : slot.stamp;
    slot = {key, stamp};
    size_ += static_cast<std::uint32_t>(is_new);
    return stamp - base_;
  }

 private:
  struct Slot {
    Key key = 0;
    std::uint32_t stamp = 0;  ///< base_ plus the leaf's number; smaller in slots of earlier frames.
  };

  [[nodiscard]] bool live(const Slot& slot) const { return slot.stamp - base_ < size_; }

  /// Where the key is, or where it belongs.
  [[nodiscard]] std::size_t find(Key key) const {
    constexpr std::uint64_t kFibonacci = 0x9E3779B97F4A7C15;  // 2^64 / golden ratio (Knuth, TAOCP 3, 6.4)
    constexpr unsigned kNeighbours = 8;
    constexpr std::size_t kNextGroup = kNeighbours + 1;  // odd: reaches every slot
    const std::size_t mask = slots_.size() - 1;
    const std::uint64_t group = (static_cast<std::uint64_t>(key) / kNeighbours) * kFibonacci;
    std::size_t i = (static_cast<std::size_t>(group >> std::countl_zero(mask)) & ~std::size_t{kNeighbours - 1}) |
                    static_cast<std::size_t>(key % kNeighbours);
    while (live(slots_[i]) && slots_[i].key != key) i = (i + kNextGroup) & mask;
    return i;
  }

  void grow() {
    AlignedVector<Slot> old(2 * slots_.size(), Slot{});
    old.swap(slots_);
    for (const Slot& slot : old) {
      if (live(slot)) slots_[find(slot.key)] = slot;
    }
  }

  AlignedVector<Slot> slots_;
  std::uint32_t base_ = 1;
  std::uint32_t size_ = 0;
};

}  // namespace fransac
