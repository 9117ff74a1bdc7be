// SPDX-License-Identifier: Apache-2.0
/// Every number of the method `cells` that is a choice, with its reason. docs/algorithms.md derives how each is used;
/// scripts/sensitivity measures how much each matters, in a build with FRANSAC_TUNABLE.
#pragma once

#include <array>
#include <string_view>

namespace fransac::cells {

// clang-format off
/// X(name, value). Lengths in metres; factors k of a noise in standard deviations of it.
#define FRANSAC_CELLS_CONSTANTS(X)                                                                                              \
  /* Of the 64 pixels of a cell it needs half: with fewer, slopes are noise. */                                                  \
  X(least_measured, 32)                                                                                                         \
  /* Smaller cells where they know their direction, too: its noise, radians, times the noise from cell to cell. */               \
  X(fine_slope, 0.1)                                                                                                           \
  /* Pixel noise: a quantile low enough to come from flat cells in a cluttered frame. */                                        \
  X(noise_quantile, 0.30)                                                                                                       \
  /* That quantile of a flat cell's rms to sigma: 1.1 to 1.3 on Kinect v1, RealSense and rendered frames. */                    \
  X(noise_gain, 1.2)                                                                                                            \
  /* Dark or shiny surfaces are noisier than the frame, at most this often, or as noisy as a Kinect. */                         \
  X(local_noise, 2.0)                                                                                                           \
  /* Noise that no depth camera exceeds near by, metres: a short-range time-of-flight imager on a dark surface. */              \
  X(most_constant_m, 0.008)                                                                                                      \
  /* Slow noise against cell-to-cell noise: Kinect v1 and Xtion 1.2 to 2, RealSense 3 (scripts/cell-noise). */                  \
  X(slow_noise, 2.0)                                                                                                            \
  /* Bias, metres: Kinect, RealSense, Azure and Xtion bend planes nearer than 3 m by 8 to 30 mm from peak to valley. */         \
  X(bias_m, 0.010)                                                                                                              \
  /* Below this share of a Kinect's noise from cell to cell depth is rendered, and not bent. */                                 \
  X(exact_noise, 0.06)                                                                                                          \
  /* What of the bias is seen across a cell or two, and what across a border or a plane. */                                     \
  X(bias_near, 0.2) X(bias_far, 0.8)                                                                                            \
  /* What people call flat, metres. */                                                                                          \
  X(flat_m, 0.003)                                                                                                              \
  /* Standard deviations that belong to a surface: of single comparisons, and of a plane's members, which are many. */          \
  X(sigmas, 2.4) X(wide_sigmas, 4.0)                                                                                            \
  /* Depth must be known to so much, metres, to say anything of planes; to half of it, to come before what is nearer. */        \
  X(most_sigma_m, 0.20)                                                                                                         \
  /* A region with less evidence, in nats, is chance. */                                                                        \
  X(least_evidence, 36)                                                                                                         \
  /* A surface whose normal turns further for certain is curved, radians; neighbouring cells of one turn by half. */            \
  X(most_turn, 0.3)                                                                                                             \
  /* Merging across what hides them: how well one plane must foretell the other, correlation length of slow noise in cells, \
     share seen past. */                                                                                                        \
  X(far_prediction_k, 8.0) X(slow_cells, 36) X(seen_past, 0.2)
// clang-format on

struct Constants {
#define FRANSAC_CELLS_MEMBER(name, value) double name = value;
  FRANSAC_CELLS_CONSTANTS(FRANSAC_CELLS_MEMBER)
#undef FRANSAC_CELLS_MEMBER
};

inline constexpr auto kConstantNames = std::to_array<std::string_view>({
#define FRANSAC_CELLS_NAME(name, value) #name,
    FRANSAC_CELLS_CONSTANTS(FRANSAC_CELLS_NAME)
#undef FRANSAC_CELLS_NAME
});

#ifdef FRANSAC_TUNABLE
/// With the factors of the environment variable FRANSAC_CELLS_TUNE, "name=factor,name=factor".
extern const Constants kConstants;
#else
inline constexpr Constants kConstants;
#endif

/// Weights of the logistic regression that makes a plane's confidence, written by scripts/fit-confidence.
struct Confidence {
  double bias = 4.527;
  double share = 0.835;
  double turn = -0.902;
  double turn_sigma = 0.306;
  double smooth = -3.985;
};
inline constexpr Confidence kConfidence;

}  // namespace fransac::cells
