// SPDX-License-Identifier: Apache-2.0
/// What is left of the score of frames when they are changed in ways that must not matter.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "changed_frames.hpp"
#include "fransac/core/result.hpp"
#include "fransac/planes/options.hpp"
#include "fransac/synth/synth.hpp"
#include "instance_score.hpp"

namespace fransac::testing {

/// What must be left: the share of the unchanged frames' score, of instance F1 at IoU 0.5 and of area-weighted IoU alike.
struct Bars {
  double mean = 0.97;        ///< Over the kinds of change.
  double worst = 0.90;       ///< Of any kind.
  double few_pixels = 0.75;  ///< Of any kind with every 8th pixel (80x60 of 640x480), instead of `worst`.

  /// Of one kind.
  [[nodiscard]] constexpr double of(const Change& change) const { return change.step >= 8 ? few_pixels : worst; }
};
inline constexpr Bars kBars;

/// A frame with truth that is to be changed.
struct Original {
  std::string group;  ///< Its data set; of rendered frames the sensor model.
  std::string name;
  Camera camera;
  std::vector<std::uint16_t> depth;
  std::vector<std::uint8_t> labels;
};

/// The frames of a folder whose truth holds all planes. An error names what cannot be read.
Result<std::vector<Original>> recorded_frames(const std::filesystem::path& folder);

/// Which frame to render.
struct Rendering {
  std::string scene;
  synth::Sensor sensor = synth::Sensor::none;
  std::uint64_t seed = 0;
};
/// All that are measured: four scenes, every sensor model, two seeds.
std::vector<Rendering> renderings();
/// Renders it. Without pixels where it cannot.
Original rendered_frame(const Rendering& rendering);

/// One frame, changed in one way.
struct Comparison {
  const Change* change = nullptr;
  std::string group;
  std::string frame;
  InstanceScore before;  ///< Of the unchanged frame.
  InstanceScore after;   ///< Of the changed one.
  /// Of the unchanged frame's labels on the pixels of the changed one, by its truth. What this lacks is the measure's own doing:
  /// planes of which a sliver is left, edges of coarser pixels.
  InstanceScore same;
};

/// Compares each change that means something to the frame, leaves a true plane, and is chosen. An error of segment() is an error
/// here but for no_data, which finds no plane.
Result<std::vector<Comparison>> compare(const Original& original, const SegmentOptions& options,
                                        const std::function<bool(const Change&)>& chosen);

/// Of all frames that are compared under one kind of change: mean score of the changed over mean score of the unchanged.
struct Share {
  const Change* change = nullptr;
  int frames = 0;
  double f1_50 = 0.0;
  double weighted_iou = 0.0;
  double same_f1_50 = 0.0;  ///< Of Comparison::same.
  double same_weighted_iou = 0.0;
};
/// In the order of changes(); without the kinds that were not compared.
std::vector<Share> shares(std::span<const Comparison> comparisons);

}  // namespace fransac::testing
