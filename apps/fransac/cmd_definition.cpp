// SPDX-License-Identifier: Apache-2.0
// The commands that write down the command line itself, for those who install it. Help does not list them.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <memory>
#include <string>

#include "commands.hpp"
#include "definition.hpp"
#include "errors.hpp"
#include "fransac/version.hpp"
#include "output.hpp"

namespace fransac::cli {
namespace {

std::string completion(const std::string& shell, const CommandDefinition& program) {
  if (shell == "bash") return bash_completion(program);
  if (shell == "zsh") return zsh_completion(program);
  if (shell == "fish") return fish_completion(program);
  throw UsageError(fmt::format("SHELL: expected one of bash, zsh, fish, not '{}'", shell));
}

}  // namespace

Command add_completion(CLI::App& parent) {
  CLI::App* app = parent.add_subcommand("completion", "print what makes a shell complete fransac's words")->group("");
  auto shell = std::make_shared<std::string>();
  app->add_option("SHELL", *shell, "bash, zsh or fish")->required();
  return {app, [shell, &parent] { write_stdout(completion(*shell, definition_of(parent))); }};
}

Command add_man(CLI::App& parent) {
  CLI::App* app = parent.add_subcommand("man", "print the manual page")->group("");
  return {app, [&parent] { write_stdout(manual_page(definition_of(parent), kVersion)); }};
}

}  // namespace fransac::cli
