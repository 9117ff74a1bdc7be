// SPDX-License-Identifier: Apache-2.0
#include "regression/robustness.hpp"

#include <algorithm>
#include <cstddef>
#include <utility>

#include "fransac/io/dataset.hpp"
#include "fransac/planes/segment.hpp"

namespace fransac::testing {
namespace {

Result<std::vector<std::uint8_t>> labels_of(const ChangedFrame& frame, const SegmentOptions& options) {
  Result<Segmentation> found = segment(frame.view(), frame.camera, options);
  if (found) return std::move(found->labels);
  if (found.error().code == ErrorCode::no_data) return std::vector<std::uint8_t>(frame.labels.size(), kLabelNoDepth);
  return Error{found.error().code, frame.kind + ": " + found.error().message};
}

/// The unchanged frame's labels where the changed one shows its pixels, but for what is no longer measured.
std::vector<std::uint8_t> carried_over(const std::vector<std::uint8_t>& labels, const ChangedFrame& frame) {
  std::vector<std::uint8_t> result(frame.source.size());
  for (std::size_t i = 0; i < result.size(); ++i) result[i] = frame.depth[i] == 0 ? kLabelNoDepth : labels[frame.source[i]];
  return result;
}

}  // namespace

Result<std::vector<Original>> recorded_frames(const std::filesystem::path& folder) {
  const auto dataset = io::list_frames(folder);
  if (!dataset) return dataset.error();
  std::vector<Original> originals;
  for (const io::FrameFiles& files : dataset->frames) {
    auto frame = io::load_frame(files);
    if (!frame) return frame.error();
    if (!frame->labels) return Error{ErrorCode::no_data, folder.string() + ": " + files.name + " has no truth"};
    originals.push_back(
        {dataset->name, files.name, frame->camera, std::move(frame->depth.pixels), std::move(frame->labels->pixels)});
  }
  return originals;
}

std::vector<Rendering> renderings() {
  std::vector<Rendering> list;
  for (const std::uint64_t seed : {1U, 2U}) {
    for (const char* scene : {"desk", "office", "boxes", "hall"}) {
      for (const synth::Sensor sensor :
           {synth::Sensor::none, synth::Sensor::kinect1, synth::Sensor::stereo, synth::Sensor::tof}) {
        list.push_back({scene, sensor, seed});
      }
    }
  }
  return list;
}

Original rendered_frame(const Rendering& rendering) {
  synth::SynthOptions options;
  options.scene = rendering.scene;
  options.sensor = rendering.sensor;
  options.seed = rendering.seed;
  auto frame = synth::render(options);
  if (!frame) return {};
  return {"synth " + std::string(enum_name(rendering.sensor)), rendering.scene + ' ' + std::to_string(rendering.seed),
          frame->camera, std::move(frame->depth), std::move(frame->labels)};
}

Result<std::vector<Comparison>> compare(const Original& original, const SegmentOptions& options,
                                        const std::function<bool(const Change&)>& chosen) {
  const ChangedFrame unchanged = unchanged_frame(original.camera, original.depth, original.labels);
  const auto labels = labels_of(unchanged, options);
  if (!labels) return labels.error();
  const InstanceScore before = instance_score(original.labels, *labels);
  std::vector<Comparison> comparisons;
  for (const Change& change : changes()) {
    if (!chosen(change)) continue;
    const ChangedFrame frame = changed_frame(change, original.camera, original.depth, original.labels);
    if (frame.depth.empty()) continue;
    const auto changed = labels_of(frame, options);
    if (!changed) return Error{changed.error().code, original.name + ", " + changed.error().message};
    const InstanceScore after = instance_score(frame.labels, *changed);
    if (after.true_planes == 0) continue;
    comparisons.push_back(
        {&change, original.group, original.name, before, after, instance_score(frame.labels, carried_over(*labels, frame))});
  }
  return comparisons;
}

std::vector<Share> shares(std::span<const Comparison> comparisons) {
  std::vector<Share> list;
  for (const Change& change : changes()) {
    Share share;
    share.change = &change;
    double f1_50 = 0.0;
    double weighted_iou = 0.0;
    for (const Comparison& c : comparisons) {
      if (c.change != &change) continue;
      ++share.frames;
      f1_50 += c.before.f1_50;
      weighted_iou += c.before.weighted_iou;
      share.f1_50 += c.after.f1_50;
      share.weighted_iou += c.after.weighted_iou;
      share.same_f1_50 += c.same.f1_50;
      share.same_weighted_iou += c.same.weighted_iou;
    }
    if (f1_50 <= 0.0) continue;
    share.f1_50 /= f1_50;
    share.same_f1_50 /= f1_50;
    share.weighted_iou /= weighted_iou;
    share.same_weighted_iou /= weighted_iou;
    list.push_back(share);
  }
  return list;
}

}  // namespace fransac::testing
