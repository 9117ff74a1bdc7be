// SPDX-License-Identifier: Apache-2.0
// Cameras as Python gives them.
#pragma once

#include <nanobind/nanobind.h>

#include "errors.hpp"
#include "fransac/core/camera.hpp"

namespace fransac::python {

/// A Camera, a dict of its fields, the path of a camera's file, or a name of tum_camera. What names no size has that of the
/// image, `width` x `height`.
Camera read_camera(nb::handle given, int width, int height);

/// fx, fy, cx, cy and depth_scale out of keyword arguments, of which `used` counts them. `function` stands in messages.
Camera read_camera_keywords(const char* function, const nb::dict& kwargs, int width, int height, std::size_t& used);

inline constexpr const char* kCameraKeywords[] = {"fx", "fy", "cx", "cy", "depth_scale"};

#define FRANSAC_CAMERA "Camera | collections.abc.Mapping[str, float] | str | os.PathLike[str]"

}  // namespace fransac::python
