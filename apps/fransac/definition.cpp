// SPDX-License-Identifier: Apache-2.0
#include "definition.hpp"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <string_view>

namespace fransac::cli {
namespace {

// Words are kept as the name of a check that lets everything pass: the parser has no other place for them.
constexpr std::string_view kWords = "words:";
constexpr char kBetweenWords = '\n';

std::vector<std::string> words_of(CLI::Option& option) {
  try {
    for (int i = 0;; ++i) {
      const std::string& name = option.get_validator(i)->get_name();
      if (name.starts_with(kWords)) return CLI::detail::split(name.substr(kWords.size()), kBetweenWords);
    }
  } catch (const CLI::OptionNotFound&) {  // the parser's way to say that there are no more
    return {};
  }
}

std::vector<std::string> names_of(const CLI::Option& option) {
  if (option.get_positional()) return {option.get_name(true)};
  std::vector<std::string> names;
  for (const std::string& name : option.get_snames()) names.push_back("-" + name);
  for (const std::string& name : option.get_lnames()) names.push_back("--" + name);
  return names;
}

std::vector<std::string> needs_of(const CLI::Option& option) {
  std::vector<std::string> names;
  for (const CLI::Option* needed : option.get_needs()) names.push_back(needed->get_name());
  std::sort(names.begin(), names.end());  // the parser sorts by address
  return names;
}

Offer offer_for(const OptionDefinition& option) {
  const auto has = [&](std::string_view word) { return option.value.find(word) != std::string::npos; };
  if (has("DIR")) return Offer::folders;
  return option.positional || has("FILE") || has("BASE") ? Offer::files : Offer::nothing;
}

OptionDefinition definition_of(CLI::Option& option) {
  OptionDefinition definition;
  definition.names = names_of(option);
  definition.help = option.get_description();
  definition.summary = definition.help.substr(0, definition.help.find(" ["));
  definition.group = option.get_group();
  definition.words = words_of(option);
  definition.needs = needs_of(option);
  definition.positional = option.get_positional();
  definition.required = option.get_required();
  definition.repeated = option.get_items_expected_max() > 1;
  if (definition.positional) {
    definition.value = definition.names.front();
  } else if (option.get_items_expected_max() > 0) {
    definition.value = option.get_type_name();
  }
  definition.is_list = definition.value.ends_with(",...");
  definition.offer = offer_for(definition);
  return definition;
}

}  // namespace

bool CommandDefinition::takes_files() const {
  return std::any_of(options.begin(), options.end(), [](const OptionDefinition& option) { return option.positional; });
}

void offer_words(CLI::Option* option, const std::vector<std::string>& words) {
  if (words.empty()) return;
  option->check(CLI::Validator().name(std::string(kWords) + joined(words, std::string(1, kBetweenWords))));
}

CommandDefinition definition_of(CLI::App& app) {
  CommandDefinition definition;
  definition.name = app.get_name();
  definition.help = app.get_description();
  if (app.get_parent() == nullptr || app.get_footer() != app.get_parent()->get_footer()) definition.footer = app.get_footer();
  for (CLI::Option* option : app.get_options({})) definition.options.push_back(definition_of(*option));
  for (CLI::App* command : app.get_subcommands([](const CLI::App* found) { return !found->get_group().empty(); })) {
    definition.commands.push_back(definition_of(*command));
  }
  return definition;
}

std::string joined(const std::vector<std::string>& words, const std::string& separator) {
  return fmt::format("{}", fmt::join(words, separator));
}

}  // namespace fransac::cli
