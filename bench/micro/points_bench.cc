// SPDX-License-Identifier: Apache-2.0
// The kernels over point arrays, each beside its scalar truth. Points lie on a noisy plane among uniform ones.
#include <benchmark/benchmark.h>

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

void leaf_keys(benchmark::State& state) {
  constexpr fransac::kernels::Lattice kLattice{{50.0, 50.0, 50.0}, {200.0, 200.0, 0.0}, {0, 10, 20}};
  fransac::AlignedVector<std::uint64_t> keys(static_cast<std::size_t>(state.range(0)) + fransac::PointCloud::kBlock);
  over_points(state, [&](auto... a) {
    fransac::kernels::leaf_keys(a..., kLattice, keys.data());
    return keys[0];
  });
}
BENCHMARK(leaf_keys)->Arg(2048)->Arg(300000);

}  // namespace
