// SPDX-License-Identifier: Apache-2.0
#include "fransac/planes/outline.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numeric>
#include <utility>

#include "core/union_find.hpp"

namespace fransac {
namespace {

using Corners = std::vector<Eigen::Vector2d>;

/// Which plane a label belongs to.
class PlaneOfLabel {
 public:
  static constexpr int kNone = -1;
  PlaneOfLabel() { planes_.fill(kNone); }
  void set(int label, int plane) {
    if (label >= kLabelFirst && label <= kMaxPlanes) planes_[static_cast<std::size_t>(label)] = plane;
  }
  int operator[](std::uint8_t label) const { return planes_[label]; }

 private:
  std::array<int, 256> planes_{};
};

/// Sets of numbers that are merged; a set goes by the smallest of its numbers.
class DisjointSets {
 public:
  std::uint32_t add() {
    parents_.push_back(static_cast<std::uint32_t>(parents_.size()));
    return parents_.back();
  }
  std::uint32_t find(std::uint32_t i) { return root_of(parents_.data(), i); }
  void merge(std::uint32_t a, std::uint32_t b) { join_roots(parents_.data(), find(a), find(b)); }
  [[nodiscard]] std::size_t size() const { return parents_.size(); }

 private:
  std::vector<std::uint32_t> parents_;
};

struct Part {
  int plane = 0;
  std::uint32_t pixels = 0;
  Outline outline;
};

/// The parts of all planes as an image of numbers.
class PartImage {
 public:
  static constexpr std::uint32_t kNone = 0;

  PartImage(const Segmentation& segmentation, const PlaneOfLabel& plane_of, std::uint32_t min_pixels)
      : width_(segmentation.width), height_(segmentation.height), part_of_(segmentation.labels.size(), kNone) {
    const std::vector<std::uint8_t>& labels = segmentation.labels;
    DisjointSets sets;
    sets.add();  // kNone
    std::vector<Found> found(1);
    const auto width = static_cast<std::size_t>(width_);
    for (std::size_t p = 0, u = 0; p < labels.size(); ++p, u = u + 1 == width ? 0 : u + 1) {
      const int plane = plane_of[labels[p]];
      if (plane == PlaneOfLabel::kNone) continue;
      const std::uint32_t left = u > 0 && labels[p - 1] == labels[p] ? part_of_[p - 1] : kNone;
      const std::uint32_t above = p >= width && labels[p - width] == labels[p] ? part_of_[p - width] : kNone;
      if (left != kNone && above != kNone && left != above) sets.merge(left, above);
      part_of_[p] = left != kNone ? left : above;
      if (part_of_[p] == kNone) {
        part_of_[p] = sets.add();
        found.push_back({plane, 0});
      }
      ++found[part_of_[p]].pixels;
    }
    renumber(sets, found, min_pixels);
  }

  [[nodiscard]] int width() const { return width_; }
  [[nodiscard]] int height() const { return height_; }
  /// The number of the part that a pixel belongs to, from 1; kNone outside the image, on no plane and on small parts.
  [[nodiscard]] std::uint32_t at(int u, int v) const {
    const bool inside = u >= 0 && u < width_ && v >= 0 && v < height_;
    return inside ? part_of_[index(u, v)] : kNone;
  }
  [[nodiscard]] std::size_t index(int u, int v) const {
    return static_cast<std::size_t>(v) * static_cast<std::size_t>(width_) + static_cast<std::size_t>(u);
  }
  Part& part(std::uint32_t number) { return parts_[number - 1]; }
  std::vector<Part>& parts() { return parts_; }

 private:
  /// A piece of a part as the scan meets it.
  struct Found {
    int plane;
    std::uint32_t pixels;
  };

  void renumber(DisjointSets& sets, std::vector<Found>& found, std::uint32_t min_pixels) {
    for (std::uint32_t i = 1; i < sets.size(); ++i) {
      if (const std::uint32_t root = sets.find(i); root != i) found[root].pixels += found[i].pixels;
    }
    std::vector<std::uint32_t> numbers(sets.size(), kNone);
    for (std::uint32_t i = 1; i < sets.size(); ++i) {
      const std::uint32_t root = sets.find(i);
      if (root == i && found[i].pixels >= min_pixels) {
        parts_.push_back({found[i].plane, found[i].pixels, {}});
        numbers[i] = static_cast<std::uint32_t>(parts_.size());
      }
      numbers[i] = numbers[root];
    }
    for (std::uint32_t& part : part_of_) part = numbers[part];
  }

  int width_;
  int height_;
  std::vector<std::uint32_t> part_of_;
  std::vector<Part> parts_;
};

/// Follows the sides of a part's pixels with the part on the left. Sides are walked westwards along the top of a pixel,
/// southwards along its left, eastwards along its bottom, northwards along its right.
class BorderFollower {
 public:
  explicit BorderFollower(PartImage& image)
      : image_(image), top_seen_(static_cast<std::size_t>(image.width()) * static_cast<std::size_t>(image.height())) {}

