// SPDX-License-Identifier: Apache-2.0
#include "fransac/eval/metrics.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <new>
#include <string>
#include <utility>

#include "core/caught.hpp"
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

Status check_sizes(std::size_t truth, std::size_t predicted) {
  if (truth == predicted) return {};
  return Error{ErrorCode::invalid_argument, "truth has " + std::to_string(truth) + " labels, the prediction " +
                                                std::to_string(predicted) + ": the sizes must be equal"};
}

/// How many judged pixels (truth != 0) have each pair of labels.
struct Confusion {
  std::vector<Counts> pixels;  ///< [truth][predicted]
  Counts truth{};
  Counts predicted{};
  Counts ignored{};  ///< Pixels of each predicted label that are not judged.
  std::uint64_t judged = 0;

  Confusion(std::span<const std::uint8_t> truth_labels, std::span<const std::uint8_t> predicted_labels) : pixels(kLabels) {
    for (std::size_t i = 0; i < truth_labels.size(); ++i) ++pixels[truth_labels[i]][predicted_labels[i]];
    ignored = std::exchange(pixels[kLabelNoDepth], Counts{});
    for (std::size_t t = 0; t < kLabels; ++t) {
      for (std::size_t p = 0; p < kLabels; ++p) {
        truth[t] += pixels[t][p];
        predicted[p] += pixels[t][p];
      }
      judged += truth[t];
    }
  }

  /// Predicted label `p` against truth label `t`.
  [[nodiscard]] Detection detection(std::size_t t, std::size_t p) const {
    const std::uint64_t both = pixels[t][p];
    return {both, predicted[p] - both, truth[t] - both};
  }

  /// Whether predicted label `p` lies where it can be right or wrong, by half of its pixels or more.
  [[nodiscard]] bool is_judged(std::size_t p) const { return predicted[p] > 0 && predicted[p] >= ignored[p]; }

  [[nodiscard]] std::uint8_t first_judged() const {
    for (std::size_t p = kLabelFirst; p < kLabelNoPlane; ++p) {
      if (is_judged(p)) return static_cast<std::uint8_t>(p);
    }
    return kLabelFirst;
  }
};

/// A plane or an object in an image.
struct Region {
  std::size_t label = 0;
  std::uint64_t pixels = 0;
  bool can_be_false = true;  ///< A predicted one: not mostly where nobody can judge.
};

/// Two regions, by index, and what they have in common.
struct Pair {
  std::size_t truth = 0;
  std::size_t predicted = 0;
  std::uint64_t pixels = 0;
  double iou = 0.0;
};

/// True and predicted regions and how they overlap.
struct Overlaps {
  std::vector<Region> truth;
  std::vector<Region> predicted;
  std::vector<Pair> pairs;  ///< All that overlap, best first; ties in the order of the regions.

  /// `found` in the order of the regions; IoUs are not known yet.
  Overlaps(std::vector<Region> true_regions, std::vector<Region> predicted_regions, std::vector<Pair> found)
      : truth(std::move(true_regions)), predicted(std::move(predicted_regions)), pairs(std::move(found)) {
    for (Pair& pair : pairs) {
      pair.iou = ratio(pair.pixels, truth[pair.truth].pixels + predicted[pair.predicted].pixels - pair.pixels);
    }
    std::stable_sort(pairs.begin(), pairs.end(), [](const Pair& a, const Pair& b) { return a.iou > b.iou; });
  }

  /// The best IoU of each true region.
  [[nodiscard]] std::vector<double> best_iou() const {
    std::vector<double> best(truth.size(), 0.0);
    for (const Pair& pair : pairs) best[pair.truth] = std::max(best[pair.truth], pair.iou);
    return best;
  }
};

/// The planes that are large enough to count.
std::vector<Region> planes_of(const Counts& counts, std::uint64_t judged, double min_share) {
  std::vector<Region> planes;
  for (std::size_t label = 0; label < kLabels; ++label) {
    const bool large = static_cast<double>(counts[label]) >= min_share * static_cast<double>(judged);
    if (is_plane(label) && counts[label] > 0 && large) planes.push_back({label, counts[label]});
  }
  return planes;
}

