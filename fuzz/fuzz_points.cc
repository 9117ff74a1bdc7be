// SPDX-License-Identifier: Apache-2.0
// Depth images as points and back, voxel grids of both, limits, lenses and distortion, all of any numbers: errors, or leaves that
// hold every point once, images that are each other's, and maps that stay in them; the same on any number of threads.
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <numeric>
#include <vector>

#include "draw.hpp"
#include "fransac/core/labels.hpp"
#include "fransac/filter/correct.hpp"
#include "fransac/filter/deproject.hpp"
#include "fransac/filter/organised.hpp"
#include "fransac/filter/pass_through.hpp"
#include "fransac/filter/rays.hpp"
#include "fransac/filter/voxel_grid.hpp"
#include "require.hpp"

namespace {

using namespace fransac;
using namespace fransac::fuzz;

AxisLimits draw_limits(Bytes& bytes) {
  AxisLimits limits;
  limits.axis = static_cast<Axis>(bytes.ConsumeIntegralInRange(0, 2));
  limits.min_m = draw_seldom(bytes) ? draw_any(bytes) : draw_number(bytes, -2.0, 2.0);
  limits.max_m = draw_seldom(bytes) ? draw_any(bytes) : draw_number(bytes, 0.0, 10.0);
  limits.outside = bytes.ConsumeBool();
  return limits;
}

double draw_leaf_size(Bytes& bytes) { return draw_seldom(bytes) ? draw_any(bytes) : draw_number(bytes, 1e-4, 1.0); }

/// Leaves that hold `points` points, each of which leaf_of has once; `size` values of leaf_of or none.
void check(const VoxelGrid& grid, std::size_t points, std::size_t size) {
  require(grid.points == points && grid.measured >= points && grid.point_count.size() == grid.leaves.size());
  require(std::accumulate(grid.point_count.begin(), grid.point_count.end(), std::uint64_t{0}) == points);
  require((grid.smallest.array() <= grid.largest.array()).all());
  for (std::size_t i = 0; i < grid.leaves.size(); ++i) require(grid.leaves.finite(i) && grid.point_count[i] > 0);
  require(grid.leaf_of.empty() || grid.leaf_of.size() == size);
  std::vector<std::uint32_t> count(grid.leaves.size());
  for (const std::uint32_t leaf : grid.leaf_of) {
    require(leaf == VoxelGrid::kNoLeaf || leaf < count.size());
    if (leaf != VoxelGrid::kNoLeaf) ++count[leaf];
  }
  if (!grid.leaf_of.empty()) require(std::equal(count.begin(), count.end(), grid.point_count.begin()));
}

void check_same(const VoxelGrid& a, const VoxelGrid& b) {
  require(a.points == b.points && a.measured == b.measured && a.point_count == b.point_count);
  const auto same = [&](const float* x, const float* y) { return std::memcmp(x, y, a.leaves.size() * sizeof(float)) == 0; };
  if (a.leaves.empty()) return;
  require(same(a.leaves.x(), b.leaves.x()) && same(a.leaves.y(), b.leaves.y()) && same(a.leaves.z(), b.leaves.z()));
}

/// Grids of a cloud, of the same points in somebody else's memory, and of both on two threads.
void check_grids(Bytes& bytes, const PointCloud& cloud) {
  PointsGridOptions options;
  options.leaf_size_m = {draw_leaf_size(bytes), draw_leaf_size(bytes), draw_leaf_size(bytes)};
  if (bytes.ConsumeBool()) options.leaf_size_m.setConstant(options.leaf_size_m.x());
  options.leaf_point = bytes.ConsumeBool() ? LeafPoint::centre : LeafPoint::centroid;
  options.leaf_of = bytes.ConsumeBool();
  VoxelGrid grid;
  const Status status = voxel_grid(cloud, options, grid);
  if (!status) return require_message(status.error());
  check(grid, cloud.size(), cloud.size());
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const std::uint32_t leaf = grid.leaf_at(grid.index_at(cloud.local(i).cast<float>()));
    require(leaf < grid.leaves.size() && (grid.leaf_of.empty() || leaf == grid.leaf_of[i]));
  }
  VoxelGrid other;
  PointsGridOptions on_two = options;
  on_two.threads = 2;
  require(voxel_grid(cloud, on_two, other).ok());
  check_same(grid, other);
  if (!cloud.origin.isZero(0.0)) return;
  const std::size_t stride = bytes.ConsumeIntegralInRange<std::size_t>(3, 6);
  std::vector<float> memory(cloud.size() * stride);
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    memory[i * stride] = cloud.x()[i];
    memory[i * stride + 1] = cloud.y()[i];
    memory[i * stride + 2] = cloud.z()[i];
  }
  require(voxel_grid(PointsView{memory.data(), cloud.size(), stride}, options, other).ok());
  check_same(grid, other);
}

