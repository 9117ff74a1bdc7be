// SPDX-License-Identifier: Apache-2.0
// PLY, without PCL: its 1.13 reader takes a file name only and, on files whose header is fine, crashes (a range_grid
// index out of range), aborts the process (a list among the vertex properties that grows after the first vertex), takes
// words for 0 or NaN in silence, and puts x into the wrong place when it stands between red and blue. What keeps it from
// that is a walk through the whole body, and that walk is all there is to decoding. PCL's writer, too, needs a named file.
// The tests hold this reader and this writer against PCL's.
#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <optional>
#include <set>
#include <type_traits>
#include <utility>
#include <vector>

#include "io/cloud_assemble.h"
#include "io/cloud_formats.h"
#include "io/cloud_text.h"

namespace fransac::io::cloud_formats {
namespace {

constexpr std::size_t kNameBytes = 48;  // of an element in messages

enum class Encoding { ascii, little_endian, big_endian };
enum class Type { int8, uint8, int16, uint16, int32, uint32, float32, float64 };

struct TypeName {
  std::string_view name;
  Type type;
};
constexpr std::array<TypeName, 16> kTypeNames = {{{"char", Type::int8},
                                                  {"int8", Type::int8},
                                                  {"uchar", Type::uint8},
                                                  {"uint8", Type::uint8},
                                                  {"short", Type::int16},
                                                  {"int16", Type::int16},
                                                  {"ushort", Type::uint16},
                                                  {"uint16", Type::uint16},
                                                  {"int", Type::int32},
                                                  {"int32", Type::int32},
                                                  {"uint", Type::uint32},
                                                  {"uint32", Type::uint32},
                                                  {"float", Type::float32},
                                                  {"float32", Type::float32},
                                                  {"double", Type::float64},
                                                  {"float64", Type::float64}}};

std::optional<Type> find_type(std::string_view name) {
  for (const auto& entry : kTypeNames) {
    if (entry.name == name) return entry.type;
  }
  return std::nullopt;
}

bool is_real(Type type) { return type == Type::float32 || type == Type::float64; }

std::size_t size_of(Type type) {
  switch (type) {
    case Type::int8:
    case Type::uint8: return 1;
    case Type::int16:
    case Type::uint16: return 2;
    case Type::int32:
    case Type::uint32:
    case Type::float32: return 4;
    case Type::float64: return 8;
  }
  return 0;
}

/// What a property is for.
enum class Role { none, x, y, z, columns, rows };

struct Property {
  std::string_view name;
  Type type = Type::float32;
  std::optional<Type> list_count;  ///< Lists: the type of their count.
  Role role = Role::none;
};

struct Element {
  std::string_view name;
  std::uint64_t count = 0;
  std::vector<Property> properties;
  std::set<std::string_view> names;  ///< Of the properties.
  std::set<Role> roles;              ///< Of the properties that have one.
};

struct Header {
  Encoding encoding = Encoding::ascii;
  std::vector<Element> elements;
  std::set<std::string_view> names;  ///< Of the elements.
  std::uint64_t columns = 0;         ///< From obj_info; 0: not given.
  std::uint64_t rows = 0;
  std::string_view body;
};

// ---- the header ----

Status read_format(const std::vector<std::string_view>& tokens, Header& header, const std::string& place) {
  if (tokens.size() != 3 || tokens[2] != "1.0") return format_error(place, "expected 'format ENCODING 1.0'");
  if (tokens[1] == "ascii") {
    header.encoding = Encoding::ascii;
  } else if (tokens[1] == "binary_little_endian") {
    header.encoding = Encoding::little_endian;
  } else if (tokens[1] == "binary_big_endian") {
    header.encoding = Encoding::big_endian;
  } else {
    return format_error(place, quoted_text(tokens[1]) + " is no encoding of PLY");
  }
  return {};
}

Status read_element(const std::vector<std::string_view>& tokens, Header& header, const std::string& place) {
  const auto count = tokens.size() == 3 ? parse_count(tokens[2]) : std::nullopt;
  if (!count) return format_error(place, "expected 'element NAME COUNT' with a count from 0 to 2147483647");
  if (!header.names.insert(tokens[1]).second) return format_error(place, "a second element " + quoted_text(tokens[1]));
  header.elements.push_back({.name = tokens[1], .count = *count, .properties = {}, .names = {}, .roles = {}});
  return {};
}

Role role_of(std::string_view element, std::string_view property) {
  struct Entry {
    std::string_view element;
    std::string_view property;
    Role role;
  };
  // PCL's writer says the extent of an organised cloud in its camera element.
  constexpr std::array<Entry, 8> kRoles = {{{"vertex", "x", Role::x},
                                            {"vertex", "y", Role::y},
                                            {"vertex", "z", Role::z},
                                            {"vertex", "X", Role::x},
                                            {"vertex", "Y", Role::y},
                                            {"vertex", "Z", Role::z},
                                            {"camera", "viewportx", Role::columns},
                                            {"camera", "viewporty", Role::rows}}};
  for (const auto& entry : kRoles) {
    if (entry.element == element && entry.property == property) return entry.role;
  }
  return Role::none;
}

Status read_property(const std::vector<std::string_view>& tokens, Header& header, const std::string& place) {
  if (header.elements.empty()) return format_error(place, "a property before the first element");
  Element& element = header.elements.back();
  Property property;
  const bool list = tokens.size() == 5 && tokens[1] == "list";
  if (!list && tokens.size() != 3) return format_error(place, "expected 'property TYPE NAME' or 'property list TYPE TYPE NAME'");
  const auto type = find_type(tokens[tokens.size() - 2]);
  if (!type) return format_error(place, quoted_text(tokens[tokens.size() - 2]) + " is no type of PLY");
  property.type = *type;
  property.name = tokens.back();
  if (list) {
    property.list_count = find_type(tokens[2]);
    if (!property.list_count || is_real(*property.list_count)) {
      return format_error(place, quoted_text(tokens[2]) + " cannot count a list's values");
    }
  }
  if (!element.names.insert(property.name).second) return format_error(place, "a second property " + quoted_text(property.name));
  const Role role = list ? Role::none : role_of(element.name, property.name);
  const bool taken = role != Role::none && !element.roles.insert(role).second;
  property.role = taken ? Role::none : role;  // "x" beside "X": the first
  element.properties.push_back(property);
  return {};
}

/// "obj_info num_cols 640": the extent of an organised cloud, as range scans and PCL know it.
void read_obj_info(const std::vector<std::string_view>& tokens, Header& header) {
  if (tokens.size() != 3) return;
  if (tokens[1] == "num_cols") header.columns = parse_count(tokens[2]).value_or(0);
  if (tokens[1] == "num_rows") header.rows = parse_count(tokens[2]).value_or(0);
}

Status read_header_line(const std::vector<std::string_view>& tokens, Header& header, const std::string& place) {
  if (tokens[0] == "format") return read_format(tokens, header, place);
  if (tokens[0] == "element") return read_element(tokens, header, place);
  if (tokens[0] == "property") return read_property(tokens, header, place);
  if (tokens[0] == "obj_info") {
    read_obj_info(tokens, header);
    return {};
  }
  return tokens[0] == "comment" ? Status() : format_error(place, "no PLY header line starts with " + quoted_text(tokens[0]));
}

Status check_vertex(const Header& header, const std::string& name) {
  for (const Element& element : header.elements) {
    if (element.name != "vertex") continue;
    for (const auto& [axis, role] : {std::pair{"x", Role::x}, std::pair{"y", Role::y}, std::pair{"z", Role::z}}) {
      const bool found = std::any_of(element.properties.begin(), element.properties.end(),
                                     [&, wanted = role](const Property& property) { return property.role == wanted; });
      if (!found) return format_error(name, "the vertices have no property " + quoted_text(axis) + " that is a number");
    }
    return {};
  }
  return format_error(name, "has no element 'vertex'");
}

Result<Header> read_header(std::string_view text, const std::string& name) {
  Header header;
  Lines lines(text);
  (void)lines.next();  // "ply": seen already.
  bool has_format = false;
  while (const auto line = lines.next()) {
    const auto tokens = words(*line);
    if (tokens.empty()) continue;
    const std::string place = name + ": line " + std::to_string(lines.number());
    if (tokens[0] == "end_header") {
      if (!has_format) return format_error(name, "the PLY header has no format line");
      header.body = lines.rest();
      if (const auto status = check_vertex(header, name); !status) return status.error();
      return header;
    }
    if (tokens[0] == "format" && std::exchange(has_format, true)) return format_error(place, "a second format line");
    if (const auto status = read_header_line(tokens, header, place); !status) return status.error();
  }
  return format_error(name, "the PLY header has no end_header line");
}

// ---- the body ----

class AsciiValues {
 public:
  explicit AsciiValues(std::string_view body) : rest_(body) {}
  std::optional<double> take(Type /*type*/) { return parse_real(take_word(rest_)); }
  bool skip(Type /*type*/, std::uint64_t count) {
    for (; count > 0; --count) {
      if (take_word(rest_).empty()) return false;
    }
    return true;
  }
  /// Fewest bytes that a value takes: a digit and what separates it from the next.
  static std::uint64_t fewest_bytes(Type /*type*/) { return 2; }
  [[nodiscard]] std::size_t bytes_left() const { return rest_.size() + 1; }  // The last value needs no blank behind it.
  bool at_end() { return take_word(rest_).empty(); }

