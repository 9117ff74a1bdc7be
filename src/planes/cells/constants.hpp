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
  /* Half a cell: with fewer pixels slopes are noise. */                                                                        \
  X(least_measured, 32)                                                                                                         \
  /* Noise: quantiles low enough to come from flat cells in a cluttered frame. */                                               \
  X(noise_quantile, 0.30)                                                                                                       \
  /* 30 % quantile of a flat cell's rms to sigma, measured on Kinect v1, RealSense and rendered frames: 1.1 to 1.3. */          \
  X(noise_gain, 1.2)                                                                                                            \
  /* Dark or shiny surfaces are noisier than the frame, at most this often. */                                                  \
  X(local_noise, 2.0)                                                                                                           \
  /* Slow errors (lens, disparity waves) against cell-to-cell noise: Kinect v1 and Xtion 1.2 to 2, RealSense 3. */              \
  X(slow_noise, 2.0)                                                                                                            \
  /* Kinect v1 bends planes by 1 to 2 cm at the image's border; scaled with the noise for other sensors, but not below. */      \
  X(bias_m, 0.010) X(least_bias_scale, 0.05) X(exact_noise, 0.03) X(most_constant_m, 0.01) X(local_constant_m, 0.002)                                                                                    \
  /* What people call flat. */                                                                                                  \
  X(flat_m, 0.003) X(flat_in_cell_m, 0.001)                                                                                     \
  /* Usable cells: residual within noise, depth known to 20 cm. */                                                              \
  X(usable_k, 2.0) X(usable_m, 0.002) X(most_sigma_m, 0.20)                                                                     \
  /* Neighbouring cells are linked without a jump and without a bend. */                                                        \
  X(jump_k, 2.5) X(jump_m, 0.002) X(bend_k, 2.0) X(bend_m, 0.001)                                                               \
  /* Regions: tolerance of a member; how many times further than its cells a plane is trusted. */                               \
  X(grow_k, 4.0) X(grow_reach, 2.0)                                                                                             \
  X(least_cells, 9) X(least_cells_of_small_seed, 5)                                                                             \
  /* A region with less evidence, in nats, is no plane by itself. */                                                             \
  X(least_evidence, 36) X(final_evidence, 60) X(most_turn, 0.3)                                                                                                         \
  /* With this share of it, a region may be a piece of a plane that is evident elsewhere. */                                    \
  X(piece_share, 0.5)                                                                                                           \
  /* Curved: a radius below this, by two sigma, and a sag that is more than noise. */                                           \
  X(curved_radius_m, 0.7) X(curved_wide, 2.0) X(curved_k, 0.35) X(curved_m, 0.002) X(curved_noise, 0.6)                                             \
  /* A patch of a curved surface: so much of its border goes on smoothly, bending by less than about ten degrees. */           \
  X(smooth_share, 0.45) X(slight_bend, 0.17)                                                                                     \
  /* Merging neighbours without a jump; the wider one where the surface is smooth. */                                           \
  X(fine_slope, 0.05) X(step_m, 0.008) X(joined_share, 0.48) X(near_k, 3.5) X(near_m, 0.002) X(near_smooth_m, 0.012)                                                                       \
  /* Merging across what hides them: residual, prediction, correlation length of slow errors in cells, share seen past. */      \
  X(far_k, 2.5) X(far_m, 0.002) X(far_prediction_k, 8.0) X(slow_cells, 36) X(seen_past, 0.2)                                    \
  /* By area: what is known to 5 cm comes before what is not. */                                                                \
  X(sure_m, 0.10)                                                                                                               \
  /* Pixels. */                                                                                                                 \
  X(pixel_k, 2.2) X(pixel_m, 0.008) X(flood_share, 0.5) X(flood_k, 1.5)
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
  double bias = 4.482;
  double share = 0.929;
  double turn = -1.048;
  double turn_sigma = 0.372;
  double smooth = -4.855;
};
inline constexpr Confidence kConfidence;

}  // namespace fransac::cells
