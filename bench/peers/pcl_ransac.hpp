// SPDX-License-Identifier: Apache-2.0
/// PCL's RANSAC, and what stands in its place, as all who use it here set it up.
#pragma once

#include <pcl/sample_consensus/method_types.h>
#include <pcl/sample_consensus/model_types.h>

#include "peer.hpp"

namespace fransac::bench {

/// One plane by RANSAC, refined from its inliers, with everybody's parameters.
template <class Segmentation>
void prepare(Segmentation& ransac) {
  ransac.setModelType(::pcl::SACMODEL_PLANE);
  ransac.setMethodType(::pcl::SAC_RANSAC);
  ransac.setDistanceThreshold(kThreshold_m);
  ransac.setProbability(kProbability);
  ransac.setMaxIterations(kMaxIterations);
  ransac.setOptimizeCoefficients(true);
}

}  // namespace fransac::bench
