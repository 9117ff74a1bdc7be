// SPDX-License-Identifier: Apache-2.0
/// JSON files with errors that name the file and the field.
#pragma once

#include <nlohmann/json.hpp>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "fransac/core/result.hpp"

namespace fransac::io {

/// A format error about a field: `NAME: field "FIELD" WHAT`.
Error field_error(const std::string& name, std::string_view field, std::string_view what);

/// Parses one JSON object and nothing after it; `name` stands for the file in messages. A field of the outermost object
/// that appears twice is an error. May throw std::bad_alloc.
Result<nlohmann::json> parse_json_object(std::string_view text, const std::string& name);

/// The number in a required field; `field` is looked up, `label` names it in messages.
Result<double> number_field(const nlohmann::json& object, const char* field, const std::string& label, const std::string& name);
/// The same for a number of at most `max` that must be whole. Values outside [0, max] become 0 or max + 1.
Result<int> whole_field(const nlohmann::json& object, const char* field, const std::string& label, int max,
                        const std::string& name);
/// The same for a plane's label, 1 to 254.
Result<int> label_field(const nlohmann::json& object, const char* field, const std::string& label, const std::string& name);

/// Text with a final newline. Throws when a string in it is not UTF-8.
std::string to_text(const nlohmann::ordered_json& value);

}  // namespace fransac::io
