// SPDX-License-Identifier: Apache-2.0
/// The subcommands. Each adds itself to the application and returns what runs it once the command line is parsed; the
/// returned function may throw Failure or UsageError.
#pragma once

#include <functional>

namespace CLI {
class App;
}

namespace fransac::cli {

struct Command {
  CLI::App* app = nullptr;
  std::function<void()> run;
};

Command add_segment(CLI::App& parent);
Command add_evaluate(CLI::App& parent);
Command add_report(CLI::App& parent);
Command add_bench(CLI::App& parent);
Command add_synth(CLI::App& parent);
Command add_track(CLI::App& parent);
Command add_calibrate(CLI::App& parent);
Command add_completion(CLI::App& parent);
Command add_man(CLI::App& parent);

}  // namespace fransac::cli
