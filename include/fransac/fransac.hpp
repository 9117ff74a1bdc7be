// SPDX-License-Identifier: Apache-2.0
/// The library in one include: `auto result = fransac::segment(depth, camera);`
#pragma once

#if __cplusplus < 202002L
#error "fransac needs C++20: compile with -std=c++20, in CMake with cxx_std_20"
#endif

#include "fransac/core/camera.hpp"
#include "fransac/core/depth_image.hpp"
#include "fransac/core/labels.hpp"
#include "fransac/core/plane.hpp"
#include "fransac/core/point_cloud.hpp"
#include "fransac/core/result.hpp"
#include "fransac/planes/options.hpp"
#include "fransac/planes/segment.hpp"
#include "fransac/version.hpp"