  /// Finds all rings, each by the first of its pixels, in reading order, with a side at the top: every closed ring has one.
  void follow_all(std::int64_t min_hole_pixels) {
    for (int v = 0; v < image_.height(); ++v) {
      for (int u = 0; u < image_.width(); ++u) {
        const std::uint32_t part = image_.at(u, v);
        if (part == PartImage::kNone || image_.at(u, v - 1) == part || top_seen_[image_.index(u, v)]) continue;
        Corners corners;
        const std::int64_t pixels = follow(u, v, part, corners);
        Outline& outline = image_.part(part).outline;
        if (pixels > 0) {
          outline.outer.pixels = std::move(corners);
        } else if (-pixels >= min_hole_pixels) {
          outline.holes.push_back({std::move(corners), {}});
        }
      }
    }
  }

 private:
  enum Direction { west, south, east, north };  // each to the left of the one before, as displayed

  /// Walks around once from the top of a pixel and collects the corners. Returns how many pixels the ring encloses; negative
  /// when the part is outside.
  std::int64_t follow(int first_u, int first_v, std::uint32_t part, Corners& corners) {
    static constexpr std::array<int, 4> kStepU{-1, 0, 1, 0};
    static constexpr std::array<int, 4> kStepV{0, 1, 0, -1};
    // The pixel ahead on the left of a corner between pixels: (u, v) is the corner at the top left of pixel (u, v).
    static constexpr std::array<int, 4> kLeftU{-1, 0, 0, -1};
    static constexpr std::array<int, 4> kLeftV{0, 0, -1, -1};
    int u = first_u + 1;
    int v = first_v;
    int direction = west;
    std::int64_t pixels = 0;
    do {
      if (direction == west) top_seen_[image_.index(u - 1, v)] = true;
      const auto ahead = static_cast<std::size_t>(direction);
      u += kStepU[ahead];
      v += kStepV[ahead];
      pixels += kStepU[ahead] * static_cast<std::int64_t>(v);
      const auto right = static_cast<std::size_t>((direction + 3) % 4);  // what is right of here is left of who faces right
      int turn = 0;
      if (image_.at(u + kLeftU[ahead], v + kLeftV[ahead]) != part) {
        turn = 1;  // also where two pixels meet at this corner only: they do not hang together
      } else if (image_.at(u + kLeftU[right], v + kLeftV[right]) == part) {
        turn = 3;
      }
      if (turn == 0) continue;
      corners.emplace_back(u - 0.5, v - 0.5);
      direction = (direction + turn) % 4;
    } while (u != first_u + 1 || v != first_v || direction != west);
    return pixels;
  }

  PartImage& image_;
  std::vector<bool> top_seen_;
};

double squared_distance_to_segment(const Eigen::Vector2d& p, const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
  const Eigen::Vector2d ab = b - a;
  const double along = std::clamp((p - a).dot(ab) / std::max(ab.squaredNorm(), std::numeric_limits<double>::min()), 0.0, 1.0);
  return (p - a - along * ab).squaredNorm();
}

/// Douglas and Peucker's choice of corners between two that are kept, until all others are within the tolerance. As many
/// `levels` split at the farthest corner, later ones halve: any choice keeps the tolerance, and none costs more than
/// O(n log n).
void keep_between(const Corners& corners, std::size_t first, std::size_t last, int levels, double squared_tolerance,
                  std::vector<bool>& keep) {
  double farthest = 0.0;
  std::size_t split = first;
  for (std::size_t i = first + 1; i < last; ++i) {
    const double distance = squared_distance_to_segment(corners[i], corners[first], corners[last]);
    if (distance > farthest) {
      farthest = distance;
      split = i;
    }
  }
  if (split == first || farthest <= squared_tolerance) return;
  if (levels <= 0) split = std::midpoint(first, last);
  keep[split] = true;
  keep_between(corners, first, split, levels - 1, squared_tolerance, keep);
  keep_between(corners, split, last, levels - 1, squared_tolerance, keep);
}

Corners::iterator farthest_from(const Eigen::Vector2d& from, Corners& corners) {
  return std::max_element(corners.begin(), corners.end(), [&](const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
    return (a - from).squaredNorm() < (b - from).squaredNorm();
  });
}

/// Twice the area, positive when clockwise as displayed.
double doubled_area(const Corners& corners) {
  double sum = 0.0;
  for (std::size_t i = 0, last = corners.size() - 1; i < corners.size(); last = i++) {
    sum += corners[last].x() * corners[i].y() - corners[i].x() * corners[last].y();
  }
  return sum;
}

/// Leaves out corners within the tolerance; all stay where too few would, or the ring would turn the other way round.
void simplify(Corners& corners, double tolerance_px) {
  if (!(tolerance_px > 0.0)) return;
  std::rotate(corners.begin(), farthest_from(corners.front(), corners), corners.end());
  const auto opposite = static_cast<std::size_t>(farthest_from(corners.front(), corners) - corners.begin());
  const std::size_t size = corners.size();
  const int levels = 2 * static_cast<int>(std::bit_width(size));
  corners.push_back(corners.front());
  std::vector<bool> keep(size);
  keep[0] = keep[opposite] = true;
  keep_between(corners, 0, opposite, levels, tolerance_px * tolerance_px, keep);
  keep_between(corners, opposite, size, levels, tolerance_px * tolerance_px, keep);
  corners.pop_back();
  Corners kept;
  for (std::size_t i = 0; i < size; ++i) {
    if (keep[i]) kept.push_back(corners[i]);
  }
  if (kept.size() >= 3 && doubled_area(kept) * doubled_area(corners) > 0.0) corners = std::move(kept);
}

/// The corners' rays cut with a plane; see Ring::points.
class RingOnPlane {
 public:
  RingOnPlane(const Plane& plane, const Camera& camera)
      : plane_(plane),
        camera_(camera),
        pixel_step_(std::max(std::hypot(plane.normal.x() / camera.fx, plane.normal.y() / camera.fy),
                             std::numeric_limits<double>::min())) {}

