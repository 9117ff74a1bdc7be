// SPDX-License-Identifier: Apache-2.0
/// Text from outside as it may stand in a message or a table.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace fransac {

/// A name from outside on one line: of bytes that are no printable UTF-8 (line ends, escape codes, marks that turn the direction
/// of text) the numbers are written, in C's hexadecimal way, and of a text of more than `max_bytes` the middle is left out ("…").
/// May throw std::bad_alloc.
std::string printable(std::string_view text, std::size_t max_bytes = 1024);
/// A word of a file, the same in single quotes and short.
std::string quoted_text(std::string_view text);

}  // namespace fransac
