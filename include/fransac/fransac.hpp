// SPDX-License-Identifier: Apache-2.0
/// The library in one include: `auto result = fransac::segment(depth, camera);`
#pragma once

#include "fransac/core/camera.hpp"
#include "fransac/core/depth_image.hpp"
#include "fransac/core/labels.hpp"
#include "fransac/core/plane.hpp"
#include "fransac/core/point_cloud.hpp"
#include "fransac/core/result.hpp"
#include "fransac/planes/options.hpp"
#include "fransac/planes/segment.hpp"
#include "fransac/version.hpp"
