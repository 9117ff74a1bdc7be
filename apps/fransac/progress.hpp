// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <fmt/format.h>
#include <unistd.h>

#include <cstddef>
#include <string_view>

#include "fransac/core/printable.hpp"
#include "output.hpp"

namespace fransac::cli {

/// One line on stderr that says how far a command is; nothing at all when stderr is no terminal or there is only one step.
class Progress {
 public:
  explicit Progress(std::size_t total) : total_(total), shown_(total > 1 && ::isatty(STDERR_FILENO) == 1) {}
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;
  ~Progress() { clear(); }

  /// Begins the next step.
  void step(std::string_view what) {
    ++done_;
    if (!shown_) return;
    clear();
    write_stderr(fmt::format("[{}/{}] {}", done_, total_, printable(what, kLongestName)));
  }
  /// Wipes the line, before something else is printed.
  void clear() const {
    if (shown_) write_stderr("\r\033[K");
  }

 private:
  static constexpr std::size_t kLongestName = 60;  // bytes, of a line of a terminal

  std::size_t total_;
  std::size_t done_ = 0;
  bool shown_;
};

}  // namespace fransac::cli