Overlaps overlaps_of(const Confusion& confusion, double min_share) {
  std::vector<Region> truth = planes_of(confusion.truth, confusion.judged, min_share);
  std::vector<Region> predicted = planes_of(confusion.predicted, confusion.judged, min_share);
  for (Region& plane : predicted) plane.can_be_false = confusion.is_judged(plane.label);
  std::vector<Pair> pairs;
  for (std::size_t t = 0; t < truth.size(); ++t) {
    for (std::size_t p = 0; p < predicted.size(); ++p) {
      const std::uint64_t both = confusion.pixels[truth[t].label][predicted[p].label];
      if (both > 0) pairs.push_back({t, p, both});
    }
  }
  return {std::move(truth), std::move(predicted), std::move(pairs)};
}

constexpr std::size_t kIds = std::size_t{1} << 16;

/// The objects of an image, by id, and where in the list each id is.
struct Objects {
  std::vector<Region> regions;
  std::vector<std::size_t> index;

  Objects(std::span<const std::uint16_t> ids, std::span<const char> judged) : index(kIds, 0) {
    std::vector<std::uint64_t> counts(kIds, 0);
    for (std::size_t i = 0; i < ids.size(); ++i) {
      if (judged[i] != 0) ++counts[ids[i]];
    }
    for (std::size_t id = 1; id < kIds; ++id) {
      if (counts[id] == 0) continue;
      index[id] = regions.size();
      regions.push_back({id, counts[id]});
    }
  }
};

Overlaps overlaps_of(std::span<const std::uint16_t> truth, std::span<const std::uint16_t> predicted,
                     std::span<const char> judged) {
  Objects true_objects(truth, judged);
  Objects predicted_objects(predicted, judged);
  // Ids may be as many as pixels, a table of all pairs out of reach: the pairs that there are, pixel by pixel, sorted.
  std::vector<std::uint32_t> both;
  for (std::size_t i = 0; i < truth.size(); ++i) {
    if (judged[i] != 0 && truth[i] != 0 && predicted[i] != 0) both.push_back(std::uint32_t{truth[i]} << 16 | predicted[i]);
  }
  std::sort(both.begin(), both.end());
  std::vector<Pair> pairs;
  for (auto first = both.begin(); first != both.end();) {
    const auto last = std::upper_bound(first, both.end(), *first);
    pairs.push_back({true_objects.index[*first >> 16], predicted_objects.index[*first & (kIds - 1)],
                     static_cast<std::uint64_t>(last - first)});
    first = last;
  }
  return {std::move(true_objects.regions), std::move(predicted_objects.regions), std::move(pairs)};
}

/// One-to-one matches, best first. Above an IoU of one half no region has two candidates; at exactly one half it may.
InstanceMetrics::AtIou match(const Overlaps& overlaps, double threshold) {
  InstanceMetrics::AtIou at{.threshold = threshold};
  std::vector<bool> truth_used(overlaps.truth.size());
  std::vector<bool> predicted_used(overlaps.predicted.size());
  double iou_sum = 0.0;
  for (const Pair& pair : overlaps.pairs) {
    if (pair.iou < threshold || truth_used[pair.truth] || predicted_used[pair.predicted]) continue;
    truth_used[pair.truth] = predicted_used[pair.predicted] = true;
    iou_sum += pair.iou;
    ++at.matched;
  }
  for (std::size_t p = 0; p < overlaps.predicted.size(); ++p) {
    if (!predicted_used[p] && overlaps.predicted[p].can_be_false) ++at.false_positives;
  }
  at.precision = ratio(at.matched, at.matched + at.false_positives);
  at.recall = ratio(at.matched, overlaps.truth.size());
  at.f1 = harmonic_mean(at.precision, at.recall);
  at.mean_iou = ratio(iou_sum, at.matched);
  return at;
}

