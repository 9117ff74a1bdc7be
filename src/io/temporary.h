// SPDX-License-Identifier: Apache-2.0
/// Files and folders under temporary names, which nobody mistakes for results and no process leaves behind for long.
#pragma once

#include <sys/types.h>

#include <filesystem>

#include "io/descriptor.h"

namespace fransac::io {

/// A new file or folder in a folder; removed again unless it is moved to its place. Its owner holds a lock on it (flock), which
/// ends with the process: who makes a temporary for the same target removes those whose owner is gone. All functions but
/// the destructor may throw std::bad_alloc.
class Temporary {
 public:
  /// `target`: what it will be called; `shown`: what it is called in messages.
  static Result<Temporary> make_file(const std::filesystem::path& folder, const std::filesystem::path& target,
                                     const std::filesystem::path& shown, mode_t mode);
  static Result<Temporary> make_folder(const std::filesystem::path& folder, const std::filesystem::path& target,
                                       const std::filesystem::path& shown);
  /// Removes what processes that are gone left behind for `target`.
  static void remove_stale(const std::filesystem::path& folder, const std::filesystem::path& target);

  Temporary(Temporary&& other) noexcept;
  Temporary(const Temporary&) = delete;
  Temporary& operator=(const Temporary&) = delete;
  Temporary& operator=(Temporary&&) = delete;
  ~Temporary();

  [[nodiscard]] const std::filesystem::path& name() const { return name_; }
  [[nodiscard]] const Descriptor& descriptor() const { return descriptor_; }
  /// Closes the file, whose last errors are errors of this.
  Status move_to(const std::filesystem::path& target);
  /// Moves what is in a temporary folder into another one, files after folders.
  Status move_content_to(const std::filesystem::path& folder);

  /// See abandon_outputs().
  static void abandon_all() noexcept;

 private:
  Temporary(std::filesystem::path name, std::filesystem::path shown, Descriptor descriptor)
      : name_(std::move(name)), shown_(std::move(shown)), descriptor_(std::move(descriptor)) {}
  template <class Make>
  static Result<Temporary> make(const std::filesystem::path& folder, const std::filesystem::path& target,
                                const std::filesystem::path& shown, const Make& make_one);

  std::filesystem::path name_;  // empty: no longer this object's
  std::filesystem::path shown_;
  Descriptor descriptor_;
};

}  // namespace fransac::io