  void complete(Ring& ring) const {
    ring.points.reserve(ring.pixels.size());
    for (const Eigen::Vector2d& p : ring.pixels) {
      const Eigen::Vector3d ray((p.x() - camera_.cx) / camera_.fx, (p.y() - camera_.cy) / camera_.fy, 1.0);
      // -n . r is 0 at the horizon and changes by pixel_step_ from pixel to pixel across it.
      const double z = plane_.d / std::max(-plane_.normal.dot(ray), pixel_step_);
      ring.points.push_back(std::min(z, static_cast<double>(kMaxDepth_m)) * ray);
    }
  }

 private:
  const Plane& plane_;
  const Camera& camera_;
  double pixel_step_;
};

bool is_image_of(const Segmentation& segmentation, const Camera& camera) {
  return validate(camera).ok() && camera.width == segmentation.width && camera.height == segmentation.height &&
         segmentation.labels.size() == static_cast<std::size_t>(camera.width) * static_cast<std::size_t>(camera.height);
}

std::vector<std::vector<Outline>> outlines_of(const Segmentation& segmentation, const Camera& camera,
                                              const PlaneOfLabel& plane_of, const OutlineOptions& options) {
  std::vector<std::vector<Outline>> result(segmentation.planes.size());
  if (!is_image_of(segmentation, camera)) return result;
  const int min_pixels = std::max(options.min_pixels, 1);
  PartImage image(segmentation, plane_of, static_cast<std::uint32_t>(min_pixels));
  BorderFollower(image).follow_all(min_pixels);
  std::stable_sort(image.parts().begin(), image.parts().end(), [](const Part& a, const Part& b) { return a.pixels > b.pixels; });
  for (Part& part : image.parts()) {
    const auto plane = static_cast<std::size_t>(part.plane);
    const RingOnPlane on_plane(segmentation.planes[plane].plane, camera);
    const auto finish = [&](Ring& ring) {
      simplify(ring.pixels, options.tolerance_px);
      on_plane.complete(ring);
    };
    finish(part.outline.outer);
    for (Ring& hole : part.outline.holes) finish(hole);
    result[plane].push_back(std::move(part.outline));
  }
  return result;
}

}  // namespace

std::vector<std::vector<Outline>> outlines(const Segmentation& segmentation, const Camera& camera,
                                           const OutlineOptions& options) {
  PlaneOfLabel plane_of;
  for (std::size_t i = 0; i < segmentation.planes.size(); ++i) plane_of.set(segmentation.planes[i].id, static_cast<int>(i));
  return outlines_of(segmentation, camera, plane_of, options);
}

std::vector<Outline> outlines(const Segmentation& segmentation, const Camera& camera, int id, const OutlineOptions& options) {
  const auto plane = std::find_if(segmentation.planes.begin(), segmentation.planes.end(),
                                  [id](const PlaneSegment& segment) { return segment.id == id; });
  if (plane == segmentation.planes.end()) return {};
  const auto index = plane - segmentation.planes.begin();
  PlaneOfLabel plane_of;
  plane_of.set(id, static_cast<int>(index));
  return std::move(outlines_of(segmentation, camera, plane_of, options)[static_cast<std::size_t>(index)]);
}

}  // namespace fransac
