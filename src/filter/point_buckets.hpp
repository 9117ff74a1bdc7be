// SPDX-License-Identifier: Apache-2.0
/// Points of a cloud in any order, brought into one in which points of a leaf are near each other in memory.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "fransac/core/aligned.hpp"
#include "fransac/core/parallel.hpp"
#include "kernels/points.h"

namespace fransac {

/// Points that are looked at together: what is made of them fits into the first-level cache.
inline constexpr std::size_t kStretch = 256;

/// Points with x, y and z side by side, all finite.
struct Stretch {
  const float* points;
  std::size_t stride;
  std::size_t size;
  const std::uint32_t* numbers;  ///< What these are called in the cloud; null: `first` and those that follow it.
  std::size_t first;

  [[nodiscard]] std::uint32_t number(std::size_t i) const {
    return numbers == nullptr ? static_cast<std::uint32_t>(first + i) : numbers[i];
  }
};

/// Where points are made into stretches that do not lie in memory like that.
struct StretchBuffer {
  static constexpr std::size_t kStride = 4;
  std::array<float, kStretch * kStride> points;
  std::array<std::uint32_t, kStretch> numbers;
};

/// Points sorted by the bucket of their leaf (kernels::leaf_buckets), in the cloud's order within each. Going through a cloud in
/// any order, every look-up of a leaf misses the caches; a bucket's leaves stay in them.
class PointBuckets {
 public:
  static constexpr std::size_t kBuckets = 256;

  /// Sorts the points [begin, end). `threads` never changes the result.
  template <class Stretches>
  void sort(const Stretches& stretches, const kernels::Lattice& lattice, std::size_t begin, std::size_t end, int threads) {
    const std::size_t tasks = (end - begin + kTaskPoints - 1) / kTaskPoints;
    bucket_of_.resize(end - begin);
    next_.resize(tasks);
    const auto for_each_stretch = [&](std::size_t task, const auto& body) {
      StretchBuffer buffer;
      const std::size_t last = std::min(end, begin + (task + 1) * kTaskPoints);
      for (std::size_t first = begin + task * kTaskPoints; first < last; first += kStretch) {
        body(stretches(first, std::min(kStretch, last - first), buffer), bucket_of_.data() + (first - begin));
      }
    };
    parallel_for(threads, tasks, [&](std::size_t task) {
      Positions& counts = next_[task];
      counts.fill(0);
      for_each_stretch(task, [&](const Stretch& stretch, std::uint8_t* bucket) {
        kernels::leaf_buckets(stretch.points, stretch.stride, stretch.size, lattice, bucket);
        for (std::size_t i = 0; i < stretch.size; ++i) ++counts[bucket[i]];
      });
    });
    count_up();
    parallel_for(threads, tasks, [&](std::size_t task) {
      Positions next = next_[task];
      for_each_stretch(task, [&](const Stretch& stretch, const std::uint8_t* bucket) {
        for (std::size_t i = 0; i < stretch.size; ++i) {
          const float* const from = stretch.points + i * stretch.stride;
          points_[next[bucket[i]]++] = {{from[0], from[1], from[2]}, stretch.number(i)};
        }
      });
    });
  }

  /// The first point of a bucket; of kBuckets the number of all.
  [[nodiscard]] std::size_t first_of(std::size_t bucket) const { return first_[bucket]; }

  /// The sorted points, as stretches.
  Stretch operator()(std::size_t first, std::size_t size, StretchBuffer& buffer) const {
    const Point* const points = points_.data() + first;
    for (std::size_t i = 0; i < size; ++i) buffer.numbers[i] = points[i].number;
    return {points->xyz, StretchBuffer::kStride, size, buffer.numbers.data(), 0};
  }

 private:
  static constexpr std::size_t kTaskPoints = std::size_t{1} << 16;
  using Positions = std::array<std::uint32_t, kBuckets>;

  struct Point {
    float xyz[3];
    std::uint32_t number;
  };

  /// From how many points of each bucket each task has to where it puts them.
  void count_up() {
    std::uint32_t position = 0;
    for (std::size_t bucket = 0; bucket < kBuckets; ++bucket) {
      first_[bucket] = position;
      for (Positions& next : next_) {
        const std::uint32_t count = next[bucket];
        next[bucket] = position;
        position += count;
      }
    }
    first_[kBuckets] = position;
    if (points_.size() < position) points_.resize(position);
  }

  AlignedVector<Point> points_;
  AlignedVector<std::uint8_t> bucket_of_;
  std::vector<Positions> next_;
  std::array<std::uint32_t, kBuckets + 1> first_{};
};

}  // namespace fransac
