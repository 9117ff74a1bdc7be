// SPDX-License-Identifier: Apache-2.0
/// Counter-based random numbers: a stream is a pure function of (seed, index).
#pragma once

#include <array>
#include <cstdint>

namespace fransac {

/// One block of Philox4x32-10 (Salmon, Moraes, Dror, Shaw, "Parallel random numbers: as easy as 1, 2, 3", SC 2011).
std::array<std::uint32_t, 4> philox4x32(std::array<std::uint32_t, 4> counter, std::array<std::uint32_t, 2> key);

/// The stream number `index` of a seed. Streams of different indices are independent, so work item i may draw from
/// stream i on any thread and in any order and the answer stays the same.
class RandomStream {
 public:
  /// Costs nothing until the first number is drawn.
  RandomStream(std::uint64_t seed, std::uint64_t index) : seed_(seed), index_(index) {}

  /// 32 uniform bits.
  std::uint32_t next();
  /// Uniform in [0, bound), without bias (Lemire, "Fast random integer generation in an interval", 2019). bound > 0.
  std::uint32_t below(std::uint32_t bound);
  /// Uniform in [0, 1) with 32 bits.
  double uniform();
  /// Standard normal (Box and Muller 1958).
  double normal();

 private:
  std::uint64_t seed_;
  std::uint64_t index_;
  std::uint64_t block_ = 0;
  std::array<std::uint32_t, 4> buffer_{};
  int used_ = 4;
};

}  // namespace fransac
