// SPDX-License-Identifier: Apache-2.0
// The manual page, in the macros of man(7).
#include <fmt/format.h>

#include <algorithm>
#include <sstream>
#include <string>
#include <string_view>
#include <vector>

#include "command_line.hpp"

namespace fransac::cli {
namespace {

/// Text as it shall be read: no character means anything to the formatter, and long words can break at commas.
std::string escaped(std::string_view text) {
  std::string out = text.starts_with('.') || text.starts_with('\'') ? "\\&" : "";
  for (std::size_t i = 0; i < text.size(); ++i) {
    switch (text[i]) {
      case '\\': out += "\\e"; break;
      case '-': out += "\\-"; break;
      case '\'': out += "\\(aq"; break;
      case '^': out += "\\(ha"; break;
      case '~': out += "\\(ti"; break;
      case '`': out += "\\(ga"; break;
      case ',': out += i + 1 < text.size() && text[i + 1] != ' ' ? ",\\:" : ","; break;
      default: out += text[i];
    }
  }
  return out;
}

std::string heading(const Option& option) {
  std::vector<std::string> names;
  for (const std::string& name : option.names()) {
    names.push_back(fmt::format("\\f{}{}\\fR", option.positional() ? 'I' : 'B', escaped(name)));
  }
  std::string line = joined(names);
  if (!option.positional() && !option.value.empty()) line += fmt::format(" \\fI{}\\fR", escaped(option.value));
  return option.repeated ? line + " ..." : line;
}

std::string entry(const Option& option) {
  std::string help = option.text();
  if (!option.needs.empty()) help += fmt::format(" (needs {})", joined(option.needs));
  if (option.required && !option.positional()) help += " (required)";
  return fmt::format(".TP\n{}\n{}\n", heading(option), escaped(help));
}

/// Options by group, in the order of the groups' first options; the parser's own group needs no title.
std::string entries(const Command& command) {
  std::vector<std::string> groups;
  for (const Option& option : command.options) {
    if (std::find(groups.begin(), groups.end(), option.group) == groups.end()) groups.push_back(option.group);
  }
  std::string text;
  for (const bool positional : {true, false}) {
    for (const std::string& group : groups) {
      std::string list;
      for (const Option& option : command.options) {
        if (option.group == group && option.positional() == positional) list += entry(option);
      }
      if (!positional && group.empty()) {
        list += entry({.name = "-h", .help = "print the options that matter most and exit"}) +
                entry({.name = "--help", .help = "print all options and exit"});
      }
      if (!list.empty() && !group.empty()) text += fmt::format(".PP\n{}:\n", escaped(group));
      text += list;
    }
  }
  return text;
}

/// Lines that were broken for a wide terminal, as paragraphs: one ends where its line ends a sentence.
std::string paragraphs(const std::string& text) {
  std::string out;
  bool begins = true;
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) {
    if (line.empty()) continue;
    out += fmt::format("{}{}\n", begins && !out.empty() ? ".PP\n" : "", escaped(line));
    begins = line.ends_with('.') || line.ends_with(':');
  }
  return out;
}

std::string usage(const Program& program, const Command& command) {
  std::string line = fmt::format("\\fB{} {}\\fR [\\fIOPTIONS\\fR]", program.name, escaped(command.name));
  for (const Option& option : command.options) {
    if (option.positional()) line += " " + heading(option);
  }
  return line;
}

}  // namespace

std::string manual_page(const Program& program) {
  std::string upper = program.name;
  std::transform(upper.begin(), upper.end(), upper.begin(),
                 [](char c) { return c >= 'a' && c <= 'z' ? char(c - 'a' + 'A') : c; });
  std::string page = fmt::format(".TH {} 1 \"\" \"{} {}\" \"User Commands\"\n.nh\n.ad l\n", upper, program.name, program.version);
  page += fmt::format(".SH NAME\n{} \\- {}\n.SH SYNOPSIS\n", program.name, escaped(program.purpose));
  for (const Command& command : program.commands) page += usage(program, command) + "\n.br\n";
  page += fmt::format("\\fB{}\\fR [\\fIOPTIONS\\fR]\n.SH OPTIONS\n{}{}.SH COMMANDS\n", program.name,
                      entry({.name = "-h", .alias = "--help", .help = "print the commands and exit"}),
                      entry({.name = "--version", .help = "print the version and exit"}));
  for (const Command& command : program.commands) {
    page += fmt::format(".TP\n\\fB{}\\fR\n{}\n", escaped(command.name), escaped(command.help));
  }
  for (const Command& command : program.commands) {
    page += fmt::format(".SH \"COMMAND {}\"\n{}\n.PP\n{}\n{}", escaped(command.name), usage(program, command),
                        escaped(command.help), entries(command));
    if (!command.footer.empty()) page += ".PP\n" + paragraphs(command.footer);
  }
  return page + ".SH \"EXIT STATUS\"\n" + paragraphs(program.footer);
}

}  // namespace fransac::cli
