// SPDX-License-Identifier: Apache-2.0
/// All planes of an organised cloud, in the place of pcl::OrganizedMultiPlaneSegmentation.
#pragma once

#include <pcl/ModelCoefficients.h>
#include <pcl/PointIndices.h>
#include <pcl/common/centroid.h>
#include <pcl/pcl_base.h>
#include <pcl/point_types.h>
#include <pcl/segmentation/planar_region.h>

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <numbers>
#include <pcl/impl/pcl_base.hpp>
#include <string>
#include <utility>
#include <vector>

#include "fransac/core/labels.hpp"
#include "fransac/filter/organised.hpp"
#include "fransac/pcl/points.hpp"
#include "fransac/planes/outline.hpp"
#include "fransac/planes/segment.hpp"

namespace fransac::pcl {

/// Finds every plane of a cloud that a depth camera took, by the method `cells`: PCL's interface and result types. No normals are
/// needed: setInputNormals() takes them and leaves them alone. The camera is recovered from the cloud, which must be organised,
/// in the camera's optical frame and without distortion (filter/organised.hpp).
///
/// Labels count planes from 0, most square metres first; kNoPlane is the label of points on none. Coefficients point to the
/// camera (d >= 0), as PCL's do. Both segment() and segmentAndRefine() give exact borders.
///
/// What neighbouring points must have in common follows from the sensor's noise. So PCL's thresholds of angle, distance and
/// curvature have no counterpart: they are kept for their getters and change nothing. options() is what there is instead.
template <class PointT, class PointNT = ::pcl::Normal, class PointLT = ::pcl::Label>
class OrganizedMultiPlaneSegmentation : public ::pcl::PCLBase<PointT> {
 public:
  /// PCL's types of what goes in and comes out.
  /// @{
  using Regions = std::vector<::pcl::PlanarRegion<PointT>, Eigen::aligned_allocator<::pcl::PlanarRegion<PointT>>>;
  using Models = std::vector<::pcl::ModelCoefficients>;
  using IndexLists = std::vector<::pcl::PointIndices>;
  using Centroids = std::vector<Eigen::Vector4f, Eigen::aligned_allocator<Eigen::Vector4f>>;
  using Covariances = std::vector<Eigen::Matrix3f, Eigen::aligned_allocator<Eigen::Matrix3f>>;
  using Labels = ::pcl::PointCloud<PointLT>;
  using LabelsPtr = typename Labels::Ptr;
  using NormalsConstPtr = typename ::pcl::PointCloud<PointNT>::ConstPtr;
  /// @}

  /// The label of points on no plane.
  static constexpr std::uint32_t kNoPlane = std::numeric_limits<std::uint32_t>::max();

  /// Of the method `cells`, for a structured-light camera.
  OrganizedMultiPlaneSegmentation() { options_.method = Method::cells; }

  /// Taken and left alone.
  /// @{
  void setInputNormals(const NormalsConstPtr& normals) { normals_ = normals; }
  [[nodiscard]] NormalsConstPtr getInputNormals() const { return normals_; }
  /// @}
  /// Planes with fewer points are left out; 1000 at first.
  /// @{
  void setMinInliers(unsigned fewest) { fewest_ = fewest; }
  [[nodiscard]] unsigned getMinInliers() const { return fewest_; }
  /// @}
  /// Kept for their getters: radians, metres, curvature.
  /// @{
  void setAngularThreshold(double radians) { angular_threshold_ = radians; }
  [[nodiscard]] double getAngularThreshold() const { return angular_threshold_; }
  void setDistanceThreshold(double metres) { distance_threshold_ = metres; }
  [[nodiscard]] double getDistanceThreshold() const { return distance_threshold_; }
  void setMaximumCurvature(double curvature) { maximum_curvature_ = curvature; }
  [[nodiscard]] double getMaximumCurvature() const { return maximum_curvature_; }
  /// @}
  /// Whether contours are moved onto the plane along their rays.
  void setProjectPoints(bool project) { project_points_ = project; }
  /// PCL's comparators say which neighbours belong together by normals, which nothing here looks at: taken and left alone.
  /// @{
  template <class ComparatorPtr>
  void setComparator(const ComparatorPtr& /*comparator*/) {}
  template <class ComparatorPtr>
  void setRefinementComparator(const ComparatorPtr& /*comparator*/) {}
  /// @}
  /// Not in PCL: sensor, seed, threads, directions of planes and what else segment() of the library takes.
  [[nodiscard]] SegmentOptions& options() { return options_; }

