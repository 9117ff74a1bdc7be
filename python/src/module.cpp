// SPDX-License-Identifier: Apache-2.0
#include <nanobind/nanobind.h>
#include <nanobind/stl/string.h>

#include <string>

#include "bindings.hpp"
#include "errors.hpp"
#include "fransac/planes/segment.hpp"
#include "fransac/version.hpp"

NB_MODULE(_core, m) {
  using namespace fransac::python;
  m.doc() = "Planes and obstacles in depth frames and point clouds: the compiled part of fransac.";
  nb::exception<NoData>(m, "NoDataError", PyExc_ValueError).attr("__doc__") = "Nothing was measured, or too little for a plane.";
  bind_camera(m);
  bind_segmentation(m);
  bind_points(m);
  bind_tracker(m);
  bind_evaluation(m);
  bind_frames(m);
  m.def(
      "instruction_set", [] { return std::string(fransac::instruction_set()); },
      "The instruction set that runs on this machine: 'AVX2', 'SSE4', 'NEON', 'SCALAR', ...");
  m.attr("version") = fransac::kVersion;
#if defined(__clang__)
  m.attr("compiler") = __VERSION__;
#else
  m.attr("compiler") = "GCC " __VERSION__;
#endif
}
