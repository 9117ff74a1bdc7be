// SPDX-License-Identifier: Apache-2.0
// Vector code over one row of a depth image. Raw pointers only. `n` counts whole blocks (a multiple of kBlock values); arrays
// are aligned to 64 bytes. Labels are whole numbers kept as floats, so that all arrays of a row have one width.
// The scalar twin in namespace `ref` says what is computed; the two agree to rounding.
#pragma once

#include <cstddef>

#include "kernels/points.h"

namespace fransac::kernels {

/// n . r along the row is base + step * u, with u counted from the start of the arrays.
struct RowPlane {
  float base;
  float step;
  float d;
  float label;
};

/// Pixels that are nearer to the plane, |z (n . r) + d|, than to all before it (`nearest`, metres) get its label and distance.
void offer_plane(const float* z, std::size_t n, const RowPlane& plane, float* nearest, float* label);

namespace ref {
void offer_plane(const float* z, std::size_t n, const RowPlane& plane, float* nearest, float* label);
}  // namespace ref

}  // namespace fransac::kernels
