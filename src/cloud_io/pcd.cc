// SPDX-License-Identifier: Apache-2.0
// PCD. Our header check comes first, so that no size which PCL works with is unchecked; then PCL 1.13 decodes binary and
// binary_compressed bodies from memory. Its ascii decoder is not used: it reads a word that is no number as 0 and a line
// with too few numbers as a point at the origin, in silence or with a line on the console.
#include <pcl/PCLPointCloud2.h>
#include <pcl/console/print.h>
#include <pcl/io/pcd_io.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <map>
#include <mutex>
#include <new>
#include <optional>
#include <set>
#include <sstream>
#include <utility>
#include <vector>

#include "cloud_io/assemble.h"
#include "cloud_io/formats.h"
#include "cloud_io/text.h"
#include "io/guard.h"

namespace fransac::io::cloud_formats {
namespace {

constexpr std::array<std::string_view, 11> kKeywords = {"VERSION", "FIELDS", "COLUMNS",   "SIZE",   "TYPE", "COUNT",
                                                        "WIDTH",   "HEIGHT", "VIEWPOINT", "POINTS", "DATA"};
constexpr std::array<std::string_view, 8> kVersions = {"0.5", ".5", "0.6", ".6", "0.7", ".7", "0.4", ".4"};
constexpr std::string_view kPadding = "_";  // The name of bytes that carry nothing.
constexpr std::array<std::string_view, 3> kAxes = {"x", "y", "z"};
/// LZF: three bytes (a long back reference) stand for at most 7 + 255 + 2 = 264 bytes.
constexpr std::uint64_t kLzfLargestExpansion = 264 / 3;
/// What stands before a compressed body: its size and the size it expands to, 32 bits each.
constexpr std::uint64_t kCompressedPrefix = 8;
/// PCL holds a point's size in an int.
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

/// Everything that PCL's decoders take on trust.
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
    // PCL's writer leaves padding out and its reader then misplaces every point.
    if (field.name == kPadding) return format_error(name, "binary_compressed data with a padding field '_'");
  }
  return {};
}

std::uint8_t pcl_type(const Field& field) {
  using Type = pcl::PCLPointField;
  if (field.type == 'F') return field.size == 4 ? Type::FLOAT32 : Type::FLOAT64;
  const bool is_signed = field.type == 'I';
  switch (field.size) {
    case 1: return is_signed ? Type::INT8 : Type::UINT8;
    case 2: return is_signed ? Type::INT16 : Type::UINT16;
    case 4: return is_signed ? Type::INT32 : Type::UINT32;
    default: return is_signed ? Type::INT64 : Type::UINT64;
  }
}

/// PCL prints what it finds wrong, on a level that the whole process shares.
class QuietPcl {
 public:
  QuietPcl() : lock_(mutex()), level_(pcl::console::getVerbosityLevel()) {
    pcl::console::setVerbosityLevel(pcl::console::L_ALWAYS);
  }
  ~QuietPcl() { pcl::console::setVerbosityLevel(level_); }
  QuietPcl(const QuietPcl&) = delete;
  QuietPcl& operator=(const QuietPcl&) = delete;

 private:
  static std::mutex& mutex() {
    static std::mutex instance;
    return instance;
  }
  std::lock_guard<std::mutex> lock_;
  pcl::console::VERBOSITY_LEVEL level_;
};

