// SPDX-License-Identifier: Apache-2.0
#include "command_line.hpp"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>

#include "errors.hpp"
#include "numbers.hpp"
#include "output.hpp"

namespace fransac::cli {
namespace {

constexpr int kNameColumns = 34;

void take(const Option& option, const std::string& text) try { option.take(text); } catch (const InvalidValue& invalid) {
  throw CLI::ValidationError(option.name, invalid.why);
}

/// Hands an option to the parser.
CLI::Option* declare(CLI::App& app, const Option& option) {
  const auto take_all = [&option](const std::vector<std::string>& texts) {
    for (const std::string& text : texts) take(option, text);
  };
  const auto take_one = [&option](const std::string& text) { take(option, text); };
  const std::string names = option.alias.empty() ? option.name : option.name + "," + option.alias;
  if (option.is_flag()) {
    const auto take_flag = [&option](std::int64_t count) { take(option, count > 0 ? "on" : "off"); };
    return app.add_flag_function(option.negatable ? fmt::format("{},!--no-{}", names, option.name.substr(2)) : names, take_flag,
                                 option.text());
  }
  CLI::Option* const declared = option.repeated
                                    ? app.add_option_function<std::vector<std::string>>(names, take_all, option.text())
                                    : app.add_option_function<std::string>(names, take_one, option.text());
  if (option.positional()) return declared;
  if (option.repeated) declared->allow_extra_args(false);
  return declared->type_name(option.value);
}

void declare(CLI::App& app, const Command& command) {
  for (const Option& option : command.options) {
    CLI::Option* const declared = declare(app, option)->required(option.required);
    if (!option.group.empty()) declared->group(option.group);
  }
}

/// Instead of the parser's own needs(), which fills the help with the word.
void check_needs(const CLI::App& app, const Command& command) {
  const auto given = [&](const std::string& name) { return app.get_option(name)->count() > 0; };
  for (const Option& option : command.options) {
    if (!given(option.name)) continue;
    for (const std::string& needed : option.needs) {
      if (!given(needed)) throw CLI::RequiresError(option.name, needed);
    }
  }
}

/// The parser's help without its "{false}" after the names of flags that say no.
std::string help_text(const CLI::App& app) {
  constexpr std::string_view kNoise = "{false}";
  std::string text = app.help();
  for (std::size_t at = 0; (at = text.find(kNoise, at)) != std::string::npos;) text.erase(at, kNoise.size());
  return text;
}

/// The options that matter most, each with an example.
std::string short_help(const Program& program, const Command& command) {
  std::string text =
      fmt::format("{} {}: {}\n\nUsage: {} {}", program.name, command.name, command.help, program.name, command.name);
  for (const Option& option : command.options) {
    if (option.positional()) text += fmt::format(" {}{}", option.name, option.repeated ? "..." : "");
  }
  text += " [OPTIONS]\n\n";
  for (const Option& option : command.options) {
    if (option.positional()) text += fmt::format("  {:<22} {}\n", option.name, option.help);
  }
  for (const Example& example : command.examples) {
    const Option& option = *command.find(example.option);
    text += fmt::format("  {:<22} {}\n{:24}e.g. {} {} {}\n", fmt::format("{} {}", option.name, option.value), option.help, "",
                        program.name, command.name, example.arguments);
  }
  return text + fmt::format("\nAll options, with units, ranges and defaults: {} {} --help\n", program.name, command.name);
}

std::vector<std::string> command_names(const Program& program) {
  std::vector<std::string> names;
  for (const Command& command : program.commands) names.push_back(command.name);
  return names;
}

/// The parser would only say that a mistyped command was not expected.
const Command& chosen_command(const Program& program, const std::string& word) {
  const Command* const command = program.find(word);
  if (command != nullptr) return *command;
  throw UsageError(fmt::format("unknown command '{}'; there are {}", word, joined(command_names(program))),
                   fmt::format("See: {} --help", program.name));
}

/// Whether the words ask for what only those who install the program need, and help does not list.
bool run_hidden(const Program& program, const std::vector<std::string>& words) {
  if (words.front() == "man") {
    write_stdout(manual_page(program));
  } else if (words.front() == "completion") {
    write_stdout(completion_script(words.size() > 1 ? words[1] : ""));
  } else if (words.front() == "__complete") {
    write_stdout(complete(program, {words.begin() + 1, words.end()}));
  } else {
    return false;
  }
  return true;
}

/// The words of a command, the last one first, as the parser takes them. Where the value of an option can be left out, the parser
/// would take a dataset that follows for it: where no number follows, the number that is meant is put in.
std::vector<std::string> words_to_parse(const Command& command, std::vector<std::string> words) {
  for (std::size_t i = 0; i < words.size() && words[i] != "--"; ++i) {
    const Option* const option = command.find(words[i]);
    const bool valued = i + 1 < words.size() && parse_number<double>(words[i + 1]);
    if (option != nullptr && option->left_out && !valued) words[i] += "=" + *option->left_out;
  }
  std::reverse(words.begin(), words.end());
  return words;
}

/// Whether the options have taken their values; else help was printed.
bool parse(const Program& program, const Command& command, std::vector<std::string> words) {
  CLI::App app(command.help, fmt::format("{} {}", program.name, command.name));
  app.get_formatter()->column_width(kNameColumns);
  app.set_help_flag("--help", "all options");
  bool is_short = false;
  const auto ask_for_short_help = [&is_short](std::int64_t /*count*/) {
    is_short = true;
    throw CLI::CallForHelp();
  };
  app.add_flag_function("-h", ask_for_short_help, "the options that matter most")->trigger_on_parse();
  declare(app, command);
  app.footer(command.footer);
  try {
    app.parse(words_to_parse(command, std::move(words)));
    check_needs(app, command);
    return true;
  } catch (const CLI::CallForHelp&) {
    write_stdout(is_short ? short_help(program, command) : help_text(app));
    return false;
  } catch (const CLI::ParseError& error) {
    throw UsageError(error.what(), fmt::format("See: {} {} --help", program.name, command.name));
  }
}

std::string program_help(const Program& program) {
  std::string text = fmt::format("{}.\nUsage: {} COMMAND [OPTIONS]\n\nCommands:\n", program.purpose, program.name);
  for (const Command& command : program.commands) text += fmt::format("  {:<12}{}\n", command.name, command.help);
  return text +
         fmt::format("\n{0} COMMAND -h shows the options that matter most, {0} COMMAND --help all of them; {0} --version.\n{1}\n",
                     program.name, program.footer);
}

}  // namespace

void run_command_line(const Program& program, int argc, const char* const* argv) {
  std::vector<std::string> words(argv + std::min(argc, 1), argv + argc);
  if (words.empty()) {
    throw UsageError(fmt::format("a command is required: {}", joined(command_names(program))),
                     fmt::format("See: {} --help", program.name));
  }
  if (words.front() == "-h" || words.front() == "--help") return write_stdout(program_help(program));
  if (words.front() == "--version") return write_stdout(fmt::format("{} {}\n", program.name, program.version));
  if (run_hidden(program, words)) return;
  const Command& command = chosen_command(program, words.front());
  if (parse(program, command, {words.begin() + 1, words.end()})) command.run();
}

}  // namespace fransac::cli
