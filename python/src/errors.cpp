// SPDX-License-Identifier: Apache-2.0
#include "errors.hpp"

#include "options.hpp"

namespace fransac::python {

void raise_type_error(const std::string& message) { throw nb::type_error(message.c_str()); }

void raise_value_error(const std::string& message) { throw nb::value_error(message.c_str()); }

void raise(const Error& error) {
  const std::string message = in_python_names(error.message);
  switch (error.code) {
    case ErrorCode::no_data: throw NoData(message);
    case ErrorCode::out_of_memory: PyErr_SetString(PyExc_MemoryError, message.c_str()); throw nb::python_error();
    case ErrorCode::io: PyErr_SetString(PyExc_OSError, message.c_str()); throw nb::python_error();
    case ErrorCode::invalid_argument:
    case ErrorCode::format:
    case ErrorCode::unsupported: break;
  }
  raise_value_error(message);
}

}  // namespace fransac::python
