// SPDX-License-Identifier: Apache-2.0
#include "scene.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>

#include "../errors.hpp"
#include "html.hpp"
#include "pictures.hpp"

namespace fransac::cli::report {
namespace {

/// The method whose planes the cloud shows where there is no truth: one that returns them all if there is one, else the paper's.
std::size_t method_to_show(std::span<const Segmentation> segmentations) {
  for (const Method wanted : {Method::cells, Method::fransac}) {
    const auto own = std::find_if(segmentations.begin(), segmentations.end(), [=](const auto& s) { return s.method == wanted; });
    if (own != segmentations.end()) return static_cast<std::size_t>(own - segmentations.begin());
  }
  return 0;
}

/// `shown`: the labels that the picture shows in place of the segmentation's.
FoundPlanes found_planes(Method method, const Segmentation& segmentation, const std::vector<std::uint8_t>& shown) {
  std::array<std::uint8_t, 256> colour{};
  for (std::size_t i = 0; i < shown.size(); ++i) colour[segmentation.labels[i]] = shown[i];
  FoundPlanes found{method, segmentation.up_source, {}};
  for (const PlaneSegment& s : segmentation.planes) {
    found.planes.push_back(
        {s.id, colour[static_cast<std::size_t>(s.id)], s.kind, s.area_m2, s.rms_m, s.confidence, s.inliers, s.plane});
  }
  return found;
}

std::string planes_note(const Row& row, std::size_t planes) {
  std::string note = fmt::format("{} plane{}", planes, planes == 1 ? "" : "s");
  if (row.scores[Quantity::f1]) note += fmt::format(", F1 {}", value_text(row.scores, Quantity::f1));
  return fmt::format("{}, {} ms", note, value_text(row.scores, Quantity::median_ms));
}

}  // namespace

Scene draw_scene(const io::FrameFiles& files, const io::Frame& frame, io::Truth truth, std::span<const Row> rows,
                 std::span<const Segmentation> segmentations, int width) {
  const DepthView depth = frame.view();
  const bool judged = truth != io::Truth::none && frame.labels.has_value();
  const auto labels_of = [&](std::size_t m) {
    return judged ? named_like(frame.labels->pixels, segmentations[m].labels) : segmentations[m].labels;
  };
  Scene scene{frame.name, {rows.begin(), rows.end()}, io::depth_range(depth), {}, {}, {}, {}};
  if (files.colour) {
    scene.views.push_back(picture("Colour", fmt::format("Photograph of {}", frame.name), "",
                                  unwrap(io::read_colour_image(*files.colour, files.limits)), width));
  }
  scene.views.push_back(
      picture("Depth", fmt::format("Depth of {}: {:.2f} to {:.2f} m", frame.name, scene.range.nearest_m, scene.range.farthest_m),
              "", depth_picture(depth, scene.range), width));
  const std::size_t shown = method_to_show(segmentations);
  const std::string painted = judged ? "the truth" : std::string(enum_name(rows[shown].method));
  io::ColourImage cloud = cloud_picture(depth, frame.camera, judged ? frame.labels->pixels : segmentations[shown].labels, width);
  if (cloud.size() > 0) {
    scene.views.push_back(picture("Cloud",
                                  fmt::format("Point cloud of {} from the side, in the colours of {}", frame.name, painted),
                                  fmt::format("from the side; colours: {}", painted), std::move(cloud), width));
  }
  if (judged) {
    scene.views.push_back(
        picture("Truth", fmt::format("True {} of {}", truth == io::Truth::planes ? "planes" : "dominant plane", frame.name),
                truth == io::Truth::planes ? "all planes" : "the dominant plane",
                io::overlay(depth, frame.labels->pixels, nullptr), width));
  }
  for (std::size_t m = 0; m < rows.size(); ++m) {
    const std::string method(enum_name(rows[m].method));
    const std::vector<std::uint8_t> labels = labels_of(m);
    if (segmentations[m].method == Method::cells) scene.found.push_back(found_planes(rows[m].method, segmentations[m], labels));
    scene.planes.push_back(picture(method, fmt::format("Planes that {} found in {}", method, frame.name),
                                   planes_note(rows[m], segmentations[m].planes.size()), io::overlay(depth, labels, nullptr),
                                   width));
    if (!judged) continue;
    scene.differences.push_back(picture(method, fmt::format("Differences between {} and the truth in {}", method, frame.name),
                                        fmt::format("recall {}, precision {}", value_text(rows[m].scores, Quantity::recall),
                                                    value_text(rows[m].scores, Quantity::precision)),
                                        difference_picture(frame.labels->pixels, segmentations[m].labels, frame.camera.width),
                                        width));
  }
  return scene;
}

}  // namespace fransac::cli::report
