// SPDX-License-Identifier: Apache-2.0
/// How well labels agree with the truth, where planes on pixels that nobody judged are neither right nor wrong.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "fransac/core/labels.hpp"

namespace fransac::testing {

struct InstanceScore {
  int true_planes = 0;        ///< That have at least 0.5 % of the judged pixels.
  int false_planes = 0;       ///< Predicted, as large, judged on half of their pixels, and no true plane's at IoU 0.5.
  double f1_50 = 0.0;         ///< Instance F1 at IoU 0.5.
  double weighted_iou = 0.0;  ///< Mean over true planes, weighted by pixels, of the best IoU with a predicted one.
};

/// Judged pixels are those whose truth is not 0. Both images have one label a pixel, and equal sizes.
inline InstanceScore instance_score(std::span<const std::uint8_t> truth, std::span<const std::uint8_t> predicted) {
  constexpr double kMinShare = 0.005;
  constexpr double kIou = 0.5;
  using Counts = std::array<std::uint64_t, 256>;
  const auto both = std::make_unique<std::array<Counts, 256>>();
  Counts of_truth{};
  Counts of_predicted{};
  Counts whole{};
  std::uint64_t judged = 0;
  for (std::size_t i = 0; i < truth.size(); ++i) {
    ++whole[predicted[i]];
    if (truth[i] == 0) continue;
    ++judged;
    ++(*both)[truth[i]][predicted[i]];
    ++of_truth[truth[i]];
    ++of_predicted[predicted[i]];
  }
  const auto large = [&](const Counts& counts) {
    std::vector<std::size_t> labels;
    for (std::size_t label = kLabelFirst; label < kLabelNoPlane; ++label) {
      if (counts[label] > 0 && static_cast<double>(counts[label]) >= kMinShare * static_cast<double>(judged))
        labels.push_back(label);
    }
    return labels;
  };
  const auto iou = [&](std::size_t t, std::size_t p) {
    const std::uint64_t common = (*both)[t][p];
    return static_cast<double>(common) / static_cast<double>(of_truth[t] + of_predicted[p] - common);
  };
  const std::vector<std::size_t> true_labels = large(of_truth);
  const std::vector<std::size_t> predicted_labels = large(of_predicted);

  InstanceScore score;
  score.true_planes = static_cast<int>(true_labels.size());
  double found = 0.0;
  double pixels = 0.0;
  for (const std::size_t t : true_labels) {
    double best = 0.0;
    for (const std::size_t p : predicted_labels) best = std::max(best, iou(t, p));
    found += best >= kIou ? 1.0 : 0.0;
    score.weighted_iou += best * static_cast<double>(of_truth[t]);
    pixels += static_cast<double>(of_truth[t]);
  }
  if (pixels > 0.0) score.weighted_iou /= pixels;
  double right = 0.0;
  for (const std::size_t p : predicted_labels) {
    if (std::any_of(true_labels.begin(), true_labels.end(), [&](std::size_t t) { return iou(t, p) >= kIou; })) {
      right += 1.0;
    } else if (2 * of_predicted[p] >= whole[p]) {
      ++score.false_planes;
    }
  }
  if (right > 0.0) {
    const double precision = right / (right + score.false_planes);
    const double recall = found / score.true_planes;
    score.f1_50 = 2.0 * precision * recall / (precision + recall);
  }
  return score;
}

}  // namespace fransac::testing
