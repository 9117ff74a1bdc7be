// SPDX-License-Identifier: Apache-2.0
#include "io/json.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <set>

#include "fransac/core/labels.hpp"
#include "io/guard.h"

namespace fransac::io {
namespace {

constexpr std::size_t kFieldBytes = 64;  // of names in messages
constexpr std::size_t kMaxDepth = 64;

std::string line_of(std::string_view text, std::size_t byte) {
  const std::string_view before = text.substr(0, std::min(byte, text.size()));
  return "line " + std::to_string(1 + std::count(before.begin(), before.end(), '\n'));
}

/// Makes a Json of what nlohmann's reader calls out.
class JsonBuilder : public nlohmann::json_sax<nlohmann::json> {
 public:
  Json value;
  std::string last_field;               ///< Of the outermost object.
  std::optional<std::string> repeated;  ///< Likewise.
  bool too_deep = false;
  bool out_of_range = false;  ///< A number is.
  std::size_t fault = 0;      ///< Byte at which the text is no JSON.

  bool null() override { return add(nullptr); }
  bool boolean(bool read) override { return add(read); }
  bool number_integer(std::int64_t read) override { return add(static_cast<double>(read)); }
  bool number_unsigned(std::uint64_t read) override { return add(static_cast<double>(read)); }
  bool number_float(double read, const std::string& /*text*/) override { return add(read); }
  bool string(std::string& read) override { return add(std::move(read)); }
  bool binary(nlohmann::json::binary_t& /*read*/) override { return false; }
  bool start_object(std::size_t /*size*/) override { return open(Json::Fields{}); }
  bool start_array(std::size_t /*size*/) override { return open(Json::Array{}); }
  bool end_object() override { return close(); }
  bool end_array() override { return close(); }
  bool key(std::string& name) override {
    if (open_.size() == 1) {
      last_field = name;
      if (!fields_.insert(name).second && !repeated) repeated = name;
    }
    open_.back().first = std::move(name);
    return true;
  }
  bool parse_error(std::size_t position, const std::string& /*token*/, const nlohmann::json::exception& error) override {
    fault = position;
    out_of_range = dynamic_cast<const nlohmann::json::out_of_range*>(&error) != nullptr;
    return false;
  }

 private:
  bool add(Json read) {
    if (open_.empty()) {
      value = std::move(read);
    } else if (auto& [field, container] = open_.back(); container.elements() != nullptr) {
      container.add(std::move(read));
    } else {
      container.add(std::move(field), std::move(read));
    }
    return true;
  }
  bool open(Json container) {
    too_deep = open_.size() == kMaxDepth;
    if (!too_deep) open_.emplace_back(std::string(), std::move(container));
    return !too_deep;
  }
  bool close() {
    Json container = std::move(open_.back().second);
    open_.pop_back();
    return add(std::move(container));
  }

  /// Arrays and objects that have begun, each with the name of the field that comes next.
  std::vector<std::pair<std::string, Json>> open_;
  std::set<std::string> fields_;
};

}  // namespace

std::optional<double> Json::number() const {
  if (const auto* const whole = std::get_if<std::int64_t>(&value_)) return static_cast<double>(*whole);
  const auto* const real = std::get_if<double>(&value_);
  return real != nullptr ? std::optional(*real) : std::nullopt;
}

const char* Json::type_name() const {
  constexpr const char* kNames[] = {"null", "boolean", "number", "number", "string", "array", "object"};
  return kNames[value_.index()];
}

const Json* Json::find(std::string_view field) const {
  const Fields* const all = fields();
  if (all == nullptr) return nullptr;
  const auto found = std::find_if(all->rbegin(), all->rend(), [&](const auto& entry) { return entry.first == field; });
  return found == all->rend() ? nullptr : &found->second;
}

void Json::add(std::string field, Json value) { std::get<Fields>(value_).emplace_back(std::move(field), std::move(value)); }

std::string Json::text() const {
  std::string text;
  append_to(text, 0);
  return text + "\n";
}

void Json::append_to(std::string& text, std::size_t depth) const {
  const auto leaf = [&](const auto& value) { text += nlohmann::json(value).dump(); };
  const auto list = [&](char begin, const auto& entries, char end, const auto& append) {
    text += begin;
    for (std::size_t i = 0; i < entries.size(); ++i) {
      text += i == 0 ? "\n" : ",\n";
      text.append(depth + 1, ' ');
      append(entries[i]);
    }
    if (!entries.empty()) text.append(1, '\n').append(depth, ' ');
    text += end;
  };
  if (const Array* const all = elements()) {
    list('[', *all, ']', [&](const Json& element) { element.append_to(text, depth + 1); });
  } else if (const Fields* const named = fields()) {
    list('{', *named, '}', [&](const auto& field) {
      leaf(field.first);
      text += ": ";
      field.second.append_to(text, depth + 1);
    });
  } else if (const std::string* const words = string()) {
    leaf(*words);
  } else if (const auto* const whole = std::get_if<std::int64_t>(&value_)) {
    leaf(*whole);
  } else if (const auto* const real = std::get_if<double>(&value_)) {
    leaf(*real);
  } else if (const bool* const truth = std::get_if<bool>(&value_)) {
    leaf(*truth);
  } else {
    text += "null";
  }
}

Error field_error(const std::string& name, std::string_view field, std::string_view what) {
  return file_error(ErrorCode::format, name, "field \"" + printable(field, kFieldBytes) + "\" " + std::string(what));
}

Result<Json> parse_json_object(std::string_view text, const std::string& name) {
  JsonBuilder builder;
  if (!nlohmann::json::sax_parse(text.begin(), text.end(), &builder)) {
    if (builder.out_of_range) return field_error(name, builder.last_field, "holds a number that is out of range");
    if (builder.too_deep) return file_error(ErrorCode::format, name, "nests deeper than " + std::to_string(kMaxDepth));
    const std::string where =
        builder.last_field.empty() ? "" : ", at or after field \"" + printable(builder.last_field, kFieldBytes) + "\"";
    return file_error(ErrorCode::format, name, "not valid JSON in " + line_of(text, builder.fault) + where);
  }
  if (builder.value.fields() == nullptr) return file_error(ErrorCode::format, name, "is not a JSON object");
  if (builder.repeated) return field_error(name, *builder.repeated, "appears twice");
  return std::move(builder.value);
}

Result<double> number_field(const Json& object, const char* field, const std::string& label, const std::string& name) {
  const Json* const found = object.find(field);
  if (found == nullptr) return field_error(name, label, "is missing");
  const std::optional<double> number = found->number();
  if (!number) return field_error(name, label, std::string("must be a number, not ") + found->type_name());
  return *number;
}

Result<int> whole_field(const Json& object, const char* field, const std::string& label, int max, const std::string& name) {
  const Result<double> value = number_field(object, field, label, name);
  if (!value) return value.error();
  if (*value != std::trunc(*value)) return field_error(name, label, "must be a whole number");
  return static_cast<int>(std::clamp(*value, 0.0, max + 1.0));
}

Result<int> label_field(const Json& object, const char* field, const std::string& label, const std::string& name) {
  Result<int> value = whole_field(object, field, label, kMaxPlanes, name);
  if (value && (*value < kLabelFirst || *value > kMaxPlanes)) return field_error(name, label, "must be between 1 and 254");
  return value;
}

}  // namespace fransac::io