void check_grid_of_image(Bytes& bytes, const DrawnDepth& depth) {
  const AxisLimits limits = draw_limits(bytes);
  DepthGridOptions options;
  options.leaf_size_m = draw_leaf_size(bytes);
  options.leaf_point = bytes.ConsumeBool() ? LeafPoint::centre : LeafPoint::centroid;
  options.limits = bytes.ConsumeBool() ? &limits : nullptr;
  options.leaf_of = bytes.ConsumeBool();
  PointCloud points;
  deproject(depth.view, depth.camera, points);
  const std::size_t measured = points.size();
  if (options.limits != nullptr) pass_through(limits, points);
  VoxelGrid grid;
  const Status status = voxel_grid(depth.view, depth.camera, options, grid);
  if (!status) return require_message(status.error());
  require(grid.measured == measured);
  check(grid, grid.points, depth.view.size());
  require(options.limits != nullptr || grid.points == measured);
  VoxelGrid other;
  options.threads = 2;
  require(voxel_grid(depth.view, depth.camera, options, other).ok());
  check_same(grid, other);
}

/// Points that limits keep are within them, and come from where they say.
void check_limits(Bytes& bytes, const PointCloud& cloud) {
  const AxisLimits limits = draw_limits(bytes);
  PointCloud kept = cloud;
  pass_through(limits, kept);
  require(kept.size() <= cloud.size());
  const LocalLimits local(limits, kept.origin[static_cast<int>(limits.axis)]);
  for (std::size_t i = 0; i < kept.size(); ++i) {
    require(kept.finite(i) && kept.local(i) == cloud.local(kept.source_of(i)));
    require(local.keeps(static_cast<float>(kept.local(i)[static_cast<int>(limits.axis)])));
  }
}

void check_organised(const PointCloud& cloud) {
  OrganisedDepth depth;
  const Status status = organised_depth(cloud, depth);
  if (!status) return require_message(status.error());
  require(validate(depth.camera).ok() && depth.metres.size() == cloud.size() && validate(depth.view()).ok());
  require(depth.rms_px >= 0.0 && depth.max_px <= 0.5);
  for (std::size_t i = 0; i < cloud.size(); ++i) require(depth.metres[i] == (cloud.measured(i) ? cloud.z()[i] : 0.0F));
}

/// What is corrected stays measured, by no more than the factor of 2; what is no measurement stays as it is.
void check_distortion(Bytes& bytes, const DrawnDepth& depth) {
  Distortion distortion;
  distortion.width = bytes.ConsumeBool() ? depth.view.width() : bytes.ConsumeIntegralInRange(-1, 64);
  distortion.height = bytes.ConsumeBool() ? depth.view.height() : bytes.ConsumeIntegralInRange(-1, 64);
  for (double& term : distortion.offset_per_m) term = draw_seldom(bytes) ? draw_any(bytes) : draw_number(bytes, -0.1, 0.1);
  for (double& term : distortion.gain) term = draw_seldom(bytes) ? draw_any(bytes) : draw_number(bytes, -0.1, 0.1);
  CorrectedDepth corrected;
  const int saturated = bytes.ConsumeBool() ? bytes.ConsumeIntegralInRange(0, 65535) : 0;
  const Status status = correct(depth.view, distortion, saturated, corrected);
  if (!status) return require_message(status.error());
  for (int v = 0; v < depth.view.height(); ++v) {
    for (int u = 0; u < depth.view.width(); ++u) {
      const float before = depth.view.metres(u, v);
      const float after = corrected.view.metres(u, v);
      const float unit = depth.view.format() == DepthFormat::uint16 ? depth.view.metres_per_unit() : 0.0F;
      if (saturated != 0 && unit > 0.0F) {
        const std::uint16_t raw = corrected.view.row_uint16(v)[u];
        require((raw == saturated) == (depth.view.row_uint16(v)[u] == saturated));
      }
      require((before == 0.0F) == (after == 0.0F));
      require(after <= 2.001F * before + unit && after >= 0.499F * before - 2.0F * unit);
    }
  }
}

