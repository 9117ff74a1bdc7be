// SPDX-License-Identifier: Apache-2.0
#include "pictures.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <numbers>
#include <utility>

#include "../errors.hpp"
#include "fransac/core/labels.hpp"
#include "fransac/core/point_cloud.hpp"
#include "fransac/eval/metrics.hpp"
#include "fransac/filter/deproject.hpp"

namespace fransac::cli::report {
namespace {

io::ColourImage filled(int width, int height, const Colour& colour) {
  io::ColourImage image{width, height, 3, {}};
  image.pixels.reserve(3 * image.size());
  for (std::size_t i = 0; i < image.size(); ++i) image.pixels.insert(image.pixels.end(), colour.begin(), colour.end());
  return image;
}

void put(io::ColourImage& image, std::size_t i, const Colour& colour) {
  std::copy(colour.begin(), colour.end(), image.pixels.begin() + static_cast<std::ptrdiff_t>(3 * i));
}

bool is_plane(std::uint8_t label) { return label != kLabelNoDepth && label != kLabelNoPlane; }

/// Values that all but `share` of the numbers at either end lie between.
std::pair<double, double> spread(std::vector<double> numbers, double share) {
  const auto at = [&](double fraction) {
    const auto rank = static_cast<std::ptrdiff_t>(fraction * static_cast<double>(numbers.size() - 1));
    std::nth_element(numbers.begin(), numbers.begin() + rank, numbers.end());
    return numbers[static_cast<std::size_t>(rank)];
  };
  return {at(share), at(1.0 - share)};
}

/// A point as the tilted view sees it.
struct Seen {
  double x = 0.0;  ///< x / z, then pixels.
  double y = 0.0;
  double z = 0.0;     ///< Distance along the view, metres.
  double size = 0.0;  ///< Of the pixel's footprint, in units of x.
  std::uint32_t source = 0;
};

/// The points from a viewpoint turned about the cloud's middle, a little farther away than the camera.
std::vector<Seen> look_at(const PointCloud& cloud, const Camera& camera) {
  constexpr double kDegree = std::numbers::pi / 180.0;
  constexpr double kTurn = 32.0 * kDegree;  // to the side: chosen by eye, as are the others
  constexpr double kTilt = 14.0 * kDegree;  // upwards
  constexpr double kDistance = 1.25;        // of the middle's
  std::vector<double> depths(cloud.size());
  for (std::size_t i = 0; i < cloud.size(); ++i) depths[i] = cloud.point(i).z();
  const double middle_m = spread(depths, 0.5).first;
  const Eigen::Vector3d pivot(0.0, 0.0, middle_m);
  const Eigen::Matrix3d turn =
      (Eigen::AngleAxisd(kTilt, Eigen::Vector3d::UnitX()) * Eigen::AngleAxisd(kTurn, Eigen::Vector3d::UnitY()))
          .toRotationMatrix();
  std::vector<Seen> seen;
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const Eigen::Vector3d p = turn * (cloud.point(i) - pivot) + kDistance * pivot;
    if (p.z() < 0.1 * middle_m) continue;  // beside or behind the viewer
    seen.push_back({p.x() / p.z(), p.y() / p.z(), p.z(), depths[i] / camera.fx / p.z(), cloud.source_of(i)});
  }
  return seen;
}

/// Scales x and y to pixels so that all but a few strays fit.
void fit(std::vector<Seen>& seen, int width, int height) {
  constexpr double kStrays = 0.004;
  constexpr double kFill = 0.94;
  std::vector<double> xs;
  std::vector<double> ys;
  for (const Seen& point : seen) {
    xs.push_back(point.x);
    ys.push_back(point.y);
  }
  const auto [left, right] = spread(std::move(xs), kStrays);
  const auto [top, bottom] = spread(std::move(ys), kStrays);
  const double scale = kFill * std::min(width / std::max(right - left, 1e-9), height / std::max(bottom - top, 1e-9));
  for (Seen& point : seen) {
    point.x = (point.x - 0.5 * (left + right)) * scale + 0.5 * width;
    point.y = (point.y - 0.5 * (top + bottom)) * scale + 0.5 * height;
    point.size *= scale;
  }
}

/// The nearest point per pixel.
struct ZBuffer {
  static constexpr float kFar = std::numeric_limits<float>::max();
  int width;
  int height;
  std::vector<float> z;
  std::vector<std::uint8_t> label;

  ZBuffer(int columns, int rows) : width(columns), height(rows), z(size(), kFar), label(size(), kLabelNoDepth) {}
  [[nodiscard]] std::size_t size() const { return static_cast<std::size_t>(width) * static_cast<std::size_t>(height); }
  [[nodiscard]] std::size_t at(int u, int v) const {
    return static_cast<std::size_t>(v) * static_cast<std::size_t>(width) + static_cast<std::size_t>(u);
  }