 private:
  std::string_view rest_;
};

class BinaryValues {
 public:
  BinaryValues(std::string_view body, bool swapped) : rest_(body), swapped_(swapped) {}
  std::optional<double> take(Type type) {
    switch (type) {
      case Type::int8: return take_as<std::int8_t>();
      case Type::uint8: return take_as<std::uint8_t>();
      case Type::int16: return take_as<std::int16_t>();
      case Type::uint16: return take_as<std::uint16_t>();
      case Type::int32: return take_as<std::int32_t>();
      case Type::uint32: return take_as<std::uint32_t>();
      case Type::float32: return take_as<float>();
      case Type::float64: return take_as<double>();
    }
    return std::nullopt;
  }
  bool skip(Type type, std::uint64_t count) {
    if (count > rest_.size() / size_of(type)) return false;
    rest_.remove_prefix(count * size_of(type));
    return true;
  }
  static std::uint64_t fewest_bytes(Type type) { return size_of(type); }
  [[nodiscard]] std::size_t bytes_left() const { return rest_.size(); }
  /// Some writers end binary files as texts.
  [[nodiscard]] bool at_end() const { return rest_.empty() || rest_ == "\n" || rest_ == "\r\n"; }

 private:
  template <class T>
  std::optional<double> take_as() {
    if (rest_.size() < sizeof(T)) return std::nullopt;
    std::array<char, sizeof(T)> bytes;
    std::memcpy(bytes.data(), rest_.data(), sizeof(T));
    if (swapped_) std::reverse(bytes.begin(), bytes.end());
    rest_.remove_prefix(sizeof(T));
    return static_cast<double>(std::bit_cast<T>(bytes));
  }

