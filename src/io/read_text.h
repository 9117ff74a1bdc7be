// SPDX-License-Identifier: Apache-2.0
/// Text files as what a parser makes of them.
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "fransac/core/result.hpp"
#include "fransac/io/file.hpp"
#include "io/text.h"

namespace fransac::io {

/// `parse(text, name)` of a file of at most `max_bytes`, whose name stands in messages. May throw std::bad_alloc.
template <class Value>
Result<Value> read_text(const std::filesystem::path& file, std::size_t max_bytes,
                        Result<Value> (*parse)(std::string_view, const std::string&)) {
  const Result<std::vector<std::byte>> bytes = read_file(file, max_bytes);
  if (!bytes) return bytes.error();
  return parse(as_text(*bytes), file.string());
}

}  // namespace fransac::io
