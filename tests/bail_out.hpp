// SPDX-License-Identifier: Apache-2.0
/// What a score must be that may be given up.
#pragma once

#include <gtest/gtest.h>

#include <initializer_list>

#include "fransac/sac/plane_problem.hpp"

namespace fransac::testing {

/// Scores `plane` against bars lower and higher than its full score: exact above the bar, else no higher than the bar. Returns
/// how often scoring was given up early.
template <class Data>
int expect_bail_out_is_fair(const Data& data, const Plane& plane, float threshold, sac::Scoring scoring,
                            std::initializer_list<double> bars) {
  const sac::Score full = data.score(plane, threshold, scoring, {-1.0, 0});
  int early = 0;
  const auto expect_fair = [&](double to_beat) {
    const sac::Score score = data.score(plane, threshold, scoring, {to_beat, 0});
    if (full.value > to_beat) {
      EXPECT_EQ(score.value, full.value);
      EXPECT_EQ(score.inliers, full.inliers);
    } else {
      EXPECT_LE(score.value, to_beat);
      early += static_cast<int>(score.value < full.value);
    }
  };
  for (const double bar : bars) expect_fair(bar);
  expect_fair(full.value);
  return early;
}

}  // namespace fransac::testing
