// SPDX-License-Identifier: Apache-2.0
// XYZ: points as lines of text, which no standard describes; what programs write differs in separators and in what stands above.
#include <algorithm>
#include <utility>
#include <vector>

#include "io/cloud_assemble.h"
#include "io/cloud_formats.h"
#include "io/cloud_text.h"

namespace fransac::io::cloud_formats {
namespace {

constexpr std::string_view kSeparators = " \t,;";

/// Takes the next word off the front; empty when there is none.
std::string_view take_column(std::string_view& line) {
  line.remove_prefix(std::min(line.find_first_not_of(kSeparators), line.size()));
  const std::string_view word = line.substr(0, line.find_first_of(kSeparators));
  line.remove_prefix(word.size());
  return word;
}

std::string_view without_comment(std::string_view line) { return line.substr(0, std::min(line.find('#'), line.find("//"))); }

}  // namespace

Result<PointCloud> decode_xyz(std::span<const std::byte> bytes, const std::string& name, const ReadLimits& limits) {
  std::vector<Eigen::Vector3d> points;
  Lines lines(as_text(bytes));
  bool first = true;
  while (const auto line = lines.next()) {
    std::string_view rest = without_comment(*line);
    std::string_view word = take_column(rest);
    if (word.empty()) continue;
    const bool may_be_header = std::exchange(first, false);
    Eigen::Vector3d point;
    int read = 0;
    for (; read < 3 && !word.empty(); ++read, word = take_column(rest)) {
      const auto value = parse_real(word);
      if (!value) break;
      point[read] = *value;
    }
    if (read == 3) {
      points.push_back(point);
    } else if (!may_be_header || (read == 1 && !word.empty()) || read == 2) {
      return format_error(name, "line " + std::to_string(lines.number()) + ": " +
                                    (word.empty() ? "fewer than three numbers" : quoted_text(word) + " is not a number"));
    }
  }
  if (Status status = check_points(points.size(), limits, name); !status) return status.error();
  if (points.empty()) return format_error(name, "holds no line \"x y z\"");
  return assemble(points.size(), 1, [&](std::size_t i) { return points[i]; });
}

}  // namespace fransac::io::cloud_formats
