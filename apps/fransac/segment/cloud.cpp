// SPDX-License-Identifier: Apache-2.0
#include <cstdint>
#include <vector>

#include "../errors.hpp"
#include "fransac/io/cloud_file.hpp"
#include "writers.hpp"

namespace fransac::cli {

namespace {

/// The labels of a cloud's points from those of the pixels that they were; none stay none.
template <class Label>
std::vector<Label> labels_of_points(const PointCloud& cloud, const std::vector<Label>& of_pixels) {
  std::vector<Label> labels(of_pixels.empty() ? 0 : cloud.size());
  for (std::size_t p = 0; p < labels.size(); ++p) labels[p] = of_pixels[cloud.source_of(p)];
  return labels;
}

}  // namespace

std::string encode_points(const std::filesystem::path& file, const SegmentResult& result) {
  constexpr auto kEncoding = io::CloudEncoding::binary;
  const auto& labels = result.segmentation.labels;
  const std::vector<std::uint16_t> ids = result.obstacles ? result.obstacles->labels : std::vector<std::uint16_t>();
  if (const PointCloud* const cloud = result.cloud(); cloud != nullptr) {
    return unwrap(io::encode_cloud(file, *cloud, labels, kEncoding, ids));
  }
  const PointCloud& points = *result.points;
  return unwrap(io::encode_cloud(file, points, labels_of_points(points, labels), kEncoding, labels_of_points(points, ids)));
}

}  // namespace fransac::cli
