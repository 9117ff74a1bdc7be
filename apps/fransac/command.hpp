// SPDX-License-Identifier: Apache-2.0
/// Commands and their options as the program declares them. The parser, the help, the manual page and the completions of shells
/// are made from these.
#pragma once

#include <functional>
#include <iterator>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "fransac/core/enum_names.hpp"

namespace fransac::cli {

/// A text that is no value of an option.
struct InvalidValue {
  std::string why;
};

struct Option {
  std::string name;                       ///< "--labels"; of a positional "INPUT".
  std::string alias{};                    ///< A second name.
  std::string value{};                    ///< What stands for its value: "FILE", "N"; empty: a flag. Of a positional its name.
  std::string help{};                     ///< One sentence.
  std::string notes{};                    ///< Unit, range and default.
  std::vector<std::string> words{};       ///< Values with a name, or what a value begins with ("bias=").
  std::vector<std::string> needs{};       ///< Options that must be given, too.
  std::string group{};                    ///< Its title in the help.
  std::optional<std::string> left_out{};  ///< The number it means where its value is left out.
  bool required = false;
  bool repeated = false;
  bool negatable = false;  ///< A flag that has a "--no-" form.
  /// Takes a value's text ("on" or "off" of a flag), once for each; throws InvalidValue.
  std::function<void(const std::string&)> take{};

  [[nodiscard]] bool positional() const { return !name.starts_with('-'); }
  [[nodiscard]] bool is_flag() const { return value.empty(); }
  /// All names, "--no-…" included.
  [[nodiscard]] std::vector<std::string> names() const;
  /// "help [notes]"
  [[nodiscard]] std::string text() const;
};

struct Example {
  std::string option;     ///< An option that matters most: `-h` shows it.
  std::string arguments;  ///< Of the command, how it is used.
};

struct Command {
  std::string name;
  std::string help;
  std::vector<Option> options{};
  std::string footer{};  ///< Lines below the help.
  std::vector<Example> examples{};
  std::function<void()> run{};  ///< Called once the options have taken their values; throws Failure or UsageError.

  /// The option of that name or alias; null: there is none.
  [[nodiscard]] const Option* find(std::string_view option) const;
  Option& add(Option option) { return options.emplace_back(std::move(option)); }
};

/// The program as a whole: its own options are those without a command.
struct Program {
  std::string name;
  std::string version;
  std::string purpose;
  std::string footer;
  std::vector<Command> commands;

  [[nodiscard]] const Command* find(std::string_view command) const;
};

/// An enum whose values have names.
template <class T>
concept Named = requires {
  EnumNames<T>::values;
};

template <Named Enum>
std::vector<std::string> enum_words() {
  return {std::begin(EnumNames<Enum>::values), std::end(EnumNames<Enum>::values)};
}

template <Named Enum>
std::optional<Enum> enum_from_name(std::string_view name) {
  int value = 0;
  for (const std::string_view known : EnumNames<Enum>::values) {
    if (known == name) return static_cast<Enum>(value);
    ++value;
  }
  return std::nullopt;
}

/// "a, b, c"
std::string joined(const std::vector<std::string>& words, std::string_view separator = ", ");

/// Throws InvalidValue: "expected …, not '…'".
[[noreturn]] void reject(std::string_view expected, std::string_view text);

/// Adds the inputs that a command works on.
void add_input(Command& command, const std::string& name, std::string& value, const std::string& help);
void add_inputs(Command& command, const std::string& name, std::vector<std::string>& values, const std::string& help);
Option& add_flag(Command& command, const std::string& name, bool& value, const std::string& help);
/// A text that means something to what takes it only.
Option& add_text(Command& command, const std::string& name, std::string& value, const std::string& type, const std::string& help);
/// Something to write: its name is not empty.
Option& add_output(Command& command, const std::string& name, std::string& value, const std::string& type,
                   const std::string& help);
/// "--json FILE|-" and its like: results as a document.
Option& add_document(Command& command, const std::string& name, std::string& value);
/// One of some words; `take` sees its place among them.
Option& add_choice(Command& command, const std::string& name, const std::vector<std::string>& words, const std::string& chosen,
                   const std::string& help, const std::function<void(std::size_t)>& take);

template <Named Enum>
Option& add_choice(Command& command, const std::string& name, Enum& value, const std::string& help) {
  return add_choice(command, name, enum_words<Enum>(), std::string(enum_name(value)), help,
                    [&value](std::size_t choice) { value = static_cast<Enum>(choice); });
}

}  // namespace fransac::cli
