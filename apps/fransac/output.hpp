// SPDX-License-Identifier: Apache-2.0
/// What commands print and write.
#pragma once

#include <filesystem>
#include <functional>
#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "fransac/io/file.hpp"

namespace fransac::cli {

/// Results go here. Throws StdoutFailure when the text could not be written (full disk, closed pipe).
void write_stdout(std::string_view text);
/// What is said while a command works; lost where stderr cannot be written, for a run's results are worth more.
void write_stderr(std::string_view text) noexcept;
/// A line on stderr, after "fransac: "; lost where it cannot be written.
void log(std::string_view text) noexcept;

/// Text of a JSON document; names that are not UTF-8 cannot make it fail. `indent` -1: on one line.
std::string to_text(const nlohmann::ordered_json& json, int indent = 2);

/// A result in a machine's form: where it goes ("-": stdout, empty: nowhere) and what makes its text.
struct Document {
  std::string file;
  std::function<std::string()> text;
};
/// Writes what is asked for; the table goes to stdout unless a document does.
void write_results(const std::vector<Document>& documents, const std::function<std::string()>& table);

/// Rows of text in aligned columns. A heading that starts with '<' (dropped) makes its column flush left. A column with nothing
/// in it is left out.
class Table {
 public:
  explicit Table(std::vector<std::string> headings);
  void add(std::vector<std::string> cells);
  /// A line between rows.
  void rule() { rows_.emplace_back(); }
  [[nodiscard]] std::string text() const;

 private:
  std::vector<bool> left_;
  std::vector<std::vector<std::string>> rows_;  // the headings first; an empty row is a line
};

/// Files that belong together, of a run or of one frame: until commit() none of them is there, and where it is not called nothing
/// that existed has changed and no folder is new. Throws Failure.
class Outputs {
 public:
  Outputs() = default;
  Outputs(const Outputs&) = delete;
  Outputs& operator=(const Outputs&) = delete;
  ~Outputs();
  /// Makes a folder unless it exists.
  void make_folder(const std::filesystem::path& folder);
  void write(const std::filesystem::path& file, std::span<const std::byte> bytes);
  void write(const std::filesystem::path& file, std::string_view text) { write(file, std::as_bytes(std::span(text))); }
  void commit();

 private:
  std::vector<std::filesystem::path> new_folders_;
  std::vector<io::OutputFile> files_;
};

}  // namespace fransac::cli
