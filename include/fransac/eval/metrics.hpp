// SPDX-License-Identifier: Apache-2.0
/// How well labels agree with the truth.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "fransac/core/plane.hpp"
#include "fransac/core/result.hpp"

namespace fransac::eval {

/// Precision, recall and F1 (Zeineldin & El-Fishawy eqs. 3 to 5), from pixel counts.
struct Detection {
  std::uint64_t true_positives = 0;   ///< TP, pixels.
  std::uint64_t false_positives = 0;  ///< FP, pixels.
  std::uint64_t false_negatives = 0;  ///< FN, pixels.

  [[nodiscard]] double precision() const;  ///< TP / (TP + FP); 0 when nothing was predicted.
  [[nodiscard]] double recall() const;     ///< TP / (TP + FN); 0 when nothing is true.
  [[nodiscard]] double f1() const;         ///< Harmonic mean; 0 when both are 0.
};

/// The first predicted plane that can be judged: the lowest label of 1 to 254 with at least half of its pixels where the truth is
/// not 0 (ignored), and at least one; 1 when there is none. A plane that lies mostly where nobody can say what is there is
/// neither right nor wrong. Both images have one label per pixel; sizes must be equal (invalid_argument).
Result<std::uint8_t> first_judged_plane(std::span<const std::uint8_t> truth, std::span<const std::uint8_t> predicted);

/// Compares predicted label `predicted_label`, or where none is given the first judged plane, with truth label 1 over the pixels
/// whose truth is not 0 (ignored). Both images have one label per pixel; sizes must be equal (invalid_argument).
Result<Detection> dominant_plane(std::span<const std::uint8_t> truth, std::span<const std::uint8_t> predicted,
                                 std::optional<std::uint8_t> predicted_label = std::nullopt);

/// The same for the predicted plane that overlaps truth label 1 most (by intersection; ties: the lower label): fair where two
/// planes are about equally large. The label itself is returned too; 0 when no predicted plane overlaps.
struct BestDetection {
  Detection detection;     ///< Of that plane.
  std::uint8_t label = 0;  ///< Its predicted label, or 0.
};
/// See BestDetection. Sizes must be equal (invalid_argument).
Result<BestDetection> best_overlap(std::span<const std::uint8_t> truth, std::span<const std::uint8_t> predicted);

/// The same turned round: one predicted plane, the first judged one unless another is given, against the true plane that it fits
/// best, the label of 1 to 254 with the largest F1 over the judged pixels (ties: the lower label). Fair to a method whose first
/// plane is another than the truth's first. The true plane's label is returned too; 0, with no true pixels, when the predicted
/// plane overlaps none.
struct MatchedDetection {
  Detection detection;     ///< Of that plane.
  std::uint8_t label = 0;  ///< Its true label, or 0.
};
/// See MatchedDetection. Sizes must be equal (invalid_argument).
Result<MatchedDetection> matched_plane(std::span<const std::uint8_t> truth, std::span<const std::uint8_t> predicted,
                                       std::optional<std::uint8_t> predicted_label = std::nullopt);

/// Matches of predicted to true planes, in the manner of EVOPS (Kornilova et al., "EVOPS Benchmark: Evaluation of Plane
/// Segmentation from RGBD and LiDAR Data", 2022) and Hoover et al. (1996).
struct InstanceMetrics {
  int true_planes = 0;       ///< Those that are large enough.
  int predicted_planes = 0;  ///< Likewise.
  /// Counts of one-to-one matches.
  struct AtIou {
    double threshold = 0.0;   ///< Least intersection over union of a match.
    int matched = 0;          ///< Pairs.
    int false_positives = 0;  ///< Predicted ones without a match; of planes only those that are judged (first_judged_plane).
    double precision = 0.0;   ///< matched / (matched + false positives); 0 when there are none.
    double recall = 0.0;      ///< matched / true; 0 when nothing is true.
    double f1 = 0.0;          ///< Harmonic mean; 0 when both are 0.
    double mean_iou = 0.0;    ///< Of the matched pairs; 0 without any.
  };
  AtIou at50;                       ///< IoU >= 0.5
  AtIou at75;                       ///< IoU >= 0.75
  double under_segmentation = 0.0;  ///< Share of the predicted planes that cover two or more true planes (Hoover: each overlap is
                                    ///< most of the true plane).
  double over_segmentation = 0.0;   ///< Share of the true planes that are covered by two or more predicted planes.
  double missed = 0.0;              ///< Share of the true planes without a match at 0.5.
  double noise = 0.0;               ///< 1 - precision at 0.5; 0 when no predicted plane counts.
  double weighted_iou = 0.0;        ///< Mean over true planes, weighted by pixels, of the best IoU with a predicted plane.
  double plane_pixel_f1 = 0.0;      ///< F1 of "on some plane" over the judged pixels.
};

/// Planes (true or predicted) with fewer than `min_share` of the judged pixels (truth != 0) are left out; DESIGN: 0.5 %.
Result<InstanceMetrics> instance_metrics(std::span<const std::uint8_t> truth, std::span<const std::uint8_t> predicted,
                                         double min_share = 0.005);

/// Matches of predicted to true objects, as of planes.
struct ObjectMetrics {
  int true_objects = 0;             ///< Those that are judged.
  int predicted_objects = 0;        ///< Likewise.
  InstanceMetrics::AtIou at50;      ///< IoU >= 0.5
  InstanceMetrics::AtIou at75;      ///< IoU >= 0.75
  double under_segmentation = 0.0;  ///< As of planes: share of the predicted objects that hold most of two or more true ones.
  double over_segmentation = 0.0;   ///< Share of the true objects that hold most of two or more predicted ones.
  int false_objects = 0;            ///< Predicted objects without a true one on most of their pixels.
  /// A true object.
  struct Object {
    std::uint16_t id = 0;      ///< Its value in the image.
    std::uint64_t pixels = 0;  ///< Judged ones.
    double iou = 0.0;          ///< The best with a predicted object; 0 where none overlaps.
  };
  std::vector<Object> objects;  ///< The true ones, by id.
};

/// Compares two images of object ids, 0 = no object, over the pixels where `judged` is not 0: a mask, such as labels whose 0 says
/// ignored, or a depth image. All sizes must be equal (invalid_argument).
Result<ObjectMetrics> object_metrics(std::span<const std::uint16_t> truth, std::span<const std::uint16_t> predicted,
                                     std::span<const std::uint8_t> judged);
/// The same where `depth`, 16-bit raw values, is not 0.
Result<ObjectMetrics> object_metrics(std::span<const std::uint16_t> truth, std::span<const std::uint16_t> predicted,
                                     std::span<const std::uint16_t> depth);

/// How much of the floor is taken for an obstacle.
struct FloorAsObstacle {
  std::uint64_t floor = 0;     ///< Pixels of the true floor.
  std::uint64_t obstacle = 0;  ///< Of these, pixels of an obstacle.

  [[nodiscard]] double share() const;  ///< obstacle / floor; 0 without a floor.
};
/// Counts the pixels whose truth is `floor_label`, and those of them where `obstacles`, an image of obstacles' ids, is not 0.
/// Both images have one value per pixel; sizes must be equal (invalid_argument).
Result<FloorAsObstacle> floor_as_obstacle(std::span<const std::uint8_t> truth, std::span<const std::uint16_t> obstacles,
                                          std::uint8_t floor_label = 1);

/// Errors of a plane against its true coefficients.
struct PlaneError {
  double angle_rad = 0.0;  ///< Between the normals, [0, pi/2].
  double offset_m = 0.0;   ///< |d - d_true|, canonical signs (normals aligned first).
};
/// See PlaneError.
PlaneError plane_error(const Plane& truth, const Plane& predicted);

}  // namespace fransac::eval