void check_rays(Bytes& bytes, const DrawnDepth& depth) {
  const Camera& camera = depth.camera;
  RayTable rays{depth.view.width(), depth.view.height(), {}, {}};
  const double bend = draw_number(bytes, -0.5, 0.5);
  for (int v = 0; v < rays.height; ++v) {
    for (int u = 0; u < rays.width; ++u) {
      const double x = (u - camera.cx) / camera.fx;
      const double y = (v - camera.cy) / camera.fy;
      const double factor = 1.0 + bend * (x * x + y * y);
      rays.x.push_back(static_cast<float>(factor * x));
      rays.y.push_back(static_cast<float>(factor * y));
    }
  }
  for (int n = bytes.ConsumeIntegralInRange(0, 8); n > 0; --n) {
    std::vector<float>& table = bytes.ConsumeBool() ? rays.x : rays.y;
    table[bytes.ConsumeIntegralInRange<std::size_t>(0, table.size() - 1)] =
        std::bit_cast<float>(bytes.ConsumeIntegral<std::uint32_t>());
  }
  if (draw_seldom(bytes)) rays.x.pop_back();
  if (draw_seldom(bytes)) rays.width = bytes.ConsumeIntegral<int>();
  Camera ideal = camera;
  ideal.width = bytes.ConsumeIntegralInRange(1, 80);
  ideal.height = bytes.ConsumeIntegralInRange(1, 80);
  const Result<RayMap> map = ray_map(rays, ideal);
  if (!map) return require_message(map.error());
  const auto pixels = static_cast<std::size_t>(ideal.width) * static_cast<std::size_t>(ideal.height);
  require(map->original.size() == pixels && map->projected.size() == depth.view.size());
  for (const std::uint32_t i : map->original) require(i == RayMap::kNone || i < depth.view.size());
  for (const std::uint32_t i : map->projected) require(i == RayMap::kNone || i < pixels);
  std::vector<float> metres;
  require(undistort(depth.view, *map, metres).ok() && metres.size() == pixels);
  for (std::size_t i = 0; i < pixels; ++i) require(metres[i] >= 0.0F && (map->original[i] != RayMap::kNone || metres[i] == 0.0F));
  std::vector<std::uint8_t> labels(depth.view.size());
  require(labels_to_original(depth.view, *map, std::vector<std::uint8_t>(pixels, kLabelFirst), labels).ok());
  for (std::size_t i = 0; i < labels.size(); ++i) {
    const int u = static_cast<int>(i) % depth.view.width();
    const int v = static_cast<int>(i) / depth.view.width();
    require((labels[i] == kLabelNoDepth) == (depth.view.metres(u, v) == 0.0F));
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  Bytes bytes(data, size);
  const int what = bytes.ConsumeIntegralInRange(0, 5);
  const DrawnDepth depth = draw_depth(bytes);
  const bool sound = validate(depth.camera) && depth.camera.width == depth.view.width();
  if (what == 0 && sound) check_grid_of_image(bytes, depth);
  if (what == 1) check_distortion(bytes, depth);
  if (what == 2) check_rays(bytes, depth);
  if (what < 3) return 0;
  PointCloud cloud = draw_cloud(bytes, depth);
  if (what == 3) return check_organised(cloud), 0;
  if (!cloud.origin.allFinite()) cloud.origin.setZero();
  if (what == 4) return check_limits(bytes, cloud), 0;
  remove_unmeasured(cloud);
  check_grids(bytes, cloud);
  return 0;
}
