// SPDX-License-Identifier: Apache-2.0
// The choice of an instruction set.
#pragma once

namespace fransac::kernels {

/// The name of the instruction set in use, as Highway writes it: "AVX2", "SSE4", "NEON", "SCALAR" …
const char* target_name();

}  // namespace fransac::kernels
