// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <cstddef>

#include "fransac/planes/segment.hpp"

namespace fransac {

/// Writes down how long each stage takes.
class StageClock {
 public:
  explicit StageClock(Timing& timing) : timing_(timing) {}
  /// What was done since the last stage or the start was this one.
  void end(Stage stage) {
    const auto now = Clock::now();
    timing_.stage_ms[static_cast<std::size_t>(stage)] = milliseconds(last_, now);
    timing_.total_ms = milliseconds(start_, now);
    last_ = now;
  }

 private:
  using Clock = std::chrono::steady_clock;
  static double milliseconds(Clock::time_point from, Clock::time_point to) {
    return std::chrono::duration<double, std::milli>(to - from).count();
  }
  Timing& timing_;
  Clock::time_point start_ = Clock::now();
  Clock::time_point last_ = start_;
};

}  // namespace fransac
