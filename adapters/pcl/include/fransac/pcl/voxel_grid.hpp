// SPDX-License-Identifier: Apache-2.0
/// One point per occupied leaf, in the place of pcl::VoxelGrid.
#pragma once

#include <pcl/filters/filter.h>

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <pcl/impl/pcl_base.hpp>
#include <string>
#include <vector>

#include "fransac/filter/voxel_grid.hpp"
#include "fransac/pcl/field_means.hpp"
#include "fransac/pcl/points.hpp"

namespace fransac::pcl {

/// Replaces the points of every leaf by their mean: PCL's interface and defaults, with places in the grid in 64 bits (31 along an
/// axis, 63 together), where PCL gives up beyond 2^31 leaves, empty ones included. PointT is any point type with x, y and z.
///
/// All registered fields are averaged: colours channel by channel, normals to unit length, labels by majority, as in PCL; fields
/// that PCL leaves at zero as well.
/// Points are in the order in which the input first enters their leaves.
template <class PointT>
class VoxelGrid : public ::pcl::Filter<PointT> {
 public:
  using typename ::pcl::Filter<PointT>::PointCloud;  ///< Of PCL.

  /// No leaf size, no limits, all fields.
  VoxelGrid() { this->filter_name_ = "VoxelGrid"; }

  /// Edges of a leaf along x, y and z, metres; all must be positive.
  /// @{
  void setLeafSize(float x, float y, float z) { leaf_size_ = {x, y, z}; }
  void setLeafSize(const Eigen::Vector4f& leaf_size) { leaf_size_ = leaf_size.head<3>(); }
  [[nodiscard]] Eigen::Vector3f getLeafSize() const { return leaf_size_; }
  /// @}
  /// False: x, y and z alone; the other fields are as in a new point.
  /// @{
  void setDownsampleAllData(bool all) { all_data_ = all; }
  [[nodiscard]] bool getDownsampleAllData() const { return all_data_; }
  /// @}
  /// Leaves with fewer points are left out.
  /// @{
  void setMinimumPointsNumberPerVoxel(unsigned int fewest) { fewest_ = fewest; }
  [[nodiscard]] unsigned int getMinimumPointsNumberPerVoxel() const { return fewest_; }
  /// @}
  /// Whether getLeafLayout() has one. Leaves can be looked up either way.
  /// @{
  void setSaveLeafLayout(bool save) { save_leaf_layout_ = save; }
  [[nodiscard]] bool getSaveLeafLayout() const { return save_leaf_layout_; }
  /// @}
  /// Points whose value of this field is outside the limits are left out; empty: none are.
  /// @{
  void setFilterFieldName(const std::string& name) { field_ = name; }
  [[nodiscard]] std::string getFilterFieldName() const { return field_; }
  /// @}
  /// Values that stay, the limits themselves too.
  /// @{
  void setFilterLimits(const double& min, const double& max) {
    limit_min_ = min;
    limit_max_ = max;
  }
  void getFilterLimits(double& min, double& max) const {
    min = limit_min_;
    max = limit_max_;
  }
  /// @}
  /// True: points strictly between the limits are left out instead.
  /// @{
  void setFilterLimitsNegative(bool negative) { negative_ = negative; }
  [[nodiscard]] bool getFilterLimitsNegative() const { return negative_; }
  void getFilterLimitsNegative(bool& negative) const { negative = negative_; }
  /// @}
  /// Not in PCL. 0: all cores; negative, the default: one. Never changes the answer.
  void setNumberOfThreads(int threads = -1) { threads_ = threads; }

