// SPDX-License-Identifier: Apache-2.0
#include "fransac/io/file.hpp"

#include <sys/stat.h>

#include <algorithm>
#include <string>

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
Result<std::vector<std::byte>> read_all(const Descriptor& descriptor, const fs::path& file, std::size_t expected,
                                        std::size_t max_bytes) {
  std::vector<std::byte> bytes(expected);
  for (std::size_t filled = 0;;) {
    const Result<std::size_t> got = read_into(descriptor, file, std::span(bytes).subspan(filled));
    if (!got) return got.error();
    filled += *got;
    if (filled > max_bytes) return too_large(file, max_bytes);
    if (filled < bytes.size()) {
      bytes.resize(filled);
      return bytes;
    }
    bytes.resize(filled + std::max(kReadBlock, filled / 2));
  }
}

}  // namespace

Result<std::vector<std::byte>> read_file(const fs::path& file, std::size_t max_bytes) {
  return guarded(file.native(), [&]() -> Result<std::vector<std::byte>> {
    const Descriptor descriptor = open_file(file, O_RDONLY);
    if (!descriptor.valid()) return errno_error(file, errno);
    struct stat info {};
    if (::fstat(descriptor.number(), &info) != 0) return errno_error(file, errno);
    if (S_ISDIR(info.st_mode)) return errno_error(file, EISDIR);
    const std::size_t size = S_ISREG(info.st_mode) ? static_cast<std::size_t>(info.st_size) : 0;
    if (size > max_bytes) return too_large(file, max_bytes);
    return read_all(descriptor, file, size + 1, max_bytes);  // the one more meets the end without growing
  });
}

Result<std::vector<std::byte>> read_head(const fs::path& file, std::size_t max_bytes) {
  return guarded(file.native(), [&]() -> Result<std::vector<std::byte>> {
    const Descriptor descriptor = open_file(file, O_RDONLY);
    if (!descriptor.valid()) return errno_error(file, errno);
    std::vector<std::byte> bytes(max_bytes);
    const Result<std::size_t> size = read_into(descriptor, file, bytes);
    if (!size) return size.error();
    bytes.resize(*size);
    return bytes;
  });
}

}  // namespace fransac::io
