// SPDX-License-Identifier: Apache-2.0
/// Keeps exceptions of the standard library and of third parties inside.
#pragma once

#include <exception>
#include <new>
#include <string>
#include <string_view>

#include "fransac/core/result.hpp"

namespace fransac::io {

/// `function()`, whose result is a Result or a Status; an exception becomes an Error that names `name`.
template <class Function>
auto guarded(std::string_view name, Function&& function) -> decltype(function()) {
  try {
    return function();
  } catch (const std::bad_alloc&) {
    return Error{ErrorCode::out_of_memory, std::string(name) + ": not enough memory"};
  } catch (const std::exception& exception) {
    return Error{ErrorCode::io, std::string(name) + ": " + exception.what()};
  }
}

}  // namespace fransac::io