  /// Finds the planes; what comes out is as in PCL, list by list in the order of the planes. Empty where the cloud cannot be
  /// used.
  /// @{
  void segment(Models& models, IndexLists& inliers) {
    find();
    write(models, inliers);
  }

  void segment(Models& models, IndexLists& inliers, Centroids& centroids, Covariances& covariances, Labels& labels,
               IndexLists& label_indices) {
    segment(models, inliers);
    centroids.resize(inliers.size());
    covariances.resize(inliers.size());
    for (std::size_t i = 0; i < inliers.size(); ++i) spread(inliers[i], covariances[i], centroids[i]);
    write(labels);
    label_indices = inliers;
  }

  void segment(Regions& regions) { segmentAndRefine(regions); }

  void segmentAndRefine(Regions& regions) {
    Models models;
    IndexLists inliers;
    IndexLists boundaries;
    segment(models, inliers);
    write(models, inliers, regions, boundaries);
  }

  void segmentAndRefine(Regions& regions, Models& models, IndexLists& inliers, LabelsPtr& labels, IndexLists& label_indices,
                        IndexLists& boundaries) {
    segment(models, inliers);
    if (!labels) labels.reset(new Labels);
    write(*labels);
    label_indices = inliers;
    write(models, inliers, regions, boundaries);
  }
  /// @}

  /// Nothing is left to refine: segment() gives exact borders.
  void refine(Models& /*models*/, IndexLists& /*inliers*/, LabelsPtr& /*labels*/, IndexLists& /*label_indices*/) {}

 private:
  /// Leaves found_ without planes where there are none.
  void find() {
    found_.planes.clear();
    found_.labels.clear();
    if (!this->input_) return complain("no input cloud");
    detail::read_organised(*this->input_, this->indices_.get(), points_);
    if (Status status = organised_depth(points_, depth_); !status) return complain(status.error().message);
    SegmentOptions options = options_;
    if (!options.min_support) {
      const double share = static_cast<double>(fewest_) / static_cast<double>(std::max<std::size_t>(1, points_.size()));
      options.min_support = std::min(share, 1.0);
    }
    Status status = ::fransac::segment(depth_.view(), depth_.camera, options, workspace_, found_);
    if (!status) return complain(status.error().message);
    std::erase_if(found_.planes, [this](const PlaneSegment& plane) { return plane.inliers < fewest_; });
  }

  void complain(const std::string& what) const { detail::complain("OrganizedMultiPlaneSegmentation::segment", what); }

  /// By label: the number of the plane among those found, or -1.
  [[nodiscard]] std::vector<int> numbers() const {
    std::vector<int> number(kLabelNoPlane + 1, -1);
    for (std::size_t i = 0; i < found_.planes.size(); ++i)
      number[static_cast<std::size_t>(found_.planes[i].id)] = static_cast<int>(i);
    return number;
  }

  void write(Models& models, IndexLists& inliers) const {
    models.assign(found_.planes.size(), {});
    inliers.assign(found_.planes.size(), {});
    for (std::size_t i = 0; i < found_.planes.size(); ++i) {
      const PlaneSegment& plane = found_.planes[i];
      models[i].header = inliers[i].header = this->input_->header;
      models[i].values = detail::coefficients_of(plane.plane);
      inliers[i].indices.reserve(plane.inliers);
    }
    const std::vector<int> number = numbers();
    for (std::size_t i = 0; i < found_.labels.size(); ++i) {
      const int plane = number[found_.labels[i]];
      if (plane >= 0) inliers[static_cast<std::size_t>(plane)].indices.push_back(static_cast<::pcl::index_t>(i));
    }
  }

