// SPDX-License-Identifier: Apache-2.0
// Parallel standard RANSAC's inner work, inliers counted in tasks of 65,536 points, by three executors: what parallel_for uses
// (oneTBB), plain threads made for each call, and OpenMP. Arguments: points, threads.
#include <benchmark/benchmark.h>

#include <atomic>
#include <cstdint>
#include <thread>
#include <vector>

#include "fransac/core/parallel.hpp"
#include "fransac/core/point_cloud.hpp"
#include "fransac/core/random.hpp"
#include "kernels/points.h"

namespace {

constexpr std::size_t kTask = 65536;

fransac::PointCloud make_cloud(std::size_t n) {
  fransac::RandomStream random(1, 0);
  fransac::PointCloud cloud;
  cloud.resize(n);
  for (std::size_t i = 0; i < n; ++i) {
    cloud.set(i, Eigen::Vector3d(random.uniform(), random.uniform(), 1.0 + 0.01 * random.normal()).cast<float>());
  }
  return cloud;
}

struct Tbb {
  template <class Body>
  static void run(int threads, std::size_t n, const Body& body) {
    fransac::parallel_for(threads, n, body);
  }
};

struct PlainThreads {
  template <class Body>
  static void run(int threads, std::size_t n, const Body& body) {
    std::atomic<std::size_t> next{0};
    const auto work = [&] {
      for (std::size_t i = next++; i < n; i = next++) body(i);
    };
    std::vector<std::jthread> helpers;
    for (int t = 1; t < threads; ++t) helpers.emplace_back(work);
    work();
  }
};

#ifdef _OPENMP
struct OpenMp {
  template <class Body>
  static void run(int threads, std::size_t n, const Body& body) {
#pragma omp parallel for schedule(dynamic) num_threads(threads)
    for (std::size_t i = 0; i < n; ++i) body(i);
  }
};
#endif

template <class Executor>
void count_inliers(benchmark::State& state) {
  const fransac::PointCloud cloud = make_cloud(static_cast<std::size_t>(state.range(0)));
  const auto threads = static_cast<int>(state.range(1));
  const std::size_t tasks = (cloud.padded_size() + kTask - 1) / kTask;
  std::vector<std::uint32_t> counts(tasks);
  for (auto _ : state) {
    Executor::run(threads, tasks, [&](std::size_t task) {
      const std::size_t first = task * kTask;
      const std::size_t size = std::min(kTask, cloud.padded_size() - first);
      counts[task] = fransac::kernels::count_inliers(cloud.x() + first, cloud.y() + first, cloud.z() + first, size,
                                                     {0.0F, 0.0F, 1.0F, -1.0F}, 0.01F);
    });
    benchmark::DoNotOptimize(counts.data());
  }
}

void arguments(benchmark::internal::Benchmark* bench) {
  for (const std::int64_t points : {300000, 2000000}) {
    for (const std::int64_t threads : {1, 2}) bench->Args({points, threads});
  }
  bench->UseRealTime()->Unit(benchmark::kMicrosecond);
}

BENCHMARK(count_inliers<Tbb>)->Name("tbb")->Apply(arguments);
BENCHMARK(count_inliers<PlainThreads>)->Name("plain_threads")->Apply(arguments);
#ifdef _OPENMP
BENCHMARK(count_inliers<OpenMp>)->Name("openmp")->Apply(arguments);
#endif

}  // namespace