  std::string_view rest_;
  bool swapped_;
};

/// What the walk through the body collects.
struct Collected {
  std::vector<Eigen::Vector3d> points;
  double columns = 0.0;
  double rows = 0.0;
};

void collect(Role role, double value, Collected& collected) {
  switch (role) {
    case Role::none: break;
    case Role::x: collected.points.back().x() = value; break;
    case Role::y: collected.points.back().y() = value; break;
    case Role::z: collected.points.back().z() = value; break;
    case Role::columns: collected.columns = value; break;
    case Role::rows: collected.rows = value; break;
  }
}

template <class Values>
bool skip_list(Values& values, const Property& property) {
  const auto count = values.take(*property.list_count);
  if (!count || *count < 0.0 || *count != std::floor(*count)) return false;
  // No list has more values than the file has bytes; so the cast is safe.
  return *count <= static_cast<double>(values.bytes_left()) && values.skip(property.type, static_cast<std::uint64_t>(*count));
}

template <class Values>
bool walk_property(Values& values, const Property& property, Collected& collected) {
  if (property.list_count) return skip_list(values, property);
  if (property.role == Role::none) return values.skip(property.type, 1);
  const auto value = values.take(property.type);
  if (value) collect(property.role, *value, collected);
  return value.has_value();
}

template <class Values>
Status walk_element(Values& values, const Element& element, const ReadLimits& limits, Collected& collected,
                    const std::string& name) {
  std::uint64_t fewest_bytes = 0;
  for (const Property& property : element.properties)
    fewest_bytes += Values::fewest_bytes(property.list_count.value_or(property.type));
  if (fewest_bytes == 0) return {};
  if (element.count > values.bytes_left() / fewest_bytes) {
    return format_error(name, "is too short for " + std::to_string(element.count) + " of element " + quoted_text(element.name));
  }
  const bool is_vertex = element.name == "vertex";
  if (is_vertex) {
    if (Status status = check_points(element.count, limits, name); !status) return status;
    collected.points.reserve(element.count);
  }
  for (std::uint64_t i = 0; i < element.count; ++i) {
    if (is_vertex) collected.points.emplace_back();
    for (const Property& property : element.properties) {
      if (walk_property(values, property, collected)) continue;
      return format_error(name, printable(element.name, kNameBytes) + " " + std::to_string(i) + ": property " +
                                    quoted_text(property.name) + " cannot be read");
    }
  }
  return {};
}

/// Columns and rows, where they are given and their product is the number of points; else one row.
Extent extent_of(const Header& header, const Collected& collected) {
  const std::size_t size = collected.points.size();
  if (header.rows > 0 && header.columns * header.rows == size) return {header.columns, header.rows};
  const bool viewport =
      collected.columns >= 1.0 && collected.rows >= 1.0 && collected.columns * collected.rows == static_cast<double>(size);
  return viewport ? Extent{static_cast<std::size_t>(collected.columns), static_cast<std::size_t>(collected.rows)}
                  : Extent{size, 1};
}

template <class Values>
Result<PointCloud> decode_body(Values values, const Header& header, const ReadLimits& limits, const std::string& name) {
  Collected collected;
  for (const Element& element : header.elements) {
    if (const auto status = walk_element(values, element, limits, collected, name); !status) return status.error();
  }
  if (!values.at_end()) return format_error(name, "has more data than its header says");
  const auto [width, height] = extent_of(header, collected);
  if (width == 0) return PointCloud();
  return assemble(width, height, [&](std::size_t i) { return collected.points[i]; });
}

// ---- writing ----

std::string header_to_write(const LabelledCloud& labelled, CloudEncoding encoding) {
  const PointCloud& cloud = labelled.cloud;
  constexpr std::string_view kBinary = std::endian::native == std::endian::little ? "binary_little_endian" : "binary_big_endian";
  std::string text = "ply\nformat " + std::string(encoding == CloudEncoding::ascii ? "ascii" : kBinary) + " 1.0\n";
  if (cloud.organised()) {
    text += "obj_info num_cols " + std::to_string(extent(cloud).width) + "\n";
    text += "obj_info num_rows " + std::to_string(extent(cloud).height) + "\n";
  }
  text += "element vertex " + std::to_string(cloud.size()) + "\n";
  for (const char* axis : {"x", "y", "z"}) {
    text += std::string("property ") + (needs_double(cloud) ? "double " : "float ") + axis + "\n";
  }
  // uint because PCL's point types hold the label in 32 bits.
  if (!labelled.labels.empty()) text += "property uchar red\nproperty uchar green\nproperty uchar blue\nproperty uint label\n";
  if (!labelled.obstacles.empty()) text += "property uint obstacle\n";
  return text + "end_header\n";
}

template <class T>
void append_bytes(std::string& text, T value) {
  const auto bytes = std::bit_cast<std::array<char, sizeof(T)>>(value);
  text.append(bytes.data(), bytes.size());
}

/// Appends values of one vertex as text or as bytes.
class VertexWriter {
 public:
  VertexWriter(std::string& text, bool ascii) : text_(text), ascii_(ascii) {}

