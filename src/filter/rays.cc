// SPDX-License-Identifier: Apache-2.0
#include "fransac/filter/rays.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <new>
#include <string>

#include "core/caught.hpp"
#include "fransac/core/labels.hpp"

namespace fransac {
namespace {

/// Farther apart in the ideal image, neighbouring rays are no neighbours: the table is of something else there. It also bounds
/// the work that a table can ask for.
constexpr double kMaxStep_px = 16.0;

Error invalid(const std::string& what) { return {ErrorCode::invalid_argument, what}; }

std::string size_text(int width, int height) { return std::to_string(width) + " x " + std::to_string(height); }

std::size_t pixels(int width, int height) { return static_cast<std::size_t>(width) * static_cast<std::size_t>(height); }

Status check(const RayTable& rays) {
  if (rays.width < 1 || rays.width > kMaxImageSide || rays.height < 1 || rays.height > kMaxImageSide) {
    return invalid("ray table: width and height must be between 1 and " + std::to_string(kMaxImageSide) + ", are " +
                   size_text(rays.width, rays.height));
  }
  const std::size_t n = pixels(rays.width, rays.height);
  if (rays.x.size() == n && rays.y.size() == n) return {};
  return invalid("ray table: x and y must have " + std::to_string(n) + " values, have " + std::to_string(rays.x.size()) +
                 " and " + std::to_string(rays.y.size()));
}

Status check(const DepthView& depth, const RayMap& map) {
  if (Status status = validate(depth); !status) return status;
  if (depth.width() == map.width && depth.height() == map.height && map.projected.size() == depth.size()) return {};
  return invalid("ray map is for " + size_text(map.width, map.height) + " pixels, the depth image has " +
                 size_text(depth.width(), depth.height()));
}

/// A place in the ideal image; NaN where the pixel has no ray.
struct Place {
  double u;
  double v;
};

class MapBuilder {
 public:
  MapBuilder(const RayTable& rays, RayMap& map) : rays_(rays), map_(map) {
    map_.original.assign(pixels(map.ideal.width, map.ideal.height), RayMap::kNone);
    map_.projected.assign(pixels(rays.width, rays.height), RayMap::kNone);
    nearest_.assign(map_.original.size(), std::numeric_limits<float>::infinity());
  }

  void build() {
    for (int v = 0; v < rays_.height; ++v) {
      for (int u = 0; u < rays_.width; ++u) {
        offer_own_pixel(u, v);
        if (u + 1 < rays_.width && v + 1 < rays_.height) offer_between(u, v);
      }
    }
  }

 private:
  [[nodiscard]] std::size_t index(int u, int v) const { return pixels(rays_.width, v) + static_cast<std::size_t>(u); }

  [[nodiscard]] Place place(int u, int v) const {
    const Camera& c = map_.ideal;
    const std::size_t i = index(u, v);
    return {c.fx * static_cast<double>(rays_.x[i]) + c.cx, c.fy * static_cast<double>(rays_.y[i]) + c.cy};
  }

  /// Takes the original pixel for the ideal one if none offered so far is nearer; of equals the first.
  void offer(int u, int v, std::size_t original, const Place& at) {
    const std::size_t ideal = pixels(map_.ideal.width, v) + static_cast<std::size_t>(u);
    const auto distance = static_cast<float>(std::hypot(at.u - u, at.v - v));
    if (!(distance < nearest_[ideal])) return;
    nearest_[ideal] = distance;
    map_.original[ideal] = static_cast<std::uint32_t>(original);
  }

  void offer_own_pixel(int u, int v) {
    const Place at = place(u, v);
    const double ideal_u = std::floor(at.u + 0.5);
    const double ideal_v = std::floor(at.v + 0.5);
    const bool inside = ideal_u >= 0.0 && ideal_u < map_.ideal.width && ideal_v >= 0.0 && ideal_v < map_.ideal.height;
    if (!inside) return;  // or NaN
    const int i = static_cast<int>(ideal_u);
    const int j = static_cast<int>(ideal_v);
    map_.projected[index(u, v)] = static_cast<std::uint32_t>(pixels(map_.ideal.width, j) + static_cast<std::size_t>(i));
    offer(i, j, index(u, v), at);
  }

