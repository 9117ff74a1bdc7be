// SPDX-License-Identifier: Apache-2.0
#include "fransac/filter/organised.hpp"

#include <algorithm>
#include <cmath>
#include <new>
#include <string>

#include "core/caught.hpp"
#include "core/number_text.hpp"

namespace fransac {
namespace {

/// Fewer measured points may lie on rays by chance, and hold no plane that is worth a search.
constexpr std::size_t kMinPoints = 64;
/// Nearer to its neighbour's centre than to its own a point would have its neighbour's label.
constexpr double kMaxError_px = 0.5;

Error unsupported(const std::string& what) { return {ErrorCode::unsupported, what}; }

/// Least squares of a coordinate on z (slope * pixel + offset): x = z (u - cx) / fx. An error of the coordinate counts by its
/// size in metres, as rounded coordinates have it.
class RayFit {
 public:
  /// `middle` of the pixels keeps the equations well conditioned.
  explicit RayFit(int pixels) : middle_(0.5 * (pixels - 1)) {}

  void add(int pixel, double z, double coordinate) {
    const double p = (pixel - middle_) * z;
    pp_ += p * p;
    pz_ += p * z;
    zz_ += z * z;
    pc_ += p * coordinate;
    zc_ += z * coordinate;
  }

  /// False where all points share a column (row), or the image is mirrored.
  bool solve(double& focal_length, double& centre) const {
    const double determinant = pp_ * zz_ - pz_ * pz_;
    if (!(determinant > 1e-9 * pp_ * zz_)) return false;
    const double slope = (pc_ * zz_ - zc_ * pz_) / determinant;
    const double offset = (zc_ * pp_ - pc_ * pz_) / determinant;
    focal_length = 1.0 / slope;
    centre = middle_ - offset / slope;
    return slope > 0.0;
  }

 private:
  double middle_;
  double pp_ = 0.0;
  double pz_ = 0.0;
  double zz_ = 0.0;
  double pc_ = 0.0;
  double zc_ = 0.0;
};

/// Calls visit(u, v, x, y, z) for every pixel whose depth is not 0.
template <class Visit>
void for_each_point(const PointCloud& cloud, const std::vector<float>& metres, Visit visit) {
  std::size_t i = 0;
  for (int v = 0; v < cloud.height; ++v) {
    for (int u = 0; u < cloud.width; ++u, ++i) {
      if (metres[i] == 0.0F) continue;
      visit(u, v, static_cast<double>(cloud.x()[i]), static_cast<double>(cloud.y()[i]), static_cast<double>(metres[i]));
    }
  }
}

Status check_shape(const PointCloud& cloud) {
  if (!cloud.organised()) return unsupported("the cloud is not organised");
  if (cloud.width < 1 || cloud.width > kMaxImageSide || cloud.height > kMaxImageSide) {
    return unsupported("the cloud is no image of 1 to " + std::to_string(kMaxImageSide) + " columns and rows");
  }
  if (static_cast<std::size_t>(cloud.width) * static_cast<std::size_t>(cloud.height) != cloud.size()) {
    return Error{ErrorCode::invalid_argument, "point cloud: width x height is not its number of points"};
  }
  if (!cloud.origin.isZero(0.0)) return unsupported("the cloud has large coordinates: they are not those of a camera's frame");
  return {};
}

Status read_depth(const PointCloud& cloud, std::vector<float>& metres) {
  metres.resize(cloud.size());
  std::size_t measured = 0;
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const float z = cloud.z()[i];
    const bool in_front = z > 0.0F && z <= kMaxDepth_m;
    const bool is_measured = in_front ? cloud.x()[i] * 0.0F + cloud.y()[i] * 0.0F == 0.0F : cloud.measured(i);
    if (is_measured && !in_front) {
      const auto width = static_cast<std::size_t>(cloud.width);
      return unsupported("point (" + std::to_string(i % width) + ", " + std::to_string(i / width) + ") has z = " +
                         number_text(static_cast<double>(z)) + " m, a camera sees what is in front of it (z forward, in metres)");
    }
    metres[i] = is_measured ? z : 0.0F;
    measured += is_measured ? 1 : 0;
  }
  if (measured < kMinPoints) return unsupported("only " + std::to_string(measured) + " points are measured");
  return {};
}

Status fit_camera(const PointCloud& cloud, const std::vector<float>& metres, Camera& camera) {
  RayFit columns(cloud.width);
  RayFit rows(cloud.height);
  for_each_point(cloud, metres, [&](int u, int v, double x, double y, double z) {
    columns.add(u, z, x);
    rows.add(v, z, y);
  });
  camera = Camera{.width = cloud.width, .height = cloud.height};
  if (!columns.solve(camera.fx, camera.cx)) return unsupported("x does not grow with the column");
  if (!rows.solve(camera.fy, camera.cy)) return unsupported("y does not grow with the row");
  if (const Status status = validate(camera); !status) return unsupported(status.error().message);
  return {};
}

Status measure_error(const PointCloud& cloud, OrganisedDepth& out) {
  const Camera& c = out.camera;
  double squares = 0.0;
  std::size_t points = 0;
  out.max_px = 0.0;
  for_each_point(cloud, out.metres, [&](int u, int v, double x, double y, double z) {
    const double per_z = 1.0 / z;
    const double du = c.fx * x * per_z + c.cx - u;
    const double dv = c.fy * y * per_z + c.cy - v;
    squares += du * du + dv * dv;
    out.max_px = std::max({out.max_px, std::abs(du), std::abs(dv)});
    ++points;
  });
  out.rms_px = std::sqrt(squares / static_cast<double>(points));
  if (out.max_px <= kMaxError_px) return {};
  return unsupported("points project up to " + number_text(out.max_px) + " pixels beside their own (rms " +
                     number_text(out.rms_px) + ")");
}

}  // namespace

Status organised_depth(const PointCloud& cloud, OrganisedDepth& out) try {
  if (Status status = check_shape(cloud); !status) return status;
  if (Status status = read_depth(cloud, out.metres); !status) return status;
  if (Status status = fit_camera(cloud, out.metres, out.camera); !status) return status;
  return measure_error(cloud, out);
} catch (const std::exception& exception) {
  return caught(exception, [&] { return "depth image of " + std::to_string(cloud.size()) + " points"; });
}

}  // namespace fransac