  /// Of the grid that filter() made last. Places beyond 32 bits are shown as the largest or smallest int, here and below.
  /// @{
  [[nodiscard]] Eigen::Vector3i getMinBoxCoordinates() const { return to_int(grid_.smallest); }
  [[nodiscard]] Eigen::Vector3i getMaxBoxCoordinates() const { return to_int(grid_.largest); }
  [[nodiscard]] Eigen::Vector3i getNrDivisions() const { return to_int(grid_.largest - grid_.smallest + Grid::Index::Ones()); }
  /// @}
  /// What coordinates less the smallest are multiplied with, for the place in getLeafLayout().
  [[nodiscard]] Eigen::Vector3i getDivisionMultiplier() const { return to_int(multiplier()); }
  /// For every place of the grid, x fastest, where in the output its leaf is, -1 where there is none: made at every call, a
  /// look-up for each place. Empty unless it was asked for before, and where there are more places than an int counts.
  [[nodiscard]] std::vector<int> getLeafLayout() const {
    std::vector<int> layout;
    const Grid::Index divisions = grid_.largest - grid_.smallest + Grid::Index::Ones();
    constexpr std::int64_t kMost = std::numeric_limits<int>::max();
    if (!save_leaf_layout_ || output_of_.empty() || divisions.z() > kMost / multiplier().z()) return layout;
    layout.reserve(static_cast<std::size_t>(divisions.prod()));
    for (std::int64_t z = 0; z < divisions.z(); ++z) {
      for (std::int64_t y = 0; y < divisions.y(); ++y) {
        for (std::int64_t x = 0; x < divisions.x(); ++x) {
          layout.push_back(output_at(Grid::Index(grid_.smallest + Grid::Index(x, y, z))));
        }
      }
    }
    return layout;
  }
  /// Where a point lies in the grid, leaf or none.
  [[nodiscard]] Eigen::Vector3i getGridCoordinates(float x, float y, float z) const { return to_int(grid_.index_at({x, y, z})); }
  /// Where in the output the leaf with these coordinates is, -1 where there is none.
  [[nodiscard]] int getCentroidIndexAt(const Eigen::Vector3i& place) const {
    return output_at({place.x(), place.y(), place.z()});
  }
  /// Where in the output the leaf is that this point lies in, -1 where there is none.
  [[nodiscard]] int getCentroidIndex(const PointT& p) const {
    return detail::is_finite(p) ? output_at(grid_.index_at({p.x, p.y, p.z})) : -1;
  }
  /// The same of leaves so many steps from the point's (a column each).
  [[nodiscard]] std::vector<int> getNeighborCentroidIndices(const PointT& p, const Eigen::MatrixXi& steps) const {
    std::vector<int> found(static_cast<std::size_t>(steps.cols()), -1);
    if (!detail::is_finite(p)) return found;
    const Grid::Index place = grid_.index_at({p.x, p.y, p.z});
    for (Eigen::Index i = 0; i < steps.cols(); ++i) {
      found[static_cast<std::size_t>(i)] = output_at(place + Grid::Index(steps(0, i), steps(1, i), steps(2, i)));
    }
    return found;
  }

 protected:
  /// What filter() calls.
  void applyFilter(PointCloud& output) override {
    output.is_dense = true;
    output_of_.clear();
    outputs_ = 0;
    if (!((leaf_size_.array() > 0.0F).all() && leaf_size_.allFinite())) {
      return fail(output, "the leaf size must be positive");
    }
    if (!field_.empty() && !detail::field_named<PointT>(field_)) {
      return fail(output, "the points have no field '" + field_ + "'");
    }
    const Status status = make_grid();
    if (!status) {
      if (status.error().code == ErrorCode::out_of_memory) return fail(output, status.error().message);
      complain(status.error().message);  // too many leaves for 63 bits: like PCL with too many for 31
      output = *this->input_;
      return;
    }
    number_leaves();
    write(output);
  }

 private:
  using Grid = ::fransac::VoxelGrid;

  void complain(const std::string& what) const { detail::complain(this->getClassName() + "::applyFilter", what); }

  void fail(PointCloud& output, const std::string& what) const {
    complain(what);
    output.clear();
  }

  [[nodiscard]] bool averages_all_fields() const { return all_data_ && detail::has_more_than_xyz<PointT>(); }

