// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <numbers>
#include <string_view>
#include <vector>

#include "fransac/core/labels.hpp"
#include "fransac/eval/metrics.hpp"

namespace fransac::eval {
namespace {

using Labels = std::vector<std::uint8_t>;

/// A mask as a drawing: '?' is 0 (no depth, ignored), '.' is 255 (no plane), digits are planes; blanks are skipped.
Labels mask(std::string_view drawing) {
  Labels labels;
  for (const char c : drawing) {
    if (c == ' ') continue;
    if (c == '?') {
      labels.push_back(kLabelNoDepth);
    } else if (c == '.') {
      labels.push_back(kLabelNoPlane);
    } else {
      labels.push_back(static_cast<std::uint8_t>(c - '0'));
    }
  }
  return labels;
}

/// `count` pixels of one label.
void append(Labels& labels, int count, std::uint8_t label) {
  labels.insert(labels.end(), static_cast<std::size_t>(count), label);
}

TEST(Detection, RatiosByHand) {
  const Detection detection{6, 2, 4};
  EXPECT_DOUBLE_EQ(detection.precision(), 0.75);
  EXPECT_DOUBLE_EQ(detection.recall(), 0.6);
  EXPECT_DOUBLE_EQ(detection.f1(), 2.0 * 0.75 * 0.6 / (0.75 + 0.6));
}

TEST(Detection, NothingIsZeroNotNaN) {
  const Detection nothing;
  EXPECT_EQ(nothing.precision(), 0.0);
  EXPECT_EQ(nothing.recall(), 0.0);
  EXPECT_EQ(nothing.f1(), 0.0);
}

TEST(DominantPlane, CountsOnlyJudgedPixels) {
  // Ignored pixels (first block) may be anything; a judged pixel without predicted depth is a miss.
  const auto detection = dominant_plane(mask("??? 11111 222 .."), mask("112 1112? 11. 1."));
  ASSERT_TRUE(detection);
  EXPECT_EQ(detection->true_positives, 3U);
  EXPECT_EQ(detection->false_positives, 3U);
  EXPECT_EQ(detection->false_negatives, 2U);
}

TEST(DominantPlane, OfAnotherPredictedLabel) {
  const auto detection = dominant_plane(mask("1111 ...."), mask("2221 2..1"), 2);
  ASSERT_TRUE(detection);
  EXPECT_EQ(detection->true_positives, 3U);
  EXPECT_EQ(detection->false_positives, 1U);
  EXPECT_EQ(detection->false_negatives, 1U);
}

TEST(DominantPlane, DifferentSizesAreAnError) {
  const auto detection = dominant_plane(mask("111"), mask("1111"));
  ASSERT_FALSE(detection);
  EXPECT_EQ(detection.error().code, ErrorCode::invalid_argument);
  EXPECT_NE(detection.error().message.find("3 labels"), std::string::npos);
  EXPECT_FALSE(best_overlap(mask("1"), mask("")));
  EXPECT_FALSE(matched_plane(mask("1"), mask("")));
  EXPECT_FALSE(instance_metrics(mask("1"), mask("")));
}

TEST(FirstJudgedPlane, HasAtLeastHalfOfItsPixelsWhereTheTruthIsNotIgnored) {
  const auto first = [](std::string_view truth, std::string_view predicted) {
    return static_cast<int>(first_judged_plane(mask(truth), mask(predicted)).value());
  };
  EXPECT_EQ(first("1111 ???", "1111 111"), 1);
  EXPECT_EQ(first("1111 ????", "1111 1111"), 1);    // exactly half
  EXPECT_EQ(first("1111 ?????", "1111 11111"), 1);  // nothing else can be judged
  EXPECT_EQ(first("1111 2222 ?????", "1111 3333 11111"), 3);
  EXPECT_EQ(first("1111 .... ?????", "1111 3333 11111"), 3);  // judged, and wrong
  EXPECT_EQ(first("1111 ?????", "3333 22222"), 3);            // plane 2 is on no judged pixel at all
  EXPECT_EQ(first("1111", "...?"), 1);
  EXPECT_FALSE(first_judged_plane(mask("11"), mask("1")));
}

TEST(FirstJudgedPlane, IsPlaneOneWhereNoneIsGiven) {
  const Labels truth = mask("1111 2222 ?????");
  const Labels predicted = mask("333. 1111 11111");
  const auto dominant = dominant_plane(truth, predicted);
  ASSERT_TRUE(dominant);
  EXPECT_EQ(dominant->true_positives, 3U);
  EXPECT_EQ(dominant->false_positives, 0U);
  EXPECT_EQ(dominant->false_negatives, 1U);
  const auto matched = matched_plane(truth, predicted);
  ASSERT_TRUE(matched);
  EXPECT_EQ(matched->label, 1);
  EXPECT_EQ(matched->detection.true_positives, 3U);
  const auto given = dominant_plane(truth, predicted, 1);
  ASSERT_TRUE(given);
  EXPECT_EQ(given->false_positives, 4U);
  EXPECT_EQ(matched_plane(truth, predicted, 1)->label, 2);
}

TEST(BestOverlap, TakesThePlaneThatOverlapsMost) {
  const auto best = best_overlap(mask("111111 222222"), mask("133333 111111"));
  ASSERT_TRUE(best);
  EXPECT_EQ(best->label, 3);
  EXPECT_EQ(best->detection.true_positives, 5U);
  EXPECT_EQ(best->detection.false_positives, 0U);
  EXPECT_EQ(best->detection.false_negatives, 1U);
}

TEST(BestOverlap, TieGoesToTheLowerLabel) {
  const auto best = best_overlap(mask("1111"), mask("4422"));
  ASSERT_TRUE(best);
  EXPECT_EQ(best->label, 2);
}

TEST(BestOverlap, NoPlaneAndNoDepthAreNoCandidates) {
  const auto best = best_overlap(mask("1111 22"), mask("...? 11"));
  ASSERT_TRUE(best);
  EXPECT_EQ(best->label, 0);
  EXPECT_EQ(best->detection.true_positives, 0U);
  EXPECT_EQ(best->detection.false_positives, 0U);
  EXPECT_EQ(best->detection.false_negatives, 4U);
}

TEST(MatchedPlane, TakesTheTruePlaneWithTheLargestF1) {
  // Predicted plane 1 has 7 judged pixels: 3 on plane 1 (12 pixels: F1 6/19), 3 on plane 2 (4 pixels: F1 6/11), 1 on no plane.
  const auto matched = matched_plane(mask("111111111111 2222 .. ??"), mask("111......... 1112 1. 11"));
  ASSERT_TRUE(matched);
  EXPECT_EQ(matched->label, 2);
  EXPECT_EQ(matched->detection.true_positives, 3U);
  EXPECT_EQ(matched->detection.false_positives, 4U);
  EXPECT_EQ(matched->detection.false_negatives, 1U);
  EXPECT_DOUBLE_EQ(matched->detection.precision(), 3.0 / 7.0);
  EXPECT_DOUBLE_EQ(matched->detection.recall(), 3.0 / 4.0);
  EXPECT_DOUBLE_EQ(matched->detection.f1(), 6.0 / 11.0);
}

TEST(MatchedPlane, LargestOverlapNeedNotBeTheLargestF1) {
  // 5 of plane 1's 20 pixels (F1 10/28), all 3 of plane 254 (F1 6/11).
  Labels truth(20, 1);
  Labels predicted(15, kLabelNoPlane);
  append(truth, 3, 254);
  append(predicted, 8, 1);
  const auto matched = matched_plane(truth, predicted);
  ASSERT_TRUE(matched);
  EXPECT_EQ(matched->label, 254);
  EXPECT_DOUBLE_EQ(matched->detection.f1(), 6.0 / 11.0);
}

TEST(MatchedPlane, WithOneTruePlaneItIsTheDominantPlanes) {
  const Labels truth = mask("11111 ...");
  const Labels predicted = mask("1112. 1..");
  const auto matched = matched_plane(truth, predicted);
  const auto dominant = dominant_plane(truth, predicted);
  ASSERT_TRUE(matched && dominant);
  EXPECT_EQ(matched->label, 1);
  EXPECT_EQ(matched->detection.true_positives, dominant->true_positives);
  EXPECT_EQ(matched->detection.false_positives, dominant->false_positives);
  EXPECT_EQ(matched->detection.false_negatives, dominant->false_negatives);
}

TEST(MatchedPlane, TieGoesToTheLowerLabel) {
  const auto matched = matched_plane(mask("33 22 .."), mask("11 11 .."));
  ASSERT_TRUE(matched);
  EXPECT_EQ(matched->label, 2);
}

TEST(MatchedPlane, NoPlaneAndIgnoredPixelsAreNoCandidates) {
  const auto matched = matched_plane(mask("... ?? 11"), mask("111 11 22"));
  ASSERT_TRUE(matched);
  EXPECT_EQ(matched->label, 0);
  EXPECT_EQ(matched->detection.true_positives, 0U);
  EXPECT_EQ(matched->detection.false_positives, 3U);
  EXPECT_EQ(matched->detection.f1(), 0.0);
  const auto other = matched_plane(mask("... ?? 11"), mask("111 11 22"), 2);
  ASSERT_TRUE(other);
  EXPECT_EQ(other->label, 1);
  EXPECT_EQ(other->detection.f1(), 1.0);
}

TEST(InstanceMetrics, PerfectPrediction) {
  const Labels labels = mask("1111 2222 33 .. ?");
  const auto metrics = instance_metrics(labels, labels);
  ASSERT_TRUE(metrics);
  EXPECT_EQ(metrics->true_planes, 3);
  EXPECT_EQ(metrics->predicted_planes, 3);
  for (const auto& at : {metrics->at50, metrics->at75}) {
    EXPECT_EQ(at.matched, 3);
    EXPECT_EQ(at.precision, 1.0);
    EXPECT_EQ(at.recall, 1.0);
    EXPECT_EQ(at.f1, 1.0);
    EXPECT_EQ(at.mean_iou, 1.0);
  }
  EXPECT_EQ(metrics->under_segmentation, 0.0);
  EXPECT_EQ(metrics->over_segmentation, 0.0);
  EXPECT_EQ(metrics->missed, 0.0);
  EXPECT_EQ(metrics->noise, 0.0);
  EXPECT_EQ(metrics->weighted_iou, 1.0);
  EXPECT_EQ(metrics->plane_pixel_f1, 1.0);
}

TEST(InstanceMetrics, LabelNumbersDoNotMatter) {
  const auto metrics = instance_metrics(mask("1111 2222"), mask("7777 3333"));
  ASSERT_TRUE(metrics);
  EXPECT_EQ(metrics->at75.matched, 2);
  EXPECT_EQ(metrics->weighted_iou, 1.0);
}

/// Three true ones with an IoU of 6/10, 4/6 and 1; four are predicted.
template <class Metrics>
void expect_matches_by_hand(const Metrics& metrics) {
  EXPECT_EQ(metrics.at50.threshold, 0.5);
  EXPECT_EQ(metrics.at50.matched, 3);
  EXPECT_DOUBLE_EQ(metrics.at50.precision, 3.0 / 4.0);
  EXPECT_DOUBLE_EQ(metrics.at50.recall, 1.0);
  EXPECT_DOUBLE_EQ(metrics.at50.f1, 6.0 / 7.0);
  EXPECT_DOUBLE_EQ(metrics.at50.mean_iou, (0.6 + 4.0 / 6.0 + 1.0) / 3.0);
  EXPECT_EQ(metrics.at75.threshold, 0.75);
  EXPECT_EQ(metrics.at75.matched, 1);
  EXPECT_DOUBLE_EQ(metrics.at75.precision, 1.0 / 4.0);
  EXPECT_DOUBLE_EQ(metrics.at75.recall, 1.0 / 3.0);
  EXPECT_DOUBLE_EQ(metrics.at75.mean_iou, 1.0);
}

TEST(InstanceMetrics, ThresholdsByHand) {
  // Plane 1: 10 pixels, 6 found by label 1: IoU 6/10. Plane 2: 5 pixels, 4 found by label 2, which has one more elsewhere: IoU
  // 4/6. Plane 3: 4 pixels, all found and nothing else: IoU 1. Label 4 lies on no plane.
  const auto metrics = instance_metrics(mask("1111111111 22222 3333 ...."), mask("111111.... 2222. 3333 2444"));
  ASSERT_TRUE(metrics);
  EXPECT_EQ(metrics->true_planes, 3);
  EXPECT_EQ(metrics->predicted_planes, 4);
  expect_matches_by_hand(*metrics);
  EXPECT_DOUBLE_EQ(metrics->missed, 0.0);
  EXPECT_DOUBLE_EQ(metrics->noise, 1.0 / 4.0);
  EXPECT_DOUBLE_EQ(metrics->weighted_iou, (10 * 0.6 + 5 * 4.0 / 6.0 + 4 * 1.0) / 19.0);
  // On some plane: 19 true, 18 predicted, 14 both.
  EXPECT_DOUBLE_EQ(metrics->plane_pixel_f1, 2.0 * 14 / (19 + 18));
}

TEST(InstanceMetrics, ExactlyHalfIsAMatchButOnlyOneOfTwo) {
  const auto metrics = instance_metrics(mask("1111"), mask("1122"));
  ASSERT_TRUE(metrics);
  EXPECT_EQ(metrics->at50.matched, 1);
  EXPECT_DOUBLE_EQ(metrics->at50.precision, 0.5);
  EXPECT_DOUBLE_EQ(metrics->at50.recall, 1.0);
  EXPECT_EQ(metrics->over_segmentation, 1.0);
}

TEST(InstanceMetrics, APlaneOnIgnoredPixelsIsNotFalseButMayBeRight) {
  // Plane 2 has 2 judged pixels, on no true plane, and 3 ignored ones. By half, it is judged.
  const auto mostly = instance_metrics(mask("1111 .. ???"), mask("1111 22 222"));
  ASSERT_TRUE(mostly);
  EXPECT_EQ(mostly->predicted_planes, 2);
  EXPECT_EQ(mostly->at50.matched, 1);
  EXPECT_EQ(mostly->at50.false_positives, 0);
  EXPECT_EQ(mostly->at50.precision, 1.0);
  EXPECT_EQ(mostly->at75.f1, 1.0);
  EXPECT_EQ(mostly->noise, 0.0);
  const auto half = instance_metrics(mask("1111 .. ??"), mask("1111 22 22"));
  ASSERT_TRUE(half);
  EXPECT_EQ(half->at50.false_positives, 1);
  EXPECT_EQ(half->at50.precision, 0.5);
  EXPECT_EQ(half->noise, 0.5);
  // Plane 2 lies mostly on ignored pixels and matches true plane 2 by 2/3: right at 0.5, not false at 0.75.
  const auto right = instance_metrics(mask("1111 222 ????"), mask("1111 22. 2222"));
  ASSERT_TRUE(right);
  EXPECT_EQ(right->at50.matched, 2);
  EXPECT_EQ(right->at50.precision, 1.0);
  EXPECT_EQ(right->at75.matched, 1);
  EXPECT_EQ(right->at75.precision, 1.0);
  EXPECT_EQ(right->at75.recall, 0.5);
}

TEST(InstanceMetrics, UnderSegmentation) {
  // Label 1 covers planes 1 and 2 wholly; label 2 covers plane 3 and exactly half of plane 4, which is not most of it.
  const auto metrics = instance_metrics(mask("1111 222 33 44"), mask("1111 111 22 2."));
  ASSERT_TRUE(metrics);
  EXPECT_DOUBLE_EQ(metrics->under_segmentation, 0.5);
  EXPECT_DOUBLE_EQ(metrics->over_segmentation, 0.0);
  EXPECT_DOUBLE_EQ(metrics->missed, 2.0 / 4.0);  // 1 (IoU 4/7) and 3 (IoU 2/3) match
}

TEST(InstanceMetrics, OverSegmentation) {
  // Plane 1 is cut in two; plane 2 is found, with a piece of label 3 that is mostly elsewhere.
  const auto metrics = instance_metrics(mask("11111111 2222 ..."), mask("11112222 3334 44."));
  ASSERT_TRUE(metrics);
  EXPECT_DOUBLE_EQ(metrics->over_segmentation, 0.5);
  EXPECT_DOUBLE_EQ(metrics->under_segmentation, 0.0);
}

TEST(InstanceMetrics, SmallPlanesAreLeftOut) {
  Labels truth;
  Labels predicted;
  append(truth, 990, 1);
  append(predicted, 990, 1);
  append(truth, 4, 2);  // 0.4 % of the judged pixels
  append(predicted, 4, kLabelNoPlane);
  append(truth, 6, kLabelNoPlane);
  append(predicted, 2, kLabelNoPlane);
  append(predicted, 4, 3);
  append(truth, 100, kLabelNoDepth);  // not judged
  append(predicted, 100, 4);
  const auto metrics = instance_metrics(truth, predicted);
  ASSERT_TRUE(metrics);
  EXPECT_EQ(metrics->true_planes, 1);
  EXPECT_EQ(metrics->predicted_planes, 1);
  EXPECT_EQ(metrics->at75.f1, 1.0);

  const auto strict = instance_metrics(truth, predicted, 0.004);  // exactly the share of plane 2 and label 3
  ASSERT_TRUE(strict);
  EXPECT_EQ(strict->true_planes, 2);
  EXPECT_EQ(strict->predicted_planes, 2);
  EXPECT_DOUBLE_EQ(strict->missed, 0.5);
  EXPECT_DOUBLE_EQ(strict->noise, 0.5);
}

TEST(InstanceMetrics, NothingPredictedOrNothingTrue) {
  const auto none_predicted = instance_metrics(mask("11 2."), mask("?? .."));
  ASSERT_TRUE(none_predicted);
  EXPECT_EQ(none_predicted->at50.precision, 0.0);
  EXPECT_EQ(none_predicted->at50.f1, 0.0);
  EXPECT_EQ(none_predicted->missed, 1.0);
  EXPECT_EQ(none_predicted->noise, 0.0);
  const auto none_true = instance_metrics(mask("...."), mask("1111"));
  ASSERT_TRUE(none_true);
  EXPECT_EQ(none_true->noise, 1.0);
  EXPECT_EQ(none_true->weighted_iou, 0.0);
  const auto empty = instance_metrics({}, {});
  ASSERT_TRUE(empty);
  EXPECT_EQ(empty->at50.f1, 0.0);
}

/// Means over frames start from these.
TEST(Metrics, StartFromZero) {
  const InstanceMetrics planes;
  for (const InstanceMetrics::AtIou& at : {planes.at50, planes.at75}) {
    for (const double value : {at.threshold, at.precision, at.recall, at.f1, at.mean_iou}) EXPECT_EQ(value, 0.0);
    EXPECT_EQ(at.matched + at.false_positives, 0);
  }
  for (const double value : {planes.under_segmentation, planes.over_segmentation, planes.missed, planes.noise,
                             planes.weighted_iou, planes.plane_pixel_f1}) {
    EXPECT_EQ(value, 0.0);
  }
  EXPECT_EQ(planes.true_planes, 0);
  EXPECT_EQ(planes.predicted_planes, 0);
  const ObjectMetrics objects;
  for (const int count : {objects.true_objects, objects.predicted_objects, objects.false_objects}) EXPECT_EQ(count, 0);
  for (const double value : {objects.under_segmentation, objects.over_segmentation}) EXPECT_EQ(value, 0.0);
  EXPECT_EQ(ObjectMetrics::Object{}.pixels, 0U);
  EXPECT_EQ(Detection{}.f1(), 0.0);
  EXPECT_EQ(FloorAsObstacle{}.share(), 0.0);
}

TEST(InstanceMetrics, RefusesAShareOutsideItsRange) {
  for (const double share : {-0.1, 1.1, std::nan("")}) {
    const auto metrics = instance_metrics(mask("1"), mask("1"), share);
    ASSERT_FALSE(metrics);
    EXPECT_NE(metrics.error().message.find("min_share"), std::string::npos);
  }
}

using Ids = std::vector<std::uint16_t>;

/// Object ids as a drawing: '.' is 0 (no object), letters are objects from 'a' = 1 on; blanks are skipped.
Ids objects(std::string_view drawing) {
  Ids ids;
  for (const char c : drawing) {
    if (c != ' ') ids.push_back(c == '.' ? std::uint16_t{0} : static_cast<std::uint16_t>(c - 'a' + 1));
  }
  return ids;
}

Result<ObjectMetrics> everywhere(const Ids& truth, const Ids& predicted) {
  return object_metrics(truth, predicted, Labels(truth.size(), 1));
}

TEST(ObjectMetrics, ThresholdsByHand) {
  // Object a: 10 pixels, 6 found: IoU 6/10. Object b: 5, 4 found by one with one pixel elsewhere: IoU 4/6. Object c: IoU 1.
  // Predicted d lies on no object.
  const auto metrics = everywhere(objects("aaaaaaaaaa bbbbb cccc ...."), objects("aaaaaa.... bbbb. cccc bddd"));
  ASSERT_TRUE(metrics);
  EXPECT_EQ(metrics->true_objects, 3);
  EXPECT_EQ(metrics->predicted_objects, 4);
  expect_matches_by_hand(*metrics);
  EXPECT_EQ(metrics->false_objects, 1);
  ASSERT_EQ(metrics->objects.size(), 3U);
  EXPECT_EQ(metrics->objects[0].id, 1);
  EXPECT_EQ(metrics->objects[0].pixels, 10U);
  EXPECT_DOUBLE_EQ(metrics->objects[0].iou, 0.6);
  EXPECT_EQ(metrics->objects[1].id, 2);
  EXPECT_EQ(metrics->objects[1].pixels, 5U);
  EXPECT_DOUBLE_EQ(metrics->objects[1].iou, 4.0 / 6.0);
  EXPECT_EQ(metrics->objects[2].id, 3);
  EXPECT_EQ(metrics->objects[2].pixels, 4U);
  EXPECT_DOUBLE_EQ(metrics->objects[2].iou, 1.0);
}

TEST(ObjectMetrics, OverAndUnderSegmentation) {
  // Predicted a merges a and b; c is cut in two, halves that lie on it by most of themselves; d is found.
  const auto metrics = everywhere(objects("aaa bbb cccccc dd .."), objects("aaa aaa cccddd ee .d"));
  ASSERT_TRUE(metrics);
  EXPECT_DOUBLE_EQ(metrics->under_segmentation, 1.0 / 4.0);
  EXPECT_DOUBLE_EQ(metrics->over_segmentation, 1.0 / 4.0);
  EXPECT_EQ(metrics->false_objects, 1);  // the merged one has exactly one half on each object: no most
}

TEST(ObjectMetrics, OnlyJudgedPixelsCount) {
  const Ids truth = objects("aaaa bb .. cc");
  const Ids predicted = objects("aabb bb bb dd");
  for (const auto& metrics : {object_metrics(truth, predicted, Labels{255, 1, 0, 0, 7, 7, 0, 0, 0, 0}),
                              object_metrics(truth, predicted, Ids{9000, 300, 0, 0, 1, 1, 0, 0, 0, 0})}) {
    ASSERT_TRUE(metrics);
    EXPECT_EQ(metrics->true_objects, 2);
    EXPECT_EQ(metrics->predicted_objects, 2);
    EXPECT_EQ(metrics->at75.f1, 1.0);
    EXPECT_EQ(metrics->at75.mean_iou, 1.0);
    EXPECT_EQ(metrics->objects[0].pixels, 2U);
  }
}

TEST(ObjectMetrics, AnyNumberOfObjects) {
  // Each pixel but the first is an object of its own, in the prediction numbered from behind.
  constexpr std::uint16_t kMost = 65535;
  Ids truth{0};
  Ids predicted{0};
  for (std::uint16_t id = kMost; id > 0; --id) {
    truth.push_back(id);
    predicted.push_back(static_cast<std::uint16_t>(kMost + 1 - id));
  }
  const auto metrics = everywhere(truth, predicted);
  ASSERT_TRUE(metrics);
  EXPECT_EQ(metrics->true_objects, 65535);
  EXPECT_EQ(metrics->at75.matched, 65535);
  EXPECT_EQ(metrics->false_objects, 0);
  EXPECT_EQ(metrics->objects.front().id, 1);
  EXPECT_EQ(metrics->objects.back().id, 65535);
}

TEST(ObjectMetrics, NothingPredictedOrNothingTrue) {
  const auto none_predicted = everywhere(objects("aabb"), objects("...."));
  ASSERT_TRUE(none_predicted);
  EXPECT_EQ(none_predicted->at50.recall, 0.0);
  EXPECT_EQ(none_predicted->at50.f1, 0.0);
  EXPECT_EQ(none_predicted->objects[1].iou, 0.0);
  const auto none_true = everywhere(objects("...."), objects("aab."));
  ASSERT_TRUE(none_true);
  EXPECT_EQ(none_true->false_objects, 2);
  EXPECT_TRUE(none_true->objects.empty());
  const auto empty = everywhere({}, {});
  ASSERT_TRUE(empty);
  EXPECT_EQ(empty->at50.f1, 0.0);
}

TEST(ObjectMetrics, DifferentSizesAreAnError) {
  const auto prediction = object_metrics(Ids(3), Ids(4), Labels(3));
  ASSERT_FALSE(prediction);
  EXPECT_EQ(prediction.error().code, ErrorCode::invalid_argument);
  EXPECT_NE(prediction.error().message.find("the prediction 4"), std::string::npos);
  const auto judged = object_metrics(Ids(3), Ids(3), Labels(2));
  ASSERT_FALSE(judged);
  EXPECT_EQ(judged.error().code, ErrorCode::invalid_argument);
  EXPECT_NE(judged.error().message.find("judged 2"), std::string::npos);
}

TEST(FloorAsObstacle, CountsTheFloorsPixelsThatAreOnAnyObstacle) {
  const auto counts = floor_as_obstacle(mask("1111 2222 .. ??"), objects("a..b aaaa cc aa"));
  ASSERT_TRUE(counts);
  EXPECT_EQ(counts->floor, 4U);
  EXPECT_EQ(counts->obstacle, 2U);
  EXPECT_EQ(counts->share(), 0.5);
  EXPECT_EQ(floor_as_obstacle(mask("1111 2222"), objects("aaaa .b.."), 2)->share(), 0.25);
}

TEST(FloorAsObstacle, WithoutAFloorItIsNothing) {
  const auto counts = floor_as_obstacle(mask("2222 .. ??"), objects("aaaa aa aa"));
  ASSERT_TRUE(counts);
  EXPECT_EQ(counts->floor, 0U);
  EXPECT_EQ(counts->share(), 0.0);
  const auto sizes = floor_as_obstacle(mask("11"), objects("a"));
  ASSERT_FALSE(sizes);
  EXPECT_EQ(sizes.error().code, ErrorCode::invalid_argument);
}

TEST(PlaneError, AngleAndOffset) {
  const double angle = std::numbers::pi / 6.0;
  const Plane truth{Eigen::Vector3d(0, 0, -1), 2.0};
  const Plane predicted{Eigen::Vector3d(std::sin(angle), 0, -std::cos(angle)), 2.25};
  const PlaneError error = plane_error(truth, predicted);
  EXPECT_NEAR(error.angle_rad, angle, 1e-12);
  EXPECT_NEAR(error.offset_m, 0.25, 1e-12);
}

TEST(PlaneError, NormalsAreAlignedFirst) {
  // Near the origin noise may flip the canonical sign: the same plane, 3 mm apart.
  const PlaneError error = plane_error({Eigen::Vector3d(0, 1, 0), 0.001}, {Eigen::Vector3d(0, -1, 0), 0.002});
  EXPECT_NEAR(error.angle_rad, 0.0, 1e-12);
  EXPECT_NEAR(error.offset_m, 0.003, 1e-12);
}

}  // namespace
}  // namespace fransac::eval
