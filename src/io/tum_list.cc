// SPDX-License-Identifier: Apache-2.0
#include "io/tum_list.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <optional>
#include <utility>

#include "io/guard.h"
#include "io/text.h"

namespace fransac::io {
namespace {

// Timestamps are written in microseconds, and doubles of today's Unix time are good to a quarter of one.
constexpr double kTimeRounding_s = 1e-6;

/// Cuts the first word off `line`; empty at its end.
std::string_view take_word(std::string_view& line) {
  line.remove_prefix(std::min(line.find_first_not_of(kBlanks), line.size()));
  const std::string_view word = line.substr(0, line.find_first_of(kBlanks));
  line.remove_prefix(word.size());
  return word;
}

std::size_t count_words(std::string_view line) {
  std::size_t count = 0;
  while (!take_word(line).empty()) ++count;
  return count;
}

std::optional<double> parse_time(std::string_view word) {
  double time_s = 0.0;
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), time_s);
  if (error != std::errc() || end != word.data() + word.size() || !std::isfinite(time_s) || std::signbit(time_s))
    return std::nullopt;
  return time_s;
}

bool stays_inside(std::string_view file) {
  const std::filesystem::path path(file);
  return path.is_relative() && std::find(path.begin(), path.end(), "..") == path.end();
}

bool printable(std::string_view file) {
  return std::none_of(file.begin(), file.end(), [](char c) { return static_cast<unsigned char>(c) < ' '; });
}

/// Takes the next two words of a line; what is wrong with them, or nothing.
std::optional<std::string_view> take_entry(std::string_view& line, TumEntry& entry) {
  const std::string_view timestamp = take_word(line);
  const std::string_view file = take_word(line);
  const std::optional<double> time_s = parse_time(timestamp);
  if (!time_s) return "timestamp is not a number of seconds";
  if (!printable(file)) return "file name holds a control character";
  if (!stays_inside(file)) return "file name leads out of the folder";
  entry = {*time_s, std::string(timestamp), std::string(file)};
  return std::nullopt;
}

std::optional<std::string_view> parse_line(std::string_view line, TumEntry& entry) {
  if (count_words(line) != 2) return "is not \"timestamp filename\"";
  return take_entry(line, entry);
}

bool is_named_depth(const TumEntry& entry) { return entry.file.starts_with("depth"); }

std::optional<std::string_view> parse_line(std::string_view line, TumPair& pair) {
  if (count_words(line) != 4) return "is not \"timestamp filename timestamp filename\"";
  std::optional<std::string_view> fault = take_entry(line, pair.colour);
  if (!fault) fault = take_entry(line, pair.depth);
  if (!fault && is_named_depth(pair.colour) && !is_named_depth(pair.depth)) std::swap(pair.colour, pair.depth);
  return fault;
}

double time_of(const TumEntry& entry) { return entry.time_s; }
double time_of(const TumPair& pair) { return pair.depth.time_s; }

template <class Entry>
Result<std::vector<Entry>> parse_entries(std::string_view text, const std::string& name) {
  std::vector<Entry> entries;
  const Status read = for_each_line(text, [&](std::string_view line, std::size_t number) -> Status {
    Entry entry;
    if (const auto fault = parse_line(line, entry)) return line_error(name, number, *fault);
    entries.push_back(std::move(entry));
    return {};
  });
  if (!read) return read.error();
  std::stable_sort(entries.begin(), entries.end(), [](const Entry& a, const Entry& b) { return time_of(a) < time_of(b); });
  return entries;
}

}  // namespace

Result<std::vector<TumEntry>> parse_tum_list(std::string_view text, const std::string& name) {
  return parse_entries<TumEntry>(text, name);
}

Result<std::vector<TumPair>> parse_tum_associations(std::string_view text, const std::string& name) {
  return parse_entries<TumPair>(text, name);
}

const TumEntry* nearest_entry(std::span<const TumEntry> sorted, double time_s) {
  const auto later = std::lower_bound(sorted.begin(), sorted.end(), time_s,
                                      [](const TumEntry& entry, double time) { return entry.time_s < time; });
  const TumEntry* nearest = nullptr;
  double gap_s = kTumAssociation_s + kTimeRounding_s;
  const auto consider = [&](const TumEntry& entry) {
    const double gap = std::abs(entry.time_s - time_s);
    if (gap > gap_s || (nearest != nullptr && gap == gap_s)) return;
    gap_s = gap;
    nearest = &entry;
  };
  if (later != sorted.begin()) consider(*(later - 1));
  if (later != sorted.end()) consider(*later);
  return nearest;
}

}  // namespace fransac::io
