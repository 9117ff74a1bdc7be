// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <numeric>
#include <optional>
#include <span>
#include <vector>

#include "bail_out.hpp"
#include "fransac/sac/plane_problem.hpp"
#include "fransac/sac/ransac.hpp"
#include "fransac/sac/stopping.hpp"
#include "support.hpp"

namespace fransac::sac {
namespace {

using Eigen::Vector3d;

// ---- equation (2) ----

TEST(RequiredIterations, TableByHand) {
  // log(1 - p) / log(1 - q^(m + d)), for example log 0.01 / log 0.875 = 4.6052 / 0.13353 = 34.49.
  EXPECT_EQ(required_iterations(0.99, 0.9, 3), 4U);     // 3.53
  EXPECT_EQ(required_iterations(0.99, 0.8, 3), 7U);     // 6.42
  EXPECT_EQ(required_iterations(0.99, 0.5, 3), 35U);    // 34.49
  EXPECT_EQ(required_iterations(0.99, 0.3, 3), 169U);   // 168.25
  EXPECT_EQ(required_iterations(0.99, 0.1, 3), 4603U);  // 4602.87
  EXPECT_EQ(required_iterations(0.999, 0.5, 3), 52U);   // 51.73
  EXPECT_EQ(required_iterations(0.5, 0.5, 3), 6U);      // 5.19
  EXPECT_EQ(required_iterations(0.75, 0.5, 1), 2U);     // 2: nothing to round up
}

TEST(RequiredIterations, PretestPointsCountLikeSamplePoints) {
  EXPECT_EQ(required_iterations(0.99, 0.5, 3, 1), 72U);   // 71.36
  EXPECT_EQ(required_iterations(0.99, 0.5, 3, 2), 146U);  // 145.05
  for (int d = 0; d < 5; ++d) EXPECT_EQ(required_iterations(0.99, 0.37, 3, d), required_iterations(0.99, 0.37, 3 + d));
}

TEST(RequiredIterations, Ends) {
  EXPECT_EQ(required_iterations(0.99, 1.0, 3), 1U);
  EXPECT_EQ(required_iterations(0.99, 1.0, 3, 7), 1U);
  EXPECT_EQ(required_iterations(1e-9, 0.99, 3), 1U);
  EXPECT_EQ(required_iterations(0.99, 0.0, 3), std::uint64_t{1} << 63);
  EXPECT_EQ(required_iterations(0.99, 1e-200, 3), std::uint64_t{1} << 63);  // q^3 is no double any more
  EXPECT_EQ(required_iterations(0.99, 1e-30, 3), std::uint64_t{1} << 63);
  // 1 - 1e-15 is off by 11 % in double; the logarithm must not be.
  EXPECT_NEAR(static_cast<double>(required_iterations(0.99, 1e-5, 3)), 4.605170185988091e15, 1e4);
}

TEST(StopReason, Names) {
  EXPECT_EQ(to_string(StopReason::confidence), "confidence");
  EXPECT_EQ(to_string(StopReason::max_iterations), "max_iterations");
  EXPECT_EQ(to_string(StopReason::degenerate), "degenerate");
}

// ---- samples ----

TEST(DrawSample, DistinctAndUniformOverAllSubsets) {
  constexpr std::uint32_t kN = 7;
  constexpr int kSubsets = 35;  // 7 choose 3
  constexpr int kDraws = 1000 * kSubsets;
  RandomStream random = testing::test_random();
  std::map<std::array<std::uint32_t, 3>, int> counts;
  for (int i = 0; i < kDraws; ++i) {
    std::array<std::uint32_t, 3> sample = draw_sample<3>(random, kN);
    std::sort(sample.begin(), sample.end());
    ASSERT_TRUE(sample[0] < sample[1] && sample[1] < sample[2] && sample[2] < kN);
    ++counts[sample];
  }
  ASSERT_EQ(counts.size(), static_cast<std::size_t>(kSubsets));
  double chi_square = 0.0;
  for (const auto& [subset, count] : counts) chi_square += (count - 1000.0) * (count - 1000.0) / 1000.0;
  EXPECT_LT(chi_square, 65.25);  // 34 degrees of freedom: exceeded with probability 0.001
}

TEST(DrawSample, AllOfThreeDataIsTheOnlySample) {
  RandomStream random = testing::test_random();
  for (int i = 0; i < 50; ++i) {
    std::array<std::uint32_t, 3> sample = draw_sample<3>(random, 3);
    std::sort(sample.begin(), sample.end());
    EXPECT_EQ(sample, (std::array<std::uint32_t, 3>{0, 1, 2}));
  }
}

// ---- the loop, against a problem small enough to see through ----

/// Scores a model on the first data of a problem by asking each, as the concept wants it.
template <class Problem, class Model>
SampleScore sample_score(const Problem& problem, const Model& model, const Bar& bar) {
  SampleScore score;
  std::uint32_t i = 0;
  for (std::size_t c = 0; c < kCheckpoints.size(); ++c) {
    for (; i < std::min(kCheckpoints[c], problem.num_sampled()); ++i) {
      score.inliers += static_cast<std::uint64_t>(problem.is_inlier(model, i));
    }
    score.value[c] = static_cast<double>(score.inliers);
    if (!bar.passed_at(c, score.value[c])) break;
  }
  return score;
}

/// The location of scalars: two different numbers propose their mean; inliers lie within 1 of it. All data are the sample.
struct Location {
  using Model = double;
  static constexpr int kSampleSize = 2;

  std::vector<double> data;

