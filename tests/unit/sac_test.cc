// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <optional>
#include <span>
#include <vector>

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

/// The location of scalars: two different numbers propose their mean; inliers lie within 1 of it.
struct Location {
  using Model = double;
  static constexpr int kSampleSize = 2;

  std::vector<double> data;

  [[nodiscard]] std::uint32_t num_data() const { return static_cast<std::uint32_t>(data.size()); }
  [[nodiscard]] std::optional<double> generate(const std::array<std::uint32_t, 2>& sample) const {
    if (data[sample[0]] == data[sample[1]]) return std::nullopt;
    return (data[sample[0]] + data[sample[1]]) / 2.0;
  }
  [[nodiscard]] bool is_inlier(double model, std::uint32_t i) const { return std::abs(data[i] - model) <= 1.0; }
  [[nodiscard]] Score score_of(double model) const {
    Score score;
    for (std::uint32_t i = 0; i < num_data(); ++i) score.inliers += static_cast<std::uint64_t>(is_inlier(model, i));
    score.value = static_cast<double>(score.inliers);
    return score;
  }
  void score(std::span<const double> models, const Score& to_beat, std::span<Score> scores) const {
    std::transform(models.begin(), models.end(), scores.begin(), [&](double model) { return score_of(model); });
    for (Score& s : scores) {
      if (s.value <= to_beat.value) s = {};  // what the concept permits: losers may get any smaller score
    }
  }
  [[nodiscard]] std::optional<double> refine(double model) const {
    double sum = 0.0;
    std::uint32_t count = 0;
    for (std::uint32_t i = 0; i < num_data(); ++i) {
      if (!is_inlier(model, i)) continue;
      sum += data[i];
      ++count;
    }
    if (count == 0) return std::nullopt;
    return sum / count;
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

/// The loop as one would write it without batches, threads or bail-out: the truth for the one in the library.
template <SamplingProblem Problem>
RansacResult<typename Problem::Model> plain_ransac(const Problem& problem, const RansacOptions& options) {
  using Model = typename Problem::Model;
  RansacResult<Model> best;
  const Score nothing_to_beat{-1.0, 0};
  std::uint64_t needed = options.max_iterations;
  for (std::uint64_t i = 0; i < needed; ++i) {
    RandomStream random(options.seed, (std::uint64_t{options.round} << 32) + i);
    ++best.iterations;
    std::optional<Model> model;
    for (int attempt = 0; attempt < 100 && !model; ++attempt) {
      model = problem.generate(draw_sample<Problem::kSampleSize>(random, problem.num_data()));
      if (!model) ++best.degenerate;
    }
    if (!model) continue;
    bool passed = true;
    for (int d = 0; d < options.pretest_points && passed; ++d)
      passed = problem.is_inlier(*model, random.below(problem.num_data()));
    if (!passed) {
      ++best.rejected;
      continue;
    }
    Score score;
    problem.score(std::span(&*model, 1), nothing_to_beat, std::span(&score, 1));
    if (score.value <= best.score.value) continue;
    best.model = model;
    best.score = score;
    if (options.local_optimisation) optimise_locally(problem, best);
    const double q = static_cast<double>(best.score.inliers) / problem.num_data();
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
  EXPECT_EQ(a.stop_reason, b.stop_reason);
}

template <SamplingProblem Problem>
RansacResult<typename Problem::Model> run(const Problem& problem, const RansacOptions& options) {
  RansacWorkspace<typename Problem::Model> work;
  return ransac(problem, options, work);
}

TEST(Ransac, IsThePlainLoopAtAnyNumberOfThreads) {
  // The number of threads sets the size of the batches too: each ends at other hypotheses.
  RansacWorkspace<double> work;  // reused throughout: what is left in it must not matter
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
    RansacResult<double> best;
    best.model = 0.9 * std::sin(static_cast<double>(i));
    best.score = problem.score_of(*best.model);
    const double before = best.score.value;
    optimise_locally(problem, best);
    EXPECT_GE(best.score.value, before);
    EXPECT_EQ(best.score.value, problem.score_of(*best.model).value);
    raised += static_cast<int>(best.score.value > before);
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

  [[nodiscard]] std::uint32_t num_data() const { return size; }
  [[nodiscard]] std::optional<int> generate(const std::array<std::uint32_t, 3>& /*sample*/) const { return 1; }
  [[nodiscard]] bool is_inlier(int model, std::uint32_t i) const { return model == 1 && i < inliers; }
  void score(std::span<const int> models, const Score& /*to_beat*/, std::span<Score> scores) const {
    std::transform(models.begin(), models.end(), scores.begin(), [&](int m) {
      return m == 1 ? Score{1.0 * inliers, inliers} : Score{};
    });
  }
  [[nodiscard]] std::optional<int> refine(int model) const { return model; }
};

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

/// Points on the unit square of the plane z = 1 + 0.3 x - 0.2 y with normal noise, then outliers in the cube around it.
PointCloud noisy_plane(std::size_t inliers, std::size_t outliers, double noise_m, RandomStream random) {
  std::vector<Vector3d> points;
  for (std::size_t i = 0; i < inliers; ++i) {
    const double x = random.uniform();
    const double y = random.uniform();
    points.emplace_back(x, y, 1.0 + 0.3 * x - 0.2 * y + noise_m * random.normal());
  }
  for (std::size_t i = 0; i < outliers; ++i) points.push_back(testing::uniform_point(random, 0.0, 2.0));
  return testing::cloud_of(points);
}

Plane random_plane(const PointCloud& cloud, RandomStream& random) {
  for (;;) {
    const auto s = draw_sample<3>(random, static_cast<std::uint32_t>(cloud.size()));
    if (const auto plane = plane_through(cloud.local(s[0]), cloud.local(s[1]), cloud.local(s[2]))) return *plane;
  }
}

TEST(PlaneProblem, ScoresClosedForm) {
  // Distances 0, t/2, t (an inlier: eq. 1 includes the end), -t/4, 2t from z = 1; all are exact in float.
  const PointCloud cloud = testing::cloud_of({{3, 4, 1}, {1, 1, 1.25}, {-2, 0, 1.5}, {0, 5, 0.875}, {0, 0, 2}});
  const Plane plane = *make_plane({0, 0, 1}, -1);
  Score score;
  PlaneProblem(cloud, 0.5, Scoring::inliers).score(std::span(&plane, 1), {-1.0, 0}, std::span(&score, 1));
  EXPECT_EQ(score.inliers, 4U);
  EXPECT_EQ(score.value, 4.0);
  PlaneProblem(cloud, 0.5, Scoring::msac).score(std::span(&plane, 1), {-1.0, 0}, std::span(&score, 1));
  EXPECT_EQ(score.inliers, 4U);
  EXPECT_EQ(score.value, 1.0 + 0.75 + 0.0 + 0.9375);
}

TEST(PlaneProblem, ScoresManyPlanesOverManyPoints) {
  RandomStream random = testing::test_random();
  const PointCloud cloud = noisy_plane(3000, 2003, 0.005, random);
  std::vector<Plane> planes;
  for (int i = 0; i < 130; ++i) planes.push_back(random_plane(cloud, random));
  for (const Scoring scoring : {Scoring::inliers, Scoring::msac}) {
    const PlaneProblem problem(cloud, 0.01, scoring);
    std::vector<Score> scores(planes.size());
    problem.score(planes, {-1.0, 0}, scores);
    for (std::size_t m = 0; m < planes.size(); ++m) {
      std::uint64_t inliers = 0;
      double gain = 0.0;
      int at_the_border = 0;  // float and double may disagree there
      for (std::size_t i = 0; i < cloud.size(); ++i) {
        const double share = planes[m].signed_distance(cloud.local(i)) / 0.01;
        at_the_border += static_cast<int>(std::abs(std::abs(share) - 1.0) < 1e-4);
        if (std::abs(share) > 1.0) continue;
        ++inliers;
        gain += 1.0 - share * share;
      }
      EXPECT_NEAR(static_cast<double>(scores[m].inliers), static_cast<double>(inliers), at_the_border);
      EXPECT_NEAR(scores[m].value, scoring == Scoring::msac ? gain : static_cast<double>(inliers), 1e-4 * gain + at_the_border);
    }
  }
}

TEST(PlaneProblem, BailOutNeverRaisesALoserNorTouchesAWinner) {
  RandomStream random = testing::test_random();
  const PointCloud cloud = noisy_plane(4000, 4000, 0.004, random);
  std::vector<Plane> planes;
  for (int i = 0; i < 60; ++i) planes.push_back(random_plane(cloud, random));
  for (const Scoring scoring : {Scoring::inliers, Scoring::msac}) {
    const PlaneProblem problem(cloud, 0.01, scoring);
    std::vector<Score> full(planes.size());
    problem.score(planes, {-1.0, 0}, full);
    for (const double to_beat : {50.0, 300.0, 1000.0, 3000.0}) {
      std::vector<Score> scores(planes.size());
      problem.score(planes, {to_beat, 0}, scores);
      for (std::size_t m = 0; m < planes.size(); ++m) {
        if (full[m].value > to_beat) {
          EXPECT_EQ(scores[m].value, full[m].value);
          EXPECT_EQ(scores[m].inliers, full[m].inliers);
        } else {
          EXPECT_LE(scores[m].value, to_beat);
        }
      }
    }
  }
}

TEST(PlaneProblem, BailOutWaitsForInliersThatComeLast) {
  // 4096 points far off the plane, then 2048 on it: the plane can win until the last point has been seen.
  std::vector<Vector3d> points;
  for (int i = 0; i < 6144; ++i) points.emplace_back(i % 64, i / 64, i < 4096 ? 5.0 : 1.0);
  const PointCloud cloud = testing::cloud_of(points);
  const Plane plane = *make_plane({0, 0, -1}, 1.0);
  for (const Scoring scoring : {Scoring::inliers, Scoring::msac}) {
    Score score;
    PlaneProblem(cloud, 0.01, scoring).score(std::span(&plane, 1), {2047.0, 2047}, std::span(&score, 1));
    EXPECT_EQ(score.value, 2048.0);
    EXPECT_EQ(score.inliers, 2048U);
  }
}

TEST(PlaneProblem, LoopIsThePlainLoopAtAnyNumberOfThreads) {
  // The plain loop scores every hypothesis on all points: bail-out, batches and threads change nothing.
  const PointCloud cloud = noisy_plane(1500, 3500, 0.004, testing::test_random());
  for (const Scoring scoring : {Scoring::inliers, Scoring::msac}) {
    const PlaneProblem problem(cloud, 0.01, scoring);
    for (const int pretest_points : {0, 1}) {
      for (std::uint64_t seed = 0; seed < 3; ++seed) {
        RansacOptions options{.max_iterations = 400, .pretest_points = pretest_points, .seed = seed};
        const auto expected = plain_ransac(problem, options);
        ASSERT_TRUE(expected.model);
        for (const int threads : {1, 2, 5}) {
          options.threads = threads;
          expect_equal(run(problem, options), expected);
        }
      }
    }
  }
}

TEST(PlaneProblem, FindsThePlaneUnderOutliers) {
  const Plane truth = *make_plane({0.3, -0.2, -1.0}, 1.0);
  const PointCloud cloud = noisy_plane(3000, 7000, 0.003, testing::test_random());
  for (std::uint64_t seed = 0; seed < 10; ++seed) {
    const PlaneProblem problem(cloud, 0.01, Scoring::msac);
    const auto result = run(problem, {.probability = 0.9999, .max_iterations = 2000, .seed = seed});
    ASSERT_TRUE(result.model);
    // 3000 points with 3 mm noise on a square metre give the normal to about 3 mm / (0.29 m sqrt(3000)) = 0.2 mrad.
    EXPECT_LT(angle_between(*result.model, truth), 2e-3);
    EXPECT_NEAR(result.model->d, truth.d, 2e-3);
  }
}

TEST(PlaneProblem, RefineFitsTheInliersOnly) {
  // Four corners of z = 1 and a point far off it: the refined plane is exact, however tilted the first one was.
  const PointCloud cloud = testing::cloud_of({{-1, -1, 1}, {1, -1, 1}, {-1, 1, 1}, {1, 1, 1}, {0, 0, 3}});
  const PlaneProblem problem(cloud, 0.1, Scoring::inliers);
  const auto refined = problem.refine(*make_plane({0.05, -0.03, -1.0}, 1.0));
  ASSERT_TRUE(refined);
  EXPECT_LT((refined->normal - Vector3d(0, 0, -1)).norm(), 1e-12);
  EXPECT_NEAR(refined->d, 1.0, 1e-12);
  EXPECT_FALSE(problem.refine(*make_plane({0, 0, -1}, 50.0)));  // no inliers
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
  const Moments moments = inlier_moments(cloud, *make_plane({0, 0, 1}, -1), 0.5);
  EXPECT_EQ(moments.count, 2U);
  EXPECT_EQ(moments.sum, Vector3d(4, 6, 2.5));
  EXPECT_EQ(moments.sum_outer(0, 2), 1.0 + 4.5);
  EXPECT_EQ(moments.sum_outer, moments.sum_outer.transpose().eval());
}

}  // namespace
}  // namespace fransac::sac
