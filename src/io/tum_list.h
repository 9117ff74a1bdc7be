// SPDX-License-Identifier: Apache-2.0
/// The lists of a TUM RGB-D sequence: depth.txt and rgb.txt, or associations.txt.
#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "fransac/core/result.hpp"

namespace fransac::io {

struct TumEntry {
  double time_s = 0.0;
  std::string timestamp;  ///< As it stands in the list: digits, '.' and exponent characters only.
  std::string file;       ///< Relative to the list's folder, and inside it.
};

/// Largest difference in time of a depth image and its picture, seconds: the default of the benchmark's association tool.
inline constexpr double kTumAssociation_s = 0.02;

/// Reads lines "timestamp filename"; '#' starts a comment. Sorted by time. Errors name `name` and the line.
/// May throw std::bad_alloc.
Result<std::vector<TumEntry>> parse_tum_list(std::string_view text, const std::string& name);

/// A depth image and its picture.
struct TumPair {
  TumEntry depth;
  TumEntry colour;
};

/// Reads lines "timestamp filename timestamp filename" as the benchmark's tool writes them: the picture's first, or the depth
/// image's where its name alone begins with "depth". Sorted by the depth's time; otherwise as parse_tum_list().
Result<std::vector<TumPair>> parse_tum_associations(std::string_view text, const std::string& name);

/// The entry nearest in time (the earlier of two) if it is within kTumAssociation_s, else null. `sorted` is by time.
const TumEntry* nearest_entry(std::span<const TumEntry> sorted, double time_s);

}  // namespace fransac::io
