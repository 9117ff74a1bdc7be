// SPDX-License-Identifier: Apache-2.0
/// JSON files with errors that name the file and the field.
#pragma once

#include <concepts>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

#include "fransac/core/result.hpp"

namespace fransac::io {

/// A JSON value; fields keep their order. nlohmann's own takes memory in its destructor, which ends the program where there is
/// none; it reads and writes single values here.
class Json {
 public:
  using Array = std::vector<Json>;
  using Fields = std::vector<std::pair<std::string, Json>>;

  Json() = default;                                        ///< null
  Json(std::nullptr_t) {}                                  // NOLINT(google-explicit-constructor)
  Json(bool value) : value_(value) {}                      // NOLINT(google-explicit-constructor)
  Json(double value) : value_(value) {}                    // NOLINT(google-explicit-constructor)
  Json(std::string value) : value_(std::move(value)) {}    // NOLINT(google-explicit-constructor)
  Json(const char* value) : value_(std::string(value)) {}  // NOLINT(google-explicit-constructor)
  Json(Array value) : value_(std::move(value)) {}          // NOLINT(google-explicit-constructor)
  Json(Fields value) : value_(std::move(value)) {}         // NOLINT(google-explicit-constructor)
  template <std::integral T>
  Json(T value) : value_(static_cast<std::int64_t>(value)) {}  // NOLINT(google-explicit-constructor)
  template <class T>
  Json(const std::optional<T>& value) {  // NOLINT(google-explicit-constructor)
    if (value) *this = Json(*value);
  }

  /// An object of fields, each a name and a value. (GCC 12 destroys parts of braced lists twice when memory runs out in them.)
  template <class... Parts>
  static Json object(Parts&&... parts) {
    Json json(Fields{});
    json.add_fields(std::forward<Parts>(parts)...);
    return json;
  }
  template <class... Elements>
  static Json array(Elements&&... elements) {
    Json json(Array{});
    (json.add(Json(std::forward<Elements>(elements))), ...);
    return json;
  }

  /// Null for what the value is not.
  [[nodiscard]] const std::string* string() const { return std::get_if<std::string>(&value_); }
  [[nodiscard]] const Array* elements() const { return std::get_if<Array>(&value_); }
  [[nodiscard]] const Fields* fields() const { return std::get_if<Fields>(&value_); }
  [[nodiscard]] std::optional<double> number() const;
  [[nodiscard]] bool is_null() const { return std::holds_alternative<std::nullptr_t>(value_); }
  /// "null", "boolean", "number", "string", "array" or "object".
  [[nodiscard]] const char* type_name() const;

  /// An object's field; null where it has none of that name.
  [[nodiscard]] const Json* find(std::string_view field) const;
  /// Adds a field to an object or an element to an array.
  void add(std::string field, Json value);
  void add(Json value) { std::get<Array>(value_).push_back(std::move(value)); }

  /// Text with a final newline. Throws std::exception when a string in it is not UTF-8.
  [[nodiscard]] std::string text() const;

 private:
  void add_fields() {}
  template <class Value, class... Rest>
  void add_fields(const char* field, Value&& value, Rest&&... rest) {
    add(field, Json(std::forward<Value>(value)));
    add_fields(std::forward<Rest>(rest)...);
  }
  void append_to(std::string& text, std::size_t depth) const;

  std::variant<std::nullptr_t, bool, std::int64_t, double, std::string, Array, Fields> value_ = nullptr;
};

/// A format error about a field: `NAME: field "FIELD" WHAT`.
Error field_error(const std::string& name, std::string_view field, std::string_view what);

/// Parses one JSON object and nothing after it; `name` stands for the file in messages. A field of the outermost object
/// that appears twice is an error; so is nesting deeper than any of our files. May throw std::bad_alloc.
Result<Json> parse_json_object(std::string_view text, const std::string& name);

/// The number in a required field; `field` is looked up, `label` names it in messages.
Result<double> number_field(const Json& object, const char* field, const std::string& label, const std::string& name);
/// The same for a number of at most `max` that must be whole. Values outside [0, max] become 0 or max + 1.
Result<int> whole_field(const Json& object, const char* field, const std::string& label, int max, const std::string& name);
/// The same for a plane's label, 1 to 254.
Result<int> label_field(const Json& object, const char* field, const std::string& label, const std::string& name);

}  // namespace fransac::io
