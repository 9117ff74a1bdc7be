// SPDX-License-Identifier: Apache-2.0
/// How well labels agree with the truth, where planes on pixels that nobody judged are neither right nor wrong.
#pragma once

#include <cstdint>
#include <span>

#include "fransac/eval/metrics.hpp"

namespace fransac::testing {

struct InstanceScore {
  int true_planes = 0;        ///< That have at least 0.5 % of the judged pixels.
  int false_planes = 0;       ///< Predicted, as large, judged on half of their pixels, and no true plane's at IoU 0.5.
  double f1_50 = 0.0;         ///< Instance F1 at IoU 0.5.
  double weighted_iou = 0.0;  ///< Mean over true planes, weighted by pixels, of the best IoU with a predicted one.
};

/// eval::instance_metrics of it. Both images must have equal sizes.
inline InstanceScore instance_score(std::span<const std::uint8_t> truth, std::span<const std::uint8_t> predicted) {
  const eval::InstanceMetrics metrics = eval::instance_metrics(truth, predicted).value();
  return {metrics.true_planes, metrics.at50.false_positives, metrics.at50.f1, metrics.weighted_iou};
}

}  // namespace fransac::testing
