// SPDX-License-Identifier: Apache-2.0
/// The pixels of a depth image as data of a plane search, without a point cloud.
#pragma once

#include "filter/depth_rows.hpp"
#include "fransac/sac/plane_problem.hpp"

namespace fransac {

/// What DepthData keeps between frames.
struct DepthDataBuffers {
  std::vector<DepthRowBuffer> rows;  ///< One per task.
  AlignedVector<std::uint32_t> pixels;
};

/// The kept pixels of an image as points in the camera's frame.
template <class Raw>
class DepthData final : public sac::PlaneData {
 public:
  /// `rows` and `buffers` must outlive this. `threads`: 0 all cores; never changes the answer.
  DepthData(const DepthRows<Raw>& rows, int threads, DepthDataBuffers& buffers);

  [[nodiscard]] std::uint64_t size() const override { return size_; }
  /// Measured pixels, whether limits keep them or not.
  [[nodiscard]] std::uint64_t measured() const { return measured_; }
  void draw(RandomStream& random, std::uint32_t n, PointCloud& sample) const override;
  [[nodiscard]] sac::Score score(const Plane& plane, float threshold, sac::Scoring scoring,
                                 const sac::Score& to_beat) const override;
  [[nodiscard]] sac::Moments inlier_moments(const Plane& plane, float threshold) const override;

 private:
  void put(Raw raw, std::uint32_t pixel, std::uint32_t k, PointCloud& sample) const;
  template <class Sum, class OfRow>
  Sum sum_over_rows(int task, const OfRow& of_row) const;
  template <class Sum, class OfRow, class Enough>
  Sum sum_over_image(const OfRow& of_row, const Enough& enough) const;

  const DepthRows<Raw>* rows_;
  int threads_;
  DepthDataBuffers* buffers_;
  std::uint64_t size_ = 0;
  std::uint64_t measured_ = 0;
};

}  // namespace fransac
