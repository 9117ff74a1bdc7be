// SPDX-License-Identifier: Apache-2.0
/// PCL's RANSAC as all who use it here set it up.
#pragma once

#include <pcl/point_types.h>
#include <pcl/segmentation/sac_segmentation.h>

#include "peer.hpp"

namespace fransac::bench {

/// One plane by RANSAC, refined from its inliers, with everybody's parameters.
inline void prepare(pcl::SACSegmentation<pcl::PointXYZ>& ransac) {
  ransac.setModelType(pcl::SACMODEL_PLANE);
  ransac.setMethodType(pcl::SAC_RANSAC);
  ransac.setDistanceThreshold(kThreshold_m);
  ransac.setProbability(kProbability);
  ransac.setMaxIterations(kMaxIterations);
  ransac.setOptimizeCoefficients(true);
}

}  // namespace fransac::bench