  void splat(const Seen& point, std::uint8_t its_label) {
    constexpr double kStretch = 1.6;     // a surface that the camera saw askew may face the new view
    constexpr double kLargest_px = 6.0;  // near surfaces seen edge-on would become slabs
    if (!(std::abs(point.x) < 4.0 * width && std::abs(point.y) < 4.0 * height)) return;
    const double half = 0.5 * std::clamp(std::ceil(kStretch * point.size), 2.0, kLargest_px);
    const auto low = [](double c) { return std::max(0, static_cast<int>(std::ceil(c))); };
    const auto high = [](double c, int end) { return std::min(end, static_cast<int>(std::ceil(c))); };
    for (int v = low(point.y - half); v < high(point.y + half, height); ++v) {
      for (int u = low(point.x - half); u < high(point.x + half, width); ++u) {
        if (static_cast<float>(point.z) >= z[at(u, v)]) continue;
        z[at(u, v)] = static_cast<float>(point.z);
        label[at(u, v)] = its_label;
      }
    }
  }

  /// Eye-dome lighting (Boucheny, "Visualisation scientifique de grands volumes de données", 2009): a pixel is darker the
  /// more its neighbours stand in front of it, which shows edges and folds without normals. Neighbours count in opposite
  /// pairs, so that a slanted plane is no darker than a frontal one.
  [[nodiscard]] double light(int u, int v) const {
    constexpr int kReach_px = 2;
    constexpr double kStrength = 12.0;
    const double hidden = std::max(0.0, in_front(u, v, kReach_px, 0)) + std::max(0.0, in_front(u, v, 0, kReach_px));
    return std::max(0.3, std::exp(-kStrength * hidden));
  }

 private:
  /// By how much the pixels at either side are nearer together, as a logarithm; what is not seen is as far as the pixel.
  [[nodiscard]] double in_front(int u, int v, int du, int dv) const {
    const double own = std::log(static_cast<double>(z[at(u, v)]));
    double sum = 0.0;
    for (const int side : {-1, 1}) {
      const int x = u + side * du;
      const int y = v + side * dv;
      const bool seen = x >= 0 && x < width && y >= 0 && y < height && z[at(x, y)] != kFar;
      if (seen) sum += own - std::log(static_cast<double>(z[at(x, y)]));
    }
    return sum;
  }
};

}  // namespace

Colour depth_colour(double share) {
  // Every eighth of viridis (van der Walt and Smith, 2015): even steps for the eye, in every kind of colour vision.
  constexpr std::array<Colour, 9> kViridis{{{68, 1, 84},
                                            {71, 44, 122},
                                            {59, 81, 139},
                                            {44, 113, 142},
                                            {33, 144, 141},
                                            {39, 173, 129},
                                            {92, 200, 99},
                                            {170, 220, 50},
                                            {253, 231, 37}}};
  const double place = (1.0 - std::clamp(share, 0.0, 1.0)) * (kViridis.size() - 1);
  const auto below = std::min(static_cast<std::size_t>(place), kViridis.size() - 2);
  const double part = place - static_cast<double>(below);
  Colour colour{};
  for (std::size_t c = 0; c < colour.size(); ++c) {
    colour[c] = static_cast<std::uint8_t>(std::lround((1.0 - part) * kViridis[below][c] + part * kViridis[below + 1][c]));
  }
  return colour;
}

io::ColourImage depth_picture(const DepthView& depth, const io::DepthRange& range) {
  io::ColourImage image = filled(depth.width(), depth.height(), kNothingColour);
  const double span_m = std::max(1e-6, static_cast<double>(range.farthest_m) - static_cast<double>(range.nearest_m));
  for (std::size_t i = 0; i < image.size(); ++i) {
    const float z_m = depth.metres(static_cast<int>(i) % depth.width(), static_cast<int>(i) / depth.width());
    if (z_m > 0.0F) put(image, i, depth_colour((static_cast<double>(z_m) - static_cast<double>(range.nearest_m)) / span_m));
  }
  return image;
}

