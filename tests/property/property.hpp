// SPDX-License-Identifier: Apache-2.0
/// RapidCheck with a seed that follows from the test's name.
#pragma once

#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <sstream>
#include <utility>

#include "support.hpp"

namespace fransac::testing {

/// Tries `property` on `runs` random inputs; a failure prints the smallest input found.
template <class Property>
void check_property(int runs, Property&& property) {
  rc::detail::TestParams params;
  params.seed = seed_of_test();
  params.maxSuccess = runs;
  rc::detail::TestMetadata metadata;
  metadata.id = ::testing::UnitTest::GetInstance()->current_test_info()->name();
  metadata.description = metadata.id;
  const rc::detail::TestResult result = rc::detail::checkTestable(std::forward<Property>(property), metadata, params);
  if (result.is<rc::detail::SuccessResult>()) return;
  std::ostringstream text;
  rc::detail::printResultMessage(result, text);
  FAIL() << text.str();
}

/// A number from a range, on a grid of a million steps.
inline double any_number(double low, double high) {
  constexpr int kSteps = 1000000;
  return low + (high - low) * *rc::gen::inRange(0, kSteps + 1) / kSteps;
}

/// A stream of random numbers that is itself a random choice: for inputs too large to be worth shrinking.
inline RandomStream any_stream() { return {*rc::gen::arbitrary<std::uint64_t>(), 0}; }

}  // namespace fransac::testing
