// SPDX-License-Identifier: Apache-2.0
#include "process.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <atomic>
#include <csignal>
#include <system_error>
#include <thread>

#include "fransac/io/file.hpp"

namespace fransac::cli {
namespace {

std::atomic<bool> g_notes_interrupts{false};
std::atomic<bool> g_interrupted{false};

void open_standard_files() {
  for (const int number : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO}) {
    if (::fcntl(number, F_GETFD) >= 0) continue;
    // The lowest free number is this one. Open the wrong way round, so that it can be neither read nor written.
    (void)::open("/dev/null", number == STDIN_FILENO ? O_WRONLY : O_RDONLY);
  }
}

/// Those that somebody wants ignored, as nohup does, stay ignored.
sigset_t signals_to_wait_for() {
  sigset_t set;
  sigemptyset(&set);
  for (const int signal : {SIGINT, SIGTERM, SIGHUP}) {
    struct sigaction action {};
    if (::sigaction(signal, nullptr, &action) == 0 && action.sa_handler != SIG_IGN) sigaddset(&set, signal);
  }
  return set;
}

void die_of(int signal) {
  std::signal(signal, SIG_DFL);
  sigset_t set;
  sigemptyset(&set);
  sigaddset(&set, signal);
  ::pthread_sigmask(SIG_UNBLOCK, &set, nullptr);
  (void)std::raise(signal);
  constexpr int kKilledBy = 128;  // as shells count
  ::_exit(kKilledBy + signal);    // the first process of a container outlives signals
}

void wait_for_signals(const sigset_t& set) {
  for (;;) {
    int signal = 0;
    if (::sigwait(&set, &signal) != 0) continue;
    if (signal == SIGINT && g_notes_interrupts && !g_interrupted.exchange(true)) continue;
    io::abandon_outputs();
    die_of(signal);
  }
}

}  // namespace

void prepare_process() {
  open_standard_files();
  std::signal(SIGPIPE, SIG_IGN);
  std::signal(SIGXFSZ, SIG_IGN);
  const sigset_t set = signals_to_wait_for();
  sigset_t before;
  ::pthread_sigmask(SIG_BLOCK, &set, &before);  // of this thread and of all that it makes
  try {
    std::thread([set] { wait_for_signals(set); }).detach();
  } catch (const std::system_error&) {  // no thread can be made: signals end the program at once, as they do by default
    ::pthread_sigmask(SIG_SETMASK, &before, nullptr);
  }
}

InterruptGuard::InterruptGuard() {
  g_interrupted = false;
  g_notes_interrupts = true;
}
InterruptGuard::~InterruptGuard() { g_notes_interrupts = interrupted(); }  // the end that was asked for is on its way

bool InterruptGuard::interrupted() {
  sigset_t pending;  // sent, but not yet seen by the thread that waits
  return g_interrupted || (::sigpending(&pending) == 0 && sigismember(&pending, SIGINT) == 1);
}

}  // namespace fransac::cli
