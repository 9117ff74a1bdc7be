// SPDX-License-Identifier: Apache-2.0
#include "fransac/eval/metrics.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <new>
#include <string>

#include "fransac/core/labels.hpp"

namespace fransac::eval {
namespace {

constexpr std::size_t kLabels = 256;
using Counts = std::array<std::uint64_t, kLabels>;

// An overlap is "most" of a plane above one half: then at most one plane can hold most of another.
constexpr double kMost = 0.5;

/// part / whole, 0 when there is no whole.
template <class Part, class Whole>
double ratio(Part part, Whole whole) {
  return whole > Whole{0} ? static_cast<double>(part) / static_cast<double>(whole) : 0.0;
}

double harmonic_mean(double a, double b) { return ratio(2.0 * a * b, a + b); }

bool is_plane(std::size_t label) { return label != kLabelNoDepth && label != kLabelNoPlane; }

Status check_sizes(std::span<const std::uint8_t> truth, std::span<const std::uint8_t> predicted) {
  if (truth.size() == predicted.size()) return {};
  return Error{ErrorCode::invalid_argument, "truth has " + std::to_string(truth.size()) + " labels, the prediction " +
                                                std::to_string(predicted.size()) + ": the sizes must be equal"};
}

/// How many judged pixels (truth != 0) have each pair of labels.
struct Confusion {
  std::vector<Counts> pixels;  ///< [truth][predicted]
  Counts truth{};
  Counts predicted{};
  std::uint64_t judged = 0;

  Confusion(std::span<const std::uint8_t> truth_labels, std::span<const std::uint8_t> predicted_labels) : pixels(kLabels) {
    for (std::size_t i = 0; i < truth_labels.size(); ++i) ++pixels[truth_labels[i]][predicted_labels[i]];
    pixels[kLabelNoDepth].fill(0);
    for (std::size_t t = 0; t < kLabels; ++t) {
      for (std::size_t p = 0; p < kLabels; ++p) {
        truth[t] += pixels[t][p];
        predicted[p] += pixels[t][p];
      }
      judged += truth[t];
    }
  }

  [[nodiscard]] double iou(std::size_t t, std::size_t p) const {
    const std::uint64_t both = pixels[t][p];
    return ratio(both, truth[t] + predicted[p] - both);
  }

