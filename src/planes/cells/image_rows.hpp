// SPDX-License-Identifier: Apache-2.0
/// All pixel rows of a depth image at once, in whole rows of cells.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "filter/depth_rows.hpp"
#include "fransac/core/aligned.hpp"
#include "fransac/core/parallel.hpp"
#include "kernels/cells.h"

namespace fransac::cells {

/// Memory of ImageRows.
struct ImageRowsBuffers {
  AlignedVector<std::uint16_t> units;
  AlignedVector<float> metres;
  std::vector<const void*> rows;
  std::vector<DepthRowBuffer> work;  ///< One per task.

  template <class Raw>
  AlignedVector<Raw>& values() {
    if constexpr (std::is_same_v<Raw, float>) {
      return metres;
    } else {
      return units;
    }
  }
};

/// Where each row of pixels is: in the image itself where it can stay there, else in a copy. Below the image are rows of zeros.
template <class Raw>
class ImageRows {
 public:
  /// Rows of cells are `side` rows of pixels; there are whole multiples of `multiple` of them.
  ImageRows(const DepthRows<Raw>& rows, int side, int multiple, int threads, ImageRowsBuffers& buffers)
      : rows_(buffers.rows), side_(static_cast<std::size_t>(side)) {
    const auto height = static_cast<std::size_t>(rows.height());
    const std::size_t together = static_cast<std::size_t>(multiple) * side_;
    const std::size_t padded_height = (height + together - 1) / together * together;
    const std::size_t block = std::max(together, kernels::kBlock);
    const std::size_t width = (rows.width() + block - 1) / block * block;
    const std::size_t copied = rows.stays_in_place() && width == rows.width() ? 0 : height;
    AlignedVector<Raw>& copy = buffers.values<Raw>();
    copy.resize((copied + 1) * width);  // and a row of zeros
    std::fill(copy.end() - static_cast<std::ptrdiff_t>(width), copy.end(), Raw{0});
    rows_.assign(padded_height, copy.data() + copied * width);
    constexpr std::size_t kRowsOfTask = kernels::kCell;
    const std::size_t tasks = (height + kRowsOfTask - 1) / kRowsOfTask;
    buffers.work.resize(std::max(buffers.work.size(), tasks));
    if (copied == 0) {
      for (std::size_t v = 0; v < height; ++v) rows_[v] = rows.row(static_cast<int>(v), buffers.work.front()).kept;
      return;
    }
    parallel_for(threads, tasks, [&](std::size_t task) {
      for (std::size_t v = task * kRowsOfTask; v < std::min((task + 1) * kRowsOfTask, height); ++v) {
        Raw* const out = copy.data() + v * width;
        std::copy_n(rows.row(static_cast<int>(v), buffers.work[task]).kept, rows.width(), out);
        std::fill(out + rows.width(), out + width, Raw{0});
        rows_[v] = out;
      }
    });
  }

  /// The pixel rows of a row of cells.
  [[nodiscard]] kernels::CellRows<Raw> cells(int row) const {
    kernels::CellRows<Raw> out{};
    for (std::size_t k = 0; k < side_; ++k)
      out.rows[k] = static_cast<const Raw*>(rows_[static_cast<std::size_t>(row) * side_ + k]);
    return out;
  }

 private:
  std::vector<const void*>& rows_;
  std::size_t side_;
};

/// Rows of cells of one task; fixed, so that sums over tasks do not depend on the number of threads.
inline constexpr int kCellRowsOfTask = 4;

inline std::size_t cell_row_tasks(int rows) { return static_cast<std::size_t>((rows + kCellRowsOfTask - 1) / kCellRowsOfTask); }

template <class Visitor>
void for_each_cell_row(std::size_t task, int rows, Visitor visit) {
  const int first = static_cast<int>(task) * kCellRowsOfTask;
  for (int row = first; row < std::min(first + kCellRowsOfTask, rows); ++row) visit(row);
}

}  // namespace fransac::cells
