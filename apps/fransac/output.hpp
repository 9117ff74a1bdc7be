// SPDX-License-Identifier: Apache-2.0
/// What commands print and write.
#pragma once

#include <filesystem>
#include <functional>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <vector>

namespace fransac::cli {

/// Results go here. Throws StdoutFailure when the text could not be written (full disk, closed pipe).
void write_stdout(std::string_view text);
/// A line on stderr, after "fransac: ".
void log(std::string_view text);

/// Text of a JSON document; names that are not UTF-8 cannot make it fail. `indent` -1: on one line.
std::string to_text(const nlohmann::ordered_json& json, int indent = 2);

/// Writes a document to a file, or to stdout when `file` is "-".
void write_text(const std::string& file, std::string_view text);

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

/// Refuses a file that could not be written later: missing folder, no permission, a folder of that name. Throws Failure
/// that names `option`.
void check_output_file(std::string_view option, const std::filesystem::path& file);
/// The same for an option that may be empty or "-".
void check_document(std::string_view option, const std::string& file);
/// The same for a folder that exists or can be made in an existing one.
void check_output_folder(std::string_view option, const std::filesystem::path& folder);

/// Removes again what was newly written unless it is all there; what existed before stays as it is by then.
class Unfinished {
 public:
  Unfinished() = default;
  Unfinished(const Unfinished&) = delete;
  Unfinished& operator=(const Unfinished&) = delete;
  ~Unfinished();
  /// Makes a folder unless it exists. Throws Failure.
  void make_folder(const std::filesystem::path& folder);
  /// Notes, and returns, the file or folder that is written next.
  std::filesystem::path add(const std::filesystem::path& path);
  void finish();

 private:
  std::vector<std::filesystem::path> folders_;  // removed only when empty: others may have put something there
  std::vector<std::filesystem::path> written_;
};

}  // namespace fransac::cli
