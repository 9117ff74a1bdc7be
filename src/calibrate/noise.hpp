// SPDX-License-Identifier: Apache-2.0
/// The law of the pixel noise, and slow noise.
#pragma once

#include <functional>
#include <span>
#include <vector>

#include "calibrate/windows.hpp"
#include "fransac/calibrate/calibrate.hpp"

namespace fransac::calibration {

/// The pixel noise of windows by depth, in bins whose borders have a constant ratio; bins with few windows are left out.
std::vector<NoiseAtDepth> noise_by_depth(std::span<const PlaneWindows> planes);

/// The law that fits best, by non-negative least squares of variances relative to what was measured. Where depths are too much
/// alike to tell its terms apart, one term says it all: the linear one of time of flight, else the quadratic one.
DepthNoise fit_law(std::span<const NoiseAtDepth> noise, SensorKind kind);

/// One sigma of what windows some way apart differ by, as a share of the pixel noise `law`, after correction.
double slow_share(std::span<const PlaneWindows> planes, const Distortion& distortion, const DepthNoise& law);

/// The middle one of some numbers, which it reorders; 0 of none.
double median(std::vector<double>& values);

}  // namespace fransac::calibration
