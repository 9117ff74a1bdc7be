// SPDX-License-Identifier: Apache-2.0
/// The files of a run: what it reads and where it writes, checked before any work is done.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "fransac/io/dataset.hpp"

namespace fransac::cli {

/// Every input is named here when it is opened, and every output before the first is written: no output may be an input, nor be
/// written twice.
class RunFiles {
 public:
  void reads(const std::filesystem::path& file);
  void reads(const io::Dataset& dataset);

  /// Refuses a file that could not be written: a missing folder, no permission, a folder of that name; a file of the input, read
  /// or not; one that is written already. Throws Failure or UsageError, which name `option`.
  void writes(std::string_view option, const std::filesystem::path& file);
  /// The same for an option that may be empty or "-".
  void writes_document(std::string_view option, const std::string& file);
  /// Refuses a folder that neither exists nor can be made in an existing one, or that could not be written to. Files in it may
  /// be named before it is made.
  void writes_folder(std::string_view option, const std::filesystem::path& folder);

 private:
  /// Regular files by device and number, whatever their names; those that do not exist by their path.
  struct Identities {
    std::set<std::pair<std::uint64_t, std::uint64_t>> numbers;
    std::set<std::filesystem::path> paths;

    [[nodiscard]] bool contains(const std::filesystem::path& file) const;
    void insert(const std::filesystem::path& file);
  };

  Identities read_;
  Identities written_;
  std::set<std::filesystem::path> new_folders_;
};

}  // namespace fransac::cli
