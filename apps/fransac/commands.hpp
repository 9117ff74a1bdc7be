// SPDX-License-Identifier: Apache-2.0
/// The commands, each in a file of its own: cmd_NAME.cpp.
#pragma once

#include "command.hpp"

namespace fransac::cli {

Command segment_command();
Command track_command();
Command evaluate_command();
Command report_command();
Command bench_command();
Command synth_command();
Command calibrate_command();

}  // namespace fransac::cli
