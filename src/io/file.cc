// SPDX-License-Identifier: Apache-2.0
#include "fransac/io/file.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <optional>
#include <string>
#include <system_error>
#include <utility>

#include "io/file_head.h"
#include "io/guard.h"

namespace fransac::io {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kReadBlock = std::size_t{1} << 16;  // first block of an input whose size is unknown

Error io_error(const fs::path& file, std::string_view what) { return {ErrorCode::io, file.string() + ": " + std::string(what)}; }

Error errno_error(const fs::path& file, int number) { return io_error(file, std::generic_category().message(number)); }

Error too_large(const fs::path& file, std::size_t max_bytes) {
  return io_error(file, "larger than the limit of " + std::to_string(max_bytes) + " bytes");
}

/// Owns a file descriptor.
class Descriptor {
 public:
  explicit Descriptor(int number) : number_(number) {}
  Descriptor(Descriptor&& other) noexcept : number_(std::exchange(other.number_, -1)) {}
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;
  Descriptor& operator=(Descriptor&&) = delete;
  ~Descriptor() { close(); }

  [[nodiscard]] int number() const { return number_; }
  [[nodiscard]] bool valid() const { return number_ >= 0; }
  /// False, with errno set, when the system reports a late write error.
  bool close() { return !valid() || ::close(std::exchange(number_, -1)) == 0; }

 private:
  int number_;
};

template <class... Mode>
Descriptor open_file(const fs::path& file, int flags, Mode... mode) {
  int number = -1;
  do {
    number = ::open(file.c_str(), flags | O_CLOEXEC | O_NOCTTY, mode...);
  } while (number < 0 && errno == EINTR);
  return Descriptor(number);
}

Status write_all(const Descriptor& descriptor, const fs::path& file, std::span<const std::byte> bytes) {
  while (!bytes.empty()) {
    const ssize_t written = ::write(descriptor.number(), bytes.data(), bytes.size());
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) return errno_error(file, errno);
    if (written == 0) return io_error(file, "nothing more could be written");
    bytes = bytes.subspan(static_cast<std::size_t>(written));
  }
  return {};
}

/// Appending, so that a standard output which the shell has pointed at a file keeps what is there already.
Status write_in_place(const fs::path& file, std::span<const std::byte> bytes) {
  Descriptor descriptor = open_file(file, O_WRONLY | O_APPEND);
  if (!descriptor.valid()) return errno_error(file, errno);
  if (Status status = write_all(descriptor, file, bytes); !status) return status;
  if (!descriptor.close()) return errno_error(file, errno);
  return {};
}

/// A new file in `folder` under a name that nobody has; removed again unless it is moved to its place.
class TemporaryFile {
 public:
  static Result<TemporaryFile> create(const fs::path& folder, const fs::path& target) {
    static std::atomic<unsigned> counter{0};
    for (;;) {
      const fs::path name = folder / (".fransac-" + std::to_string(::getpid()) + "-" + std::to_string(counter++) + ".tmp");
      Descriptor descriptor = open_file(name, O_WRONLY | O_CREAT | O_EXCL, mode_t{0666});
      if (descriptor.valid()) return TemporaryFile(name, std::move(descriptor));
      if (errno != EEXIST) return errno_error(target, errno);
    }
  }
  TemporaryFile(TemporaryFile&& other) noexcept
      : name_(std::exchange(other.name_, fs::path())), descriptor_(std::move(other.descriptor_)) {}
  TemporaryFile(const TemporaryFile&) = delete;
  TemporaryFile& operator=(const TemporaryFile&) = delete;
  TemporaryFile& operator=(TemporaryFile&&) = delete;
  ~TemporaryFile() {
    if (!name_.empty()) ::unlink(name_.c_str());
  }

  [[nodiscard]] const Descriptor& descriptor() const { return descriptor_; }

  Status move_to(const fs::path& target) {
    if (::fsync(descriptor_.number()) != 0 && errno != EINVAL)
      return errno_error(target, errno);  // EINVAL: cannot be synchronised
    if (!descriptor_.close() || ::rename(name_.c_str(), target.c_str()) != 0) return errno_error(target, errno);
    name_.clear();
    return {};
  }

 private:
  TemporaryFile(fs::path name, Descriptor descriptor) : name_(std::move(name)), descriptor_(std::move(descriptor)) {}

  fs::path name_;  // empty: no longer this object's
  Descriptor descriptor_;
};

/// Names of the process's own open files: they may lead to a regular file, which must not be replaced behind its back.
bool names_descriptor(const fs::path& file) {
  const fs::path parent = file.parent_path();
  return file == "/dev/stdout" || file == "/dev/stderr" || parent == "/dev/fd" || parent == "/proc/self/fd";
}

/// `old_mode`: permissions of the file that is replaced.
Status replace_file(const fs::path& target, std::optional<mode_t> old_mode, std::span<const std::byte> bytes) {
  const fs::path folder = target.has_parent_path() ? target.parent_path() : fs::path(".");
  Result<TemporaryFile> temporary = TemporaryFile::create(folder, target);
  if (!temporary) return temporary.error();
  const Descriptor& descriptor = temporary->descriptor();
  if (old_mode && ::fchmod(descriptor.number(), *old_mode) != 0) return errno_error(target, errno);
  if (Status status = write_all(descriptor, target, bytes); !status) return status;
  return temporary->move_to(target);
}

Status write_anywhere(const fs::path& file, std::span<const std::byte> bytes) {
  if (names_descriptor(file)) return write_in_place(file, bytes);
  struct stat info {};
  if (::stat(file.c_str(), &info) != 0) {
    if (errno != ENOENT) return errno_error(file, errno);
    return replace_file(file, std::nullopt, bytes);
  }
  if (S_ISDIR(info.st_mode)) return errno_error(file, EISDIR);
  if (!S_ISREG(info.st_mode)) return write_in_place(file, bytes);
  if (::access(file.c_str(), W_OK) != 0) return errno_error(file, errno);  // a rename alone would not ask
  std::error_code error;
  const fs::path target = fs::is_symlink(file, error) ? fs::canonical(file, error) : file;  // the link stays, its target changes
  if (error) return io_error(file, error.message());
  return replace_file(target, info.st_mode & 07777, bytes);
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

Status write_file(const fs::path& file, std::span<const std::byte> bytes) {
  return guarded(file.native(), [&] { return write_anywhere(file, bytes); });
}

Status write_file(const fs::path& file, std::string_view text) { return write_file(file, std::as_bytes(std::span(text))); }

}  // namespace fransac::io
