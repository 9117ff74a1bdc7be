// SPDX-License-Identifier: Apache-2.0
// From the library's errors, which are values, to Python's exceptions.
#pragma once

#include <nanobind/nanobind.h>

#include <stdexcept>
#include <string>
#include <utility>

#include "fransac/core/result.hpp"

namespace fransac::python {

namespace nb = nanobind;

/// Python's NoDataError, a ValueError: the input is well formed but holds nothing to work on.
struct NoData : std::runtime_error {
  using std::runtime_error::runtime_error;
};

[[noreturn]] void raise_type_error(const std::string& message);
[[noreturn]] void raise_value_error(const std::string& message);
/// The exception for an error's code: ValueError, NoDataError, OSError or MemoryError. Names of options are Python's.
[[noreturn]] void raise(const Error& error);

inline void check(const Status& status) {
  if (!status) raise(status.error());
}

template <class T>
T unwrap(Result<T> result) {
  if (!result) raise(result.error());
  return std::move(result).value();
}

/// What `work` makes while other threads of Python run; `work` must not touch Python.
template <class Work>
auto without_gil(const Work& work) {
  const nb::gil_scoped_release release;
  return work();
}

}  // namespace fransac::python
