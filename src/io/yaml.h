// SPDX-License-Identifier: Apache-2.0
/// YAML files as the values that JSON has.
#pragma once

#include <string>
#include <string_view>

#include "fransac/core/result.hpp"
#include "io/json.h"

namespace fransac::io {

/// Parses the first document of a YAML text, a mapping; OpenCV's header "%YAML:1.0" is taken as well. Plain words that are finite
/// numbers become numbers, other scalars strings; tags are ignored. A field of the outermost mapping that appears twice is an
/// error; so are aliases, keys that are no scalars, and nesting deeper than in any of our files. May throw std::bad_alloc.
Result<Json> parse_yaml_object(std::string_view text, const std::string& name);

}  // namespace fransac::io