/// Share of the regions on one side (`&Pair::truth` or `&Pair::predicted`) that hold most of two or more of the other's.
double share_holding_several(const Overlaps& overlaps, std::size_t Pair::*side) {
  const bool of_truth = side == &Pair::truth;
  const std::vector<Region>& held = of_truth ? overlaps.predicted : overlaps.truth;
  const auto other = of_truth ? &Pair::predicted : &Pair::truth;
  std::vector<int> holds(of_truth ? overlaps.truth.size() : overlaps.predicted.size(), 0);
  for (const Pair& pair : overlaps.pairs) {
    if (ratio(pair.pixels, held[pair.*other].pixels) > kMost) ++holds[pair.*side];
  }
  return ratio(std::count_if(holds.begin(), holds.end(), [](int count) { return count >= 2; }), holds.size());
}

/// What planes and objects are judged by alike.
template <class Metrics>
void add_matches(const Overlaps& overlaps, Metrics& metrics) {
  metrics.at50 = match(overlaps, 0.5);
  metrics.at75 = match(overlaps, 0.75);
  metrics.under_segmentation = share_holding_several(overlaps, &Pair::predicted);
  metrics.over_segmentation = share_holding_several(overlaps, &Pair::truth);
}

double weighted_iou(const Overlaps& overlaps) {
  const std::vector<double> best = overlaps.best_iou();
  double sum = 0.0;
  double weight = 0.0;
  for (std::size_t t = 0; t < best.size(); ++t) {
    const auto pixels = static_cast<double>(overlaps.truth[t].pixels);
    sum += best[t] * pixels;
    weight += pixels;
  }
  return ratio(sum, weight);
}

/// Predicted objects without a true one on most of their pixels.
int false_objects(const Overlaps& overlaps) {
  auto count = static_cast<int>(overlaps.predicted.size());
  for (const Pair& pair : overlaps.pairs) {
    if (ratio(pair.pixels, overlaps.predicted[pair.predicted].pixels) > kMost) --count;  // at most once for each
  }
  return count;
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

constexpr const char* kComparison = "comparison of labels";

/// Runs `compute` on the confusion of two label images of equal size.
template <class T, class Compute>
Result<T> compare(std::span<const std::uint8_t> truth, std::span<const std::uint8_t> predicted, Compute compute) try {
  if (const Status status = check_sizes(truth.size(), predicted.size()); !status) return status.error();
  return compute(Confusion(truth, predicted));
} catch (const std::exception& exception) {
  return caught(exception, kComparison);
}

template <class Mask>
Result<ObjectMetrics> compare_objects(std::span<const std::uint16_t> truth, std::span<const std::uint16_t> predicted,
                                      std::span<const Mask> mask) try {
  if (const Status status = check_sizes(truth.size(), predicted.size()); !status) return status.error();
  if (mask.size() != truth.size()) {
    return Error{ErrorCode::invalid_argument, "truth has " + std::to_string(truth.size()) + " pixels, what is judged " +
                                                  std::to_string(mask.size()) + ": the sizes must be equal"};
  }
  std::vector<char> judged(mask.size());
  std::transform(mask.begin(), mask.end(), judged.begin(), [](Mask value) { return value != 0 ? 1 : 0; });
  const Overlaps overlaps = overlaps_of(truth, predicted, judged);
  ObjectMetrics metrics;
  metrics.true_objects = static_cast<int>(overlaps.truth.size());
  metrics.predicted_objects = static_cast<int>(overlaps.predicted.size());
  add_matches(overlaps, metrics);
  metrics.false_objects = false_objects(overlaps);
  const std::vector<double> best = overlaps.best_iou();
  for (std::size_t t = 0; t < best.size(); ++t) {
    metrics.objects.push_back({static_cast<std::uint16_t>(overlaps.truth[t].label), overlaps.truth[t].pixels, best[t]});
  }
  return metrics;
} catch (const std::exception& exception) {
  return caught(exception, kComparison);
}

}  // namespace

