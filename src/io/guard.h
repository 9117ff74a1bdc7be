// SPDX-License-Identifier: Apache-2.0
/// Keeps exceptions of the standard library and of third parties inside.
#pragma once

#include <exception>
#include <string_view>

#include "core/caught.hpp"
#include "fransac/core/result.hpp"

namespace fransac::io {

/// `function()`, whose result is a Result or a Status; an exception becomes an Error that names `name`.
template <class Function>
auto guarded(std::string_view name, Function&& function) -> decltype(function()) {
  try {
    return function();
  } catch (const std::exception& exception) {
    return caught(exception, name);
  }
}

}  // namespace fransac::io
