// SPDX-License-Identifier: Apache-2.0
/// The method `cells`: every plane of a depth image, at full resolution. docs/algorithms.md derives its steps.
#pragma once

#include "fransac/core/result.hpp"
#include "fransac/core/sensor.hpp"
#include "fransac/planes/segment.hpp"
#include "planes/cells/grid.hpp"
#include "planes/cells/image_rows.hpp"
#include "planes/cells/judge.hpp"
#include "planes/cells/labels.hpp"
#include "planes/cells/merge.hpp"
#include "planes/cells/regions.hpp"
#include "planes/stage_clock.hpp"

namespace fransac::cells {

/// Memory that a stream of frames keeps.
struct Buffers {
  ImageRowsBuffers image;
  GridBuffers grid_buffers;
  Grid grid;
  RegionBuffers region_buffers;
  Regions regions;
  JudgeBuffersOfTasks judge;
  MergeBuffers merge;
  ReassignBuffers reassign;
  std::vector<PlaneSegment> wanted;     ///< By Workspace::expect.
  std::vector<ExpectedPlane> expected;  ///< The same in the image.
  std::vector<std::uint8_t> labels;     ///< Per region.
  std::vector<std::int16_t> ranked;     ///< Regions by label.
  LabelPixelBuffers pixels;
};

/// Finds and labels all planes. `options` are complete (with_defaults), `limits` null or what is kept of the image; `result` has
/// its size and an empty list of planes.
Status find_planes(const DepthView& depth, const Camera& camera, const SegmentOptions& options, const AxisLimits* limits,
                   Buffers& buffers, StageClock& clock, Segmentation& result);

}  // namespace fransac::cells
