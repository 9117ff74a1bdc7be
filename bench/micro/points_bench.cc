// SPDX-License-Identifier: Apache-2.0
// The kernels over point arrays, each beside its scalar truth. Points lie on a noisy plane among uniform ones.
#include <benchmark/benchmark.h>

#include <algorithm>
#include <vector>

#include "fransac/core/aligned.hpp"
#include "fransac/core/point_cloud.hpp"
#include "fransac/core/random.hpp"
#include "kernels/points.h"

namespace {

using fransac::kernels::PlaneF;

constexpr PlaneF kPlane{0.0F, 0.0F, 1.0F, -2.0F};
constexpr float kThreshold = 0.01F;

fransac::PointCloud make_cloud(std::size_t n) {
  fransac::RandomStream random(1, 0);
  fransac::PointCloud cloud;
  cloud.resize(n);
  for (std::size_t i = 0; i < n; ++i) {
    const bool on_plane = random.uniform() < 0.5;
    const double z = on_plane ? 2.0 + 0.004 * random.normal() : 0.5 + 4.0 * random.uniform();
    cloud.set(i, Eigen::Vector3d(4.0 * random.uniform() - 2.0, 3.0 * random.uniform() - 1.5, z).cast<float>());
  }
  return cloud;
}

template <class Kernel>
void over_points(benchmark::State& state, const Kernel& kernel) {
  const fransac::PointCloud cloud = make_cloud(static_cast<std::size_t>(state.range(0)));
  for (auto _ : state) benchmark::DoNotOptimize(kernel(cloud.x(), cloud.y(), cloud.z(), cloud.padded_size()));
  state.SetItemsProcessed(state.iterations() * state.range(0));
}

#define FRANSAC_POINT_BENCH(name)                                                                        \
  void name(benchmark::State& state) {                                                                   \
    over_points(state, [](auto... a) { return fransac::kernels::name(a..., kPlane, kThreshold); });      \
  }                                                                                                      \
  BENCHMARK(name)->Arg(2048)->Arg(300000);                                                               \
  void name##_ref(benchmark::State& state) {                                                             \
    over_points(state, [](auto... a) { return fransac::kernels::ref::name(a..., kPlane, kThreshold); }); \
  }                                                                                                      \
  BENCHMARK(name##_ref)->Arg(2048)->Arg(300000)

FRANSAC_POINT_BENCH(count_inliers);
FRANSAC_POINT_BENCH(msac);
FRANSAC_POINT_BENCH(inlier_moments);

/// The same points side by side, as in PCL.
void leaf_runs(benchmark::State& state) {
  constexpr fransac::kernels::Lattice kLattice{
      .per_leaf = {50.0, 50.0, 50.0}, .offset = {200.0, 200.0, 0.0}, .rounder = {0x1.8p25, 0x1.8p25, 0x1.8p25}};
  constexpr std::size_t kStretch = 256;
  const auto n = static_cast<std::size_t>(state.range(0));
  const fransac::PointCloud cloud = make_cloud(n);
  std::vector<float> points(4 * n);
  for (std::size_t i = 0; i < n; ++i) Eigen::Map<Eigen::Vector3f>(points.data() + 4 * i) = cloud.local(i).cast<float>();
  fransac::AlignedVector<fransac::kernels::LeafRun> runs(kStretch);
  for (auto _ : state) {
    for (std::size_t i = 0; i < n; i += kStretch) {
      benchmark::DoNotOptimize(
          fransac::kernels::leaf_runs(points.data() + 4 * i, 4, std::min(kStretch, n - i), kLattice, runs.data()));
    }
  }
  state.SetItemsProcessed(state.iterations() * state.range(0));
}
BENCHMARK(leaf_runs)->Arg(2048)->Arg(300000);

}  // namespace