  /// Predicted label `p` against truth label `t`.
  [[nodiscard]] Detection detection(std::size_t t, std::size_t p) const {
    const std::uint64_t both = pixels[t][p];
    return {both, predicted[p] - both, truth[t] - both};
  }
};

/// The labels of the planes that are large enough to count.
std::vector<std::size_t> planes_of(const Counts& counts, std::uint64_t judged, double min_share) {
  std::vector<std::size_t> labels;
  for (std::size_t label = 0; label < kLabels; ++label) {
    const bool large = static_cast<double>(counts[label]) >= min_share * static_cast<double>(judged);
    if (is_plane(label) && counts[label] > 0 && large) labels.push_back(label);
  }
  return labels;
}

struct Pair {
  std::size_t truth = 0;
  std::size_t predicted = 0;
  double iou = 0.0;
};

/// All overlapping pairs, best first; ties in the order of the labels.
std::vector<Pair> overlapping_pairs(const Confusion& confusion, std::span<const std::size_t> truth,
                                    std::span<const std::size_t> predicted) {
  std::vector<Pair> pairs;
  for (const std::size_t t : truth) {
    for (const std::size_t p : predicted) {
      if (confusion.pixels[t][p] > 0) pairs.push_back({t, p, confusion.iou(t, p)});
    }
  }
  std::stable_sort(pairs.begin(), pairs.end(), [](const Pair& a, const Pair& b) { return a.iou > b.iou; });
  return pairs;
}

/// One-to-one matches, best first. Above an IoU of one half no plane has two candidates; at exactly one half it may.
InstanceMetrics::AtIou match(std::span<const Pair> pairs, double threshold, int true_planes, int predicted_planes) {
  InstanceMetrics::AtIou at{.threshold = threshold};
  std::array<bool, kLabels> truth_used{};
  std::array<bool, kLabels> predicted_used{};
  double iou_sum = 0.0;
  for (const Pair& pair : pairs) {
    if (pair.iou < threshold || truth_used[pair.truth] || predicted_used[pair.predicted]) continue;
    truth_used[pair.truth] = predicted_used[pair.predicted] = true;
    iou_sum += pair.iou;
    ++at.matched;
  }
  at.precision = ratio(at.matched, predicted_planes);
  at.recall = ratio(at.matched, true_planes);
  at.f1 = harmonic_mean(at.precision, at.recall);
  at.mean_iou = ratio(iou_sum, at.matched);
  return at;
}

/// Share of the `covering` planes that hold most of two or more of the `covered` planes.
template <class Overlap>
double share_covering_several(std::span<const std::size_t> covering, std::span<const std::size_t> covered,
                              const Counts& covered_size, Overlap overlap) {
  const auto several = std::count_if(covering.begin(), covering.end(), [&](std::size_t a) {
    return std::count_if(covered.begin(), covered.end(),
                         [&](std::size_t b) { return ratio(overlap(a, b), covered_size[b]) > kMost; }) >= 2;
  });
  return ratio(several, covering.size());
}

double weighted_iou(const Confusion& confusion, std::span<const std::size_t> truth, std::span<const std::size_t> predicted) {
  double sum = 0.0;
  double weight = 0.0;
  for (const std::size_t t : truth) {
    double best = 0.0;
    for (const std::size_t p : predicted) best = std::max(best, confusion.iou(t, p));
    sum += best * static_cast<double>(confusion.truth[t]);
    weight += static_cast<double>(confusion.truth[t]);
  }
  return ratio(sum, weight);
}

double plane_pixel_f1(const Confusion& confusion) {
  Detection on_plane;
  for (std::size_t t = 1; t < kLabels; ++t) {
    for (std::size_t p = 0; p < kLabels; ++p) {
      const std::uint64_t count = confusion.pixels[t][p];
      if (is_plane(t) && is_plane(p)) on_plane.true_positives += count;
      if (!is_plane(t) && is_plane(p)) on_plane.false_positives += count;
      if (is_plane(t) && !is_plane(p)) on_plane.false_negatives += count;
    }
  }
  return on_plane.f1();
}

/// Runs `compute` on the confusion of two label images of equal size.
template <class T, class Compute>
Result<T> compare(std::span<const std::uint8_t> truth, std::span<const std::uint8_t> predicted, Compute compute) {
  if (const Status status = check_sizes(truth, predicted); !status) return status.error();
  try {
    return compute(Confusion(truth, predicted));
  } catch (const std::bad_alloc&) {
    return Error{ErrorCode::out_of_memory, "not enough memory to compare labels"};
  }
}

}  // namespace

double Detection::precision() const { return ratio(true_positives, true_positives + false_positives); }
double Detection::recall() const { return ratio(true_positives, true_positives + false_negatives); }
double Detection::f1() const { return harmonic_mean(precision(), recall()); }

Result<Detection> dominant_plane(std::span<const std::uint8_t> truth, std::span<const std::uint8_t> predicted,
                                 std::uint8_t predicted_label) {
  return compare<Detection>(truth, predicted,
                            [&](const Confusion& confusion) { return confusion.detection(kLabelFirst, predicted_label); });
}

Result<BestDetection> best_overlap(std::span<const std::uint8_t> truth, std::span<const std::uint8_t> predicted) {
  return compare<BestDetection>(truth, predicted, [](const Confusion& confusion) {
    const Counts& overlap = confusion.pixels[kLabelFirst];
    const auto best = std::max_element(overlap.begin() + kLabelFirst, overlap.begin() + kLabelNoPlane);  // the first of equals
    if (*best == 0) return BestDetection{{0, 0, confusion.truth[kLabelFirst]}, 0};
    const auto label = static_cast<std::uint8_t>(best - overlap.begin());
    return BestDetection{confusion.detection(kLabelFirst, label), label};
  });
}

Result<MatchedDetection> matched_plane(std::span<const std::uint8_t> truth, std::span<const std::uint8_t> predicted,
                                       std::uint8_t predicted_label) {
  return compare<MatchedDetection>(truth, predicted, [&](const Confusion& confusion) {
    MatchedDetection best{{0, confusion.predicted[predicted_label], 0}, 0};
    for (std::size_t t = kLabelFirst; t < kLabelNoPlane; ++t) {
      const Detection detection = confusion.detection(t, predicted_label);
      if (detection.f1() > best.detection.f1()) best = {detection, static_cast<std::uint8_t>(t)};
    }
    return best;
  });
}

Result<InstanceMetrics> instance_metrics(std::span<const std::uint8_t> truth, std::span<const std::uint8_t> predicted,
                                         double min_share) {
  if (!(min_share >= 0.0 && min_share <= 1.0)) {
    return Error{ErrorCode::invalid_argument, "min_share must be between 0 and 1, not " + std::to_string(min_share)};
  }
  return compare<InstanceMetrics>(truth, predicted, [&](const Confusion& confusion) {
    const auto true_labels = planes_of(confusion.truth, confusion.judged, min_share);
    const auto predicted_labels = planes_of(confusion.predicted, confusion.judged, min_share);
    const auto pairs = overlapping_pairs(confusion, true_labels, predicted_labels);
    InstanceMetrics metrics;
    metrics.true_planes = static_cast<int>(true_labels.size());
    metrics.predicted_planes = static_cast<int>(predicted_labels.size());
    metrics.at50 = match(pairs, 0.5, metrics.true_planes, metrics.predicted_planes);
    metrics.at75 = match(pairs, 0.75, metrics.true_planes, metrics.predicted_planes);
    metrics.under_segmentation = share_covering_several(predicted_labels, true_labels, confusion.truth,
                                                        [&](std::size_t p, std::size_t t) { return confusion.pixels[t][p]; });
    metrics.over_segmentation = share_covering_several(true_labels, predicted_labels, confusion.predicted,
                                                       [&](std::size_t t, std::size_t p) { return confusion.pixels[t][p]; });
    metrics.missed = ratio(metrics.true_planes - metrics.at50.matched, metrics.true_planes);
    metrics.noise = ratio(metrics.predicted_planes - metrics.at50.matched, metrics.predicted_planes);
    metrics.weighted_iou = weighted_iou(confusion, true_labels, predicted_labels);
    metrics.plane_pixel_f1 = plane_pixel_f1(confusion);
    return metrics;
  });
}

PlaneError plane_error(const Plane& truth, const Plane& predicted) {
  const double sign = truth.normal.dot(predicted.normal) < 0.0 ? -1.0 : 1.0;
  return {angle_between(truth, predicted), std::abs(sign * predicted.d - truth.d)};
}

}  // namespace fransac::eval