double Detection::precision() const { return ratio(true_positives, true_positives + false_positives); }
double Detection::recall() const { return ratio(true_positives, true_positives + false_negatives); }
double Detection::f1() const { return harmonic_mean(precision(), recall()); }

Result<std::uint8_t> first_judged_plane(std::span<const std::uint8_t> truth, std::span<const std::uint8_t> predicted) {
  return compare<std::uint8_t>(truth, predicted, [](const Confusion& confusion) { return confusion.first_judged(); });
}

Result<Detection> dominant_plane(std::span<const std::uint8_t> truth, std::span<const std::uint8_t> predicted,
                                 std::optional<std::uint8_t> predicted_label) {
  return compare<Detection>(truth, predicted, [&](const Confusion& confusion) {
    return confusion.detection(kLabelFirst, predicted_label.value_or(confusion.first_judged()));
  });
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
                                       std::optional<std::uint8_t> predicted_label) {
  return compare<MatchedDetection>(truth, predicted, [&](const Confusion& confusion) {
    const std::uint8_t label = predicted_label.value_or(confusion.first_judged());
    MatchedDetection best{{0, confusion.predicted[label], 0}, 0};
    for (std::size_t t = kLabelFirst; t < kLabelNoPlane; ++t) {
      const Detection detection = confusion.detection(t, label);
      if (detection.f1() > best.detection.f1()) best = {detection, static_cast<std::uint8_t>(t)};
    }
    return best;
  });
}

Result<InstanceMetrics> instance_metrics(std::span<const std::uint8_t> truth, std::span<const std::uint8_t> predicted,
                                         double min_share) {
  return compare<InstanceMetrics>(truth, predicted, [&](const Confusion& confusion) -> Result<InstanceMetrics> {
    if (!(min_share >= 0.0 && min_share <= 1.0)) {
      return Error{ErrorCode::invalid_argument, "min_share must be between 0 and 1, not " + std::to_string(min_share)};
    }
    const Overlaps overlaps = overlaps_of(confusion, min_share);
    InstanceMetrics metrics;
    metrics.true_planes = static_cast<int>(overlaps.truth.size());
    metrics.predicted_planes = static_cast<int>(overlaps.predicted.size());
    add_matches(overlaps, metrics);
    metrics.missed = ratio(metrics.true_planes - metrics.at50.matched, metrics.true_planes);
    metrics.noise = ratio(metrics.at50.false_positives, metrics.at50.matched + metrics.at50.false_positives);
    metrics.weighted_iou = weighted_iou(overlaps);
    metrics.plane_pixel_f1 = plane_pixel_f1(confusion);
    return metrics;
  });
}

Result<ObjectMetrics> object_metrics(std::span<const std::uint16_t> truth, std::span<const std::uint16_t> predicted,
                                     std::span<const std::uint8_t> judged) {
  return compare_objects(truth, predicted, judged);
}

Result<ObjectMetrics> object_metrics(std::span<const std::uint16_t> truth, std::span<const std::uint16_t> predicted,
                                     std::span<const std::uint16_t> depth) {
  return compare_objects(truth, predicted, depth);
}

double FloorAsObstacle::share() const { return ratio(obstacle, floor); }

Result<FloorAsObstacle> floor_as_obstacle(std::span<const std::uint8_t> truth, std::span<const std::uint16_t> obstacles,
                                          std::uint8_t floor_label) try {
  if (const Status status = check_sizes(truth.size(), obstacles.size()); !status) return status.error();
  FloorAsObstacle counts;
  for (std::size_t i = 0; i < truth.size(); ++i) {
    if (truth[i] != floor_label) continue;
    ++counts.floor;
    if (obstacles[i] != 0) ++counts.obstacle;
  }
  return counts;
} catch (const std::exception& exception) {
  return caught(exception, kComparison);
}

PlaneError plane_error(const Plane& truth, const Plane& predicted) {
  const double sign = truth.normal.dot(predicted.normal) < 0.0 ? -1.0 : 1.0;
  return {angle_between(truth, predicted), std::abs(sign * predicted.d - truth.d)};
}

}  // namespace fransac::eval
