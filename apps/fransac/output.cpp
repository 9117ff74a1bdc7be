// SPDX-License-Identifier: Apache-2.0
#include "output.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <system_error>

#include "errors.hpp"
#include "fransac/core/printable.hpp"

namespace fransac::cli {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kLongestMessage = 4096;  // bytes
constexpr std::size_t kLongestCell = 256;

}  // namespace

void write_stdout(std::string_view text) {
  errno = 0;
  const bool written = std::fwrite(text.data(), 1, text.size(), stdout) == text.size() && std::fflush(stdout) == 0;
  if (!written) throw StdoutFailure(fmt::format("standard output: {}", std::generic_category().message(errno)));
}

void write_stderr(std::string_view text) noexcept {
  (void)std::fwrite(text.data(), 1, text.size(), stderr);
  (void)std::fflush(stderr);
}

void log(std::string_view text) noexcept {
  try {
    // One line, and one piece: lines of several processes do not mix.
    write_stderr(fmt::format("fransac: {}\n", printable(text, kLongestMessage)));
  } catch (...) {
    write_stderr("fransac: out of memory\n");
  }
}

std::string to_text(const nlohmann::ordered_json& json, int indent) {
  return json.dump(indent, ' ', false, nlohmann::ordered_json::error_handler_t::replace) + "\n";
}

void write_results(const std::vector<Document>& documents, const std::function<std::string()>& table) {
  Outputs outputs;
  std::string on_stdout;
  for (const Document& document : documents) {
    if (document.file == "-") on_stdout += document.text();
    if (!document.file.empty() && document.file != "-") outputs.write(document.file, document.text());
  }
  write_stdout(on_stdout.empty() ? table() : on_stdout);
  outputs.commit();
}

Table::Table(std::vector<std::string> headings) {
  for (std::string& heading : headings) {
    left_.push_back(heading.starts_with('<'));
    if (left_.back()) heading.erase(0, 1);
  }
  rows_.push_back(std::move(headings));
}

void Table::add(std::vector<std::string> cells) {
  for (std::string& cell : cells) cell = printable(cell, kLongestCell);
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

Outputs::~Outputs() {
  files_.clear();  // temporaries are in the folders
  std::error_code ignored;
  for (const fs::path& folder : new_folders_)
    fs::remove(folder, ignored);  // only when empty: others may have put something there
}

void Outputs::make_folder(const fs::path& folder) {
  std::error_code error;
  const bool made = fs::create_directory(folder, error);
  if (error) throw Failure(fmt::format("{}: {}", folder.string(), error.message()));
  if (made) new_folders_.push_back(folder);
}

void Outputs::write(const fs::path& file, std::span<const std::byte> bytes) {
  files_.push_back(unwrap(io::OutputFile::create(file)));
  check(files_.back().write(bytes));
}

void Outputs::commit() {
  for (io::OutputFile& file : files_) check(file.commit());
  new_folders_.clear();
}

}  // namespace fransac::cli
