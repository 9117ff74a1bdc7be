// SPDX-License-Identifier: Apache-2.0
// Drawings small enough to be classified by hand.
#include "fransac/eval/hoover.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "fransac/core/labels.hpp"

namespace fransac::eval {
namespace {

/// An image as a drawing, a row per line: '?' is 0 (ignored), '.' is 255 (no plane), digits are planes.
struct Drawing {
  std::vector<std::uint8_t> labels;
  int width = 0;

  explicit Drawing(std::string_view rows) {
    for (const char c : rows) {
      if (c == '\n') {
        width = width == 0 ? static_cast<int>(labels.size()) : width;
      } else if (c != ' ') {
        labels.push_back(c == '?' ? kLabelNoDepth : c == '.' ? kLabelNoPlane : static_cast<std::uint8_t>(c - '0'));
      }
    }
    if (width == 0) width = static_cast<int>(labels.size());
  }
};

constexpr HooverOptions kAnySize{.min_pixels = 1};

Result<HooverMetrics> classified(std::string_view truth, std::string_view predicted, double tolerance = kHooverTolerance,
                                 const HooverOptions& options = kAnySize) {
  const Drawing drawing(truth);
  return hoover(drawing.labels, Drawing(predicted).labels, drawing.width, tolerance, options);
}

/// "correct over under missed noise of predicted against true regions"
std::string counts(const Result<HooverMetrics>& metrics) {
  if (!metrics) return metrics.error().message;
  const HooverMetrics& m = *metrics;
  return std::to_string(m.correct) + " " + std::to_string(m.over_segmented) + " " + std::to_string(m.under_segmented) + " " +
         std::to_string(m.missed) + " " + std::to_string(m.noise) + " of " + std::to_string(m.predicted) + " against " +
         std::to_string(m.true_regions);
}

TEST(Hoover, CorrectNeedsTheToleranceOfBoth) {
  // 8 of the 10 true pixels, and 8 of the 10 predicted ones: at 0.8 exactly.
  EXPECT_EQ(counts(classified("1111111111..", "..1111111111")), "1 0 0 0 0 of 1 against 1");
  EXPECT_EQ(counts(classified("1111111111..", "..1111111111", 0.81)), "0 0 0 1 1 of 1 against 1");
  // All 8 predicted pixels are on it, but 8 of 11 are too few of the truth; and the reverse.
  EXPECT_EQ(counts(classified("11111111111", "11111111...")), "0 0 0 1 1 of 1 against 1");
  EXPECT_EQ(counts(classified("11111111...", "11111111111")), "0 0 0 1 1 of 1 against 1");
}

TEST(Hoover, LabelNumbersDoNotMatter) { EXPECT_EQ(counts(classified("1111.2222", "7777.3333")), "2 0 0 0 0 of 2 against 2"); }

TEST(Hoover, OverSegmentationIsOneTrueRegionUnderSeveral) {
  // 4 + 4 of 10 pixels, both parts wholly within.
  EXPECT_EQ(counts(classified("1111111111", "1111..2222")), "0 1 0 0 0 of 2 against 1");
  EXPECT_EQ(counts(classified("1111111111", "1111..2222", 0.85)), "0 0 0 1 2 of 2 against 1");  // 8 of 10 are too few
  // Part 2 has 3 of its 5 pixels on the region: no part of it, and part 1 alone is not enough.
  EXPECT_EQ(counts(classified("11111111..", "1111.22222")), "0 0 0 1 2 of 2 against 1");
}

TEST(Hoover, UnderSegmentationIsSeveralTrueRegionsUnderOne) {
  EXPECT_EQ(counts(classified("1111..2222", "1111111111")), "0 0 1 0 0 of 1 against 2");
  EXPECT_EQ(counts(classified("1111..2222", "1111111111", 0.85)), "0 0 0 2 1 of 1 against 2");
  // Part 1 has region 1 and 2 of the 5 pixels of region 2, which is no part of it; and 5 of its own 7 are too few.
  EXPECT_EQ(counts(classified("1111122222", "1111111...")), "0 0 0 2 1 of 1 against 2");
}

TEST(Hoover, MissedAndNoiseAreWhatIsLeft) {
  EXPECT_EQ(counts(classified("111122223333....", "1111........4444")), "1 0 0 2 1 of 2 against 3");
  EXPECT_EQ(counts(classified("1111", "....")), "0 0 0 1 0 of 0 against 1");
  EXPECT_EQ(counts(classified("....", "1111")), "0 0 0 0 1 of 1 against 0");
  EXPECT_EQ(counts(classified("", "", 0.8)), "width must divide the 0 pixels, not be 0");
}

TEST(Hoover, OfTwoClassesTheLargerMeanOverlapWins) {
  // Region 1 (20 pixels): part 1 has 16 of it and 2 elsewhere: correct, (16/20 + 16/18) / 2 = 0.844. Parts 1 and 2 (4 pixels
  // within): over-segmented, (16/18 + 4/4 + 20/20) / 3 = 0.963.
  EXPECT_EQ(counts(classified("11111111111111111111..", "2222111111111111111111")), "0 1 0 0 0 of 2 against 1");
  // Part 1 has 18 pixels, all within: correct, (18/20 + 18/18) / 2 = 0.95. Part 2 has 2 of its 3 within: over-segmented, (18/18 +
  // 2/3 + 20/20) / 3 = 0.889.
  EXPECT_EQ(counts(classified("11111111111111111111.", "111111111111111111222", 0.6)), "1 0 0 0 1 of 2 against 1");
  // Regions 1 (8) and 2 (2), part 1 on both (10): under-segmented, (1 + 1 + 1) / 3, against correct, (8/8 + 8/10) / 2.
  EXPECT_EQ(counts(classified("1111111122", "1111111111")), "0 0 1 0 0 of 1 against 2");
}

TEST(Hoover, OfEqualsTheFirstClassWins) {
  // Region 1 has 32 pixels. Part 1 has 22, all within: correct, (22/32 + 22/22) / 2 = 0.84375. Part 2 has 3 of its 4 within:
  // over-segmented, (22/22 + 3/4 + 25/32) / 3 = 0.84375.
  const std::string truth = std::string(32, '1') + ".";
  const std::string predicted = std::string(22, '1') + std::string(7, '.') + "2222";
  EXPECT_EQ(counts(classified(truth, predicted, 0.6)), "1 0 0 0 1 of 2 against 1");
}

TEST(Hoover, EveryRegionIsInOneClassAtMost) {
  // Part 1 covers region 1 (8) with 8 of its 9 pixels, and with its ninth, and part 2 (1), region 2 (2): region 2 has no class.
  const auto metrics = classified("1111111122", "1111111112");
  EXPECT_EQ(counts(metrics), "1 0 0 1 1 of 2 against 2");
}

TEST(Hoover, PredictionsAreSplitIntoPartsThatTouchAtCornersToo) {
  constexpr std::string_view kTruth =
      "11.22\n"
      "11.22\n";
  EXPECT_EQ(counts(classified(kTruth,
                              "11.11\n"
                              "11.11\n")),
            "2 0 0 0 0 of 2 against 2");
  // The diagonal is one part; where it is broken it is two. True regions are what the truth numbers, however many parts they
  // have.
  EXPECT_EQ(counts(classified("1...\n"
                              ".1..\n"
                              "..1.\n"
                              "...1\n",
                              "1...\n"
                              ".1..\n"
                              "..1.\n"
                              "...1\n")),
            "1 0 0 0 0 of 1 against 1");
  EXPECT_EQ(counts(classified("..1\n"
                              ".1.\n"
                              "1..\n",
                              "..1\n"
                              ".1.\n"
                              "1..\n")),
            "1 0 0 0 0 of 1 against 1");
  EXPECT_EQ(counts(classified("1.1\n"
                              "1.1\n",
                              "1.1\n"
                              "1.1\n")),
            "0 1 0 0 0 of 2 against 1");
  // The end of a row does not touch the beginning of the next.
  EXPECT_EQ(counts(classified("...1\n"
                              "....\n"
                              "2...\n",
                              "...1\n"
                              "1...\n"
                              "1...\n",
                              0.6)),
            "1 0 0 1 1 of 2 against 2");
}

TEST(Hoover, PartsMeetLateInARow) {
  // A fork that is two parts until its last row.
  EXPECT_EQ(counts(classified("1.1.1\n"
                              "1.1.1\n"
                              "11111\n",
                              "3.3.3\n"
                              "3.3.3\n"
                              "33333\n")),
            "1 0 0 0 0 of 1 against 1");
}

TEST(Hoover, SmallPartsAreLeftOut) {
  // Part 3 is one pixel on region 1 and, apart from it, one on no region.
  constexpr std::string_view kTruth = "11111111..22";
  constexpr std::string_view kPredicted = "111111.3.322";
  EXPECT_EQ(counts(classified(kTruth, kPredicted, 0.7, {.min_pixels = 1})), "1 1 0 0 1 of 4 against 2");
  EXPECT_EQ(counts(classified(kTruth, kPredicted, 0.7, {.min_pixels = 2})), "2 0 0 0 0 of 2 against 2");
  EXPECT_EQ(counts(classified(kTruth, kPredicted, 0.7, {.min_pixels = 3})), "1 0 0 1 0 of 1 against 2");
  EXPECT_EQ(counts(classified(kTruth, kPredicted, 0.7, {})), "0 0 0 2 0 of 0 against 2");  // 50 by default
}

TEST(Hoover, IgnoredPixelsCountForNothing) {
  // 4 of the 8 pixels of part 1 are ignored: the 4 others are the whole region.
  EXPECT_EQ(counts(classified("1111????", "11111111")), "1 0 0 0 0 of 1 against 1");
  // On pixels without depth, 0 in the prediction as in the truth, there is nothing.
  EXPECT_EQ(counts(classified("1111????", "1111????")), "1 0 0 0 0 of 1 against 1");
  // A part that lies mostly on ignored pixels is no noise; by half it is.
  EXPECT_EQ(counts(classified("1111.???", "1111.222")), "1 0 0 0 0 of 1 against 1");
  EXPECT_EQ(counts(classified("1111..???", "1111.2222")), "1 0 0 0 0 of 1 against 1");
  EXPECT_EQ(counts(classified("1111...??", "1111.2222")), "1 0 0 0 1 of 2 against 1");
}

TEST(Hoover, RegionsOfTheComparisonBeginAtTen) {
  // Values below 10 are judged, and no region: predicted pixels on them count against a part.
  const std::vector<std::uint8_t> truth{10, 10, 10, 10, 0, 9, 255, 255, 255, 255};
  const HooverOptions options{.truth = TrueRegions::segcomp, .min_pixels = 1};
  const auto classify = [&](const Drawing& predicted, double tolerance) {
    return counts(hoover(truth, predicted.labels, 10, tolerance, options));
  };
  EXPECT_EQ(classify(Drawing("1111..2222"), 0.8), "2 0 0 0 0 of 2 against 2");
  EXPECT_EQ(classify(Drawing("1111112222"), 0.8), "1 0 0 1 1 of 2 against 2");  // 4 of 6 pixels of part 1
  EXPECT_EQ(classify(Drawing("1111112222"), 0.66), "2 0 0 0 0 of 2 against 2");
  EXPECT_EQ(classify(Drawing("....11...."), 0.8), "0 0 0 2 1 of 1 against 2");
}

TEST(Hoover, SeveralTolerancesAtOnce) {
  const Drawing truth("1111111111..2222222222");
  const Drawing predicted("..11111111..2222222222");
  const std::vector<double> tolerances{0.95, 0.51, 0.8, 1.0};
  const auto metrics = hoover(truth.labels, predicted.labels, truth.width, tolerances, kAnySize);
  ASSERT_TRUE(metrics);
  ASSERT_EQ(metrics->size(), 4U);
  const int correct[] = {1, 2, 2, 1};
  for (std::size_t i = 0; i < tolerances.size(); ++i) {
    EXPECT_EQ((*metrics)[i].tolerance, tolerances[i]);
    EXPECT_EQ((*metrics)[i].correct, correct[i]) << tolerances[i];
    EXPECT_EQ(counts((*metrics)[i]), counts(hoover(truth.labels, predicted.labels, truth.width, tolerances[i], kAnySize)));
  }
}

TEST(Hoover, WhatDoesNotFitIsAnError) {
  const auto error = [](auto metrics) { return metrics ? "none" : metrics.error().message; };
  const Drawing drawing("1111\n1111\n");
  EXPECT_EQ(error(hoover(drawing.labels, Drawing("111").labels, 4)),
            "truth has 8 pixels, the prediction 3: the sizes must be equal");
  EXPECT_EQ(error(hoover(drawing.labels, drawing.labels, 3)), "width must divide the 8 pixels, not be 3");
  EXPECT_EQ(error(hoover(drawing.labels, drawing.labels, 0)), "width must divide the 8 pixels, not be 0");
  for (const double tolerance : {0.5, 1.01, -1.0, std::nan("")}) {
    const auto metrics = hoover(drawing.labels, drawing.labels, 4, tolerance);
    ASSERT_FALSE(metrics);
    EXPECT_EQ(metrics.error().code, ErrorCode::invalid_argument);
    EXPECT_NE(metrics.error().message.find("tolerance must be above 0.5 and at most 1"), std::string::npos);
  }
  EXPECT_EQ(error(hoover(drawing.labels, drawing.labels, 4, 0.8, {.min_pixels = 0})), "min_pixels must be at least 1, not 0");
}

}  // namespace
}  // namespace fransac::eval