  /// Offers the four pixels from (u, v) on to all ideal pixels in the box of their places: a stretched image has no holes.
  void offer_between(int u, int v) {
    const std::array<Place, 4> places{place(u, v), place(u + 1, v), place(u, v + 1), place(u + 1, v + 1)};
    const std::array<std::size_t, 4> originals{index(u, v), index(u + 1, v), index(u, v + 1), index(u + 1, v + 1)};
    const auto [left, right] = std::minmax({places[0].u, places[1].u, places[2].u, places[3].u});
    const auto [top, bottom] = std::minmax({places[0].v, places[1].v, places[2].v, places[3].v});
    double sum = 0.0;
    for (const Place& p : places) sum += p.u + p.v;
    if (!std::isfinite(sum) || right - left > kMaxStep_px || bottom - top > kMaxStep_px) return;
    const auto clamped = [](double x, int size) { return static_cast<int>(std::clamp(x, -1.0, static_cast<double>(size))); };
    const int first = std::max(0, clamped(std::ceil(left), map_.ideal.width));
    const int last = std::min(map_.ideal.width - 1, clamped(std::floor(right), map_.ideal.width));
    const int lowest = std::min(map_.ideal.height - 1, clamped(std::floor(bottom), map_.ideal.height));
    for (int j = std::max(0, clamped(std::ceil(top), map_.ideal.height)); j <= lowest; ++j) {
      for (int i = first; i <= last; ++i) {
        for (std::size_t k = 0; k < places.size(); ++k) offer(i, j, originals[k], places[k]);
      }
    }
  }

  const RayTable& rays_;
  RayMap& map_;
  std::vector<float> nearest_;
};

float metres_at(const DepthView& depth, std::uint32_t i) {
  const auto width = static_cast<std::uint32_t>(depth.width());
  return depth.metres(static_cast<int>(i % width), static_cast<int>(i / width));
}

}  // namespace

Result<RayMap> ray_map(const RayTable& rays, const Camera& ideal) try {
  if (Status status = check(rays); !status) return status.error();
  if (Status status = validate(ideal); !status) return status.error();
  RayMap map;
  map.ideal = ideal;
  map.width = rays.width;
  map.height = rays.height;
  MapBuilder(rays, map).build();
  return map;
} catch (const std::exception& exception) {
  return caught(exception, [&] { return "ray map of " + size_text(ideal.width, ideal.height) + " pixels"; });
}

Status undistort(const DepthView& depth, const RayMap& map, std::vector<float>& metres) try {
  if (Status status = check(depth, map); !status) return status;
  metres.resize(map.original.size());
  for (std::size_t i = 0; i < metres.size(); ++i) {
    metres[i] = map.original[i] < depth.size() ? metres_at(depth, map.original[i]) : 0.0F;
  }
  return {};
} catch (const std::exception& exception) {
  return caught(exception, [&] { return "image of " + std::to_string(map.original.size()) + " pixels"; });
}

Status labels_to_original(const DepthView& depth, const RayMap& map, std::span<const std::uint8_t> ideal_labels,
                          std::span<std::uint8_t> labels) try {
  if (Status status = check(depth, map); !status) return status;
  if (ideal_labels.size() != map.original.size() || labels.size() != depth.size()) {
    return invalid("labels: there must be " + std::to_string(map.original.size()) + " of the ideal image and " +
                   std::to_string(depth.size()) + " of the original, are " + std::to_string(ideal_labels.size()) + " and " +
                   std::to_string(labels.size()));
  }
  for (std::size_t i = 0; i < labels.size(); ++i) {
    const std::uint32_t ideal = map.projected[i];
    const std::uint8_t label = ideal < ideal_labels.size() ? ideal_labels[ideal] : kLabelNoDepth;
    const bool measured = metres_at(depth, static_cast<std::uint32_t>(i)) > 0.0F;
    labels[i] = !measured ? kLabelNoDepth : label == kLabelNoDepth ? kLabelNoPlane : label;
  }
  return {};
} catch (const std::exception& exception) {
  return caught(exception, "labels");
}

}  // namespace fransac
