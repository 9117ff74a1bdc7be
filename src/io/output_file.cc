// SPDX-License-Identifier: Apache-2.0
#include <sys/stat.h>

#include <charconv>
#include <optional>
#include <string>
#include <utility>

#include "fransac/io/file.hpp"
#include "io/descriptor.h"
#include "io/guard.h"
#include "io/temporary.h"

namespace fransac::io {
namespace {

namespace fs = std::filesystem;

/// Where a path leads.
struct Target {
  fs::path path;                  ///< No link; may not exist.
  std::optional<int> descriptor;  ///< The path is a name of this open file, whatever that is.
};

fs::path folder_of(const fs::path& file) { return file.has_parent_path() ? file.parent_path() : fs::path("."); }

/// The number of this process's open file that an entry of /proc/self/fd stands for.
std::optional<int> descriptor_of(const fs::path& folder, const fs::path& name) {
  std::error_code error;
  const fs::path own = fs::canonical("/proc/self/fd", error);
  if (error || folder != own) return std::nullopt;
  const std::string& digits = name.native();
  int number = -1;
  const auto [end, fault] = std::from_chars(digits.data(), digits.data() + digits.size(), number);
  return fault == std::errc() && end == digits.data() + digits.size() ? std::optional(number) : std::nullopt;
}

/// Follows links one by one: the system's own names of open files are links as well, which lead to the files behind our back.
Result<Target> resolve(const fs::path& file) {
  constexpr int kMostLinks = 40;  // as Linux
  fs::path path = file;
  for (int i = 0; i < kMostLinks; ++i) {
    std::error_code error;
    const fs::path folder = fs::canonical(folder_of(path), error);
    if (error) return errno_error(file, error.value());
    if (const auto descriptor = descriptor_of(folder, path.filename())) return Target{path, descriptor};
    const fs::file_status status = fs::symlink_status(path, error);
    if (!fs::status_known(status)) return errno_error(file, error.value());
    if (!fs::is_symlink(status)) return Target{path, std::nullopt};
    const fs::path next = fs::read_symlink(path, error);
    if (error) return errno_error(file, error.value());
    path = next.is_absolute() ? next : folder / next;
  }
  return errno_error(file, ELOOP);
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

}  // namespace

struct OutputFile::Implementation {
  fs::path file;                       ///< As it was named.
  fs::path target;                     ///< Where it goes.
  std::optional<mode_t> old_mode;      ///< Of the file that is replaced.
  std::optional<Temporary> temporary;  ///< Or else
  Descriptor in_place;

  Status open() {
    const Result<Target> found = resolve(file);
    if (!found) return found.error();
    target = found->path;
    if (found->descriptor) return hold(Descriptor(::fcntl(*found->descriptor, F_DUPFD_CLOEXEC, 0)));
    struct stat info {};
    if (::stat(target.c_str(), &info) == 0) {
      if (S_ISDIR(info.st_mode)) return errno_error(file, EISDIR);
      if (!S_ISREG(info.st_mode)) return hold(open_file(target, O_WRONLY | O_APPEND));
      if (::access(target.c_str(), W_OK) != 0) return errno_error(file, errno);  // a rename alone would not ask
      old_mode = info.st_mode & mode_t{07777};
    } else if (errno != ENOENT) {
      return errno_error(file, errno);
    }
    constexpr mode_t kNew = 0666;
    constexpr mode_t kOwn = S_IRUSR | S_IWUSR;
    Result<Temporary> made = Temporary::make_file(folder_of(target), target, file, (old_mode.value_or(kNew) & kNew) | kOwn);
    if (!made) return made.error();
    temporary.emplace(std::move(made).value());
    return {};
  }

  Status hold(Descriptor descriptor) {
    if (!descriptor.valid()) return errno_error(file, errno);
    in_place = std::move(descriptor);
    return {};
  }

  Status commit() {
    if (!temporary) return in_place.close() ? Status() : errno_error(file, errno);
    if (old_mode && ::fchmod(temporary->descriptor().number(), *old_mode) != 0) return errno_error(file, errno);
    return temporary->move_to(target);
  }
};

OutputFile::OutputFile(std::unique_ptr<Implementation> implementation) : implementation_(std::move(implementation)) {}
OutputFile::OutputFile(OutputFile&& other) noexcept = default;
OutputFile& OutputFile::operator=(OutputFile&& other) noexcept = default;
OutputFile::~OutputFile() = default;

Result<OutputFile> OutputFile::create(const fs::path& file) {
  return guarded(file.native(), [&]() -> Result<OutputFile> {
    auto implementation = std::make_unique<Implementation>();
    implementation->file = file;
    if (const Status status = implementation->open(); !status) return status.error();
    return OutputFile(std::move(implementation));
  });
}

Status OutputFile::write(std::span<const std::byte> bytes) {
  return guarded(implementation_->file.native(), [&] {
    const auto& temporary = implementation_->temporary;
    return write_all(temporary ? temporary->descriptor() : implementation_->in_place, implementation_->file, bytes);
  });
}

Status OutputFile::write(std::string_view text) { return write(std::as_bytes(std::span(text))); }

Status OutputFile::commit() {
  return guarded(implementation_->file.native(), [&] { return implementation_->commit(); });
}

struct OutputFolder::Implementation {
  fs::path folder;     ///< Without a separator at its end.
  bool is_new = true;  ///< There was none before.
  std::optional<Temporary> temporary;

  Status open() {
    if (!folder.has_filename()) folder = folder.parent_path();
    std::error_code error;
    const fs::file_status status = fs::status(folder, error);
    if (!fs::status_known(status)) return errno_error(folder, error.value());
    is_new = !fs::exists(status);
    const fs::path place = is_new ? folder_of(folder) : folder;
    if (!is_new) {
      Temporary::remove_stale(place, folder);
      const bool empty = fs::is_empty(folder, error);
      if (error) return errno_error(folder, error.value());
      if (!empty) return io_error(folder, "is not empty; choose a new folder");
    }
    Result<Temporary> made = Temporary::make_folder(place, folder, folder);
    if (!made) return made.error();
    temporary.emplace(std::move(made).value());
    return {};
  }

  Status commit() { return is_new ? temporary->move_to(folder) : temporary->move_content_to(folder); }
};

OutputFolder::OutputFolder(std::unique_ptr<Implementation> implementation) : implementation_(std::move(implementation)) {}
OutputFolder::OutputFolder(OutputFolder&& other) noexcept = default;
OutputFolder& OutputFolder::operator=(OutputFolder&& other) noexcept = default;
OutputFolder::~OutputFolder() = default;

Result<OutputFolder> OutputFolder::create(const fs::path& folder) {
  return guarded(folder.native(), [&]() -> Result<OutputFolder> {
    auto implementation = std::make_unique<Implementation>();
    implementation->folder = folder;
    if (const Status status = implementation->open(); !status) return status.error();
    return OutputFolder(std::move(implementation));
  });
}

const fs::path& OutputFolder::path() const { return implementation_->temporary->name(); }

Status OutputFolder::commit() {
  return guarded(implementation_->folder.native(), [&] { return implementation_->commit(); });
}

Status write_file(const fs::path& file, std::span<const std::byte> bytes) {
  Result<OutputFile> output = OutputFile::create(file);
  if (!output) return output.error();
  if (Status status = output->write(bytes); !status) return status;
  return output->commit();
}

Status write_file(const fs::path& file, std::string_view text) { return write_file(file, std::as_bytes(std::span(text))); }

void abandon_outputs() noexcept { Temporary::abandon_all(); }

}  // namespace fransac::io