  Status make_grid() {
    const ::pcl::PointCloud<PointT>& input = *this->input_;
    const ::pcl::Indices* const indices = this->fake_indices_ ? nullptr : this->indices_.get();
    const PointsGridOptions options{
        .leaf_size_m = leaf_size_.cast<double>(), .leaf_of = averages_all_fields(), .threads = threads_ < 0 ? 1 : threads_};
    const std::optional<PointsView> in_place = detail::view_of(input);
    gathered_ = indices != nullptr || !field_.empty() || !in_place;
    if (!gathered_) {
      return voxel_grid(*in_place, options, grid_);
    }
    if (field_.empty()) {
      detail::read(input, indices, points_);
    } else {
      const detail::Component field = *detail::field_named<PointT>(field_);
      detail::read(
          input, indices, [&](std::size_t i) { return keeps(field.read(input[i])); }, points_);
    }
    return voxel_grid(points_, options, grid_);
  }

  /// Limits themselves are kept either way, and so is NaN, as in PCL.
  [[nodiscard]] bool keeps(double value) const {
    return negative_ ? !(value < limit_max_ && value > limit_min_) : !(value > limit_max_ || value < limit_min_);
  }

  /// Finds the place in the output of each leaf with enough points.
  void number_leaves() {
    output_of_.resize(grid_.leaves.size());
    outputs_ = 0;
    for (std::size_t leaf = 0; leaf < output_of_.size(); ++leaf) {
      output_of_[leaf] = grid_.point_count[leaf] >= fewest_ ? static_cast<int>(outputs_++) : -1;
    }
  }

  void write(PointCloud& output) {
    const bool means = averages_all_fields();
    if (means) output.clear();  // what is not registered is then as in a new point
    output.resize(outputs_);
    output.width = static_cast<std::uint32_t>(outputs_);
    output.height = 1;
    if (means) write_means(output);
    const float* const x = grid_.leaves.x();
    const float* const y = grid_.leaves.y();
    const float* const z = grid_.leaves.z();
    for (std::size_t leaf = 0; leaf < output_of_.size(); ++leaf) {
      if (output_of_[leaf] < 0) continue;
      PointT& point = output[static_cast<std::size_t>(output_of_[leaf])];
      if (!means) point = PointT();
      point.x = x[leaf];
      point.y = y[leaf];
      point.z = z[leaf];
    }
  }

  void write_means(PointCloud& output) const {
    detail::FieldMeans<PointT> means(outputs_);
    for (std::size_t i = 0; i < grid_.leaf_of.size(); ++i) {
      const int place = output_at(grid_.leaf_of[i]);
      if (place >= 0) means.add(static_cast<std::size_t>(place), (*this->input_)[gathered_ ? points_.source_of(i) : i]);
    }
    for (std::size_t place = 0; place < outputs_; ++place) means.get(place, output[place]);
  }

  [[nodiscard]] int output_at(std::uint32_t leaf) const { return leaf < output_of_.size() ? output_of_[leaf] : -1; }
  [[nodiscard]] int output_at(const Grid::Index& place) const { return output_at(grid_.leaf_at(place)); }

  /// At most 2^62: indices have at most 31 bits along an axis.
  [[nodiscard]] Grid::Index multiplier() const {
    const Grid::Index divisions = grid_.largest - grid_.smallest + Grid::Index::Ones();
    return {1, divisions.x(), divisions.x() * divisions.y()};
  }

  static Eigen::Vector3i to_int(const Grid::Index& place) {
    constexpr std::int64_t kMin = std::numeric_limits<int>::min();
    constexpr std::int64_t kMax = std::numeric_limits<int>::max();
    return place.cwiseMax(kMin).cwiseMin(kMax).cast<int>();
  }

  Eigen::Vector3f leaf_size_ = Eigen::Vector3f::Zero();
  bool all_data_ = true;
  unsigned int fewest_ = 0;
  bool save_leaf_layout_ = false;
  std::string field_;
  double limit_min_ = static_cast<double>(std::numeric_limits<float>::lowest());
  double limit_max_ = static_cast<double>(std::numeric_limits<float>::max());
  bool negative_ = false;
  int threads_ = -1;

  bool gathered_ = false;  ///< Whether points_ are what the grid was made of; else the input as it lies in memory.
  ::fransac::PointCloud points_;
  Grid grid_;
  std::vector<int> output_of_;  ///< Of each leaf; -1: it has too few points.
  std::size_t outputs_ = 0;
};

}  // namespace fransac::pcl
