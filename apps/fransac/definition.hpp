// SPDX-License-Identifier: Apache-2.0
/// The command line as the parser knows it, for those who write it down: manual page, completions of shells.
#pragma once

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

namespace fransac::cli {

/// What a shell may offer for a value, besides words.
enum class Offer { nothing, files, folders };

struct OptionDefinition {
  std::vector<std::string> names;  ///< "-h", "--help"; of a positional its only name
  std::string value;               ///< "FILE", "N"; empty for a flag
  std::string help;
  std::string summary;  ///< The help without its notes on unit, range and default.
  std::string group;
  std::vector<std::string> words;  ///< Values with a name.
  std::vector<std::string> needs;  ///< Options that must be given, too.
  Offer offer = Offer::nothing;
  bool is_list = false;  ///< Several words, separated by commas.
  bool positional = false;
  bool required = false;
  bool repeated = false;
};

struct CommandDefinition {
  std::string name;
  std::string help;
  std::string footer;  ///< Empty when it is its parent's.
  std::vector<OptionDefinition> options;
  std::vector<CommandDefinition> commands;  ///< Those that help lists.

  [[nodiscard]] bool takes_files() const;  ///< Whether a positional does.
};

/// Remembers what words a value may be, or begin with; parsing does not look at them.
void offer_words(CLI::Option* option, const std::vector<std::string>& words);

CommandDefinition definition_of(CLI::App& app);

/// "a b c"
std::string joined(const std::vector<std::string>& words, const std::string& separator = " ");

std::string manual_page(const CommandDefinition& program, const std::string& version);
std::string bash_completion(const CommandDefinition& program);
std::string zsh_completion(const CommandDefinition& program);
std::string fish_completion(const CommandDefinition& program);

}  // namespace fransac::cli
