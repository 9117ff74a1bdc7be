// SPDX-License-Identifier: Apache-2.0
/// The smooth error of inverse depth by which a camera bends planes, the same in every frame.
#pragma once

#include <array>

#include "fransac/core/result.hpp"

namespace fransac {

/// Highest degree of the polynomials that a Distortion consists of.
inline constexpr int kDistortionDegree = 6;
/// How many products P_i(x) P_j(y) of Legendre polynomials have 2 <= i + j <= kDistortionDegree.
inline constexpr int kDistortionTerms = (kDistortionDegree + 1) * (kDistortionDegree + 2) / 2 - 3;
/// Largest magnitude of a coefficient that is believed.
inline constexpr double kMaxDistortion = 1.0;

/// What is added to a pixel's inverse depth q to correct it: a(x, y) + b(x, y) q, per metre, both sums of products P_i(x) P_j(y)
/// of Legendre polynomials, with x and y from -1 to 1 from one border of the image to the other. An affine part, i + j < 2, is
/// left out: it turns every plane into another plane, so no plane can show it. docs/calibration.md has the reasons. Order of the
/// terms: by i + j, then by i.
struct Distortion {
  int width = 0;   ///< Of the images that it was found in, pixels; 0: there is none. Images of another size show the same field
                   ///< of view, and must have the same shape.
  int height = 0;  ///< Likewise.
  std::array<double, kDistortionTerms> offset_per_m{};  ///< Of a, per metre.
  std::array<double, kDistortionTerms> gain{};          ///< Of b, dimensionless.

  [[nodiscard]] bool empty() const { return width == 0; }  ///< Whether there is nothing to correct.
  bool operator==(const Distortion&) const = default;
};

/// Checks sizes and coefficients: finite, at most kMaxDistortion. The message names the field.
Status validate(const Distortion& distortion);

/// Whether images of this size can be corrected: their shape is that of the distortion's own to 5 %. invalid_argument else.
Status check_shape(const Distortion& distortion, int width, int height);

/// P_i(x) P_j(y) of all terms, in their order, at a place of the image.
std::array<double, kDistortionTerms> distortion_terms(double x, double y);

/// The correction of an inverse depth q, per metre, at a place of the image (x and y from -1 to 1), per metre.
double correction_at(const Distortion& distortion, double x, double y, double q_per_m);

/// A row of the image: a and b as polynomials of x, the coefficient of x^k at [k].
struct DistortionRow {
  std::array<float, kDistortionDegree + 1> offset_per_m{};  ///< Of a, per metre.
  std::array<float, kDistortionDegree + 1> gain{};          ///< Of b.
};
/// At y from -1 to 1.
DistortionRow distortion_row(const Distortion& distortion, double y);

}  // namespace fransac
