// SPDX-License-Identifier: Apache-2.0
#include "io/json.h"

#include <algorithm>
#include <cmath>
#include <set>

#include "fransac/core/labels.hpp"
#include "io/guard.h"

namespace fransac::io {
namespace {

constexpr std::size_t kFieldBytes = 64;  // of names in messages

std::string line_of(std::string_view text, std::size_t byte) {
  const std::string_view before = text.substr(0, std::min(byte, text.size()));
  return "line " + std::to_string(1 + std::count(before.begin(), before.end(), '\n'));
}

}  // namespace

Error field_error(const std::string& name, std::string_view field, std::string_view what) {
  return file_error(ErrorCode::format, name, "field \"" + printable(field, kFieldBytes) + "\" " + std::string(what));
}

Result<nlohmann::json> parse_json_object(std::string_view text, const std::string& name) {
  using nlohmann::json;
  std::set<std::string> fields;
  std::string last_field;
  std::optional<std::string> repeated;
  const auto watch = [&](int depth, json::parse_event_t event, json& parsed) {
    if (depth == 1 && event == json::parse_event_t::key) {
      last_field = parsed.get<std::string>();
      if (!fields.insert(last_field).second && !repeated) repeated = last_field;
    }
    return true;
  };
  try {
    json value = json::parse(text.begin(), text.end(), watch);
    if (!value.is_object()) return file_error(ErrorCode::format, name, "is not a JSON object");
    if (repeated) return field_error(name, *repeated, "appears twice");
    return value;
  } catch (const json::parse_error& error) {
    const std::string where = last_field.empty() ? "" : ", at or after field \"" + printable(last_field, kFieldBytes) + "\"";
    return file_error(ErrorCode::format, name, "not valid JSON in " + line_of(text, error.byte) + where);
  } catch (const json::exception&) {  // a number beyond double
    return field_error(name, last_field, "holds a number that is out of range");
  }
}

Result<double> number_field(const nlohmann::json& object, const char* field, const std::string& label, const std::string& name) {
  const auto found = object.find(field);
  if (found == object.end()) return field_error(name, label, "is missing");
  if (!found->is_number()) return field_error(name, label, std::string("must be a number, not ") + found->type_name());
  return found->get<double>();
}

Result<int> whole_field(const nlohmann::json& object, const char* field, const std::string& label, int max,
                        const std::string& name) {
  const Result<double> value = number_field(object, field, label, name);
  if (!value) return value.error();
  if (*value != std::trunc(*value)) return field_error(name, label, "must be a whole number");
  return static_cast<int>(std::clamp(*value, 0.0, max + 1.0));
}

Result<int> label_field(const nlohmann::json& object, const char* field, const std::string& label, const std::string& name) {
  Result<int> value = whole_field(object, field, label, kMaxPlanes, name);
  if (value && (*value < kLabelFirst || *value > kMaxPlanes)) return field_error(name, label, "must be between 1 and 254");
  return value;
}

std::string to_text(const nlohmann::ordered_json& value) { return value.dump(1) + "\n"; }

}  // namespace fransac::io
