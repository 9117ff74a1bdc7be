// SPDX-License-Identifier: Apache-2.0
#include "planes/depth_data.hpp"

#include <algorithm>

#include "core/parallel_sum.hpp"
#include "planes/image_plane.hpp"
#include "planes/row_tasks.hpp"

namespace fransac {

template <class Raw>
DepthData<Raw>::DepthData(const DepthRows<Raw>& rows, int threads, DepthDataBuffers& buffers)
    : rows_(&rows), threads_(threads_for_rows(threads, rows.view().size())), buffers_(&buffers) {
  buffers.rows.resize(row_tasks(rows.height()));
  for (int v = 0; v < rows.height(); ++v) {
    const auto row = rows.row(v, buffers.rows.front());
    size_ += rows.count(row.kept);
    if (row.kept != row.measured) measured_ += rows.count(row.measured);
  }
  measured_ = std::max(measured_, size_);
}

template <class Raw>
void DepthData<Raw>::draw(RandomStream& random, std::uint32_t n, PointCloud& sample) const {
  // Where fewer pixels than one in so many are there, trying random ones would take longer than listing all.
  constexpr std::uint64_t kSparse = 8;
  const auto width = static_cast<std::uint32_t>(rows_->width());
  const auto pixels = static_cast<std::uint32_t>(rows_->view().size());
  const auto kept_at = [&](std::uint32_t pixel) { return rows_->kept_at(pixel % width, static_cast<int>(pixel / width)); };
  const bool all = n >= size_;
  sample.origin.setZero();
  sample.source.clear();
  sample.resize_uninitialised(all ? size_ : n);
  if (!all && kSparse * size_ >= pixels) {
    for (std::uint32_t k = 0; k < n;) {
      const std::uint32_t pixel = random.below(pixels);
      const Raw raw = kept_at(pixel);
      put(raw, pixel, k, sample);
      k += static_cast<std::uint32_t>(raw > Raw{0});
    }
    return;
  }
  AlignedVector<std::uint32_t>& list = buffers_->pixels;
  list.clear();
  for (std::uint32_t pixel = 0; pixel < pixels; ++pixel) {
    if (kept_at(pixel) > Raw{0}) list.push_back(pixel);
  }
  for (std::uint32_t k = 0; k < sample.size(); ++k) {
    const std::uint32_t pixel = list[all ? k : random.below(static_cast<std::uint32_t>(list.size()))];
    put(kept_at(pixel), pixel, k, sample);
  }
}

template <class Raw>
void DepthData<Raw>::put(Raw raw, std::uint32_t pixel, std::uint32_t k, PointCloud& sample) const {
  const Camera& camera = rows_->camera();
  const auto width = static_cast<std::uint32_t>(rows_->width());
  const std::uint32_t u = pixel % width;
  const std::uint32_t v = pixel / width;
  const float z = static_cast<float>(raw) * rows_->view().metres_per_unit();
  sample.x()[k] = z * ((static_cast<float>(u) - static_cast<float>(camera.cx)) * static_cast<float>(1.0 / camera.fx));
  sample.y()[k] = z * ((static_cast<float>(v) - static_cast<float>(camera.cy)) * static_cast<float>(1.0 / camera.fy));
  sample.z()[k] = z;
}

/// Adds up of_row(v, kept row) over the rows of a task.
template <class Raw>
template <class Sum, class OfRow>
Sum DepthData<Raw>::sum_over_rows(int task, const OfRow& of_row) const {
  DepthRowBuffer& buffer = buffers_->rows[static_cast<std::size_t>(task)];
  Sum sum{};
  const int end = std::min(rows_->height(), (task + 1) * kRowsOfTask);
  for (int v = task * kRowsOfTask; v < end; ++v) sum += of_row(v, rows_->row(v, buffer).kept);
  return sum;
}

/// Adds up of_row over all rows: in tasks, so that the sum does not depend on the number of threads. `enough(sum, rows)` ends
/// it early where one thread does all.
template <class Raw>
template <class Sum, class OfRow, class Enough>
Sum DepthData<Raw>::sum_over_image(const OfRow& of_row, const Enough& enough) const {
  Sum sum{};
  if (resolve_threads(threads_) == 1) {
    for (int task = 0; task < static_cast<int>(row_tasks(rows_->height())) && !enough(sum, task * kRowsOfTask); ++task)
      sum += sum_over_rows<Sum>(task, of_row);
    return sum;
  }
  return parallel_sum<Sum>(threads_, row_tasks(rows_->height()),
                           [&](std::size_t task) { return sum_over_rows<Sum>(static_cast<int>(task), of_row); });
}

template <class Raw>
sac::Score DepthData<Raw>::score(const Plane& plane, float threshold, sac::Scoring scoring, const sac::Score& to_beat) const {
  const ImagePlane image_plane(plane, rows_->camera(), rows_->view().metres_per_unit(), static_cast<double>(threshold));
  const auto& kernels = kernels::row_kernels<Raw>();
  const std::size_t n = rows_->padded_width();
  const auto of_row = [&](int v, const Raw* raw) {
    const kernels::Msac msac = kernels.score(raw, n, image_plane.row(v));
    const double value = scoring == sac::Scoring::msac ? static_cast<double>(msac.gain) : static_cast<double>(msac.inliers);
    return sac::Score{value, msac.inliers};
  };
  // Bail-out: a pixel adds at most 1. Exact: it costs nothing but losers.
  const auto lost = [&](const sac::Score& sum, int rows) {
    const std::uint64_t left =
        std::min<std::uint64_t>(size_, static_cast<std::uint64_t>(rows_->height() - rows) * rows_->width());
    return sum.value + static_cast<double>(left) <= to_beat.value;
  };
  return sum_over_image<sac::Score>(of_row, lost);
}

template <class Raw>
sac::Moments DepthData<Raw>::inlier_moments(const Plane& plane, float threshold) const {
  const Camera& camera = rows_->camera();
  const auto metres = static_cast<double>(rows_->view().metres_per_unit());
  const ImagePlane image_plane(plane, camera, rows_->view().metres_per_unit());
  const kernels::Ramp ray{static_cast<float>(-camera.cx / camera.fx), static_cast<float>(1.0 / camera.fx)};
  const auto& kernels = kernels::row_kernels<Raw>();
  const std::size_t n = rows_->padded_width();
  const auto of_row = [&](int v, const Raw* raw) {
    const kernels::RowMoments m = kernels.moments(raw, n, image_plane.row(v), threshold, ray);
    const double b = (v - camera.cy) / camera.fy;  // y = b z along the row
    const auto linear = [&](float sum) { return static_cast<double>(sum) * metres; };
    const auto square = [&](float sum) { return static_cast<double>(sum) * metres * metres; };
    const double xz = square(m.zza);
    const double zz = square(m.zz);
    sac::Moments moments;
    moments.count = m.count;
    moments.sum << linear(m.za), b * linear(m.z), linear(m.z);
    moments.sum_outer << square(m.zzaa), b * xz, xz, b * xz, b * b * zz, b * zz, xz, b * zz, zz;
    return moments;
  };
  return sum_over_image<sac::Moments>(of_row, [](const sac::Moments&, int) { return false; });
}

template class DepthData<std::uint16_t>;
template class DepthData<float>;

}  // namespace fransac
