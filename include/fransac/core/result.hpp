// SPDX-License-Identifier: Apache-2.0
/// Errors as values: the library never prints, aborts or exits. Functions that return a Result or a Status do not throw; the
/// others can throw std::bad_alloc and nothing else.
#pragma once

#include <cassert>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <variant>

namespace fransac {

/// What kind of thing went wrong; `Error::message` says which thing.
enum class ErrorCode {
  invalid_argument,  ///< An option or a parameter is out of its range.
  io,                ///< A file could not be opened, read, written or renamed.
  format,            ///< A file's content is not what its format demands.
  no_data,           ///< The input is well formed but holds nothing to work on.
  unsupported,       ///< A feature that this build or this version does not have.
  out_of_memory,     ///< An allocation failed.
};

/// The name of a code as it stands in this header, for example "invalid_argument".
std::string_view to_string(ErrorCode code);

/// A code for programs and a message for people. The message names the file, field or option concerned.
struct Error {
  ErrorCode code = ErrorCode::invalid_argument;
  std::string message;
};

/// Either a value or an Error. Reading the wrong one is a programming error; a debug build asserts.
template <class T>
class [[nodiscard]] Result {
 public:
  Result(T value) : state_(std::in_place_index<0>, std::move(value)) {}      // NOLINT(google-explicit-constructor)
  Result(Error error) : state_(std::in_place_index<1>, std::move(error)) {}  // NOLINT(google-explicit-constructor)

  [[nodiscard]] bool ok() const { return state_.index() == 0; }
  explicit operator bool() const { return ok(); }

  [[nodiscard]] const T& value() const& {
    assert(ok());
    return *std::get_if<0>(&state_);
  }
  [[nodiscard]] T& value() & {
    assert(ok());
    return *std::get_if<0>(&state_);
  }
  [[nodiscard]] T&& value() && {
    assert(ok());
    return std::move(*std::get_if<0>(&state_));
  }
  const T& operator*() const& { return value(); }
  T& operator*() & { return value(); }
  const T* operator->() const { return &value(); }
  T* operator->() { return &value(); }

  [[nodiscard]] const Error& error() const {
    assert(!ok());
    return *std::get_if<1>(&state_);
  }

 private:
  std::variant<T, Error> state_;
};

/// Success, or an Error: the result of an operation that yields no value.
class [[nodiscard]] Status {
 public:
  Status() = default;
  Status(Error error) : error_(std::move(error)) {}  // NOLINT(google-explicit-constructor)

  [[nodiscard]] bool ok() const { return !error_.has_value(); }
  explicit operator bool() const { return ok(); }
  [[nodiscard]] const Error& error() const { return *error_; }

 private:
  std::optional<Error> error_;
};

}  // namespace fransac