  void write(Labels& labels) const {
    labels.clear();
    if (!this->input_) return;
    labels.header = this->input_->header;
    labels.resize(this->input_->size());
    labels.width = this->input_->width;
    labels.height = this->input_->height;
    const std::vector<int> number = numbers();
    for (std::size_t i = 0; i < labels.size(); ++i) {
      const int plane = i < found_.labels.size() ? number[found_.labels[i]] : -1;
      labels[i].label = plane < 0 ? kNoPlane : static_cast<std::uint32_t>(plane);
    }
  }

  void spread(const ::pcl::PointIndices& inliers, Eigen::Matrix3f& covariance, Eigen::Vector4f& centroid) const {
    ::pcl::computeMeanAndCovarianceMatrix(*this->input_, inliers.indices, covariance, centroid);
  }

  void write(const Models& models, const IndexLists& inliers, Regions& regions, IndexLists& boundaries) const {
    regions.clear();
    boundaries.assign(models.size(), {});
    if (models.empty()) return;
    const std::vector<std::vector<Outline>> parts = outlines(found_, depth_.camera, {.tolerance_px = 0.0, .min_pixels = 1});
    for (std::size_t i = 0; i < models.size(); ++i) {
      boundaries[i].header = models[i].header;
      if (!parts[i].empty()) boundaries[i].indices = pixels_along(parts[i].front().outer);
      Eigen::Matrix3f covariance = Eigen::Matrix3f::Zero();
      Eigen::Vector4f centroid = Eigen::Vector4f::Zero();
      spread(inliers[i], covariance, centroid);
      const Eigen::Map<const Eigen::Vector4f> plane(models[i].values.data());
      regions.emplace_back(centroid.template head<3>(), covariance, static_cast<unsigned>(inliers[i].indices.size()),
                           contour(boundaries[i].indices, plane), plane);
    }
  }

  /// The pixels just inside a ring, in its order. The plane is on the left of who walks along it, v pointing down.
  [[nodiscard]] ::pcl::Indices pixels_along(const Ring& ring) const {
    ::pcl::Indices pixels;
    for (std::size_t i = 0; i < ring.pixels.size(); ++i) {
      const Eigen::Vector2d from = ring.pixels[i];
      const Eigen::Vector2d way = ring.pixels[(i + 1) % ring.pixels.size()] - from;
      const double length = way.cwiseAbs().sum();  // along a row or a column
      const Eigen::Vector2d step = way / length;
      const Eigen::Vector2d left(step.y(), -step.x());
      for (double k = 0.5; k < length; k += 1.0) {
        const Eigen::Vector2d pixel = from + k * step + 0.5 * left;
        const auto index =
            static_cast<::pcl::index_t>(std::lround(pixel.y()) * static_cast<long>(this->input_->width) + std::lround(pixel.x()));
        if (pixels.empty() || pixels.back() != index) pixels.push_back(index);
      }
    }
    return pixels;
  }

  [[nodiscard]] typename ::pcl::PointCloud<PointT>::VectorType contour(const ::pcl::Indices& pixels,
                                                                       const Eigen::Vector4f& plane) const {
    typename ::pcl::PointCloud<PointT>::VectorType points;
    points.reserve(pixels.size());
    for (const ::pcl::index_t pixel : pixels) {
      PointT p = (*this->input_)[static_cast<std::size_t>(pixel)];
      const float along = plane.head<3>().dot(Eigen::Vector3f(p.x, p.y, p.z));
      if (project_points_ && along != 0.0F) {
        const float stretch = -plane[3] / along;
        p.x *= stretch;
        p.y *= stretch;
        p.z *= stretch;
      }
      points.push_back(p);
    }
    return points;
  }

  // PCL's defaults.
  unsigned fewest_ = 1000;
  double angular_threshold_ = 3.0 * std::numbers::pi / 180.0;
  double distance_threshold_ = 0.02;
  double maximum_curvature_ = 0.001;
  bool project_points_ = false;
  NormalsConstPtr normals_;

  SegmentOptions options_;
  ::fransac::PointCloud points_;
  OrganisedDepth depth_;
  Workspace workspace_;
  Segmentation found_;
};

}  // namespace fransac::pcl
