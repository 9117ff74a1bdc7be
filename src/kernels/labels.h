// SPDX-License-Identifier: Apache-2.0
// Vector code over labels.
#pragma once

#include <cstddef>
#include <cstdint>

namespace fransac::kernels {

/// Replaces each label by table[label], for labels up to `largest` and 255; there are no others. `largest` is at most 254.
void relabel(std::uint8_t* labels, std::size_t n, const std::uint8_t* table, int largest);

namespace ref {
void relabel(std::uint8_t* labels, std::size_t n, const std::uint8_t* table, int largest);
}  // namespace ref

}  // namespace fransac::kernels
