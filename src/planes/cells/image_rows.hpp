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

/// Where each row of samples is: in the image itself where it can stay there, else in a copy with every pixel `copies` times side
/// by side; rows of one pixel row are one. Below the image are rows of zeros.
template <class Raw>
class ImageRows {
 public:
  /// `multiple` rows of cells belong together; there are whole ones of those.
  ImageRows(const DepthRows<Raw>& rows, int copies, int multiple, int threads, ImageRowsBuffers& buffers) : rows_(buffers.rows) {
    const auto repeat = static_cast<std::size_t>(copies);
    const auto height = static_cast<std::size_t>(rows.height());
    const std::size_t together = static_cast<std::size_t>(multiple) * kernels::kCell;
    const std::size_t cell_rows = (height * repeat + together - 1) / together * static_cast<std::size_t>(multiple);
    const std::size_t block = std::max(together, kernels::kBlock);
    const std::size_t width = (rows.width() * repeat + block - 1) / block * block;
    const std::size_t copied = rows.stays_in_place() && repeat == 1 && width == rows.width() ? 0 : height;
    AlignedVector<Raw>& copy = buffers.values<Raw>();
    copy.resize((copied + 1) * width);  // and a row of zeros
    std::fill(copy.end() - static_cast<std::ptrdiff_t>(width), copy.end(), Raw{0});
    rows_.assign(cell_rows * kernels::kCell, copy.data() + copied * width);
    buffers.work.resize(std::max(buffers.work.size(), cell_rows));
    if (copied == 0) {
      for (std::size_t v = 0; v < height; ++v) rows_[v] = rows.row(static_cast<int>(v), buffers.work.front()).kept;
      return;
    }
    const std::size_t rows_of_task = std::max<std::size_t>(1, kernels::kCell / repeat);
    parallel_for(threads, (height + rows_of_task - 1) / rows_of_task, [&](std::size_t task) {
      for (std::size_t v = task * rows_of_task; v < std::min((task + 1) * rows_of_task, height); ++v) {
        const Raw* const kept = rows.row(static_cast<int>(v), buffers.work[task]).kept;
        Raw* const out = copy.data() + v * width;
        repeat_pixels(kept, rows.width(), repeat, out);
        std::fill(out + rows.width() * repeat, out + width, Raw{0});
        std::fill_n(rows_.begin() + static_cast<std::ptrdiff_t>(v * repeat), repeat, out);
      }
    });
  }

  /// The pixel rows of a row of cells.
  [[nodiscard]] kernels::CellRows<Raw> cells(int row) const {
    kernels::CellRows<Raw> out{};
    for (std::size_t k = 0; k < kernels::kCell; ++k) {
      out.rows[k] = static_cast<const Raw*>(rows_[static_cast<std::size_t>(row) * kernels::kCell + k]);
    }
    return out;
  }

 private:
  /// Compilers make vector code of the usual ones.
  static void repeat_pixels(const Raw* pixels, std::size_t width, std::size_t repeat, Raw* out) {
    if (repeat == 1) {
      std::copy_n(pixels, width, out);
    } else if (repeat == 2) {
      for (std::size_t u = 0; u < width; ++u) out[2 * u] = out[2 * u + 1] = pixels[u];
    } else {
      for (std::size_t u = 0; u < width; ++u) std::fill_n(out + u * repeat, repeat, pixels[u]);
    }
  }

  std::vector<const void*>& rows_;
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
