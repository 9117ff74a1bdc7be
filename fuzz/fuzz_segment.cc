// SPDX-License-Identifier: Apache-2.0
// All methods with any options, on a small depth image and on its points: an error, or labels and planes that fit each other,
// the same on any number of threads and in memory that held another frame; outlines enclose exactly the labelled pixels.
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "check_segmentation.hpp"
#include "draw.hpp"
#include "fransac/planes/outline.hpp"

namespace {

using namespace fransac;
using namespace fransac::fuzz;

/// Twice the area of a ring, positive where it is anticlockwise as displayed.
double doubled_area(const Ring& ring) {
  require(ring.pixels.size() >= 3 && ring.points.size() == ring.pixels.size());
  double area = 0.0;
  for (std::size_t i = 0; i < ring.pixels.size(); ++i) {
    const Eigen::Vector2d& a = ring.pixels[i];
    const Eigen::Vector2d& b = ring.pixels[(i + 1) % ring.pixels.size()];
    require(a.allFinite() && ring.points[i].allFinite());
    area -= a.x() * b.y() - b.x() * a.y();
  }
  return area;
}

void check_outlines(const Segmentation& s, const Camera& camera, const OutlineOptions& simplified) {
  const auto exact = outlines(s, camera, {.tolerance_px = 0.0, .min_pixels = 1});
  require(exact.size() == s.planes.size());
  for (std::size_t k = 0; k < exact.size(); ++k) {
    double area = 0.0;
    for (const Outline& part : exact[k]) {
      area += doubled_area(part.outer);
      for (const Ring& hole : part.holes) area += doubled_area(hole);
    }
    require(area == 2.0 * static_cast<double>(s.planes[k].inliers));
  }
  for (const auto& parts : outlines(s, camera, simplified)) {
    for (const Outline& part : parts) {
      (void)doubled_area(part.outer);
      for (const Ring& hole : part.holes) (void)doubled_area(hole);
    }
  }
}

/// Segments twice; the result of the first, or nothing after an error.
template <class Measured, class... Input>
std::optional<Segmentation> run(const SegmentOptions& options, Workspace& workspace, std::size_t size, const Measured& measured,
                                const Input&... input) {
  const Result<Segmentation> once = segment(input..., options);
  SegmentOptions other = options;
  if (validate(options)) other.threads = options.threads == 1 ? 2 : 1;
  Segmentation again;
  const Status status = segment(input..., other, workspace, again);
  require(once.ok() == status.ok());
  if (!once) {
    require_message(once.error());
    require(once.error().message == status.error().message && again.planes.empty());
    return std::nullopt;
  }
  require(validate(options).ok());
  check(*once, size, measured);
  check_same(*once, again);
  const int most = with_defaults(options, once->method).max_planes.value();
  require(once->planes.size() <= static_cast<std::size_t>(most == 0 ? kMaxPlanes : most));
  return *once;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  Bytes bytes(data, size);
  const SegmentOptions options = draw_segment_options(bytes);
  const DrawnDepth depth = draw_depth(bytes);
  Workspace workspace;
  const auto measured = [&](std::size_t i) {
    const int u = static_cast<int>(i) % depth.view.width();
    const int v = static_cast<int>(i) / depth.view.width();
    const bool saturated =
        depth.view.format() == DepthFormat::uint16 && options.saturated != 0 && depth.view.row_uint16(v)[u] == options.saturated;
    return !saturated && depth.view.metres(u, v) > 0.0F;
  };
  const auto of_image = run(options, workspace, depth.view.size(), measured, depth.view, depth.camera);
  if (of_image) {
    OutlineOptions simplified;
    simplified.tolerance_px = draw_seldom(bytes) ? draw_any(bytes) : draw_number(bytes, 0.0, 10.0);
    simplified.min_pixels = bytes.ConsumeIntegral<std::int16_t>();
    check_outlines(*of_image, depth.camera, simplified);
  }
  const PointCloud cloud = draw_cloud(bytes, depth);
  run(
      options, workspace, cloud.size(), [&](std::size_t i) { return cloud.measured(i); }, cloud);
  if (of_image) {  // the next frame of a sequence
    workspace.expect(of_image->planes);
    Segmentation next;
    require(segment(depth.view, depth.camera, options, workspace, next).ok());
    check(next, depth.view.size(), measured);
  }
  return 0;
}
