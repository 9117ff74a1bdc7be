// SPDX-License-Identifier: Apache-2.0
/// CGAL's Efficient RANSAC (Schnabel, Wahl, Klein 2007) on a cloud thinned by CGAL's own grid, with normals from 12
/// neighbours. It looks for all planes of at least 1 % of the thinned points; the connectivity that it asks for is five leaves,
/// its normals may differ by the documented default. Its probability is that of overlooking the largest plane: 1 - p.
/// Labels: the distance of each point to the largest plane.
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Point_with_normal_3.h>
#include <CGAL/Shape_detection/Efficient_RANSAC.h>
#include <CGAL/grid_simplify_point_set.h>
#include <CGAL/pca_estimate_normals.h>
#include <CGAL/property_map.h>
#include <CGAL/version.h>

#include <limits>
#include <utility>
#include <vector>

#include "labelling.hpp"

namespace fransac::bench {
namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using PointWithNormal = std::pair<Kernel::Point_3, Kernel::Vector_3>;
using Points = std::vector<PointWithNormal>;
using PointMap = CGAL::First_of_pair_property_map<PointWithNormal>;
using NormalMap = CGAL::Second_of_pair_property_map<PointWithNormal>;
using Traits = CGAL::Shape_detection::Efficient_RANSAC_traits<Kernel, Points, PointMap, NormalMap>;
using Ransac = CGAL::Shape_detection::Efficient_RANSAC<Traits>;
using Plane = CGAL::Shape_detection::Plane<Traits>;

class CgalEfficientRansac final : public Peer {
 public:
  [[nodiscard]] std::string id() const override { return "cgal-efficient-ransac"; }
  void load(const Frame& frame) override { labels_.resize(frame.size()); }

  bool run(const Frame& frame, Answer& answer) override {
    deproject(frame);
    leaves_ = points_;
    const auto options = CGAL::parameters::point_map(PointMap());
    leaves_.erase(CGAL::grid_simplify_point_set(leaves_, kLeafSize_m, options), leaves_.end());
    constexpr unsigned kNeighbours = 12;
    CGAL::pca_estimate_normals<CGAL::Sequential_tag>(leaves_, kNeighbours, options.normal_map(NormalMap()));

    Ransac ransac;
    ransac.set_input(leaves_);
    ransac.add_shape_factory<Plane>();
    Ransac::Parameters parameters;
    parameters.probability = 1.0 - kProbability;
    parameters.min_points = leaves_.size() / 100;
    parameters.epsilon = kThreshold_m;
    parameters.cluster_epsilon = 5 * kLeafSize_m;
    if (!ransac.detect(parameters)) return false;

    const Plane* largest = nullptr;
    std::size_t most = 0;
    for (const auto& shape : ransac.shapes()) {
      const auto* const plane = dynamic_cast<const Plane*>(shape.get());
      if (plane == nullptr || plane->indices_of_assigned_points().size() <= most) continue;
      largest = plane;
      most = plane->indices_of_assigned_points().size();
    }
    if (largest == nullptr) return false;
    const Kernel::Plane_3 plane = static_cast<Kernel::Plane_3>(*largest);
    const double length = std::sqrt(plane.orthogonal_vector().squared_length());
    answer.plane[0] = plane.a() / length;
    answer.plane[1] = plane.b() / length;
    answer.plane[2] = plane.c() / length;
    answer.plane[3] = plane.d() / length;

    const auto xyz = [this](std::size_t i, float& x, float& y, float& z) {
      const Kernel::Point_3& p = points_[i].first;
      x = static_cast<float>(p.x());
      y = static_cast<float>(p.y());
      z = static_cast<float>(p.z());
    };
    const auto pixel = [this](std::size_t i) { return pixels_[i]; };
    answer.inliers =
        label_by_distance(points_.size(), answer.plane, std::numeric_limits<double>::infinity(), xyz, pixel, labels_);
    answer.planes = 1;
    answer.labels = labels_.data();
    return true;
  }

 private:
  void deproject(const Frame& frame) {
    points_.clear();
    pixels_.clear();
    std::size_t pixel = 0;
    for (int v = 0; v < frame.height; ++v) {
      for (int u = 0; u < frame.width; ++u, ++pixel) {
        if (frame.depth[pixel] == 0) continue;
        const double z = frame.depth[pixel] / frame.depth_scale;
        points_.emplace_back(Kernel::Point_3((u - frame.cx) / frame.fx * z, (v - frame.cy) / frame.fy * z, z),
                             Kernel::Vector_3());
        pixels_.push_back(pixel);
      }
    }
  }

  Points points_;
  Points leaves_;
  std::vector<std::size_t> pixels_;
  std::vector<std::uint8_t> labels_;
};

}  // namespace

void add_cgal(Party& party) {
  party.peers.push_back(std::make_unique<CgalEfficientRansac>());
  party.versions.emplace_back("cgal", CGAL_VERSION_STR);
}

}  // namespace fransac::bench
