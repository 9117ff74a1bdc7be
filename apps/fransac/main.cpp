// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <exception>
#include <filesystem>
#include <new>
#include <string>
#include <string_view>

#include "command_line.hpp"
#include "commands.hpp"
#include "errors.hpp"
#include "fransac/planes/tuning.hpp"
#include "fransac/version.hpp"
#include "output.hpp"
#include "process.hpp"

namespace fransac::cli {
namespace {

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

void run(int argc, char** argv) {
  if (lists_constants(argc, argv)) return;
  const Program program{.name = "fransac",
                        .version = kVersion,
                        .purpose = "Planes in depth frames and point clouds",
                        .footer = "Exit codes: 0 done, 1 the input could not be used or an output not be written, 2 wrong usage.",
                        .commands = {segment_command(), track_command(), evaluate_command(), report_command(), bench_command(),
                                     synth_command(), calibrate_command()}};
  run_command_line(program, argc, argv);
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
