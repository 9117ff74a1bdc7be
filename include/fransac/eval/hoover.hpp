// SPDX-License-Identifier: Apache-2.0
/// Regions compared as range images have been since 1996: A. Hoover, G. Jean-Baptiste, X. Jiang, P. J. Flynn, H. Bunke,
/// D. B. Goldgof, K. Bowyer, D. W. Eggert, A. Fitzgibbon, R. B. Fisher, "An Experimental Comparison of Range Image Segmentation
/// Algorithms", IEEE Transactions on Pattern Analysis and Machine Intelligence 18(7), 1996, section 4.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "fransac/core/result.hpp"

namespace fransac::eval {

/// What the values of an image of true regions mean.
enum class TrueRegions {
  labels,   ///< Labels: 1 to 254 are regions, 255 is none, 0 is not judged.
  segcomp,  ///< The images of Hoover et al.: values from 10 on are regions; the rest is none, and all of it is judged.
};

/// How regions are made of predicted labels.
struct HooverOptions {
  TrueRegions truth = TrueRegions::labels;  ///< What the truth's values mean.
  int min_pixels = 50;                      ///< Predicted parts with fewer pixels are left out; at least 1.
};

/// How many regions are what. Each true and each predicted region is counted in one class at most: where two classes claim it,
/// the one with the larger mean overlap has it, of equals in the order of this list.
struct HooverMetrics {
  double tolerance = 0.0;  ///< Least share of a region's pixels that an overlap must hold.
  int true_regions = 0;    ///< Of the truth.
  int predicted = 0;       ///< Predicted regions that count.
  int correct = 0;         ///< Pairs that hold the tolerance of each other.
  int over_segmented =
      0;  ///< True regions that two or more predicted ones, each by the tolerance within it, cover by the tolerance.
  int under_segmented = 0;  ///< The same, turned round: predicted regions in place of two or more true ones.
  int missed = 0;           ///< True regions in none of these.
  int noise = 0;            ///< Predicted regions in none of these.
};

/// The tolerance at which results are given most often.
inline constexpr double kHooverTolerance = 0.8;

/// Classifies regions at one tolerance, above 0.5 and up to 1. `truth` and `predicted` are images of `width` columns, row by row;
/// the prediction holds labels: 1 to 254 are planes. Each is split into its 8-connected parts, which are the predicted regions,
/// as the paper has it: two faces in one plane are two regions. Where the truth is not judged, pixels count for no region, and a
/// part that has most of its pixels there is no noise. Errors: invalid_argument when sizes, `width`, `tolerance` or an option do
/// not fit; out_of_memory.
Result<HooverMetrics> hoover(std::span<const std::uint8_t> truth, std::span<const std::uint8_t> predicted, int width,
                             double tolerance = kHooverTolerance, const HooverOptions& options = {});

/// The same at several tolerances, in their order: the curves of the paper.
Result<std::vector<HooverMetrics>> hoover(std::span<const std::uint8_t> truth, std::span<const std::uint8_t> predicted, int width,
                                          std::span<const double> tolerances, const HooverOptions& options = {});

}  // namespace fransac::eval
