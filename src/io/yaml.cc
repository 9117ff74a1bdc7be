// SPDX-License-Identifier: Apache-2.0
#include "io/yaml.h"

#include <yaml-cpp/eventhandler.h>
#include <yaml-cpp/exceptions.h>
#include <yaml-cpp/parser.h>

#include <cmath>
#include <optional>
#include <set>
#include <sstream>
#include <utility>
#include <vector>

#include "fransac/core/printable.hpp"
#include "io/guard.h"
#include "io/text.h"

namespace fransac::io {
namespace {

constexpr std::size_t kMaxDepth = 64;

/// What the builder refuses, as an exception through the parser, which knows no other way out.
struct Refused {
  YAML::Mark mark;
  std::string what;
};

/// Makes a Json of what the parser calls out.
class JsonBuilder : public YAML::EventHandler {
 public:
  Json value;

  void OnDocumentStart(const YAML::Mark& /*mark*/) override {}
  void OnDocumentEnd() override {}
  void OnNull(const YAML::Mark& mark, YAML::anchor_t /*anchor*/) override { add(mark, nullptr); }
  void OnAlias(const YAML::Mark& mark, YAML::anchor_t /*anchor*/) override { throw Refused{mark, "an alias, which is not read"}; }
  void OnScalar(const YAML::Mark& mark, const std::string& tag, YAML::anchor_t /*anchor*/, const std::string& text) override {
    const bool is_plain = tag != "!";
    const auto number = is_plain && !awaits_key() ? parse_real(text) : std::nullopt;
    add(mark, number && std::isfinite(*number) ? Json(*number) : Json(text));
  }
  void OnSequenceStart(const YAML::Mark& mark, const std::string& /*tag*/, YAML::anchor_t /*anchor*/,
                       YAML::EmitterStyle::value /*style*/) override {
    open(mark, Json(Json::Array{}));
  }
  void OnSequenceEnd() override { close(); }
  void OnMapStart(const YAML::Mark& mark, const std::string& /*tag*/, YAML::anchor_t /*anchor*/,
                  YAML::EmitterStyle::value /*style*/) override {
    open(mark, Json(Json::Fields{}));
  }
  void OnMapEnd() override { close(); }

 private:
  struct Open {
    Json container;
    YAML::Mark mark;
    std::optional<std::string> key;  ///< Whose value comes next.
  };

  /// Whether the next scalar names a field.
  [[nodiscard]] bool awaits_key() const {
    return !open_.empty() && open_.back().container.fields() != nullptr && !open_.back().key;
  }

  void add(const YAML::Mark& mark, Json read) {
    if (open_.empty()) {
      value = std::move(read);
    } else if (awaits_key()) {
      const std::string* const name = read.string();
      if (name == nullptr) throw Refused{mark, "a key that is no text"};
      if (open_.size() == 1 && !fields_.insert(*name).second)
        throw Refused{mark, "field " + quoted_text(*name) + " appears twice"};
      open_.back().key = *name;
    } else if (Open& last = open_.back(); last.key) {
      last.container.add(*std::move(last.key), std::move(read));
      last.key.reset();
    } else {
      last.container.add(std::move(read));
    }
  }

  void open(const YAML::Mark& mark, Json container) {
    if (open_.size() == kMaxDepth) throw Refused{mark, "nesting deeper than " + std::to_string(kMaxDepth)};
    open_.push_back({std::move(container), mark, {}});
  }

  void close() {
    Open last = std::move(open_.back());
    open_.pop_back();
    add(last.mark, std::move(last.container));
  }

  std::vector<Open> open_;  ///< Sequences and mappings that have begun.
  std::set<std::string> fields_;
};

std::size_t line_of(const YAML::Mark& mark) { return static_cast<std::size_t>(mark.line) + 1; }

}  // namespace

Result<Json> parse_yaml_object(std::string_view text, const std::string& name) {
  std::string document(text);
  const std::size_t start = text.starts_with(kByteOrderMark) ? kByteOrderMark.size() : 0;
  if (text.substr(start).starts_with("%YAML:")) document[start] = '#';  // no directive of YAML's
  JsonBuilder builder;
  try {
    std::istringstream stream(document);
    YAML::Parser(stream).HandleNextDocument(builder);
  } catch (const Refused& refused) {
    return line_error(name, line_of(refused.mark), refused.what);
  } catch (const YAML::Exception& error) {
    return line_error(name, line_of(error.mark), "not valid YAML");
  }
  if (builder.value.fields() == nullptr)
    return file_error(ErrorCode::format, name, "is neither a JSON object nor a YAML mapping");
  return std::move(builder.value);
}

}  // namespace fransac::io
