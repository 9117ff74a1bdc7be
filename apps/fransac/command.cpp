// SPDX-License-Identifier: Apache-2.0
#include "command.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace fransac::cli {

std::vector<std::string> Option::names() const {
  std::vector<std::string> names{name};
  if (!alias.empty()) names.push_back(alias);
  if (negatable) names.push_back("--no-" + name.substr(2));
  return names;
}

std::string Option::text() const { return notes.empty() ? help : fmt::format("{} [{}]", help, notes); }

const Option* Command::find(std::string_view option) const {
  const auto named = [&](const Option& known) {
    const std::vector<std::string> names = known.names();
    return std::find(names.begin(), names.end(), option) != names.end();
  };
  const auto found = std::find_if(options.begin(), options.end(), named);
  return found == options.end() ? nullptr : &*found;
}

const Command* Program::find(std::string_view command) const {
  const auto named = [&](const Command& known) { return known.name == command; };
  const auto found = std::find_if(commands.begin(), commands.end(), named);
  return found == commands.end() ? nullptr : &*found;
}

std::string joined(const std::vector<std::string>& words, std::string_view separator) {
  return fmt::format("{}", fmt::join(words, separator));
}

void reject(std::string_view expected, std::string_view text) {
  throw InvalidValue{fmt::format("expected {}, not '{}'", expected, text)};
}

void add_input(Command& command, const std::string& name, std::string& value, const std::string& help) {
  command.add(
      {.name = name, .value = name, .help = help, .required = true, .take = [&value](const std::string& text) { value = text; }});
}

void add_inputs(Command& command, const std::string& name, std::vector<std::string>& values, const std::string& help) {
  command.add(
      {.name = name, .value = name, .help = help, .required = true, .repeated = true, .take = [&values](const std::string& text) {
         values.push_back(text);
       }});
}

Option& add_flag(Command& command, const std::string& name, bool& value, const std::string& help) {
  return command.add({.name = name, .help = help, .take = [&value](const std::string& text) { value = text == "on"; }});
}

Option& add_text(Command& command, const std::string& name, std::string& value, const std::string& type,
                 const std::string& help) {
  return command.add({.name = name, .value = type, .help = help, .take = [&value](const std::string& text) { value = text; }});
}

Option& add_output(Command& command, const std::string& name, std::string& value, const std::string& type,
                   const std::string& help) {
  const auto take = [&value](const std::string& text) {
    if (text.empty()) reject("a name", text);
    value = text;
  };
  return command.add({.name = name, .value = type, .help = help, .take = take});
}

Option& add_document(Command& command, const std::string& name, std::string& value) {
  return add_output(command, name, value, "FILE|-", "results; '-' is standard output, instead of the table");
}

Option& add_choice(Command& command, const std::string& name, const std::vector<std::string>& words, const std::string& chosen,
                   const std::string& help, const std::function<void(std::size_t)>& take) {
  const std::string expected = "one of " + joined(words);
  const auto choose = [words, expected, take](const std::string& text) {
    const auto known = std::find(words.begin(), words.end(), text);
    if (known == words.end()) reject(expected, text);
    take(static_cast<std::size_t>(known - words.begin()));
  };
  return command.add({.name = name,
                      .value = "NAME",
                      .help = help,
                      .notes = fmt::format("{}; default: {}", expected, chosen),
                      .words = words,
                      .take = choose});
}

}  // namespace fransac::cli
