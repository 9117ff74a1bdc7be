// SPDX-License-Identifier: Apache-2.0
/// Which way is up, and what that makes of the planes.
#pragma once

#include "fransac/planes/orientation.hpp"
#include "fransac/planes/segment.hpp"

namespace fransac {

/// `up` is a unit vector in the planes' coordinates.
inline void set_up(const Eigen::Vector3d& up, UpSource source, Segmentation& segmentation) {
  segmentation.up = up;
  segmentation.up_source = source;
  classify(up, segmentation.planes);
}

}  // namespace fransac
