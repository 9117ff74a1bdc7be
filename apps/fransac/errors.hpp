// SPDX-License-Identifier: Apache-2.0
/// How a command ends early: main() turns these into a message on stderr and an exit code.
#pragma once

#include <stdexcept>
#include <string>
#include <utility>

#include "fransac/core/result.hpp"

namespace fransac::cli {

inline constexpr int kExitDone = 0;
inline constexpr int kExitFailure = 1;  ///< An input could not be used or an output not be written.
inline constexpr int kExitUsage = 2;    ///< The command line itself is wrong.

struct Failure : std::runtime_error {
  using std::runtime_error::runtime_error;
};
/// Nothing more can be said on standard output.
struct StdoutFailure : Failure {
  using Failure::Failure;
};
struct UsageError : std::runtime_error {
  explicit UsageError(const std::string& what, std::string where_to_look = {})
      : std::runtime_error(what), hint(std::move(where_to_look)) {}
  std::string hint;  ///< A line of its own; may be empty.
};

inline void check(const Status& status) {
  if (!status) throw Failure(status.error().message);
}

template <class T>
T unwrap(Result<T> result) {
  if (!result) throw Failure(result.error().message);
  return std::move(result).value();
}

}  // namespace fransac::cli
