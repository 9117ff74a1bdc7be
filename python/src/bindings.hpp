// SPDX-License-Identifier: Apache-2.0
// The parts of the module.
#pragma once

#include <nanobind/nanobind.h>

namespace fransac::python {

void bind_camera(nanobind::module_& m);
void bind_segmentation(nanobind::module_& m);
void bind_points(nanobind::module_& m);
void bind_tracker(nanobind::module_& m);
void bind_evaluation(nanobind::module_& m);
void bind_frames(nanobind::module_& m);

}  // namespace fransac::python
