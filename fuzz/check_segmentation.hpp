// SPDX-License-Identifier: Apache-2.0
/// What holds of every segmentation.
#pragma once

#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include "fransac/core/labels.hpp"
#include "fransac/planes/segment.hpp"
#include "require.hpp"

namespace fransac::fuzz {

/// Labels, planes and counts fit each other; `measured(i)` says of which pixels or points there is a measurement.
template <class Measured>
void check(const Segmentation& s, std::size_t size, const Measured& measured) {
  require(s.labels.size() == size && static_cast<std::size_t>(s.width) * static_cast<std::size_t>(s.height) == size);
  require(s.residuals_m.empty() || s.residuals_m.size() == size);
  std::array<std::uint64_t, 256> pixels{};
  for (std::size_t i = 0; i < size; ++i) {
    const std::uint8_t label = s.labels[i];
    ++pixels[label];
    require((label == kLabelNoDepth) != measured(i));
    require(label == kLabelNoPlane || label <= s.planes.size());
    if (!s.residuals_m.empty()) require(std::isnan(s.residuals_m[i]) == (label == kLabelNoDepth || label == kLabelNoPlane));
  }
  require(s.valid_points == size - pixels[kLabelNoDepth] && s.sampled_points <= s.valid_points);
  require(s.up.has_value() == (s.up_source != UpSource::none));
  require(!s.up || std::abs(s.up->norm() - 1.0) < 1e-6);
  for (std::size_t k = 0; k < s.planes.size(); ++k) {
    const PlaneSegment& p = s.planes[k];
    require(p.id == static_cast<int>(k) + kLabelFirst && p.inliers == pixels[k + kLabelFirst]);
    require(p.support <= s.sampled_points);
    require(std::abs(p.plane.normal.norm() - 1.0) < 1e-6 && std::isfinite(p.plane.d) && p.plane.d >= 0.0);
    require(std::isfinite(p.rms_m) && p.rms_m >= 0.0 && std::isfinite(p.area_m2) && p.area_m2 >= 0.0);
    require(p.confidence >= 0.0 && p.confidence <= 1.0 && p.centroid.allFinite() && p.covariance.allFinite());
    require((p.kind == PlaneKind::unknown) == !s.up);
  }
}

/// The same answer to the last bit, but for the times.
inline void check_same(const Segmentation& a, const Segmentation& b) {
  require(a.method == b.method && a.labels == b.labels && a.planes.size() == b.planes.size());
  require(a.up == b.up && a.valid_points == b.valid_points && a.sampled_points == b.sampled_points);
  require(a.iterations == b.iterations && a.rejected == b.rejected && a.degenerate == b.degenerate);
  require(a.residuals_m.size() == b.residuals_m.size());
  for (std::size_t i = 0; i < a.residuals_m.size(); ++i) {
    require(std::bit_cast<std::uint32_t>(a.residuals_m[i]) == std::bit_cast<std::uint32_t>(b.residuals_m[i]));
  }
  for (std::size_t k = 0; k < a.planes.size(); ++k) {
    const PlaneSegment& p = a.planes[k];
    const PlaneSegment& q = b.planes[k];
    require(p.plane.normal == q.plane.normal && p.plane.d == q.plane.d && p.support == q.support && p.kind == q.kind);
    require(p.rms_m == q.rms_m && p.area_m2 == q.area_m2 && p.centroid == q.centroid && p.confidence == q.confidence);
    require(p.iterations == q.iterations && p.stop_reason == q.stop_reason && p.covariance == q.covariance);
  }
}

}  // namespace fransac::fuzz
