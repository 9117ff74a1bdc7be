// SPDX-License-Identifier: Apache-2.0
#include "result.hpp"

#include <fmt/format.h>

#include "../errors.hpp"
#include "../obstacle_output.hpp"
#include "checks.hpp"
#include "fransac/filter/correct.hpp"
#include "fransac/filter/deproject.hpp"
#include "fransac/io/overlay.hpp"

namespace fransac::cli {
namespace {

/// A cloud's distance from its origin of coordinates as a depth image, to be shaded.
std::vector<float> distances(const PointCloud& cloud) {
  std::vector<float> metres(cloud.size(), 0.0F);
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    if (cloud.finite(i)) metres[i] = static_cast<float>(cloud.point(i).norm());
  }
  return metres;
}

}  // namespace

const SegmentResult& Segmenter::find(std::size_t i, Progress& progress) {
  result_.name = input_.name_of(i);
  if (input_.is_folder_of_frames()) result_.frame = input_.frames[i].name;
  result_.content = load(input_, i, doubts_, progress);
  check_content(request_, result_.content);
  segment(result_.name, result_.content, request_.options, workspace_, result_.segmentation);
  if (request_.obstacles.asked) {
    if (!result_.obstacles) result_.obstacles.emplace();
    if (const Status status = find_obstacles_in_content(); !status) {
      throw Failure(fmt::format("{}: {}", result_.name, status.error().message));
    }
  }
  if (request_.outlines) outline();
  if (request_.grid.asked()) {
    const io::Frame& frame = result_.image();
    result_.grid =
        unwrap(occupancy_grid(frame.view(), frame.camera, result_.segmentation, *result_.obstacles, request_.occupancy));
  }
  if (request_.overlay.asked()) result_.overlay = draw_overlay(i);
  if (request_.cloud.asked() && result_.cloud() == nullptr) result_.points = points_of_image();
  return result_;
}

Status Segmenter::find_obstacles_in_content() {
  const Segmentation& segmentation = result_.segmentation;
  const PointCloud* const cloud = result_.cloud();
  const AxisLimits* const limits = limits_of(request_.options, segmentation.method, cloud == nullptr);
  if (cloud == nullptr) {
    const io::Frame& frame = result_.image();
    return find_obstacles(frame.view(), frame.camera, segmentation, request_.obstacles.options, limits, obstacle_workspace_,
                          *result_.obstacles);
  }
  Result<Obstacles> found = find_obstacles(*cloud, segmentation, request_.obstacles.options, limits);
  if (!found) return found.error();
  result_.obstacles = std::move(*found);
  return {};
}

void Segmenter::outline() {
  const Camera& camera = result_.image().camera;
  result_.outlines = outlines(result_.segmentation, camera);
  if (result_.obstacles) result_.drop_outlines = drop_outlines(*result_.obstacles, camera);
}

io::ColourImage Segmenter::draw_overlay(std::size_t i) const {
  std::vector<float> metres;
  std::optional<io::ColourImage> colour;
  DepthView view;
  if (const PointCloud* const cloud = result_.cloud(); cloud != nullptr) {
    metres = distances(*cloud);
    view = DepthView::from_float(metres.data(), cloud->width, cloud->height);
  } else {
    view = result_.image().view();
    if (input_.frames[i].colour) colour = unwrap(io::read_colour_image(*input_.frames[i].colour, input_.limits));
  }
  const io::ColourImage* const background = colour ? &*colour : nullptr;
  const auto& labels = result_.segmentation.labels;
  if (result_.obstacles) return obstacle_overlay(view, labels, result_.obstacles->labels, background);
  io::ColourImage picture = io::overlay(view, labels, background);
  io::number_planes(picture, labels);
  return picture;
}

PointCloud Segmenter::points_of_image() const {
  const io::Frame& frame = result_.image();
  const Distortion& distortion = result_.segmentation.distortion;
  CorrectedDepth corrected;
  if (!distortion.empty()) check(correct(frame.view(), distortion, request_.options.saturated, corrected));
  PointCloud points;
  deproject(distortion.empty() ? frame.view() : corrected.view, frame.camera, points);
  return points;
}

}  // namespace fransac::cli
