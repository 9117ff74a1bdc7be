// SPDX-License-Identifier: Apache-2.0
// PCD, PCL's format, versions .4 to .7. Every size in the header is checked before anything is read by it.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <map>
#include <optional>
#include <set>
#include <span>
#include <type_traits>
#include <utility>
#include <vector>

#include "io/cloud_assemble.h"
#include "io/cloud_formats.h"
#include "io/cloud_text.h"
#include "io/guard.h"
#include "io/lzf.h"

namespace fransac::io::cloud_formats {
namespace {

constexpr std::array<std::string_view, 11> kKeywords = {"VERSION", "FIELDS", "COLUMNS",   "SIZE",   "TYPE", "COUNT",
                                                        "WIDTH",   "HEIGHT", "VIEWPOINT", "POINTS", "DATA"};
constexpr std::array<std::string_view, 8> kVersions = {"0.5", ".5", "0.6", ".6", "0.7", ".7", "0.4", ".4"};
constexpr std::string_view kPadding = "_";  // The name of bytes that carry nothing.
constexpr std::string_view kColour = "rgb";
constexpr std::array<std::string_view, 3> kAxes = {"x", "y", "z"};
/// What stands before a compressed body: its size and the size it expands to, 32 bits each.
constexpr std::uint64_t kCompressedPrefix = 8;
/// Readers hold a point's size in an int.
constexpr std::uint64_t kLargestPoint = 0x7fffffff;

struct Field {
  std::string_view name;
  std::uint64_t size = 4;
  char type = 'F';
  std::uint64_t count = 1;
  std::uint64_t offset = 0;  ///< Bytes from the point's start.
  std::uint64_t column = 0;  ///< Numbers before it in an ascii line.
};

struct Header {
  std::vector<Field> fields;
  std::array<std::size_t, 3> axes{};  ///< Indices of x, y, z in `fields`.
  std::uint64_t width = 0;
  std::uint64_t height = 0;
  std::uint64_t point_bytes = 0;
  std::uint64_t columns = 0;  ///< Numbers in an ascii line.
  CloudEncoding encoding = CloudEncoding::ascii;
  std::string_view body;
  int lines = 0;
  std::optional<Eigen::Vector3d> sensor_position;  ///< The translation of VIEWPOINT, unless it is the default.

  [[nodiscard]] std::uint64_t points() const { return width * height; }
};

/// The header's lines by keyword, DATA the last.
struct Entries {
  std::map<std::string_view, std::vector<std::string_view>> values;
  std::string_view body;
  int lines = 0;

