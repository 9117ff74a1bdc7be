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
  ErrorCode code = ErrorCode::invalid_argument;  ///< For programs.
  std::string message;                           ///< For people; names the file, field or option.
};

/// Either a value or an Error. Reading the wrong one is a programming error; a debug build asserts.
template <class T>
class [[nodiscard]] Result {
 public:
  /// Success.
  Result(T value) : state_(std::in_place_index<0>, std::move(value)) {}  // NOLINT(google-explicit-constructor)
  /// Failure.
  Result(Error error) : state_(std::in_place_index<1>, std::move(error)) {}  // NOLINT(google-explicit-constructor)

  [[nodiscard]] bool ok() const { return state_.index() == 0; }  ///< Whether it holds a value.
  explicit operator bool() const { return ok(); }                ///< The same.

  /// The value of a success.
  [[nodiscard]] const T& value() const& {
    assert(ok());
    return *std::get_if<0>(&state_);
  }
  /// The value of a success.
  [[nodiscard]] T& value() & {
    assert(ok());
    return *std::get_if<0>(&state_);
  }
  /// The value of a success.
  [[nodiscard]] T&& value() && {
    assert(ok());
    return std::move(*std::get_if<0>(&state_));
  }
  const T& operator*() const& { return value(); }   ///< The same as value().
  T& operator*() & { return value(); }              ///< The same as value().
  const T* operator->() const { return &value(); }  ///< A member of the value.
  T* operator->() { return &value(); }              ///< A member of the value.

  /// The error of a failure.
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
  Status() = default;  ///< Success.
  /// Failure.
  Status(Error error) : error_(std::move(error)) {}  // NOLINT(google-explicit-constructor)

  [[nodiscard]] bool ok() const { return !error_.has_value(); }  ///< Whether it is a success.
  explicit operator bool() const { return ok(); }                ///< The same.
  [[nodiscard]] const Error& error() const { return *error_; }   ///< Of a failure.

 private:
  std::optional<Error> error_;
};

}  // namespace fransac