io::ColourImage cloud_picture(const DepthView& depth, const Camera& camera, std::span<const std::uint8_t> labels, int width) {
  constexpr int kOversampling = 2;
  constexpr Colour kNoPlaneColour{170, 170, 170};
  PointCloud cloud;
  deproject(depth, camera, cloud);
  if (cloud.empty()) return {};
  std::vector<Seen> seen = look_at(cloud, camera);
  if (seen.empty()) return {};
  const int columns = kOversampling * std::min(width, depth.width());
  ZBuffer buffer(columns, std::max(1, columns * depth.height() / depth.width()));
  fit(seen, buffer.width, buffer.height);
  for (const Seen& point : seen) buffer.splat(point, labels[point.source]);
  io::ColourImage image = filled(buffer.width, buffer.height, kNothingColour);
  for (int v = 0; v < buffer.height; ++v) {
    for (int u = 0; u < buffer.width; ++u) {
      const std::size_t i = buffer.at(u, v);
      if (buffer.z[i] == ZBuffer::kFar) continue;
      Colour colour = is_plane(buffer.label[i]) ? io::label_colour(buffer.label[i]) : kNoPlaneColour;
      for (std::uint8_t& channel : colour) channel = static_cast<std::uint8_t>(std::lround(channel * buffer.light(u, v)));
      put(image, i, colour);
    }
  }
  return shrunk(std::move(image), width);
}

io::ColourImage difference_picture(std::span<const std::uint8_t> truth, std::span<const std::uint8_t> predicted, int width) {
  io::ColourImage image = filled(width, static_cast<int>(truth.size()) / width, kNothingColour);
  const std::uint8_t first = unwrap(eval::first_judged_plane(truth, predicted));
  for (std::size_t i = 0; i < truth.size(); ++i) {
    if (truth[i] == kLabelNoDepth) continue;
    const bool on = truth[i] == kLabelFirst;
    const bool found = predicted[i] == first;
    put(image, i, on ? (found ? kHitColour : kMissedColour) : (found ? kFalseColour : kRestColour));
  }
  return image;
}

std::vector<std::uint8_t> named_like(std::span<const std::uint8_t> truth, std::span<const std::uint8_t> predicted) {
  std::vector<std::array<std::uint32_t, 256>> overlap(256);
  std::array<std::uint32_t, 256> area{};
  std::array<bool, 256> taken{};
  for (std::size_t i = 0; i < truth.size(); ++i) {
    ++overlap[predicted[i]][truth[i]];
    ++area[predicted[i]];
  }
  int fresh = 0;
  for (const std::uint8_t label : truth) fresh = std::max(fresh, is_plane(label) ? static_cast<int>(label) : 0);
  std::array<std::uint8_t, 256> name{};
  name[kLabelNoPlane] = kLabelNoPlane;
  for (std::size_t p = kLabelFirst; p < kLabelNoPlane; ++p) {
    const auto planes = std::span(overlap[p]).subspan(kLabelFirst, kMaxPlanes);
    const auto best = static_cast<std::size_t>(std::max_element(planes.begin(), planes.end()) - planes.begin()) + kLabelFirst;
    const bool same = 2 * overlap[p][best] > area[p] && !taken[best];
    if (area[p] == 0) continue;
    name[p] = static_cast<std::uint8_t>(same ? static_cast<int>(best) : std::min(++fresh, kMaxPlanes));
    taken[name[p]] = true;
  }
  std::vector<std::uint8_t> named(predicted.size());
  std::transform(predicted.begin(), predicted.end(), named.begin(), [&](std::uint8_t label) { return name[label]; });
  return named;
}

io::ColourImage shrunk(io::ColourImage image, int width) {
  if (image.width <= width) return image;
  io::ColourImage small{width, std::max(1, image.height * width / image.width), 3, {}};
  small.pixels.reserve(3 * small.size());
  for (int v = 0; v < small.height; ++v) {
    for (int u = 0; u < small.width; ++u) {
      const int top = v * image.height / small.height;
      const int bottom = std::max(top + 1, (v + 1) * image.height / small.height);
      const int left = u * image.width / small.width;
      const int right = std::max(left + 1, (u + 1) * image.width / small.width);
      std::array<std::uint32_t, 3> sum{};
      for (int y = top; y < bottom; ++y) {
        for (int x = left; x < right; ++x) {
          const std::size_t i =
              3 * (static_cast<std::size_t>(y) * static_cast<std::size_t>(image.width) + static_cast<std::size_t>(x));
          for (std::size_t c = 0; c < 3; ++c) sum[c] += image.pixels[i + c];
        }
      }
      const auto count = static_cast<std::uint32_t>((bottom - top) * (right - left));
      for (const std::uint32_t channel : sum) small.pixels.push_back(static_cast<std::uint8_t>((channel + count / 2) / count));
    }
  }
  return small;
}

Picture picture(const std::string& title, const std::string& alt, const std::string& note, io::ColourImage image, int width) {
  image = shrunk(std::move(image), width);
  return {title, note, alt, png_uri(unwrap(io::encode_png(image))), image.width, image.height};
}

}  // namespace fransac::cli::report
