// SPDX-License-Identifier: Apache-2.0
#include "evaluation.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <numbers>
#include <system_error>

#include "doubts.hpp"
#include "errors.hpp"
#include "fransac/core/labels.hpp"
#include "fransac/eval/metrics.hpp"
#include "fransac/obstacles/obstacles.hpp"
#include "inputs.hpp"
#include "progress.hpp"
#include "statistics.hpp"

namespace fransac::cli {
namespace {

/// The quantities of planes or objects that are matched at one IoU.
struct AtIouQuantities {
  Quantity f1;
  Quantity precision;
  Quantity recall;
};

void score_matches(Scores& scores, const eval::InstanceMetrics::AtIou& at, const AtIouQuantities& quantities) {
  scores[quantities.f1] = at.f1;
  scores[quantities.precision] = at.precision;
  scores[quantities.recall] = at.recall;
}

void score_instances(Scores& scores, const eval::InstanceMetrics& metrics) {
  using enum Quantity;
  score_matches(scores, metrics.at50, {instance_f1_50, instance_precision_50, instance_recall_50});
  score_matches(scores, metrics.at75, {instance_f1_75, instance_precision_75, instance_recall_75});
  scores[mean_iou_50] = metrics.at50.mean_iou;
  scores[mean_iou_75] = metrics.at75.mean_iou;
  scores[weighted_iou] = metrics.weighted_iou;
  scores[plane_pixel_f1] = metrics.plane_pixel_f1;
  scores[under_segmentation] = metrics.under_segmentation;
  scores[over_segmentation] = metrics.over_segmentation;
  scores[missed] = metrics.missed;
  scores[noise] = metrics.noise;
}

/// Error of the predicted plane that overlaps the dominant one most, where the truth has its coefficients.
void score_coefficients(Scores& scores, const io::Frame& frame, const Segmentation& segmentation, std::uint8_t best_label) {
  const auto truth =
      std::find_if(frame.true_planes.begin(), frame.true_planes.end(), [](const auto& plane) { return plane.first == 1; });
  if (truth == frame.true_planes.end() || best_label == 0) return;
  const eval::PlaneError error = eval::plane_error(truth->second, segmentation.planes[best_label - 1U].plane);
  scores[Quantity::angle_deg] = error.angle_rad * 180.0 / std::numbers::pi;
  scores[Quantity::offset_m] = error.offset_m;
}

/// The first judged plane against the true plane that it fits best. Where the truth is the dominant plane alone, that is the only
/// one.
eval::Detection matched_of(const std::vector<std::uint8_t>& true_labels, const std::vector<std::uint8_t>& labels, io::Truth truth,
                           const eval::Detection& dominant) {
  return truth == io::Truth::planes ? unwrap(eval::matched_plane(true_labels, labels)).detection : dominant;
}

Scores score(const io::Frame& frame, io::Truth truth, const SegmentOptions& options, const Segmentation& segmentation) {
  const auto& true_labels = frame.labels->pixels;
  Scores scores;
  // Against no plane at all nothing can be scored but the number of planes found.
  const auto is_plane = [](std::uint8_t label) { return label != kLabelNoDepth && label != kLabelNoPlane; };
  if (std::none_of(true_labels.begin(), true_labels.end(), is_plane)) return scores;
  const auto dominant = unwrap(eval::dominant_plane(true_labels, segmentation.labels));
  const auto best = unwrap(eval::best_overlap(true_labels, segmentation.labels));
  const auto matched = matched_of(true_labels, segmentation.labels, truth, dominant);
  scores[Quantity::precision] = dominant.precision();
  scores[Quantity::recall] = dominant.recall();
  scores[Quantity::f1] = dominant.f1();
  scores[Quantity::best_f1] = best.detection.f1();
  scores[Quantity::matched_f1] = matched.f1();
  scores[Quantity::matched_precision] = matched.precision();
  scores[Quantity::matched_recall] = matched.recall();
  if (truth == io::Truth::planes && with_defaults(options, segmentation.method).max_planes != 1) {
    score_instances(scores, unwrap(eval::instance_metrics(true_labels, segmentation.labels)));
  }
  score_coefficients(scores, frame, segmentation, best.label);
  return scores;
}

/// The ids of what was found, without drops: these are no objects.
std::vector<std::uint16_t> objects_of(const Obstacles& found) {
  std::vector<std::uint16_t> labels = found.labels;
  for (std::uint16_t& label : labels) {
    if (label != 0 && found.obstacles[label - 1U].kind == ObstacleKind::drop) label = 0;
  }
  return labels;
}

/// 1 where depth was measured.
std::vector<std::uint8_t> measured_in(const DepthView& depth) {
  std::vector<std::uint8_t> measured(depth.size());
  auto at = measured.begin();
  for (int v = 0; v < depth.height(); ++v) {
    for (int u = 0; u < depth.width(); ++u) *at++ = depth.metres(u, v) > 0.0F ? 1 : 0;
  }
  return measured;
}

void score_objects(Scores& scores, const io::Frame& frame, const Obstacles& found) {
  const auto metrics = unwrap(eval::object_metrics(frame.objects->pixels, objects_of(found), measured_in(frame.view())));
  using enum Quantity;
  scores[objects_true] = metrics.true_objects;
  scores[objects_predicted] = metrics.predicted_objects;
  scores[objects_false] = metrics.false_objects;
  if (metrics.true_objects == 0) return;  // nothing that could be found
  score_matches(scores, metrics.at50, {objects_f1_50, objects_precision_50, objects_recall_50});
  score_matches(scores, metrics.at75, {objects_f1_75, objects_precision_75, objects_recall_75});
  scores[objects_over] = metrics.over_segmentation;
  scores[objects_under] = metrics.under_segmentation;
  double sum = 0.0;
  for (const auto& object : metrics.objects) sum += object.iou;
  scores[objects_mean_iou] = sum / metrics.true_objects;
}

/// How much of the true floor, where it is known which that is and it is seen, became an obstacle; drops are obstacles here.
void score_floor(Scores& scores, const io::Frame& frame, io::Truth truth, const Obstacles& found) {
  const int label = frame.floor.value_or(truth == io::Truth::planes ? kLabelFirst : kLabelNoDepth);
  if (label == kLabelNoDepth) return;
  const auto counts = unwrap(eval::floor_as_obstacle(frame.labels->pixels, found.labels, static_cast<std::uint8_t>(label)));
  if (counts.floor > 0) scores[Quantity::floor_as_obstacle] = counts.share();
}

void set_hoover(Scores& scores, const eval::HooverMetrics& metrics) {
  using enum Quantity;
  scores[hoover_regions] = metrics.true_regions;
  scores[hoover_predicted] = metrics.predicted;
  scores[hoover_correct] = metrics.correct;
  scores[hoover_over] = metrics.over_segmented;
  scores[hoover_under] = metrics.under_segmented;
  scores[hoover_missed] = metrics.missed;
  scores[hoover_noise] = metrics.noise;
}

/// Regions against those of gt_seg.png, or else against planes. What was asked for one plane is not judged by all.
void score_regions(Row& row, const HooverRequest& request, const io::Frame& frame, io::Truth truth, const SegmentOptions& options,
                   const Segmentation& segmentation) {
  const bool of_planes = truth == io::Truth::planes && frame.labels;
  const bool wanted = request.asked ? frame.regions || of_planes : request.curve && frame.regions;
  if (!wanted || with_defaults(options, segmentation.method).max_planes == 1) return;
  const io::LabelImage& regions = frame.regions ? *frame.regions : *frame.labels;
  std::vector<double> tolerances{request.tolerance};
  for (int percent = kHooverCurveFrom_percent; request.curve && percent <= kHooverCurveTo_percent; ++percent) {
    tolerances.push_back(percent / 100.0);
  }
  const eval::HooverOptions how{.truth = frame.regions ? eval::TrueRegions::segcomp : eval::TrueRegions::labels};
  std::vector<eval::HooverMetrics> metrics =
      unwrap(eval::hoover(regions.pixels, segmentation.labels, regions.width, tolerances, how));
  if (metrics.front().true_regions == 0) return;  // nothing that could be found
  set_hoover(row.scores, metrics.front());
  row.hoover_curve.assign(metrics.begin() + 1, metrics.end());
}

/// What follows from other quantities, of a scene as of means.
void set_derived(Scores& scores) {
  const double regions = scores[Quantity::hoover_regions].value_or(0.0);
  if (regions > 0.0) scores[Quantity::hoover_correct_share] = scores[Quantity::hoover_correct].value_or(0.0) / regions;
  const double ms = scores[Quantity::median_ms].value_or(0.0);
  scores[Quantity::fps] = ms > 0.0 ? std::optional(1e3 / ms) : std::nullopt;
}

Row mean_of(const std::string& dataset, Method method, const std::vector<const Row*>& rows) {
  Row mean{dataset, "mean", method, {}, {}, {}};
  for (std::size_t q = 0; q < kQuantityCount; ++q) {
    double sum = 0.0;
    double count = 0.0;
    for (const Row* row : rows) {
      sum += row->scores.values[q].value_or(0.0);
      count += row->scores.values[q] ? 1.0 : 0.0;
    }
    if (count > 0.0) mean.scores.values[q] = sum / count;
  }
  for (const Row* row : rows) {
    for (std::size_t s = 0; s < kStages; ++s) mean.stage_ms[s] += row->stage_ms[s] / static_cast<double>(rows.size());
  }
  set_derived(mean.scores);
  return mean;
}

/// What is kept from run to run.
struct Work {
  Workspace planes;
  ObstacleWorkspace obstacles;
  Obstacles found;
};

/// Milliseconds by run.
struct Times {
  std::vector<double> total_ms;
  std::array<std::vector<double>, kStages> stage_ms;
  std::vector<double> obstacles_ms;
};

Status run_once(const Runs& runs, const SegmentOptions& options, const io::Frame& frame, Work& work, Segmentation& segmentation,
                Times& times) {
  if (Status status = segment(frame.view(), frame.camera, options, work.planes, segmentation); !status) return status;
  times.total_ms.push_back(segmentation.timing.total_ms);
  for (std::size_t s = 0; s < kStages; ++s) times.stage_ms[s].push_back(segmentation.timing.stage_ms[s]);
  if (!runs.obstacles.asked) return {};
  const AxisLimits* const limits = limits_of(options, segmentation.method, true);
  if (Status status =
          find_obstacles(frame.view(), frame.camera, segmentation, runs.obstacles.options, limits, work.obstacles, work.found);
      !status) {
    return status;
  }
  times.obstacles_ms.push_back(work.found.total_ms);
  return {};
}

Row evaluate_frame(const Runs& runs, Method method, const std::string& dataset, io::Truth truth, const io::Frame& frame,
                   Work& work, Segmentation& segmentation) {
  const SegmentOptions options = runs.options_of(method);
  Times times;
  for (int run = 0; run < runs.repeat; ++run) {
    if (const Status status = run_once(runs, options, frame, work, segmentation, times); !status) {
      throw Failure(fmt::format("{}: {}: {}", dataset, frame.name, status.error().message));
    }
  }
  Row row{dataset, frame.name, method, {}, {}, {}};
  if (truth != io::Truth::none && frame.labels) row.scores = score(frame, truth, options, segmentation);
  row.scores[Quantity::planes] = static_cast<double>(segmentation.planes.size());
  row.scores[Quantity::median_ms] = median(times.total_ms);
  score_regions(row, runs.hoover, frame, truth, options, segmentation);
  set_derived(row.scores);
  for (std::size_t s = 0; s < kStages; ++s) row.stage_ms[s] = median(times.stage_ms[s]);
  if (runs.obstacles.asked) row.scores[Quantity::objects_median_ms] = median(times.obstacles_ms);
  if (runs.obstacles.asked && frame.objects) score_objects(row.scores, frame, work.found);
  if (runs.obstacles.asked && frame.labels) score_floor(row.scores, frame, truth, work.found);
  return row;
}

}  // namespace

io::Dataset open_dataset(const std::string& name, Runs& runs, std::string_view no_clouds) {
  const io::InputKind kind = unwrap(io::detect_kind(name));
  if (io::is_cloud(kind)) throw Failure(fmt::format("{}: {}", name, no_clouds));
  return open_frames(name, runs.inputs);
}

io::Truth truth_of(const io::Dataset& dataset) {
  const bool labelled_frame = dataset.kind == io::InputKind::frame && dataset.frames.front().labels;
  return dataset.truth == io::Truth::none && labelled_frame ? io::Truth::dominant : dataset.truth;
}

void evaluate_dataset(const Runs& runs, const std::string& name, const io::Dataset& dataset, const FrameVisitor& visit) {
  const io::Truth truth = truth_of(dataset);
  Progress progress(dataset.frames.size());
  Doubts doubts;
  Work work;
  std::vector<Segmentation> segmentations(runs.methods.size());
  for (const io::FrameFiles& files : dataset.frames) {
    progress.step(files.name);
    const io::Frame frame = unwrap(io::load_frame(files));
    doubts.look_at(files, frame, progress);
    std::vector<Row> rows;
    for (std::size_t m = 0; m < runs.methods.size(); ++m) {
      rows.push_back(evaluate_frame(runs, runs.methods[m], name, truth, frame, work, segmentations[m]));
    }
    visit(files, frame, rows, segmentations);
  }
}

std::vector<Row> means_of(const std::vector<std::string>& datasets, const std::vector<Method>& methods,
                          const std::vector<Row>& rows) {
  std::vector<Row> means;
  for (const std::string& dataset : datasets) {
    for (const Method method : methods) {
      std::vector<const Row*> chosen;
      for (const Row& row : rows) {
        if (row.dataset == dataset && row.method == method) chosen.push_back(&row);
      }
      means.push_back(mean_of(dataset, method, chosen));
    }
  }
  return means;
}

void check_named_once(const std::vector<std::string>& datasets) {
  for (auto later = datasets.begin(); later != datasets.end(); ++later) {
    const auto same = [&](const std::string& earlier) {
      std::error_code error;
      return earlier == *later || (std::filesystem::equivalent(earlier, *later, error) && !error);
    };
    if (std::any_of(datasets.begin(), later, same)) throw UsageError(fmt::format("DATASET: '{}' is named twice", *later));
  }
}

std::string value_text(const Scores& scores, Quantity quantity) {
  const std::optional<double>& value = scores[quantity];
  return value ? fmt::format("{:.{}f}", *value, info_of(quantity).decimals) : "-";
}

}  // namespace fransac::cli
