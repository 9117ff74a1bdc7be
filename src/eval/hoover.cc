// SPDX-License-Identifier: Apache-2.0
#include "fransac/eval/hoover.hpp"

#include <algorithm>
#include <array>
#include <cstddef>
#include <iterator>
#include <map>
#include <new>
#include <numeric>
#include <string>
#include <utility>

#include "core/caught.hpp"
#include "core/union_find.hpp"
#include "fransac/core/labels.hpp"

namespace fransac::eval {
namespace {

constexpr std::uint8_t kFirstSegcompRegion = 10;  // below: shadows, noise, edges across

/// Pixels that two regions, by index, have in common.
struct Overlap {
  std::size_t truth = 0;
  std::size_t predicted = 0;
  std::uint64_t pixels = 0;
};

/// What classes are made of.
struct Regions {
  std::vector<std::uint64_t> truth;      ///< Pixels of each.
  std::vector<std::uint64_t> predicted;  ///< Judged pixels of each.
  std::vector<char> can_be_noise;        ///< Of predicted ones: not mostly where nothing is judged.
  std::vector<Overlap> overlaps;         ///< All that are not empty.
};

bool is_plane(std::uint8_t label) { return label != kLabelNoDepth && label != kLabelNoPlane; }

bool is_true_region(std::uint8_t value, TrueRegions kind) {
  return kind == TrueRegions::segcomp ? value >= kFirstSegcompRegion : is_plane(value);
}

bool is_judged(std::uint8_t value, TrueRegions kind) { return kind == TrueRegions::segcomp || value != kLabelNoDepth; }

/// The first pixel, row by row, of the 8-connected part of equal label that each pixel is in.
std::vector<std::size_t> parts_of(std::span<const std::uint8_t> labels, std::size_t width) {
  std::vector<std::size_t> first(labels.size());
  std::iota(first.begin(), first.end(), std::size_t{0});
  const auto join = [&](std::size_t a, std::size_t b) {
    if (labels[a] == labels[b]) join_roots(first.data(), root_of(first.data(), a), root_of(first.data(), b));
  };
  for (std::size_t i = 0; i < labels.size(); ++i) {
    const std::size_t column = i % width;
    if (column > 0) join(i - 1, i);
    if (i < width) continue;
    join(i - width, i);
    if (column > 0) join(i - width - 1, i);
    if (column + 1 < width) join(i - width + 1, i);
  }
  for (std::size_t i = 0; i < first.size(); ++i) first[i] = root_of(first.data(), i);
  return first;
}

Regions regions_of(std::span<const std::uint8_t> truth, std::span<const std::uint8_t> predicted, std::size_t width,
                   const HooverOptions& options) {
  constexpr std::size_t kNone = ~std::size_t{0};
  Regions regions;
  std::array<std::size_t, 256> index_of_true{};
  std::array<std::uint64_t, 256> counts{};
  for (const std::uint8_t value : truth) ++counts[value];
  for (std::size_t value = 0; value < counts.size(); ++value) {
    index_of_true[value] = kNone;
    if (counts[value] == 0 || !is_true_region(static_cast<std::uint8_t>(value), options.truth)) continue;
    index_of_true[value] = regions.truth.size();
    regions.truth.push_back(counts[value]);
  }

  const std::vector<std::size_t> parts = parts_of(predicted, width);
  std::vector<std::uint64_t> pixels(parts.size(), 0);
  std::vector<std::uint64_t> judged(parts.size(), 0);
  for (std::size_t i = 0; i < parts.size(); ++i) {
    ++pixels[parts[i]];
    judged[parts[i]] += is_judged(truth[i], options.truth) ? 1U : 0U;
  }
  std::vector<std::size_t> index_of_part(parts.size(), kNone);
  for (std::size_t i = 0; i < parts.size(); ++i) {
    const bool counts_at_all = is_plane(predicted[i]) && pixels[i] >= static_cast<std::uint64_t>(options.min_pixels);
    if (!counts_at_all || judged[i] == 0) continue;
    index_of_part[i] = regions.predicted.size();
    regions.predicted.push_back(judged[i]);
    regions.can_be_noise.push_back(2 * judged[i] >= pixels[i] ? 1 : 0);
  }

  std::map<std::pair<std::size_t, std::size_t>, std::uint64_t> common;
  for (std::size_t i = 0; i < parts.size(); ++i) {
    const std::pair pair{index_of_true[truth[i]], index_of_part[parts[i]]};
    if (pair.first != kNone && pair.second != kNone) ++common[pair];
  }
  for (const auto& [pair, count] : common) regions.overlaps.push_back({pair.first, pair.second, count});
  return regions;
}

enum class Class { correct, over_segmented, under_segmented };

/// Regions that may be of a class, unless a better one claims them.
struct Candidate {
  Class kind = Class::correct;
  double mean_overlap = 0.0;
  std::vector<std::size_t> truth;
  std::vector<std::size_t> predicted;
};

double share(std::uint64_t part, std::uint64_t whole) { return static_cast<double>(part) / static_cast<double>(whole); }

/// Pairs, `kind` correct, that hold the tolerance of each other.
std::vector<Candidate> correct_ones(const Regions& regions, double tolerance) {
  std::vector<Candidate> found;
  for (const Overlap& o : regions.overlaps) {
    const double of_true = share(o.pixels, regions.truth[o.truth]);
    const double of_predicted = share(o.pixels, regions.predicted[o.predicted]);
    if (of_true < tolerance || of_predicted < tolerance) continue;
    found.push_back({Class::correct, (of_true + of_predicted) / 2.0, {o.truth}, {o.predicted}});
  }
  return found;
}

/// Wholes of one side that two or more pieces of the other cover: true regions that predicted ones cover, or the reverse.
std::vector<Candidate> covered_ones(const Regions& regions, double tolerance, Class kind) {
  const bool over = kind == Class::over_segmented;
  const std::vector<std::uint64_t>& wholes = over ? regions.truth : regions.predicted;
  const std::vector<std::uint64_t>& pieces = over ? regions.predicted : regions.truth;
  struct Cover {
    std::uint64_t pixels = 0;
    double of_pieces = 0.0;  // the sum of what the whole holds of each
    std::vector<std::size_t> pieces;
  };
  std::vector<Cover> covers(wholes.size());
  for (const Overlap& o : regions.overlaps) {
    const std::size_t piece = over ? o.predicted : o.truth;
    const double held = share(o.pixels, pieces[piece]);
    if (held < tolerance) continue;
    Cover& cover = covers[over ? o.truth : o.predicted];
    cover.pixels += o.pixels;
    cover.of_pieces += held;
    cover.pieces.push_back(piece);
  }
  std::vector<Candidate> found;
  for (std::size_t w = 0; w < wholes.size(); ++w) {
    Cover& cover = covers[w];
    const double covered = share(cover.pixels, wholes[w]);
    if (cover.pieces.size() < 2 || covered < tolerance) continue;
    Candidate candidate{kind, (cover.of_pieces + covered) / static_cast<double>(cover.pieces.size() + 1), {w}, cover.pieces};
    if (!over) std::swap(candidate.truth, candidate.predicted);
    found.push_back(std::move(candidate));
  }
  return found;
}

HooverMetrics classify(const Regions& regions, double tolerance) {
  std::vector<Candidate> candidates = correct_ones(regions, tolerance);
  for (const Class kind : {Class::over_segmented, Class::under_segmented}) {
    std::vector<Candidate> more = covered_ones(regions, tolerance, kind);
    std::move(more.begin(), more.end(), std::back_inserter(candidates));
  }
  std::stable_sort(candidates.begin(), candidates.end(),
                   [](const Candidate& a, const Candidate& b) { return a.mean_overlap > b.mean_overlap; });
  std::vector<char> truth_used(regions.truth.size(), 0);
  std::vector<char> predicted_used(regions.predicted.size(), 0);
  const auto is_free = [](const std::vector<char>& used, const std::vector<std::size_t>& wanted) {
    return std::none_of(wanted.begin(), wanted.end(), [&](std::size_t i) { return used[i] != 0; });
  };
  HooverMetrics metrics{.tolerance = tolerance, .true_regions = static_cast<int>(regions.truth.size())};
  for (const Candidate& candidate : candidates) {
    if (!is_free(truth_used, candidate.truth) || !is_free(predicted_used, candidate.predicted)) continue;
    for (const std::size_t t : candidate.truth) truth_used[t] = 1;
    for (const std::size_t p : candidate.predicted) predicted_used[p] = 1;
    switch (candidate.kind) {
      case Class::correct: ++metrics.correct; break;
      case Class::over_segmented: ++metrics.over_segmented; break;
      case Class::under_segmented: ++metrics.under_segmented; break;
    }
  }
  metrics.missed = static_cast<int>(std::count(truth_used.begin(), truth_used.end(), 0));
  for (std::size_t p = 0; p < predicted_used.size(); ++p) {
    if (predicted_used[p] != 0 || regions.can_be_noise[p] != 0) ++metrics.predicted;
    if (predicted_used[p] == 0 && regions.can_be_noise[p] != 0) ++metrics.noise;
  }
  return metrics;
}

Status check(std::span<const std::uint8_t> truth, std::span<const std::uint8_t> predicted, int width,
             std::span<const double> tolerances, const HooverOptions& options) {
  const auto refuse = [](std::string message) { return Error{ErrorCode::invalid_argument, std::move(message)}; };
  if (truth.size() != predicted.size()) {
    return refuse("truth has " + std::to_string(truth.size()) + " pixels, the prediction " + std::to_string(predicted.size()) +
                  ": the sizes must be equal");
  }
  if (width < 1 || truth.size() % static_cast<std::size_t>(width) != 0) {
    return refuse("width must divide the " + std::to_string(truth.size()) + " pixels, not be " + std::to_string(width));
  }
  for (const double tolerance : tolerances) {
    // At one half two regions could claim the same one, and none would be the better.
    if (!(tolerance > 0.5 && tolerance <= 1.0)) {
      return refuse("tolerance must be above 0.5 and at most 1, not " + std::to_string(tolerance));
    }
  }
  if (options.min_pixels < 1) return refuse("min_pixels must be at least 1, not " + std::to_string(options.min_pixels));
  return {};
}

}  // namespace

Result<HooverMetrics> hoover(std::span<const std::uint8_t> truth, std::span<const std::uint8_t> predicted, int width,
                             double tolerance, const HooverOptions& options) try {
  const Result<std::vector<HooverMetrics>> metrics = hoover(truth, predicted, width, std::span(&tolerance, 1), options);
  if (!metrics) return metrics.error();
  return metrics->front();
} catch (const std::exception& exception) {
  return caught(exception, "comparison of regions");
}

Result<std::vector<HooverMetrics>> hoover(std::span<const std::uint8_t> truth, std::span<const std::uint8_t> predicted, int width,
                                          std::span<const double> tolerances, const HooverOptions& options) try {
  if (const Status status = check(truth, predicted, width, tolerances, options); !status) return status.error();
  const Regions regions = regions_of(truth, predicted, static_cast<std::size_t>(width), options);
  std::vector<HooverMetrics> metrics;
  for (const double tolerance : tolerances) metrics.push_back(classify(regions, tolerance));
  return metrics;
} catch (const std::exception& exception) {
  return caught(exception, "comparison of regions");
}

}  // namespace fransac::eval
