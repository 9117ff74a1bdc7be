// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <exception>
#include <filesystem>
#include <new>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "commands.hpp"
#include "errors.hpp"
#include "fransac/planes/tuning.hpp"
#include "fransac/version.hpp"
#include "options.hpp"
#include "output.hpp"
#include "process.hpp"

namespace fransac::cli {
namespace {

constexpr const char* kSeeHelp = "See: fransac --help";

/// The parser's help without its "{false}" after the names of flags that say no.
std::string help_text(const CLI::App& app) {
  constexpr std::string_view kNoise = "{false}";
  std::string text = app.help();
  for (std::size_t at = 0; (at = text.find(kNoise, at)) != std::string::npos;) text.erase(at, kNoise.size());
  return text;
}

/// The text that the parser asks to be printed, or a usage error.
void finish_parsing(const CLI::App& app, const CLI::ParseError& error) {
  if (dynamic_cast<const CLI::CallForHelp*>(&error) != nullptr) return write_stdout(help_text(app));
  if (dynamic_cast<const CLI::CallForVersion*>(&error) != nullptr) return write_stdout(std::string(error.what()) + "\n");
  const auto chosen = app.get_subcommands();
  throw UsageError(error.what(), fmt::format("See: fransac {}--help", chosen.empty() ? "" : chosen.front()->get_name() + " "));
}

/// The parser would only say that a mistyped command was not expected.
void check_command(std::span<const Command> commands, const std::string& word) {
  const auto named = [&](const Command& command) { return command.app->get_name() == word; };
  if (word.starts_with('-') || std::any_of(commands.begin(), commands.end(), named)) return;
  throw UsageError(fmt::format("unknown command '{}'; there are segment, track, evaluate, report, bench, synth, calibrate", word),
                   kSeeHelp);
}

#ifdef FRANSAC_TUNABLE
/// For scripts/sensitivity: whether the constants' names were asked for.
bool lists_constants(int argc, char** argv) {
  if (const Status& status = tuning_status(); !status) throw UsageError(status.error().message);
  if (argc != 2 || std::string_view(argv[1]) != "--list-constants") return false;
  write_stdout(fmt::format("{}\n", fmt::join(tunable_constants(), "\n")));
  return true;
}
#else
bool lists_constants(int /*argc*/, char** /*argv*/) { return false; }
#endif

/// The words of the command line, the last one first, as the parser takes them. After --hoover, whose value may be left out, the
/// parser would take a dataset for the value: where no number follows, the default is put in.
std::vector<std::string> words_to_parse(int argc, char** argv) {
  std::vector<std::string> words(argv + std::min(argc, 1), argv + argc);
  for (std::size_t i = 0; i < words.size(); ++i) {
    const bool valued = i + 1 < words.size() && parse_number<double>(words[i + 1]);
    if (words[i] == "--hoover" && !valued) words[i] += fmt::format("={}", HooverRequest{}.tolerance);
    if (words[i] == "--") break;
  }
  std::reverse(words.begin(), words.end());
  return words;
}

void run(int argc, char** argv) {
  if (lists_constants(argc, argv)) return;
  CLI::App app("Planes in depth frames and point clouds.", "fransac");
  app.set_version_flag("--version", fmt::format("fransac {}", kVersion), "print the version and exit");
  app.require_subcommand(0, 1);  // none is refused below: the parser would not name a mistyped one
  app.get_formatter()->column_width(34);
  app.footer("Exit codes: 0 done, 1 the input could not be used or an output not be written, 2 wrong usage.");
  const Command commands[] = {add_segment(app), add_track(app),     add_evaluate(app),   add_report(app), add_bench(app),
                              add_synth(app),   add_calibrate(app), add_completion(app), add_man(app)};
  if (argc > 1) check_command(commands, argv[1]);
  try {
    app.parse(words_to_parse(argc, argv));
  } catch (const CLI::ParseError& error) {
    return finish_parsing(app, error);
  }
  for (const Command& command : commands) {
    if (command.app->parsed()) return command.run();
  }
  throw UsageError("a command is required: segment, track, evaluate, report, bench, synth or calibrate", kSeeHelp);
}

int guarded_run(int argc, char** argv) {
  try {
    run(argc, argv);
    return kExitDone;
  } catch (const UsageError& error) {
    log(error.what());
    if (!error.hint.empty()) write_stderr(error.hint + "\n");
    return kExitUsage;
  } catch (const Failure& error) {
    log(error.what());
  } catch (const std::bad_alloc&) {
    log("out of memory");
  } catch (const std::filesystem::filesystem_error& error) {  // a link that leads in a circle, a name that is too long
    log(fmt::format("{}: {}", error.path1().string(), error.code().message()));
  } catch (const std::exception& error) {
    log(fmt::format("internal error: {}", error.what()));
  }
  return kExitFailure;
}

}  // namespace
}  // namespace fransac::cli

int main(int argc, char** argv) {
  fransac::cli::prepare_process();
  return fransac::cli::guarded_run(argc, argv);
}
