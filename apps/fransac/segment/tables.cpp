// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include "../obstacle_output.hpp"
#include "writers.hpp"

namespace fransac::cli {
namespace {

std::string normal_text(const Eigen::Vector3d& n) { return fmt::format("({:+.4f}, {:+.4f}, {:+.4f})", n.x(), n.y(), n.z()); }

Table plane_table(const Input& input) {
  std::vector<std::string> headings{"plane",   "<normal",  "d [m]",     input.is_cloud() ? "points" : "pixels",
                                    "support", "rms [mm]", "area [m2]", "confidence",
                                    "<kind"};
  if (input.is_folder_of_frames()) headings.insert(headings.begin(), "<frame");
  return Table(std::move(headings));
}

void add_planes(Table& table, const std::optional<std::string>& frame, const Segmentation& segmentation) {
  const bool judged = segmentation.method == Method::cells;  // the others do not judge
  for (const PlaneSegment& segment : segmentation.planes) {
    std::vector<std::string> cells{fmt::format("{}", segment.id),
                                   normal_text(segment.plane.normal),
                                   fmt::format("{:.4f}", segment.plane.d),
                                   fmt::format("{}", segment.inliers),
                                   fmt::format("{}", segment.support),
                                   fmt::format("{:.2f}", 1e3 * segment.rms_m),
                                   fmt::format("{:.3f}", segment.area_m2),
                                   judged ? fmt::format("{:.2f}", segment.confidence) : "",
                                   segment.kind == PlaneKind::unknown ? "" : std::string(enum_name(segment.kind))};
    if (frame) cells.insert(cells.begin(), *frame);
    table.add(std::move(cells));
  }
}

}  // namespace

ResultTables::ResultTables(const Input& input, bool obstacles)
    : obstacles_(obstacles),
      planes_(plane_table(input)),
      supports_(support_table(input.is_folder_of_frames())),
      obstacle_rows_(obstacle_table(input.is_folder_of_frames(), input.is_cloud())) {}

void ResultTables::add(const SegmentResult& result) {
  add_planes(planes_, result.frame, result.segmentation);
  if (!result.obstacles) return;
  add_support(supports_, result.frame, result.segmentation, *result.obstacles);
  add_obstacles(obstacle_rows_, result.frame, *result.obstacles);
}

std::string ResultTables::text() const {
  return planes_.text() + (obstacles_ ? "\n" + supports_.text() + "\n" + obstacle_rows_.text() : "");
}

}  // namespace fransac::cli
