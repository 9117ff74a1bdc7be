// SPDX-License-Identifier: Apache-2.0
/// Exceptions as errors, at the boundary of every public function that returns a Result or a Status.
#pragma once

#include <exception>
#include <new>
#include <stdexcept>
#include <string>
#include <string_view>
#include <system_error>
#include <type_traits>

#include "fransac/core/result.hpp"

namespace fransac {

/// What an exception says of `what`: a text, or a function that makes one. Never throws: where there is no memory for the
/// message, a shorter one is given that needs none.
template <class What>
Error caught(const std::exception& exception, const What& what) {
  const bool no_memory = dynamic_cast<const std::bad_alloc*>(&exception) != nullptr ||
                         dynamic_cast<const std::length_error*>(&exception) != nullptr;  // more than a container can hold
  try {
    std::string message;
    if constexpr (std::is_invocable_v<What>) {
      message = what();
    } else {
      message = std::string_view(what);
    }
    message += ": ";
    const auto* const of_system = dynamic_cast<const std::system_error*>(&exception);  // whose what() repeats names as they are
    message += no_memory ? "not enough memory" : of_system != nullptr ? of_system->code().message() : exception.what();
    return {no_memory ? ErrorCode::out_of_memory : ErrorCode::io, std::move(message)};
  } catch (const std::exception&) {
    return {ErrorCode::out_of_memory, "no memory"};
  }
}

}  // namespace fransac
