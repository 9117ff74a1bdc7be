// SPDX-License-Identifier: Apache-2.0
#include "fransac/core/distortion.hpp"

#include <cmath>
#include <cstddef>
#include <string>
#include <string_view>

#include "core/caught.hpp"
#include "core/number_text.hpp"
#include "fransac/core/camera.hpp"

namespace fransac {
namespace {

constexpr std::size_t kPowers = kDistortionDegree + 1;
using Polynomial = std::array<double, kPowers>;

/// Calls visit(term, i, j) for every term in order.
template <class Visitor>
constexpr void for_each_term(Visitor&& visit) {
  std::size_t term = 0;
  for (std::size_t degree = 2; degree < kPowers; ++degree) {
    for (std::size_t i = 0; i <= degree; ++i) visit(term++, i, degree - i);
  }
}

/// Bonnet's recursion: (n + 1) P_{n+1} = (2n + 1) x P_n - n P_{n-1}.
constexpr Polynomial legendre(double x) {
  Polynomial p{1.0, x};
  for (std::size_t n = 1; n + 1 < kPowers; ++n) {
    const auto m = static_cast<double>(n);
    p[n + 1] = ((2.0 * m + 1.0) * x * p[n] - m * p[n - 1]) / (m + 1.0);
  }
  return p;
}

/// The coefficients of x^k in P_n at [n][k].
constexpr std::array<Polynomial, kPowers> legendre_coefficients() {
  std::array<Polynomial, kPowers> c{};
  c[0][0] = 1.0;
  c[1][1] = 1.0;
  for (std::size_t n = 1; n + 1 < kPowers; ++n) {
    const auto m = static_cast<double>(n);
    for (std::size_t k = 0; k < kPowers; ++k) {
      const double shifted = k > 0 ? c[n][k - 1] : 0.0;
      c[n + 1][k] = ((2.0 * m + 1.0) * shifted - m * c[n - 1][k]) / (m + 1.0);
    }
  }
  return c;
}

std::array<float, kPowers> row_of(const std::array<double, kDistortionTerms>& terms, const Polynomial& at_y) {
  static constexpr std::array<Polynomial, kPowers> kCoefficients = legendre_coefficients();
  Polynomial sum{};
  for_each_term([&](std::size_t term, std::size_t i, std::size_t j) {
    const double factor = terms[term] * at_y[j];
    for (std::size_t k = 0; k <= i; ++k) sum[k] += factor * kCoefficients[i][k];
  });
  std::array<float, kPowers> row{};
  for (std::size_t k = 0; k < kPowers; ++k) row[k] = static_cast<float>(sum[k]);
  return row;
}

Error bad(std::string_view field, const std::string& what) {
  return {ErrorCode::invalid_argument, "distortion " + std::string(field) + ": " + what};
}

Status check(std::string_view field, const std::array<double, kDistortionTerms>& terms) {
  for (std::size_t i = 0; i < terms.size(); ++i) {
    if (std::abs(terms[i]) <= kMaxDistortion) continue;  // false for NaN
    return bad(field, "number " + std::to_string(i) + " must be between " + number_text(-kMaxDistortion) + " and " +
                          number_text(kMaxDistortion) + ", is " + number_text(terms[i]));
  }
  return {};
}

Status check(std::string_view field, int pixels) {
  if (pixels >= 1 && pixels <= kMaxImageSide) return {};
  return bad(field, "must be between 1 and " + std::to_string(kMaxImageSide) + " pixels, is " + std::to_string(pixels));
}

}  // namespace

Status validate(const Distortion& distortion) try {
  if (distortion == Distortion{}) return {};
  if (Status status = check("width", distortion.width); !status) return status;
  if (Status status = check("height", distortion.height); !status) return status;
  if (Status status = check("offset_per_m", distortion.offset_per_m); !status) return status;
  return check("gain", distortion.gain);
} catch (const std::exception& exception) {
  return caught(exception, "distortion");
}

Status check_shape(const Distortion& distortion, int width, int height) try {
  constexpr double kTolerance = 0.05;  // copies with fewer pixels are cut at a border
  const double own = static_cast<double>(distortion.width) * height;
  if (distortion.empty() || std::abs(static_cast<double>(width) * distortion.height - own) <= kTolerance * own) return {};
  const auto size = [](int w, int h) { return std::to_string(w) + " x " + std::to_string(h); };
  return Error{ErrorCode::invalid_argument, "distortion: is that of images of " + size(distortion.width, distortion.height) +
                                                " pixels; " + size(width, height) + " have another shape"};
} catch (const std::exception& exception) {
  return caught(exception, "distortion");
}

std::array<double, kDistortionTerms> distortion_terms(double x, double y) {
  const Polynomial of_x = legendre(x);
  const Polynomial of_y = legendre(y);
  std::array<double, kDistortionTerms> terms{};
  for_each_term([&](std::size_t term, std::size_t i, std::size_t j) { terms[term] = of_x[i] * of_y[j]; });
  return terms;
}

double correction_at(const Distortion& distortion, double x, double y, double q_per_m) {
  const std::array<double, kDistortionTerms> terms = distortion_terms(x, y);
  double sum = 0.0;
  for (std::size_t i = 0; i < terms.size(); ++i) {
    sum += terms[i] * (distortion.offset_per_m[i] + distortion.gain[i] * q_per_m);
  }
  return sum;
}

DistortionRow distortion_row(const Distortion& distortion, double y) {
  const Polynomial at_y = legendre(y);
  return {row_of(distortion.offset_per_m, at_y), row_of(distortion.gain, at_y)};
}

}  // namespace fransac
