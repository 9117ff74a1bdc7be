// SPDX-License-Identifier: Apache-2.0
/// Errors of files. Keeps exceptions of the standard library and of third parties inside.
#pragma once

#include <exception>
#include <filesystem>
#include <new>
#include <string>
#include <string_view>

#include "fransac/core/printable.hpp"
#include "fransac/core/result.hpp"

namespace fransac::io {

/// `FILE: WHAT`. All of the library's errors of files are made here; `what` is the library's own text, but for words that are
/// quoted_text().
inline Error file_error(ErrorCode code, std::string_view file, std::string_view what) {
  return {code, printable(file) + ": " + std::string(what)};
}
/// `FILE:LINE: WHAT`
inline Error line_error(std::string_view file, std::size_t line, std::string_view what) {
  return {ErrorCode::format, printable(file) + ":" + std::to_string(line) + ": " + std::string(what)};
}

/// `function()`, whose result is a Result or a Status; an exception becomes an Error that names `file`.
template <class Function>
auto guarded(std::string_view file, Function&& function) -> decltype(function()) {
  try {
    return function();
  } catch (const std::bad_alloc&) {
    return file_error(ErrorCode::out_of_memory, file, "not enough memory");
  } catch (const std::filesystem::filesystem_error& error) {
    return file_error(ErrorCode::io, file, error.code().message());
  } catch (const std::exception& exception) {
    return file_error(ErrorCode::io, file, exception.what());
  }
}

}  // namespace fransac::io
