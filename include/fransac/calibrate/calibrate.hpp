// SPDX-License-Identifier: Apache-2.0
/// How precisely a depth camera measures and how it bends planes, from frames of large planes. docs/calibration.md has the
/// method.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "fransac/core/camera.hpp"
#include "fransac/core/depth_image.hpp"
#include "fransac/core/result.hpp"
#include "fransac/core/sensor.hpp"

namespace fransac {

/// A frame to calibrate from.
struct CalibrationFrame {
  DepthView depth;  ///< As the sensor gives it.
  Camera camera;    ///< Of its size.
};

/// How a sensor is calibrated.
struct CalibrateOptions {
  SensorKind kind = SensorKind::automatic;  ///< How it measures. `automatic`: what the law of its noise looks like.
  bool distortion = true;                   ///< Whether to look for the field that bends planes.
  double max_bend_m = 0.02;                 ///< By how much planes may be bent and still are found in one piece, metres, 0 to 1.
  double min_share = 0.03;                  ///< Smallest plane that counts, as a share of the image, above 0 to 1.
  int saturated = 65535;                    ///< Raw 16-bit value that means no measurement beside 0; 0: none.
  int threads = 1;                          ///< 0: all cores. Never changes the answer.
};

/// What pixels of planes show at one depth.
struct NoiseAtDepth {
  double z_m = 0.0;         ///< Depth, metres.
  double sigma_m = 0.0;     ///< One sigma of a pixel about the plane through its window, metres.
  std::size_t windows = 0;  ///< Windows of pixels that say so.
};

/// How planes are bent: the smooth part of their pixels' differences from the best plane, metres along the optical axis, as if
/// all were at the median depth (in inverse depth, times its square).
struct Bend {
  double rms_m = 0.0;   ///< Root mean square.
  double most_m = 0.0;  ///< What 95 % are below.
};

/// A calibration and what it stands on.
struct SensorCalibration {
  SensorOptions sensor;    ///< All numbers are set; the distortion is empty where none was found that holds for other frames.
  std::size_t frames = 0;  ///< Frames with a plane that is large enough.
  std::size_t views = 0;   ///< Of these frames such that do not see the same from the same place.
  std::size_t planes = 0;  ///< Such planes, over all frames.
  std::vector<NoiseAtDepth> noise{};  ///< By depth; what the law is fitted to.
  Bend before;                        ///< As the sensor measures.
  Bend after;  ///< Each view corrected by what the others showed; as `before` where there is no distortion.
};

/// Calibrates a sensor from frames of one camera with large planes: a wall or a floor at a few distances, or any rooms. Errors:
/// invalid_argument (a frame, its size differing from the first's, an option), no_data (no plane is large enough), out_of_memory.
/// The distortion needs at least three different views, for it is only believed if what some show corrects others.
Result<SensorCalibration> calibrate(std::span<const CalibrationFrame> frames, const CalibrateOptions& options = {});

/// Checks every range. The message names the option.
Status validate(const CalibrateOptions& options);

}  // namespace fransac