pcl::PCLPointCloud2 empty_blob(const Header& header) {
  pcl::PCLPointCloud2 blob;
  blob.width = static_cast<pcl::uindex_t>(header.width);
  blob.height = static_cast<pcl::uindex_t>(header.height);
  blob.point_step = static_cast<pcl::uindex_t>(header.point_bytes);
  blob.row_step = static_cast<pcl::uindex_t>(header.point_bytes * header.width);
  blob.data.resize(header.points() * header.point_bytes);
  for (const Field& field : header.fields) {
    pcl::PCLPointField pcl_field;
    pcl_field.name = std::string(field.name);
    pcl_field.offset = static_cast<pcl::uindex_t>(field.offset);
    pcl_field.datatype = pcl_type(field);
    pcl_field.count = static_cast<pcl::uindex_t>(field.count);
    blob.fields.push_back(pcl_field);
  }
  return blob;
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

Result<PointCloud> decode_binary(const Header& header, const ReadLimits& limits, const std::string& name) {
  if (const auto status = check_binary_body(header, limits, name); !status) return status.error();
  pcl::PCLPointCloud2 blob = empty_blob(header);
  {
    const QuietPcl quiet;
    const auto* body = reinterpret_cast<const unsigned char*>(header.body.data());
    const bool compressed = header.encoding == CloudEncoding::binary_compressed;
    if (pcl::PCDReader().readBodyBinary(body, blob, pcl::PCDReader::PCD_V7, compressed, 0) < 0) {
      return format_error(name, compressed ? "the compressed data is damaged" : "PCL cannot decode the data");
    }
  }
  struct Axis {
    std::size_t offset;
    double (*load)(const std::uint8_t*);
  };
  std::array<Axis, 3> axes{};
  for (std::size_t axis = 0; axis < axes.size(); ++axis) {
    const Field& field = header.fields[header.axes[axis]];
    axes[axis] = {field.offset, loader_of(field)};
  }
  const auto value = [](const std::uint8_t* point, Axis axis) { return axis.load(point + axis.offset); };
  const auto coordinate = [&](std::size_t i) {
    const std::uint8_t* point = blob.data.data() + i * header.point_bytes;
    return Eigen::Vector3d(value(point, axes[0]), value(point, axes[1]), value(point, axes[2]));
  };
  return assemble(header.width, header.height, coordinate);
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
void store(std::vector<std::uint8_t>& bytes, std::size_t& offset, T value) {
  std::memcpy(bytes.data() + offset, &value, sizeof value);
  offset += sizeof value;
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
    header.fields.push_back({.name = "rgb"});  // PCL's way: the integer's bits in a float.
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

void fill(pcl::PCLPointCloud2& blob, const LabelledCloud& labelled) {
  const auto& [cloud, labels, obstacles] = labelled;
  std::size_t offset = 0;
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const Eigen::Vector3d point = point_to_write(cloud, i);
    for (const double value : {point.x(), point.y(), point.z()}) {
      needs_double(cloud) ? store(blob.data, offset, value) : store(blob.data, offset, static_cast<float>(value));
    }
    if (!labels.empty()) {
      store(blob.data, offset, packed_colour(labels[i]));
      store(blob.data, offset, std::uint32_t{labels[i]});
    }
    if (!obstacles.empty()) store(blob.data, offset, std::uint32_t{obstacles[i]});
  }
}

/// PCL's ascii writer prints all numbers with one precision and to named files only; the shortest exact text is ours.
std::string ascii_body(const LabelledCloud& labelled) {
  const auto& [cloud, labels, obstacles] = labelled;
  std::string text;
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const Eigen::Vector3d point = point_to_write(cloud, i);
    for (int axis = 0; axis < 3; ++axis) {
      if (axis > 0) text += ' ';
      needs_double(cloud) ? append_real(text, point[axis]) : append_real(text, static_cast<float>(point[axis]));
    }
    if (!labels.empty()) text += ' ' + std::to_string(packed_colour(labels[i])) + ' ' + std::to_string(labels[i]);
    if (!obstacles.empty()) text += ' ' + std::to_string(obstacles[i]);
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
  const QuietPcl quiet;
  pcl::PCDWriter writer;
  Eigen::Vector4f viewpoint = Eigen::Vector4f::Zero();
  if (labelled.cloud.sensor_position) viewpoint.head<3>() = labelled.cloud.sensor_position->cast<float>();
  const Eigen::Quaternionf no_rotation = Eigen::Quaternionf::Identity();
  pcl::PCLPointCloud2 blob = empty_blob(header_to_write(labelled));
  if (encoding == CloudEncoding::ascii) {
    return writer.generateHeaderASCII(blob, viewpoint, no_rotation) + "DATA ascii\n" + ascii_body(labelled);
  }
  fill(blob, labelled);
  if (encoding == CloudEncoding::binary) {
    std::string text = writer.generateHeaderBinary(blob, viewpoint, no_rotation) + "DATA binary\n";
    return text.append(reinterpret_cast<const char*>(blob.data.data()), blob.data.size());
  }
  std::ostringstream stream;
  const int written = writer.writeBinaryCompressed(stream, blob, viewpoint, no_rotation);
  if (!stream) throw std::bad_alloc();  // a stream into memory has no other fault
  if (written < 0) {
    return file_error(ErrorCode::unsupported, name, "the cloud is too large for binary_compressed; binary has no such limit");
  }
  return std::move(stream).str();
}

}  // namespace fransac::io::cloud_formats