  [[nodiscard]] std::uint64_t num_data() const { return data.size(); }
  [[nodiscard]] std::uint32_t num_sampled() const { return static_cast<std::uint32_t>(data.size()); }
  [[nodiscard]] std::optional<double> generate(const std::array<std::uint32_t, 2>& sample) const {
    if (data[sample[0]] == data[sample[1]]) return std::nullopt;
    return (data[sample[0]] + data[sample[1]]) / 2.0;
  }
  [[nodiscard]] bool is_inlier(double model, std::uint32_t i) const { return std::abs(data[i] - model) <= 1.0; }
  void score(std::span<const double> models, const Bar& bar, std::span<SampleScore> scores) const {
    std::transform(models.begin(), models.end(), scores.begin(), [&](double model) { return sample_score(*this, model, bar); });
  }
  [[nodiscard]] std::optional<double> refine(double model) const {
    double sum = 0.0;
    std::uint32_t count = 0;
    for (std::uint32_t i = 0; i < num_sampled(); ++i) {
      if (!is_inlier(model, i)) continue;
      sum += data[i];
      ++count;
    }
    if (count == 0) return std::nullopt;
    return sum / count;
  }
  [[nodiscard]] std::optional<double> refine_on_all(double model) const { return refine(model); }
  [[nodiscard]] Score verify(double model, const Score& to_beat) const {
    const auto on = [&](double x) { return std::abs(x - model) <= 1.0; };
    const auto inliers = static_cast<std::uint64_t>(std::count_if(data.begin(), data.end(), on));
    const Score score{static_cast<double>(inliers), inliers};
    return score.value > to_beat.value ? score : Score{};  // what the concept permits: losers may get any smaller score
  }
};
static_assert(SamplingProblem<Location>);
static_assert(SamplingProblem<PlaneProblem>);

/// A share of the data around 0 with standard deviation 0.7, the others anywhere within 50.
Location located(double inlier_share, int size, RandomStream random) {
  Location problem;
  for (int i = 0; i < size; ++i) {
    problem.data.push_back(i < inlier_share * size ? 0.7 * random.normal() : testing::uniform(random, -50.0, 50.0));
  }
  return problem;
}

template <SamplingProblem Problem>
SampleScore full_sample_score(const Problem& problem, const typename Problem::Model& model) {
  SampleScore score;
  problem.score(std::span(&model, 1), Bar{}, std::span(&score, 1));
  return score;
}

/// The loop as one would write it without batches, threads or preemption, where all data are the sample: the truth for the one in
/// the library.
template <SamplingProblem Problem>
RansacResult<typename Problem::Model> plain_ransac(const Problem& problem, const RansacOptions& options) {
  using Model = typename Problem::Model;
  RansacResult<Model> best;
  std::uint64_t needed = options.max_iterations;
  for (std::uint64_t i = 0; i < needed; ++i) {
    RandomStream random(options.seed, (std::uint64_t{options.round} << 32) + i);
    ++best.iterations;
    std::optional<Model> model;
    for (int attempt = 0; attempt < 100 && !model; ++attempt) {
      model = problem.generate(draw_sample<Problem::kSampleSize>(random, problem.num_sampled()));
      if (!model) ++best.degenerate;
    }
    if (!model) continue;
    bool passed = true;
    for (int d = 0; d < options.pretest_points && passed; ++d)
      passed = problem.is_inlier(*model, random.below(problem.num_sampled()));
    if (!passed) {
      ++best.rejected;
      continue;
    }
    std::pair candidate{*model, full_sample_score(problem, *model)};
    if (total(candidate.second) <= best.score.value) continue;
    if (options.local_optimisation) detail::optimise_on_sample(problem, candidate);
    best.model = candidate.first;
    best.score = {total(candidate.second), candidate.second.inliers};
    const double q = static_cast<double>(best.score.inliers) / static_cast<double>(problem.num_data());
    needed = std::min<std::uint64_t>(options.max_iterations,
                                     required_iterations(options.probability, q, Problem::kSampleSize, options.pretest_points));
    best.stop_reason = needed < options.max_iterations ? StopReason::confidence : StopReason::max_iterations;
  }
  return best;
}

template <class Model>
void expect_equal(const RansacResult<Model>& a, const RansacResult<Model>& b) {
  ASSERT_EQ(a.model.has_value(), b.model.has_value());
  if constexpr (std::is_same_v<Model, Plane>) {
    if (a.model) {
      EXPECT_EQ(a.model->normal, b.model->normal);
      EXPECT_EQ(a.model->d, b.model->d);
    }
  } else {
    EXPECT_EQ(a.model, b.model);
  }
  EXPECT_EQ(a.score.value, b.score.value);
  EXPECT_EQ(a.score.inliers, b.score.inliers);
  EXPECT_EQ(a.iterations, b.iterations);
  EXPECT_EQ(a.rejected, b.rejected);
  EXPECT_EQ(a.degenerate, b.degenerate);
  EXPECT_EQ(a.verified, b.verified);
  EXPECT_EQ(a.stop_reason, b.stop_reason);
}

template <SamplingProblem Problem>
RansacResult<typename Problem::Model> run(const Problem& problem, const RansacOptions& options) {
  RansacWorkspace<Problem> work;
  return ransac(problem, options, work);
}

TEST(Ransac, IsThePlainLoopAtAnyNumberOfThreads) {
  // The number of threads sets the size of the batches too: each ends at other hypotheses.
  RansacWorkspace<Location> work;  // reused throughout: what is left in it must not matter
  for (const double share : {0.9, 0.4, 0.1}) {
    const Location problem = located(share, 300, testing::test_random(static_cast<std::uint64_t>(10 * share)));
    for (const int pretest_points : {0, 1, 2}) {
      for (const bool local_optimisation : {false, true}) {
        for (std::uint64_t seed = 0; seed < 5; ++seed) {
          RansacOptions options{
              .max_iterations = 300, .pretest_points = pretest_points, .local_optimisation = local_optimisation, .seed = seed};
          const auto expected = plain_ransac(problem, options);
          for (const int threads : {1, 2, 5}) {
            options.threads = threads;
            expect_equal(ransac(problem, options, work), expected);
          }
        }
      }
    }
  }
}

TEST(Ransac, RoundsDrawDifferentSamples) {
  const Location problem = located(0.3, 200, testing::test_random());
  RansacOptions options{.max_iterations = 20, .local_optimisation = false};
  const auto first = run(problem, options);
  options.round = 1;
  const auto second = run(problem, options);
  EXPECT_NE(first.model, second.model);
  expect_equal(second, plain_ransac(problem, options));
}

TEST(Ransac, StopsByConfidence) {
  const Location problem{{0.0, 0.1, 0.2, 0.3, 0.4, 0.5}};  // all inliers of every hypothesis: eq. (2) asks for one
  const auto result = run(problem, {});
  EXPECT_EQ(result.stop_reason, StopReason::confidence);
  EXPECT_EQ(result.iterations, 1U);
  EXPECT_EQ(result.score.inliers, 6U);
}

TEST(Ransac, StopsExactlyWhereEquation2Says) {
  const Location problem = located(0.5, 400, testing::test_random());
  const RansacOptions options{.max_iterations = 1000, .local_optimisation = false};
  const auto result = run(problem, options);
  ASSERT_EQ(result.stop_reason, StopReason::confidence);
  const double q = static_cast<double>(result.score.inliers) / 400.0;
  EXPECT_GE(result.iterations, required_iterations(options.probability, q, 2));
  // Not one more unless the last improvement itself came later.
  RansacOptions shorter = options;
  shorter.max_iterations = static_cast<std::uint32_t>(result.iterations - 1);
  const auto cut = run(problem, shorter);
  EXPECT_TRUE(result.iterations == required_iterations(options.probability, q, 2) || cut.score.value < result.score.value);
}

TEST(Ransac, StopsAtTheCap) {
  const Location problem = located(0.1, 1000, testing::test_random());
  for (const std::uint32_t cap : {1U, 7U, 8U, 9U, 41U}) {  // below, at and beyond the borders of batches
    const auto result = run(problem, {.max_iterations = cap});
    EXPECT_EQ(result.iterations, cap);
    EXPECT_EQ(result.stop_reason, StopReason::max_iterations);
  }
}

TEST(Ransac, GivesUpWhereEverySampleIsDegenerate) {
  const Location problem{std::vector<double>(50, 3.0)};
  for (const int threads : {1, 5}) {
    const auto result = run(problem, {.max_iterations = 20, .threads = threads});
    EXPECT_FALSE(result.model);
    EXPECT_EQ(result.stop_reason, StopReason::degenerate);
    EXPECT_EQ(result.iterations, 20U);
    EXPECT_EQ(result.degenerate, 2000U);
  }
}

TEST(Ransac, ARareGoodSampleIsStillFound) {
  // One datum in 200 differs: one sample in a hundred is not degenerate, so a third of the hypotheses find none.
  Location problem{std::vector<double>(200, 3.0)};
  problem.data[17] = 5.0;
  const auto result = run(problem, {.max_iterations = 50});
  EXPECT_TRUE(result.model);
  EXPECT_NE(result.stop_reason, StopReason::degenerate);
}

TEST(Ransac, TooFewDataAreDegenerate) {
  for (const std::size_t size : std::initializer_list<std::size_t>{0, 1}) {
    const auto result = run(Location{std::vector<double>(size, 1.0)}, {});
    EXPECT_FALSE(result.model);
    EXPECT_EQ(result.stop_reason, StopReason::degenerate);
    EXPECT_EQ(result.iterations, 0U);
  }
}

TEST(Ransac, DegenerateSamplesAreDrawnAgainAndCounted) {
  // Half of the data coincide: a quarter of the samples are degenerate, and every hypothesis still gets a model.
  Location problem{std::vector<double>(500, 200.0)};
  RandomStream random = testing::test_random();
  for (int i = 0; i < 500; ++i) problem.data.push_back(testing::uniform(random, 0.0, 100.0));
  const auto result = run(problem, {.probability = 0.999999999, .max_iterations = 2000, .local_optimisation = false});
  ASSERT_EQ(result.iterations, 2000U);
  // Samples until success are geometric with success 3/4: mean 1/3 of a failure each, variance 4/9; 4 standard deviations.
  EXPECT_NEAR(static_cast<double>(result.degenerate), 2000.0 / 3.0, 4.0 * std::sqrt(2000.0 * 4.0 / 9.0));
}

TEST(Ransac, LocalOptimisationNeverLowersTheScoreAndMostlyRaisesIt) {
  const Location problem = located(0.5, 400, testing::test_random());
  int raised = 0;
  for (std::uint32_t i = 0; i < 50; ++i) {
    const double start = 0.9 * std::sin(static_cast<double>(i));
    std::pair candidate{start, full_sample_score(problem, start)};
    const double before = total(candidate.second);
    detail::optimise_on_sample(problem, candidate);
    EXPECT_GE(total(candidate.second), before);
    EXPECT_EQ(total(candidate.second), total(full_sample_score(problem, candidate.first)));
    raised += static_cast<int>(total(candidate.second) > before);
  }
  EXPECT_GE(raised, 40);  // only those that start within a data point of the optimum have nothing to gain
}

// ---- the pre-test ----

/// Every sample proposes the one true model, of which a share of the data are inliers.
struct OneModel {
  using Model = int;
  static constexpr int kSampleSize = 3;
  std::uint32_t size;
  std::uint32_t inliers;

