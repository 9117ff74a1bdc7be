// SPDX-License-Identifier: Apache-2.0
#include "output.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <system_error>

#include "errors.hpp"
#include "fransac/io/file.hpp"

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

}  // namespace

void write_stdout(std::string_view text) {
  errno = 0;
  const bool written = std::fwrite(text.data(), 1, text.size(), stdout) == text.size() && std::fflush(stdout) == 0;
  if (!written) throw StdoutFailure(fmt::format("standard output: {}", std::generic_category().message(errno)));
}

void log(std::string_view text) { fmt::print(stderr, "fransac: {}\n", text); }

std::string to_text(const nlohmann::ordered_json& json, int indent) {
  return json.dump(indent, ' ', false, nlohmann::ordered_json::error_handler_t::replace) + "\n";
}

void write_text(const std::string& file, std::string_view text) {
  if (file == "-") {
    write_stdout(text);
  } else {
    check(io::write_file(file, text));
  }
}

void write_results(const std::vector<Document>& documents, const std::function<std::string()>& table) {
  bool on_stdout = false;
  for (const Document& document : documents) {
    if (!document.file.empty()) write_text(document.file, document.text());
    on_stdout = on_stdout || document.file == "-";
  }
  if (!on_stdout) write_stdout(table());
}

Table::Table(std::vector<std::string> headings) {
  for (std::string& heading : headings) {
    left_.push_back(heading.starts_with('<'));
    if (left_.back()) heading.erase(0, 1);
  }
  rows_.push_back(std::move(headings));
}

void Table::add(std::vector<std::string> cells) {
  cells.resize(left_.size());
  rows_.push_back(std::move(cells));
}

std::string Table::text() const {
  std::vector<std::size_t> widths(left_.size(), 0);
  for (std::size_t r = rows_.size(); r-- > 0;) {
    for (std::size_t c = 0; c < rows_[r].size(); ++c) {
      const bool nothing_below = r == 0 && rows_.size() > 1 && widths[c] == 0;
      if (!nothing_below) widths[c] = std::max(widths[c], rows_[r][c].size());
    }
  }
  std::size_t total = 0;
  for (const std::size_t width : widths) total += (total > 0 && width > 0 ? 2 : 0) + width;

  std::string text;
  for (const auto& row : rows_) {
    std::string line = row.empty() ? std::string(total, '-') : "";
    for (std::size_t c = 0; c < row.size(); ++c) {
      if (widths[c] == 0) continue;
      const std::string padding(widths[c] - row[c].size(), ' ');
      line += (line.empty() ? "" : "  ") + (left_[c] ? row[c] + padding : padding + row[c]);
    }
    line.erase(line.find_last_not_of(' ') + 1);
    text += line + "\n";
  }
  return text;
}

void check_output_file(std::string_view option, const fs::path& file) {
  if (file.empty()) throw UsageError(fmt::format("{}: the file name is empty", option));
  std::error_code error;
  const fs::file_status status = fs::status(file, error);
  if (fs::is_directory(status)) throw Failure(fmt::format("{}: '{}' is a folder", option, file.string()));
  if (fs::exists(status) && !writable(file)) throw Failure(fmt::format("{}: '{}' is not writable", option, file.string()));
  if (!fs::exists(status) || fs::is_regular_file(status)) check_parent(option, file);  // devices and pipes need no temporary
}

void check_document(std::string_view option, const std::string& file) {
  if (!file.empty() && file != "-") check_output_file(option, file);
}

void check_output_folder(std::string_view option, const fs::path& folder) {
  if (folder.empty()) throw UsageError(fmt::format("{}: the folder's name is empty", option));
  std::error_code error;
  const fs::file_status status = fs::status(folder, error);
  if (!fs::exists(status)) return check_parent(option, folder.has_filename() ? folder : folder.parent_path());
  if (!fs::is_directory(status)) throw Failure(fmt::format("{}: '{}' is not a folder", option, folder.string()));
  if (!writable(folder)) throw Failure(fmt::format("{}: the folder '{}' is not writable", option, folder.string()));
}

Unfinished::~Unfinished() {
  std::error_code ignored;
  for (const fs::path& path : written_) fs::remove_all(path, ignored);
  for (const fs::path& folder : folders_) fs::remove(folder, ignored);
}

void Unfinished::make_folder(const fs::path& folder) {
  std::error_code error;
  const bool made = fs::create_directory(folder, error);
  if (error) throw Failure(fmt::format("{}: {}", folder.string(), error.message()));
  if (made) folders_.push_back(folder);
}

fs::path Unfinished::add(const fs::path& path) {
  std::error_code error;
  if (!fs::exists(path, error)) written_.push_back(path);
  return path;
}

void Unfinished::finish() {
  written_.clear();
  folders_.clear();
}

}  // namespace fransac::cli
