// SPDX-License-Identifier: Apache-2.0
/// The sampling loop. Every RANSAC variant in this project is a choice of pre-test, scorer and stopping rule for this
/// one loop; there is no second one.
///
/// The loop works on a sample of the data (all of them when they are few): minimal samples, first scores and local
/// optimisation come from it, and only what does well there is verified on all data. sac/preemption.hpp says what that costs.
#pragma once

#include <algorithm>
#include <array>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "fransac/core/parallel.hpp"
#include "fransac/core/random.hpp"
#include "fransac/sac/preemption.hpp"
#include "fransac/sac/stopping.hpp"

namespace fransac::sac {

/// How well all data support a model. `value` is what is maximised; `inliers` is what eq. (2) looks at.
struct Score {
  double value = 0.0;         ///< By Scoring: inliers, or their truncated squared distances.
  std::uint64_t inliers = 0;  ///< Data within the threshold.
};
/// Adds the support by other data.
Score& operator+=(Score& sum, const Score& part);
/// What is maximised, on all data.
inline double total(const Score& score) { return score.value; }
/// What is maximised, on the whole sample; -1 for a hypothesis that was given up.
inline double total(const SampleScore& score) { return score.value.back(); }

/// What the loop needs to know of a problem. All members are const and may be called from several threads at once.
template <class P>
concept SamplingProblem = requires(const P& problem, const std::array<std::uint32_t, P::kSampleSize>& sample,
                                   const typename P::Model& model, std::span<const typename P::Model> models,
                                   std::span<SampleScore> scores, const Bar& bar, const Score& to_beat, std::uint32_t i) {
  /// The size of a minimal sample.
  { P::kSampleSize } -> std::convertible_to<int>;
  /// The number of all data.
  { problem.num_data() } -> std::convertible_to<std::uint64_t>;
  /// The number of sampled data, all of them or kSampledData; minimal samples are distinct numbers below it.
  { problem.num_sampled() } -> std::convertible_to<std::uint32_t>;
  /// The model of a minimal sample, or nothing when the sample is degenerate.
  { problem.generate(sample) } -> std::same_as<std::optional<typename P::Model>>;
  /// Whether sampled datum i is an inlier (eq. 1); asked by the pre-test.
  { problem.is_inlier(model, i) } -> std::same_as<bool>;
  /// Scores every model on the sample. A model below the bar at a checkpoint need not be looked at further.
  {problem.score(models, bar, scores)};
  /// A model fitted to the sampled inliers of `model`, or nothing when they do not determine one.
  { problem.refine(model) } -> std::same_as<std::optional<typename P::Model>>;
  /// The score on all data. A model that cannot reach more than `to_beat.value` may be given any smaller score.
  { problem.verify(model, to_beat) } -> std::same_as<Score>;
  /// A model fitted to all inliers of `model`, or nothing when they do not determine one.
  { problem.refine_on_all(model) } -> std::same_as<std::optional<typename P::Model>>;
};

/// What a user can choose about the loop.
struct RansacOptions {
  double probability = 0.99;            ///< p of eq. (2). Zeineldin & El-Fishawy, section 4.
  std::uint32_t max_iterations = 1000;  ///< The cap I, the paper's second stop.
  int pretest_points = 0;               ///< d of T(d,d); 0 is standard RANSAC.
  bool local_optimisation = true;       ///< Refit every promising model to its inliers while that raises its score (LO-RANSAC).
  /// With local optimisation: a hypothesis is promising from this share of the best model's score on, in (0, 1]. The best has
  /// been refitted; a hypothesis through three noisy points has not, and scores less than its refit would: at 1 the larger of two
  /// planes of nearly the same size is missed more often than `probability` says.
  double promising = 1.0;
  std::uint64_t seed = 0;   ///< Of all random numbers; the same seed, the same answer.
  std::uint32_t round = 0;  ///< Tells several searches with one seed apart: hypothesis i draws from stream (round << 32) + i.
  int threads = 1;          ///< 0: all cores. Never changes the answer.
};

/// Evidence of a run.
template <class Model>
struct RansacResult {
  std::optional<Model> model;    ///< Nothing only when every sample was degenerate or no model had support.
  Score score;                   ///< On all data.
  std::uint64_t iterations = 0;  ///< Hypotheses drawn, pre-tested ones included.
  std::uint64_t rejected = 0;    ///< Hypotheses that failed the pre-test.
  std::uint64_t degenerate = 0;  ///< Samples thrown away and drawn again.
  std::uint64_t verified = 0;    ///< Models that were scored on all data.
  StopReason stop_reason = StopReason::max_iterations;  ///< Why it ended.
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

template <class Problem>
struct Hypothesis {
  std::array<std::uint32_t, Problem::kSampleSize> sample{};
  std::optional<typename Problem::Model> model;
  std::uint32_t degenerate = 0;
  bool passed = false;
};

/// Hypothesis i: a pure function of the problem, the seed and i.
template <SamplingProblem Problem>
Hypothesis<Problem> draw_hypothesis(const Problem& problem, const RansacOptions& options, std::uint64_t i) {
  RandomStream random(options.seed, (std::uint64_t{options.round} << 32) + i);
  Hypothesis<Problem> hypothesis;
  const auto n = static_cast<std::uint32_t>(problem.num_sampled());
  for (int attempt = 0; attempt < kMaxSampleAttempts && !hypothesis.model; ++attempt) {
    hypothesis.sample = draw_sample<Problem::kSampleSize>(random, n);
    hypothesis.model = problem.generate(hypothesis.sample);
    if (!hypothesis.model) ++hypothesis.degenerate;
  }
  hypothesis.passed = hypothesis.model.has_value();
  for (int d = 0; d < options.pretest_points && hypothesis.passed; ++d) {  // T(d,d): all d must be inliers
    hypothesis.passed = problem.is_inlier(*hypothesis.model, random.below(n));
  }
  return hypothesis;
}

/// Calls refit(model) -> optional<(model, score)> for as long as that raises the score (LO-RANSAC: Chum, Matas, Kittler 2003).
template <class Model, class ScoreOf, class Refit>
void climb(std::pair<Model, ScoreOf>& best, const Refit& refit) {
  constexpr int kMaxRefits = 10;
  constexpr double kWorthwhile = 1e-3;  // a relative rise below this does not pay for another look at the data
  const auto value = [](const std::pair<Model, ScoreOf>& p) { return total(p.second); };
  for (int i = 0; i < kMaxRefits; ++i) {
    const std::optional<std::pair<Model, ScoreOf>> next = refit(best.first);
    if (!next || value(*next) <= value(best)) return;
    const double rise = value(*next) - value(best);
    best = *next;
    if (rise < kWorthwhile * value(best)) return;
  }
}

/// Local optimisation on the sample.
template <SamplingProblem Problem>
void optimise_on_sample(const Problem& problem, std::pair<typename Problem::Model, SampleScore>& candidate) {
  using Model = typename Problem::Model;
  climb(candidate, [&](const Model& model) -> std::optional<std::pair<Model, SampleScore>> {
    const std::optional<Model> refined = problem.refine(model);
    if (!refined) return std::nullopt;
    SampleScore score;
    problem.score(std::span(&*refined, 1), Bar{}, std::span(&score, 1));
    return std::pair(*refined, score);
  });
}

/// Local optimisation on all data.
template <SamplingProblem Problem>
void optimise_on_all(const Problem& problem, RansacResult<typename Problem::Model>& best) {
  using Model = typename Problem::Model;
  std::pair<Model, Score> candidate{*best.model, best.score};
  climb(candidate, [&](const Model& model) -> std::optional<std::pair<Model, Score>> {
    const std::optional<Model> refined = problem.refine_on_all(model);
    if (!refined) return std::nullopt;
    return std::pair(*refined, problem.verify(*refined, Score{}));
  });
  best.model = candidate.first;
  best.score = candidate.second;
}

}  // namespace detail

/// Buffers of the loop, to be kept between calls.
template <class Problem>
struct RansacWorkspace {
  std::vector<detail::Hypothesis<Problem>> hypotheses;  ///< Of a batch.
  std::vector<typename Problem::Model> models;          ///< Those that passed the pre-test.
  std::vector<SampleScore> scores;                      ///< One per model.
};

/// RANSAC. Hypotheses are drawn and scored in batches, in parallel, and judged one after the other in the order of their
/// numbers, exactly as a serial loop would: what a batch holds beyond the stopping point is thrown away, so neither the
/// batch size nor the number of threads can change the answer.
template <SamplingProblem Problem>
RansacResult<typename Problem::Model> ransac(const Problem& problem, const RansacOptions& options,
                                             RansacWorkspace<Problem>& work) {
  using Model = typename Problem::Model;
  constexpr std::uint64_t kFirstBatch = 4;  // most frames with a clear plane need no more
  constexpr std::uint64_t kMaxBatch = 64;
  constexpr std::size_t kModelsPerTask = 16;
  constexpr std::uint64_t kMostThreads = 64;  // that batches grow with
  RansacResult<Model> best;
  const auto n = static_cast<std::uint64_t>(problem.num_data());
  if (n < static_cast<std::uint64_t>(Problem::kSampleSize)) {
    best.stop_reason = StopReason::degenerate;
    return best;
  }
  const std::uint64_t sampled = problem.num_sampled();
  const bool all_sampled = sampled == n;
  const double promising = options.local_optimisation ? options.promising : 1.0;
  const auto bar_of = [&](double score) {
    return all_sampled ? Bar::exact(score, sampled) : Bar::likely(score / static_cast<double>(n), sampled);
  };
  Bar bar;            // of hypotheses
  Bar optimised_bar;  // of what local optimisation makes of them
  double best_in_sample = 0.0;

  /// Whether a hypothesis, weaker than the best, only repeats it: local optimisation has already been there.
  const auto repeats_best = [&](const detail::Hypothesis<Problem>& hypothesis, const SampleScore& score) {
    return options.local_optimisation && best.model && total(score) < best_in_sample &&
           std::all_of(hypothesis.sample.begin(), hypothesis.sample.end(),
                       [&](std::uint32_t i) { return problem.is_inlier(*best.model, i); });
  };

  const auto threads = std::min<std::uint64_t>(static_cast<std::uint64_t>(resolve_threads(options.threads)), kMostThreads);
  bool any_model = false;
  std::uint64_t needed = options.max_iterations;
  std::uint64_t batch = kFirstBatch;
  while (best.iterations < needed) {
    const std::uint64_t first = best.iterations;
    const std::uint64_t count = std::min(batch, needed - first);
    batch = std::min(2 * batch, kMaxBatch * threads);

    work.hypotheses.resize(count);
    const std::size_t draw_tasks = (count + kModelsPerTask - 1) / kModelsPerTask;
    parallel_for(options.threads, draw_tasks, [&](std::size_t task) {
      const std::size_t end = std::min<std::size_t>(count, (task + 1) * kModelsPerTask);
      for (std::size_t i = task * kModelsPerTask; i < end; ++i) {
        work.hypotheses[i] = detail::draw_hypothesis(problem, options, first + i);
      }
    });
    work.models.clear();
    for (const auto& hypothesis : work.hypotheses) {
      if (hypothesis.passed) work.models.push_back(*hypothesis.model);
    }
    work.scores.assign(work.models.size(), SampleScore{});
    const std::size_t tasks = (work.models.size() + kModelsPerTask - 1) / kModelsPerTask;
    parallel_for(options.threads, tasks, [&](std::size_t task) {
      const std::size_t begin = task * kModelsPerTask;
      const std::size_t size = std::min(kModelsPerTask, work.models.size() - begin);
      problem.score(std::span(work.models).subspan(begin, size), bar, std::span(work.scores).subspan(begin, size));
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
      if (!bar.passed_by(work.scores[s]) || repeats_best(hypothesis, work.scores[s])) continue;
      std::pair<Model, SampleScore> candidate{work.models[s], work.scores[s]};
      if (options.local_optimisation) detail::optimise_on_sample(problem, candidate);
      if (!optimised_bar.passed_by(candidate.second)) continue;
      Score score{total(candidate.second), candidate.second.inliers};
      if (!all_sampled) {
        score = problem.verify(candidate.first, best.score);
        ++best.verified;
      }
      if (!(score.value > best.score.value)) continue;
      best.model = candidate.first;
      best.score = score;
      best_in_sample = total(candidate.second);
      bar = bar_of(promising * score.value);
      optimised_bar = bar_of(score.value);
      const double inlier_ratio = static_cast<double>(score.inliers) / static_cast<double>(n);
      needed = std::min<std::uint64_t>(options.max_iterations, required_iterations(options.probability, inlier_ratio,
                                                                                   Problem::kSampleSize, options.pretest_points));
      best.stop_reason = needed < options.max_iterations ? StopReason::confidence : StopReason::max_iterations;
    }
  }
  if (!any_model) best.stop_reason = StopReason::degenerate;
  if (best.model && options.local_optimisation && !all_sampled) detail::optimise_on_all(problem, best);
  return best;
}

}  // namespace fransac::sac
