// SPDX-License-Identifier: Apache-2.0
// What shells offer at the tabulator key. No names of ours hold anything that a shell would have to be kept from reading; texts
// do.
#include <fmt/format.h>

#include <algorithm>
#include <string>
#include <string_view>
#include <vector>

#include "definition.hpp"

namespace fransac::cli {
namespace {

/// Each character out of `special` after a backslash.
std::string guarded(std::string_view text, std::string_view special) {
  std::string out;
  for (const char c : text) {
    if (special.find(c) != std::string_view::npos) out += '\\';
    out += c;
  }
  return out;
}

/// In single quotes, as bash and zsh read them.
std::string single_quoted(std::string_view text) {
  std::string out = "'";
  for (const char c : text) out += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return out + "'";
}

std::vector<std::string> command_names(const CommandDefinition& program) {
  std::vector<std::string> names;
  for (const CommandDefinition& command : program.commands) names.push_back(command.name);
  return names;
}

std::vector<std::string> option_names(const CommandDefinition& command) {
  std::vector<std::string> names;
  for (const OptionDefinition& option : command.options) {
    if (!option.positional) names.insert(names.end(), option.names.begin(), option.names.end());
  }
  return names;
}

constexpr std::string_view kBashHead = R"(# bash completion for fransac -*- shell-script -*-

_fransac_words() { mapfile -t COMPREPLY < <(compgen -W "$1" -- "$current"); }
_fransac_list() {
  local before=
  [[ $current != *,* ]] || before=${current%,*},
  mapfile -t COMPREPLY < <(compgen -P "$before" -W "$1" -- "${current##*,}")
}
_fransac_parts() { _fransac_words "$1"; compopt -o nospace 2> /dev/null; }
_fransac_paths() {
  local path
  while read -r path; do COMPREPLY+=("$path"); done < <(compgen "$1" -- "$current")
  compopt -o filenames 2> /dev/null
}

_fransac() {
  local current=${COMP_WORDS[COMP_CWORD]} previous=${COMP_WORDS[COMP_CWORD - 1]} command=${COMP_WORDS[1]}
  COMPREPLY=()
  # Bash takes --option=value for three words.
  if [[ $current == = ]]; then current=; elif [[ $previous == = ]]; then previous=${COMP_WORDS[COMP_CWORD - 2]}; fi
)";

std::string bash_values(const OptionDefinition& option) {
  const std::string words = single_quoted(joined(option.words));
  const bool parts = !option.words.empty() && option.words.front().ends_with('=');
  std::vector<std::string> calls;
  if (!option.words.empty())
    calls.push_back((option.is_list ? "_fransac_list " : parts ? "_fransac_parts " : "_fransac_words ") + words);
  if (option.offer != Offer::nothing) calls.push_back(option.offer == Offer::files ? "_fransac_paths -f" : "_fransac_paths -d");
  return calls.empty() ? ":" : joined(calls, "; ");
}

std::string zsh_values(const OptionDefinition& option) {
  const std::string files = option.offer == Offer::folders ? "_files -/" : "_files";
  const std::string words = joined(option.words);
  if (option.words.empty()) return option.offer == Offer::nothing ? " " : files;
  if (option.is_list) return "_sequence compadd - " + words;
  if (option.words.front().ends_with('=')) return fmt::format(" compadd -S \"\" - {}", words);
  if (option.offer == Offer::nothing) return fmt::format("({})", words);
  return fmt::format(" _alternative \"names\\:name\\:({})\" \"files\\:file\\:{}\"", words, files);
}

/// The arguments of zsh's _arguments, one for each name of an option.
std::string zsh_arguments(const CommandDefinition& command, std::string_view indent) {
  std::string text;
  for (const OptionDefinition& option : command.options) {
    const std::string value = guarded(option.value, ":[]\\");
    if (option.positional) {
      text += fmt::format(" \\\n{}{}", indent,
                          single_quoted(fmt::format("{}:{}:{}", option.repeated ? "*" : "", value, zsh_values(option))));
      continue;
    }
    for (const std::string& name : option.names) {
      std::string argument = (option.repeated ? "*" : "") + name;
      if (!option.value.empty() && name.starts_with("--")) argument += "=";
      argument += fmt::format("[{}]", guarded(option.summary, ":[]\\"));
      if (!option.value.empty()) argument += fmt::format(":{}:{}", value, zsh_values(option));
      text += fmt::format(" \\\n{}{}", indent, single_quoted(argument));
    }
  }
  return text;
}

/// In single quotes, as fish reads them.
std::string fish_quoted(std::string_view text) { return "'" + guarded(text, "'\\") + "'"; }

std::string fish_values(const OptionDefinition& option) {
  if (option.value.empty()) return "";
  std::vector<std::string> values = option.words;
  if (option.is_list) values = {fmt::format("(__fish_complete_list , \"string split ' ' '{}'\")", joined(option.words))};
  if (option.offer == Offer::folders) values.emplace_back("(__fish_complete_directories)");
  // -x: a value and no files; -r: a value, files too.
  std::string text = option.offer == Offer::files ? " -r -F" : " -x";
  if (!values.empty()) text += " -a " + fish_quoted(joined(values));
  return text;
}

std::string fish_lines(const CommandDefinition& command, const std::string& condition) {
  std::string text;
  for (const OptionDefinition& option : command.options) {
    if (option.positional) continue;
    for (const std::string& name : option.names) {
      const bool is_long = name.starts_with("--");
      text += fmt::format("complete -c fransac -n {}{} {}{} -d {}\n", condition, is_long ? " -l" : " -s",
                          name.substr(is_long ? 2 : 1), fish_values(option), fish_quoted(option.summary));
    }
  }
  return text;
}

}  // namespace

std::string bash_completion(const CommandDefinition& program) {
  std::vector<std::string> first = command_names(program);
  for (const std::string& name : option_names(program)) first.push_back(name);
  std::string text(kBashHead);
  text += fmt::format("  if ((COMP_CWORD == 1)); then\n    _fransac_words {}\n    return\n  fi\n", single_quoted(joined(first)));
  text += "  case $command:$previous in\n";
  for (const CommandDefinition& command : program.commands) {
    for (const OptionDefinition& option : command.options) {
      if (option.positional || option.value.empty()) continue;
      std::vector<std::string> patterns;
      for (const std::string& name : option.names) patterns.push_back(fmt::format("{}:{}", command.name, name));
      text += fmt::format("    {}) {}; return ;;\n", joined(patterns, " | "), bash_values(option));
    }
  }
  text += "  esac\n  [[ ${COMP_WORDS[COMP_CWORD]} != = && ${COMP_WORDS[COMP_CWORD - 1]} != = ]] || return\n";
  text += "  case $command:$current in\n";
  for (const CommandDefinition& command : program.commands) {
    text += fmt::format("    {}:-*) _fransac_words {} ;;\n", command.name, single_quoted(joined(option_names(command))));
    if (command.takes_files()) text += fmt::format("    {}:*) _fransac_paths -f ;;\n", command.name);
  }
  return text + "  esac\n}\n\ncomplete -F _fransac fransac\n";
}

std::string zsh_completion(const CommandDefinition& program) {
  std::string text = "#compdef fransac\n\n_fransac() {\n  local curcontext=$curcontext state line\n  typeset -A opt_args\n";
  text += "  local -a commands=(\n";
  for (const CommandDefinition& command : program.commands) {
    text += fmt::format("    {}\n", single_quoted(fmt::format("{}:{}", command.name, guarded(command.help, ":\\"))));
  }
  text += fmt::format("  )\n  _arguments -C{} \\\n    '1:command:->command' '*::argument:->argument' && return\n",
                      zsh_arguments(program, "    "));
  text += "  [[ $state != command ]] || { _describe -t commands command commands; return; }\n  case $line[1] in\n";
  for (const CommandDefinition& command : program.commands) {
    text += fmt::format("    {})\n      _arguments{} ;;\n", command.name, zsh_arguments(command, "        "));
  }
  text += "  esac\n}\n\n";
  // Loaded from the function path it is called at once; read by `source` it is registered.
  return text + "if [[ $funcstack[1] == _fransac ]]; then _fransac \"$@\"; else compdef _fransac fransac; fi\n";
}

std::string fish_completion(const CommandDefinition& program) {
  std::string text = "complete -c fransac -f\n";
  text += fish_lines(program, "__fish_use_subcommand");
  for (const CommandDefinition& command : program.commands) {
    text += fmt::format("complete -c fransac -n __fish_use_subcommand -a {} -d {}\n", command.name, fish_quoted(command.help));
  }
  for (const CommandDefinition& command : program.commands) {
    const std::string condition = fmt::format("'__fish_seen_subcommand_from {}'", command.name);
    if (command.takes_files()) text += fmt::format("complete -c fransac -n {} -F\n", condition);
    text += fish_lines(command, condition);
  }
  return text;
}

}  // namespace fransac::cli
