// SPDX-License-Identifier: Apache-2.0
/// Open files of the system, and what goes wrong with them.
#pragma once

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <filesystem>
#include <string_view>
#include <system_error>
#include <utility>

#include "io/guard.h"

namespace fransac::io {

inline Error io_error(const std::filesystem::path& file, std::string_view what) {
  return file_error(ErrorCode::io, file.native(), what);
}

inline Error errno_error(const std::filesystem::path& file, int number) {
  return file_error(number == ENOMEM ? ErrorCode::out_of_memory : ErrorCode::io, file.native(),
                    std::generic_category().message(number));
}

/// Owns a file descriptor.
class Descriptor {
 public:
  explicit Descriptor(int number = -1) : number_(number) {}
  Descriptor(Descriptor&& other) noexcept : number_(std::exchange(other.number_, -1)) {}
  Descriptor& operator=(Descriptor&& other) noexcept {
    std::swap(number_, other.number_);
    return *this;
  }
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;
  ~Descriptor() { close(); }

  [[nodiscard]] int number() const { return number_; }
  [[nodiscard]] bool valid() const { return number_ >= 0; }
  /// False, with errno set, when the system reports a late write error.
  bool close() { return !valid() || ::close(std::exchange(number_, -1)) == 0; }

 private:
  int number_;
};

/// Not valid, with errno set, where the file cannot be opened.
template <class... Mode>
Descriptor open_file(const std::filesystem::path& file, int flags, Mode... mode) {
  int number = -1;
  do {
    number = ::open(file.c_str(), flags | O_CLOEXEC | O_NOCTTY, mode...);
  } while (number < 0 && errno == EINTR);
  return Descriptor(number);
}

}  // namespace fransac::io
