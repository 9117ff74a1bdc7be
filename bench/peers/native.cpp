// SPDX-License-Identifier: Apache-2.0
/// The module's only symbol: everything that is compiled for this machine's own instruction set.
#include "peer.hpp"

extern "C" __attribute__((visibility("default"))) void fransac_bench_native(fransac::bench::Party* party) {
  using namespace fransac::bench;
  add_floors(*party);
#ifdef FRANSAC_BENCH_HAS_PCL
  add_pcl_sac(*party);
  add_pcl_organized(*party);
  add_pcl_clouds(*party);
  add_pcl_clusters(*party);
#endif
#ifdef FRANSAC_BENCH_HAS_CGAL
  add_cgal(*party);
#endif
}
