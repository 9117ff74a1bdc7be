// SPDX-License-Identifier: Apache-2.0
#include "fransac/io/file.hpp"

#include <sys/stat.h>

#include <algorithm>
#include <string>
#include <utility>

#include "io/descriptor.h"
#include "io/file_head.h"
#include "io/guard.h"

namespace fransac::io {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kReadBlock = std::size_t{1} << 16;  // first block of an input whose size is unknown

Error too_large(const fs::path& file, std::size_t max_bytes) {
  return io_error(file, "larger than the limit of " + std::to_string(max_bytes) + " bytes");
}

/// Fills `buffer` from where the file stands; fewer bytes only at its end.
Result<std::size_t> read_into(const Descriptor& descriptor, const fs::path& file, std::span<std::byte> buffer) {
  std::size_t filled = 0;
  while (filled < buffer.size()) {
    const ssize_t got = ::read(descriptor.number(), buffer.data() + filled, buffer.size() - filled);
    if (got < 0 && errno == EINTR) continue;
    if (got < 0) return errno_error(file, errno);
    if (got == 0) break;
    filled += static_cast<std::size_t>(got);
  }
  return filled;
}

/// Reads to the end; `expected` is only a guess at the size.
Status read_all(const Descriptor& descriptor, const fs::path& file, std::size_t expected, std::size_t max_bytes,
                std::vector<std::byte>& bytes) {
  bytes.resize(expected);
  for (std::size_t filled = 0;;) {
    const Result<std::size_t> got = read_into(descriptor, file, std::span(bytes).subspan(filled));
    if (!got) return got.error();
    filled += *got;
    if (filled > max_bytes) return too_large(file, max_bytes);
    if (filled < bytes.size()) {
      bytes.resize(filled);
      return {};
    }
    bytes.resize(filled + std::max(kReadBlock, filled / 2));
  }
}

/// Names of the process's own open files, which a user gives on purpose: standard input, a pipe of the shell.
bool names_descriptor(const fs::path& file) {
  const fs::path parent = file.parent_path();
  return file == "/dev/stdin" || parent == "/dev/fd" || parent == "/proc/self/fd";
}

struct OpenInput {
  Descriptor descriptor;
  std::size_t size = 0;  ///< Bytes of a regular file; 0: not known.
};

/// A pipe or a device behind a name that a folder, a list or a link gives could wait or read for ever.
Result<OpenInput> open_input(const fs::path& file) {
  const bool any_kind = names_descriptor(file);
  struct stat info {};
  const auto check_kind = [&]() -> Status {
    if (S_ISDIR(info.st_mode)) return errno_error(file, EISDIR);
    return any_kind || S_ISREG(info.st_mode) ? Status() : io_error(file, "is not a regular file");
  };
  if (::stat(file.c_str(), &info) != 0) return errno_error(file, errno);
  if (const Status status = check_kind(); !status) return status.error();  // opening alone can have effects
  Descriptor descriptor = open_file(file, any_kind ? O_RDONLY : O_RDONLY | O_NONBLOCK);
  if (!descriptor.valid() || ::fstat(descriptor.number(), &info) != 0) return errno_error(file, errno);
  if (const Status status = check_kind(); !status) return status.error();
  return OpenInput{std::move(descriptor), S_ISREG(info.st_mode) ? static_cast<std::size_t>(info.st_size) : 0};
}

}  // namespace

Result<std::vector<std::byte>> read_file(const fs::path& file, std::size_t max_bytes) {
  return guarded(file.native(), [&]() -> Result<std::vector<std::byte>> {
    std::vector<std::byte> bytes;
    if (Status status = read_file(file, max_bytes, bytes); !status) return status.error();
    return bytes;
  });
}

Status read_file(const fs::path& file, std::size_t max_bytes, std::vector<std::byte>& bytes) {
  return guarded(file.native(), [&]() -> Status {
    const Result<OpenInput> input = open_input(file);
    if (!input) return input.error();
    if (input->size > max_bytes) return too_large(file, max_bytes);
    return read_all(input->descriptor, file, input->size + 1, max_bytes, bytes);  // the one more meets the end without growing
  });
}

Result<std::vector<std::byte>> read_head(const fs::path& file, std::size_t max_bytes) {
  return guarded(file.native(), [&]() -> Result<std::vector<std::byte>> {
    const Result<OpenInput> input = open_input(file);
    if (!input) return input.error();
    std::vector<std::byte> bytes(max_bytes);
    const Result<std::size_t> size = read_into(input->descriptor, file, bytes);
    if (!size) return size.error();
    bytes.resize(*size);
    return bytes;
  });
}

}  // namespace fransac::io
