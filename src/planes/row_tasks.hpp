// SPDX-License-Identifier: Apache-2.0
/// How the rows of an image are dealt out to threads.
#pragma once

#include <cstddef>

namespace fransac {

/// Rows of one task; fixed, so that sums over tasks do not depend on the number of threads.
inline constexpr int kRowsOfTask = 32;

inline std::size_t row_tasks(int height) { return (static_cast<std::size_t>(height) + kRowsOfTask - 1) / kRowsOfTask; }

/// Smaller images are not worth a second thread for a look at all pixels, which takes some 0.05 ms.
inline int threads_for_rows(int threads, std::size_t pixels) { return pixels < (std::size_t{1} << 19) ? 1 : threads; }

}  // namespace fransac
