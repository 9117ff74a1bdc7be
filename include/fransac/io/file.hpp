// SPDX-License-Identifier: Apache-2.0
/// Whole files in and out.
#pragma once

#include <cstddef>
#include <filesystem>
#include <memory>
#include <span>
#include <string_view>
#include <vector>

#include "fransac/core/result.hpp"

namespace fransac::io {

/// Reads a whole regular file, or a stream that is named as the process's own open file: /dev/stdin, /dev/fd/3. Errors name the
/// file. Folders, pipes and devices behind other names, which may never end, and files above `max_bytes` are refused.
Result<std::vector<std::byte>> read_file(const std::filesystem::path& file, std::size_t max_bytes);
/// The same into `bytes`, whose memory is used again.
Status read_file(const std::filesystem::path& file, std::size_t max_bytes, std::vector<std::byte>& bytes);

/// A file that is written piece by piece and has its name only when it is whole: until commit() the bytes are in a temporary of
/// its folder, which a failure or the end of this object removes. What a process that was killed leaves is removed by the next
/// one that writes the same file. Permissions of a file that is replaced are kept; of a link, what it leads to is replaced.
/// Things that are not regular files (/dev/full, a pipe) and the process's own open files (/dev/stdout, /dev/fd/3) are written in
/// place, piece by piece. Errors name the file.
class OutputFile {
 public:
  /// Errors: io where the file cannot be made, or its old self not be written.
  static Result<OutputFile> create(const std::filesystem::path& file);
  OutputFile(OutputFile&&) noexcept;
  OutputFile& operator=(OutputFile&&) noexcept;
  ~OutputFile();

  /// Appends.
  Status write(std::span<const std::byte> bytes);
  /// The same of text.
  Status write(std::string_view text);
  /// Flushes, and gives the file its name. Only once, and nothing is written after it.
  Status commit();

 private:
  struct Implementation;
  explicit OutputFile(std::unique_ptr<Implementation> implementation);
  std::unique_ptr<Implementation> implementation_;
};

/// A folder that is there only when all that is in it is whole: until commit() it has a temporary name, which a failure or the
/// end of this object removes with all that is in it. An empty folder of that name is filled at the end.
class OutputFolder {
 public:
  /// Errors: io where the folder is not empty, or cannot be made.
  static Result<OutputFolder> create(const std::filesystem::path& folder);
  OutputFolder(OutputFolder&&) noexcept;
  OutputFolder& operator=(OutputFolder&&) noexcept;
  ~OutputFolder();

  /// Where to write until commit().
  [[nodiscard]] const std::filesystem::path& path() const;
  /// Gives the folder its name. Only once.
  Status commit();

 private:
  struct Implementation;
  explicit OutputFolder(std::unique_ptr<Implementation> implementation);
  std::unique_ptr<Implementation> implementation_;
};

/// Writes a whole file by way of an OutputFile: readers see the old file or the new one, and a failure (full disk, no permission)
/// leaves the old one.
Status write_file(const std::filesystem::path& file, std::span<const std::byte> bytes);
/// The same of text.
Status write_file(const std::filesystem::path& file, std::string_view text);

/// Removes the temporaries of all that this process is writing. Threads that would begin or end such a file wait from then on,
/// for ever: for a program that a signal ends at once (not for the signal's handler, but for a thread that waits for it).
void abandon_outputs() noexcept;

}  // namespace fransac::io