  [[nodiscard]] std::uint64_t num_data() const { return size; }
  [[nodiscard]] std::uint32_t num_sampled() const { return size; }
  [[nodiscard]] std::optional<int> generate(const std::array<std::uint32_t, 3>& /*sample*/) const { return 1; }
  [[nodiscard]] bool is_inlier(int model, std::uint32_t i) const { return model == 1 && i < inliers; }
  void score(std::span<const int> models, const Bar& bar, std::span<SampleScore> scores) const {
    std::transform(models.begin(), models.end(), scores.begin(), [&](int model) { return sample_score(*this, model, bar); });
  }
  [[nodiscard]] std::optional<int> refine(int model) const { return model; }
  [[nodiscard]] std::optional<int> refine_on_all(int model) const { return model; }
  [[nodiscard]] Score verify(int model, const Score& /*to_beat*/) const {
    return model == 1 ? Score{1.0 * inliers, inliers} : Score{};
  }
};
static_assert(SamplingProblem<OneModel>);

TEST(Pretest, GoodHypothesesPassWithProbabilityQToTheD) {
  constexpr int kHypotheses = 20000;
  const OneModel problem{.size = 1000, .inliers = 600};
  for (const int d : {0, 1, 2, 3}) {
    const RansacOptions options{.pretest_points = d, .seed = testing::seed_of_test()};
    int passed = 0;
    for (std::uint64_t i = 0; i < kHypotheses; ++i)
      passed += static_cast<int>(detail::draw_hypothesis(problem, options, i).passed);
    const double expected = std::pow(0.6, d);
    // 4 standard deviations of the binomial: missed with probability 6e-5.
    EXPECT_NEAR(passed, kHypotheses * expected, 4.0 * std::sqrt(kHypotheses * expected * (1.0 - expected)) + 1e-9) << "d = " << d;
  }
}

TEST(Pretest, RejectedHypothesesAreCounted) {
  const OneModel problem{.size = 1000, .inliers = 0};  // no pre-test point is ever an inlier
  const auto result = run(problem, {.max_iterations = 77, .pretest_points = 1});
  EXPECT_EQ(result.iterations, 77U);
  EXPECT_EQ(result.rejected, 77U);
  EXPECT_FALSE(result.model);
  EXPECT_EQ(result.stop_reason, StopReason::max_iterations);
}

/// A sample of inliers only proposes the true model, any other one a model without support.
struct AllOrNothing : OneModel {
  [[nodiscard]] std::optional<int> generate(const std::array<std::uint32_t, 3>& sample) const {
    return std::all_of(sample.begin(), sample.end(), [this](std::uint32_t i) { return i < inliers; }) ? 1 : 0;
  }
};

TEST(RequiredIterations, FailsNoMoreOftenThanAsked) {
  // As many hypotheses as eq. (2) asks for must find the model with probability p, with and without a pre-test. 600 runs
  // with a failure probability of at most 0.1: 60 failures expected, 90 are more than 4 standard deviations (7.3) above.
  // Without the pre-test's correction (d = 1, q = 0.5) a run would fail with probability 0.31, with N a third too large 0.046.
  constexpr int kRuns = 600;
  constexpr double kProbability = 0.9;
  const AllOrNothing problem{{.size = 2000, .inliers = 1000}};
  for (const int d : {0, 1, 2}) {
    const auto n = static_cast<std::uint32_t>(required_iterations(kProbability, 0.5, 3, d));
    int failures = 0;
    for (int i = 0; i < kRuns; ++i) {
      const std::uint64_t seed = testing::seed_of_test() + static_cast<std::uint64_t>(i);
      const auto result = run(problem, {.max_iterations = n, .pretest_points = d, .seed = seed});
      failures += static_cast<int>(!result.model);
    }
    EXPECT_LE(failures, 90) << "d = " << d;
    EXPECT_GE(failures, 30) << "d = " << d;
  }
}

// ---- planes ----

Plane random_plane(const PointCloud& cloud, RandomStream& random) {
  for (;;) {
    const auto s = draw_sample<3>(random, static_cast<std::uint32_t>(cloud.size()));
    if (const auto plane = plane_through(cloud.local(s[0]), cloud.local(s[1]), cloud.local(s[2]))) return *plane;
  }
}

/// A plane problem over a cloud, with what it refers to.
struct CloudProblem {
  CloudProblem(const PointCloud& cloud, double threshold_m, Scoring scoring, std::uint64_t seed = 0, int threads = 1)
      : data(cloud, threads), problem(data, threshold_m, scoring, seed, 0, sample) {}
  CloudData data;
  PointCloud sample;
  PlaneProblem problem;
};

constexpr Score kNothingToBeat{-1.0, 0};
constexpr Scoring kScorings[] = {Scoring::inliers, Scoring::msac};

TEST(PlaneProblem, ScoresClosedForm) {
  // Distances 0, t/2, t (an inlier: eq. 1 includes the end), -t/4, 2t from z = 1; all are exact in float.
  const PointCloud cloud = testing::cloud_of({{3, 4, 1}, {1, 1, 1.25}, {-2, 0, 1.5}, {0, 5, 0.875}, {0, 0, 2}});
  const Plane plane = *make_plane({0, 0, 1}, -1);
  for (const Scoring scoring : kScorings) {
    const CloudProblem cloud_problem(cloud, 0.5, scoring);
    const double expected = scoring == Scoring::inliers ? 4.0 : 1.0 + 0.75 + 0.0 + 0.9375;
    const SampleScore in_sample = full_sample_score(cloud_problem.problem, plane);
    EXPECT_EQ(in_sample.inliers, 4U);
    EXPECT_THAT(in_sample.value, ::testing::Each(expected));  // every checkpoint lies beyond the last point
    const Score of_all = cloud_problem.problem.verify(plane, kNothingToBeat);
    EXPECT_EQ(of_all.inliers, 4U);
    EXPECT_EQ(of_all.value, expected);
  }
}

/// Support of a plane in the first points of a cloud, in double.
struct PlainScore {
  double gain = 0.0;
  double inliers = 0.0;
  double undecided = 0.0;  ///< Float and double may disagree on these.
  [[nodiscard]] double value(Scoring scoring) const { return scoring == Scoring::msac ? gain : inliers; }
};

PlainScore plain_score(const PointCloud& cloud, const Plane& plane, double threshold_m, std::size_t points) {
  PlainScore score;
  for (std::size_t i = 0; i < points; ++i) {
    const double share = plane.signed_distance(cloud.local(i)) / threshold_m;
    score.undecided += static_cast<double>(std::abs(std::abs(share) - 1.0) < 1e-4);
    if (std::abs(share) > 1.0) continue;
    ++score.inliers;
    score.gain += 1.0 - share * share;
  }
  return score;
}

TEST(PlaneProblem, ScoresManyPlanesUpToEachCheckpoint) {
  RandomStream random = testing::test_random();
  const PointCloud cloud = testing::noisy_plane(2000, 1803, 0.005, random);
  std::vector<Plane> planes;
  for (int i = 0; i < 130; ++i) planes.push_back(random_plane(cloud, random));
  for (const Scoring scoring : kScorings) {
    const CloudProblem cloud_problem(cloud, 0.01, scoring);
    std::vector<SampleScore> scores(planes.size());
    cloud_problem.problem.score(planes, Bar{}, scores);
    for (std::size_t m = 0; m < planes.size(); ++m) {
      for (std::size_t c = 0; c < kCheckpoints.size(); ++c) {
        const PlainScore expected = plain_score(cloud, planes[m], 0.01, std::min<std::size_t>(kCheckpoints[c], cloud.size()));
        EXPECT_NEAR(scores[m].value[c], expected.value(scoring), 1e-4 * expected.gain + expected.undecided);
        if (c + 1 == kCheckpoints.size()) {
          EXPECT_NEAR(static_cast<double>(scores[m].inliers), expected.inliers, expected.undecided);
        }
      }
    }
  }
}

TEST(PlaneProblem, NothingIsLookedAtBeyondTheBar) {
  RandomStream random = testing::test_random();
  const PointCloud cloud = testing::noisy_plane(1500, 2500, 0.005, random);
  const CloudProblem cloud_problem(cloud, 0.01, Scoring::msac);
  for (int i = 0; i < 50; ++i) {
    const Plane plane = random_plane(cloud, random);
    const SampleScore full = full_sample_score(cloud_problem.problem, plane);
    for (std::size_t last = 0; last < 2; ++last) {
      Bar bar;
      bar.least[last] = full.value[last];  // reached, not passed
      SampleScore score;
      cloud_problem.problem.score(std::span(&plane, 1), bar, std::span(&score, 1));
      EXPECT_FALSE(bar.passed_by(score));
      for (std::size_t c = 0; c < kCheckpoints.size(); ++c) EXPECT_EQ(score.value[c], c <= last ? full.value[c] : -1.0);
      EXPECT_LE(score.inliers, full.inliers);
    }
  }
}

TEST(PlaneProblem, AnExactBarHoldsUpLosersOnly) {
  RandomStream random = testing::test_random();
  const PointCloud cloud = testing::noisy_plane(2000, 2000, 0.004, random);
  int winners = 0;
  int early = 0;
  for (const Scoring scoring : kScorings) {
    const CloudProblem cloud_problem(cloud, 0.01, scoring);
    for (int i = 0; i < 60; ++i) {
      const Plane plane = random_plane(cloud, random);
      const SampleScore full = full_sample_score(cloud_problem.problem, plane);
      for (const double to_beat : {0.0, 50.0, 300.0, 1500.0, 3500.0, total(full)}) {
        const Bar bar = Bar::exact(to_beat, cloud.size());
        SampleScore score;
        cloud_problem.problem.score(std::span(&plane, 1), bar, std::span(&score, 1));
        EXPECT_EQ(bar.passed_by(score), total(full) > to_beat);
        if (bar.passed_by(score)) {
          ++winners;
          EXPECT_EQ(score.value, full.value);
          EXPECT_EQ(score.inliers, full.inliers);
        }
        early += static_cast<int>(total(score) < 0.0);
      }
    }
  }
  EXPECT_GT(winners, 100);
  EXPECT_GT(early, 50);
}

TEST(PlaneProblem, AnExactBarWaitsForInliersThatComeLast) {
  // 3000 points far off the plane, then 1000 on it: the plane can win until the last point has been seen.
  std::vector<Vector3d> points;
  for (int i = 0; i < 4000; ++i) points.emplace_back(i % 64, i / 64, i < 3000 ? 5.0 : 1.0);
  const PointCloud cloud = testing::cloud_of(points);
  const Plane plane = *make_plane({0, 0, -1}, 1.0);
  for (const Scoring scoring : kScorings) {
    const CloudProblem cloud_problem(cloud, 0.01, scoring);
    const Bar bar = Bar::exact(999.0, cloud.size());
    SampleScore score;
    cloud_problem.problem.score(std::span(&plane, 1), bar, std::span(&score, 1));
    EXPECT_TRUE(bar.passed_by(score));
    EXPECT_EQ(total(score), 1000.0);
    EXPECT_EQ(score.inliers, 1000U);
  }
}

TEST(PlaneProblem, LoopIsThePlainLoopAtAnyNumberOfThreads) {
  // The plain loop scores every hypothesis on all points: preemption, batches and threads change nothing while all are sampled.
  const PointCloud cloud = testing::noisy_plane(1200, 2896, 0.004, testing::test_random());
  ASSERT_EQ(cloud.size(), kSampledData);
  for (const Scoring scoring : kScorings) {
    const CloudProblem cloud_problem(cloud, 0.01, scoring);
    for (const int pretest_points : {0, 1}) {
      for (std::uint64_t seed = 0; seed < 3; ++seed) {
        RansacOptions options{.max_iterations = 400, .pretest_points = pretest_points, .seed = seed};
        const auto expected = plain_ransac(cloud_problem.problem, options);
        ASSERT_TRUE(expected.model);
        for (const int threads : {1, 2, 5}) {
          options.threads = threads;
          expect_equal(run(cloud_problem.problem, options), expected);
        }
      }
    }
  }
}

TEST(PlaneProblem, FindsThePlaneUnderOutliers) {
  const Plane truth = *make_plane({0.3, -0.2, -1.0}, 1.0);
  for (const std::size_t size : {std::size_t{1000}, std::size_t{10000}}) {  // fewer and more than are sampled
    const PointCloud cloud = testing::noisy_plane(3 * size / 10, 7 * size / 10, 0.003, testing::test_random());
    for (std::uint64_t seed = 0; seed < 10; ++seed) {
      const CloudProblem cloud_problem(cloud, 0.01, Scoring::msac, seed);
      const auto result = run(cloud_problem.problem, {.probability = 0.9999, .max_iterations = 2000, .seed = seed});
      ASSERT_TRUE(result.model);
      // n inliers with 3 mm noise on a square metre give the normal to about 3 mm / (0.29 m sqrt(n)); the inliers in the sample
      // count, some 300 and 1200: 0.6 and 0.3 mrad. Outliers within the threshold add a little.
      EXPECT_LT(angle_between(*result.model, truth), 4e-3);
      EXPECT_NEAR(result.model->d, truth.d, 4e-3);
    }
  }
}

TEST(NormalLimits, AllowAnglesOnBothSides) {
  const auto plane = [](double degrees) {
    const double a = degrees * std::numbers::pi / 180.0;
    return *make_plane({std::sin(a), 0.0, std::cos(a)}, 1.0);
  };
  const NormalLimits parallel = NormalLimits::parallel({0.0, 0.0, -3.0}, 10.0 * std::numbers::pi / 180.0);
  const NormalLimits perpendicular = NormalLimits::perpendicular({0.0, 0.0, 2.0}, 10.0 * std::numbers::pi / 180.0);
  for (const double side : {-1.0, 1.0}) {
    EXPECT_TRUE(parallel.allow(plane(side * 9.9)));
    EXPECT_TRUE(parallel.allow(plane(180.0 - side * 9.9)));
    EXPECT_FALSE(parallel.allow(plane(side * 10.1)));
    EXPECT_TRUE(perpendicular.allow(plane(90.0 + side * 9.9)));
    EXPECT_FALSE(perpendicular.allow(plane(90.0 + side * 10.1)));
  }
}

TEST(PlaneProblem, NoModelLeavesTheLimits) {
  // Most points are on z = 1, some on x = 1: only the latter is allowed, and neither a sample nor a fit may be anything else.
  RandomStream random = testing::test_random();
  std::vector<Eigen::Vector3d> points;
  for (int i = 0; i < 6000; ++i) {
    const double a = testing::uniform(random, -1.0, 1.0);
    const double b = testing::uniform(random, -1.0, 1.0);
    points.emplace_back(i % 5 == 0 ? Eigen::Vector3d(1.0, a, b) : Eigen::Vector3d(a, b, 1.0));
  }
  const PointCloud cloud = testing::cloud_of(points);
  const CloudData data(cloud);
  PointCloud sample;
  const NormalLimits limits = NormalLimits::parallel({1.0, 0.0, 0.0}, 0.2);
  const PlaneProblem problem(data, 0.01, Scoring::msac, 0, 0, sample, limits);
  const auto result = run(problem, {.probability = 0.999});
  ASSERT_TRUE(result.model);
  EXPECT_LT((result.model->normal.cwiseAbs() - Eigen::Vector3d::UnitX()).norm(), 1e-3);
  EXPECT_FALSE(problem.refine(*make_plane({0.0, 0.0, -1.0}, 1.0)));
  EXPECT_FALSE(problem.refine_on_all(*make_plane({0.0, 0.0, -1.0}, 1.0)));
  const NormalLimits none = NormalLimits::parallel({0.0, 1.0, 0.0}, 0.01);
  const PlaneProblem impossible(data, 0.001, Scoring::msac, 0, 0, sample, none);
  const auto nothing = run(impossible, {.max_iterations = 5});
  EXPECT_TRUE(!nothing.model || none.allow(*nothing.model));
}

TEST(PlaneProblem, RefineFitsTheInliersOnly) {
  // Four corners of z = 1 and a point far off it: the refined plane is exact, however tilted the first one was.
  const PointCloud cloud = testing::cloud_of({{-1, -1, 1}, {1, -1, 1}, {-1, 1, 1}, {1, 1, 1}, {0, 0, 3}});
  const CloudProblem cloud_problem(cloud, 0.1, Scoring::inliers);
  const auto refined = cloud_problem.problem.refine(*make_plane({0.05, -0.03, -1.0}, 1.0));
  ASSERT_TRUE(refined);
  EXPECT_LT((refined->normal - Vector3d(0, 0, -1)).norm(), 1e-12);
  EXPECT_NEAR(refined->d, 1.0, 1e-12);
  EXPECT_FALSE(cloud_problem.problem.refine(*make_plane({0, 0, -1}, 50.0)));  // no inliers
}

// ---- all points of a cloud ----

TEST(CloudData, ScoresManyPlanesOverManyPoints) {
  RandomStream random = testing::test_random();
  const PointCloud cloud = testing::noisy_plane(40000, 30003, 0.005, random);  // more than one task
  for (int i = 0; i < 20; ++i) {
    const Plane plane = random_plane(cloud, random);
    const PlainScore expected = plain_score(cloud, plane, 0.01, cloud.size());
    for (const Scoring scoring : kScorings) {
      const Score score = CloudData(cloud).score(plane, 0.01F, scoring, kNothingToBeat);
      EXPECT_NEAR(static_cast<double>(score.inliers), expected.inliers, expected.undecided);
      EXPECT_NEAR(score.value, expected.value(scoring), 1e-4 * expected.gain + expected.undecided);
      for (const int threads : {2, 5}) {
        const Score threaded = CloudData(cloud, threads).score(plane, 0.01F, scoring, kNothingToBeat);
        EXPECT_EQ(threaded.value, score.value);
        EXPECT_EQ(threaded.inliers, score.inliers);
      }
    }
  }
}

TEST(CloudData, BailOutNeverRaisesALoserNorTouchesAWinner) {
  RandomStream random = testing::test_random();
  const PointCloud cloud = testing::noisy_plane(100000, 100000, 0.004, random);
  int early = 0;
  for (const Scoring scoring : kScorings) {
    for (const int threads : {1, 2}) {
      const CloudData data(cloud, threads);
      for (int i = 0; i < 15; ++i) {
        const Plane plane = random_plane(cloud, random);
        early += testing::expect_bail_out_is_fair(data, plane, 0.01F, scoring, {1000.0, 10000.0, 50000.0, 199999.0});
      }
    }
  }
  EXPECT_GT(early, 10);
}

TEST(CloudData, BailOutWaitsForInliersThatComeLast) {
  // 2^17 points far off the plane, then 2^16 on it: the plane can win until the last point has been seen.
  constexpr int kFar = 1 << 17;
  constexpr int kOn = 1 << 16;
  std::vector<Vector3d> points;
  for (int i = 0; i < kFar + kOn; ++i) points.emplace_back(i % 64, i / 64, i < kFar ? 5.0 : 1.0);
  const PointCloud cloud = testing::cloud_of(points);
  const Plane plane = *make_plane({0, 0, -1}, 1.0);
  for (const Scoring scoring : kScorings) {
    const Score score = CloudData(cloud).score(plane, 0.01F, scoring, {kOn - 1.0, kOn - 1});
    EXPECT_EQ(score.value, kOn);
    EXPECT_EQ(score.inliers, static_cast<std::uint64_t>(kOn));
  }
}

TEST(CloudData, DrawsAllInOrderWhenAskedForAsMany) {
  RandomStream random = testing::test_random();
  PointCloud cloud = testing::noisy_plane(20, 13, 0.1, random);
  cloud.origin = {1, 2, 3};
  for (const std::uint32_t n : {33U, 34U, 4096U}) {
    PointCloud sample = testing::cloud_of({{7, 7, 7}});
    CloudData(cloud).draw(random, n, sample);
    ASSERT_EQ(sample.size(), cloud.size());
    EXPECT_EQ(sample.origin, cloud.origin);
    for (std::size_t i = 0; i < cloud.size(); ++i) EXPECT_EQ(sample.local(i), cloud.local(i));
  }
}

TEST(CloudData, DrawsUniformlyWithReplacement) {
  // Point i lies at x = i, so a drawn point tells its number.
  constexpr std::size_t kPoints = 100;
  constexpr std::uint32_t kDrawn = 50;
  constexpr int kDraws = 2000;
  std::vector<Vector3d> points;
  for (std::size_t i = 0; i < kPoints; ++i) points.emplace_back(static_cast<double>(i), 1.0, 2.0);
  const PointCloud cloud = testing::cloud_of(points);
  RandomStream random = testing::test_random();
  std::vector<int> counts(kPoints);
  PointCloud sample;
  int with_repeats = 0;
  for (int draw = 0; draw < kDraws; ++draw) {
    CloudData(cloud).draw(random, kDrawn, sample);
    ASSERT_EQ(sample.size(), kDrawn);
    std::vector<float> x(sample.x(), sample.x() + kDrawn);
    for (const float i : x) ++counts[static_cast<std::size_t>(i)];
    std::sort(x.begin(), x.end());
    with_repeats += static_cast<int>(std::adjacent_find(x.begin(), x.end()) != x.end());
    for (std::size_t i = kDrawn; i < sample.padded_size(); ++i) EXPECT_TRUE(std::isnan(sample.z()[i]));
  }
  EXPECT_EQ(with_repeats, kDraws);  // 50 of 100 without a repeat: one in 10^7
  constexpr double kExpected = kDraws * kDrawn / static_cast<double>(kPoints);
  double chi_square = 0.0;
  for (const int count : counts) chi_square += (count - kExpected) * (count - kExpected) / kExpected;
  EXPECT_LT(chi_square, 148.2);  // 99 degrees of freedom: exceeded with probability 0.001
}

TEST(PlaneProblem, TheSampleFollowsFromSeedAndRound) {
  const PointCloud cloud = testing::noisy_plane(3000, 3000, 0.01, testing::test_random());
  const CloudData data(cloud);
  const auto sample_of = [&](std::uint64_t seed, std::uint32_t round) {
    PointCloud sample;
    const PlaneProblem problem(data, 0.01, Scoring::msac, seed, round, sample);
    EXPECT_EQ(problem.num_data(), 6000U);
    EXPECT_EQ(problem.num_sampled(), kSampledData);
    return std::vector<float>(sample.x(), sample.x() + sample.size());
  };
  EXPECT_EQ(sample_of(3, 1), sample_of(3, 1));
  EXPECT_NE(sample_of(3, 1), sample_of(3, 2));
  EXPECT_NE(sample_of(3, 1), sample_of(4, 1));
}

// ---- least squares ----

Moments moments_of(const std::vector<Vector3d>& points) {
  Moments moments;
  for (const Vector3d& p : points) moments.add(p);
  return moments;
}

TEST(FitPlane, FourCorners) {
  const auto fit = fit_plane(moments_of({{-1, -2, 5}, {1, -2, 5}, {-1, 2, 5}, {1, 2, 5}}));
  ASSERT_TRUE(fit);
  EXPECT_EQ(fit->points, 4U);
  EXPECT_LT((fit->plane.normal - Vector3d(0, 0, -1)).norm(), 1e-14);
  EXPECT_NEAR(fit->plane.d, 5.0, 1e-13);
  EXPECT_LT(fit->rms_m, 1e-7);  // the square root of a rounding error at 25 m^2
}

TEST(FitPlane, OffsetsThatCancelAreTheRms) {
  // Diagonal corners 0.1 m above, the other two 0.1 m below: no tilt explains any of it.
  const auto fit = fit_plane(moments_of({{1, 2, 0.1}, {-1, -2, 0.1}, {1, -2, -0.1}, {-1, 2, -0.1}}));
  ASSERT_TRUE(fit);
  EXPECT_NEAR(fit->rms_m, 0.1, 1e-12);
  EXPECT_NEAR(std::abs(fit->plane.normal.z()), 1.0, 1e-12);
  EXPECT_NEAR(fit->plane.d, 0.0, 1e-12);
}

TEST(FitPlane, MinimisesTheDistanceAlongTheNormalNotAlongZ) {
  // A steep plane: least squares in z would not even be defined for x = const.
  RandomStream random = testing::test_random();
  std::vector<Vector3d> points;
  for (int i = 0; i < 1000; ++i) {
    const double y = testing::uniform(random, -1.0, 1.0);
    points.emplace_back(2.0 + (i % 2 == 0 ? 0.01 : -0.01), y, testing::uniform(random, -1.0, 1.0));
  }
  const auto fit = fit_plane(moments_of(points));
  ASSERT_TRUE(fit);
  EXPECT_GT(std::abs(fit->plane.normal.x()), 0.99999);
  EXPECT_NEAR(fit->rms_m, 0.01, 1e-5);
}

TEST(FitPlane, KnownNoiseGivesItsRms) {
  RandomStream random = testing::test_random();
  const Plane truth = *make_plane(testing::unit_vector(random), 2.0);
  const Vector3d e1 = truth.normal.unitOrthogonal();
  const Vector3d e2 = truth.normal.cross(e1);
  Moments moments;
  constexpr int kPoints = 20000;
  for (int i = 0; i < kPoints; ++i) {
    const double a = testing::uniform(random, -1.0, 1.0);
    const double b = testing::uniform(random, -1.0, 1.0);
    moments.add(-truth.d * truth.normal + a * e1 + b * e2 + 0.01 * random.normal() * truth.normal);
  }
  const auto fit = fit_plane(moments);
  ASSERT_TRUE(fit);
  EXPECT_NEAR(fit->rms_m, 0.01, 4.0 * 0.01 / std::sqrt(2.0 * kPoints));  // 4 standard deviations
  EXPECT_LT(angle_between(fit->plane, truth),
            5.0 * 0.01 * std::sqrt(3.0 / kPoints));  // sigma / (spread sqrt(n)), spread 1 / sqrt(3)
  EXPECT_NEAR(fit->plane.d, truth.d, 5.0 * 0.01 / std::sqrt(1.0 * kPoints));
}

TEST(FitPlane, NothingForFewCollinearOrCoincidingPoints) {
  EXPECT_FALSE(fit_plane(Moments{}));
  EXPECT_FALSE(fit_plane(moments_of({{0, 0, 1}, {1, 0, 1}})));
  EXPECT_FALSE(fit_plane(moments_of(std::vector<Vector3d>(10, Vector3d(1.1, 2.2, 3.3)))));
  std::vector<Vector3d> line;
  for (int i = 0; i < 100; ++i) line.emplace_back(0.3 + 0.1 * i, 1.0 - 0.07 * i, 2.0 + 0.03 * i);
  EXPECT_FALSE(fit_plane(moments_of(line)));
}

TEST(FitPlane, ExtremeMomentsGiveNothingOrAPlane) {
  // Overflow must end in "nothing", never in a plane that is not finite.
  for (const double scale : {1e-200, 1e-30, 1e30, 1e100, 1e160, 1e300}) {
    const auto fit = fit_plane(moments_of({{scale, 0, scale}, {0, scale, scale}, {-scale, -scale, scale}}));
    if (!fit) continue;
    EXPECT_TRUE(fit->plane.normal.allFinite()) << scale;
    EXPECT_NEAR(fit->plane.d / scale, 1.0, 1e-6) << scale;
  }
}

TEST(FitPlane, AKilometreFromTheOrigin) {
  // A square metre at 1 km: the subtraction of the mean leaves about 1e-16 * 1e6 = 1e-10 m^2.
  RandomStream random = testing::test_random();
  const Plane truth = *make_plane({0.1, 0.2, -1.0}, 900.0);
  Moments moments;
  for (int i = 0; i < 1000; ++i) {
    const double x = 400.0 + random.uniform();
    const double y = -300.0 + random.uniform();
    moments.add({x, y, -(truth.normal.x() * x + truth.normal.y() * y + truth.d) / truth.normal.z()});
  }
  const auto fit = fit_plane(moments);
  ASSERT_TRUE(fit);
  EXPECT_LT(angle_between(fit->plane, truth), 1e-7);
  EXPECT_LT(fit->rms_m, 5e-5);
}

TEST(Moments, AddUp) {
  const std::vector<Vector3d> points{{1, 2, 3}, {4, 5, 6}, {-1, 0, 2}, {7, -3, 1}};
  Moments sum = moments_of({points[0], points[1]});
  sum += moments_of({points[2], points[3]});
  const Moments all = moments_of(points);
  EXPECT_EQ(sum.count, all.count);
  EXPECT_EQ(sum.sum, all.sum);
  EXPECT_EQ(sum.sum_outer, all.sum_outer);
  EXPECT_EQ(all.sum, Vector3d(11, 4, 12));
  EXPECT_EQ(all.sum_outer(0, 1), 2.0 + 20.0 + 0.0 - 21.0);
  EXPECT_EQ(all.sum_outer(1, 0), all.sum_outer(0, 1));
}

TEST(Moments, OfInliersOnly) {
  const PointCloud cloud = testing::cloud_of({{1, 2, 1}, {3, 4, 1.5}, {5, 6, 2.5}});
  const Moments moments = CloudData(cloud).inlier_moments(*make_plane({0, 0, 1}, -1), 0.5F);
  EXPECT_EQ(moments.count, 2U);
  EXPECT_EQ(moments.sum, Vector3d(4, 6, 2.5));
  EXPECT_EQ(moments.sum_outer(0, 2), 1.0 + 4.5);
  EXPECT_EQ(moments.sum_outer, moments.sum_outer.transpose().eval());
}

}  // namespace
}  // namespace fransac::sac
