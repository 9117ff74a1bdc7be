// SPDX-License-Identifier: Apache-2.0
/// The process and the system: standard files and signals.
#pragma once

namespace fransac::cli {

/// To be called first. Standard files that are closed are opened such that using them fails; otherwise the next file to be opened
/// would get their place. A closed pipe or a full file system becomes a failed write with a message. SIGINT, SIGTERM and SIGHUP
/// end the program as they do by default, but what it is writing is removed before.
void prepare_process();

/// While one lives, the first SIGINT is only noted, and a second one ends the program.
class InterruptGuard {
 public:
  InterruptGuard();
  InterruptGuard(const InterruptGuard&) = delete;
  InterruptGuard& operator=(const InterruptGuard&) = delete;
  ~InterruptGuard();
  /// Whether one has been noted.
  [[nodiscard]] static bool interrupted();
};

}  // namespace fransac::cli
