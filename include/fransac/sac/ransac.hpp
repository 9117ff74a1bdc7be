// SPDX-License-Identifier: Apache-2.0
/// The sampling loop. Every RANSAC variant in this project is a choice of pre-test, scorer and stopping rule for this
/// one loop; there is no second one.
#pragma once

#include <algorithm>
#include <array>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "fransac/core/parallel.hpp"
#include "fransac/core/random.hpp"
#include "fransac/sac/stopping.hpp"

namespace fransac::sac {

/// How well the data support a model. `value` is what is maximised; `inliers` is what eq. (2) looks at.
struct Score {
  double value = 0.0;
  std::uint64_t inliers = 0;
};

/// What the loop needs to know of a problem. All members are const and may be called from several threads at once.
template <class P>
concept SamplingProblem = requires(const P& problem, const std::array<std::uint32_t, P::kSampleSize>& sample,
                                   const typename P::Model& model, std::span<const typename P::Model> models,
                                   std::span<Score> scores, const Score& to_beat, std::uint32_t i) {
  /// The size of a minimal sample.
  { P::kSampleSize } -> std::convertible_to<int>;
  /// The number of data; a sample is distinct numbers below it.
  { problem.num_data() } -> std::convertible_to<std::uint32_t>;
  /// The model of a minimal sample, or nothing when the sample is degenerate.
  { problem.generate(sample) } -> std::same_as<std::optional<typename P::Model>>;
  /// Whether datum i is an inlier (eq. 1); asked by the pre-test.
  { problem.is_inlier(model, i) } -> std::same_as<bool>;
  /// Scores every model. A model that cannot reach more than `to_beat.value` may be given any smaller score: bail-out.
  {problem.score(models, to_beat, scores)};
  /// A model fitted to the inliers of `model`, or nothing when they do not determine one.
  { problem.refine(model) } -> std::same_as<std::optional<typename P::Model>>;
};

struct RansacOptions {
  double probability = 0.99;            ///< p of eq. (2). Zeineldin & El-Fishawy, section 4.
  std::uint32_t max_iterations = 1000;  ///< The cap I, the paper's second stop.
  int pretest_points = 0;               ///< d of T(d,d); 0 is standard RANSAC.
  bool local_optimisation = true;       ///< Refit every new best model to its inliers while that raises its score (LO-RANSAC).
  std::uint64_t seed = 0;
  std::uint32_t round = 0;  ///< Tells several searches with one seed apart: hypothesis i draws from stream (round << 32) + i.
  int threads = 1;          ///< 0: all cores. Never changes the answer.
};

/// Evidence of a run.
template <class Model>
struct RansacResult {
  std::optional<Model> model;  ///< Nothing only when every sample was degenerate or no model had support.
  Score score;
  std::uint64_t iterations = 0;  ///< Hypotheses drawn, pre-tested ones included.
  std::uint64_t rejected = 0;    ///< Hypotheses that failed the pre-test.
  std::uint64_t degenerate = 0;  ///< Samples thrown away and drawn again.
  StopReason stop_reason = StopReason::max_iterations;
};

/// Draws a uniform sample of distinct numbers below n (n >= K).
template <std::size_t K>
std::array<std::uint32_t, K> draw_sample(RandomStream& random, std::uint32_t n) {
  std::array<std::uint32_t, K> sample{};
  for (std::size_t k = 0; k < K;) {
    sample[k] = random.below(n);
    const auto drawn = sample.begin() + static_cast<std::ptrdiff_t>(k);
    if (std::find(sample.begin(), drawn, sample[k]) == drawn) ++k;
  }
  return sample;
}

namespace detail {

/// Samples tried per hypothesis before it is left without a model.
inline constexpr int kMaxSampleAttempts = 100;

template <class Model>
struct Hypothesis {
  std::optional<Model> model;
  std::uint32_t degenerate = 0;
  bool passed = false;
};

/// Hypothesis i: a pure function of the problem, the seed and i.
template <SamplingProblem Problem>
Hypothesis<typename Problem::Model> draw_hypothesis(const Problem& problem, const RansacOptions& options, std::uint64_t i) {
  RandomStream random(options.seed, (std::uint64_t{options.round} << 32) + i);
  Hypothesis<typename Problem::Model> hypothesis;
  const auto n = static_cast<std::uint32_t>(problem.num_data());
  for (int attempt = 0; attempt < kMaxSampleAttempts && !hypothesis.model; ++attempt) {
    hypothesis.model = problem.generate(draw_sample<Problem::kSampleSize>(random, n));
    if (!hypothesis.model) ++hypothesis.degenerate;
  }
  hypothesis.passed = hypothesis.model.has_value();
  for (int d = 0; d < options.pretest_points && hypothesis.passed; ++d) {  // T(d,d): all d must be inliers
    hypothesis.passed = problem.is_inlier(*hypothesis.model, random.below(n));
  }
  return hypothesis;
}

}  // namespace detail

/// Buffers of the loop, to be kept between calls.
template <class Model>
struct RansacWorkspace {
  std::vector<detail::Hypothesis<Model>> hypotheses;
  std::vector<Model> models;
  std::vector<Score> scores;
};

/// Refits the best model to its inliers for as long as that raises the score (LO-RANSAC: Chum, Matas, Kittler 2003).
template <SamplingProblem Problem>
void optimise_locally(const Problem& problem, RansacResult<typename Problem::Model>& best) {
  constexpr int kMaxRefits = 10;
  constexpr double kWorthwhile = 1e-3;  // a relative rise below this does not pay for another look at all data
  for (int refit = 0; refit < kMaxRefits; ++refit) {
    const std::optional<typename Problem::Model> refined = problem.refine(*best.model);
    if (!refined) return;
    Score score;
    problem.score(std::span(&*refined, 1), best.score, std::span(&score, 1));
    if (score.value <= best.score.value) return;
    const double rise = score.value - best.score.value;
    best.model = refined;
    best.score = score;
    if (rise < kWorthwhile * score.value) return;
  }
}

/// RANSAC. Hypotheses are drawn and scored in batches, in parallel, and judged one after the other in the order of their
/// numbers, exactly as a serial loop would: what a batch holds beyond the stopping point is thrown away, so neither the
/// batch size nor the number of threads can change the answer.
template <SamplingProblem Problem>
RansacResult<typename Problem::Model> ransac(const Problem& problem, const RansacOptions& options,
                                             RansacWorkspace<typename Problem::Model>& work) {
  constexpr std::uint64_t kFirstBatch = 4;  // most frames with a clear plane need no more
  constexpr std::uint64_t kMaxBatch = 32;
  constexpr std::size_t kModelsPerTask = 8;
  constexpr int kMostThreads = 64;  // that batches grow with
  RansacResult<typename Problem::Model> best;
  const auto n = static_cast<std::uint64_t>(problem.num_data());
  if (n < static_cast<std::uint64_t>(Problem::kSampleSize)) {
    best.stop_reason = StopReason::degenerate;
    return best;
  }

  const auto threads = static_cast<std::uint64_t>(std::min(resolve_threads(options.threads), kMostThreads));
  bool any_model = false;
  std::uint64_t needed = options.max_iterations;
  std::uint64_t batch = kFirstBatch * threads;
  while (best.iterations < needed) {
    const std::uint64_t first = best.iterations;
    const std::uint64_t count = std::min(batch, needed - first);
    batch = std::min(2 * batch, kMaxBatch * threads);

    work.hypotheses.resize(count);
    parallel_for(options.threads, count,
                 [&](std::size_t i) { work.hypotheses[i] = detail::draw_hypothesis(problem, options, first + i); });
    work.models.clear();
    for (const auto& hypothesis : work.hypotheses) {
      if (hypothesis.passed) work.models.push_back(*hypothesis.model);
    }
    work.scores.assign(work.models.size(), Score{});
    const std::size_t tasks = (work.models.size() + kModelsPerTask - 1) / kModelsPerTask;
    const Score to_beat = best.score;
    parallel_for(options.threads, tasks, [&](std::size_t task) {
      const std::size_t begin = task * kModelsPerTask;
      const std::size_t size = std::min(kModelsPerTask, work.models.size() - begin);
      problem.score(std::span(work.models).subspan(begin, size), to_beat, std::span(work.scores).subspan(begin, size));
    });

    std::size_t scored = 0;
    for (std::size_t i = 0; i < count && best.iterations < needed; ++i) {
      const auto& hypothesis = work.hypotheses[i];
      ++best.iterations;
      best.degenerate += hypothesis.degenerate;
      if (!hypothesis.model) continue;
      any_model = true;
      if (!hypothesis.passed) {
        ++best.rejected;
        continue;
      }
      const std::size_t s = scored++;
      if (!(work.scores[s].value > best.score.value)) continue;
      best.model = work.models[s];
      best.score = work.scores[s];
      if (options.local_optimisation) optimise_locally(problem, best);
      const double inlier_ratio = static_cast<double>(best.score.inliers) / static_cast<double>(n);
      needed = std::min<std::uint64_t>(options.max_iterations, required_iterations(options.probability, inlier_ratio,
                                                                                   Problem::kSampleSize, options.pretest_points));
      best.stop_reason = needed < options.max_iterations ? StopReason::confidence : StopReason::max_iterations;
    }
  }
  if (!any_model) best.stop_reason = StopReason::degenerate;
  return best;
}

}  // namespace fransac::sac
