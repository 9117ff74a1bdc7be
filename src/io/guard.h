// SPDX-License-Identifier: Apache-2.0
/// Errors of files. Keeps exceptions of the standard library and of third parties inside.
#pragma once

#include <exception>
#include <string>
#include <string_view>

#include "core/caught.hpp"
#include "fransac/core/printable.hpp"
#include "fransac/core/result.hpp"

namespace fransac::io {

/// `FILE: WHAT`. All of the library's errors of files are made here; `what` is the library's own text, but for words that are
/// quoted_text().
inline Error file_error(ErrorCode code, std::string_view file, std::string_view what) {
  return {code, printable(file) + ": " + std::string(what)};
}
/// The same of a file that does not hold what it should.
inline Error format_error(std::string_view file, std::string_view what) { return file_error(ErrorCode::format, file, what); }
/// `FILE:LINE: WHAT`
inline Error line_error(std::string_view file, std::size_t line, std::string_view what) {
  return {ErrorCode::format, printable(file) + ":" + std::to_string(line) + ": " + std::string(what)};
}

/// `function()`, whose result is a Result or a Status; an exception becomes an Error that names `file`.
template <class Function>
auto guarded(std::string_view file, Function&& function) -> decltype(function()) {
  try {
    return function();
  } catch (const std::exception& exception) {
    return caught(exception, [&] { return printable(file); });
  }
}

}  // namespace fransac::io
