// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <limits>
#include <string>
#include <vector>

#include "outlines.hpp"
#include "property.hpp"

namespace fransac {
namespace {

/// A random image of up to three labels, from specks to blotches.
Segmentation any_label_image() {
  const int width = *rc::gen::inRange(1, 40);
  const int height = *rc::gen::inRange(1, 30);
  const int copied = *rc::gen::inRange(0, 10);  // of ten pixels, how many repeat a neighbour
  RandomStream random = testing::any_stream();
  std::vector<std::string> rows(static_cast<std::size_t>(height), std::string(static_cast<std::size_t>(width), '.'));
  for (std::size_t v = 0; v < rows.size(); ++v) {
    for (std::size_t u = 0; u < rows[v].size(); ++u) {
      if (static_cast<int>(random.below(10)) >= copied) {
        rows[v][u] = ".123"[random.below(4)];
      } else if (random.below(2) == 0) {
        rows[v][u] = u > 0 ? rows[v][u - 1] : '1';
      } else {
        rows[v][u] = v > 0 ? rows[v - 1][u] : '1';
      }
    }
  }
  rows[0][0] = '3';  // all three planes exist
  return testing::label_image(rows);
}

double distance_to(const Ring& ring, const Eigen::Vector2d& p) {
  double nearest = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < ring.pixels.size(); ++i) {
    const Eigen::Vector2d& a = ring.pixels[i];
    const Eigen::Vector2d ab = ring.pixels[(i + 1) % ring.pixels.size()] - a;
    const double along = std::clamp((p - a).dot(ab) / ab.squaredNorm(), 0.0, 1.0);
    nearest = std::min(nearest, (p - a - along * ab).norm());
  }
  return nearest;
}

void check_ring(const Ring& ring, double sign) {
  RC_ASSERT(ring.pixels.size() >= 3U);
  RC_ASSERT(ring.points.size() == ring.pixels.size());
  RC_ASSERT(sign * testing::area_px(ring) > 0.0);
}

/// Both simplified and exact, and the former within the tolerance of the latter.
void check_simplified(const Ring& simple, const Ring& exact, double tolerance, double sign) {
  check_ring(simple, sign);
  for (const Eigen::Vector2d& corner : exact.pixels) RC_ASSERT(distance_to(simple, corner) <= tolerance + 1e-9);
  for (const Eigen::Vector2d& corner : simple.pixels) {
    RC_ASSERT(std::find(exact.pixels.begin(), exact.pixels.end(), corner) != exact.pixels.end());
  }
}

TEST(Outlines, EncloseTheLabelledPixels) {
  testing::check_property(300, [] {
    const Segmentation s = any_label_image();
    const auto all = outlines(s, testing::small_camera(s.width, s.height), testing::kExact);
    for (const PlaneSegment& segment : s.planes) {
      double pixels = 0.0;
      double last = std::numeric_limits<double>::infinity();
      for (const Outline& outline : all[static_cast<std::size_t>(segment.id - 1)]) {
        check_ring(outline.outer, -1.0);
        double part = -testing::area_px(outline.outer);
        for (const Ring& hole : outline.holes) {
          check_ring(hole, 1.0);
          part -= testing::area_px(hole);
        }
        RC_ASSERT(part <= last);
        last = part;
        pixels += part;
      }
      RC_ASSERT(pixels == static_cast<double>(std::count(s.labels.begin(), s.labels.end(), segment.id)));
    }
  });
}

TEST(Outlines, SimplifiedStayWithinTheTolerance) {
  testing::check_property(300, [] {
    const Segmentation s = any_label_image();
    const Camera camera = testing::small_camera(s.width, s.height);
    const double tolerance = testing::any_number(0.0, 5.0);
    const auto exact = outlines(s, camera, testing::kExact);
    const auto simple = outlines(s, camera, {tolerance, 1});
    for (std::size_t i = 0; i < exact.size(); ++i) {
      RC_ASSERT(simple[i].size() == exact[i].size());
      for (std::size_t part = 0; part < exact[i].size(); ++part) {
        check_simplified(simple[i][part].outer, exact[i][part].outer, tolerance, -1.0);
        RC_ASSERT(simple[i][part].holes.size() == exact[i][part].holes.size());
        for (std::size_t hole = 0; hole < exact[i][part].holes.size(); ++hole) {
          check_simplified(simple[i][part].holes[hole], exact[i][part].holes[hole], tolerance, 1.0);
        }
      }
    }
  });
}

}  // namespace
}  // namespace fransac
