// SPDX-License-Identifier: Apache-2.0
#include "run_files.hpp"

#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <system_error>
#include <variant>

#include "errors.hpp"

namespace fransac::cli {
namespace {

namespace fs = std::filesystem;

/// The user may not write to it, or nobody should: a file without any write permission is protected from its owner, and
/// even from root, on purpose.
bool writable(const fs::path& path) {
  constexpr auto kAnyWrite = fs::perms::owner_write | fs::perms::group_write | fs::perms::others_write;
  std::error_code error;
  return (fs::status(path, error).permissions() & kAnyWrite) != fs::perms::none && ::access(path.c_str(), W_OK) == 0;
}

void check_parent(std::string_view option, const fs::path& path) {
  const fs::path parent = path.has_parent_path() ? path.parent_path() : fs::path(".");
  std::error_code error;
  if (!fs::is_directory(parent, error)) throw Failure(fmt::format("{}: the folder '{}' does not exist", option, parent.string()));
  if (!writable(parent)) throw Failure(fmt::format("{}: the folder '{}' is not writable", option, parent.string()));
}

/// What is there; not_found where nothing is. Throws Failure where that cannot be told.
fs::file_status status_of(std::string_view option, const fs::path& path) {
  std::error_code error;
  const fs::file_status status = fs::status(path, error);
  if (!fs::status_known(status)) throw Failure(fmt::format("{}: {}: {}", option, path.string(), error.message()));
  return status;
}

using FileNumber = std::pair<std::uint64_t, std::uint64_t>;
/// Of devices and pipes there is nothing to tell apart.
using Identity = std::variant<std::monostate, FileNumber, fs::path>;

Identity identity_of(const fs::path& file) {
  struct stat info {};
  if (::stat(file.c_str(), &info) == 0)
    return S_ISREG(info.st_mode) ? Identity(FileNumber(info.st_dev, info.st_ino)) : Identity();
  std::error_code error;
  fs::path path = fs::weakly_canonical(fs::absolute(file, error), error);
  return error ? Identity() : Identity(std::move(path));
}

/// Names of the process's own open files: it may write what they lead to, whatever the files' modes say now.
bool names_open_file(const fs::path& file) {
  const fs::path folder = file.parent_path();
  return file == "/dev/stdout" || file == "/dev/stderr" || folder == "/dev/fd" || folder == "/proc/self/fd";
}

}  // namespace

bool RunFiles::Identities::contains(const fs::path& file) const {
  const Identity identity = identity_of(file);
  if (const auto* const number = std::get_if<FileNumber>(&identity)) return numbers.contains(*number);
  const auto* const path = std::get_if<fs::path>(&identity);
  return path != nullptr && paths.contains(*path);
}

void RunFiles::Identities::insert(const fs::path& file) {
  Identity identity = identity_of(file);
  if (const auto* const number = std::get_if<FileNumber>(&identity)) numbers.insert(*number);
  if (auto* const path = std::get_if<fs::path>(&identity)) paths.insert(std::move(*path));
}

void RunFiles::reads(const fs::path& file) { read_.insert(file); }

void RunFiles::reads(const io::Dataset& dataset) {
  for (const fs::path& file : dataset.files) reads(file);
  for (const io::FrameFiles& frame : dataset.frames) {
    reads(frame.depth);
    for (const auto* const file :
         {&frame.colour, &frame.labels, &frame.objects, &frame.regions, &frame.truth, &frame.camera_file}) {
      if (*file) reads(**file);
    }
  }
}

void RunFiles::writes(std::string_view option, const fs::path& file) {
  if (file.empty()) throw UsageError(fmt::format("{}: the file name is empty", option));
  const fs::file_status status = status_of(option, file);
  if (fs::is_directory(status)) throw Failure(fmt::format("{}: '{}' is a folder", option, file.string()));
  const bool is_open = names_open_file(file);
  if (fs::exists(status) && !is_open && !writable(file)) {
    throw Failure(fmt::format("{}: '{}' is not writable", option, file.string()));
  }
  // Devices, pipes and what is open already need no temporary.
  const bool in_place = is_open || (fs::exists(status) && !fs::is_regular_file(status));
  if (!in_place && !new_folders_.contains(file.parent_path())) check_parent(option, file);
  if (read_.contains(file)) throw UsageError(fmt::format("{}: '{}' is part of the input", option, file.string()));
  if (written_.contains(file)) throw UsageError(fmt::format("{}: '{}' would be written twice", option, file.string()));
  written_.insert(file);
}

void RunFiles::writes_document(std::string_view option, const std::string& file) {
  if (!file.empty() && file != "-") writes(option, file);
}

void RunFiles::writes_folder(std::string_view option, const fs::path& folder) {
  if (folder.empty()) throw UsageError(fmt::format("{}: the folder's name is empty", option));
  const fs::file_status status = status_of(option, folder);
  if (!fs::exists(status)) {
    new_folders_.insert((folder / "").parent_path());  // as files in it name it
    return check_parent(option, folder.has_filename() ? folder : folder.parent_path());
  }
  if (!fs::is_directory(status)) throw Failure(fmt::format("{}: '{}' is not a folder", option, folder.string()));
  if (!writable(folder)) throw Failure(fmt::format("{}: the folder '{}' is not writable", option, folder.string()));
}

}  // namespace fransac::cli