  template <class T>
  void operator()(T value) {
    if (!ascii_) return append_bytes(text_, value);
    if (!std::exchange(first_, false)) text_ += ' ';
    if constexpr (std::is_floating_point_v<T>) {
      append_real(text_, value);
    } else {
      text_ += std::to_string(value);
    }
  }
  void end() {
    if (ascii_) text_ += '\n';
    first_ = true;
  }

 private:
  std::string& text_;
  bool ascii_;
  bool first_ = true;
};

}  // namespace

Result<PointCloud> decode_ply(std::span<const std::byte> bytes, const std::string& name, const ReadLimits& limits) {
  const auto header = read_header(as_text(bytes), name);
  if (!header) return header.error();
  if (header->encoding == Encoding::ascii) return decode_body(AsciiValues(header->body), *header, limits, name);
  const bool is_little = header->encoding == Encoding::little_endian;
  return decode_body(BinaryValues(header->body, is_little != (std::endian::native == std::endian::little)), *header, limits,
                     name);
}

std::string encode_ply(const LabelledCloud& labelled, CloudEncoding encoding) {
  const auto& [cloud, labels, obstacles] = labelled;
  std::string text = header_to_write(labelled, encoding);
  VertexWriter write(text, encoding == CloudEncoding::ascii);
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const Eigen::Vector3d point = point_to_write(cloud, i);
    for (const double value : {point.x(), point.y(), point.z()}) {
      needs_double(cloud) ? write(value) : write(static_cast<float>(value));
    }
    if (!labels.empty()) {
      for (const std::uint8_t channel : point_colour(labels[i])) write(channel);
      write(std::uint32_t{labels[i]});
    }
    if (!obstacles.empty()) write(std::uint32_t{obstacles[i]});
    write.end();
  }
  return text;
}

}  // namespace fransac::io::cloud_formats
