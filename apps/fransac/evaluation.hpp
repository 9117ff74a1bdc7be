// SPDX-License-Identifier: Apache-2.0
/// Methods compared on frames, with the truth where there is one: what `evaluate` prints and `report` draws.
#pragma once

#include <array>
#include <cstddef>
#include <functional>
#include <iterator>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "fransac/eval/hoover.hpp"
#include "fransac/io/dataset.hpp"
#include "fransac/planes/segment.hpp"
#include "options.hpp"

namespace fransac::cli {

/// What is measured of one scene with one method.
enum class Quantity {
  precision,
  recall,
  f1,
  best_f1,
  matched_f1,
  matched_precision,
  matched_recall,
  instance_f1_50,
  instance_precision_50,
  instance_recall_50,
  mean_iou_50,
  instance_f1_75,
  instance_precision_75,
  instance_recall_75,
  mean_iou_75,
  weighted_iou,
  plane_pixel_f1,
  under_segmentation,
  over_segmentation,
  missed,
  noise,
  angle_deg,
  offset_m,
  planes,
  median_ms,
  fps,
  objects_true,
  objects_predicted,
  objects_f1_50,
  objects_precision_50,
  objects_recall_50,
  objects_f1_75,
  objects_precision_75,
  objects_recall_75,
  objects_mean_iou,
  objects_over,
  objects_under,
  objects_false,
  floor_as_obstacle,
  objects_median_ms,
  hoover_regions,
  hoover_predicted,
  hoover_correct,
  hoover_correct_share,
  hoover_over,
  hoover_under,
  hoover_missed,
  hoover_noise,
};

struct QuantityInfo {
  std::string_view key;      ///< In JSON and CSV.
  std::string_view heading;  ///< In the table; empty: not shown there.
  int decimals;
  std::string_view group{};  ///< Not empty: the JSON object that holds it; CSV has group_key.
};

inline constexpr std::string_view kObjects = "objects";
inline constexpr std::string_view kHoover = "hoover";

inline constexpr QuantityInfo kQuantities[] = {
    {"precision", "precision", 4},
    {"recall", "recall", 4},
    {"f1", "F1", 4},
    {"best_f1", "best F1", 4},
    {"matched_f1", "matched", 4},
    {"matched_precision", "", 4},
    {"matched_recall", "", 4},
    {"instance_f1_50", "F1@0.5", 4},
    {"instance_precision_50", "", 4},
    {"instance_recall_50", "", 4},
    {"mean_iou_50", "", 4},
    {"instance_f1_75", "F1@0.75", 4},
    {"instance_precision_75", "", 4},
    {"instance_recall_75", "", 4},
    {"mean_iou_75", "", 4},
    {"weighted_iou", "wIoU", 4},
    {"plane_pixel_f1", "", 4},
    {"under_segmentation", "", 4},
    {"over_segmentation", "", 4},
    {"missed", "", 4},
    {"noise", "", 4},
    {"angle_deg", "angle [deg]", 3},
    {"offset_m", "offset [m]", 4},
    {"planes", "", 2},
    {"median_ms", "", 3},
    {"fps", "fps", 1},
    {"true", "objects", 1, kObjects},
    {"predicted", "found", 1, kObjects},
    {"f1_50", "object F1@0.5", 4, kObjects},
    {"precision_50", "", 4, kObjects},
    {"recall_50", "", 4, kObjects},
    {"f1_75", "object F1@0.75", 4, kObjects},
    {"precision_75", "", 4, kObjects},
    {"recall_75", "", 4, kObjects},
    {"mean_iou", "object IoU", 4, kObjects},
    {"over_segmentation", "over", 4, kObjects},
    {"under_segmentation", "under", 4, kObjects},
    {"false", "false", 1, kObjects},
    {"floor_as_obstacle", "floor as obstacle", 5, kObjects},
    {"median_ms", "obstacles [ms]", 3, kObjects},
    {"regions", "regions", 1, kHoover},
    {"predicted", "", 1, kHoover},
    {"correct", "correct", 1, kHoover},
    {"correct_share", "correct share", 4, kHoover},
    {"over_segmented", "over-seg.", 1, kHoover},
    {"under_segmented", "under-seg.", 1, kHoover},
    {"missed", "missed", 1, kHoover},
    {"noise", "noise", 1, kHoover},
};
inline constexpr std::size_t kQuantityCount = std::size(kQuantities);
static_assert(kQuantityCount == static_cast<std::size_t>(Quantity::hoover_noise) + 1);

constexpr const QuantityInfo& info_of(Quantity quantity) { return kQuantities[static_cast<std::size_t>(quantity)]; }

/// Values by quantity; nothing where it does not apply.
struct Scores {
  std::array<std::optional<double>, kQuantityCount> values;
  std::optional<double>& operator[](Quantity quantity) { return values[static_cast<std::size_t>(quantity)]; }
  const std::optional<double>& operator[](Quantity quantity) const { return values[static_cast<std::size_t>(quantity)]; }
};

struct Row {
  std::string dataset;
  std::string scene;
  Method method = Method::automatic;
  Scores scores;
  std::array<double, kStages> stage_ms{};           ///< Medians over the runs.
  std::vector<eval::HooverMetrics> hoover_curve{};  ///< Over kHooverCurve, where that is asked for and there are true regions.
};

/// The tolerances of a curve.
inline constexpr int kHooverCurveFrom_percent = 51;
inline constexpr int kHooverCurveTo_percent = 95;

/// The frames of a dataset; a camera chosen by the user stands for their own. Throws Failure; a point cloud is refused with
/// `no_clouds` as the reason.
io::Dataset open_dataset(const std::string& name, Runs& runs, std::string_view no_clouds);

/// A frame folder with labels but without a dataset.json: label 1 is all that is known to mean anything.
io::Truth truth_of(const io::Dataset& dataset);

/// Sees one frame with a row and the last run's segmentation per method, in the methods' order.
using FrameVisitor =
    std::function<void(const io::FrameFiles&, const io::Frame&, std::span<const Row>, std::span<const Segmentation>)>;

/// Runs every method on every frame and scores what it found where there is truth. Throws Failure.
void evaluate_dataset(const Runs& runs, const std::string& name, const io::Dataset& dataset, const FrameVisitor& visit);

/// A row "mean" per dataset and method: of each quantity over the rows that have it; fps: of the mean time; shares of regions: of
/// all regions.
std::vector<Row> means_of(const std::vector<std::string>& datasets, const std::vector<Method>& methods,
                          const std::vector<Row>& rows);

/// Refuses a dataset named twice, whose rows would be averaged together. Throws UsageError.
void check_named_once(const std::vector<std::string>& datasets);

/// "0.9962"; "-" where the quantity does not apply.
std::string value_text(const Scores& scores, Quantity quantity);

}  // namespace fransac::cli
