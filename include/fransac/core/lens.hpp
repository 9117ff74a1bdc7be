// SPDX-License-Identifier: Apache-2.0
/// The distortion of a camera's lens.
#pragma once

#include <array>
#include <string_view>

namespace fransac {

/// How a lens moves the image of a point away from where a pinhole has it.
enum class LensModel {
  plumb_bob,            ///< k1, k2, p1, p2, k3: radial and tangential (Brown 1966, Conrady 1919).
  rational_polynomial,  ///< k1, k2, p1, p2, k3, k4, k5, k6: the radial factor is a quotient of two polynomials.
  equidistant,          ///< k1 to k4 of a polynomial in the angle to the optical axis: fisheyes (Kannala and Brandt 2006).
};
/// The model's name in ROS, for example "plumb_bob".
std::string_view to_string(LensModel model);

/// Coefficients in the order and with the meaning that OpenCV and ROS give them.
struct Lens {
  LensModel model = LensModel::plumb_bob;  ///< What the coefficients are of.
  std::array<double, 8> coefficients{};    ///< Those that the model does not have are 0.

  bool operator==(const Lens&) const = default;
};

}  // namespace fransac
