// SPDX-License-Identifier: Apache-2.0
/// Numbers with a bound of what floats may be off them: the rounding of every operation, carried along (running error analysis,
/// Higham, "Accuracy and Stability of Numerical Algorithms", section 3.3). Fused operations round less often and stay within.
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <ostream>
#include <vector>

namespace fransac::testing {

struct Rounded {
  static constexpr double kUnit = 0x1p-24;  ///< Of one operation on floats, relative.

  double value = 0.0;
  double error = 0.0;

  Rounded() = default;
  Rounded(float exact) : value(static_cast<double>(exact)) {}  // NOLINT(google-explicit-constructor)
  /// A number that was rounded so many times before.
  Rounded(float stored, double roundings) : Rounded(stored) { error = roundings * kUnit * std::abs(value); }
  /// After one rounding of what is known to `error`.
  static Rounded after(double value, double error) {
    Rounded result;
    result.value = value;
    result.error = error + kUnit * (std::abs(value) + error);
    return result;
  }

  /// Whether floats, or the truth stored as one, may be that.
  [[nodiscard]] bool may_be(float other) const {
    return std::abs(static_cast<double>(other) - value) <= error + kUnit * std::abs(value);
  }
};

inline Rounded operator+(const Rounded& a, const Rounded& b) { return Rounded::after(a.value + b.value, a.error + b.error); }
inline Rounded operator-(const Rounded& a, const Rounded& b) { return Rounded::after(a.value - b.value, a.error + b.error); }
inline Rounded operator*(const Rounded& a, const Rounded& b) {
  return Rounded::after(a.value * b.value, std::abs(a.value) * b.error + std::abs(b.value) * a.error + a.error * b.error);
}
inline Rounded operator/(const Rounded& a, const Rounded& b) {
  const double quotient = a.value / b.value;
  const double least = std::abs(b.value) - b.error;
  return Rounded::after(quotient,
                        least > 0.0 ? (a.error + std::abs(quotient) * b.error) / least : std::numeric_limits<double>::infinity());
}
inline std::ostream& operator<<(std::ostream& out, const Rounded& r) { return out << r.value << " +- " << r.error; }

/// The sum in whatever order: a rounding for each term, of no more than the sum of all sizes.
inline Rounded sum(const std::vector<Rounded>& terms) {
  Rounded total;
  double size = 0.0;
  for (const Rounded& term : terms) {
    total.value += term.value;
    total.error += term.error;
    size += std::abs(term.value) + term.error;
  }
  total.error += static_cast<double>(terms.size()) * Rounded::kUnit * size;
  return total;
}

inline Rounded larger(const Rounded& a, const Rounded& b) {
  Rounded result = a.value >= b.value ? a : b;
  result.error = std::max(a.error, b.error);
  return result;
}

/// Whether a <= b; nothing where rounding may decide.
inline std::optional<bool> at_most(const Rounded& a, const Rounded& b) {
  const double error = a.error + b.error;
  if (error > 0.0 && std::abs(a.value - b.value) <= error) return std::nullopt;
  return a.value <= b.value;
}
inline std::optional<bool> both(std::optional<bool> a, std::optional<bool> b) {
  if (a == false || b == false) return false;
  return a && b ? std::optional(true) : std::nullopt;
}

}  // namespace fransac::testing
