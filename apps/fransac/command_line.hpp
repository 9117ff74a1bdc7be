// SPDX-License-Identifier: Apache-2.0
/// From the words of a command line to the command that they ask for. The one part that knows the parser, CLI11.
#pragma once

#include "command.hpp"

namespace fransac::cli {

/// Lets the options take their values and runs the command, or prints what is asked for instead: help, version, and, for those
/// who install the program, `man`, `completion SHELL`, `__complete WORD…`. Throws Failure or UsageError.
void run_command_line(const Program& program, int argc, const char* const* argv);

/// The manual page, in the macros of man(7).
std::string manual_page(const Program& program);

/// What makes a shell ask `fransac __complete`: bash, zsh or fish. Throws UsageError.
std::string_view completion_script(std::string_view shell);
/// What the last of `words`, which stand after the program's name, may be or begin with: lines of a word, a tab and what it
/// means;
/// ":file" and ":directory" for any of these, ":more" where a word is not the whole value.
std::string complete(const Program& program, const std::vector<std::string>& words);

}  // namespace fransac::cli
