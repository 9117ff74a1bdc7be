// SPDX-License-Identifier: Apache-2.0
// What shells offer at the tabulator key: each asks the program itself.
#include <fmt/format.h>

#include "command_line.hpp"
#include "errors.hpp"

namespace fransac::cli {
namespace {

constexpr std::string_view kBash = R"(# bash completion for fransac -*- shell-script -*-
_fransac() {
  local line path words=("${COMP_WORDS[@]:1:COMP_CWORD}")
  local current=${words[-1]}
  [[ $current != = ]] || current=
  COMPREPLY=()
  while read -r line; do
    case $line in
      :file | :directory)
        while read -r path; do COMPREPLY+=("$path"); done < <(compgen -A "${line#:}" -- "$current" | sort -u)
        compopt -o filenames 2> /dev/null ;;
      :more) compopt -o nospace 2> /dev/null ;;
      *) COMPREPLY+=("${line%%$'\t'*}") ;;
    esac
  done < <("${COMP_WORDS[0]}" __complete "${words[@]}" 2> /dev/null)
}
complete -F _fransac fransac
)";

constexpr std::string_view kZsh = R"(#compdef fransac
_fransac() {
  local line
  local -a offers more
  for line in "${(@f)$("${words[1]}" __complete "${(@)words[2,CURRENT]}" 2> /dev/null)}"; do
    case $line in
      :file) _files ;;
      :directory) _files -/ ;;
      :more) more=(-S '') ;;
      ?*) offers+=("${line%%$'\t'*}:${line#*$'\t'}") ;;
    esac
  done
  (( ! $#offers )) || _describe fransac offers $more
}
# Loaded from the function path it is called at once; read by `source` it is registered.
if [[ $funcstack[1] == _fransac ]]; then _fransac "$@"; else compdef _fransac fransac; fi
)";

constexpr std::string_view kFish = R"(function __fransac_complete
  set -l current (commandline -ct)
  set -l words (commandline -opc) "$current"
  for line in ($words[1] __complete $words[2..] 2> /dev/null)
    switch $line
      case :file
        __fish_complete_path $current
      case :directory
        __fish_complete_directories $current
      case :more
      case '*'
        echo $line
    end
  end
end
complete -c fransac -f -a '(__fransac_complete)'
)";

class Offers {
 public:
  /// The words must begin with `typed`; `before` stands before each of them already.
  explicit Offers(std::string typed, std::string before = {}) : typed_(std::move(typed)), before_(std::move(before)) {}

  void word(const std::string& word, std::string_view meaning) {
    if (word.starts_with(typed_)) text_ += fmt::format("{}{}\t{}\n", before_, word, meaning);
  }
  void names(const Option& option) {
    for (const std::string& name : option.names()) word(name, option.help);
  }
  void say(std::string_view directive) { text_ += fmt::format("{}\n", directive); }
  [[nodiscard]] const std::string& text() const { return text_; }

 private:
  std::string typed_;
  std::string before_;
  std::string text_;
};

bool names_folder(const Option& option) { return option.value.find("DIR") != std::string::npos; }
bool names_file(const Option& option) {
  return option.positional() || option.value.find("FILE") != std::string::npos || option.value.find("BASE") != std::string::npos;
}

/// Values of an option; `before`: the words that the shell holds for a part of the value, "--method=".
std::string values_of(const Option& option, std::string typed, std::string before) {
  const std::size_t comma = typed.rfind(',');
  if (option.value.ends_with(",...") && comma != std::string::npos) {  // the last of a list
    before += typed.substr(0, comma + 1);
    typed.erase(0, comma + 1);
  }
  Offers offers(std::move(typed), std::move(before));
  for (const std::string& word : option.words) offers.word(word, "");
  if (!option.words.empty() && option.words.front().ends_with('=')) offers.say(":more");
  if (names_folder(option)) {
    offers.say(":directory");
  } else if (names_file(option)) {
    offers.say(":file");
  }
  return offers.text();
}

std::string first_words(const Program& program, const std::string& typed) {
  Offers offers(typed);
  for (const Command& command : program.commands) offers.word(command.name, command.help);
  offers.word("-h", "help");
  offers.word("--help", "help");
  offers.word("--version", "the program's version");
  return offers.text();
}

std::string option_names(const Command& command, const std::string& typed) {
  Offers offers(typed);
  for (const Option& option : command.options) {
    if (!option.positional()) offers.names(option);
  }
  offers.word("-h", "the options that matter most");
  offers.word("--help", "all options");
  return offers.text();
}

}  // namespace

std::string_view completion_script(std::string_view shell) {
  if (shell == "bash") return kBash;
  if (shell == "zsh") return kZsh;
  if (shell == "fish") return kFish;
  throw UsageError(fmt::format("SHELL: expected one of bash, zsh, fish, not '{}'", shell));
}

std::string complete(const Program& program, const std::vector<std::string>& words) {
  if (words.empty()) return {};
  if (words.size() == 1) return first_words(program, words.front());
  const Command* const command = program.find(words.front());
  if (command == nullptr) return {};
  std::string typed = words.back();
  std::string option_name = words[words.size() - 2];
  std::string before;
  const std::size_t equals = typed.find('=');
  if (typed == "=") {  // bash takes --option=value for three words
    typed.clear();
  } else if (option_name == "=" && words.size() > 3) {
    option_name = words[words.size() - 3];
  } else if (typed.starts_with("--") && equals != std::string::npos) {
    option_name = typed.substr(0, equals);
    before = typed.substr(0, equals + 1);
    typed.erase(0, equals + 1);
  }
  const Option* const option = command->find(option_name);
  if (option != nullptr && !option->positional() && !option->is_flag()) return values_of(*option, typed, before);
  if (typed.starts_with('-')) return option_names(*command, typed);
  for (const Option& positional : command->options) {
    if (positional.positional()) return values_of(positional, typed, {});
  }
  return {};
}

}  // namespace fransac::cli