  [[nodiscard]] const std::vector<std::string_view>* find(std::string_view keyword) const {
    const auto found = values.find(keyword);
    return found == values.end() ? nullptr : &found->second;
  }
};

Result<Entries> read_entries(std::string_view text, const std::string& name) {
  Entries entries;
  Lines lines(text);
  while (const auto line = lines.next()) {
    auto tokens = words(*line);
    if (tokens.empty() || tokens[0].starts_with('#')) continue;
    const std::string_view keyword = tokens[0];
    if (std::find(kKeywords.begin(), kKeywords.end(), keyword) == kKeywords.end()) {
      if (entries.values.empty()) return format_error(name, "is neither a PCD nor a PLY file");
      return format_error(name,
                          "line " + std::to_string(lines.number()) + ": no PCD header line starts with " + quoted_text(keyword));
    }
    tokens.erase(tokens.begin());
    if (!entries.values.emplace(keyword, std::move(tokens)).second) {
      return format_error(name, "line " + std::to_string(lines.number()) + ": a second " + std::string(keyword));
    }
    if (keyword == "DATA") {
      entries.body = lines.rest();
      entries.lines = lines.number();
      return entries;
    }
  }
  return format_error(name, entries.values.empty() ? "is neither a PCD nor a PLY file" : "the PCD header has no DATA line");
}

/// The counts of an entry; `size` of them. Nothing when the entry is not there.
Result<std::optional<std::vector<std::uint64_t>>> read_counts(const Entries& entries, std::string_view keyword, std::size_t size,
                                                              const std::string& name) {
  const auto* tokens = entries.find(keyword);
  if (tokens == nullptr) return std::optional<std::vector<std::uint64_t>>();
  if (tokens->size() != size) {
    return format_error(
        name, std::string(keyword) + " has " + std::to_string(tokens->size()) + " values, expected " + std::to_string(size));
  }
  std::vector<std::uint64_t> counts;
  for (const std::string_view token : *tokens) {
    const auto count = parse_count(token);
    if (!count)
      return format_error(name, std::string(keyword) + " " + quoted_text(token) + " is not a number from 0 to 2147483647");
    counts.push_back(*count);
  }
  return std::optional(std::move(counts));
}

Result<std::optional<std::uint64_t>> read_count(const Entries& entries, std::string_view keyword, const std::string& name) {
  const auto counts = read_counts(entries, keyword, 1, name);
  if (!counts) return counts.error();
  return *counts ? std::optional((**counts)[0]) : std::nullopt;
}

Status check_type(const Field& field, const std::string& name) {
  const bool integer =
      (field.type == 'I' || field.type == 'U') && (field.size == 1 || field.size == 2 || field.size == 4 || field.size == 8);
  const bool real = field.type == 'F' && (field.size == 4 || field.size == 8);
  if (integer || real) return {};
  return format_error(name, "field " + quoted_text(field.name) + ": TYPE " + quoted_text({&field.type, 1}) + " with SIZE " +
                                std::to_string(field.size) + " is no PCD type");
}

Status read_fields(const Entries& entries, Header& header, const std::string& name) {
  const auto* names = entries.find("FIELDS");
  if (names == nullptr) names = entries.find("COLUMNS");  // The name of FIELDS in versions before .6.
  if (names == nullptr || names->empty()) return format_error(name, "the PCD header has no FIELDS");
  const auto sizes = read_counts(entries, "SIZE", names->size(), name);
  if (!sizes) return sizes.error();
  const auto counts = read_counts(entries, "COUNT", names->size(), name);
  if (!counts) return counts.error();
  const auto* types = entries.find("TYPE");
  // Versions before .6 have neither and mean floats.
  if (sizes->has_value() != (types != nullptr))
    return format_error(name, "the PCD header has one of SIZE and TYPE without the other");
  if (types != nullptr && types->size() != names->size()) {
    return format_error(name, "TYPE has " + std::to_string(types->size()) + " values, expected " + std::to_string(names->size()));
  }
  for (std::size_t i = 0; i < names->size(); ++i) {
    Field field{.name = (*names)[i]};
    if (types != nullptr) {
      field.size = (**sizes)[i];
      field.type = (*types)[i].size() == 1 ? (*types)[i][0] : '?';
    }
    if (counts->has_value()) field.count = (**counts)[i];
    if (field.count == 0) return format_error(name, "field " + quoted_text(field.name) + ": COUNT is 0");
    if (auto status = check_type(field, name); !status) return status;
    field.offset = header.point_bytes;
    field.column = header.columns;
    header.point_bytes += field.size * field.count;
    header.columns += field.count;
    if (header.point_bytes > kLargestPoint) return format_error(name, "one point has more than 2147483647 bytes");
    header.fields.push_back(field);
  }
  return {};
}

Status find_axes(Header& header, const std::string& name) {
  std::set<std::string_view> seen;
  for (const Field& field : header.fields) {
    if (field.name != kPadding && !seen.insert(field.name).second)
      return format_error(name, "a second field " + quoted_text(field.name));
  }
  constexpr std::array<std::string_view, 3> kUpperCase = {"X", "Y", "Z"};
  for (std::size_t axis = 0; axis < kAxes.size(); ++axis) {
    const auto named = [&](std::string_view wanted) {
      return std::find_if(header.fields.begin(), header.fields.end(), [&](const Field& field) { return field.name == wanted; });
    };
    auto found = named(kAxes[axis]);
    if (found == header.fields.end()) found = named(kUpperCase[axis]);
    if (found == header.fields.end()) return format_error(name, "has no field " + quoted_text(kAxes[axis]));
    if (found->count != 1) return format_error(name, "field " + quoted_text(kAxes[axis]) + " is not one number");
    header.axes[axis] = static_cast<std::size_t>(found - header.fields.begin());
  }
  return {};
}

Status read_extent(const Entries& entries, Header& header, const std::string& name) {
  const auto width = read_count(entries, "WIDTH", name);
  const auto height = read_count(entries, "HEIGHT", name);
  const auto points = read_count(entries, "POINTS", name);
  for (const auto* count : {&width, &height, &points}) {
    if (!*count) return count->error();
  }
  if (!width->has_value() && !points->has_value()) return format_error(name, "the PCD header has neither WIDTH nor POINTS");
  header.height = height->value_or(1);
  header.width = width->has_value() ? **width : **points;  // Versions before .6 have POINTS alone.
  if (header.points() > kLargestPoint) return format_error(name, "WIDTH x HEIGHT is more than 2147483647 points");
  if (points->has_value() && header.points() != **points) {
    return format_error(name, "WIDTH " + std::to_string(header.width) + " x HEIGHT " + std::to_string(header.height) +
                                  " is not POINTS " + std::to_string(**points));
  }
  return {};
}

Status read_encoding(const Entries& entries, Header& header, const std::string& name) {
  const auto& data = *entries.find("DATA");
  const std::string_view word = data.size() == 1 ? data[0] : std::string_view();
  if (word == "ascii") {
    header.encoding = CloudEncoding::ascii;
  } else if (word == "binary") {
    header.encoding = CloudEncoding::binary;
  } else if (word == "binary_compressed") {
    header.encoding = CloudEncoding::binary_compressed;
  } else {
    return format_error(name, "DATA is not ascii, binary or binary_compressed");
  }
  return {};
}

/// Translation and quaternion (w, x, y, z). 0 0 0 is what PCL writes when it knows no viewpoint.
Status read_viewpoint(const Entries& entries, Header& header, const std::string& name) {
  const auto* tokens = entries.find("VIEWPOINT");
  if (tokens == nullptr) return {};  // Versions before .7 have none.
  constexpr std::size_t kNumbers = 7;
  if (tokens->size() != kNumbers) {
    return format_error(name,
                        "VIEWPOINT has " + std::to_string(tokens->size()) + " values, expected " + std::to_string(kNumbers));
  }
  Eigen::Vector3d translation;
  for (std::size_t i = 0; i < kNumbers; ++i) {
    const auto number = parse_real((*tokens)[i]);
    if (!number || !std::isfinite(*number)) {
      return format_error(name, "VIEWPOINT " + quoted_text((*tokens)[i]) + " is not a finite number");
    }
    if (i < 3) translation[static_cast<Eigen::Index>(i)] = *number;
  }
  if (const Status status = validate_position(translation, "VIEWPOINT"); !status)
    return format_error(name, status.error().message);
  if (!translation.isZero(0.0)) header.sensor_position = translation;
  return {};
}

Result<Header> read_header(std::string_view text, const std::string& name) {
  const auto entries = read_entries(text, name);
  if (!entries) return entries.error();
  if (const auto* version = entries->find("VERSION")) {
    if (version->size() != 1 || std::find(kVersions.begin(), kVersions.end(), (*version)[0]) == kVersions.end()) {
      return format_error(name, "VERSION is not one of .4 to .7");
    }
  }
  Header header;
  header.body = entries->body;
  header.lines = entries->lines;
  if (const auto status = read_fields(*entries, header, name); !status) return status.error();
  if (const auto status = find_axes(header, name); !status) return status.error();
  if (const auto status = read_extent(*entries, header, name); !status) return status.error();
  if (const auto status = read_viewpoint(*entries, header, name); !status) return status.error();
  if (const auto status = read_encoding(*entries, header, name); !status) return status.error();
  return header;
}

std::string bytes_wanted(std::uint64_t points, std::uint64_t wanted, std::size_t there) {
  return std::to_string(points) + " points need " + std::to_string(wanted) + " bytes after the header, the file has " +
         std::to_string(there);
}

std::uint32_t read_u32(std::string_view bytes, std::size_t offset) {
  std::uint32_t value = 0;
  std::memcpy(&value, bytes.data() + offset, sizeof value);
  return value;
}

/// All that decoding relies on.
Status check_binary_body(const Header& header, const ReadLimits& limits, const std::string& name) {
  const std::uint64_t expanded = header.points() * header.point_bytes;
  const std::size_t there = header.body.size();
  if (header.encoding == CloudEncoding::binary) {
    if (expanded > there) return format_error(name, bytes_wanted(header.points(), expanded, there));
    return check_points(header.points(), limits, name);
  }
  if (there < kCompressedPrefix) return format_error(name, "the compressed data's sizes are missing");
  const std::uint64_t compressed = read_u32(header.body, 0);
  if (read_u32(header.body, 4) != expanded) {
    return format_error(name, "the compressed data expands to " + std::to_string(read_u32(header.body, 4)) + " bytes, " +
                                  std::to_string(header.points()) + " points need " + std::to_string(expanded));
  }
  if (compressed > there - kCompressedPrefix) {
    return format_error(name, "the compressed data has " + std::to_string(compressed) + " bytes, the file only " +
                                  std::to_string(there - kCompressedPrefix));
  }
  if (expanded > compressed * kLzfLargestExpansion) {
    return format_error(name, std::to_string(compressed) + " compressed bytes cannot hold " + std::to_string(expanded));
  }
  if (Status status = check_points(header.points(), limits, name); !status) return status;
  if (expanded > limits.max_decoded_bytes()) {
    return format_error(name, "the compressed data expands to " + std::to_string(expanded) + " bytes: more than the limit of " +
                                  std::to_string(limits.max_decoded_bytes()) + " (--max-size)");
  }
  for (const Field& field : header.fields) {
    // PCL's writer leaves padding out, others do not.
    if (field.name == kPadding) return format_error(name, "binary_compressed data with a padding field '_'");
  }
  return {};
}

template <class T>
double load(const std::uint8_t* bytes) {
  T value;
  std::memcpy(&value, bytes, sizeof value);
  return static_cast<double>(value);
}

/// How a field's values are read, whatever type they have.
double (*loader_of(const Field& field))(const std::uint8_t*) {
  if (field.type == 'F') return field.size == 4 ? &load<float> : &load<double>;
  const bool is_signed = field.type == 'I';
  switch (field.size) {
    case 1: return is_signed ? &load<std::int8_t> : &load<std::uint8_t>;
    case 2: return is_signed ? &load<std::int16_t> : &load<std::uint16_t>;
    case 4: return is_signed ? &load<std::int32_t> : &load<std::uint32_t>;
    default: return is_signed ? &load<std::int64_t> : &load<std::uint64_t>;
  }
}

/// Where an axis' values stand in a body, and how they are read.
struct AxisPlace {
  const std::uint8_t* first = nullptr;
  std::size_t step = 0;  ///< Bytes from point to point.
  double (*load)(const std::uint8_t*) = nullptr;

