// SPDX-License-Identifier: Apache-2.0
/// Numbers for the leaves that the rows of a depth camera enter, one run of pixels after the other.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <memory>
#include <new>
#include <optional>

#include "fransac/core/aligned.hpp"

namespace fransac {

/// Leaf numbers by key, counted from 0 in the order in which keys are first seen. Keys have the index along x in their lowest
/// bits; space is cut into bars of 64 leaves along x, and a bar that is entered gets a block of 64 numbers. There is nothing to
/// search and hardly anything to predict, and as rows follow each other their bars stay in the first-level cache.
///
/// What an earlier frame wrote is told by its stamps, so nothing is cleared between frames.
class LeafBars {
 public:
  static constexpr int kLeafBits = 6;   ///< Of a key, for the place in the bar.
  static constexpr int kMostBits = 28;  ///< Of a key: the table of bars has 16 MiB then, mostly never touched.

  /// Forgets all keys.
  void forget() {
    first_leaf_ += leaves_;
    first_block_ += blocks_;
    leaves_ = 0;
    blocks_ = 0;
  }

  /// The same; keys will have `key_bits` bits.
  void restart(int key_bits) {
    constexpr std::uint32_t kMostStamps = std::uint32_t{1} << 31;
    forget();
    const std::size_t bars = std::size_t{1} << (key_bits - kLeafBits);
    if (bars > size_ || first_leaf_ >= kMostStamps) {
      // Zeros that cost nothing until they are touched; most bars never are.
      bars_.reset(static_cast<std::uint32_t*>(std::calloc(bars, sizeof(std::uint32_t))));  // NOLINT(cppcoreguidelines-no-malloc)
      size_ = bars_ ? bars : 0;
      if (!bars_) throw std::bad_alloc();
      numbers_.assign(numbers_.size(), 0);
      first_leaf_ = 1;
      first_block_ = 1;
    }
  }

  [[nodiscard]] std::uint32_t leaves() const { return leaves_; }

  [[nodiscard]] std::optional<std::uint32_t> number_of(std::uint32_t key) const {
    const std::uint32_t block = bars_[key >> kLeafBits] - first_block_;
    if (block >= blocks_) return std::nullopt;
    const std::uint32_t known = numbers_[(block << kLeafBits) + (key & kInBar)] - first_leaf_;
    return known < leaves_ ? std::optional(known) : std::nullopt;
  }

  /// Looks up the keys of one row: a copy of the table's state that stays in registers.
  class Row {
   public:
    explicit Row(LeafBars& bars)
        : bars_(&bars),
          blocks_(bars.bars_.get()),
          numbers_(bars.numbers_.data()),
          first_leaf_(bars.first_leaf_),
          leaves_(bars.leaves_) {}
    Row(const Row&) = delete;
    Row& operator=(const Row&) = delete;
    ~Row() { bars_->leaves_ = leaves_; }

    [[nodiscard]] std::uint32_t leaves() const { return leaves_; }

    std::uint32_t number_of(std::uint32_t key) {
      std::uint32_t block = blocks_[key >> kLeafBits] - bars_->first_block_;
      if (block >= bars_->blocks_) block = enter(key >> kLeafBits);
      std::uint32_t& stamp = numbers_[(block << kLeafBits) + (key & kInBar)];
      // Whether a leaf is new cannot be predicted, so it must not become a branch.
      const std::uint32_t known = stamp - first_leaf_;
      const std::uint32_t old = 0U - static_cast<std::uint32_t>(known < leaves_);
      const std::uint32_t number = (known & old) | (leaves_ & ~old);
      leaves_ += 1U + old;
      stamp = number + first_leaf_;
      return number;
    }

   private:
    /// A new block for a bar; happens once for some tens of runs.
    std::uint32_t enter(std::uint32_t bar) {
      const std::uint32_t block = bars_->blocks_++;
      blocks_[bar] = block + bars_->first_block_;
      const std::size_t needed = std::size_t{bars_->blocks_} << kLeafBits;
      if (needed > bars_->numbers_.size()) {
        bars_->numbers_.resize(2 * needed, 0);
        numbers_ = bars_->numbers_.data();
      }
      return block;
    }

    LeafBars* bars_;
    std::uint32_t* blocks_;
    std::uint32_t* numbers_;
    std::uint32_t first_leaf_;
    std::uint32_t leaves_;
  };

 private:
  static constexpr std::uint32_t kInBar = (1U << kLeafBits) - 1;

  struct Free {
    void operator()(void* p) const { std::free(p); }  // NOLINT(cppcoreguidelines-no-malloc)
  };

  std::unique_ptr<std::uint32_t[], Free> bars_;  ///< By bar: first_block_ plus its block; smaller when not of this frame.
  std::size_t size_ = 0;
  AlignedVector<std::uint32_t> numbers_;  ///< By block and place in it: first_leaf_ plus the leaf's number; smaller likewise.
  std::uint32_t first_leaf_ = 1;
  std::uint32_t first_block_ = 1;
  std::uint32_t leaves_ = 0;
  std::uint32_t blocks_ = 0;
};

}  // namespace fransac
