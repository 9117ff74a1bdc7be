// SPDX-License-Identifier: Apache-2.0
/// What a user of a library would write around it to have labels for all pixels. Compiled with its caller.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numeric>
#include <vector>

#include "peer.hpp"

namespace fransac::bench {

inline constexpr std::uint8_t kNoDepth = 0;
inline constexpr std::uint8_t kFirstPlane = 1;
inline constexpr std::uint8_t kNoPlane = 255;

/// Labels a cloud's points by their distance to a plane; `xyz(i, x, y, z)` reads point i, `pixel(i)` is its place in the labels.
/// Returns the number of inliers. Points outside the limits along z are on no plane.
template <class Xyz, class Pixel>
std::size_t label_by_distance(std::size_t points, const double (&plane)[4], double farthest_m, Xyz&& xyz, Pixel&& pixel,
                              std::vector<std::uint8_t>& labels) {
  const auto a = static_cast<float>(plane[0]);
  const auto b = static_cast<float>(plane[1]);
  const auto c = static_cast<float>(plane[2]);
  const auto d = static_cast<float>(plane[3]);
  const auto threshold = static_cast<float>(kThreshold_m);
  const auto farthest = static_cast<float>(farthest_m);
  std::fill(labels.begin(), labels.end(), kNoDepth);
  std::size_t inliers = 0;
  for (std::size_t i = 0; i < points; ++i) {
    float x = 0.0F;
    float y = 0.0F;
    float z = 0.0F;
    xyz(i, x, y, z);
    const bool inlier = std::abs(a * x + b * y + c * z + d) <= threshold && z <= farthest;
    labels[pixel(i)] = inlier ? kFirstPlane : kNoPlane;
    inliers += inlier ? 1 : 0;
  }
  return inliers;
}

/// The same from a list of inliers.
template <class Indices, class Pixel>
std::size_t label_by_index(const Frame& frame, const Indices& inliers, Pixel&& pixel, std::vector<std::uint8_t>& labels) {
  if (frame.depth == nullptr) {
    std::fill(labels.begin(), labels.end(), kNoPlane);
  } else {
    std::transform(frame.depth, frame.depth + frame.size(), labels.begin(),
                   [](std::uint16_t z) { return z == 0 ? kNoDepth : kNoPlane; });
  }
  for (const auto i : inliers) labels[pixel(static_cast<std::size_t>(i))] = kFirstPlane;
  return inliers.size();
}

/// Numbers planes anew, most pixels first; returns their pixel counts in the new order.
inline std::vector<std::size_t> order_by_size(std::vector<std::uint8_t>& labels) {
  std::array<std::size_t, 256> count{};
  for (const std::uint8_t label : labels) ++count[label];
  std::array<std::uint8_t, 256> order{};
  std::iota(order.begin(), order.end(), std::uint8_t{0});
  std::stable_sort(order.begin() + 1, order.end() - 1, [&](std::uint8_t a, std::uint8_t b) { return count[a] > count[b]; });
  std::array<std::uint8_t, 256> renamed{};
  std::vector<std::size_t> sizes;
  renamed[kNoPlane] = kNoPlane;
  for (std::size_t rank = 1; rank < kNoPlane && count[order[rank]] > 0; ++rank) {
    renamed[order[rank]] = static_cast<std::uint8_t>(rank);
    sizes.push_back(count[order[rank]]);
  }
  for (std::uint8_t& label : labels) label = renamed[label];
  return sizes;
}

}  // namespace fransac::bench