  [[nodiscard]] double operator()(std::size_t point) const { return load(first + point * step); }
};

/// Binary bodies hold point after point; compressed ones field after field.
Result<PointCloud> decode_binary(const Header& header, const ReadLimits& limits, const std::string& name) {
  if (const auto status = check_binary_body(header, limits, name); !status) return status.error();
  const bool compressed = header.encoding == CloudEncoding::binary_compressed;
  std::span body(reinterpret_cast<const std::uint8_t*>(header.body.data()), header.body.size());
  std::vector<std::uint8_t> plain;
  if (compressed) {
    plain.resize(header.points() * header.point_bytes);
    if (!expand_lzf(body.subspan(kCompressedPrefix, read_u32(header.body, 0)), plain)) {
      return format_error(name, "the compressed data is damaged");
    }
    body = plain;
  }
  std::array<AxisPlace, 3> axes{};
  for (std::size_t axis = 0; axis < axes.size(); ++axis) {
    const Field& field = header.fields[header.axes[axis]];
    axes[axis] = compressed ? AxisPlace{body.data() + field.offset * header.points(), field.size, loader_of(field)}
                            : AxisPlace{body.data() + field.offset, header.point_bytes, loader_of(field)};
  }
  return assemble(header.width, header.height,
                  [&](std::size_t i) { return Eigen::Vector3d(axes[0](i), axes[1](i), axes[2](i)); });
}

/// One line: `columns` values, of which x, y and z are read. Returns what is wrong, or nothing.
std::string parse_point(const Header& header, std::string_view line, Eigen::Vector3d& point) {
  std::uint64_t column = 0;
  for (auto word = take_word(line); !word.empty(); word = take_word(line), ++column) {
    for (std::size_t axis = 0; axis < kAxes.size(); ++axis) {
      if (header.fields[header.axes[axis]].column != column) continue;
      const auto value = parse_real(word);
      if (!value) return std::string(kAxes[axis]) + " is " + quoted_text(word) + ", not a number";
      point[static_cast<Eigen::Index>(axis)] = *value;
    }
  }
  if (column == header.columns) return {};
  return std::to_string(column) + " values, expected " + std::to_string(header.columns);
}

Result<PointCloud> decode_ascii(const Header& header, const ReadLimits& limits, const std::string& name) {
  // A number has at least one character and one blank or line end behind it, but for the last.
  const std::uint64_t wanted = header.points() * header.columns * 2 - 1;
  if (wanted > header.body.size()) return format_error(name, bytes_wanted(header.points(), wanted, header.body.size()));
  if (const Status status = check_points(header.points(), limits, name); !status) return status.error();
  std::vector<Eigen::Vector3d> points;
  points.reserve(header.points());
  Lines lines(header.body, header.lines);
  while (const auto line = lines.next()) {
    if (std::string_view rest = *line; take_word(rest).empty()) continue;
    std::string problem;
    if (points.size() == header.points()) {
      problem = "more than the " + std::to_string(header.points()) + " points of the header";
    } else {
      problem = parse_point(header, *line, points.emplace_back());
    }
    if (!problem.empty()) return format_error(name, "line " + std::to_string(lines.number()) + ": " + problem);
  }
  if (points.size() != header.points()) {
    return format_error(name,
                        "has " + std::to_string(points.size()) + " points, the header says " + std::to_string(header.points()));
  }
  return assemble(header.width, header.height, [&](std::size_t i) { return points[i]; });
}

// ---- writing ----

template <class T>
void append(std::string& bytes, T value) {
  bytes.append(reinterpret_cast<const char*>(&value), sizeof value);
}

/// 0x00RRGGBB, what PCL and CloudCompare read from a field named rgb.
std::uint32_t packed_colour(std::uint8_t label) {
  const auto [red, green, blue] = point_colour(label);
  return (std::uint32_t{red} << 16) | (std::uint32_t{green} << 8) | std::uint32_t{blue};
}

/// The cloud as a header: PCL's PointXYZRGBL, but for x, y, z being double where there is an origin; then the obstacle.
Header header_to_write(const LabelledCloud& labelled) {
  const PointCloud& cloud = labelled.cloud;
  Header header;
  const std::uint64_t real = needs_double(cloud) ? sizeof(double) : sizeof(float);
  for (const std::string_view axis : kAxes) header.fields.push_back({.name = axis, .size = real});
  if (!labelled.labels.empty()) {
    header.fields.push_back({.name = kColour});
    header.fields.push_back({.name = "label", .type = 'U'});
  }
  if (!labelled.obstacles.empty()) header.fields.push_back({.name = "obstacle", .type = 'U'});
  for (Field& field : header.fields) {
    field.offset = header.point_bytes;
    header.point_bytes += field.size;
  }
  header.width = extent(cloud).width;
  header.height = extent(cloud).height;
  return header;
}

/// The lines before the body, as version .7 has them.
std::string header_text(const Header& header) {
  constexpr std::array<std::string_view, 3> kEncodings = {"ascii", "binary", "binary_compressed"};
  std::string names, sizes, types, counts;
  for (const Field& field : header.fields) {
    names += " " + std::string(field.name);
    sizes += " " + std::to_string(field.size);
    // In text a colour is the integer itself, as PCL has it; else its bits are a float's.
    types += std::string(" ") + (field.name == kColour && header.encoding == CloudEncoding::ascii ? 'U' : field.type);
    counts += " " + std::to_string(field.count);
  }
  std::string viewpoint;
  const Eigen::Vector3d position = header.sensor_position.value_or(Eigen::Vector3d::Zero());
  for (const double value : {position.x(), position.y(), position.z()}) {
    append_real(viewpoint, value);
    viewpoint += ' ';
  }
  return "# .PCD v0.7 - Point Cloud Data file format\nVERSION 0.7\nFIELDS" + names + "\nSIZE" + sizes + "\nTYPE" + types +
         "\nCOUNT" + counts + "\nWIDTH " + std::to_string(header.width) + "\nHEIGHT " + std::to_string(header.height) +
         "\nVIEWPOINT " + viewpoint + "1 0 0 0\nPOINTS " + std::to_string(header.points()) + "\nDATA " +
         std::string(kEncodings[static_cast<std::size_t>(header.encoding)]) + "\n";
}

/// Calls visit(value) for the i-th point's fields, each in the type that it is written in.
template <class Visit>
void visit_fields(const LabelledCloud& labelled, std::size_t i, Visit&& visit) {
  const auto& [cloud, labels, obstacles] = labelled;
  const Eigen::Vector3d point = point_to_write(cloud, i);
  for (const double value : {point.x(), point.y(), point.z()}) {
    needs_double(cloud) ? visit(value) : visit(static_cast<float>(value));
  }
  if (!labels.empty()) {
    visit(packed_colour(labels[i]));
    visit(std::uint32_t{labels[i]});
  }
  if (!obstacles.empty()) visit(std::uint32_t{obstacles[i]});
}

/// Point after point.
std::string binary_body(const LabelledCloud& labelled) {
  std::string bytes;
  for (std::size_t i = 0; i < labelled.cloud.size(); ++i) {
    visit_fields(labelled, i, [&](auto value) { append(bytes, value); });
  }
  return bytes;
}

/// Field after field, compressed. Nothing where a size does not fit into its 32 bits.
std::optional<std::string> compressed_body(const LabelledCloud& labelled, std::size_t fields) {
  std::vector<std::string> columns(fields);
  for (std::size_t i = 0; i < labelled.cloud.size(); ++i) {
    std::size_t field = 0;
    visit_fields(labelled, i, [&](auto value) { append(columns[field++], value); });
  }
  std::string plain;
  for (const std::string& column : columns) plain += column;
  const std::string compressed = compress_lzf({reinterpret_cast<const std::uint8_t*>(plain.data()), plain.size()});
  constexpr std::size_t kLargest = std::numeric_limits<std::uint32_t>::max();
  if (std::max(plain.size(), compressed.size()) > kLargest) return std::nullopt;
  std::string body;
  append(body, static_cast<std::uint32_t>(compressed.size()));
  append(body, static_cast<std::uint32_t>(plain.size()));
  return body + compressed;
}

/// Each number by the shortest text that is exact.
std::string ascii_body(const LabelledCloud& labelled) {
  std::string text;
  const auto add = [&text](auto value) {
    if (!text.empty() && text.back() != '\n') text += ' ';
    if constexpr (std::is_floating_point_v<decltype(value)>) {
      append_real(text, value);
    } else {
      text += std::to_string(value);
    }
  };
  for (std::size_t i = 0; i < labelled.cloud.size(); ++i) {
    visit_fields(labelled, i, add);
    text += '\n';
  }
  return text;
}

}  // namespace

Result<PointCloud> decode_pcd(std::span<const std::byte> bytes, const std::string& name, const ReadLimits& limits) {
  const auto header = read_header(as_text(bytes), name);
  if (!header) return header.error();
  if (header->points() == 0) return PointCloud();
  Result<PointCloud> cloud =
      header->encoding == CloudEncoding::ascii ? decode_ascii(*header, limits, name) : decode_binary(*header, limits, name);
  if (cloud) cloud->sensor_position = header->sensor_position;
  return cloud;
}

Result<std::string> encode_pcd(const LabelledCloud& labelled, CloudEncoding encoding, const std::string& name) {
  Header header = header_to_write(labelled);
  header.sensor_position = labelled.cloud.sensor_position;
  header.encoding = encoding;
  if (encoding == CloudEncoding::ascii) return header_text(header) + ascii_body(labelled);
  if (encoding == CloudEncoding::binary) return header_text(header) + binary_body(labelled);
  const std::optional<std::string> body = compressed_body(labelled, header.fields.size());
  if (!body) {
    return file_error(ErrorCode::unsupported, name, "the cloud is too large for binary_compressed; binary has no such limit");
  }
  return header_text(header) + *body;
}

}  // namespace fransac::io::cloud_formats
